"""A class is measured whole, with bases that were cut off to keep a module short."""

import ast
from collections import Counter
from functools import cache
from pathlib import Path

import sosbook

ROOT = Path(sosbook.__file__).parent
MOST = 400  # lines


ARGUMENTS = 12  # at most, of a function or a constructor
#: Records that nobody calls with all of it: they are read from print or a file, or made
#: by one function. A number may only fall.
RECORDS = {
    "Example": 14,  # of the thesis, number by number
    "MipPrint": 23,  # the same
    "Robot": 39,  # a robot's file, key by key
    "Solution": 16,  # and its Design: made by the design functions, field by field
    "TickLog": 16,  # the columns of a log
}


@cache
def parsed():
    """Each module of the package."""
    return [ast.parse(x.read_text("utf8")) for x in sorted(ROOT.rglob("*.py"))]


def statements(node):
    """Those of a module, a class or a function, and those within them."""
    for name in ("body", "orelse", "finalbody", "handlers"):
        for one in getattr(node, name, ()):
            yield one
            yield from statements(one)


def arguments(node):
    """(name, count) of each public function of a module, and of dataclasses."""
    for one in node.body:
        kinds = ast.FunctionDef, ast.ClassDef
        if not isinstance(one, kinds) or one.name.startswith("_"):
            continue
        if isinstance(one, ast.ClassDef):
            fields = [x for x in one.body if isinstance(x, ast.AnnAssign)]
            fields = [x for x in fields if "ClassVar" not in ast.unparse(x.annotation)]
            made = any("dataclass" in ast.unparse(x) for x in one.decorator_list)
            yield one.name, len(fields) if made else 0
        else:
            names = one.args
            yield one.name, len(names.posonlyargs + names.args + names.kwonlyargs)


def test_no_public_function_has_more_arguments_than_a_reader_keeps_in_mind():
    found = {}
    for tree in parsed():
        for name, count in arguments(tree):
            found[name] = max(found.get(name, 0), count)
    many = {name: count for name, count in found.items() if count > ARGUMENTS}
    assert many == RECORDS


def classes():
    """(lines, names of bases) of each class of the package, by name, the longest."""
    found = {}
    for tree in parsed():
        for node in statements(tree):
            if isinstance(node, ast.ClassDef):
                bases = [ast.unparse(base).split(".")[-1] for base in node.bases]
                one = node.end_lineno - node.lineno + 1, bases
                found[node.name] = max(found.get(node.name, one), one)
    return found


def measured(found):
    """Lines of each class with those bases that it alone has and no room hands out."""
    heirs = Counter(base for _, bases in found.values() for base in set(bases))
    shown = "".join(x.read_text("utf8") for x in ROOT.rglob("__init__.py"))

    def lines(name):
        own, bases = found[name]
        cut = [
            b for b in bases if b in found and heirs[b] == 1 and f'"{b}"' not in shown
        ]
        return own + sum(map(lines, cut))

    return {name: lines(name) for name in found}


def test_no_class_is_longer_than_a_module_may_be():
    assert {name: n for name, n in measured(classes()).items() if n > MOST} == {}


def test_no_module_has_400_lines():
    counts = {p: len(p.read_text("utf8").splitlines()) for p in ROOT.rglob("*.py")}
    assert {p.name: n for p, n in counts.items() if n >= MOST} == {}


def test_a_class_that_is_cut_into_a_base_stays_as_long():
    found = {"Whole": (300, ["Part"]), "Part": (200, []), "Other": (10, ["Shared"])}
    found |= {"Shared": (500, []), "Another": (20, ["Shared"])}
    assert measured(found)["Whole"] == 500 and measured(found)["Other"] == 10


def test_no_door_hands_on_all_that_its_scope_holds():
    """So that an editor finds who uses a keyword."""
    hidden = [p for p in ROOT.rglob("*.py") if "**locals()" in p.read_text("utf8")]
    assert hidden == []
