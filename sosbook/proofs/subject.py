"""The subject of a proof file, compared with the wanted plant, gain or program.

A digest can be mended, and a proof of an easier plant is a proof. So a verdict names
what it is about, and it is held against the reader's own files.
"""

import re

from ..exact.checker.verdict import subject
from ..exact.proof_file import load
from ..exact.rational import decimals, exact, fractions
from ..plants.as_data import plant_data
from ..plants.checks import matrix
from ..plants.files import plant_and_asked
from ..plants.kinds import checked_plant
from ..requirements.in_files import asked_in_file
from ..runtime.digests import digest
from ..runtime.later import later
from ..runtime.names import claimed
from ..runtime.reading import named, path_of, read_bytes, read_json, read_text
from ..synthesis.fixed_mode import parts_data

__all__ = ["compare_code", "compare_gain", "compare_plant", "proofs_beside", "subject"]

CODE = "controllers.code"  # its room may be missing where no program is compared
FILES = re.compile(r"\(file[\s*]+sha256[\s*]+([0-9a-f]{64})\)")


def compare_plant(data, path):
    """The difference between the plant of a proof's ``data`` and that of a file at
    ``path``, and U, K_A and law of a file of ``python -m sosbook design``; or "".
    """
    plant, file = plant_and_asked(path)
    plant = checked_plant(plant)
    law = None
    if file is not None and "law" in file:
        with named(path):
            plant, law = asked_in_file({"law": file["law"]})["law"].on(plant)
    wanted = {"plant": plant_data(plant)}
    if file is not None:
        with named(path):
            for name, none in (("U", []), ("K_A", None)):
                given = file.get(name)
                wanted[name] = none if given is None else decimals(matrix(name, given))
            wanted["law"] = law and parts_data(law.parts(plant))
            if law:  # which of its numbers are free
                free = law.structure(plant).directions
                wanted["gains"] = [fractions(exact(K)) for K in free]
    for name, value in wanted.items():
        if name == "plant" or name in data:
            if data.get(name) != value:
                return f"it is about another {name} than {path}{_where(data, wanted)}"
    law, z = data.get("K"), getattr(plant, "coordinates", None)
    reads = law.get("inputs") if isinstance(law, dict) else None
    if reads and z and reads[: len(z)] != claimed(z):
        return f"its K reads {', '.join(reads)}: {path} names z otherwise"
    return ""


def _where(data, wanted):
    """The first matrix that differs, if the plants have one shape."""
    mine, yours = (x.get("plant") or {} for x in (data, wanted))
    pairs = zip(mine.get("vertices", ()), yours.get("vertices", ()))
    for k, (a, b) in enumerate(pairs, 1):
        for name in a:
            if a[name] != b.get(name):
                return f": {name} of vertex {k} differs"
    return ""


def compare_gain(data, path):
    """The difference between the gain of a proof's ``data`` and that of a JSON file at
    ``path``, a matrix or an object with "K"; or "".
    """
    given = read_json(path)
    if isinstance(given, dict):
        given = given.get("K")
    with named(path):
        wanted = decimals(matrix("K", given))
    if data.get("K") == wanted:
        return ""
    return f"it is about another K than {path}"


def compare_code(proof, path):
    """(difference between a ``proof`` and a program at ``path``, each comparison in
    words); one of the files that `Controller.to_c` or a pendulum's `Program` writes,
    all beside it.
    """
    text, gains, name = _numbers(path)
    if fault := later(CODE, "code_fault")(proof.data, text):
        return f"{fault}: {gains}", []
    files = FILES.findall(text)
    if files and digest(proof.text.encode()) not in files:
        return f"the numbers are the proof's, but {gains} names other proof files", []
    faults, said = later("controllers.written", "changes")(gains.parent, name)
    own = "its law, tick and delay: those of the proof, number by number"
    return "; ".join(faults), [own, *said]


def proofs_beside(path):
    """The proof files that a program names by their digests, beside it, of its law.

    ``path``: as for `compare_code`. Raises ValueError if there is none.
    """
    text, path, _ = _numbers(path)
    known, faults = FILES.findall(text), []
    files = [
        p for p in sorted(path.parent.glob("*.json")) if digest(read_bytes(p)) in known
    ]
    for file in list(files):
        if fault := later(CODE, "code_fault")(load(file).data, text):
            faults.append(f"{file.name}: {fault}")
            files.remove(file)
    if not files:
        why = "; ".join(faults) or "it names none that lies there"
        raise ValueError(
            f"{path} has no proof of its law beside it ({why}): give the file of one, "
            "verify PROOF --code PROGRAM"
        )
    return files


def _numbers(path):
    """The text of a program's <name>_gains.h, where it lies, and the program's name."""
    path, ends = path_of(path), ("_gains.h", "_tick.h", ".c", ".h")
    read_bytes(path)
    name = next((path.name.removesuffix(x) for x in ends if path.name.endswith(x)), "")
    gains = path.with_name(f"{name}_gains.h")
    if not name or not gains.is_file():
        raise ValueError(
            f"{path} is no file of a program's law: give <name>.c, <name>.h, "
            "<name>_tick.h or <name>_gains.h, with the others beside it"
        )
    text = read_text(gains)
    with named(gains):
        later(CODE, "read_gains")(text)
    return text, gains, name
