"""Public signatures are typed, and mypy finds that they say the truth."""

import functools
import inspect
import re
import subprocess
import sys
import typing
from pathlib import Path

import pytest

import sosbook as sos
from sosbook.requirements import Requirement

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


@pytest.mark.parametrize("value", PUBLIC.values(), ids=PUBLIC)
def test_every_parameter_of_a_public_function_is_typed(value):
    found = {name: untyped(function) for name, function in functions(value)}
    assert {name: bare for name, bare in found.items() if bare} == {}


@pytest.mark.parametrize("value", PUBLIC.values(), ids=PUBLIC)
def test_types_name_things_that_exist(value):
    for _, function in functions(value):
        typing.get_type_hints(function)


def test_a_parameter_without_a_type_is_seen():
    def bare(x, y: int, *, z=0): ...

    class Thing:
        def method(self, x) -> None: ...

        @property
        def size(self): ...

    Thing.__module__ = "sosbook.x"
    assert untyped(bare) == ["x", "z", "return"]
    assert {n: untyped(f) for n, f in functions(Thing)} == {
        "Thing.method": ["x"],
        "Thing.size": ["return"],
    }


@pytest.mark.slow
def test_mypy_has_nothing_to_say():
    """Ten seconds without the cache that `python3 tasks.py types` fills, too."""
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", ROOT / "_build" / "mypy"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_type_checkers_are_told_that_there_are_types():
    assert (PACKAGE / "py.typed").read_bytes() == b""


def undocumented(function):
    """Parameters that a docstring neither names nor leaves to another one."""
    text = inspect.getdoc(function) or ""
    if re.search(r"\b(as in|as for|[Ss]ee|Simulate) `", text):
        return []
    names = set(inspect.signature(function).parameters) - {"self", "cls"}
    return sorted(n for n in names if not re.search(rf"\b{n}\b", text))


@pytest.mark.parametrize("value", PUBLIC.values(), ids=PUBLIC)
def test_every_parameter_is_explained(value):
    # what authors of requirements write is explained in `Requirement`
    hooks = {*vars(Requirement), "noise_unit", "__init__", "per_vertex"}
    found = {
        name: undocumented(function)
        for name, function in functions(value)
        if name.split(".")[-1] not in hooks
    }
    assert {name: bare for name, bare in found.items() if bare} == {}


CLASSES = {
    name: value
    for name, value in PUBLIC.items()
    if inspect.isclass(value) and not issubclass(value, Warning) and name != "Result"
}


@pytest.mark.parametrize("value", CLASSES.values(), ids=CLASSES)
def test_what_makes_an_object_is_explained(value):
    names = set(inspect.signature(value).parameters) - {"args", "kwargs"}
    text = inspect.getdoc(value)
    bare = sorted(n for n in names if not re.search(rf"\b{n}\b", text))
    assert [n for n in bare if not n.startswith("_")] == []


def test_a_parameter_that_is_not_explained_is_seen():
    def f(x, horizon):
        """Simulate until x falls."""

    def g(x):
        """Parameters as in `f`."""

    assert undocumented(f) == ["horizon"]
    assert undocumented(g) == []
