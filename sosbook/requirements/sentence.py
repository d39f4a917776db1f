"""Sentences of English that say all that a plant file asks, and are read again.

The words stand in ``sentence.json``, which the book's pages read, too. A clause prints
and reads the numbers of one place of the file. What it prints is the shortest decimal
that leads back to the very float; a clause that has none of six digits isn't taken,
and the next for the same place is.
"""

import re
from copy import deepcopy
from functools import cache
from pathlib import Path

from ..runtime.reading import read_json
from .figures import FIGURE, number, show, shown_of, value_of
from .places import canonical, get, integrated, limit, mixed, put

TABLE = read_json(Path(__file__).with_name("sentence.json"))
CLAUSES = TABLE["clauses"]
#: What stays as it is in the file, said or not.
KEPT = "$schema", "plant", "words", "U", "search"
LOOSE = {
    "²": r"(?:²|\^?2)",
    "s⁻¹": "(?:s⁻¹|1/s|/s)",
    "σ": "(?:σ|sigma)",
    "θ": "(?:θ|theta)",
    "ρ": "(?:ρ|rho)",
    "γ": "(?:γ|gamma)",
    "μ": "(?:μ|mu)",
    "°": r"(?:°|\s*deg(?:rees)?)",
}


AT_X0 = "saturation", "x0"
#: What a part of the file must have, so that clauses say it.
NEEDED = {"saturation": ("u_max", "x0"), "controller": ("T",)}
NEEDED |= {"hinf": ("gamma",), "cost": ("bound",)}


