"""Rows of the reproduction table and errata, and the judgement of a row.

What can be written down of a row before anything is computed stands in
``rows.toml``: its name, kind, tolerance and texts. `evaluate` judges what was
computed by the kind, and fills the texts.
"""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from ...runtime.reading import read_toml

VERDICTS = {
    "reproduced": "our number equals the printed one to the tolerance",
    "property holds": "the claim is true, our numbers are our own",
    "another solution": "the LMIs have many solutions; the printed one and "
    "ours are proven to be among them",
    "misprint": "what is printed fails a test that the corrected text passes",
    "claim refuted": "it isn't so, on each reading of the text that we tried",
    "not reproducible": "can't be told: the readings of the text disagree, or "
    "something that is needed isn't in it",
}
KINDS = {
    "misprint": "the text beside it, or a computation, shows what is meant",
    "single character": "a misprint of one sign, digit, letter or point in "
    "one place, which may be of our machine-read copy and not of the thesis",
    "gap": "something that is needed isn't said",
    "claim refuted": "what is said isn't so",
    "improvement": "right as it stands; there is something better",
}


@dataclass(frozen=True)
class Row:
    """One printed number or claim, and what became of it: the ``chapter``, a file, that
    shows it; ``item`` and ``place``, what, and where in the thesis; ``printed`` and
    ``ours``, the thesis's number and the same quantity, computed here; the ``verdict``,
    a key of `VERDICTS`, and ``why``: tolerance, reason, or what is missing; the
    ``claim`` that the row tests, if several rows do or an erratum speaks of it: a claim
    is counted once; its ``id``, which no other row has; ``kind``, how it was judged, a
    key of `JUDGES`; the ``tolerance`` where numbers are compared; ``assumptions`` of
    the book where the thesis leaves something open.
    """

    chapter: str
    item: str
    place: str
    printed: str
    ours: str
    verdict: str
    why: str
    claim: str = ""
    id: str = ""
    kind: str = ""
    tolerance: str = ""
    assumptions: str = ""

    def __post_init__(self):
        if self.verdict not in VERDICTS:
            raise ValueError(f"unknown verdict {self.verdict!r}")

    @property
    def about(self):
        """The claim's name; a row without one has its own."""
        return self.claim or f"{self.place}: {self.item}"


@dataclass(frozen=True)
class Erratum:
    """One correction: its ``kind``, a key of `KINDS`, its ``place`` in the thesis, what
    is ``printed``, what is ``correct``; the ``evidence``, the ``chapter`` that shows
    it, and the ``claim`` of the rows that compute it.
    """

    kind: str
    place: str
    printed: str
    correct: str
    evidence: str
    chapter: str
    claim: str = ""

    def __post_init__(self):
        if self.kind not in KINDS:
            raise ValueError(f"unknown kind {self.kind!r}")


def evaluate(name, /, *tested, **words):
    """The `Row` of ``rows.toml`` with a ``name``, its id, judged by what was
    ``tested``: see `JUDGES`; ``words`` stand in the braces of its texts. Raises
    KeyError.
    """
    entry = _entries()[name]
    verdict, computed = JUDGES[entry["kind"]](entry, *tested)
    words = computed | words
    texts = {"printed": "{printed}", "ours": "{ours}"} | entry
    if verdict in ("claim refuted", "not reproducible"):
        texts["ours"] = entry.get("otherwise", texts["ours"])
    texts = {name: texts[name].format(**words) for name in TEXTS if name in texts}
    texts["id"] = re.sub(r"[^\w.-]+", "-", texts["id"]).strip("-")
    tolerance = entry.get("within", "")
    if "tolerance" in entry and not tolerance:
        tolerance = f"{entry['tolerance']:g} {entry.get('unit', '')}".strip()
    return Row(
        **texts,
        verdict=verdict,
        kind=entry["kind"],
        tolerance=tolerance,
        assumptions=entry.get("assumptions") or _assumed(texts["place"]),
    )


#: What the book assumes of a figure.
ASSUMED = ("start", "channels", "reference", "delay", "rest")
#: The texts of a row.
TEXTS = ("id", "chapter", "item", "place", "printed", "ours", "why", "claim")


@cache
def read_texts(name):
    """The content of a table of this folder, such as ``rows``."""
    return read_toml(Path(__file__).with_name(f"{name}.toml"))


@cache
def _entries():
    entries = read_texts("rows")["rows"]
    return {re.sub(r"-\{\w+\}", "", entry["id"]): entry for entry in entries}


