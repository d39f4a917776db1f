"""What a row of the reproduction table and an erratum hold."""

from dataclasses import dataclass

import numpy as np

__all__ = [
    "KINDS",
    "VERDICTS",
    "Erratum",
    "Row",
    "below",
    "claim",
    "compare",
    "format_gain",
    "format_poles",
    "matched",
    "misprint",
    "proven",
    "solution",
]

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
    """One printed number or claim, and what became of it.

    Parameters
    ----------
    chapter : str
        File of the book's chapter that shows it.
    item, place : str
        What, and where in the thesis.
    printed, ours : str
        The thesis's number, and the same quantity, computed here.
    verdict : str
        A key of `VERDICTS`.
    why : str
        Tolerance, reason, or what is missing.
    claim : str, optional
        The claim that the row tests, if several rows do or an erratum
        speaks of it: a claim is counted once.
    """

    chapter: str
    item: str
    place: str
    printed: str
    ours: str
    verdict: str
    why: str
    claim: str = ""

    def __post_init__(self):
        if self.verdict not in VERDICTS:
            raise ValueError(f"unknown verdict {self.verdict!r}")

    @property
    def about(self):
        """The claim's name; a row without one has its own."""
        return self.claim or f"{self.place}: {self.item}"


@dataclass(frozen=True)
class Erratum:
    """One correction.

    Parameters
    ----------
    kind : str
        A key of `KINDS`.
    place, printed, correct : str
        Where it stands in the thesis, what stands there, and what should.
    evidence : str
        Why, and what computes it.
    chapter : str
        File of the chapter that shows it.
    claim : str, optional
        The claim of the rows that compute it.
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


def compare(printed, ours, tolerance):
    """Verdict on ours against printed numbers within a tolerance, and the gap.

    A number that isn't met refutes the claim that it follows.
    """
    gap = np.abs(np.asarray(printed) - np.asarray(ours)).max()
    return ("reproduced" if gap <= tolerance else "claim refuted"), gap


def claim(*holds):
    """Verdict on a claim: whether it holds, on each reading of it.

    Examples
    --------
    >>> print(claim(True), claim(False, False), claim(True, False), sep="; ")
    property holds; claim refuted; not reproducible
    """
    if all(holds):
        return "property holds"
    return "not reproducible" if any(holds) else "claim refuted"


def misprint(printed, mended):
    """Verdict on a character: whether ``printed`` or ``mended`` passes a test.

    Examples
    --------
    >>> print(misprint(False, True), misprint(True, True), sep="; ")
    misprint; not reproducible
    """
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
    """Whether an answer has a certificate, and is proven exactly with such digits."""
    return answer.certify(*digits).proven


def below(value, limit):
    """Whether a value is below a limit, in words, for digits may differ.

    Those of rounding errors differ between machines.
    """
    return f"below {limit:g}" if value < limit else f"{value:.2g}"


def format_poles(values):
    """Poles, the given values, as text."""
    upper = [p for p in np.atleast_1d(values) if p.imag >= 0]
    return ", ".join(
        f"{p.real:.4f}" + (f" ± {p.imag:.4f}j" if p.imag else "") for p in upper
    )


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


def format_gain(K, decimals=4):
    """A gain K as text, row by row, with so many decimals."""
    return "; ".join(" ".join(f"{k:.{decimals}f}" for k in row) for row in K)
