"""Where the poles of one plant may go: places that keep all that is asked of poles."""

from dataclasses import dataclass

import numpy as np
from flint import arb, fmpq, fmpq_poly

from ..exact.algebraic import roots_of
from ..exact.definite import exact
from ..runtime.time_limit import check_time

__all__ = ["Mode", "dyadic", "goals", "modes_of", "real_places"]

ROOT_BITS = 512  # of the modes that stay
GRID = np.geomspace(1e-6, 1e6, 241)  # of places, relative to a rate
LEFT = np.geomspace(1e-6, 1e4, 61)  # how far left of the axis, relative to a mode
FAMILIES = (  # whether all modes move, how far beyond the edge of the region
    *((False, depth) for depth in (0.1, 0.3, 1.0, 3.0, 0.03, 0.01)),
    *((True, depth) for depth in (0.1, 0.3, 1.0)),
)
STEPS = 0.1  # between poles in a row on the real axis, relative
ROWS = 8  # at most, of poles on the real axis
FASTEST_ROW = 30.0  # times the fastest mode
FILLED = 0.8  # of a region in which poles are spread


def real_places(request):
    """Places on the real axis that keep all that a request asks of poles.

    Parameters
    ----------
    request : Request
        Of one plant.

    Returns
    -------
    list of float
        Some of them, in rad/s, the nearest to zero first.
    """
    rates = [r.rate()[1] for r in request.demands if r.rate()]
    rates.append(max(map(abs, np.linalg.eigvals(request.mean.state_space()[0]))))
    rates = {float(rate) for rate in rates if 0 < rate < np.inf}
    rough = (r.rough_rate() for r in request.demands)
    rates = rates or set(filter(None, rough)) or {1.0}
    sizes = np.sort(np.concatenate([rate * GRID for rate in rates]))
    inside = [float(-x) for x in sizes if _holds(request, float(-x))]
    return inside or [x for x in _deepest(request, sizes) if _holds(request, x)]


def _deepest(request, sizes):
    """The negative number that keeps the regions best.

    Each asks alpha + (beta + beta') x < 0, whose largest eigenvalue is convex: its
    least is found by cutting an interval into three.
    """
    forms = [r.pole_matrices() for r in request.demands]
    if None in forms:
        return
    forms = [tuple(np.asarray(x, float) for x in form) for form in forms]

    def worst(t):
        x = -np.exp(t)
        return max(np.linalg.eigvalsh(a + (b + b.T) * x)[-1] for a, b in forms)

    low, high = np.log(sizes[0]), np.log(sizes[-1])
    for _ in range(120):
        one, two = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, two) if worst(one) < worst(two) else (one, high)
    yield float(-np.exp(low))


def _holds(request, s):
    """Whether a pole at a number s of floats keeps what is asked."""
    check_time()
    root = roots_of(fmpq_poly([*_factor(s), 1]))[0]
    return all(r.holds_at(root) is True for r in request.demands)


def _factor(s):
    """The real polynomial with the root s in rationals, without its leading 1."""
    re, im = exact(float(np.real(s))), exact(float(np.imag(s)))
    return (-re,) if im == 0 else (re * re + im * im, -2 * re)


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of a plant, in the upper half-plane or real.

    Parameters
    ----------
    s : complex or float
        The mode, in rad/s.
    factor : tuple of fmpq
        The real polynomial with this root, without its leading 1.
    stays : bool
        Whether it is where it should be.
    """

    s: complex
    factor: tuple
    stays: bool


def modes_of(request, A):
    """The modes of a rational matrix A, each as often as it counts.

    The ``request`` says which of them may stay.
    """
    modes = []
    for polynomial, times in A.charpoly().factor_squarefree()[1]:
        for root in roots_of(polynomial):
            check_time()
            ball = root.ball(ROOT_BITS)
            if ball.imag < 0:
                continue
            s, real = complex(root), ball.imag.contains(0)
            re, im = dyadic(ball.real), dyadic(ball.imag)
            factor = (-re,) if real else (re * re + im * im, -2 * re)
            stays = all(r.holds_at(root) is True for r in request.demands)
            modes += [Mode(s.real if real else s, factor, stays)] * times
    return modes


def dyadic(ball):
    """The middle of a real ball in rationals."""
    mantissa, exponent = map(int, arb(ball).mid().man_exp())
    return fmpq(mantissa) * fmpq(2) ** exponent


def goals(request, modes, places):
    """Where the modes may go, the gentlest way first.

    Parameters
    ----------
    request : Request
        Of one plant.
    modes : list of Mode
        All of its modes.
    places : list of float
        See `real_places`; at least one.

    Yields
    ------
    list of tuples of fmpq
        The factors of the polynomial of the poles, without their leading ones.
    """
    centre = _centre(request, places)
    sizes = [abs(m.s) for m in modes if m.s] or [abs(centre)]
    for all_move, depth in FAMILIES:
        factors = []
        for k, m in enumerate(modes):
            deep = depth * (1 + k / len(modes))  # poles don't meet
            stays = m.stays and not all_move
            factors.append(
                m.factor if stays else _near(request, m.s, deep, centre, min(sizes))
            )
        if None not in factors:
            yield factors
    count = sum(len(m.factor) for m in modes)
    slow = [x for x in places if -x < FASTEST_ROW * max(sizes)]
    for place in slow[:: 1 + len(slow) // ROWS]:
        row = [place * (1 + STEPS * (k + 2)) for k in range(count)]
        if _holds(request, row[0]) and _holds(request, row[-1]):
            yield [_factor(x) for x in row]
    pairs = count // 2
    middle = [_factor(centre)] * (count % 2)
    yield middle + _spread(request, centre, np.exp(1j * np.pi * _between(pairs)), 1.0)
    yield middle + _spread(request, centre, np.full(pairs, 1j), _between(pairs))


def _between(count):
    return (np.arange(count) + 0.5) / count


def _centre(request, places):
    """A place well inside the region, but not much faster than it has to be."""
    slow = _edge(request, places[0], 0.0)
    fast = max(places[-1], 3 * slow)
    return (slow + _edge(request, fast, 2 * fast)) / 2


def _edge(request, inside, outside):
    """The last point inside on the way from one inside to one outside."""
    for _ in range(30):
        middle = (inside + outside) / 2
        if _holds(request, middle):
            inside = middle
        else:
            outside = middle
    return inside


def _spread(request, centre, directions, shares):
    """Factors of places around a centre, as far as the region allows, in shares."""
    factors = []
    for direction, share in zip(directions, np.broadcast_to(shares, len(directions))):
        reach = abs(centre)
        while not _holds(request, centre + reach * direction):
            reach /= 1.2
        factors.append(_factor(centre + FILLED * share * reach * direction))
    return factors


def _near(request, s, depth, centre, slowest):
    """The factor of a place inside, near a mode s; None where none was found.

    Straight left of it, or on the way to the centre.
    """
    size, tries = abs(s) or slowest, []
    for x in -size * LEFT:
        if x < np.real(s) and _holds(request, complex(x, np.imag(s))):
            left = min(x * (1 + depth), -depth * size)
            tries.append(complex(left, np.imag(s)))
            break
    inside = s if _holds(request, s) else _edge(request, centre, s)
    tries.append(inside + min(depth, 0.9) * (centre - inside))
    for place in tries:
        if _holds(request, place):
            return _factor(place)
    return None
