"""Prove the poles of the book's proofs by Rocq: ``python3 tasks.py formal``.

    python3 tasks.py formal                   the proofs of every notebook
    python3 tasks.py formal 05 22             those of chapters 5 and 22
    python3 tasks.py formal proof.json ..     these

The notebooks are run, and each proof that one makes is kept in _build/formal.
"""

import shutil
import sys
from collections import Counter
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from formal import gen, rocq

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "_build" / "formal"
START = """import sys
sys.path.insert(0, {!r})
from formal import collect
collect.start({!r})"""


def main(words):
    if not rocq.ensure():
        print(rocq.MISSING, file=sys.stderr)
        return 0
    shutil.rmtree(BUILD, ignore_errors=True)
    rocq.theory(BUILD / "theory")
    files = [Path(word) for word in words if word.endswith(".json")]
    chapters = [word for word in words if not word.endswith(".json")]
    for path in sorted((ROOT / "book").glob("*.ipynb")):
        if not words or any(map(path.name.startswith, chapters)):
            files += proofs_of(path)
    folders = {}
    for path in files:
        folders.setdefault(path.parent, []).append(path)
    counts = sum((verdicts(*item) for item in folders.items()), Counter())
    print("\n" + "\n".join(f"{n:4}  {words}" for words, n in sorted(counts.items())))
    return int(not files or any(words.startswith("FAILED") for words in counts))


def proofs_of(path):
    """Run a notebook; the files of the proofs that it makes."""
    folder, notebook = BUILD / path.stem, nbformat.read(path, 4)
    first = nbformat.v4.new_code_cell(START.format(str(ROOT), str(folder)))
    notebook.cells.insert(0, first)
    where = {"metadata": {"path": str(path.parent)}}
    NotebookClient(
        notebook, timeout=1800, kernel_name="python3", resources=where
    ).execute()
    return sorted(folder.glob("*.json"))


def verdicts(folder, paths):
    """How often Rocq says what of the proofs in a folder; failures are printed."""
    counts, texts = Counter(), {}
    for path in paths:
        try:
            texts[path] = gen.written(gen.read(path.read_text("utf-8")))
        except gen.Refused as refusal:
            counts[f"not covered: {refusal}"] += 1
        except gen.Failed as failure:
            counts["FAILED"] += 1
            print(f"{path}: FAILED: {failure}", flush=True)
    groups = [list(texts)] if texts else []
    while groups:
        group = groups.pop()
        try:
            chosen = [texts[path] for path in group]
            theorems = rocq.prove(BUILD / "theory", "proofs", chosen)
        except rocq.Failed as failure:
            if len(group) > 1:  # which one is it?
                groups += [[path] for path in group]
                continue
            counts["FAILED"] += 1
            print(f"{group[0]}: FAILED: {failure}", flush=True)
        else:
            counts["proven"] += len(group)
            print(
                f"{folder.name}: {len(group)} proven, {theorems} theorems", flush=True
            )
    return counts


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
