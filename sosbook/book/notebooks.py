"""Run the book's notebooks and store them in one canonical form.

The executed notebooks are the source of the book: the site shows their stored
outputs and the tests derive every one of them again. Run twice, a notebook is
the same file to the byte.

Commands::

    python -m sosbook.book.notebooks run [FILE ...]     run and store
    python -m sosbook.book.notebooks check [FILE ...]   name every fault

Without files both take every notebook in ``book/``.
"""

import argparse
import hashlib
import os
import re
import sys
from pathlib import Path

from ..runtime.libraries import library
from ..runtime.progress import WITHOUT_BARS
from ..runtime.threads import ONE_THREAD
from ..runtime.writing import write_file

nbformat = library("nbformat")
NotebookClient = library("nbclient").NotebookClient
CellExecutionError = library("nbclient.exceptions").CellExecutionError


BOOK = Path(__file__).resolve().parents[2] / "book"
LINE_LENGTH = 72
CELL_LENGTH = 25
CELL_TIMEOUT = 600  # seconds for one cell

WIDGET = "application/vnd.jupyter.widget-view+json"  # names a model of one kernel
TEXTS = frozenset({"text/plain", "text/html", "text/markdown", "text/latex"})

METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {
        "file_extension": ".py",
        "mimetype": "text/x-python",
        "name": "python",
        "pygments_lexer": "ipython3",
    },
}
KEPT_METADATA = ("mystnb", "tags")  # of a cell

_TAG = re.compile(r"<(svg|img)\b[^>]*>", re.IGNORECASE)
_NAMED = {
    "svg": re.compile(r"\baria-(label=\"[^\"]+\"|hidden=\"true\")", re.IGNORECASE),
    "img": re.compile(r"\balt=\"[^\"]+\"", re.IGNORECASE),
}
_PROOF = re.compile(r":::\{prf:proof\}(.*?)\n:::", re.DOTALL)
_MARKDOWN_IMAGE = re.compile(r"!\[\s*\]\(")
_BARE_LINK = re.compile(r"(?<!!)\[\s*\]\(([^)]*)\)")
_SHARED = re.compile(r'\n<(style|script) class="sos-shared">.*?</\1>', re.DOTALL)
_MACHINE = re.compile(
    r"0x[0-9a-f]{7,}|(?<![\w./])(/(home|root|tmp|usr|opt|var|mnt|Users|private)/\w"
    rf"|{re.escape(str(BOOK.parent))}\b)"
    r"|site-packages|\b[A-Z]:\\\w|<ipython-input|ipykernel_\d"
)
_DIGITS = re.compile(r"\d\.\d{11,}")  # more than other processors agree on


def canonical(notebook):
    """Bring a ``notebook`` to the canonical form, in place, and return it: only
    sources, outputs and tags stay. A cell's id is a hash of its source.
    """
    notebook.metadata = nbformat.from_dict(METADATA)
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    ids = set()
    for cell in notebook.cells:
        cell.source = "\n".join(line.rstrip() for line in cell.source.split("\n"))
        cell.source = cell.source.strip("\n")
        cell.metadata = nbformat.from_dict(
            {key: cell.metadata[key] for key in KEPT_METADATA if cell.metadata.get(key)}
        )
        cell.id = _hash(cell.source)
        while cell.id in ids:
            cell.id = _hash(cell.id + cell.source)
        ids.add(cell.id)
        if cell.cell_type == "code":
            cell.outputs = _canonical_outputs(cell)
        else:
            cell.pop("outputs", None)  # the format has none here
    return notebook


def execute(notebook, folder=BOOK):
    """Run all cells in a fresh kernel; return the notebook in canonical form.

    Raises nbclient.exceptions.CellExecutionError when a cell fails. Nothing is stored
    then.
    """
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    canonical(notebook)
    NotebookClient(
        notebook,
        timeout=CELL_TIMEOUT,
        kernel_name="python3",
        record_timing=False,
        store_widget_state=False,
        coalesce_streams=True,
        extra_arguments=["--IPKernelApp.log_level=ERROR"],
        resources={"metadata": {"path": str(folder)}},
    ).execute()
    return canonical(notebook)


def problems(notebook):
    """A list, in words, of all that keeps a ``notebook`` out of the book."""
    sentences = []
    count = 0
    for index, cell in enumerate(notebook.cells):
        faults = list(_text_faults(cell.source))
        if cell.cell_type == "code":
            count += 1
            if cell.execution_count != count:
                faults.append(
                    f"has execution count {cell.execution_count} "
                    f"instead of {count}: run the notebook"
                )
            faults += _code_faults(cell)
            faults += [
                fault for output in cell.outputs for fault in _output_faults(output)
            ]
        else:
            faults += _page_faults(cell.source)
        sentences += [f"cell {index} {fault}" for fault in faults]
    return sentences


def read(path):
    """Read the notebook of any format at a path as format 4."""
    return nbformat.read(path, as_version=4)


def text(notebook):
    """The file's content, with sorted keys and a newline at the end."""
    return nbformat.writes(notebook).rstrip("\n") + "\n"


