"""The numbers of a C program, read back and compared with the proven ones."""

import re

import numpy as np

from ..exact.definite import exact
from ..exact.rational import read_fractions, read_number
from ..runtime.digests import digest
from .estimates import balancing, heading
from .signals import identifiers

MATRICES = ("A", "B", "C", "D")
NUMBERS = "TICK", "SINGLE", "STATES", "MEASURED", "OUTPUTS", "TICK_US"
DELAYS = "DELAY_TICKS", "DELAY_REST_US"  # a balancing robot's program has none
ROBOTS = "BLEND", "DELAY"  # nor any other these, and its heading's K
ROWS = "ROWS"  # a robot's program has none
NUMBER = re.compile(r"(-?(?:0x[0-9a-f]+(?:\.[0-9a-f]+)?p[+-]?\d+|\d+))(f|UL)?")
LINE = re.compile(r"#(?:ifndef \w+|endif|define (?P<name>\w+)(?: (?P<value>.*))?)")
DIGEST = re.compile("[0-9a-f]{16,}")
PLANT = re.compile(rf"plants?:[\s*]+sha256((?:[\s*]+{DIGEST.pattern})+)")
MICROSECOND = 1e-6  # of which the program's clock has whole ones
ROUNDED = 0.500001 * MICROSECOND


def read_gains(text):
    """The numbers of a controller's loop in the text of a <name>_gains.h.

    Parameters
    ----------
    text : str
        Of the file.

    Returns
    -------
    dict
        A, B, C and D are arrays; TICK, SINGLE, STATES, MEASURED, OUTPUTS, TICK_US are
        numbers. A balancing robot's program has BLEND, DELAY, and K of its heading;
        others have the numbers DELAY_TICKS and DELAY_REST_US and the array ROWS, what
        is measured of the plant's state.

    Raises
    ------
    ValueError
        If one is missing or can't be read, or the text has more than comments and
        definitions, each once.
    """
    given = definitions(text)
    named = {name: given.get(name) for name in (*MATRICES, *NUMBERS)}
    if lost := sorted(name for name, value in named.items() if value is None):
        raise ValueError(f"the text defines no {', '.join(lost)}")
    found = {name: _matrix(named[name]) for name in MATRICES}
    found |= {name: value_of(named[name]) for name in NUMBERS}
    found |= {x: value_of(given[x]) for x in (*DELAYS, *ROBOTS) if x in given}
    if "K" in given:
        found["K"] = _matrix("{" + given["K"] + "}")[0]
    if ROWS in given:
        found[ROWS] = _matrix(given[ROWS])
    l, q, m = (int(found[name]) for name in ("STATES", "MEASURED", "OUTPUTS"))
    room = max(l, 1)  # C has no array of nothing
    for name, shape in zip(MATRICES, ((room, room), (room, q), (m, room), (m, q))):
        if found[name].shape != shape:
            raise ValueError(f"{name} has not the {shape} numbers of its sizes")
    if ROWS in found and len(found[ROWS]) != q:
        raise ValueError(f"{ROWS} has not a row for each of the {q} sensors")
    return found


def definitions(text):
    """The definitions in the text of a <name>_gains.h, as they stand there.

    Returns a dict from each label, without the program's name in front, to its value.
    Raises ValueError if the text has anything else than comments and definitions,
    each once, and each with the program's name in front.
    """
    if not isinstance(text, str):
        raise ValueError(f"text must be that of a file, got {type(text).__name__}")
    lines = [line.strip() for line in _without_comments(text).split("\n")]
    lines = [LINE.fullmatch(line) or _refuse(line) for line in lines if line]
    if not lines:
        raise ValueError("the text defines nothing: give that of <name>_gains.h")
    guard = lines[0].string.removeprefix("#ifndef ")
    prefix, given = guard.removesuffix("GAINS_H"), {}
    for line in lines[1:-1]:
        name = line["name"] or _refuse(line.string)
        label = name.removeprefix(prefix)
        if name == label or label in given:
            _refuse(line.string)
        given[label] = re.sub(r"\s+", " ", line["value"] or "").strip()
    if given.pop("GAINS_H", None) != "":
        _refuse(lines[0].string)
    return given


