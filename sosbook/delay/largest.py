"""How far a delay or a decay rate can be pushed with a certificate."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..exact.definite import round_digits
from ..exact.rational import digit_count
from ..loops import Loop, opened
from ..plants.checks import is_word
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds
from ..runtime.time_limit import time_limit as limited
from .design import DelayDesign
from .inner_points import alphas
from .request import DelayRequest, check_loop
from .solve import centred_design, first_design, without_alpha
from .spectrum import checked_pair, delayed_loop, rightmost_real

SURELY = 1e-6  # of a loop's size: no root is as far from where it is computed


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest value of a parameter that has a certificate.

    Parameters
    ----------
    name : {"tau", "mu", "delta"}
    value : float or None
        The largest one that has a certificate; None where even a tiny one has none.
    beyond : float or None
        The next round number, which wasn't found to have one; None where
        the parameter's own limit was reached (mu = tau).
    found : DelayDesign or None
        Some design at ``value``, as the search came upon it.
    refused : DelayDesign or None
        At ``beyond``: "infeasible" where it is proven exactly that there is no
        certificate, "undecided" where the search gave up; then its ``reason`` says why.
    """

    name: str
    value: float | None = None
    beyond: float | None = None
    found: DelayDesign | None = None
    refused: DelayDesign | None = None

    @cached_property
    def design(self):
        """The centred `DelayDesign` at ``value``, computed when it is read, or None."""
        return None if self.found is None else centred_design(self.found)

    @property
    def proven(self):
        """True if it is proven that ``beyond`` has no proof."""
        return self.refused is not None and self.refused.status == "infeasible"

    def __repr__(self):
        if self.value is None:
            return f"<Largest: no {self.name} was found to have one, {self._end()}>"
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
):
    """Find the largest tau, mu or delta that still has a certificate.

    Parameters
    ----------
    name : {"tau", "mu", "delta"}
        Its own argument says where to start from, with small steps: a value near the
        answer saves most of the search. The others are held.
    plant : SecondOrderSystem, Polytope, Uncertain, Loop or DelayedLoop
        Of a plant, gains are designed at each value, as `design_delay_pid` does; a
        loop is analysed as it is.
    U, tau, mu, delta
        As in `design_delay_pid` and `analyse_delay`.
    alpha : float, optional
        In seconds. Without it every value is tried with several multiples of its tau.
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

    Returns
    -------
    Largest
        Found by bisection. The feasible side is certified. Of the other
        side ``proven`` says whether a certificate is excluded.

    Raises
    ------
    ValueError
        On bad input, an unknown name, or a Loop with a clock.

    Examples
    --------
    >>> from sosbook.delay import DelayedLoop
    >>> loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    >>> largest("tau", loop, tau=1, method="legendre", order=1, digits=3)
    <Largest: tau = 6.05 has a certificate, 6.06 is proven to have none>
    """
    if not is_word(name, ("tau", "mu", "delta")):
        raise ValueError(f'name must be "tau", "mu" or "delta", got {name!r}')
    digits = digit_count(digits)
    check_loop(plant, None, U)
    K = None
    if isinstance(plant, Loop):
        if plant.clock is not None or U is not None:
            raise ValueError(
                "plant: a Loop says what it integrates, and has no clock here: leave U "
                f'out, or ask loop.late(tau).largest("{name}")'
            )
        plant, K, U = opened(plant.plant, plant.gains, law=plant.law)
    given = DelayRequest(plant, U, tau, mu, delta, alpha, method, order, gain=K)
    return _Search(name, given, digits, time_limit).run(refuse)


class _Search:
    """Growing steps and bisection over round numbers. The first step doubles a value
    that nobody gave, and moves a given one by some of its last digits.

    Where alpha is searched it goes on with one that holds; the others have to be
    refused only where that one ends.
    """

    def __init__(self, name, given, digits, seconds):
        self.name, self.given, self.digits = name, given, digits
        self.seconds = checked_seconds(seconds)
        self.limit = given.tau if name == "mu" else float("inf")
        self.step = 1 + 10.0 ** (1 - digits) if getattr(given, name) else 2.0
        self.known, self.hopeless = {}, set()  # designs by value and place of alpha
        self.places, self.place = range(len(alphas(given))), 0

    def run(self, refuse):
        """The `Largest`; what is known where the time is over."""
        try:
            with limited(self.seconds):
                low, high = self._bracket()
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
        found = None if low is None else self._at(low, self.place)
        return Largest(self.name, low, high, found, refused)

    def _known(self):
        """The largest feasible value so far, and the next one to look at."""
        good = [key for key, d in self.known.items() if d.status == "feasible"]
        low, self.place = max(good, default=(None, 0))
        tried = {*(value for value, _ in self.known), *self.hopeless}
        bad = [v for v in tried if low is None or v > low]
        step = self._start() if low is None else self._near(2 * low)
        return low, min(bad, default=min(step, self.limit))

    def _bracket(self):
        """The largest feasible number and the next one, or None for either."""
        start = low = high = self._start()
        step = self.step
        while not self._feasible(low):
            high, low, step = low, self._near(low / step), min(step**2, 2.0)
            if low < 1e-4 * start:
                return None, high
        while True:
            low, high = self._edge(low, high, start)
            if high is None or not self._feasible(high):
                return low, high
            low = high

    def _edge(self, low, high, start):
        """The same for the alpha that holds at ``low``."""
        place, step = self.place, self.step
        while high < self.limit and self._holds(high, place):
            low, high = high, min(self._near(step * high), self.limit)
            step = min(step**2, 2.0)
            if high > 1e4 * start:
                return low, None
        if self._holds(high, place):  # the limit itself
            return high, None
        while (middle := self._near((low + high) / 2)) not in (low, high):
            good = self._holds(middle, place)
            low, high = (middle, high) if good else (low, middle)
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
        """True if an alpha holds at a value: the first one is tried from now on."""
        held = next((k for k in self.places if self._holds(value, k)), None)
        self.place = self.place if held is None else held
        return held is not None

    def _holds(self, value, place):
        if (value, place) not in self.known and value not in self.hopeless:
            if _too_slow(self._request(value)):
                self.hopeless.add(value)
        good = value not in self.hopeless
        return good and self._at(value, place).status == "feasible"

    def _at(self, value, place):
        """The design at a value, for the alpha at a place."""
        if (value, place) not in self.known:
            request = self._request(value)
            self.known[value, place] = first_design(
                request.at(alpha=alphas(request)[place]), refuse=False, centred=False
            )
        return self.known[value, place]

    def _refused(self, value, refuse):
        """The verdict there, with a proof if one is found."""
        if len(self.places) > 1:
            return without_alpha(self._request(value))
        if not refuse:
            return self._at(value, self.place)
        again = first_design(self._request(value))
        return again if again.status != "feasible" else self._at(value, self.place)


def _too_slow(request):
    """True if a given gain's loop is too slow at an end of the delay's interval.

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
