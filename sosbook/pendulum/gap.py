"""The two experiments with play in the gears.

The motors' side of the gears, with a share of the inertia, and what they drive,
with the rest, meet where the play is closed; within it each goes its own way.
"""

from math import ceil, pi, sin

import numpy as np

from ..plants.checks import finite, positive

__all__ = ["motion_with_play"]

CONTACT_HERTZ = 50.0  # of the teeth's spring: stiff beside what a robot does
CONTACT_DAMPING = 0.5  # of critical: teeth that meet don't bounce for long
LONGEST_STEP = 1.25e-3  # s; a sixteenth of the spring's period


def motion_with_play(e, f, d, V, T, friction, play, share, sees="driven"):
    r"""Angle and speed of a `motion` behind gears with play, from rest.

    (1 - s) q'' = p - d sin q and s m'' = e V - f m' - rub - p for the driven side's
    angle q and the motors' m, in units of the whole inertia; p is the push of a
    spring and a damper where m - q exceeds half of the play, and never a pull.

    Parameters
    ----------
    e, f, d : float
        As for `motion`.
    V : (N,) array_like
        Voltage, held from one sample to the next.
    T : float or (N,) array_like
        Sampling time in s, or the time from each sample to the next.
    friction : float
        Coulomb friction on the motors' side, in V; it is dry.
    play : float
        The gap, in rad at the wheels.
    share : float
        s, of the inertia on the motors' side, between 0 and 1.
    sees : {"driven", "motors"}
        Whose angle and speed the sensor has.

    Returns
    -------
    q, w : (N,) arrays
        Angle and speed before V[k] acts.

    Raises
    ------
    ValueError
        If a number isn't finite, T isn't positive or the share isn't in (0, 1).

    Examples
    --------
    Without play it is the motion of one body.

    >>> from .experiments import motion
    >>> V = [1.0] * 100
    >>> stiff = motion(200.0, 30.0, 0.0, V, 0.01)[0]
    >>> loose = motion_with_play(200.0, 30.0, 0.0, V, 0.01, 0.0, 0.0, 0.5)[0]
    >>> bool(abs(loose - stiff).max() < 0.01 * stiff.max())
    True
    """
    e, f, d = finite("e", e), finite("f", f), finite("d", d)
    if not 0 < finite("share", share) < 1:
        raise ValueError(f"share must lie between 0 and 1, got {share!r}")
    V = np.asarray(V, float)
    spans = np.broadcast_to(np.asarray(T, float), V.shape)
    steps = ceil(positive("T", float(spans.max())) / LONGEST_STEP)
    if sees not in ("driven", "motors"):
        raise ValueError(f"sees must be 'driven' or 'motors', got {sees!r}")
    rest, gap = 1 - share, abs(finite("play", play)) / 2
    rate, least = 2 * pi * CONTACT_HERTZ, share * rest
    spring, damper = rate * rate * least, 2 * CONTACT_DAMPING * rate * least
    held = abs(e * finite("friction", friction)) / share
    q = w = m = v = 0.0
    path, rounds = [], range(steps)
    for volt, h in zip(V.tolist(), (spans / steps).tolist()):
        path.append((q, w) if sees == "driven" else (m, v))
        force, half, most, lag = e * volt, h / 2, h * held, h * f / (2 * share)
        by_rest, by_share, keeps = h / rest, h / share, 1 - lag
        for _ in rounds:  # half a step of the places, one of the speeds, half a step
            q += half * w
            m += half * v
            apart = m - q
            if apart > gap:
                push = spring * (apart - gap) + damper * (v - w)
                push = push if push > 0 else 0.0
            elif apart < -gap:
                push = spring * (apart + gap) + damper * (v - w)
                push = push if push < 0 else 0.0
            else:
                push = 0.0
            w += by_rest * (push - d * sin(q))
            v = (keeps * v + by_share * (force - push)) / (1 + lag)
            v = v - most if v > most else v + most if v < -most else 0.0
            q += half * w
            m += half * v
    return tuple(np.array(path).T)
