"""Public signatures are typed, and mypy finds that they say the truth."""

import ast
import functools
import inspect
import sys
import typing
from pathlib import Path

import pytest

import sosbook as sos
from tests.processes import process

PACKAGE = Path(sos.__file__).parent
ROOT = Path(__file__).resolve().parent.parent


def functions(value):
    """(name, function) of a public function or of a class's public methods."""
    if not inspect.isclass(value):
        yield value.__name__, inspect.unwrap(value)
        return
    for owner in value.__mro__:
        if not owner.__module__.startswith("sosbook"):
            continue
        for name, member in vars(owner).items():
            if name.startswith("_") and name != "__init__":
                continue
            if isinstance(member, (classmethod, staticmethod)):
                member = member.__func__
            elif isinstance(member, property):
                member = member.fget
            elif isinstance(member, functools.cached_property):
                member = member.func
            if inspect.isfunction(member):
                yield f"{value.__name__}.{name}", inspect.unwrap(member)


def untyped(function):
    """Parameters without a type, and "return" if that has none."""
    there = inspect.signature(function)
    bare = [
        name
        for name, parameter in there.parameters.items()
        if parameter.annotation is parameter.empty and name not in ("self", "cls")
    ]
    return bare + ["return"] * (there.return_annotation is there.empty)


PUBLIC = {
    name: getattr(sos, name)
    for name in sos.__all__
    if not inspect.ismodule(getattr(sos, name))
}


def bare(names_of, *names_and_functions):
    """{name: what ``names_of`` finds}, where it finds something."""
    found = {name: names_of(function) for name, function in names_and_functions}
    return {name: names for name, names in found.items() if names}


def every_function():
    """(name, function) of everything public."""
    return [pair for value in PUBLIC.values() for pair in functions(value)]


@functools.cache
def of_checkers(module):
    """What a module imports for type checkers alone, by name."""
    found = {}
    for node in ast.parse(inspect.getsource(sys.modules[module])).body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            code = compile(ast.Module(node.body, []), module, "exec")
            exec(code, dict(vars(sys.modules[module])), found)
    return found


def unknown_types(function):
    """Types that name nothing, in words."""
    try:
        typing.get_type_hints(function, localns=of_checkers(function.__module__))
    except (NameError, AttributeError, TypeError) as error:
        return [str(error)]
    return []


def test_every_parameter_of_a_public_function_is_typed():
    assert len(every_function()) > 200
    assert bare(untyped, *every_function()) == {}


def test_types_name_things_that_exist():
    assert bare(unknown_types, *every_function()) == {}


def long_types(function):
    """Types that nobody reads in a signature."""
    words = [
        inspect.formatannotation(x.annotation)
        for x in inspect.signature(function).parameters.values()
    ]
    return [x for x in words if len(x) > 250 or "_NestedSequence" in x]


def test_signatures_can_be_read():
    assert bare(long_types, *every_function()) == {}


@pytest.mark.slow
def test_mypy_has_nothing_to_say():
    """Ten seconds without the cache that `python3 tasks.py types` fills, too."""
    done = process(
        sys.executable, "-m", "mypy", "--cache-dir", ROOT / "_build" / "mypy", cwd=ROOT
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_type_checkers_are_told_that_there_are_types():
    assert (PACKAGE / "py.typed").read_bytes() == b""