def columns_fault(text, law=None):
    """The difference between the names of a program's columns and its rows; or "".

    ``text``: of a <name>_gains.h. Sensors, set points and outputs are numbered in their
    order, and the comment of a row of ROWS names its sensor. A sampled ``law`` of a
    proof names the plant's states and inputs: what is called as a state has its row.
    """
    given, law = definitions(text), law or {}
    if lost := {"SET_POINTS", ROWS} - given.keys():
        return f"the text defines no {', '.join(sorted(lost))}"
    words = {}
    for kind, size in (("IN", "MEASURED"), ("SET", "SET_POINTS"), ("OUT", "OUTPUTS")):
        labels = [x for x in given if x.startswith(f"{kind}_") and x != "SET_POINTS"]
        if [given[x] for x in labels] != [str(k) for k in range(int(given[size]))]:
            return f"its {kind}_ numbers aren't 0, 1, ... in their order"
        words[kind] = [x.removeprefix(f"{kind}_") for x in labels]
    said = _sensors(text)
    if not said or identifiers(said) != words["IN"]:
        return f"its IN_ names aren't those of its {ROWS}"
    if law.get("outputs") and identifiers(law["outputs"]) != words["OUT"]:
        return "its OUT_ names aren't the proof's"
    states = list(law.get("inputs", ()))
    for word, row in zip(said, _matrix(given[ROWS])):
        if word in states and (row != np.eye(len(states))[states.index(word)]).any():
            return f"its {ROWS} has another row for {word} than the proof"
    return ""


def _states(plant):
    """The names of a ``plant``'s states in a proof, where its kind has some."""
    if plant.get("kind") != "descriptor":
        return ()
    first = (plant.get("vertices") or [plant])[0]
    return plant.get("states") or [f"x{k}" for k in range(1, len(first["E"]) + 1)]


def _sensors(text):
    """The names of the sensors beside ROWS, without their units."""
    block = re.search(rf"_{ROWS} {{ \\\n(.*?)\n}}", text.replace("\r", ""), re.S)
    said = re.findall(r"/\* (.*): [^:]* \*/", block[1] if block else "")
    return [re.sub(r" \([^()]*\)$", "", words) for words in said]


def _refuse(line):
    raise ValueError(f"the text has more than definitions, each once: {line[:80]!r}")


def _without_comments(text):
    """A text of C as its compiler sees it, joined lines being one; no strings."""
    if "??" in text:
        _refuse(text[text.index("??") :])

    def told(match):
        return " " if match[0].startswith("/*") else _refuse(match[0])

    text = text.replace("\r\n", "\n").replace("\\\n", "")
    return re.sub(r"/\*.*?\*/|[\"'\\\r].*|//.*", told, text, flags=re.S)


def value_of(text):
    """The value of a ``text`` that is a literal of C."""
    match = NUMBER.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"{text.strip()[:80]!r} is no number")
    value = float.fromhex(match[1]) if "x" in match[1] else float(match[1])
    return float(np.float32(value)) if match[2] == "f" else value


def _matrix(text):
    """The array of a matrix of C."""
    rows = re.findall(r"\{([^{}]*)\}", text[1:])
    rest = re.sub(r"\{[^{}]*\}|[\s,]", "", text[1:])
    if text[:1] != "{" or rest != "}" or not rows:
        raise ValueError(f"{text[:80]!r} is no matrix")
    rows = [[value_of(x) for x in row.split(",")] for row in rows]
    if len(set(map(len, rows))) > 1:
        raise ValueError("the rows of a matrix differ in length")
    return np.array(rows)


