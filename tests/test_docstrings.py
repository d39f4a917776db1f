"""Every public object says what it is, takes, returns and raises."""

import importlib
import inspect
import pkgutil
import re

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


def modules():
    for found in pkgutil.walk_packages(sosbook.__path__, "sosbook."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


def public():
    """Names of all public classes, functions, methods and properties."""
    names = {}
    for module in modules():
        for name in getattr(module, "__all__", ()):
            thing = getattr(module, name)
            if not (inspect.isclass(thing) or inspect.isfunction(thing)):
                continue
            if not thing.__module__.startswith("sosbook"):
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


PUBLIC = public()


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


def test_there_are_hundreds():
    assert len(PUBLIC) > 500


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_a_public_object_is_documented(name):
    thing = PUBLIC[name]
    doc = inspect.getdoc(thing) or ""
    owner, _, attribute = name.rpartition(".")
    if not doc and owner in PUBLIC:  # what its base class says holds for it
        doc = inspect.getdoc(getattr(PUBLIC[owner], attribute)) or ""
        assert doc, "no docstring, nor has the base class one"
        return
    assert doc, "no docstring"
    if not isinstance(thing, property):
        assert undocumented(thing, doc) == set(), "undocumented arguments"
    errors = validate(name)["errors"]
    assert [(code, text) for code, text in errors if code in FAULTS] == []
