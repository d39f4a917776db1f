"""The sampled loop of a pendulum and a law, about upright."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..controllers.estimates import estimated
from ..plants.checks import positive
from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.system import SampledSystem
from .law import PD_SIGNALS, SampledLaw
from .model import Mip

__all__ = ["SENSING", "SampledLoop", "held", "loop_radius", "lowest_rate",
           "peak_sensitivity", "sensing"]  # fmt: skip

#: What the law is given for [theta, phi, theta', phi'].
SENSING = ("exact", "differenced", "raw", "firmware")
INTEGRATION_TOLERANCE = 1e-9  # from one: a nearer eigenvalue counts as one


def sensing(kind, T, blend=0.0):
    """The system from the true [theta, phi, theta', phi'] to what the law is given.

    Parameters
    ----------
    kind : {"exact", "differenced", "raw", "firmware"}
        "exact": the truth. "differenced": phi' is the encoders'
        difference over T plus the gyro at this tick. "raw": the
        encoders' angle phi - theta, and its difference, stand for phi
        and phi'. "firmware": as `Firmware` does it, theta by the
        trapezoidal rule and phi' as the difference of absolute angles.
    T : float
        Time between samples, in s.
    blend : float
        As in `Firmware`, with accelerometers that say the truth.

    Returns
    -------
    SampledSystem
        A system with four inputs and four outputs, sampled with T.

    Examples
    --------
    >>> sensing("raw", 0.01).D
    array([[   1.,    0.,    0.,    0.],
           [  -1.,    1.,    0.,    0.],
           [   0.,    0.,    1.,    0.],
           [-100.,  100.,    0.,    0.]])
    """
    if kind not in SENSING:
        raise ValueError(f"sensing must be one of {SENSING}, got {kind!r}")
    T = positive("T", T)
    theta, phi, gyro, _rate = np.eye(4)
    wheels = phi - theta
    if kind == "exact":
        return SampledSystem([], [], [], np.eye(4), T)
    if kind == "firmware":
        return estimated(T, blend)
    raw = kind == "raw"
    return SampledSystem(  # the state is the last tick's encoder angle
        [[0]],
        [wheels],
        [[0], [0], [0], [-1 / T]],
        [theta, wheels if raw else phi, gyro, wheels / T + (0 if raw else gyro)],
        T,
    )


def held(plant, T, delay):
    """From the inputs of a ``plant``, ``delay`` late, to [z; z'] at ticks T apart."""
    (vertex,) = input_vertices(plant, None)
    A, B = SampleTiming.of(T, delay).held(vertex)
    states = 2 * plant.n
    return SampledSystem(
        A, B, np.eye(states, len(A)), np.zeros((states, B.shape[1])), T
    )


@lru_cache(maxsize=1000)
def _held(robot, T, delay):
    """As `held`, of a `Mip`."""
    return held(robot.plant(), T, delay)


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """A pendulum about upright with a sampled law.

    Parameters
    ----------
    robot : Mip
        The pendulum.
    law : SampledLaw
        The control law, which sees samples and gives a voltage.
    delay : float
        The time from the sample to the voltage that follows from it, in s.
    sensing : {"exact", "differenced", "raw", "firmware"}
        As in `sensing`.
    blend : float
        As in `Firmware`.

    Raises
    ------
    ValueError
        On a negative delay or an unknown ``sensing``.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> law = SampledLaw.of_gain(thesis.mip().gains["PD"][1], 0.01)
    >>> round(SampledLoop(Mip.printed(), law).radius, 3)
    0.99
    >>> late = SampledLoop(Mip.printed(), law, delay=0.01)
    >>> round(late.radius, 3)
    1.002
    """

    robot: Mip
    law: SampledLaw
    delay: float = 0.0
    sensing: str = "exact"
    blend: float = 0.0

    def __post_init__(self):
        truth = _held(self.robot, self.law.T, self.delay)
        object.__setattr__(self, "loop_gain", truth.then(self.controller))

    @property
    def controller(self):
        """The system from the true [theta, phi, theta', phi'] to the voltage."""
        law = self.law
        whole = sensing(self.sensing, law.T, self.blend).then(
            SampledSystem(law.A, law.B, law.C, law.D, law.T)
        )
        return replace(whole, inputs=PD_SIGNALS, outputs=("u",))

    @property
    def open_loop(self):
        """The system from the voltage to the law's, as python-control's StateSpace."""
        return self.loop_gain.to_control()

    @property
    def matrix(self):
        """The matrix of the closed loop, from one tick to the next."""
        L = self.loop_gain
        return L.A + L.B @ L.C

    @property
    def poles(self):
        """Its eigenvalues, the largest first."""
        eigenvalues = np.linalg.eigvals(self.matrix)
        return eigenvalues[np.argsort(-np.abs(eigenvalues))]

    @property
    def constants(self):
        """How many of the poles are one: those of sums that nothing feeds back.

        A law of the rates doesn't know phi; a law that integrates the
        gyro doesn't know theta's beginning.
        """
        return len(self.poles) - len(_moving(self.matrix))

    @property
    def radius(self):
        """The largest |eigenvalue|, `constants` left out.

        Below one, what the law sees of the loop is stable. Eigenvalues
        at one are left out without a look at what they are; a law whose
        own states make a ramp would need that look.
        """
        return loop_radius(self.loop_gain)

    @property
    def sensitivity(self):
        """The peak of |1 / (1 - L)| at the motor; infinite if unstable.

        Its inverse is the distance of Nyquist's curve from the critical
        point, the modulus margin.
        """
        return peak_sensitivity(self.loop_gain)


def _moving(F):
    """Eigenvalues of F but those at one."""
    poles = np.linalg.eigvals(F)
    return poles[np.abs(poles - 1) >= INTEGRATION_TOLERANCE]


def loop_radius(gain):
    """The largest |eigenvalue| of a loop's ``gain`` that is closed, but those at one.

    The gain is a `SampledSystem` with as many outputs as inputs and no direct
    way from one to the other.
    """
    return float(np.abs(_moving(gain.A + gain.B @ gain.C)).max())


def peak_sensitivity(gain):
    """The peak of |1 / (1 - L)| of a loop's ``gain`` L; infinite if unstable.

    The gain is a `SampledSystem` with one input and one output, and no direct way
    from one to the other.
    """
    if loop_radius(gain) >= 1:
        return np.inf
    opened = np.linalg.eigvals(gain.A)
    closed = np.linalg.eigvals(gain.A + gain.B @ gain.C)

    def inverse(angles):  # 1 - L = det(z - A - B C) / det(z - A)
        z = np.exp(1j * angles)[:, None]
        return np.abs(np.prod((z - closed) / (z - opened), axis=1))

    angles = np.linspace(0, np.pi, 2001)[1:]
    coarse = inverse(angles)
    fine = angles[coarse.argmin()] + np.linspace(-1, 1, 201) * np.pi / 2000
    return float(1 / min(coarse.min(), inverse(fine).min()))


def lowest_rate(robots, law_of, ticks=0.0, sensing="exact", rates=None):
    """The rate down to which every robot's loop is stable.

    Parameters
    ----------
    robots : sequence of Mip
        The pendulums, all of which shall be stable.
    law_of : callable
        Makes a `SampledLaw` of T, in s.
    ticks : float
        The delay, in units of T.
    sensing : {"exact", "differenced", "raw", "firmware"}
        As in `sensing`.
    rates : sequence of float, optional
        Rates in Hz, from the fastest down; from 1000 to 10 Hz without it, a step by
        2 %. The answer is the last one before the first that fails. A slower one may
        be stable again.

    Returns
    -------
    float
        The rate in Hz; infinite if the first fails.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> gain = thesis.mip().gains["PD"][5]
    >>> rate = lowest_rate(
    ...     [Mip.printed()], lambda T: SampledLaw.of_gain(gain, T), ticks=1)
    >>> 35 < rate < 45
    True
    """
    lowest = np.inf
    for rate in np.geomspace(1000, 10, 241) if rates is None else rates:
        law = law_of(1 / rate)
        loops = (SampledLoop(robot, law, ticks / rate, sensing) for robot in robots)
        if not all(loop.radius < 1 for loop in loops):
            break
        lowest = float(rate)
    return lowest
