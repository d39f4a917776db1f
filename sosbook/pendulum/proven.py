"""A controller for a robot, with its proofs."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..plants.checks import finite, positive
from ..plants.gain import Gain
from ..runtime.writing import write_texts
from . import tuning
from .drive import Drive
from .facts import facts
from .firmware import Firmware
from .fit_spread import FitSpread
from .law import PD_SIGNALS, PID_SIGNALS, SampledLaw
from .model import Mip
from .recovery import largest_tilt
from .rest import Gears, volts_at_rest
from .robot import Robot
from .sensors import Sensors
from .spread import polytope, triangles, vertices
from .steering_design import SteeringDesign
from .written import check, texts

__all__ = ["Deployment"]

BENCH_VOLTS = 2.0  # V, at most, while the wheels hang free: enough to see them turn
MOST_CELLS = 600  # of the uncertain parameters, for one proof of the sampled loop
FIT_CELLS = 150  # of those of a fit, each of which has 16 corners
LARGEST_DECAY = 0.2  # 1/s, the most that the proof with the hold is asked for
LEAST_TILT = np.deg2rad(5)  # rad; a robot must be able to come back from here
REST_SECONDS = 60.0  # of a simulation at rest, before anything is written
RESCUE = 20.0  # fall times, and this many s at least, in which a robot must settle
RESCUE_SECONDS = 3.0
LARGEST_PEAK = 2.0  # of the sensitivity: 1/2 is then the distance from -1


@dataclass(frozen=True, eq=False)
class Deployment:
    """A controller for a robot, and what is known about it.

    Parameters
    ----------
    mip : Mip
        The robot in the middle, with its I_w.
    R : float or None
        Weight of the voltage. None searches the smallest of 1, 2, 5, 10, ... with
        which no sampled loop's sensitivity exceeds ``peak``.
    spread : float or FitSpread
        Relative spread of e/c and of e/a; or that of all five ratios, from a fit.
    robot : Robot, optional
        The description; the thesis's robot without it. How long it bears a fault is
        filled in, where it doesn't say.
    Q : (5,) or (5, 5) array_like, optional
        Weight of [theta, phi, theta', phi', x3], or its diagonal; the identity
        without it.
    decay : float
        The decay rate behind the hold, in 1/s, if it can be proven; else the largest
        of some shares of it that can.
    peak : float
        The largest peak of the sensitivity; above it nothing is written.
    cells : int, optional
        As for `certify_sampled`, at most; 600 without it, or 150 of a `FitSpread`, each
        of which takes longer.
    patience : float
        Seconds, at most, for a proof that lets delays and ticks vary; without any
        it isn't tried.
    identified : Identified or None
        What the logs say of the robot.
    data : dict
        Where the robot comes from: facts for the header.

    Raises
    ------
    ValueError
        On bad input, or motors that are too weak. `design` and `delayed` raise it
        where there is none; they say why.
    """

    mip: Mip
    R: float | None = None
    spread: object = 0.04
    robot: Robot | None = None
    Q: object = None
    decay: float = LARGEST_DECAY
    peak: float = LARGEST_PEAK
    cells: int | None = None
    patience: float = 0.0
    identified: object = None
    data: dict = field(default_factory=dict)

    def __post_init__(self):
        """Fill in the defaults and check the numbers."""
        Q = np.eye(5) if self.Q is None else np.asarray(self.Q, float)
        object.__setattr__(self, "Q", np.diag(Q) if Q.ndim == 1 else Q)
        robot = tuning.timed(self.robot or Robot.shipped("thesis"), self.mip)
        object.__setattr__(self, "robot", robot)
        if self.cells is None:
            many = FIT_CELLS if isinstance(self.spread, FitSpread) else MOST_CELLS
            object.__setattr__(self, "cells", many)
        if self.R is not None:
            positive("R", self.R)
        if positive("peak", self.peak) <= 1:
            raise ValueError(f"peak must be above 1, got {self.peak!r}")
        for name, unit in (("decay", "1/s"), ("patience", "s")):
            value = finite(name, getattr(self, name))
            if value < 0:
                raise ValueError(f"{name} must be 0 or more, in {unit}, got {value!r}")
        tilt = tuning.recoverable_tilt(self.mip, robot.limit)
        if tilt < LEAST_TILT:
            raise ValueError(
                f"the motors are too weak: {robot.limit:g} V can bring the robot "
                f"back from {np.degrees(tilt):.1f} degrees at most. It takes "
                f"{robot.limit * LEAST_TILT / tilt:.0f} V or stronger motors for "
                f"{np.degrees(LEAST_TILT):.0f} degrees"
            )

    @cached_property
    def design(self):
        """The `Design` of Theorem 2.4 over the polytope, or the `OptimalLaw`.

        The latter is of the robot in the middle; of it the sampled loops alone are
        proven.
        """
        return tuning.design(
            self.mip, self.robot, self.spread, self.Q, self.R, self.peak, self.gears
        )

    @cached_property
    def delayed(self):
        """The `DelayDesign` of the gain behind any delay up to T + delay + jitter.

        The hold, and a computer that takes the robot's delay; None for an
        `OptimalLaw`.
        """
        if self.optimal:
            return None
        plants, K = polytope(self.mip, self.spread), self.certificate.K
        return tuning.prove(plants, tuning.U, self.robot, K, self.decay)

    @property
    def optimal(self):
        """True if the design is an `OptimalLaw`, with the sampled proofs alone."""
        return self.robot.law != "gain"

    @cached_property
    def certificate(self):
        """A `DesignProof` of the design, in continuous time; not of an `OptimalLaw`.

        Its K has six digits and is the gain that goes onto the robot.
        """
        return self.design.certify()

    @cached_property
    def held(self):
        """The `DelayProof` of K behind the hold; not of an `OptimalLaw`."""
        return self.delayed.certify()

    @cached_property
    def law(self):
        """The `SampledLaw` of K, or of the `OptimalLaw`."""
        if self.optimal:
            return self.design.law
        gain = Gain(self.certificate.K, PID_SIGNALS)
        return SampledLaw.of_gain(gain, self.robot.T)

    @property
    def robots(self):
        """The one in the middle and the vertices."""
        return (self.mip, *vertices(self.mip, self.spread))

    @cached_property
    def loops(self):
        """Sampled loops of all robots for no, half and all delay.

        A dict from the delay in s to a tuple of `SampledLoop`, with the
        firmware's own sensing.
        """
        return tuning.loops(self.robots, self.law, self.robot)

    @property
    def radius(self):
        """The largest spectral radius of all `loops`."""
        return max(x.radius for row in self.loops.values() for x in row)

    @property
    def sensitivity(self):
        """The largest peak of the sensitivity of all `loops`."""
        return max(x.sensitivity for row in self.loops.values() for x in row)

    @cached_property
    def reach(self):
        """The tilt in rad up to which the program is seen to raise every robot.

        It is simulated, with all faults on, the delay at its largest and the encoders'
        counts; not proven.
        """
        robot = self.robot
        seconds = max(RESCUE_SECONDS, RESCUE * tuning.fall_time(self.mip))
        asked = self.robots, Firmware.of(self.law, robot), seconds, robot.tip
        how = dict(rounds=2, delay=robot.delay, substeps=4)
        tilts = largest_tilt(*asked, sensors=Sensors(counts=robot.counts), **how)
        return float(tilts.min())

    @property
    def gears(self):
        """The dry friction and the play that the logs allow."""
        return Gears.of(self.identified, self.robot)

    @cached_property
    def rest(self):
        """The volts (rms) of the program at rest, by a minute's run; not proven."""
        return volts_at_rest(self.mip, self.law, self.robot, REST_SECONDS, self.gears)

    @cached_property
    def sampled(self):
        """Proofs of `loops` for every plant of the polytope.

        A dict from the delay in s to a `SampledProof` for each of
        `triangles`; a range of delays stands for all of `varying`. They presume
        accelerometers that measure theta exactly.
        """
        if self.varying:
            return {(0.0, self.robot.delay): self.varying}
        parts, controller = triangles(self.mip, self.spread), self._controller
        return tuning.prove_sampled(parts, controller, self.robot, self.cells)

    @cached_property
    def varying(self):
        """Proofs of the loops under every sequence of delays and of late ticks.

        A tuple of `SampledProof`, one for each of `triangles`: each delay is
        at most the robot's, each tick late by at most its jitter. It is empty where
        they aren't found within the ``patience``.
        """
        if not self.patience:
            return ()
        parts = triangles(self.mip, self.spread)
        asked = self._controller, self.robot, self.cells, self.patience
        return tuning.prove_varying(parts, *asked)

    @cached_property
    def varying_robots(self):
        """As `varying`, of the one in the middle and of each vertex, one by one.

        Of an `OptimalLaw` whose plants `varying` doesn't have.
        """
        if self.varying or not self.optimal:
            return ()
        plants = [mip.plant() for mip in self.robots]
        return tuning.prove_varying(plants, self._controller, self.robot, self.cells)

    @cached_property
    def steering(self):
        """The `SteeringDesign` of a robot that has a track; else None."""
        if self.robot.track is None:
            return None
        laws = Firmware.of(self.law, self.robot), self._controller
        about = self.robot, self.robots, self.spread
        return SteeringDesign(*about, *laws, self.peak)

    @property
    def _controller(self):
        """The `SampledSystem` from the true [theta, phi, theta', phi'] to V."""
        return self.loops[0.0][0].controller

    @property
    def continuous_proofs(self):
        """The proofs of the gain in continuous time; none of an `OptimalLaw`."""
        if self.optimal:
            return {}
        return {"in continuous time": self.certificate, "behind the hold": self.held}

    @property
    def lacking_sampled(self):
        """The proofs of the sampled loops that fail, in words."""
        return [
            f"sampled, {1000 * late:g} ms late: " + "; ".join(sorted(reasons))
            for late, row in self.sampled.items()
            for reasons in [{text for proof in row for text in proof.failed}]
            if reasons
        ]

    @cached_property
    def lacking(self):
        """The proofs that fail, in words; empty if all hold."""
        failures = [
            f"{name}: {', '.join(proof.failed)}"
            for name, proof in self.continuous_proofs.items()
            if not proof.proven
        ]
        failures += self.lacking_sampled
        return (*failures, *(self.steering.lacking if self.steering else ()))

    @property
    def proven(self):
        """True if all proofs hold, those of the sampled loops too."""
        return not self.lacking

    @cached_property
    def facts(self):
        """The facts in the C program's header, from a word to a sentence."""
        return facts(self)

    @cached_property
    def firmware(self):
        """The `Firmware`, with the facts as its law's note."""
        note = (f"{word}: {text}" for word, text in self.facts.items())
        return Firmware.of(self.law.noted(*note), self.robot)

    @property
    def bench_firmware(self):
        """A `Firmware` to check signs, wheels in the air.

        It has the gains of theta and theta' alone and 2 V at most: in
        the air the gains of the wheels are positive feedback.
        """
        K = self.design.K[:, :4] if self.optimal else self.law.D
        law = SampledLaw.of_gain(Gain(K * [1, 0, 1, 0], PD_SIGNALS), self.robot.T)
        law = law.noted(
            "For the stand, wheels in the air, to check signs: the gains of theta and "
            "theta' alone. It doesn't balance.",
            f"robot: {self.robot.words}",
        )
        limit = min(BENCH_VOLTS, self.robot.limit)
        return Firmware.of(law, self.robot, limit=limit, compensation=0.0)

    @property
    def drive(self):
        """The `Drive`: how fast this robot may be told to roll and to turn."""
        drive = Drive.of(self.mip, self.robot.limit)
        return drive.turning(self.mip, self.robot) if self.steering else drive

    def write(self, folder, name="balance", replace=False):
        """Write the programs, their provenance and their proofs.

        ``folder``: made if it doesn't exist; ``name``: of the C functions and files;
        ``replace``: files of an earlier run that differ, as for `write_texts`. Returns
        list of Path: where the files stand. Raises ValueError if something isn't
        proven, or the sensitivity peaks above ``peak``: such a controller isn't
        written; FileExistsError if a file is there that may not be replaced: then
        nothing is written.
        """
        check(self)
        return write_texts(folder, texts(self, name), replace)
