"""Public names of the package: which page of the book documents each, and how.

A page of ``book/api`` documents some modules, its own by the fence ``{room}``.
Names of the root, such as ``sosbook.design_pid``, belong to the page of the
room that they live in. An object is documented once, under its shortest name;
every other public name of it is known as an alias.
"""

import inspect
import re
from functools import cache
from importlib import import_module
from pathlib import Path

BOOK = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^:::\{room\} (.+)\n:::$", re.MULTILINE)
ROOT = "sosbook"


LITERAL = re.compile(r"(``.+?``|(?<!`)`[^`]+`)")


def escaped(text):
    """A line of a docstring in which |x| is a norm: bars mean something else."""
    parts = LITERAL.split(text)
    return "".join(
        part if k % 2 else part.replace("|", r"\|") for k, part in enumerate(parts)
    )


class Entry:
    """A public object: its name in the book and the page that documents it."""

    def __init__(self, name, thing, page, module):
        self.name, self.thing, self.page, self.module = name, thing, page, module
        self.aliases = set()

    @property
    def kind(self):
        """What Sphinx calls it."""
        if inspect.isclass(self.thing):
            is_error = issubclass(self.thing, Exception)
            return "exception" if is_error else "class"
        return "function" if callable(self.thing) else "data"

    @property
    def summary(self):
        """The first sentence of the docstring; the type of a constant."""
        if self.kind == "data":
            return f"A constant of the type ``{type(self.thing).__name__}``."
        text = inspect.getdoc(self.thing) or ""
        return escaped(" ".join(text.split("\n\n")[0].split()))


def pages():
    """The modules that each page of the manual documents, in the book's order."""
    contents = (BOOK.parent / "_toc.yml").read_text("utf-8")
    names = re.findall(r"file: book/(api/\w+)$", contents, re.MULTILINE)
    return {
        f"book/{name}": " ".join(
            FENCE.findall((BOOK / f"{name}.md").read_text("utf-8"))
        ).split()
        for name in names
    }


def _key(thing, name):
    """Equal for two names of one object; constants have only their name."""
    if inspect.isclass(thing) or inspect.isfunction(thing):
        return f"{thing.__module__}.{thing.__qualname__}"
    return name


@cache
def entries():
    """The entries of all pages by their names."""
    root = import_module(ROOT)
    found = {}

    def add(name, thing, page, module):
        entry = found.setdefault(_key(thing, name), Entry(name, thing, page, module))
        entry.aliases.add(name)

    for page, modules in pages().items():
        for home, names in root._NAMES.items():
            if any((f"{ROOT}.{home}.").startswith(f"{m}.") for m in modules):
                for name in names:
                    add(f"{ROOT}.{name}", getattr(root, name), page, modules[0])
    for page, modules in pages().items():
        for module in modules:
            there = import_module(module)
            for name in getattr(there, "__all__", ()):
                thing = getattr(there, name)
                if not inspect.ismodule(thing):
                    add(f"{module}.{name}", thing, page, module)
    for key, entry in found.items():
        entry.aliases.add(key)
    return {entry.name: entry for entry in found.values()}


@cache
def names():
    """Every known name of every entry."""
    return {a: entry for entry in entries().values() for a in entry.aliases}


def lookup(name):
    """The entry of a dotted name and what is left of it (a method), or None."""
    parts = name.split(".")
    for k in range(len(parts), 1, -1):
        if entry := names().get(".".join(parts[:k])):
            return entry, ".".join(parts[k:])
    return None


def resolve(name, owner=None):
    """The documented name that a word of a docstring means, or None.

    ``owner`` is the class or module whose docstring has the word.
    """
    name = name.removeprefix("~").removesuffix("()")
    for start in _starts(owner):
        if found := lookup(start + name):
            entry, rest = found
            if not rest or hasattr(entry.thing, rest.split(".")[0]):
                return entry.name + (f".{rest}" if rest else "")
    ends = {e.name: e for n, e in names().items() if n.endswith(f".{name}")}
    return next(iter(ends)) if len(ends) == 1 else None


def _starts(owner):
    yield ""
    while owner:
        yield owner + "."
        owner = owner.rpartition(".")[0]


def exists(name, owner=None):
    """Whether a word of a docstring names anything of the package at all."""
    name = name.removeprefix("~").removesuffix("()")
    tail = name.split(".")
    for start in _starts(owner):
        if _found(start + name):
            return True
    return any(_attributes(module, tail) for module in _all_modules() if tail[0])


def _found(name):
    """Whether a dotted name can be imported."""
    parts = name.split(".")
    if parts[0] != ROOT:
        return False
    thing = import_module(ROOT)
    return _attributes(thing, parts[1:])


def _attributes(thing, path):
    for part in path:
        fields = getattr(thing, "__dataclass_fields__", {})
        if part in fields:
            return True
        try:
            thing = inspect.getattr_static(thing, part)
        except AttributeError:
            try:
                thing = getattr(thing, part)
            except AttributeError:
                return False
    return True


@cache
def _all_modules():
    folder = BOOK.parent / ROOT
    stems = (
        ".".join(p.relative_to(folder.parent).with_suffix("").parts)
        for p in sorted(folder.rglob("*.py"))
        if p.stem != "__main__" and p.parent.name != "templates"  # programs of a robot
    )
    return [import_module(s.removesuffix(".__init__")) for s in stems]
