"""A requirement has a home: no other module knows it by name."""

import ast
from pathlib import Path

import pytest

import sosbook

PACKAGE = Path(sosbook.__file__).parent
HOMES = ("requirements", "book")  # the book speaks of the thesis's own examples
NAMES = {
    "gamma",
    "saturation",
    "cost",
    "u_max",
    "hinf",
    "lqr",
    "half-plane",
    "sector",
    "disk",
    "sigma",
}
ATTRIBUTES = {"gamma", "saturation", "cost", "region"}
# keywords of the design functions, which become requirements at once
SHORTHAND = {
    "synthesis/closed_loop.py": {"gamma", "saturation", "cost"},
    "synthesis/design.py": {"gamma"},
    "synthesis/pid.py": {"gamma", "saturation", "cost"},
    "proofs/check.py": NAMES,  # stands alone: it can ask no object of the package
    "pendulum/facts.py": {"cost"},  # writes the weights into a C comment
    "pendulum/robot.py": {"lqr"},  # the name of a law in a description
    "pendulum/optimal.py": {"lqr"},
}


KINDS = {"hinf", "input_bound", "cost"}  # modules of single requirements
MAKERS = {  # make one of the keywords of their functions
    "synthesis/closed_loop.py",
    "synthesis/pid.py",
    "synthesis/lqr.py",
    "sampled/lqr.py",
    "studies/gamma_bounds.py",
}


def known(file):
    """Requirements that a module knows by name, with their lines."""
    tree = ast.parse(file.read_text("utf8"))
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


@pytest.mark.parametrize(
    "file",
    [
        f
        for f in sorted(PACKAGE.rglob("*.py"))
        if f.relative_to(PACKAGE).parts[0] not in HOMES
    ],
    ids=lambda f: str(f.relative_to(PACKAGE)),
)
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