def _assumed(place):
    """The book's assumptions on the figures that a place names."""
    return "; ".join(
        entry[part]
        for entry in read_texts("assumptions")["figures"]
        if _figures(place) & _figures(entry["place"])
        for part in ASSUMED
    )


def _figures(place):
    """The figures that a place names, those of 4.8 to 4.11 one by one."""
    if not place.startswith(("Fig", "4.3.1, Figs")):
        return set()
    names = set(re.findall(r"\b\d\.\d+\b(?!\.)", place.replace("4.3.1", "")))
    for chapter, low, high in re.findall(r"(\d)\.(\d+) to \d\.(\d+)", place):
        names |= {f"{chapter}.{k}" for k in range(int(low), int(high))}
    return names


def _number(entry, printed, ours):
    """Our number against the printed one, both shown in the entry's form."""
    form = entry.get("form", ".4g")
    if form == "poles":
        ours = matched(printed, ours)
    printed, ours = np.asarray(printed), np.asarray(ours)
    scale = np.where(printed, printed, 1) if entry.get("unit") == "relative" else 1.0
    verdict, gap = compare(printed / scale, ours / scale, entry["tolerance"])
    texts = {"printed": shown(printed, form), "ours": shown(ours, form)}
    return verdict, texts | {"gap": gap, "percent": 100 * gap}


def _gains(entry, printed, ours, *proven):
    """Our gains against the printed ones: the same, or other ones of the LMIs."""
    verdict, reason = solution(printed, ours, entry["tolerance"], *proven)
    form = entry.get("form", ".4f")
    texts = {"printed": shown(printed, form), "ours": shown(ours, form)}
    return verdict, texts | {"reason": reason}


#: How a kind of rows is judged.
JUDGES = {
    "number": _number,
    "gains": _gains,
    "claim": lambda entry, *holds: (claim(*holds), {}),
    "character": lambda entry, *passes: (misprint(*passes), {}),
}


def compare(printed, ours, tolerance):
    """Verdict on ours against printed numbers within a tolerance, and the gap.

    A number that isn't met refutes the claim that it follows.
    """
    gap = np.abs(np.asarray(printed) - np.asarray(ours)).max()
    return ("reproduced" if gap <= tolerance else "claim refuted"), gap


def claim(*holds):
    """Verdict on a claim: whether it ``holds``, on each reading of it."""
    if all(holds):
        return "property holds"
    return "not reproducible" if any(holds) else "claim refuted"


def misprint(printed, mended):
    """Verdict on a character: whether ``printed`` or ``mended`` passes a test."""
    if not printed and mended:
        return "misprint"
    return claim(printed, not mended)


def solution(printed, ours, tolerance, *proven):
    """Verdict on ours against printed gains, and why, within a tolerance.

    They are the same, or both solve the LMIs (proven).
    """
    verdict, gap = compare(printed, ours, tolerance)
    if verdict != "reproduced" and all(proven):
        verdict = "another solution"
    reason = (
        "both are proven to satisfy the LMIs"
        if all(proven)
        else "not both are proven to satisfy the LMIs"
    )
    return verdict, (
        f"{reason}; ours is their analytic centre; largest difference {gap:.2g}"
    )


def proven(answer, *digits):
    """True if an answer has a certificate, and is proven exactly with such digits."""
    return answer.certify(*digits).proven


def said(proof):
    """Says if there is a ``proof``."""
    return "proven" if proof else "not proven"


def below(value, limit):
    """Says that a ``value`` is below a ``limit``, or how large it is: the digits of
    rounding errors differ between machines.
    """
    return f"below {limit:g}" if value < limit else f"{value:.2g}"


def shown(values, form=".4f"):
    """The values as text in a form: poles, or the rows of a matrix."""
    if form == "poles":
        upper = [p for p in np.atleast_1d(values) if p.imag >= 0]
        return ", ".join(
            f"{p.real:.4f}" + (f" ± {p.imag:.4f}j" if p.imag else "") for p in upper
        )
    rows = np.atleast_2d(np.asarray(values, float)) + 0.0  # no minus zero
    return "; ".join(" ".join(format(float(x), form) for x in row) for row in rows)


def matched(printed, computed):
    """The computed poles in the order of the printed ones.

    Where there are too few, infinity stands for the others.
    """
    unmatched = [*computed, *(len(printed) - len(computed)) * [np.inf]]
    return np.array(
        [
            unmatched.pop(int(np.argmin([abs(p - q) for q in unmatched])))
            for p in printed
        ]
    )