class Sentences:
    """Sentences about one plant.

    ``data``: the content of a plant file; ``n``: how many coordinates its plant has;
    ``rest``: a function from the rows that are integrated to the coordinates at which
    the plant rests when each of these errors is one, or to None.
    """

    def __init__(self, data, n, rest=lambda rows: None):
        plant = data["plant"] if isinstance(data["plant"], dict) else {}
        self.data, self.n, self.rest = canonical(data), n, rest
        self.ranges = plant.get("parameters", {})
        named = plant.get("coordinates") or [f"z{i + 1}" for i in range(n)]
        sensors = {f"z{i + 1}": [name] for i, name in enumerate(named)}
        self.names = TABLE["names"] | {name: [name] for name in self.ranges} | sensors
        self.names |= {"it": [TABLE["it"]]} | _words(data.get("words", {}))

    # ------------------------------------------------------------- printing
    def __str__(self):
        data, said = self.data, []
        for clause in CLAUSES:
            text = self._clause(clause, data)
            if text is not None and clause["key"] not in dict(said):
                said.append((clause["key"], text))
        texts = [text for _, text in said]
        if more := self.others():
            texts.append(TABLE["end"].replace("{}", ", ".join(more)))
        return f"{self._subject()} {', '.join(texts)}".strip() + "."

    def others(self):
        """The parts of the file that no clause says, by name."""
        found = []
        for key, value in sorted(self.data.items()):
            places = [c["at"] for c in CLAUSES if c["at"][0] == key]
            known = {at[1] for at in places if len(at) > 1}
            if key in KEPT:
                continue
            if not places or not self._readable(key, value):
                found.append(key)
            elif known:
                known |= {"position", "integrate"} if key == "law" else set()
                known |= {"x0"} if key == "saturation" else set()
                same = key == "controller" and value.get("u_max") == limit(self.data)
                known |= {"u_max"} if same else set()
                found += [f"{key}.{inner}" for inner in sorted(value.keys() - known)]
        return found

    def _readable(self, key, value):
        """True if clauses say the value of a key of the file."""
        if key == "law":
            return self._law(value) is not None
        if key == "gamma":
            return isinstance(value, (int, float))
        needed = NEEDED.get(key, ())
        there = value if isinstance(value, dict) else {}
        return bool(there) and all(there.get(x) is not None for x in needed)

    def _subject(self):
        text = self._named(TABLE["subject"])
        for k, (name, ends) in enumerate(self.ranges.items()):
            low, high = (show(repr(float(x)), -self._power(name)) for x in ends)
            text += self._range(k, name).format(low=low, high=high)
        return text

    def _range(self, k, name):
        own = self.names[name][0] == self.names["it"][0]
        form = TABLE["range"][0 if own and k == 0 else 1 if k == 0 else 2]
        return self._named(form.replace("<p>", f"<{name}>").replace("[p]", f"[{name}]"))

    def _power(self, name):
        return (*self.names[name], "", 0)[2] if len(self.names[name]) > 2 else 0

    def _named(self, text):
        """A text with names and units in the place of <z> and [z]."""

        def of(found):
            name = self.names[found[1] or found[2]]
            unit = name[1] if len(name) > 1 else ""
            return name[0] if found[1] else unit and f" {unit}"

        return re.sub(r"<(\w+)>|\[(\w+)\]", of, text)

    def _clause(self, clause, data):
        """The words of a clause about the file's content, or None."""
        key, value = clause["key"], get(data, clause["at"])
        if value is None or not self._readable(clause["at"][0], data[clause["at"][0]]):
            return None
        if key == "law":
            shown = {"law": self._law(value)}
        else:
            shown = {key: shown_of(clause, value)}
        if "{step}" in clause["says"]:
            step = self._step(data)
            shown["step"] = None if step is None else show(repr(step))
        if "{x0}" in clause["says"]:
            shown["x0"] = "; ".join(show(repr(float(x))) for x in get(data, AT_X0))
        if None in shown.values():
            return None
        return self._named(clause["says"]).format(**shown)

    # ----------------------------------------------------- what is measured
    def laws(self):
        """[words, rows of the measured positions] of all laws that have words."""
        unit = [[float(i == j) for j in range(self.n)] for i in range(self.n)]
        (clause,) = (c for c in CLAUSES if c["key"] == "law")
        places = [f"z{i + 1}" for i in range(self.n)]
        bare = ["position " * (self.names[z][0] == z) + f"<{z}>" for z in places]
        one = [clause["one"].replace("<z>", z) for z in bare]
        some = [(self._named(text), [unit[i]]) for i, text in enumerate(one)]
        return [*(some if self.n > 1 else ()), (clause["all"], unit)]

    def _law(self, law):
        """The words of a law of the file, or None."""
        if {*law} - {"position", "integrate", "filter", "structure"}:
            return None
        for words, rows in self.laws():
            same = law.get("position") == rows
            if same and law.get("integrate", []) == mixed(
                integrated({"law": law}), rows
            ):
                return words
        return None

    def _start(self, step, data):
        """x(0) at rest, a step of all that is integrated away; None if unknown."""
        rows, law = integrated(data), data.get("law") or {}
        rest = self.rest(rows)
        if rest is None:
            return None
        seen = law["position"] if "filter" in law else []
        held = [sum(x * z for x, z in zip(row, rest)) for row in seen]
        return [0.0 - step * x for x in (*rest, *[0] * (self.n + len(rows)), *held)]

    def _step(self, data):
        """The step of the set point that x(0) is, or None."""
        x0, one = get(data, AT_X0), self._start(1.0, data)
        if one is None or len(x0) != len(one) or not any(one):
            return None
        k = next(k for k, x in enumerate(one) if x)
        step = x0[k] / one[k]
        return step if step > 0 and self._start(step, data) == x0 else None

    # -------------------------------------------------------------- reading
    def read(self, text):
        """The content of the plant file that a ``text`` asks for.

        What isn't said isn't asked. Raises ValueError for what isn't understood, with
        its place and how the sentence may go on there.
        """
        whole = re.sub(r"\s+", " ", text.replace("_", " ")).strip()
        whole = re.sub(r"\s*:[^:]*$", "", whole).removesuffix(".")
        found = {}
        at = self._read_subject(whole, found)
        end = _pattern(TABLE["end"].replace("{}", "{end}"))
        while at < len(whole):
            at += re.match(r"[\s,]*", whole[at:]).end()
            rest = whole[at:]
            if last := end.match(rest):
                self._others(last, found, at)
                at += last.end()
                continue
            at += re.match(r"(?:and\s+)?", rest, re.IGNORECASE).end()
            rest = whole[at:]
            if not rest:
                break
            clause, hit = self._hit(rest)
            if clause is None:
                odd = f"“{rest[:40]}” isn't understood"
                _refuse(f"{odd}. It may go on: {self._next(found)}", at)
            if clause["key"] in found:
                _refuse(f"“{hit[0]}”: that is said twice", at)
            found[clause["key"]] = self._values(clause, hit, at)
            at += hit.end()
        return self._made(found)

    def _read_subject(self, whole, found):
        """Read the subject and the ranges of parameters; return where it ends."""
        form = self._named(TABLE["subject"])
        form += "".join(self._range(k, name) for k, name in enumerate(self.ranges))
        for k in range(len(self.ranges)):
            form = form.replace("{low}", f"{{low{k}}}", 1).replace(
                "{high}", f"{{high{k}}}", 1
            )
        hit = _pattern(form).match(whole)
        if not hit:
            _refuse(f"the sentence begins “{self._subject()} …”", 0)
        found["ranges"] = {}
        for k, name in enumerate(self.ranges):
            texts = hit[2 * k + 1], hit[2 * k + 2]
            low, high = (value_of({"shift": self._power(name)}, x) for x in texts)
            if not low < high:
                _refuse(
                    f"“{texts[0]}..{texts[1]}”: the smaller number stands first",
                    hit.start(2 * k + 1),
                )
            found["ranges"][name] = [low, high]
        return hit.end()

    def _hit(self, rest):
        """The clause with which a text begins, and its match; or None twice."""
        for clause in CLAUSES:
            says = self._named(clause["says"])
            laws = self.laws() if clause["key"] == "law" else [("", None)]
            for form in [says.replace("{law}", words) for words, _ in laws]:
                if hit := _pattern(form).match(rest):
                    return clause, hit
        return None, None

    def _values(self, clause, hit, at):
        """The numbers of a clause that was found, by slot."""
        key, slots = clause["key"], re.findall(r"\{(\w+)\}", clause["says"])
        if key == "law":
            for words, rows in self.laws():
                if _pattern(clause["says"].replace("{law}", words)).match(hit[0]):
                    return {"law": rows}
        values = {}
        for k, slot in enumerate(slots):
            if slot == "x0":
                values[slot] = [
                    value_of({}, x) for x in re.split(r"\s*;\s*", hit[k + 1])
                ]
                continue
            x = value_of(clause if slot == key else {}, hit[k + 1])
            low, high = clause.get("below"), clause.get("most")
            shown = number(hit[k + 1])
            if slot == key and low is not None and not shown < low:
                _refuse(f"“{hit[0]}”: a number below {show(repr(low))} is needed", at)
            if slot == key and high is not None and not shown <= high:
                _refuse(f"“{hit[0]}”: at most {show(repr(high))} is needed", at)
            if not (x > 0 or (x == 0 and "zero" in clause)) or x == float("inf"):
                _refuse(f"“{hit[0]}”: a number above zero is needed", at)
            values[slot] = x
        return values

    def _others(self, hit, found, at):
        """Note which parts stay as in the file."""
        names = re.split(r"\s*,\s*", hit[1].strip())
        for name in names:
            if name not in self.others():
                _refuse(f"“{name}”: the file says nothing else of it", at)
        found["others"] = names

    def _next(self, found):
        texts = {}
        for clause in CLAUSES:
            if clause["key"] not in found:
                text = self._named(clause["says"])
                law = " / ".join(words for words, _ in self.laws())
                text = text.replace("{law}", law)
                texts.setdefault(clause["key"], re.sub(r"\{\w+\}", "…", text))
        return "; ".join(texts.values())

    def _made(self, found):
        """The content of a file with what was found and nothing else."""
        data, rows = deepcopy(self.data), integrated(self.data)
        for name in self.others():
            if name not in found.get("others", ()):
                put(data, name.split("."), None)
        for clause in CLAUSES:
            if clause["at"][0] not in found.get("others", ()):
                put(data, clause["at"], None)
        if "controller.u_max" not in self.others():
            put(data, ["controller", "u_max"], None)
        if found["ranges"]:
            data["plant"]["parameters"] = found["ranges"]
        if "law" not in data:
            data["U"] = rows
        if "law" in found:
            data.pop("U", None)
            position = found["law"]["law"]
            seen = mixed(rows, position)
            data["law"] = {"position": position} | ({"integrate": seen} if seen else {})
            if "law.structure" in found.get("others", ()):
                data["law"]["structure"] = self.data["law"]["structure"]
        elif "filter" in found:
            _refuse("“its rate over …” needs before it what is measured", 0)
        for clause in CLAUSES:
            key = clause["key"]
            if key not in ("law", "u_max") and key in found:
                put(data, clause["at"], found[key][key])
        if not data.get("U", True):
            del data["U"]
        if "u_max" in found:
            x0 = found["u_max"].get("x0") or self._start(found["u_max"]["step"], data)
            if x0 is None:
                _refuse("where this plant rests isn't known: write x(0) out", 0)
            data.setdefault("saturation", {}).update(
                u_max=found["u_max"]["u_max"], x0=x0
            )
        if "controller" in data and "T" not in data["controller"]:
            _refuse("the controller needs its clock: say “at … kHz”", 0)
        return canonical(data)


def _words(words):
    """The vocabulary of a file, each entry a list."""
    return {
        name: x if isinstance(x, list) else [x]
        for name, x in words.items()
        if name != "filter"
    }


def _refuse(words, at):
    raise ValueError(f"character {at + 1}: {words}")


@cache
def _pattern(form):
    """The loose pattern of a clause's words, with a group for each number."""

    def of(bit):
        if bit == "{end}":
            return r"((?:[\w.]+,\s*)*[\w.]+?)"
        if bit == "{x0}":
            return rf"\s*({FIGURE}(?:\s*;\s*{FIGURE})*)\s*"
        if bit.startswith("{"):
            return rf"\s*({FIGURE})\s*"
        text = re.sub(r"[.*+?^${}()|\[\]\\/]", r"\\\g<0>", bit.replace("_", " "))
        text = re.sub(r"\s+", r"\\s*", text)
        for mark, loose in LOOSE.items():
            text = text.replace(mark, loose)
        return text

    bits = re.split(r"(\{\w+\})", form)
    return re.compile("".join(map(of, bits)) + r"(?![\w²])", re.IGNORECASE)
