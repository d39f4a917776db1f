"""From two logs to a C program: identify, design, prove, write.

``python -m sosbook.pendulum body.csv wheels.csv folder`` does it all.
"""

import hashlib
import json
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ..delay import analyse_delay
from ..plants.checks import number, positive
from ..sampled import certify_sampled
from ..synthesis.lqr import design_lqr
from .export import c_header, c_source, pyctrl_script, rc_balance
from .firmware import Firmware, share
from .identify import identify
from .law import SampledLaw
from .log import Log
from .margins import SampledLoop
from .model import Mip
from .spread import polytope, triangles, vertices

__all__ = ["Deployment", "deploy", "recommend"]

U = [[0, 1]]  # integrate phi
DECAY = 0.2  # 1/s, what the proof with the hold promises
FROZEN = 12  # ticks; a living gyro repeats itself so long in years
STAND = 2.0  # V
CELLS = 200  # at most so many for one proof of the sampled loop
MIDDLE = 0.5  # the delays that are looked at: none, half, all of it


@dataclass(frozen=True, eq=False)
class Deployment:
    """A controller for a robot, and what is known about it.

    Parameters
    ----------
    mip : Mip
        The robot in the middle.
    spread : float
        Of e/c and e/a, relative.
    design : Design
        Theorem 2.4 over the polytope.
    delayed : DelayDesign
        The same plants and gain behind any delay from zero to T +
        delay: the hold, and a computer that takes ``delay``.
    T, delay : float
        In s.
    blend : float
        As in `Firmware`.
    cells : int
        As for `certify_sampled`, at most.
    identified : Identified or None
        What the logs say of the robot.
    data : dict
        Where the robot comes from: facts for the header.

    Raises
    ------
    ValueError
        If the parts are about different plants, gains or delays.
    """

    mip: Mip
    spread: float
    design: object
    delayed: object
    T: float
    delay: float
    blend: float
    cells: int = CELLS
    identified: object = None
    data: dict = field(default_factory=dict)

    def __post_init__(self):
        about = self.delayed.request
        plants = (self.design.request.plant, about.plant,
                  polytope(self.mip, self.spread))
        for name in "MDSB":
            first, *others = (
                [getattr(v, name) for v in each.vertices] for each in plants)
            if not all(np.array_equal(first, other) for other in others):
                raise ValueError("design, delayed and mip with its spread "
                                 "are about different plants")
        if not np.array_equal(self.delayed.K, self.certificate.K):
            raise ValueError("delayed isn't about the design's gain, "
                             "rounded to six digits")
        positive("T", self.T)
        if number("delay", self.delay) < 0:
            raise ValueError(
                f"delay must be 0 or more, in s, got {self.delay!r}")
        share("blend", self.blend)
        least, most = about.tau - about.mu, about.tau + about.mu
        if least > 0 or most < (self.T + self.delay) * (1 - 1e-12):
            raise ValueError(
                f"delayed is about {least:g} to {most:g} s, but must be "
                f"about 0 to T + delay = {self.T + self.delay:g} s")
        asked = self.design.request
        plain = np.array_equal(asked.cost.Q, np.eye(5)) and (
            asked.coupling == "pairs" and not about.misprints)
        if not plain or any(not np.array_equal(x.U, U)
                            for x in (asked, about)):
            raise ValueError(
                "design and delayed must be of Q = I, U = [0 1], pairs of "
                "vertices and the theorem as mended: the header says so")

    @cached_property
    def certificate(self):
        """A `Certificate` of the design, in continuous time.

        Its K has six digits and is the gain that goes onto the robot.
        """
        return self.design.certify()

    @cached_property
    def held(self):
        """The `DelayCertificate` of K behind the hold."""
        return self.delayed.certify()

    @cached_property
    def law(self):
        """The `SampledLaw` of K."""
        return SampledLaw.of_gain(self.certificate.K, self.T)

    @property
    def robots(self):
        """The one in the middle and the four vertices."""
        return (self.mip, *vertices(self.mip, self.spread))

    @cached_property
    def loops(self):
        """Sampled loops of all robots for no, half and all delay.

        A dict from the delay in s to a tuple of `SampledLoop`, with the
        firmware's own sensing.
        """
        return {
            late: tuple(
                SampledLoop(robot, self.law, late, "firmware", self.blend)
                for robot in self.robots)
            for late in (0.0, MIDDLE * self.delay, self.delay)
        }

    @property
    def radius(self):
        """The largest spectral radius of all `loops`."""
        return max(x.radius for row in self.loops.values() for x in row)

    @property
    def sensitivity(self):
        """The largest peak of the sensitivity of all `loops`."""
        return max(
            x.sensitivity for row in self.loops.values() for x in row)

    @cached_property
    def sampled(self):
        """Proofs of `loops` for every plant of the polytope.

        A dict from the delay in s to two `SampledCertificate`, one for
        each of `triangles`. What they say of the estimate of theta
        takes the accelerometers by their word.
        """
        parts = triangles(self.mip, self.spread)
        return {
            late: tuple(
                certify_sampled(part, row[0].controller, self.T, late,
                                cells=self.cells)
                for part in parts)
            for late, row in self.loops.items()
        }

    @cached_property
    def lacking(self):
        """The proofs that fail, in words; empty if all hold."""
        found = []
        for name, proof in (("in continuous time", self.certificate),
                            ("behind the hold", self.held)):
            if not proof.proven:
                found.append(f"{name}: {', '.join(proof.failed)}")
        for late, row in self.sampled.items():
            words = {text for proof in row for text in proof.failed}
            if words:
                found.append(f"sampled, {1000 * late:g} ms late: "
                             + "; ".join(sorted(words)))
        return tuple(found)

    @property
    def proven(self):
        """Whether all proofs hold, those of the sampled loops too."""
        return not self.lacking

    @cached_property
    def facts(self):
        """What the C program's header says, from a word to a sentence."""
        mip, T = self.mip, self.law.T
        letters = ", ".join(
            f"{x} = {getattr(mip, x):.6g}" for x in "abcdef")
        return {
            **self.data,
            "plant": f"{letters} (SI units), I_w = {mip.I_w:.6g}",
            "spread": f"e/c and e/a off by {100 * self.spread:g} %, either "
            "way",
            "specification": "least quadratic cost (Theorem 2.4, vertices "
            "and pairs), Q = I, R = "
            f"{self.design.request.cost.R[0, 0]:g}, U = [0 1]",
            "gain": " ".join(f"{k:.6g}" for k in self.certificate.K[0]),
            "proof": "; ".join(self.certificate.claims) or "none",
            "proof with the hold": "; ".join(self.held.claims) or "none",
            "proof of the sampled loop": self._sampled_in_words(),
            "sampling": f"T = {T:g} s, computed within {self.delay:g} s",
            "estimate": f"{self.blend:g} of the accelerometers' tilt per "
            "tick; the proof of the sampled loop takes it for the truth",
            "sampled loop": f"spectral radius {self.radius:.4f}, peak "
            f"sensitivity {self.sensitivity:.3f}, worst of "
            f"{len(self.robots)} robots and {len(self.loops)} delays",
            "written by": f"sosbook {version('sosbook')}",
        }

    def _sampled_in_words(self):
        if not all(x.proven for row in self.sampled.values() for x in row):
            return "none"
        delays = ", ".join(f"{1000 * late:g}" for late in self.sampled)
        return ("every plant of the polytope, with this law and its "
                "estimates of theta, phi and phi', is stable for each of "
                f"the constant delays {delays} ms")

    @cached_property
    def firmware(self):
        """The `Firmware`, with the facts as its note."""
        note = tuple(f"{word}: {text}" for word, text in self.facts.items())
        return Firmware(
            self.law, blend=self.blend, frozen=FROZEN, note=note)

    @property
    def stand(self):
        """A `Firmware` to check signs, wheels in the air.

        It has the gains of theta and theta' alone and 2 V at most: in
        the air the gains of the wheels are positive feedback.
        """
        return Firmware(
            SampledLaw.of_gain(self.law.D * [1, 0, 1, 0], self.T),
            limit=STAND, blend=self.blend, frozen=FROZEN, note=(
                "For the stand, wheels in the air, to check signs: the "
                "gains of theta and theta' alone. It doesn't balance.",))

    def write(self, folder, name="balance"):
        """Write the programs and their provenance.

        Parameters
        ----------
        folder : str or Path
            Made if it doesn't exist.
        name : str
            Of the C functions and files.

        Returns
        -------
        list of Path

        Raises
        ------
        ValueError
            If something isn't proven: such a controller isn't written.
        """
        if not self.proven:
            raise ValueError(
                "this controller isn't proven, so it isn't written. "
                + ". ".join(self.lacking)
                + ". Take another R, a smaller spread or delay, or more "
                "cells where a proof is undecided")
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        texts = {f"provenance_{name}.json": json.dumps(
            self.facts, indent=2) + "\n"}
        for precision, suffix in (("double", ""), ("single", "_single")):
            texts[f"{name}{suffix}.h"] = c_header(
                self.firmware, f"{name}{suffix}", precision)
            texts[f"{name}{suffix}.c"] = c_source(
                self.firmware, f"{name}{suffix}", precision)
        texts[f"{name}_stand.h"] = c_header(self.stand, f"{name}_stand")
        texts[f"{name}_stand.c"] = c_source(self.stand, f"{name}_stand")
        for each, firmware in ((name, self.firmware),
                               (f"{name}_stand", self.stand)):
            texts[f"rc_{each}.c"] = rc_balance(firmware, each)
            texts[f"pyctrl_{each}.py"] = pyctrl_script(firmware)
        for file, text in texts.items():
            (folder / file).write_bytes(text.encode())
        return [folder / file for file in texts]


