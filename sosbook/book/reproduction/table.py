"""What a row of the reproduction table and an erratum hold."""

from dataclasses import dataclass

import numpy as np

__all__ = [
    "Erratum",
    "Row",
    "VERDICTS",
    "claim",
    "compare",
    "format_gain",
    "format_poles",
    "matched",
]

VERDICTS = {
    "reproduced": "our number equals the printed one to the tolerance",
    "property holds": "the claim is true, our numbers are our own",
    "differs": "our number is another one; the row says why",
    "not reproducible": "something that is needed isn't in the text",
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
    verdict : str
        A key of `VERDICTS`.
    why : str
        Tolerance, reason, or what is missing.
    """

    chapter: str
    item: str
    place: str
    printed: str
    ours: str
    verdict: str
    why: str

    def __post_init__(self):
        if self.verdict not in VERDICTS:
            raise ValueError(f"unknown verdict {self.verdict!r}")


@dataclass(frozen=True)
class Erratum:
    """One correction.

    Parameters
    ----------
    place, printed, correct : str
    evidence : str
        Why, and what computes it.
    chapter : str
        File of the chapter that shows it.
    """

    place: str
    printed: str
    correct: str
    evidence: str
    chapter: str


def compare(printed, ours, tolerance):
    """Verdict on numbers; poles are matched in sorted order."""
    gap = np.abs(np.asarray(printed) - np.asarray(ours)).max()
    return ("reproduced" if gap <= tolerance else "differs"), gap


def claim(holds):
    return "property holds" if holds else "differs"


def format_poles(values):
    upper = [p for p in np.atleast_1d(values) if p.imag >= 0]
    return ", ".join(
        f"{p.real:.4f}" + (f" ± {p.imag:.4f}j" if p.imag else "")
        for p in upper
    )


def matched(printed, computed):
    """The computed poles in the order of the printed ones."""
    left = list(computed)
    return np.array([
        left.pop(int(np.argmin([abs(p - q) for q in left])))
        for p in printed
    ])


def format_gain(K):
    return "; ".join(" ".join(f"{k:.4f}" for k in row) for row in K)
