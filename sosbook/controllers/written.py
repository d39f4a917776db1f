"""The comparison of a program's files with what sosbook wrote.

A proof is about numbers, and a program is more than its numbers. The files that carry
the law out are written again and compared, letter by letter. For all the rest a record
of the program says what was written; nobody signs it, so it notices changes, and no
forger.
"""

import re

from ..exact.proof_file import laid_out
from ..runtime.digests import digest
from ..runtime.later import later
from ..runtime.reading import named, read_bytes, read_json
from .code import definitions
from .template import fitted, noted, read, renamed, version_in, written_by

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
#: Files around a controller's program, which hold no number: their templates.
AROUND = {
    "{0}_bench.c": "axis_bench.c",
    "CMakeLists.txt": "CMakeLists.txt",
    "{0}_sketch/{0}_sketch.ino": "axis.ino",
    "{0}_sketch/platformio.ini": "platformio.ini",
}
#: All that is defined in <name>_gains.h, in this order; {} stands for signals.
NUMBERS = (
    "SINGLE STATES MEASURED SET_POINTS OUTPUTS TICK_US DELAY_TICKS DELAY_REST_US {} "
    "TICK SLACK MOST_LOST MOST_LATE MOST_FULL MOST_SILENT PREDICTS SLEWS RAMPS "
    "FOLLOWED LIMIT SLEW RAMP RANGE JUMP REACH TRUSTED A B BR W C D DR GUESS START ROWS"
)
OF_ROBOT = (
    "SINGLE STATES MEASURED SET_POINTS OUTPUTS TICK_US COMPENSATES STEERS TICK "
    "HALF_TICK HERTZ LIMIT TIP BLEND RANGE PUSH REACH TRUSTED RUB SOFT STEEP MOST_LOST "
    "FROZEN DEAF MOST_FULL A B C D W BR DR START {} DELAY SLACK MOST_LATE REST_TICKS "
    "SPEED ACCELERATION TURN_RATE TURN_ACCELERATION"
)
OF_HEADING = "SHARE STEER_REACH UNWIND PER_RADIAN K"


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


def around_texts(name, note=None):
    """The texts of the files `AROUND` a program of this ``name``; ``note`` as there."""
    return {
        file.format(name): noted(
            renamed(read("sosbook.controllers", template), "axis", name),
            [note or written_by()],
        )
        for file, template in AROUND.items()
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
    files, robot = CONTROLLER, "BLEND" in numbers
    if robot:
        files = ROBOT | (STEERING if numbers.get("STEERS") == "1" else {})
    version = version_in(text)
    note = version and written_by(version)
    faults = [*_defined(text, numbers, name, robot)]
    for end, wanted in law_texts(files, name, note).items():
        faults += _differs(folder / f"{name}{end}", wanted)
    around = around_texts(name, note).items()
    around = [(folder / file, wanted) for file, wanted in around if name in file]
    if robot:
        around = later("pendulum.around", "around")(folder, name, numbers)
    others = [(path, wanted) for path, wanted in around if path.is_file()]
    for path, wanted in others:
        faults += _differs(path, wanted)
    for path in sorted((folder / f"{name}_sketch").glob("*.[ch]")):
        beside = folder / path.name
        if beside.is_file():
            faults += _differs(path, _text(beside))
    if faults and version and written_by(version) != written_by():
        faults.append(f"sosbook {version} wrote it: compare it with that version")
    law = [f"{name}{x}" for x in files] + [path.name for path, _ in others]
    said = [f"{', '.join(law)}: as sosbook writes them"]
    records = {p: _record(p, name) for p in sorted(folder.glob("program_*.json"))}
    records = {path: found for path, found in records.items() if found}
    for path, found in records.items():
        faults += _changed(folder, found, name, numbers)
        said.append(
            "all other files, numbers and words, such as limits, ramps, faults, set "
            f"points and bounds: as they were written ({path.name}), and not computed "
            "again; no proof is of them"
        )
    if not records:
        said.append(
            "limits, ramps, faults, set points, bounds and words: NOT compared, since "
            f"there is no program_{name}.json beside it"
        )
    held = {folder / f"{name}{end}" for end in (*files, GAINS)}
    held |= {path for path, _ in others}
    held |= {folder / file for found in records.values() for file in found["files"]}
    if left := [*_left(folder, name, held)]:
        said.append(f"{', '.join(left)}: NOT compared, since nothing says what it was")
    return list(dict.fromkeys(faults)), said


def _left(folder, name, held):
    """The names of a program's C files that are not ``held`` to anything."""
    for path in sorted({*folder.glob(f"{name}*.[ch]")} - held):
        yield path.name
    for path in sorted({*(folder / f"{name}_sketch").glob("*.[ch]")} - held):
        if not (folder / path.name).is_file():
            yield path.name


def _defined(text, numbers, name, robot):
    """The differences of a <name>_gains.h's definitions from those of sosbook."""
    if not re.search(rf"^#ifndef {name.upper()}_GAINS_H$", text, re.M):
        yield f"{name}{GAINS} is that of a program with another name"
    if robot:
        inner = OF_HEADING * (numbers.get("STEERS") == "1")
        wanted = OF_ROBOT.format(inner).split()
    else:
        signals = [x for x in numbers if re.match("(IN|SET|OUT)_", x)]
        inner = [x for x in signals if x != "SET_POINTS"]
        wanted = NUMBERS.format(" ".join(inner)).split()
    if [*numbers] != wanted:
        pairs = zip([*numbers, "nothing"], [*wanted, "nothing"])
        mine, other = next((a, b) for a, b in pairs if a != b)
        yield f"{name}{GAINS} defines {mine}, where sosbook writes {other}"


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


def _differs(path, wanted):
    """The difference of a file from a ``wanted`` text, none or one, in words."""
    if not path.is_file():
        yield f"{path.name} isn't there"
        return
    mine = _text(path)
    wanted = fitted(wanted, mine)
    if mine != wanted:
        pairs = zip(mine.split("\n"), wanted.split("\n"))
        lines = [k for k, (a, b) in enumerate(pairs, 1) if a != b]
        last = min(mine.count("\n"), wanted.count("\n")) + 1
        line = lines[0] if lines else last
        yield f"{path.name} isn't what sosbook writes: see line {line}"