def recommend(mip, R=20.0, spread=0.04, T=0.01, delay=0.01, blend=0.005,
              **more):
    """The controller that this book recommends for a robot.

    Parameters
    ----------
    mip : Mip
        With I_w.
    R : float
        Weight of the voltage, beside Q = I.
    spread : float
        Of e/c and e/a, relative.
    T : float
        Time between samples, in s.
    delay : float
        The longest time from the sample to the voltage, in s.
    blend : float
        As in `Firmware`.
    **more
        cells, identified and data of `Deployment`.

    Returns
    -------
    Deployment

    Raises
    ------
    ValueError
        On bad input, or where there is no design.
    """
    positive("R", R)
    positive("T", T)
    share("blend", blend)
    if number("delay", delay) < 0:
        raise ValueError(f"delay must be 0 or more, in s, got {delay!r}")
    plants = polytope(mip, spread)
    design = design_lqr(plants, np.eye(5), [[R]], U)
    if design.status != "feasible":
        raise ValueError(f"no design: {design.advice}")
    K, longest = design.certify().K, T + delay
    delayed = analyse_delay(
        plants, K, U, tau=longest / 2, mu=longest / 2, delta=DECAY)
    if delayed.status != "feasible":
        raise ValueError(
            f"no proof with the hold for R = {R:g}: {delayed.status}; take "
            "a larger R, or a smaller T, delay or spread")
    return Deployment(mip, spread, design, delayed, T, delay, blend, **more)


def deploy(body, wheels, robot=None, **asked):
    """From the logs of the two experiments to a controller.

    Parameters
    ----------
    body, wheels : str or Path
        CSV files, as `Log.read` takes them.
    robot : dict, optional
        Masses, lengths and counts that differ from the thesis's, as
        `identify` takes them: M_b, l, r, M_w, g, counts.
    **asked
        As for `recommend`.

    Returns
    -------
    Deployment
    """
    found = identify(Log.read(body), Log.read(wheels), **(robot or {}))
    sd = np.sqrt(np.diag(found.covariance))
    data = {
        f"log of the {name}": f"{Path(path).name}, sha256 "
        + hashlib.sha256(Path(path).read_bytes()).hexdigest()
        for name, path in (("body", body), ("wheels", wheels))
    }
    data["identified"] = ", ".join(
        f"{name.replace('_', '/')} = {value:.5g} +- {1.96 * s:.2g}"
        for (name, value), s in zip(found.ratios.items(), sd))
    data |= {name: f"{value:g}" for name, value in (robot or {}).items()}
    return recommend(found.mip, identified=found, data=data, **asked)
