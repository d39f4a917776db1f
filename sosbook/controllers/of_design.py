"""From a design to its controller: what is measured, and how the rest is estimated."""

from dataclasses import dataclass, replace

import numpy as np

from ..exact.rational import round_digits
from ..plants.checks import positive
from ..plants.gain import Gain, input_names, signals
from ..plants.simplex import random_weights
from ..sampled.ticks import Ticks
from .clock import clock_of, least_slack, timing_of, vertices_of, warn_of_long_ticks
from .controller import Controller
from .limits import Faults, Limits, quantum
from .memory import DIGITS, assembled, direct, filtered, kalman, observed
from .of_law import law_memory, law_sensors
from .set_points import quiet_set_point
from .signals import Readings, signals_of

MEMORIES = ("observer", "filter")
BETWEEN = 4  # random plants between the vertices that a search looks at, too
FINE = 1e-6  # of a unit: how fine is measured what nobody said
SHARE_OF_DECAY = 0.5  # of the decay rate with everything measured: an observer keeps it
CURE = "Sample faster, or ask the design for less"
DEAREST_PEAK = 10.0  # of the complementary sensitivity that any controller has
#: How much more the process is doubted than the sensors, in the order of trial.
DOUBTS = tuple(10.0**k for k in np.arange(-2, 7, 0.5))


def controller_of(
    design,
    measured=None,
    *,
    T=None,
    delay=0.0,
    jitter=0.0,
    units=None,
    counts=None,
    memory=None,
    filter_time=None,
    peak=2.0,
    time_limit=None,
):
    """The `Controller` of a design.

    Parameters
    ----------
    design : Design
        Or another result with a gain.
    measured, T, delay, jitter, units, counts, memory, filter_time, peak, time_limit
        As in `Gains.controller`, which calls this.
    """
    request = design.request
    plant, U = request.plant, request.U
    if design.K is None:
        raise ValueError(
            f"the design is {design.status}: there is no gain to make a controller of; "
            f"its reason says why. {design.reason}"
        )
    clock = clock_of(plant, T, delay, jitter)
    T, delay = clock.T, clock.latest
    K_A = getattr(request, "K_A", None)  # no loop with a delay has one
    if K_A is not None and np.any(K_A):
        raise ValueError(
            "the design has an acceleration gain K_A, which no sampled controller "
            "holds: design without"
        )
    names = signals(plant)
    vertices = vertices_of(plant)
    (N, m), n = vertices[0].Bu.shape, vertices[0].n  # no coordinates: n is zero
    outputs = input_names(m)
    law, known = request.law, names[: n or N]
    if law.whole:
        wanted, rows = _measured(measured, names)
        noise = np.zeros((len(rows), plant.p))
    else:
        given = measured, memory, filter_time
        wanted, rows, noise, places = law_sensors(law, plant, *given)
        known = (*known, *(x for x in wanted if x not in names))
    units = _units(units, known, outputs)
    seen = signals_of(wanted, units)
    steps = quantum(counts, seen)
    certificate = design.certify(time_limit=time_limit)
    at_ticks = getattr(design, "at_ticks", False)
    K = design.K if at_ticks else round_digits(design.K, DIGITS)
    if certificate.proven and not at_ticks:
        K = certificate.K
    timing = timing_of(plant, T, delay)
    stepped = timing.steps
    check_rate(vertices, timing)
    if not (at_ticks or stepped):
        warn_of_long_ticks(design, T)
    if not law.whole:
        estimate, gain, sums = law_memory(law, plant, K, T, at_ticks, stepped)
        U = sums[:, :places]
        R = quiet_set_point(U, gain.K[:, :places])
    else:
        gain, sums = Gain(np.asarray(K, float), design.gain.signals), _sums(U, rows)
        R = np.zeros((0, 0))
        if n:
            U_z = _integrated(U, rows, names[:n], wanted)
            R = quiet_set_point(U_z, gain.K[:, :n])
    free = np.full(m, np.inf)
    limits = Limits(free, free, np.full(R.shape[1], np.inf))
    faults = Faults(slack=max(Faults.slack, least_slack(clock)))
    readings = Readings(seen, rows, noise, steps)
    whole = readings, clock, U, sums, R, limits, faults, units, certificate

    def made(estimate):
        return Controller(plant, gain, estimate, *whole)

    plants = (*vertices, *between(vertices))
    if not law.whole:
        return made(estimate)
    kind = _kind(memory, filter_time, rows, n)
    if kind == "direct":
        return made(direct(rows, m))
    if kind == "filter":
        tracking = 0.0 if filter_time == 0 else positive("filter_time", filter_time)
        return made(filtered(rows, n, m, T, tracking, names))
    _observable(vertices, rows, names, T if stepped else None)
    gains = _gains(gain.K, N, U, rows, T, R)
    known = [(w, _mixed(vertices, w)) for w in np.eye(len(vertices))]
    if len(vertices) > 1:
        middle = np.full(len(vertices), 1 / len(vertices))
        known = [(middle, _mixed(vertices, middle)), *known]
    full = _gains(gain.K, N, U, np.eye(N), T, R)
    parts, _ = assembled(direct(np.eye(N), m), timing, *full)
    at_best = max(Ticks.of(parts, np.eye(N), timing, d).radius for d in plants)
    if at_best >= 1:
        raise ValueError(
            f"at T = {T:g} s, delay = {delay:g} s this gain is unstable even if "
            f"everything is measured: spectral radius {at_best:.4f}. {CURE}"
        )
    fine, worst = np.where(steps > 0, steps, FINE), positive("peak", peak)
    worst = worst, at_best**SHARE_OF_DECAY
    found = chosen_observer(plants, known, timing, rows, fine, names, gains, *worst)
    if found is None:
        raise ValueError(
            f"no observer that was tried keeps every loop stable with this gain at T = "
            f"{T:g} s, delay = {delay:g} s. {CURE}"
        )
    _, chosen = found
    d, M = _mixed(vertices, chosen.weights), round_digits(chosen.M, DIGITS)
    return made(replace(observed(d, timing, rows, M, names), chosen=chosen))


