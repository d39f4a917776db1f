"""Prove the poles of the book's proofs by Rocq: ``python3 tasks.py formal``.

    python3 tasks.py formal                   the proofs of every notebook
    python3 tasks.py formal 05 27             those of chapters 5 and 27
    python3 tasks.py formal proof.json ..     these

The notebooks are run, and each proof that one makes is kept in _build/formal.
"""

import os
import shutil
import sys
from collections import Counter
from pathlib import Path

import nbformat
from nbclient import NotebookClient

from formal import gen, rocq

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "_build" / "formal"
START = "from formal import collect\ncollect.start({!r})"


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
    counts = Counter(map(verdict, files))
    print("\n" + "\n".join(f"{n:4}  {words}" for words, n in sorted(counts.items())))
    return int(not files or any(words.startswith("FAILED") for words in counts))


def proofs_of(path):
    """Run a notebook; the files of the proofs that it makes."""
    folder, notebook = BUILD / path.stem, nbformat.read(path, 4)
    first = nbformat.v4.new_code_cell(START.format(str(folder)))
    notebook.cells.insert(0, first)
    os.environ["PYTHONPATH"] = str(ROOT)
    where = {"metadata": {"path": str(path.parent)}}
    NotebookClient(
        notebook, timeout=1800, kernel_name="python3", resources=where
    ).execute()
    return sorted(folder.glob("*.json"))


def verdict(path):
    """What Rocq says of a proof, without its name; all of it is printed."""
    name = "proof_" + path.stem.replace("-", "_")
    try:
        text = gen.written(gen.read(path.read_text("utf-8")))
        count = rocq.prove(BUILD / "theory", name, text)
    except gen.Refused as refusal:
        words = detail = f"not covered: {refusal}"
    except (gen.Failed, rocq.Failed) as failure:
        words, detail = "FAILED", f"FAILED: {failure}"
    else:
        words, detail = "proven", f"proven: {count} theorems"
    print(f"{path.parent.name}/{path.name}: {detail}", flush=True)
    return words


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
