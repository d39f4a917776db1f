"""Best known values: what the sharpest test of the package proves, and what is false.

Prose, errata and exercises read these here, so that they can't fall behind a
sharper method: a test asks every method of the package for more.
"""

from dataclasses import dataclass
from functools import cache

from ..delay import delayed_loop, largest, slowest_decay
from ..plants.descriptor import descriptors
from . import thesis

__all__ = ["RATES", "SHARPEST", "Width", "wing"]

#: The method that proves the most for the wing's printed gains.
SHARPEST = {"method": "interval", "order": 1}
#: The rates that the book asks for, in 1/s: the thesis's, half of it, stability.
RATES = (0.6, 0.3, 0.0)


@dataclass(frozen=True)
class Width:
    """How far a delay may move around its nominal value while a loop keeps a rate.

    ``rate``: the rate of decay, in 1/s; ``tau``: the nominal delay, in s; ``proven``:
    the largest mu with a certificate, in s, of three digits; ``false``: from this mu
    on, in s, a constant delay of [tau - mu, tau + mu] makes the loop slower than the
    rate.
    """

    rate: float
    tau: float
    proven: float
    false: float

    @property
    def share(self):
        """The part of the widths on which the rate can be true that is proven."""
        return self.proven / self.false

    def __repr__(self):
        return (
            f"<rate {self.rate}: mu = {self.proven} s "
            f"({self.proven / self.tau:.3f} tau) proven, "
            f"{self.false:.4f} s ({self.false / self.tau:.3f} tau) false>"
        )


@cache
def wing(rate):
    """The `Width` of the published wing with the thesis's gains, at a rate in 1/s.

    Raises ``ValueError`` where no certificate can be proven.

    Examples
    --------
    >>> wing(0.6)
    <rate 0.6: mu = 0.0338 s (0.169 tau) proven, 0.0399 s (0.200 tau) false>
    """
    ex = thesis.delay_example_1(published=True)
    found = largest(
        "mu",
        ex.plant,
        K=ex.K,
        U=ex.U,
        tau=ex.tau,
        mu=0.05,
        delta=rate,
        digits=3,
        refuse=False,
        **SHARPEST,
    )
    if not found.design.certify().proven:
        raise ValueError(f"mu = {found.value} s isn't proven for the rate {rate}")
    (plant,) = descriptors(ex.plant, ex.U)
    A, Ad = delayed_loop(plant, ex.K)
    low, high = 0.0, ex.tau
    while high - low > 1e-5:
        middle = (low + high) / 2
        kept = slowest_decay(A, Ad, ex.tau - middle, ex.tau + middle)[0] >= rate
        low, high = (middle, high) if kept else (low, middle)
    return Width(rate, ex.tau, found.value, high)
