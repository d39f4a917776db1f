"""The comparison of a program's files with what sosbook wrote.

A proof is about numbers, and a program is more than its numbers. The files that carry
the law out are written again and compared, letter by letter. For all the rest a record
of the program says what was written; nobody signs it, so it notices changes, and no
forger.
"""

from ..exact.proof_file import laid_out
from ..runtime.digests import digest
from ..runtime.reading import named, read_bytes, read_json
from .code import definitions
from .template import noted, read, renamed, version_in, written_by

FORMAT = "sosbook program"
GAINS = "_gains.h"
#: The files that carry a law out, by the end of their name: package and template.
CONTROLLER = {x: ("sosbook.controllers", f"axis{x}") for x in (".h", ".c", "_tick.h")}
ROBOT = {x: ("sosbook.pendulum", f"balance{x}") for x in (".h", ".c")} | {
    "_run.h": ("sosbook.pendulum", "balance_run.h"),
    "_run.c": ("sosbook.pendulum", "balance_run.c"),
    "_tick.h": CONTROLLER["_tick.h"],
}
STEERING = {x: ("sosbook.pendulum", f"balance{x}") for x in ("_steer.h", "_steer.c")}


def law_texts(templates, name, note=None):
    """The texts of the files that carry a law out, by the ends of their names.

    ``templates``: such as `CONTROLLER`; ``name``: of the program; ``note``: the line
    that says who wrote it, this version without it.
    """
    return {
        end: noted(
            renamed(read(package, file), file.removesuffix(end), name),
            [note or written_by()],
        )
        for end, (package, file) in templates.items()
    }


def record(texts, name):
    """The text of program_<name>.json: what the ``texts`` of a program's files were.

    It has the digest of each file, and of each file of numbers its definitions.
    """
    tops = [x for x in texts if x.endswith(GAINS) and "/" not in x]
    said = {
        "format": FORMAT,
        "name": name,
        "files": {file: digest(text.encode()) for file, text in texts.items()},
        "numbers": {file: definitions(texts[file]) for file in tops},
    }
    return laid_out(said) + "\n"


def changes(folder, name):
    """(changes of a program since it was written, words for what was compared).

    ``folder``: where its files lie; ``name``: of the program. Returns (list of str,
    list of str): each change, and each comparison, in words.
    """
    text = _text(folder / f"{name}{GAINS}")
    with named(folder / f"{name}{GAINS}"):
        numbers = definitions(text)
    files = CONTROLLER
    if "BLEND" in numbers:
        files = ROBOT | (STEERING if numbers.get("STEERS") == "1" else {})
    version = version_in(text)
    faults = []
    for end, wanted in law_texts(files, name, version and written_by(version)).items():
        path = folder / f"{name}{end}"
        if not path.is_file():
            faults.append(f"{path.name} isn't there")
        elif line := _first_difference(_text(path), wanted):
            faults.append(f"{path.name} isn't what sosbook writes: see line {line}")
    if faults and version and written_by(version) != written_by():
        faults.append(f"sosbook {version} wrote it: compare it with that version")
    said = [f"{', '.join(f'{name}{x}' for x in files)}: as sosbook writes them"]
    records = {p: _record(p, name) for p in sorted(folder.glob("program_*.json"))}
    records = {path: found for path, found in records.items() if found}
    for path, found in records.items():
        faults += _changed(folder, found, name, numbers)
        said.append(f"all other files and numbers: as they were written ({path.name})")
    if not records:
        said.append(
            "limits, ramps, faults, set points and words: NOT compared, since there is "
            f"no program_{name}.json beside it"
        )
    return list(dict.fromkeys(faults)), said


def _changed(folder, record, name, numbers):
    """The differences from a ``record``: numbers by their labels, and files."""
    own = f"{name}{GAINS}"
    written = record["numbers"][own]
    for label in sorted({*numbers, *written}):
        now, then = (x.get(label, "nothing") for x in (numbers, written))
        if now != then:
            yield f"{label} is {now[:60]}, and was written as {then[:60]} ({own})"
    for file, wanted in record["files"].items():
        path = folder / file
        if not path.is_file():
            yield f"{file} isn't there"
        elif digest(_text(path).encode()) != wanted and (
            file != own or numbers == written
        ):
            yield f"{file} was changed since it was written"


def _record(path, name):
    """The record in a file, if it is that of a program with this ``name``, or None."""
    try:
        found = read_json(path)
    except ValueError:
        if path.name == f"program_{name}.json":
            raise
        return None
    own = f"{name}{GAINS}"
    files, numbers = (
        found.get(key) if isinstance(found, dict) else None
        for key in ("files", "numbers")
    )
    if isinstance(files, dict) and isinstance(numbers, dict) and own in files:
        texts = numbers.get(own)
        if isinstance(texts, dict) and all(
            isinstance(x, str) for x in (*files.values(), *texts.values())
        ):
            return found
    if path.name == f"program_{name}.json":
        raise ValueError(f"{path} is no record of a program: write the program again")
    return None


def _text(path):
    """The text of a file; the two ways to end a line count as one."""
    return read_bytes(path).decode("utf-8", "replace").replace("\r\n", "\n")


def _first_difference(mine, wanted):
    """The number of the first line that differs, or 0."""
    if mine == wanted:
        return 0
    pairs = zip(mine.split("\n"), wanted.split("\n"))
    lines = [k for k, (a, b) in enumerate(pairs, 1) if a != b]
    return lines[0] if lines else min(mine.count("\n"), wanted.count("\n")) + 1
