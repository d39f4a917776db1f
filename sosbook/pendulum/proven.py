"""A controller for a robot, with its proofs."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..plants.checks import finite, positive
from ..plants.gain import Gain
from ..sampled import certify_sampled
from .drive import Drive
from .facts import facts
from .firmware import SOFTNESS, Firmware, share
from .law import PD_SIGNALS, PID_SIGNALS, SampledLaw
from .model import Mip
from .optimal import OptimalLaw
from .recording import write_texts
from .robot import Robot
from .spread import polytope, triangles, vertices
from .steering_design import steer
from .tuning import U, loops
from .written import texts

__all__ = ["Deployment"]

BENCH_VOLTS = 2.0  # V, at most, while the wheels hang free: enough to see them turn
MOST_CELLS = 600  # of the uncertain parameters, for one proof of the sampled loop
LARGEST_PEAK = 2.0  # of the sensitivity: 1/2 is then the distance from -1


@dataclass(frozen=True, eq=False)
class Deployment:
    """A controller for a robot, and what is known about it.

    Parameters
    ----------
    mip : Mip
        The robot in the middle.
    spread : float or FitSpread
        Relative spread of e/c and of e/a; or that of all five ratios, from a fit.
    design : Design or OptimalLaw
        Theorem 2.4 over the polytope, or an optimal law of the robot in the
        middle, of which the sampled loops alone are proven.
    delayed : DelayDesign or None
        The same plants and gain behind any delay from zero to T +
        delay: the hold, and a computer that takes ``delay``. None for an
        `OptimalLaw`.
    T, delay : float
        Time between samples, and from a sample to its voltage, in s.
    blend : float
        As in `Firmware`.
    cells : int
        As for `certify_sampled`, at most.
    peak : float
        The largest peak of the sensitivity with which it is written.
    identified : Identified or None
        What the logs say of the robot.
    robot : Robot, optional
        The robot's description; without it the thesis's robot, whose
        T, delay and blend are those above.
    data : dict
        Where the robot comes from: facts for the header.

    Raises
    ------
    ValueError
        If the parts are about different plants, gains or delays.
    """

    mip: Mip
    spread: object
    design: object
    delayed: object
    T: float
    delay: float
    blend: float
    cells: int = MOST_CELLS
    peak: float = LARGEST_PEAK
    identified: object = None
    robot: Robot | None = None
    data: dict = field(default_factory=dict)

    def __post_init__(self):
        positive("T", self.T)
        if finite("delay", self.delay) < 0:
            raise ValueError(f"delay must be 0 or more, in s, got {self.delay!r}")
        share("blend", self.blend)
        robot = self.robot or Robot.shipped("thesis")
        object.__setattr__(
            self, "robot", robot.but(T=self.T, delay=self.delay, blend=self.blend)
        )
        if not self.optimal:
            self._check_gain(robot)

    def _check_gain(self, robot):
        """A ValueError unless design and delayed are about this robot's gain."""
        about = self.delayed.request
        plants = (
            self.design.request.plant,
            about.plant,
            polytope(self.mip, self.spread),
        )
        for name in "MDSB":
            first, *others = (
                [getattr(v, name) for v in polytope_of_proof.vertices]
                for polytope_of_proof in plants
            )
            if not all(np.array_equal(first, other) for other in others):
                raise ValueError(
                    "design, delayed and mip with its spread are about different plants"
                )
        if not np.array_equal(self.delayed.K, self.certificate.K):
            raise ValueError(
                "delayed isn't about the design's gain, rounded to six digits"
            )
        least, most = about.tau - about.mu, about.tau + about.mu
        longest = self.T + self.delay + robot.jitter
        if least > 0 or most < longest * (1 - 1e-12):
            late = "T + delay" + " + jitter" * (robot.jitter > 0)
            raise ValueError(
                f"delayed is about {least:g} to {most:g} s, but must be "
                f"about 0 to {late} = {longest:g} s"
            )
        asked = self.design.request
        plain = asked.coupling == "pairs" and not about.misprints
        if not plain or any(not np.array_equal(x.U, U) for x in (asked, about)):
            raise ValueError(
                "design and delayed must be of U = [0 1], pairs of vertices "
                "and the theorem as mended: the header says so"
            )

    @property
    def optimal(self):
        """Whether the design is an `OptimalLaw`, with the sampled proofs alone."""
        return isinstance(self.design, OptimalLaw)

    @cached_property
    def certificate(self):
        """A `Certificate` of the design, in continuous time; not of an `OptimalLaw`.

        Its K has six digits and is the gain that goes onto the robot.
        """
        return self.design.certify()

    @cached_property
    def held(self):
        """The `DelayCertificate` of K behind the hold; not of an `OptimalLaw`."""
        return self.delayed.certify()

    @cached_property
    def law(self):
        """The `SampledLaw` of K, or of the `OptimalLaw`."""
        if self.optimal:
            return self.design.law
        # of this pendulum's plants and U = [0 1], as `_check_gain` has seen
        return SampledLaw.of_gain(Gain(self.certificate.K, PID_SIGNALS), self.T)

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
        return loops(self.robots, self.law, self.robot)

    @property
    def radius(self):
        """The largest spectral radius of all `loops`."""
        return max(x.radius for row in self.loops.values() for x in row)

    @property
    def sensitivity(self):
        """The largest peak of the sensitivity of all `loops`."""
        return max(x.sensitivity for row in self.loops.values() for x in row)

    @cached_property
    def sampled(self):
        """Proofs of `loops` for every plant of the polytope.

        A dict from the delay in s to a `SampledCertificate` for each of
        `triangles`. They presume accelerometers that measure theta exactly.
        """
        parts = triangles(self.mip, self.spread)
        return {
            late: tuple(
                certify_sampled(part, row[0].controller, self.T, late, cells=self.cells)
                for part in parts
            )
            for late, row in self.loops.items()
        }

    @cached_property
    def steering(self):
        """The `SteeringDesign` of a robot that has a track; else None."""
        if self.robot.track is None:
            return None
        return steer(
            self.mip,
            self.robots,
            self.robot,
            self._firmware(self.law, self.robot.limit, (), self.robot.compensation),
            self.loops[0.0][0].controller,
            self.spread,
            self.peak,
        )

    @property
    def continuous_proofs(self):
        """What is proven of the gain in continuous time; nothing of an `OptimalLaw`."""
        if self.optimal:
            return {}
        return {"in continuous time": self.certificate, "behind the hold": self.held}

    @cached_property
    def lacking(self):
        """The proofs that fail, in words; empty if all hold."""
        failures = [
            f"{name}: {', '.join(proof.failed)}"
            for name, proof in self.continuous_proofs.items()
            if not proof.proven
        ]
        for late, row in self.sampled.items():
            reasons = {text for proof in row for text in proof.failed}
            if reasons:
                failures.append(
                    f"sampled, {1000 * late:g} ms late: " + "; ".join(sorted(reasons))
                )
        return (*failures, *(self.steering.lacking if self.steering else ()))

    @property
    def proven(self):
        """Whether all proofs hold, those of the sampled loops too."""
        return not self.lacking

    def _advice(self):
        if self.blend == 0:
            return (
                "With blend = 0 nothing corrects the estimate of theta: "
                "take a blend above 0"
            )
        if any("undecided" in failure for failure in self.lacking):
            return "Where a proof is undecided, take more cells"
        return "Take a larger R, a smaller spread or delay"

    @cached_property
    def facts(self):
        """What the C program's header says, from a word to a sentence."""
        return facts(self)

    @cached_property
    def firmware(self):
        """The `Firmware`, with the facts as its note."""
        note = tuple(f"{word}: {text}" for word, text in self.facts.items())
        robot = self.robot
        return self._firmware(self.law, robot.limit, note, robot.compensation)

    def _firmware(self, law, limit, note, compensation=0.0):
        """A `Firmware` with what the description says of faults."""
        robot = self.robot
        return Firmware(
            law,
            limit=limit,
            tip=robot.tip,
            blend=self.blend,
            missing=robot.missing,
            frozen=robot.frozen,
            stall=robot.stall,
            gyro_range=robot.gyro_range,
            deaf=robot.deaf,
            compensation=compensation,
            note=note,
        )

    @property
    def bench_firmware(self):
        """A `Firmware` to check signs, wheels in the air.

        It has the gains of theta and theta' alone and 2 V at most: in
        the air the gains of the wheels are positive feedback.
        """
        return self._firmware(
            SampledLaw.of_gain(
                Gain(
                    (self.design.K[:, :4] if self.optimal else self.law.D)
                    * [1, 0, 1, 0],
                    PD_SIGNALS,
                ),
                self.T,
            ),
            min(BENCH_VOLTS, self.robot.limit),
            (
                "For the stand, wheels in the air, to check signs: the "
                "gains of theta and theta' alone. It doesn't balance.",
                f"robot: {self.robot.words}",
            ),
        )

    @property
    def drive(self):
        """The `Drive`: how fast this robot may be told to roll and to turn."""
        drive = Drive.of(self.mip, self.robot.limit)
        return drive.turning(self.mip, self.robot) if self.steering else drive

    def _check_coupling(self):
        """A ValueError if motors that differ as described unsettle the robot."""
        if self.steering and self.steering.coupled_radius >= 1:
            raise ValueError(
                f"unequal = {self.robot.unequal:g}: with motors that differ so much "
                "balance and steering aren't stable together: match the motors, or "
                "take a larger R"
            )

    def write(self, folder, name="balance", replace=False):
        """Write the programs, their provenance and their proofs.

        Parameters
        ----------
        folder : str or Path
            Made if it doesn't exist.
        name : str
            The name of the C functions and files.
        replace : bool
            As for `write_texts`: replace files of an earlier run that differ.

        Returns
        -------
        list of Path
            Where the files stand.

        Raises
        ------
        ValueError
            If something isn't proven, or the sensitivity peaks above
            ``peak``: such a controller isn't written.
        FileExistsError
            If a file is there that may not be replaced; then nothing is written.
        """
        if not self.proven:
            raise ValueError(
                "this controller isn't proven, so it isn't written. "
                + ". ".join(self.lacking)
                + ". "
                + self._advice()
            )
        sector = 1 + 1 / SOFTNESS
        if self.sensitivity > self.peak:
            raise ValueError(
                "this controller's margin is thin, so it isn't written: "
                f"its sensitivity peaks at {self.sensitivity:.2f}, above "
                f"{self.peak:g}. Leave R out, and the smallest that will "
                "do is searched"
            )
        if self.robot.compensation and self.sensitivity * (1 / SOFTNESS) >= sector:
            raise ValueError(
                f"compensation: with a sensitivity of {self.sensitivity:.2f} a gain "
                f"that varies from 1 to {sector:g} isn't known to be stable: take a "
                "larger R, or leave it out"
            )
        self._check_coupling()
        return write_texts(folder, texts(self, name), replace)
