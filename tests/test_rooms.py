"""The house keeps its floors: a room imports only from the rooms before it."""

import ast
import importlib
import inspect
import re
import sys
from functools import cache
from pathlib import Path

import pytest

import sosbook

PACKAGE = Path(sosbook.__file__).parent
README = (PACKAGE.parent / "README.md").read_text("utf8")
LISTED = README.partition("imports only from those before it:")[2].partition("\ntests/")
LISTED = LISTED[0].replace("(laid out like the printed ones)", "")
LISTED, _, SPARED = LISTED.partition(";")
ROOMS = tuple(room.strip() for room in LISTED.split(","))
CONTRIBUTING = (PACKAGE.parent / "CONTRIBUTING.md").read_text("utf8")
AWAY = CONTRIBUTING.partition("each of these and all:\n\n")[2].partition("\n\n")[0]
OPTIONAL = {  # the files and folders of each optional room
    paths[0].rpartition("/")[2]: paths
    for paths in (re.findall(r"`([\w/.]+)`", line) for line in AWAY.split("\n"))
}
TOOLS = ("bisection",)  # all rooms may use it; it imports none


def imports(file):
    """Modules of the package that a file imports, as paths below it."""
    return imported(file.relative_to(PACKAGE).parts[:-1], file.read_text("utf8"))


@cache
def imported(here, text):
    """Those that the ``text`` of a file in the folder ``here`` imports."""
    return [*found(here, ast.parse(text))]


def found(here, tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = here[: len(here) - node.level + 1]
            module = (*base, *(node.module or "").split(".")) if (node.module) else base
            for name in node.names:
                yield (*module, name.name)
        elif isinstance(node, ast.ImportFrom):
            parts = node.module.split(".")
            if parts[0] == "sosbook":
                for name in node.names:
                    yield (*parts[1:], name.name)
        elif isinstance(node, ast.Import):
            for name in node.names:
                parts = name.name.split(".")
                if parts[0] == "sosbook":
                    yield tuple(parts[1:])


def files():
    every = sorted(PACKAGE.rglob("*.py"))
    return [file for file in every if file.parent.name != "templates"]


def test_every_folder_is_a_room():
    folders = {p.name for p in PACKAGE.iterdir() if (p / "__init__.py").exists()}
    assert folders == set(ROOMS)
    loose = {p.name for p in PACKAGE.glob("*.py")}
    tools = {f"{name}.py" for name in TOOLS}
    assert loose == {"__init__.py", "__main__.py", *tools}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_from_rooms_before_it(room):
    allowed = {*ROOMS[: ROOMS.index(room) + 1], *TOOLS, "__version__"}
    for file in (PACKAGE / room).rglob("*.py"):
        for module in imports(file):
            where = f"{file.relative_to(PACKAGE)} imports {'.'.join(module)}"
            assert module and module[0] in allowed, where


def test_the_map_of_contributing_has_all_rooms_in_their_order():
    text = CONTRIBUTING.partition("## The rooms")[2]
    rows = re.findall(r"^\| (`.*`) \| ", text, re.M)
    assert tuple(re.findall(r"`(\w+)`", " ".join(rows))) == ROOMS


def test_no_room_imports_an_optional_one():
    """Only optional rooms do; README and CONTRIBUTING name the same ones."""
    homes = [tuple(Path(paths[0]).parts) for paths in OPTIONAL.values()]
    whole = {home[0] for home in homes if len(home) == 1}
    assert whole == set(re.findall(r"\w+", SPARED.partition("without")[2])) - {"or"}
    for file in files():
        place = file.relative_to(PACKAGE).parts
        if not any(place[: len(home)] == home for home in homes):
            for module in imports(file):
                arrow = f"{file.relative_to(PACKAGE)} imports {'.'.join(module)}"
                assert not any(module[: len(home)] == home for home in homes), arrow


def modules():
    """Each module of the package, as a path below it, with its file."""
    parts = {file.relative_to(PACKAGE).with_suffix("").parts: file for file in files()}
    return {p[:-1] if p[-1] == "__init__" else p: file for p, file in parts.items()}


def arrows(of=lambda module: module):
    """From modules, or ``of`` them, to their imports, in functions, too."""
    known = modules()
    graph = {of(module): set() for module in known}
    for module, file in known.items():
        for path in imports(file):
            target = path if path in known else path[:-1]
            graph[of(module)] |= {of(target)} - {of(module)}
    return graph


def circles(graph):
    """What remains when whatever imports nothing that remains is taken away."""
    rest = dict(graph)
    while leaves := [name for name in rest if not graph[name] & rest.keys()]:
        for name in leaves:
            del rest[name]
    return {name: graph[name] & rest.keys() for name in rest}


def test_no_module_imports_what_imports_it():
    assert circles(arrows()) == {}


def test_no_folder_of_a_room_imports_what_imports_it():
    """A folder is one thing, but for the names that its __init__ hands on."""
    folders = {m for m, file in modules().items() if file.name == "__init__.py"}

    def folder(module):
        return module[:2] if module[:2] in folders else module

    assert circles(arrows(folder)) == {}


@pytest.mark.parametrize("name", TOOLS)
def test_a_tool_imports_no_room(name):
    assert imports(PACKAGE / f"{name}.py") == []


def test_type_checkers_read_the_names_that_are_there():
    """__init__.pyi imports each name from where `__getattr__` finds it."""
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text("utf8"))
    stub = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom):
            for name in node.names:
                stub[name.asname or name.name] = (node.module, name.name)
    (names,) = (n.value for n in tree.body if isinstance(n, ast.Assign))
    assert sorted(ast.literal_eval(names)) == sosbook.__all__
    assert set(stub) == set(sosbook.__all__) <= set(dir(sosbook))
    for name, (module, original) in stub.items():
        value = getattr(sosbook, name)
        home = importlib.import_module("sosbook" + (f".{module}" if module else ""))
        assert getattr(home, original) is value
        if not inspect.ismodule(value):
            assert sosbook._HOMES[name] == module


def test_the_contract_sees_an_arrow_that_points_up(tmp_path, monkeypatch):
    monkeypatch.setattr(sys.modules[__name__], "PACKAGE", tmp_path)
    file = tmp_path / "lmi" / "x.py"
    file.parent.mkdir()
    for text in (
        "from ..book import thesis",
        "from .. import book",
        "import sosbook.book.thesis",
        "from sosbook.book import thesis",
        "def f():\n    from ..book.thesis import arm",
    ):
        file.write_text(text, "utf8")
        assert [m[0] for m in imports(file)] == ["book"], text


def test_an_unknown_name_is_an_error():
    with pytest.raises(AttributeError, match="no attribute 'walls'"):
        sosbook.walls
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("sosbook.pendulum.nothing")


def test_no_name_that_is_found_later_is_a_module_beside_it():
    """Python binds a module in its package when it is imported: the name would change
    from what it stands for into that module.
    """
    for file in PACKAGE.rglob("__init__.py"):
        package = ".".join(("sosbook", *file.parent.relative_to(PACKAGE).parts))
        homes = getattr(importlib.import_module(package), "_HOMES", {})
        beside = {p.stem for p in file.parent.iterdir() if p.suffix in ("", ".py")}
        assert not beside & homes.keys(), package
