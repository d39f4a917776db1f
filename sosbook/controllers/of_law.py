r"""A law's own controller, from tick to tick: its memory, and what its gain multiplies.

Between two samples what is measured is taken to move in a straight line, for a position
does so nearly; of such motions the memory x' = A x + B y is exact. With
:math:`x(k + 1) = \Phi x(k) + \Gamma_1 y(k) + \Gamma_2 y(k + 1)` it is remembered as
:math:`w = x - \Gamma_2 y`, which asks for no sample to come:

.. math::

    w(k + 1) = \Phi w(k) + (\Gamma_1 + \Phi \Gamma_2) y(k), \qquad
    x(k) = w(k) + \Gamma_2 y(k).

Rates of ramps are exact, and a pole s becomes :math:`e^{sT}`; Tustin's rule would bend
the frequencies, and let a filter of less than T/2 ring. What is proven is the loop of
the decimals that come out, so their exponentials need no proof. Integrals are sums, as
in every controller here.

Source: the triangle hold of Franklin, Powell and Workman, Digital Control of Dynamic
Systems, section 6.3.
"""

import numpy as np
from scipy.linalg import expm

from ..exact.rational import exact, inverse
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import Gain
from .memory import Estimate

SAME = 1e-9  # of T: a filter that is as slow as the clock but for rounding
INVERTIBLE = 1e-9  # of the largest singular value: what a memory forgets of readings


def law_sensors(law, plant, measured, memory, filter_time):
    """Names of a ``law``'s sensors, their rows on the ``plant``'s state, how w enters
    them, and how many are of places; a ValueError where it has decided about
    ``measured``, ``memory`` or ``filter_time``.
    """
    parts = law.parts(plant)
    sensors = parts.sensors
    given = (measured,) if isinstance(measured, str) else measured
    if given is not None and tuple(given) != sensors:
        raise ValueError(
            f"measured: the design's law measures {', '.join(sensors)}; leave it out"
        )
    for name, value in (("memory", memory), ("filter_time", filter_time)):
        if value is not None:
            raise ValueError(
                f"{name} is for a gain of the whole state: the design's law has a "
                "memory of its own"
            )
    rows, noise = (np.asarray(x, float) for x in (parts.rows, parts.noise))
    return sensors, rows, noise, _of_places(law, plant, rows)


def _of_places(law, plant, rows):
    """How many sensors are of places alone: they have set points, and come first."""
    first_order, places = isinstance(plant, DescriptorSystem), law.places
    if places is None:
        places = ~rows[:, plant.order if first_order else plant.n :].any(axis=1)
    count = places.sum()
    if not places[:count].all():
        raise ValueError(
            "sensors: set points are of places, whose rows come first: give the rows "
            "of the Output in this order"
        )
    return count


def law_memory(law, plant, K, T, at_ticks=False, steps=False):
    """The `Estimate` that a ``law`` of a ``plant`` remembers every T s, without
    integrals; the `Gain` of its signals, integrals last; and (a, s), what is integrated
    of the sensors. ``K``, (m + free, q), is read as decimals; ``at_ticks``: free
    dynamics are from tick to tick already; ``steps``: the plant is of discrete time,
    and the memory's change in a tick is T (A x + B y), to the letter.
    """
    parts, K = law.parts(plant), exact(np.asarray(K))
    A, B, C, D = parts.controller(K)
    a, l, s = parts.integrals, len(A), len(parts.sensors)
    if A[:a].any() or A[:, :a].any():  # no plain sums: memory as any other
        a = 0
    if not (parts.free or steps):
        _not_too_fast(parts, a, T)
    m = len(C)
    stay, take = parts.of_states, parts.of_sensors
    plain = take[:s] - exact(np.eye(s))
    if plain.any() or stay[:s].any():  # its signals hide the sensors
        K, names = np.hstack([D, C]), (*parts.sensors, *parts.states)
        stay, take = exact(np.eye(s + l, l, -s)), exact(np.eye(s + l, s))
    else:
        names = parts.signals
    kept = [k for k in range(len(take)) if take[k].any() or stay[k, a:].any()]
    gain = Gain(
        np.asarray(np.hstack([K[:m, kept], C[:, :a]]), float),
        (*(names[k] for k in kept), *parts.states[:a]),
    )
    moved = A[a:, a:], B[a:]
    if steps:
        moved = exact(np.eye(l - a)) + exact(T) * moved[0], exact(T) * moved[1]
    flow, push, now, sums = (
        np.asarray(x, float) for x in (*moved, stay[kept, a:], B[:a])
    )
    seen = np.zeros((l - a, s))
    if not (steps or (at_ticks and parts.free)):
        flow, push, seen = _ramped(flow, push, T)
    at_once = np.asarray(take[kept], float) + now @ seen
    start = np.zeros((l - a, s))
    still = np.eye(l - a) - flow
    if not parts.free and l - a == s and _invertible(still, push):
        # in units of the readings at which it rests
        X = np.linalg.solve(still, push)
        flow = np.round(np.linalg.solve(X, flow @ X), 12)
        push, now, start = np.eye(s) - flow, now @ X, np.eye(s)
    lines = "" if steps else ", between samples as for readings in straight lines"
    words = f"{law.words(plant)}{lines}"
    none = np.zeros((l - a, m))
    known = now, at_once, flow, push, none[:, :0], none, start, parts.states[a:], words
    return Estimate(*known, errors=True), gain, sums


def _ramped(A, B, T):
    """Phi, Gamma_1 + Phi Gamma_2 and Gamma_2 of x' = A x + B y for straight y."""
    l, s = B.shape
    whole = np.zeros((l + 2 * s,) * 2)
    whole[:l] = np.hstack([A, B, np.zeros((l, s))]) * T
    whole[l : l + s, l + s :] = np.eye(s)
    flow, held, later = np.split(expm(whole)[:l], [l, l + s], axis=1)
    return flow, held - later + flow @ later, later


def _invertible(*matrices):
    sizes = [np.linalg.svd(M, compute_uv=False) for M in matrices]
    return all(len(x) and x[-1] > INVERTIBLE * x[0] for x in sizes)


def _not_too_fast(parts, a, T):
    """Raise where what the law filters with is over within a tick."""
    E, A = parts.E[a:, a:], parts.A[a:, a:]
    if not len(E):
        return
    fastest = abs(np.linalg.eigvals(np.asarray(inverse(E) @ A, float))).max()
    if fastest * T > 1 + SAME:
        raise ValueError(
            f"T = {T:g} s is longer than the law's filter of {1 / fastest:.4g} s, "
            f"which then smooths nothing: sample faster, or take filter={T:g} or more"
        )
