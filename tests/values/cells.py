"""The cells of nbval, with outputs compared by values."""

from pathlib import Path
from types import MethodType

from . import differences, folded

FOLDER = Path(__file__).resolve().parents[2] / "_build" / "outputs"


def adopt(item):
    """Have a cell that nbval collected compare by values; leave other tests."""
    if hasattr(item, "cell_num") and hasattr(item, "compare_outputs"):
        item.compare_outputs = MethodType(compare, item)


def compare(item, test, ref, skip_compare=None):
    """Replaces nbval's method: whether the new outputs agree with the stored."""
    faults = differences(ref, test)
    item.comparison_traceback = faults
    if faults:
        stem = f"{Path(item.parent.path).stem}-{item.cell_num}"
        names = [
            written(FOLDER / f"{stem}-{when}.html", outputs)
            for when, outputs in (("stored", ref), ("now", test))
        ]
        item.comparison_traceback = [
            *faults,
            "",
            "The stored output and the new one:",
            *map(str, names),
        ]
    return not faults


def written(path, outputs):
    """Write outputs as a page for a browser, and return its path."""
    parts = []
    for kind, contents in folded(outputs).items():
        for content in contents:
            plain = kind != "text/html"
            text = str(content).replace("&", "&amp;").replace("<", "&lt;")
            parts.append(
                f"<h3>{kind}</h3>" + (f"<pre>{text}</pre>" if plain else content)
            )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        '<!doctype html><meta charset="utf-8">' + "\n".join(parts), encoding="utf-8"
    )
    return path
