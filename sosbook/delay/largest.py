"""How far a delay or a decay rate can be pushed with a certificate."""

from dataclasses import dataclass

from ..lmi.exact import round_digits
from .design import ALPHAS, DelayDesign, solve_delay
from .request import DelayRequest, check_loop

__all__ = ["Largest", "largest"]


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest value of a parameter that has a certificate.

    Parameters
    ----------
    name : {"tau", "mu", "delta"}
    value : float or None
        The largest one found; None where even a tiny one has none.
    beyond : float or None
        The next round number, for which a quick search found none; None
        where the parameter's own limit was reached (mu = tau).
    design : DelayDesign or None
        At ``value``.
    """

    name: str
    value: float = None
    beyond: float = None
    design: DelayDesign = None

    def __repr__(self):
        return (f"<Largest: {self.name} = {self.value} has a certificate, "
                f"none found for {self.beyond}>")


def largest(name, plant, K=None, U=None, tau=None, mu=0.0, delta=0.0,
            alpha=None, method="functional", order=2, digits=2):
    """Find the largest tau, mu or delta that still has a certificate.

    Parameters
    ----------
    name : {"tau", "mu", "delta"}
        Its own argument says where to start from; the others are held.
    plant, U, tau, mu, delta, method, order
        As in `design_delay_pid` and `analyse_delay`.
    K : (m, N) array_like, optional
        Analyse this gain; design one at each value without it.
    alpha : float, optional
        In seconds. Without it every value is tried with several
        multiples of its tau.
    digits : int
        The answer is a number of so many significant digits.

    Returns
    -------
    Largest
        Found by bisection. The feasible side is certified. The other
        one isn't excluded: close to the edge `solve_delay`, which looks
        longer, may still find a certificate.

    Raises
    ------
    ValueError
        On bad input, or an unknown name.

    Examples
    --------
    >>> from sosbook.delay import DelayedLoop
    >>> loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    >>> largest("tau", loop, tau=1, method="legendre", order=1, digits=3)
    <Largest: tau = 6.05 has a certificate, none found for 6.06>
    """
    if name not in ("tau", "mu", "delta"):
        raise ValueError(
            f'name must be "tau", "mu" or "delta", got {name!r}')
    if not isinstance(digits, int) or isinstance(digits, bool) or digits < 1:
        raise ValueError(f"digits must be 1 or more, got {digits!r}")
    check_loop(plant, K, U)
    given = DelayRequest(
        plant, U, tau, mu, delta, alpha, method, order, gain=K)
    limit = given.tau if name == "mu" else float("inf")
    known = {}

    def design(value):
        if value not in known:
            known[value] = _first(given.at(**{name: value}))
        return known[value]

    start = getattr(given, name) or 0.1 * (
        given.tau if name == "mu" else 1 / given.tau)
    low = high = _near(min(start, limit), digits)
    while design(low) is None:
        high, low = low, _near(low / 2, digits)
        if low < 1e-4 * start:
            return Largest(name, beyond=high)
    while high < limit and design(high) is not None:
        low, high = high, min(_near(2 * high, digits), limit)
        if high > 1e4 * start:
            return Largest(name, low, None, design(low))
    if design(high) is not None:  # the limit itself
        return Largest(name, high, None, design(high))
    while (middle := _near((low + high) / 2, digits)) not in (low, high):
        if design(middle) is None:
            high = middle
        else:
            low = middle
    return Largest(name, low, high, design(low))


def _near(value, digits):
    return float(round_digits(value, digits))


def _first(request):
    """The first design along the search of alpha, or None."""
    if request.alpha is not None or not request.needs_alpha:
        requests = [request]
    else:
        requests = [
            request.at(alpha=_near(request.tau * ratio, 2))
            for ratio in ALPHAS
        ]
    for each in requests:
        found = solve_delay(each, refuse=False)
        if found.status == "feasible":
            return found
    return None
