"""A requirement has a home: no other module knows it by name."""

import ast
import re
from functools import cache
from pathlib import Path

import sosbook
from tests.each import each

PACKAGE = Path(sosbook.__file__).parent
HOMES = ("requirements", "book")  # the book speaks of the thesis's own examples
NAMES = {"gamma", "saturation", "cost", "u_max", "hinf", "lqr"}
NAMES |= {"half-plane", "sector", "disk", "sigma"}
ATTRIBUTES = {"gamma", "saturation", "cost", "region"}
# keywords of the design functions, which become requirements at once
SHORTHAND = {
    "synthesis/closed_loop.py": {"gamma", "saturation", "cost"},
    "synthesis/design.py": {"gamma", "region"},
    "synthesis/pid.py": {"gamma", "saturation", "cost", "sigma"},
    "exact/checker/requirements.py": NAMES,  # stands alone: it asks no object
    "exact/checker/designs.py": NAMES,
    "exact/checker/regions.py": NAMES,
    "exact/checker/fields.py": NAMES,
    "exact/checker/known.py": {"gamma", "cost", "h2"},
    "exact/checker/any_order.py": NAMES,
    "exact/checker/observer.py": {"cost"},
    "exact/checker/small_input.py": {"u_max"},
    "exact/checker/fixed_mode.py": NAMES,
    "exact/checker/ticks.py": {"gamma"},
    "exact/checker/unreached.py": {"gamma"},
    "pendulum/facts.py": {"cost"},  # writes the weights into a C comment
    "theorems/text.py": {"gamma"},  # the size of a theorem's argument
    "controllers/limits.py": {"u_max"},  # an argument, in what is said of it
    "controllers/margins.py": {"disk"},  # a margin's name
    "controllers/motions.py": {"u_max"},
    "controllers/output_bounds.py": {"u_max"},
    "proofs/folder.py": {"u_max"},  # the limit of a controller
}


KINDS = {"hinf", "input_bound", "cost"}  # modules of single requirements
MAKERS = {  # make one of the keywords of their functions
    "synthesis/closed_loop.py",
    "synthesis/pid.py",
    "synthesis/lqr.py",
    "sampled/lqr.py",
    "delay/searched.py",
}


def known(file):
    """Requirements that a module knows by name, with their lines."""
    text = file.read_text("utf8")
    if not any(name in text for name in (*ATTRIBUTES, *NAMES)):
        return
    tree = ast.parse(text)
    prose = {
        id(node.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in ATTRIBUTES:
            yield node.attr, node.lineno
        elif (
            isinstance(node, ast.Constant)
            and id(node) not in prose
            and isinstance(node.value, str)
            and node.value in NAMES
        ):
            yield node.value, node.lineno


OTHERS = [
    f
    for f in sorted(PACKAGE.rglob("*.py"))
    if f.relative_to(PACKAGE).parts[0] not in HOMES
]


@each("file", OTHERS)
def test_no_other_module_knows_a_requirement(file):
    allowed = SHORTHAND.get(file.relative_to(PACKAGE).as_posix(), set())
    assert [(name, line) for name, line in known(file) if name not in allowed] == []


def imported(file):
    """Modules of single requirements that a module imports."""
    text = file.read_text("utf8")
    for node in ast.walk(ast.parse(text)) if "requirements" in text else ():
        if isinstance(node, ast.ImportFrom) and node.module:
            room, _, module = node.module.rpartition(".")
            if room.endswith("requirements") and module in KINDS:
                yield module


def test_no_other_module_imports_a_requirement():
    files = {f.relative_to(PACKAGE).as_posix(): f for f in PACKAGE.rglob("*.py")}
    importers = {
        name
        for name, f in files.items()
        if name.split("/")[0] not in HOMES and any(imported(f))
    }
    assert importers <= MAKERS


@cache
def classes():
    """Names of the requirements' classes."""
    known = {"Requirement", "Region", "RegionForms"}
    while True:
        heirs = {
            node.name
            for f in PACKAGE.joinpath("requirements").glob("*.py")
            for node in ast.walk(ast.parse(f.read_text("utf8")))
            if isinstance(node, ast.ClassDef)
            and known & {getattr(b, "id", "") for b in node.bases}
        }
        if heirs <= known:
            return known
        known |= heirs


def asked_for_its_type(text):
    """Lines that ask whether something is of a requirement's class."""

    def named(*nodes):
        inner = (x for node in nodes for x in ast.walk(node))
        names = {getattr(x, "id", getattr(x, "attr", "")) for x in inner}
        return names & classes()

    def call_of(node, *functions):
        return isinstance(node, ast.Call) and getattr(node.func, "id", "") in functions

    mentioned = classes() & {*re.findall(r"\w+", text)}
    for node in ast.walk(ast.parse(text)) if mentioned else ():
        if call_of(node, "isinstance", "issubclass"):
            asked = named(*node.args[1:])
        elif isinstance(node, ast.Compare):
            sides = (node.left, *node.comparators)
            typed = any(
                call_of(x, "type")
                or getattr(x, "attr", "") in ("__class__", "__name__")
                for side in sides
                for x in ast.walk(side)
            )
            asked = typed and named(*sides)
        else:
            asked = isinstance(node, ast.MatchClass) and named(node.cls)
        if asked:
            yield node.lineno if hasattr(node, "lineno") else node.cls.lineno


@each("file", OTHERS)
def test_no_other_module_asks_for_a_requirement_s_type(file):
    assert list(asked_for_its_type(file.read_text("utf8"))) == []
