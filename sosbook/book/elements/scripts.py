"""The scripts of the page elements, for pages that are opened as files, too.

They are ES modules, which a browser loads from a server alone. So a page has each of
them as a classic script: its imports are read from ``sosModules``, where its exports
go. The kernel is one module there, and the text of one function, `sosKernel`, for a
worker runs it as well.
"""

import re
from functools import cache
from importlib.resources import files

ASSETS, KERNEL = files(__package__) / "assets", files("sosbook.book.kernel")
IMPORT = re.compile(
    r'^import (\{[^}]*\}|\* as \w+) from "(.*?)(\w+)\.js";\n', re.MULTILINE
)
#: Words that the package reads, too, become a part of the script.
DATA = re.compile(
    r'^import (\w+) from "((?:\.\./)+)([\w/]+\.json)" with \{type ?: "json"\};\n',
    re.MULTILINE,
)
EXPORT = re.compile(r"^export (?=(?:class|const|function\*?|let) (\w+))", re.MULTILINE)


@cache
def modules(*names):
    """The modules of these ``names`` and all that they import, in an order to load.

    Examples
    --------
    >>> modules("program", "plot")
    ('sentence', 'program', 'kit', 'plot')
    """
    order = {}
    for name in names:
        order |= dict.fromkeys(_needed(name))
        order[name] = None
    return tuple(order)


@cache
def script(name):
    """The module of this ``name`` as a classic script.

    Examples
    --------
    >>> print(script("line"))  # doctest: +ELLIPSIS
    (globalThis.sosModules ??= {}).line ??= (() => {
    "use strict";
    ...
    return {line};
    })();
    <BLANKLINE>
    """
    if name != "kernel":
        return _registered(name, f"(() => {{\n{_body(_asset(f'{name}.js'))}}})()")
    parts = sorted(p.name for p in KERNEL.iterdir() if p.name.endswith(".js"))
    text = "\n".join(IMPORT.sub("", (KERNEL / p).read_text("utf8")) for p in parts)
    function = f"globalThis.sosKernel ??= function sosKernel() {{\n{_body(text)}}};\n"
    return function + _registered(name, "sosKernel()")


@cache
def sheet(name):
    """The style sheet of this ``name``."""
    return _asset(f"{name}.css")


def _registered(name, value):
    return f"(globalThis.sosModules ??= {{}}).{name} ??= {value};\n"


def _body(text):
    """The body of a function that returns what the module exports."""
    names = ", ".join(EXPORT.findall(text))
    text = DATA.sub(_said, IMPORT.sub(_read, EXPORT.sub("", text)))
    return f'"use strict";\n{text}return {{{names}}};\n'


def _read(match):
    names, _, _ = match.groups()
    names = names.removeprefix("* as ").replace(" as ", ": ")
    return f"const {names} = sosModules.{_module(match)};\n"


def _said(match):
    name, _, path = match.groups()
    return f"const {name} = {files('sosbook').joinpath(path).read_text('utf8')};\n"


def _needed(name):
    if name == "kernel":
        return ()
    return modules(*(map(_module, IMPORT.finditer(_asset(f"{name}.js")))))


def _module(match):
    return "kernel" if "kernel" in match[2] else match[3]


def _asset(name):
    return (ASSETS / name).read_text("utf8")
