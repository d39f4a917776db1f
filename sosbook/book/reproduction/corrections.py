"""Corrections to the thesis's text, and what was found right.

The texts stand in ``corrections.toml``, what they leave open is computed here.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from ...delay import largest
from .. import ledger, thesis
from .table import Erratum, read_texts


@dataclass(frozen=True)
class Checked:
    """A part of the text that stands: its ``place``, ``what`` was checked and ``how``,
    and the ``chapter``, a file, that does.
    """

    place: str
    what: str
    how: str
    chapter: str


@cache
def errata():
    """Corrections to the text that this edition relies on."""
    numbers = _wing() | _controllers()
    return tuple(
        Erratum(**{name: text.format(**numbers) for name, text in entry.items()})
        for entry in read_texts("corrections")["errata"]
    )


def checked():
    """Formulas of the thesis that were checked and found right."""
    return tuple(Checked(**entry) for entry in read_texts("corrections")["checked"])


def assumptions():
    """The book's assumptions where the thesis leaves its figures open."""
    return tuple(read_texts("assumptions")["figures"])


def readings():
    """Questions that a look into the PDF would answer, with the rows they decide."""
    return tuple(read_texts("assumptions")["readings"])


def _wing():
    """How far the wing's promise is proven, and false."""
    ex = thesis.delay_example_1(published=True)
    best = ledger.wing(ex.delta)
    asked = dict(tau=ex.tau, mu=0.008, delta=ex.delta)
    theorem = largest("mu", ex.loop, **asked, refuse=False)
    return {
        "proven": best.proven / ex.tau,
        "false": best.false / ex.tau,
        "seconds": best.proven,
        "share": best.share,
        "theorem": theorem.value,
    }


def _controllers():
    """The poles and zeros that the printed (4.28) and Table 4.1 imply."""
    printed = thesis.mip()
    _, (_, (zero, _)), (pole, *_) = printed.controller
    ((theta, phi, *_),) = printed.pd[5]
    return {
        "zero": zero,
        "pole_in_hertz": -pole / 2 / np.pi,
        "zero_in_hertz": zero / 2 / np.pi,
        "exponent": pole * 0.01,
        "factor": np.exp(pole * 0.01),
        "lag": np.degrees(np.arctan(2 * np.pi * 50 / zero)),
        "wheel": theta / phi,
    }
