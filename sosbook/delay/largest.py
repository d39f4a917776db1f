"""How far a delay or a decay rate can be pushed with a certificate."""

from dataclasses import dataclass

import numpy as np

from ..lmi.exact import round_digits
from ..lmi.rational import digit_count
from ..lmi.time_limit import OutOfTime
from ..lmi.time_limit import time_limit as limited
from ..runtime.threads import one_thread
from .design import DelayDesign
from .request import DelayRequest, check_loop
from .solve import centred_design, first_design
from .spectrum import checked_pair, delayed_loop, rightmost_real

__all__ = ["Largest", "largest"]

SURELY = 1e-6  # of a loop's size: no root is as far from where it is computed


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest value of a parameter that has a certificate.

    Parameters
    ----------
    name : {"tau", "mu", "delta"}
    value : float or None
        The largest one that has a certificate; None where even a tiny
        one has none.
    beyond : float or None
        The next round number, which wasn't found to have one; None where
        the parameter's own limit was reached (mu = tau).
    design : DelayDesign or None
        At ``value``.
    refused : DelayDesign or None
        At ``beyond``: "infeasible" where it is proven exactly that there
        is no certificate, "undecided" where the search gave up; then its
        ``reason`` says why.
    """

    name: str
    value: float | None = None
    beyond: float | None = None
    design: DelayDesign | None = None
    refused: DelayDesign | None = None

    @property
    def proven(self):
        """Whether it is proven that ``beyond`` has no certificate."""
        return self.refused is not None and self.refused.status == "infeasible"

    def __repr__(self):
        return f"<Largest: {self.name} = {self.value} has a certificate, {self._end()}>"

    def _end(self):
        if self.beyond is None:
            return "which is its own limit"
        if self.proven:
            return f"{self.beyond} is proven to have none"
        return f"gave up at {self.beyond}: {self.refused.reason}"


@one_thread
def largest(
    name,
    plant,
    K=None,
    U=None,
    tau=None,
    mu=0.0,
    delta=0.0,
    alpha=None,
    method="functional",
    order=None,
    digits=2,
    refuse=True,
    time_limit=None,
    progress=False,
):
    """Find the largest tau, mu or delta that still has a certificate.

    Parameters
    ----------
    name : {"tau", "mu", "delta"}
        Its own argument says where to start from; the others are held.
    plant
        As in `design_delay_pid`.
    K : (m, N) array_like, optional
        Analyse this gain; design one at each value without it.
    U, tau, mu, delta
        As in `design_delay_pid` and `analyse_delay`.
    alpha : float, optional
        In seconds. Without it every value is tried with several
        multiples of its tau.
    method, order
        As in `analyse_delay`.
    digits : int
        The answer is a number of so many significant digits.
    refuse : bool
        Look for an exact proof that the next number has no certificate;
        that may take longer than all the rest.
    time_limit : float, optional
        In seconds, for the whole search. The answer is the largest value
        found until then.
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    Largest
        Found by bisection. The feasible side is certified. Of the other
        side ``proven`` says whether a certificate is excluded.

    Raises
    ------
    ValueError
        On bad input, or an unknown name.

    Examples
    --------
    >>> from sosbook.delay import DelayedLoop
    >>> loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    >>> largest("tau", loop, tau=1, method="legendre", order=1, digits=3)
    <Largest: tau = 6.05 has a certificate, 6.06 is proven to have none>
    """
    if name not in ("tau", "mu", "delta"):
        raise ValueError(f'name must be "tau", "mu" or "delta", got {name!r}')
    digits = digit_count(digits)
    check_loop(plant, K, U)
    given = DelayRequest(plant, U, tau, mu, delta, alpha, method, order, gain=K)
    return _Search(name, given, digits, time_limit).run(refuse, progress)


class _Search:
    """Doubling and bisection over round numbers.

    Parameters
    ----------
    name : str
    given : DelayRequest
    digits : int
    seconds : float or None
        The time limit.
    """

    def __init__(self, name, given, digits, seconds):
        if seconds is not None and not seconds > 0:
            raise ValueError(f"time_limit must be positive, got {seconds!r}")
        self.name, self.given, self.digits = name, given, digits
        self.seconds = seconds
        self.limit = given.tau if name == "mu" else float("inf")
        self.known, self.hopeless = {}, set()

    def run(self, refuse, progress):
        """The `Largest`; what is known where the time is over."""
        try:
            with limited(self.seconds, progress):
                low, high = self._bracket()
                if low is not None:
                    self.known[low] = centred_design(self.known[low])
                refused = None if high is None else self._refused(high, refuse)
        except OutOfTime:
            if self.seconds is None:  # somebody else's limit
                raise
            low, high = self._known()
            refused = DelayDesign(
                self._request(high),
                "undecided",
                self.given.gain,
                reason=f"stopped after {self.seconds:g} s",
            )
        return Largest(self.name, low, high, self.known.get(low), refused)

    def _known(self):
        """The largest feasible value so far, and the next one to look at."""
        good = [v for v, d in self.known.items() if d.status == "feasible"]
        low = max(good, default=None)
        tried = {*self.known, *self.hopeless}
        bad = [v for v in tried if low is None or v > low]
        step = self._start() if low is None else self._near(2 * low)
        return low, min(bad, default=min(step, self.limit))

    def _bracket(self):
        """The largest feasible number and the next one, or None for either."""
        start = low = high = self._start()
        while not self._feasible(low):
            high, low = low, self._near(low / 2)
            if low < 1e-4 * start:
                return None, high
        while high < self.limit and self._feasible(high):
            low, high = high, min(self._near(2 * high), self.limit)
            if high > 1e4 * start:
                return low, None
        if self._feasible(high):  # the limit itself
            return high, None
        while (middle := self._near((low + high) / 2)) not in (low, high):
            low, high = (middle, high) if self._feasible(middle) else (low, middle)
        return low, high

    def _start(self):
        unit = self.given.tau if self.name == "mu" else 1 / self.given.tau
        start = getattr(self.given, self.name) or 0.1 * unit
        return self._near(min(start, self.limit))

    def _near(self, value):
        return float(round_digits(value, self.digits))

    def _request(self, value):
        return self.given.at(**{self.name: value})

    def _feasible(self, value):
        if value not in self.known and value not in self.hopeless:
            if _too_slow(self._request(value)):
                self.hopeless.add(value)
        return value not in self.hopeless and self._at(value).status == "feasible"

    def _at(self, value):
        """The design at a value."""
        if value not in self.known:
            self.known[value] = first_design(
                self._request(value), refuse=False, centred=False
            )
        return self.known[value]

    def _refused(self, value, refuse):
        """The verdict there, with a proof if one is found."""
        if not refuse:
            return self._at(value)
        again = first_design(self._request(value))
        return again if again.status != "feasible" else self._at(value)


def _too_slow(request):
    """Whether a given gain's loop is too slow at an end of the delay's interval.

    It has no certificate then, and its roots take less time than the LMIs.
    """
    if request.gain is None:
        return False
    for vertex in request.vertices:
        A, A_d = checked_pair(*delayed_loop(vertex, request.gain))
        doubt = SURELY * (np.linalg.norm(A) + np.linalg.norm(A_d))
        for delay in {request.tau + request.mu, request.tau - request.mu}:
            try:
                if rightmost_real(A, A_d, delay) > doubt - request.delta:
                    return True
            except ValueError:  # it is too long for the discretisation
                continue
    return False
