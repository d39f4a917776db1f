"""Gears that have play: the motors' rotors are a body of their own.

Between the rotors, with the encoders, and the wheels lies a gap. In it the motors turn
nothing but themselves; at its ends the teeth push like a spring with a damper.
"""

import math

import numpy as np

from ..plants.checks import finite, positive
from .fleet import STICTION_SPEED, UPSET, Fleet, listed_for

__all__ = ["Geared", "motion_with_play"]

#: Of the rotors against the wheels through the teeth, in Hz, and its damping. Nobody
#: knows those of gears: these ring like steel on a plastic hub, and fade in a cycle.
TEETH_HERTZ, TEETH_DAMPING = 70.0, 0.3
LONGEST_STEP = 5e-4  # s: a thirtieth of their period
#: Likewise in a fit: teeth that bounce longer make its residual's valley rough.
FITTED_TEETH = 50.0, 0.5
FITTED_STEP = 1.25e-3  # s: a sixteenth of their period
ROTORS_SHARE = 0.1  # of what rolls with the wheels, where the pendulum has no J


def teeth(one, other, hertz=TEETH_HERTZ, damping=TEETH_DAMPING):
    """The spring and the damper of teeth between two inertias."""
    both, rate = one * other / (one + other), 2 * math.pi * hertz
    return both * rate * rate, 2 * damping * both * rate


def bite(twist, rate, half, spring, damper):
    """The torque of teeth that are turned by a twist, beyond half of the play."""
    if -half <= twist <= half:
        return 0.0
    over = twist - half if twist > 0 else twist + half
    push = spring * over + damper * rate
    return push if push * over > 0 else 0.0  # teeth push and never pull


class Geared(Fleet):
    """A `Fleet` with play, whose robots are moved one by one.

    ``robots``: one for all runs, or one for each; ``gap``: the play in rad of a wheel,
    from one end to the other; ``friction``: as in `Fleet`; ``runs``: how many runs
    there are.
    """

    def __init__(self, robots, gap, friction, runs):
        super().__init__(robots, friction)
        self.half, self.rotors = gap / 2, None
        self.robots = self.robots * (runs if len(self.robots) == 1 else 1)

    def seen(self, x):
        """The states x with the angle and the rate of the rotors for the wheels'."""
        if self.rotors is None:
            self.rotors = x[1::2].copy()
        seen = x.copy()
        seen[1::2] = self.rotors
        return seen

    def acceleration(self, x, V, torques=(0.0, 0.0)):
        """z'' at the states x, under the voltage V and torques on theta and phi."""
        states = zip(self.robots, self._whole(x), listed_for(x, V))
        return np.array([self._rates(m, v, torques)(*s)[:2] for m, s, v in states]).T

    def advance(self, x, V, torques, time, steps):
        """The states x after a ``time`` under a constant V and torques.

        It takes at least so many ``steps``.
        """
        steps = max(steps, math.ceil(time / LONGEST_STEP))
        ends = np.array(
            [
                _moved(state, self._rates(mip, volt, torques), time / steps, steps)
                for mip, state, volt in zip(
                    self.robots, self._whole(x), listed_for(x, V)
                )
            ]
        ).T
        self.rotors = ends[[2, 5]]
        return ends[[0, 1, 3, 4]]

    def _whole(self, x):
        """[theta, phi, rho, and their rates] of each robot, in plain numbers."""
        if self.rotors is None:
            self.rotors = x[1::2].copy()
        (theta, phi, w, v), (angle, rate) = x.tolist(), self.rotors.tolist()
        return zip(theta, phi, angle, w, v, rate)

    def _rates(self, mip, V, torques):
        """The rates of theta', phi' and rho' under a voltage and torques."""
        own = mip.J  # of the rotors, as far as the pendulum's equations have them
        J = own or ROTORS_SHARE * mip.a
        wheels, body = mip.a - J, mip.c - own
        spring, damper = teeth(J, wheels)
        b, d, e, f = mip.b, mip.d, mip.e, mip.f
        (on_body, on_wheels), half, friction = torques, self.half, self.friction
        sine, cosine, tanh = math.sin, math.cos, math.tanh

        def rates(theta, phi, rho, w, v, n):
            twist = rho - phi
            loose = -half <= twist <= half  # it is asked here: a call takes longer
            push = 0.0 if loose else bite(twist, n - v, half, spring, damper)
            rub = friction * tanh((n - w) / STICTION_SPEED) if friction else 0.0
            torque = e * (V - rub) - f * (n - w)
            sin, lean = sine(theta), b * cosine(theta)
            p = d * sin - (push if own else torque) + on_body
            q = b * sin * w * w + push + on_wheels
            size = body * wheels - lean * lean
            tips = (wheels * p - lean * q) / size
            spins = (torque - push) / J + (tips if own else 0.0)
            return tips, (body * q - lean * p) / size, spins

        return rates


def _moved(x, rates, h, steps):
    """The state x after some steps of length h by Heun's method."""
    (theta, phi, rho, w, v, n), half = x, h / 2
    for _ in range(steps):  # written out: lists take twice as long
        if abs(theta) >= UPSET:
            return [math.copysign(UPSET, theta), phi, rho, 0.0, 0.0, 0.0]
        a, b, c = rates(theta, phi, rho, w, v, n)
        w2, v2, n2 = w + h * a, v + h * b, n + h * c
        at = theta + h * w, phi + h * v, rho + h * n
        a2, b2, c2 = rates(*at, w2, v2, n2)
        theta, phi = theta + half * (w + w2), phi + half * (v + v2)
        rho += half * (n + n2)
        w, v, n = w + half * (a + a2), v + half * (b + b2), n + half * (c + c2)
    return [theta, phi, rho, w, v, n]


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
    steps = math.ceil(positive("T", float(spans.max())) / FITTED_STEP)
    if sees not in ("driven", "motors"):
        raise ValueError(f"sees must be 'driven' or 'motors', got {sees!r}")
    rest, gap = 1 - share, abs(finite("play", play)) / 2
    spring, damper = teeth(share, rest, *FITTED_TEETH)
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
            push = bite(m - q, v - w, gap, spring, damper)
            w += by_rest * (push - (d * math.sin(q) if d else 0.0))
            v = (keeps * v + by_share * (force - push)) / (1 + lag)
            v = v - most if v > most else v + most if v < -most else 0.0
            q += half * w
            m += half * v
    return tuple(np.array(path).T)
