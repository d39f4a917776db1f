"""Best known values: what the sharpest test of the package proves, and what is false.

Prose, errata and exercises read these here, so that they can't fall behind a
sharper method: a test asks every method of the package for more.
"""

from dataclasses import dataclass
from functools import cache

from scipy.optimize import brentq

from ..delay import delayed_loop, largest, slowest_decay
from ..plants.descriptor import descriptors
from ..synthesis.pid import analyse_pid
from . import thesis

__all__ = ["RATES", "SHARPEST", "Best", "entries", "masses", "norm", "wing"]

#: The method that proves the most for both printed gains with a delayed input.
SHARPEST = {"method": "interval", "order": 1}
USUAL = dict(mu=0.85, delta=0.94)  # of what can be true: where a search begins

#: The rates that the book asks for, in 1/s: the thesis's, half of it, stability.
RATES = (0.6, 0.3, 0.0)


@dataclass(frozen=True)
class Best:
    """The best known value of something that the thesis promises of its gains.

    ``what``: what is promised, with the quantity's name last; ``unit``: of the
    quantity; ``printed``: the promised value, or None; ``proven``: the best value
    with a certificate, of three digits; ``false``: what can't be true, from here on,
    to the next digits; ``method``: what proves it; ``chapter``: file of the chapter
    that shows it.
    """

    what: str
    unit: str
    printed: float | None
    proven: float
    false: float
    method: str
    chapter: str

    @property
    def share(self):
        """The part of what can be true that is proven."""
        return min(self.proven / self.false, self.false / self.proven)

    def __repr__(self):
        return (
            f"<{self.what} = {self.proven}{self.unit} proven, "
            f"{self.false:.3g}{self.unit} false>"
        )


def entries():
    """Every `Best` of the ledger."""
    return (*map(wing, RATES), masses(), *map(norm, (1, 2, 3)))


def _largest(name, ex, true, **asked):
    """The largest value of a name, below the ``true`` one, that `SHARPEST` proves for
    an example's gains.
    """
    asked |= {name: USUAL[name] * true, "tau": ex.tau} | SHARPEST
    found = largest(name, ex.loop, digits=3, refuse=False, **asked)
    if not found.design.certify().proven:
        raise ValueError(f"{name} = {found.value} isn't proven")
    return found.value


@cache
def wing(rate):
    """A `Best`: how far the published wing's delay may move, at a ``rate`` in 1/s.
    Raises ``ValueError`` where nothing is proven.
    """
    ex = thesis.delay_example_1(published=True)
    A, Ad = delayed_loop(*descriptors(ex.plant, ex.U), ex.K)

    def spare(mu):
        return slowest_decay(A, Ad, ex.tau - mu, ex.tau + mu)[0] - rate

    if spare(0.0) <= 0:
        raise ValueError(f"the rate {rate} isn't true even of the constant delay")
    high = brentq(spare, 0.0, ex.tau, xtol=1e-7) + 1e-6
    proven = _largest("mu", ex, high, delta=rate)
    promised = ex.mu if rate == ex.delta else None
    what, how = f"rate {rate}: mu", "interval functional, order 1"
    return Best(what, " s", promised, proven, high, how, "17_wing_and_two_masses")


@cache
def masses():
    """A `Best`: the rate of the two masses for every delay in [0.2 s, 0.6 s]."""
    ex = thesis.delay_example_2()
    A, Ad = delayed_loop(*descriptors(ex.plant, ex.U), ex.K)
    true, _ = slowest_decay(A, Ad, ex.tau - ex.mu, ex.tau + ex.mu)
    proven = _largest("delta", ex, true, mu=ex.mu)
    what, how = "two masses: rate", "interval functional, order 1"
    return Best(what, " 1/s", ex.delta, proven, true, how, "17_wing_and_two_masses")


@cache
def norm(number):
    """A `Best`: the norm of Example ``number``, 1, 2 or 3, with the printed gains."""
    ex = getattr(thesis, f"example_{number}")()
    asked = dict(K_A=ex.K_A, minimize="gamma", coupling="pairs")
    found = analyse_pid(ex.plant, ex.K, ex.U, **asked)
    if not found.certify().proven:
        raise ValueError(f"gamma = {found.gamma} isn't proven for Example {number}")
    what, how = f"Example {number}: norm from w to z", "bounded real lemma, free mu"
    chapter = "27_what_gamma_measures"
    return Best(what, "", ex.gamma, found.gamma, found.hinf(), how, chapter)