def without_shared(html):
    """The ``html`` without the style and scripts that all page elements share.

    The built pages load them as files, so they aren't stored.

    Examples
    --------
    >>> without_shared('<p>1</p>\\n<style class="sos-shared">p {}</style>\\n<p>2</p>')
    '<p>1</p>\\n<p>2</p>'
    """
    return _SHARED.sub("", html).rstrip("\n") if _SHARED.search(html) else html


def _canonical_outputs(cell):
    """The outputs of a cell without what depends on a run."""
    kept = []
    for output in cell.outputs:
        output.pop("transient", None)
        output.get("data", {}).pop(WIDGET, None)
        if "metadata" in output:
            output.metadata = nbformat.from_dict({})
        if html := output.get("data", {}).get("text/html"):
            output.data["text/html"] = without_shared(html)
        if output.output_type == "execute_result":
            output.execution_count = cell.execution_count
        last = kept[-1] if kept else None
        if output.output_type == "stream" and last and last.get("name") == output.name:
            last.text += output.text
        else:
            kept.append(output)
    return kept


def _page_faults(source):
    if _MARKDOWN_IMAGE.search(source):
        yield "shows an image without a text for those who cannot see it"
    for target in _BARE_LINK.findall(source):
        yield f"has a link without words, which only the book fills: {target}"
    for proof in _PROOF.findall(source):
        if not proof.rstrip().endswith(r"$\square$"):
            yield "has a proof that doesn't end with a square"


def _code_faults(cell):
    """Faults of a code cell, in words."""
    lines = cell.source.split("\n")
    if not cell.source.strip():
        yield "is empty"
    if len(lines) > CELL_LENGTH:
        yield f"has {len(lines)} lines; {CELL_LENGTH} is the limit"
    for line in lines:
        if len(line) > LINE_LENGTH:
            yield f"has a line of {len(line)} characters: {line.strip()}"
        if line.lstrip().startswith(("# NBVAL", "#NBVAL", "# PYTEST_VALIDATE")):
            yield f"steers nbval by a comment: {line.strip()}"
    if lines[-1].rstrip().endswith(";"):
        yield "hides its value with a semicolon"
    for tag in cell.metadata.get("tags", []):
        if tag.startswith(("nbval", "raises", "remove-cell")):
            yield f"carries the tag {tag}"


def _output_faults(output):
    """Faults of an output, in words."""
    if output.output_type == "error":
        yield f"failed: {output.ename}: {output.evalue}"
    elif output.output_type == "stream":
        if output.name != "stdout":
            yield f"wrote to {output.name}: {output.text.strip()[:200]}"
        yield from _text_faults(output.text)
        yield from _digit_faults(output.text)
    else:
        for kind, content in output.data.items():
            if kind == "text/plain":
                yield from _digit_faults(content)
            if kind in TEXTS:
                yield from _text_faults(content)
            else:
                yield f"stores {kind}: show figures with sosbook.book.plots.show"


def _digit_faults(content):
    if match := _DIGITS.search(content):
        yield f"prints digits that may differ elsewhere: {match[0]}"


def _text_faults(content):
    if match := _MACHINE.search(content):
        around = content[max(0, match.start() - 20) : match.end() + 40]
        yield f"names a place on one machine: {around!r}"
    for match in _TAG.finditer(content):
        if not _NAMED[match[1].lower()].search(match[0]):
            yield f"has a picture without a text: {match[0][:80]}"


def _hash(source):
    return hashlib.sha256(source.encode()).hexdigest()[:8]


def _run(path):
    before = path.read_text(encoding="utf-8")
    try:
        notebook = execute(read(path), folder=path.parent)
    except CellExecutionError as error:
        return [f"failed\n{error}"]
    after = text(notebook)
    if after != before:
        write_file(path, after)
    print(f"{path.name}: {'unchanged' if after == before else 'stored'}", flush=True)
    return problems(notebook)


def _check(path):
    notebook = read(path)
    sentences = problems(notebook)
    if text(canonical(notebook)) != path.read_text(encoding="utf-8"):
        sentences.append(
            "is not in canonical form: python -m sosbook.book.notebooks run"
        )
    return sentences


def main(argv=None):
    """Run ``python -m sosbook.book.notebooks`` with words argv; the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m sosbook.book.notebooks", description=__doc__.split("\n")[0]
    )
    parser.add_argument("task", choices=["run", "check"])
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    arguments = parser.parse_args(argv)
    os.environ.update(ONE_THREAD | WITHOUT_BARS)  # for the notebooks' processes
    task = _run if arguments.task == "run" else _check
    files = arguments.files or sorted(BOOK.glob("*.ipynb"))
    for path in files:
        if not path.is_file():
            parser.error(f"there is no notebook {path}")
    listed = [(path, fault) for path in files for fault in task(path)]
    for path, fault in listed:
        print(f"{path.name}: {fault}", file=sys.stderr)
    return 1 if listed else 0


if __name__ == "__main__":
    sys.exit(main())