def between(vertices):
    """Some plants between several vertices, the same ones each time."""
    if len(vertices) == 1:
        return ()
    weights = random_weights(len(vertices), BETWEEN, 0)
    return tuple(_mixed(vertices, w) for w in weights)


def check_rate(vertices, timing):
    """Refuse a clock (``timing``) with which no controller has a reasonable loop.

    An unstable pole p of the ``vertices`` and d + 1 ticks from a sample to its effect
    leave a complementary sensitivity of at least e^(p T (d + 1)): T(z) is 1 at z =
    e^(pT), z^(d+1) T(z) is analytic outside the unit circle, and the maximum modulus
    principle. A plant of discrete time has its poles z itself, and is what it is.
    """
    whole = timing.whole_samples + 1
    for d in vertices if not timing.steps else ():
        p = max(0.0, np.linalg.eigvals(np.linalg.solve(d.E, d.A)).real.max())
        least = np.exp(p * float(timing.T) * whole)
        if least > DEAREST_PEAK:
            raise ValueError(
                f"no controller can do it at T = {float(timing.T):g} s: with the "
                f"plant's unstable pole at {p:.4g} rad/s and {whole} ticks to act "
                f"every one has a complementary sensitivity of at least {least:.3g} "
                f"(the limit here is {DEAREST_PEAK:g}); sample faster"
            )


def _kind(memory, filter_time, rows, n):
    """The kind of estimate: "direct" (all is measured), "filter" or "observer"."""
    if memory is not None and memory not in MEMORIES:
        raise ValueError(f"memory must be one of {MEMORIES}, got {memory!r}")
    if filter_time is not None and memory == "observer":
        raise ValueError("filter_time is for a filter: leave it, or memory, out")
    if filter_time is not None or memory == "filter":
        if filter_time is None:
            raise ValueError("filter_time is missing: the filter's time constant, in s")
        if not n or not rows[:, :n].any(axis=0).all():
            raise ValueError(
                "a filter gives rates of what is measured, and not every coordinate "
                'is: take memory="observer"'
            )
        return "filter"
    full = rows.shape[0] == rows.shape[1]
    return "direct" if full and memory is None else "observer"


def _observable(vertices, rows, names, step):
    """Raise where a mode of a vertex that isn't stable isn't measured; ``step``: the
    tick of a plant of discrete time.
    """
    for d in vertices:
        A = np.linalg.solve(d.E, d.A)
        for s in np.linalg.eigvals(A):
            pencil = np.vstack([s * np.eye(len(A)) - A, rows])
            sizes = np.linalg.svd(pencil, compute_uv=False)
            where, grows = f"{s:.4g} rad/s", s.real >= -1e-9 * abs(A).max()
            if step is not None:
                z = 1 + step * s
                where, grows = f"z = {z:.4g}", abs(z) >= 1 - 1e-9
            if grows and sizes[-1] < 1e-9 * sizes[0]:
                raise ValueError(
                    f"measured doesn't see the mode at {where}, which isn't stable by "
                    f"itself: measure more of {', '.join(names)}"
                )


