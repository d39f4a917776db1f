"""Every public object says what it is, takes, returns and raises."""

import ast
import importlib
import inspect
import pkgutil
import re
from functools import cache
from pathlib import Path

import pytest
from numpydoc.docscrape import FunctionDoc
from numpydoc.validate import validate

import sosbook

#: What numpydoc must not find. Summaries, examples and references are a
#: matter of taste; what can be wrong isn't.
FAULTS = {
    "GL06": "unknown section",
    "GL07": "sections out of order",
    "SS03": "the summary has no full stop",
    "PR02": "documents an argument that doesn't exist",
    "PR03": "arguments out of order",
    "PR05": "an argument's type ends in a full stop",
    "PR07": "an argument without a description",
    "PR09": "a description without a full stop",
    "PR10": "no space before the colon",
    "RT03": "a return value without a description",
}
FREE = {"self", "cls"}
CHECKER = "sosbook.exact.checker."  # a program that stands alone


def modules():
    for found in pkgutil.walk_packages(sosbook.__path__, "sosbook."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


@cache
def imported():
    """Names that some module of the package takes from another one."""
    files = Path(sosbook.__path__[0]).rglob("*.py")
    taken = r"^ *from [\w.]+ import (?:\(([^)]*)\)|(.*))"
    froms = (re.findall(taken, file.read_text("utf-8"), re.M) for file in files)
    words = (x.split() for found in froms for y in found for x in "".join(y).split(","))
    return {x[0] for x in words if x and x[0].isidentifier() and x[0][0] != "_"}


@cache
def public():
    """All public classes, functions, methods; without __all__ what others import."""
    names = {}
    for module in modules():
        if module.__name__.startswith(CHECKER):
            continue
        names_here = sorted(imported() & vars(module).keys())
        for name in getattr(module, "__all__", names_here):
            thing = getattr(module, name)
            if not (inspect.isclass(thing) or inspect.isfunction(thing)):
                continue
            alone = module.__name__ if not hasattr(module, "__all__") else "sosbook"
            if not thing.__module__.startswith(alone):
                continue
            full = f"{thing.__module__}.{thing.__qualname__}"
            names[full] = thing
            if inspect.isclass(thing):
                names |= {
                    f"{full}.{key}": value
                    for key, value in vars(thing).items()
                    if not key.startswith("_") and function_of(value) is not None
                }
    return names


def function_of(thing):
    """The function behind a method, a property or a function, or None."""
    if isinstance(thing, classmethod | staticmethod):
        return thing.__func__
    if isinstance(thing, property):
        return thing.fget
    thing = getattr(thing, "func", thing)  # of a cached property
    return thing if inspect.isfunction(thing) else None


def arguments(thing):
    if inspect.isclass(thing):
        try:
            thing = inspect.signature(thing)
        except ValueError:  # a class of C
            return set()
    else:
        thing = inspect.signature(function_of(thing))
    return {name for name in thing.parameters if name not in FREE and name[0] != "_"}


def undocumented(thing, doc):
    """Arguments that no section describes and no sentence names."""
    described = {
        name.strip(" *")
        for p in FunctionDoc(None, doc=doc)["Parameters"]
        for name in p.name.split(",")
    }
    return {
        name
        for name in arguments(thing) - described
        if described or not re.search(rf"(?<!\w){re.escape(name)}(?!\w)", doc)
    }


def faults(name):
    """What is wrong with the docstring of a public object, in words."""
    thing = public()[name]
    doc = inspect.getdoc(thing) or ""
    owner, _, attribute = name.rpartition(".")
    if not doc and owner in public():  # what its base class says holds for it
        doc = inspect.getdoc(getattr(public()[owner], attribute)) or ""
        return [] if doc else ["no docstring, nor has the base class one"]
    if not doc:
        return ["no docstring"]
    found = [f"{code}: {x}" for code, x in validate(name)["errors"] if code in FAULTS]
    if isinstance(thing, property):
        return found
    names = [p.name for p in FunctionDoc(None, doc=doc)["Parameters"]]
    twice = sorted({x for x in names if names.count(x) > 1})
    found += [f"{x} is documented twice" for x in twice]
    return [f"{x} isn't documented" for x in sorted(undocumented(thing, doc))] + found


@pytest.mark.slow
def test_every_public_object_is_documented(monkeypatch):
    """No comment excuses one, nor does any fault below ask a source: to look at these
    takes longer than all the rest.
    """
    place = "numpydoc.validate.extract_ignore_validation_comments"
    monkeypatch.setattr(place, lambda *_, **__: {})
    for asked in ("source_file_def_line", "method_returns_something"):
        monkeypatch.setattr(f"numpydoc.validate.Validator.{asked}", None)
    assert len(public()) > 500
    found = {name: faults(name) for name in sorted(public())}
    assert {name: words for name, words in found.items() if words} == {}


def test_no_letter_is_both_a_size_and_another_argument():
    twice = []
    for name, thing in public().items():
        doc = FunctionDoc(None, doc=inspect.getdoc(thing) or "")["Parameters"]
        types = {
            argument: p.type
            for p in doc
            for argument in p.name.replace("*", "").split(", ")
        }
        for argument, kind in types.items():
            shape = re.match(r"\(([^)]*)\)", kind)
            for letter in re.findall(r"\b[A-Za-z]\b", shape[1] if shape else ""):
                if "int" not in types.get(letter, "int"):
                    twice.append((name, argument, kind))
    assert not twice


@cache
def described():
    """(place, lines, docstring) of each module, class and function of the package, by
    its text; a module has 0 lines.
    """
    here = Path(sosbook.__path__[0])
    return [
        (
            f"{file.relative_to(here)} {getattr(node, 'name', '')}",
            getattr(node, "end_lineno", 0) - getattr(node, "lineno", 1) + 1,
            ast.get_docstring(node) or "",
        )
        for file in sorted(here.rglob("*.py"))
        for node in statements(ast.parse(file.read_text("utf-8")))
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
    ]


def statements(node):
    """A node and all within it that isn't a part of an expression."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield from statements(child)


def test_no_docstring_begins_as_a_question():
    assert not [p for p, _, x in described() if re.match("(What|Whether)\\b", x)]


def test_a_function_of_15_lines_has_a_docstring():
    assert not [place for place, lines, x in described() if lines >= 15 and not x]


def test_no_docstring_of_a_test_has_an_example():
    """Nobody would run it: pytest looks for examples in the package alone."""
    for path in Path(__file__).parent.rglob("*.py"):
        assert not re.search(r"^ *>>> ", path.read_text("utf-8"), re.MULTILINE), path
