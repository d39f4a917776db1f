"""The design of a law that holds a heading, with its proofs."""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from ..plants.second_order import Polytope
from ..requirements.pole_region import PoleRegion
from ..sampled import certify_sampled
from ..sampled.system import SampledSystem
from ..synthesis.lqr import design_lqr
from .firmware import Firmware
from .margins import held, loop_radius, peak_sensitivity
from .model import COORDINATES
from .steering import Steering
from .tuning import DELAY_SHARES, WEIGHTS, prove, prove_sampled
from .turning import inertia_bounds, turning_plants, unequal_plant

__all__ = ["SteeringDesign"]

U = [[1]]  # integrate delta
DAMPING_DEG = 45.0  # half a sector's angle: a single pair overshoots by 4 %
DECAYS = 2.0, 1.0, 0.5  # 1/s, one after the other: at 2 / s a turn is over in 2 s
STEERING_CELLS = 600  # of the rectangle's halves, at most
UNEQUAL_CELLS = 12  # of the motors' differences, for one proof


@dataclass(frozen=True, eq=False)
class SteeringDesign:
    """A damped steering law with its proofs: the fastest with a good margin.

    Poles lie in a sector and decay, the rate is never fed back positively, and R is the
    smallest that keeps the peak. ``robot``: its description, with its track;
    ``robots``: the pendulum in the middle, with its I_w, and those at the corners;
    ``spread``: as in `turning_plants`; ``firmware``: what balances; ``balance``: the
    same as a system from the true [theta, phi, theta', phi'] to V; ``peak``: the
    largest of the sensitivity. From `design` on a ValueError if no decay and no weight
    from 1 on keep the peak, or none is proven behind the hold.
    """

    robot: object
    robots: tuple
    spread: object
    firmware: Firmware
    balance: SampledSystem
    peak: float

    @property
    def plants(self):
        """The three polytopes of `turning_plants`."""
        return turning_plants(self.robots[0], self.robot, self.spread)

    @cached_property
    def _chosen(self):
        """The design, its law, and its `DelayDesign`."""
        robot, plants, why = self.robot, self.plants[0], ""
        for decay, R in product(DECAYS, (R for R in WEIGHTS if R >= 1)):
            region = PoleRegion(decay, theta_deg=DAMPING_DEG)
            designed = design_lqr(plants, np.eye(3), [[R]], U, region=region)
            if designed.status != "feasible":
                continue
            K = designed.certify().K
            law = Steering(self.firmware, K, robot.steering, robot.track, robot.r)
            if K[0, 1] > 0 or _peak(plants, law.system, robot) > self.peak:
                continue
            try:
                return designed, law, prove(plants, U, robot, K, decay)
            except ValueError as error:
                why = f". At R = {R:g}: {error}"
        raise ValueError(
            f"steering: no R keeps the peak of the sensitivity at {self.peak:g} or "
            f"below with T = {1000 * robot.T:g} ms, poles that decay by "
            f"{DECAYS[-1]:g}/s within {DAMPING_DEG:g} degrees of the real axis, and a "
            "rate that isn't fed back positively: take a smaller T or delay, closer "
            f"bounds of the inertia (turning), or leave track out{why}"
        )

    @property
    def design(self):
        """The `Design`: the least cost of Theorem 2.4 over the rectangle."""
        return self._chosen[0]

    @property
    def law(self):
        """The `Steering` that runs on the robot."""
        return self._chosen[1]

    @property
    def delayed(self):
        """The `DelayDesign` of the gain behind any delay up to T + delay + jitter."""
        return self._chosen[2]

    @cached_property
    def sensitivity(self):
        """The largest peak of the sensitivity at the corners and the delays."""
        return _peak(self.plants[0], self.law.system, self.robot)

    @cached_property
    def certificate(self):
        """The `DesignProof` in continuous time."""
        return self.design.certify()

    @cached_property
    def held(self):
        """The `DelayProof` behind the hold."""
        return self.delayed.certify()

    @cached_property
    def sampled(self):
        """Proofs of the sampled loops: a dict from the delay to two certificates."""
        parts = self.plants[1:]
        return prove_sampled(parts, self.law.system, self.robot, STEERING_CELLS)

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
    def unequal(self):
        """Proofs of balance and steering as one, with motors that differ.

        A tuple of `SampledProof`, of each pendulum, either bound of the
        inertia and each delay. Each holds for all shares by which the right motor's
        e and f are above the mean, and the left's below, up to the robot's
        ``unequal``: it is of the triangle of these pairs, whose other half is
        its mirror image, left and right exchanged. Of pendulums between these
        nothing is proven. At the first that isn't proven they end.
        """
        w, proofs = self.robot.unequal, []
        if not w:
            return ()
        for mip, inertia, late in self._coupled_cases:
            pairs = (-w, -w), (w, w), (w, -w)
            triangle = Polytope([unequal_plant(mip, inertia, *pair) for pair in pairs])
            asked = _both(self.balance, self.law.system), self.robot.T, late
            how = dict(digits=12, cells=UNEQUAL_CELLS)
            proofs.append(certify_sampled(triangle, *asked, **how))
            if not proofs[-1].proven:
                break
        return tuple(proofs)

    @property
    def unequal_proven(self):
        """True if all proofs of `unequal` hold."""
        return bool(self.unequal) and all(proof.proven for proof in self.unequal)

    @property
    def _coupled_cases(self):
        """Every pendulum, bound of the inertia and delay at which motors may differ."""
        return [
            (mip, inertia, share * self.robot.delay)
            for mip in self.robots
            for inertia in inertia_bounds(mip, self.robot)
            for share in DELAY_SHARES
        ]

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
            for mip, inertia, late in self._coupled_cases
            for crossed in (more, -more)
            for plant in [unequal_plant(mip, inertia, more, crossed)]
        )


def _peak(plants, system, robot):
    """The largest sensitivity of the corners for no, half and all delay."""
    return max(
        peak_sensitivity(held(plant, robot.T, share * robot.delay).then(system))
        for plant in plants.vertices
        for share in DELAY_SHARES
    )


def _coupled(plant, balance, steering, late):
    """From [V, W] to what both laws answer, one after the other."""
    return held(plant, balance.dt, late).then(_both(balance, steering))


def _both(balance, steering):
    """From [theta, phi, delta] and their rates to [V, W]: both laws side by side."""
    p, q = balance.nstates, steering.nstates
    A, C = np.zeros((p + q, p + q)), np.zeros((2, p + q))
    A[:p, :p], A[p:, p:] = balance.A, steering.A
    C[0, :p], C[1, p:] = balance.C[0], steering.C[0]
    B, D = np.zeros((p + q, 6)), np.zeros((2, 6))
    B[:p, [0, 1, 3, 4]], B[p:, [2, 5]] = balance.B, steering.B
    D[0, [0, 1, 3, 4]], D[1, [2, 5]] = balance.D[0], steering.D[0]
    angles = (*COORDINATES, "delta")
    names = (*angles, *(f"{angle}'" for angle in angles)), ("u1", "u2")
    return SampledSystem(A, B, C, D, balance.dt, None, None, *names)
