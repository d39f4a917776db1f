"""What works on one system only, and can be seen without another one."""

import ast
import re
from pathlib import Path

from tests.each import each

ROOT = Path(__file__).resolve().parent.parent
SOURCES = [ROOT / "tasks.py", ROOT / "conftest.py"]
for folder in ("sosbook", "tests", "benchmarks"):
    SOURCES += sorted((ROOT / folder).rglob("*.py"))
ENCODED = {"open": 3, "read_text": 0, "write_text": 1, "NamedTemporaryFile": 99}
COMMANDS = ("run", "Popen", "check_output")
MENTIONED = re.compile(rf"\b({'|'.join((*ENCODED, *COMMANDS))})\b")


def without_encoding(source):
    """Lines that read or write text in whatever encoding the system prefers."""
    lines = []
    for node in ast.walk(ast.parse(source)) if MENTIONED.search(source) else ():
        if not isinstance(node, ast.Call):
            continue
        function = node.func
        method = isinstance(function, ast.Attribute)
        name = function.attr if method else getattr(function, "id", None)
        given = {keyword.arg: keyword.value for keyword in node.keywords}
        value = getattr(function, "value", None)
        owner = getattr(value, "id", getattr(value, "attr", None))
        if name in ENCODED and owner not in ("os", "problem", "self", "webbrowser"):
            place = ENCODED[name] - (name == "open" and method)
            mode = given.get("mode") or (
                node.args[1 - method]
                if name == "open" and len(node.args) > 1 - method
                else None
            )
            binary = isinstance(mode, ast.Constant) and "b" in mode.value
            if not binary and "encoding" not in given and len(node.args) <= place:
                lines.append(node.lineno)
        elif name in COMMANDS and "encoding" not in given:
            if getattr(given.get("text"), "value", False):
                lines.append(node.lineno)
    return lines


@each("path", SOURCES)
def test_text_is_read_and_written_as_utf_8(path):
    assert without_encoding(path.read_text("utf-8")) == []


def test_no_two_files_differ_by_case_alone_and_no_name_is_reserved():
    """Windows and macOS would take such files for one."""
    reserved = {"con", "prn", "aux", "nul", *(f"com{k}" for k in range(1, 10))}
    for folder in ("sosbook", "tests", "benchmarks", "book"):
        names = [str(path.relative_to(ROOT)) for path in (ROOT / folder).rglob("*")]
        assert len({name.casefold() for name in names}) == len(names)
        for name in names:
            assert not set(name) & set('<>:"|?*\\')
            assert Path(name).stem.casefold() not in reserved


def test_a_missing_encoding_is_seen():
    source = "open('a')\npath.open('w')\npath.read_text()\nrun(words, text=True)\n"
    good = "open('a', 'rb')\np.open('w', encoding='utf-8')\np.read_text('utf-8')\n"
    assert without_encoding(source + good) == [1, 2, 3, 4]
