"""Public names and their arguments change knowingly: a list of them is kept.

``python -m tests.test_stable`` writes it again; the difference belongs into CHANGELOG.
"""

import importlib
import inspect
from pathlib import Path

import sosbook

LIST = Path(__file__).parent / "public_names.txt"


def arguments(thing):
    """The arguments of a function or a class, without their types."""
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return ""
    bare = [p.replace(annotation=p.empty) for p in signature.parameters.values()]
    return str(inspect.Signature(bare))


def public():
    """A line for each public name, of the package and of each room."""
    lines = []
    for room in ("sosbook", *(f"sosbook.{room}" for room in sosbook._ROOMS)):
        module = importlib.import_module(room)
        for name in sorted(getattr(module, "__all__", ())):
            thing = getattr(module, name)
            if not inspect.ismodule(thing):
                told = arguments(thing) if callable(thing) else ""
                lines.append(f"{room}.{name}{told}")
    return lines


def test_public_names_and_their_arguments_are_those_of_the_list():
    assert public() == LIST.read_text("utf-8").splitlines(), (
        "public names or arguments changed: `python -m tests.test_stable` writes the "
        "list again; CHANGELOG.md says what changed"
    )


if __name__ == "__main__":
    LIST.write_text("\n".join(public()) + "\n", "utf-8")