def code_fault(data, text):
    """The difference between a program's loop and a proof's; empty if there is none.

    Parameters
    ----------
    data : dict
        Of a proof file about a sampled controller; or about a gain, which a program
        must then apply at once, with sums of T U times what is measured.
    text : str
        Of the program's <name>_gains.h. The digest of the plant counts, where it has
        one. Its set points, limits and faults are no part of a proof.

    Notes
    -----
    A proof has the law as a function of the plant's state x. A program has it as a
    function of its sensors y = R x, where R is its matrix ROWS. So C and A must be
    those of the proof, and B R and D R must be its B and D, entry by entry, rounded to
    doubles. In single precision a program can be compared only if each of its sensors
    is a coordinate as it is. Of a plant of discrete time the proof has the program's
    own matrices as those of its law, see `sosbook.controllers.own_ticks`.
    """
    law, own, about = data.get("K"), data.get("law"), data.get("plant") or {}
    if not law or (own and "dt" not in about) or "L" in data:
        return "the proof is about no gain and no sampled controller"
    try:
        mine = read_gains(text)
        robot = "BLEND" in mine
        named = law if isinstance(law, dict) else dict(inputs=_states(about))
        fault = "" if robot else columns_fault(text, named)
    except ValueError as error:
        return str(error)
    if fault:
        return fault
    plant = PLANT.search(text)
    given = DIGEST.findall(plant[1]) if plant else ()
    if given and not digest(data.get("plant")).startswith(tuple(given)):
        return f"it is about another plant, sha256 {', '.join(given)}"
    kind = np.float32 if mine["SINGLE"] else float
    if "dt" in about and (fault := _tick_fault(data, mine, kind)):
        return fault
    if own:
        return _program_fault(data, mine, kind, text)
    if not robot:
        if mine["SINGLE"] and _mixes(mine[ROWS]):
            return "its sensors mix coordinates: hold the program in double precision"
        mine |= {
            name: np.asarray(exact(mine[name]) @ exact(mine[ROWS]), float)
            for name in "BD"
        }
    if not isinstance(law, dict):
        return _gain_fault(data, mine, kind)
    if fault := _clock_fault(data, mine, kind):
        return fault
    if robot:
        return _robot_fault(law, mine)
    law = {name: _read(law[name], kind) for name in MATRICES}
    for name in MATRICES:
        if not _same(law[name], mine[name]):
            seen = "" if name in "AC" else f" {ROWS}"
            return f"its {name}{seen} isn't the proof's {name}"
    return ""


def _tick_fault(data, mine, kind):
    """The difference between a program's tick and that of a proof's plant of discrete
    time, on which it acts at once; or "".
    """
    dt = float(exact(read_number(data["plant"]["dt"])))
    us = round(dt / MICROSECOND)
    if mine["TICK"] != float(kind(dt)) or mine["TICK_US"] != us:
        return "its TICK isn't the clock of the proof's plant"
    if any(mine.get(x, 1) for x in DELAYS):
        return "it acts later than the proof's plant says"
    return ""


def _program_fault(data, mine, kind, text):
    """The difference between a program and the law of a proof at the ticks of a plant
    of discrete time; or "".
    """
    law, dt = data["law"], exact(read_number(data["plant"]["dt"]))
    q, l = len(law["rows"]), len(law["E"])
    wide = dict(rows=0, E=0, A=0, B=q, of_sensors=0, of_states=l)
    rows, E, A, B, y, s = (read_fractions(law[x], n) for x, n in wide.items())
    one, own = exact(np.eye(q + l)), exact(np.eye(l))
    if (np.hstack([y, s]) != one).any() or (E != dt * own).any():
        return "the proof's law isn't that of a program"
    if identifiers(_sensors(text)) != identifiers(law["signals"][:q]):
        return "its sensors aren't the proof's"
    K = _read(data["K"], kind)
    for name, M in dict(A=A + own, B=B, C=K[:, q:], D=K[:, :q], ROWS=rows).items():
        if not _same(np.asarray(M, float).astype(kind).astype(float), mine[name]):
            return f"its {name} isn't the proof's"
    return ""


