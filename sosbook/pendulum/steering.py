"""The heading of a robot with two wheels: how it turns, and the law that holds it.

The wheels' difference delta = phi_R - phi_L says where the robot heads:
psi = r delta / track, positive to the left. With half the voltages' difference
W = V_R - V_L more on the right and less on the left, equal motors leave the
sum of both torques as it is: balancing doesn't notice.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from ..plants.checks import finite, matrix, positive
from ..plants.second_order import Polytope, SecondOrderSystem
from ..sampled import certify_sampled
from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.system import SampledSystem
from ..synthesis.lqr import design_lqr
from .firmware import TRUSTED_VOLTS, Firmware, within
from .law import combine
from .margins import loop_radius, peak_sensitivity
from .spread import vertices
from .tuning import DELAY_SHARES, WEIGHTS, proven_decay

__all__ = [
    "Steered",
    "Steering",
    "SteeringDesign",
    "steer",
    "turning_plants",
    "unequal_plant",
]

U = [[1]]  # integrate delta
TRACKING_TIME = 0.5  # s, as in `SampledLaw.of_gain`
MOST_LOST = 32766  # ticks: what C promises of an int, less one


@dataclass(frozen=True, eq=False)
class Steering:
    """The law that holds a heading, beside a firmware that balances.

    W = K [delta - target, delta' - rate, sum] with the sum T (delta - target);
    W is cut to what balancing leaves of the limit, and to a share of it.

    Parameters
    ----------
    firmware : Firmware
        The one that balances: its clock, its limit and its wheels' fastest rate.
    K : (1, 3) array_like
        The gain, in V per rad, V s per rad and V per rad s.
    share : float
        The most that steering takes of the limit, above 0 and below 1.
    track : float
        The distance between the wheels, in m.
    r : float
        The wheels' radius, in m.

    Raises
    ------
    ValueError
        If a number is out of its range.

    Examples
    --------
    >>> from sosbook.pendulum import SampledLaw
    >>> firmware = Firmware(SampledLaw.of_gain([[20, 0.8, 2, 0.9]], 0.01))
    >>> steering = Steering(firmware, [[-1, -0.1, -0.5]], 0.25, 0.08, 0.034)
    >>> steered = steering.controller()
    >>> steered.start(left=0.0, right=0.0)
    >>> left, right = steered.step([3.0], [0], left=0.0, right=0.1)
    >>> left.round(3), right.round(3)
    (array([3.55]), array([2.45]))
    """

    firmware: Firmware
    K: np.ndarray
    share: float
    track: float
    r: float

    def __post_init__(self):
        if not isinstance(self.firmware, Firmware):
            raise ValueError("firmware must be a Firmware")
        object.__setattr__(self, "K", matrix("K", self.K, (1, 3)))
        if self.K[0, 2] == 0:
            raise ValueError("K's last entry, of the sum, is zero: nothing unwinds it")
        for name in ("share", "track", "r"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))
        if self.share >= 1:
            raise ValueError(f"share must be below 1, got {self.share!r}")

    @property
    def per_radian(self):
        """Radians of the wheels' difference per radian of heading."""
        return self.track / self.r

    @property
    def volts(self):
        """The most that one motor gets for steering, in V."""
        return self.share * self.firmware.limit

    @property
    def reach(self):
        """The most by which the difference changes in a tick, in rad."""
        return 2 * self.firmware.fastest * self.firmware.law.T

    @property
    def unwinding(self):
        """How what the limit withheld acts on the sum, in rad s per V."""
        return self.firmware.law.T / (TRACKING_TIME * self.K[0, 2])

    @property
    def system(self):
        """The `SampledSystem` from the true [delta, delta'] to W."""
        (k, k_rate, k_sum), T = self.K[0], self.firmware.law.T
        return SampledSystem(
            [[0, 0], [0, 1]],
            [[1, 0], [T, 0]],
            [[-k_rate / T, k_sum]],
            [[k + k_rate / T, 0]],
            T,
        )

    def controller(self, runs=1, kind=float):
        """A `Steered` for ``runs`` robots; ``kind`` is float or np.float32."""
        return Steered(self, runs, kind)


class Steered:
    """A `Steering` at work on robots side by side, as the C program does it.

    Parameters
    ----------
    steering : Steering
        The law and its limits.
    runs : int
        How many robots stand side by side.
    kind : float or np.float32
        The precision of all arithmetic.
    """

    def __init__(self, steering, runs=1, kind=float):
        self.steering, self.runs, self.kind = steering, runs, np.dtype(kind)

    def start(self, left=0.0, right=0.0):
        """Forget everything; the wheels rest at the angles left and right, in rad."""
        self.turned = self.zero = self._each(right) - self._each(left)
        self.sum = self._each(0)
        self.lost = np.zeros(self.runs, int)

    def step(self, volts, fault, left, right, target=0.0, rate=0.0):
        """One tick, after the firmware's.

        Parameters
        ----------
        volts : (runs,) array_like
            What the firmware answered, in V.
        fault : (runs,) array_like of int
            The firmware's fault; with any the motors get nothing.
        left, right : float or (runs,) array
            The wheels' angles against the body, in rad.
        target, rate : float or (runs,) array
            Set point of delta since the start and of its rate, in rad and
            rad/s.

        Returns
        -------
        (left, right) : tuple of (runs,) array
            Volts for each motor.
        """
        with np.errstate(invalid="ignore", over="ignore"):
            return self._step(
                np.asarray(fault) == 0,
                *map(self._each, (volts, left, right, target, rate)),
            )

    def _step(self, running, V, left, right, target, rate):
        s, one = self.steering, self.kind.type
        T, limit = s.firmware.law.T, one(s.firmware.limit)
        turned, since = right - left, (self.lost + 1).astype(self.kind)
        seen = within(turned - self.turned, one(s.reach) * since)
        y = [
            turned - self.zero - target,
            (turned - self.turned) * one(1 / T) / since - rate,
            self.sum,
        ]
        u = combine(s.K[0], y)
        rest = limit - abs(V)
        room = 2 * np.where(rest < one(s.volts), rest, one(s.volts))
        W = np.where(u > room, room, np.where(u < -room, -room, u))
        good = running & seen & within(u, one(TRUSTED_VOLTS))
        later = self.sum + one(T) * y[0] + one(s.unwinding) * (W - u)
        self.sum = np.where(good, later, self.sum)
        self.turned = np.where(good, turned, self.turned)
        lost = np.minimum(self.lost + 1, MOST_LOST)
        self.lost = np.where(good, 0, np.where(running, lost, self.lost))
        half = np.where(good, W / 2, one(0))
        return tuple(
            np.where(running, np.clip(V + side * half, -limit, limit), one(0))
            for side in (-1, 1)
        )

    def _each(self, value):
        return np.broadcast_to(np.asarray(value, self.kind), self.runs)


def inertia_bounds(mip, robot):
    """Least and largest a_d of a_d delta'' + f delta' = e W, in kg m^2.

    Virtual work gives a_d = 4 (I_z + M_w track^2 / 2) (r / track)^2 + 2 I_w,
    with I_z the body's inertia about the vertical. Without the robot's
    ``turning`` I_z lies between zero and M_b (track / 2)^2, that of a body
    whose mass lies within the circle through both wheels: then a_d is at
    least 2 M_w r^2 + 2 I_w, and at most the pendulum's a.

    Parameters
    ----------
    mip : Mip
        The pendulum, with its I_w.
    robot : Robot
        Its masses and lengths.
    """
    body = robot.turning or (0.0, robot.M_b * (robot.track / 2) ** 2)
    scale = 4 * (robot.r / robot.track) ** 2
    wheels = 2 * robot.M_w * robot.r**2 + 2 * mip.I_w
    return tuple(scale * I_z + wheels for I_z in body)


def turning_plants(mip, robot, spread=0.04):
    """How the robot turns: two polytopes that cover all allowed plants.

    The plant is (a_d / e) delta'' + (f / e) delta' = W, and the two quotients
    fill a rectangle, of which each polytope is a half.

    Parameters
    ----------
    mip : Mip
        The pendulum in the middle, with its I_w.
    robot : Robot
        The robot's description, with its track.
    spread : float or FitSpread
        As for `polytope`, whose pendulums' quotients the rectangle holds.

    Returns
    -------
    tuple of Polytope
        The rectangle, then its two triangles.

    Examples
    --------
    >>> from sosbook.pendulum import Mip, Robot
    >>> robot = Robot.shipped("thesis").but(track=0.07)
    >>> [part.N for part in turning_plants(Mip.printed(), robot)]
    [4, 3, 3]
    """
    if mip.I_w is None:
        raise ValueError("mip has no I_w: say which part of a is geared")
    if robot.track is None:
        raise ValueError("the robot has no track: how far apart are its wheels?")
    around = vertices(mip, spread)
    quotients = [x / m.e for m in around for x in inertia_bounds(m, robot)]
    inertia = min(quotients), max(quotients)
    damping = min(m.f / m.e for m in around), max(m.f / m.e for m in around)
    plants = [
        SecondOrderSystem([[m]], [[d]], [[0]], B=[[1]])
        for m, d in product(inertia, damping)
    ]
    parts = (0, 1, 2, 3), (0, 3, 1), (0, 3, 2)
    return tuple(Polytope([plants[k] for k in part]) for part in parts)


@dataclass(frozen=True, eq=False)
class SteeringDesign:
    """A steering law with its proofs.

    Parameters
    ----------
    robot : Robot
        The robot's description, with its track.
    robots : tuple of Mip
        The pendulum in the middle and those at the polytope's corners.
    spread : float or FitSpread
        As in `turning_plants`.
    design : Design
        The least cost of Theorem 2.4 over the rectangle of `turning_plants`.
    delayed : DelayDesign
        The same gain behind any delay up to `largest_hold`.
    law : Steering
        What runs on the robot.
    balance : SampledSystem
        What balances, from the true [theta, phi, theta', phi'] to V.
    """

    robot: object
    robots: tuple
    spread: object
    design: object
    delayed: object
    law: Steering
    balance: SampledSystem

    @property
    def plants(self):
        """The three polytopes of `turning_plants`."""
        return turning_plants(self.robots[0], self.robot, self.spread)

    @cached_property
    def sensitivity(self):
        """The largest peak of the sensitivity at the corners and the delays."""
        return _peak(self.plants[0], self.law.system, self.robot)

    @cached_property
    def certificate(self):
        """The `Certificate` in continuous time."""
        return self.design.certify()

    @cached_property
    def held(self):
        """The `DelayCertificate` behind the hold."""
        return self.delayed.certify()

    @cached_property
    def sampled(self):
        """Proofs of the sampled loops: a dict from the delay to two certificates."""
        return {
            late: tuple(
                certify_sampled(part, self.law.system, self.robot.T, late, cells=600)
                for part in self.plants[1:]
            )
            for late in (share * self.robot.delay for share in DELAY_SHARES)
        }

    @property
    def proofs(self):
        """Every proof by a name, for a file or a sentence."""
        rows = (x for row in self.sampled.values() for x in row)
        return {
            "steer": self.certificate,
            "steer_hold": self.held,
            **{f"steer_sampled_{k}": proof for k, proof in enumerate(rows, 1)},
        }

    @cached_property
    def lacking(self):
        """The proofs that fail, in words; empty if all hold."""
        return tuple(
            f"{name}: {', '.join(proof.failed)}"
            for name, proof in self.proofs.items()
            if not proof.proven
        )

    @cached_property
    def coupled_radius(self):
        """The largest spectral radius of balance and steering as one, in floats.

        One motor's e is larger by the robot's ``unequal`` and the other's
        smaller, and f likewise, alike or crosswise; for every robot, either
        bound of the inertia, and each delay.
        """
        more = self.robot.unequal
        return max(
            loop_radius(_coupled(plant, self.balance, self.law.system, late))
            for mip in self.robots
            for inertia in inertia_bounds(mip, self.robot)
            for crossed in (more, -more)
            for plant in [unequal_plant(mip, inertia, more, crossed)]
            for late in (share * self.robot.delay for share in DELAY_SHARES)
        )


def steer(mip, robots, robot, firmware, balance, spread, peak):
    """The `SteeringDesign` of a robot: the smallest R with a good margin.

    Parameters
    ----------
    mip : Mip
        The pendulum in the middle, with its I_w.
    robots : sequence of Mip
        It and those at the corners of its polytope.
    robot : Robot
        The robot's description, with its track.
    firmware : Firmware
        What balances.
    balance : SampledSystem
        The same, from the true [theta, phi, theta', phi'] to V.
    spread : float or FitSpread
        As in `turning_plants`.
    peak : float
        The largest peak of the sensitivity.

    Raises
    ------
    ValueError
        If no weight from 1 on keeps the peak, or no decay is proven.
    """
    plants = turning_plants(mip, robot, spread)[0]
    for R in (R for R in WEIGHTS if R >= 1):
        designed = design_lqr(plants, np.eye(3), [[R]], U)
        if designed.status != "feasible":
            continue
        K = designed.certify().K
        law = Steering(firmware, K, robot.steering, robot.track, robot.r)
        if _peak(plants, law.system, robot) <= peak:
            delayed = proven_decay(plants, U, robot, K, 0.0)
            return SteeringDesign(
                robot, tuple(robots), spread, designed, delayed, law, balance
            )
    raise ValueError(
        f"steering: no R keeps the peak of the sensitivity at {finite('peak', peak):g} "
        f"or below with T = {1000 * robot.T:g} ms: take a smaller T or delay, or "
        "leave track out"
    )


def _held(plant, T, late):
    """From the voltages to [z; z'] at the ticks."""
    (vertex,) = input_vertices(plant, None)
    A, B = SampleTiming.of(T, late).held(vertex)
    states = 2 * plant.n
    return SampledSystem(
        A, B, np.eye(states, len(A)), np.zeros((states, B.shape[1])), T
    )


def _peak(plants, system, robot):
    """The largest sensitivity of the corners for no, half and all delay."""
    return max(
        peak_sensitivity(_held(plant, robot.T, share * robot.delay).then(system))
        for plant in plants.vertices
        for share in DELAY_SHARES
    )


def unequal_plant(mip, inertia, more, crossed):
    """The plant of z = [theta, phi, delta] and u = [V, W] with unequal motors.

    Parameters
    ----------
    mip : Mip
        The pendulum, with the sums e and f of both motors.
    inertia : float
        As in `inertia_bounds`, in kg m^2.
    more, crossed : float
        The right motor's e and f are larger by these shares than the mean, and
        the left's smaller.

    Returns
    -------
    SecondOrderSystem
        With three angles and two voltages.
    """
    two, e, f = mip.plant(), mip.e, mip.f
    M, D, S = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    M[:2, :2], M[2, 2] = two.M, inertia
    D[:2, :2], D[2, 2] = two.D, f
    D[:2, 2] = -f * crossed / 2, f * crossed / 2
    D[2, :2] = -2 * f * crossed, 2 * f * crossed
    S[:2, :2] = two.S
    B = [[-e, -e * more / 2], [e, e * more / 2], [2 * e * more, e]]
    return SecondOrderSystem(M, D, S, B=B)


def _coupled(plant, balance, steering, late):
    """From [V, W] to what both laws answer, one after the other."""
    p, q = balance.nstates, steering.nstates
    A, C = np.zeros((p + q, p + q)), np.zeros((2, p + q))
    A[:p, :p], A[p:, p:] = balance.A, steering.A
    C[0, :p], C[1, p:] = balance.C[0], steering.C[0]
    B, D = np.zeros((p + q, 6)), np.zeros((2, 6))
    B[:p, [0, 1, 3, 4]], B[p:, [2, 5]] = balance.B, steering.B
    D[0, [0, 1, 3, 4]], D[1, [2, 5]] = balance.D[0], steering.D[0]
    both = SampledSystem(A, B, C, D, balance.dt)
    return _held(plant, balance.dt, late).then(both)