def _measured(measured, names):
    """Names of what is measured, and its rows on a plant's state with these names."""
    words = (measured,) if isinstance(measured, str) else measured
    try:
        wanted = tuple(names if words is None else words)
    except TypeError:
        wanted = ()
    known = all(isinstance(word, str) for word in wanted)
    if not wanted or not known or len(set(wanted)) < len(wanted):
        raise ValueError(f"measured must name signals, each once, got {measured!r}")
    if strange := [x for x in wanted if x not in names]:
        raise ValueError(
            f"measured names {strange[0]!r}, which is none of {', '.join(names)}"
        )
    return wanted, np.array([[float(x == name) for name in names] for x in wanted])


def _integrated(U, rows, names, wanted):
    """The rows of U that are integrated; raises where a coordinate isn't measured."""
    U = np.zeros((0, len(names))) if U is None else np.asarray(U, float)
    for k, name in enumerate(names):
        if U[:, k].any() and not rows[:, k].any():
            raise ValueError(
                f"{name} is integrated but isn't measured: integrate what is "
                f"measured ({', '.join(wanted)}), or measure {name}"
            )
    return U


def _sums(U, rows):
    """The integrated rows, on the measured signals."""
    if U is None:
        return np.zeros((0, len(rows)))
    return np.asarray(U, float) @ rows[:, : np.shape(U)[1]].T


def _gains(K, N, U, rows, T, R):
    return K[:, :N], K[:, N:], _sums(U, rows), T, -K[:, : len(R)] @ R


def _mixed(vertices, weights):
    """The mixture of some vertices in descriptor form."""
    parts = zip(*((v.E, v.A, v.Bu, v.Bw) for v in vertices))
    means = (sum(w * x for w, x in zip(weights, some)) for some in parts)
    return replace(vertices[0], **dict(zip(("E", "A", "Bu", "Bw"), means)))


def _units(units, coordinates, outputs):
    known = {} if units is None else units
    texts = isinstance(known, dict) and {*map(type, known.values())} <= {str}
    if not texts:
        raise ValueError(
            f"units must be a dict of texts, {{{outputs[0]!r}: 'N'}}, got {units!r}"
        )
    for name in known:
        if name not in (*coordinates, *outputs):
            raise ValueError(
                f"units names {name!r}, which is none of "
                f"{', '.join((*coordinates, *outputs))}; rates follow from these"
            )
    return known


@dataclass(frozen=True, eq=False)
class Chosen:
    """An observer's gain ``M``, the ``weights`` of the plant that it knows, and the
    worst of its loops: the ``peak`` sensitivity at the plant's input, the largest
    spectral ``radius``, and the largest rms of u under the sensors' steps, ``noise``.
    """

    M: np.ndarray
    weights: np.ndarray
    peak: float
    radius: float
    noise: float


def chosen_observer(plants, known, timing, rows, steps, names, gains, most, slowest):
    """The quietest Kalman filter whose loops, with all ``plants``, keep their peak
    sensitivity below ``most`` and their radius below ``slowest``; else that of the
    lowest peak.

    ``known``, (weights, Descriptor): plants that it may know; ``timing``; ``rows``, (q,
    N) and ``steps``, (q,): what is measured, how fine; ``names`` of the plant's state;
    ``gains``: K_x, K_I, what is integrated, T and K_r of `assembled`. Returns
    (Estimate, Chosen), or None where no candidate keeps all loops stable.
    """
    found = []
    for doubt in DOUBTS:
        for weights, d in known:
            try:
                M = kalman(d, timing, rows, steps, doubt * steps.max())
            except (np.linalg.LinAlgError, ValueError):
                continue
            estimate = observed(d, timing, rows, M, names)
            parts, _ = assembled(estimate, timing, *gains)
            loops = [Ticks.of(parts, rows, timing, one) for one in plants]
            radius = max(loop.radius for loop in loops)
            if not radius < 1:
                continue
            peak = max(loop.sensitivity_peak for loop in loops)
            noise = max(loop.noise_rms(steps).max() for loop in loops)
            found.append((estimate, Chosen(M, weights, peak, radius, noise)))
        if any(c.peak <= most and c.radius <= slowest for _, c in found):
            break  # those that follow are louder
    if not found:
        return None
    good = [x for x in found if x[1].peak <= most and x[1].radius <= slowest]
    if good:
        return min(good, key=lambda pair: pair[1].noise)
    return min(found, key=lambda pair: pair[1].peak)