def _clock_fault(data, mine, kind):
    """The difference between a program's tick and delay and a proof's; or ""."""
    law = data["K"]
    T, (early, late) = _ends(data["T"]), _ends(data["delay"])
    tick = law["dt"] if isinstance(law["dt"], str) else None
    tick = T[0] if tick is None else exact(read_number(tick))
    if not T[0] <= tick <= T[1] or mine["TICK"] != float(kind(float(tick))):
        return "its TICK isn't the proof's T"
    if mine["TICK_US"] != round(float(tick) / MICROSECOND):
        return "its TICK_US isn't the proof's T"
    if "DELAY" in mine:
        late_enough = float(late) <= mine["DELAY"] + ROUNDED
        return "" if late_enough else "its delay is shorter than the proof's"
    if not all(x in mine for x in DELAYS):
        return "it has no delay"
    after = mine["DELAY_TICKS"] * float(tick) + mine["DELAY_REST_US"] * MICROSECOND
    if not float(early) - ROUNDED <= after <= float(late) + ROUNDED:
        return "its delay isn't the proof's"
    return ""


def _robot_fault(law, mine):
    """The difference between a robot's law and estimates and a proof's; or ""."""
    if mine["SINGLE"]:
        return "its estimates round otherwise: hold the program in double precision"
    proven = [_read(law[name], float) for name in MATRICES]
    known = [balancing(mine)]
    if "K" in mine:
        known.append(heading(mine["K"], mine["TICK"]))
    for system in known:
        own = [getattr(system, name) for name in MATRICES]
        if all(
            a.shape == b.shape and np.allclose(a, b, rtol=1e-13, atol=1e-13 * size)
            for a, b in zip(proven, own)
            for size in [abs(b).max(initial=0)]
        ):
            return ""
    return "its law and estimates aren't the proof's"


def _gain_fault(data, mine, kind):
    """The difference of u = C x + D y, x the sums of T U y, from a gain's; or ""."""
    if "T" in data:
        return "the proof is about a sampled gain: take that of the controller"
    K, U = _read(data["K"], kind), _read(data.get("U"), float)
    if "K" in mine and _same(K, mine["K"][None]) and _same(U, np.eye(1)):
        return ""  # of a robot's heading
    sums = len(U)
    C = mine["C"] if mine["C"].any() else np.zeros((len(mine["D"]), 0))
    if not _same(K, np.hstack([mine["D"], C])):
        return (
            "its C and D aren't the proof's K (a law with an estimate in it is held to "
            "the proof of its sampled loop)"
        )
    if not sums:
        return ""
    n, tiny = U.shape[1], 2 * np.finfo(kind).eps  # T U is rounded, and T once more
    B = np.zeros(mine["B"].shape)
    B[:, :n] = mine["TICK"] * U
    good = data.get("K_A") is None and _same(np.eye(sums), mine["A"])
    if not good or not np.allclose(mine["B"], B, rtol=tiny, atol=0):
        return "its A and B don't sum the proof's U"
    return ""


def _ends(x):
    """Both ends of a range, or of one decimal, exactly."""
    low, high = x if isinstance(x, list) else (x, x)
    return exact(read_number(low)), exact(read_number(high))


def _read(rows, kind):
    """A matrix of decimals as floats, rounded as the program has them."""
    if not rows:
        return np.zeros((0, 0))
    numbers = [[read_number(x) for x in row] for row in rows]
    return np.array(numbers, float).astype(kind).astype(float)


def _same(a, b):
    """True if a and b are equal; no entries equal zeros, which C needs."""
    return (a.shape == b.shape and (a == b).all()) or (not a.size and not b.any())


def _mixes(rows):
    """True if one of the rows is more than one coordinate as it is."""
    rows = np.asarray(rows, float)
    return not ((rows == 0) | (rows == 1)).all() or (rows.sum(axis=1) != 1).any()
