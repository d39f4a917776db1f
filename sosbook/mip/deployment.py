"""From two logs to a C program: identify, design, prove, write.

``python -m sosbook.mip.deployment body.csv wheels.csv folder`` does it all;
without logs it takes those that the package ships.
"""

import argparse
import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ..delay import analyse_delay
from ..lqr import design_lqr
from ..sampled import certify_sampled
from ..system import number, positive
from .export import c_header, c_source, pyctrl_script, rc_balance
from .firmware import Firmware
from .identify import identify
from .law import SampledLaw
from .log import Log
from .margins import SampledLoop
from .model import Mip
from .rig import DATA
from .spread import polytope, triangles, vertices

__all__ = ["Deployment", "deploy", "recommend"]

U = [[0, 1]]  # integrate phi
DECAY = 0.2  # 1/s, what the proof with the hold promises
FROZEN = 25  # ticks; that a living gyro repeats itself so long is hopeless
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
    certificate : Certificate
        Of the design, in continuous time; its K has six digits and is
        the gain that goes onto the robot.
    held : DelayCertificate
        Of the same K behind any delay from zero to T + delay: the hold,
        and a computer that takes ``delay``.
    delay : float
        In s.
    law : SampledLaw
    blend : float
        As in `Firmware`.
    data : dict
        What the robot was identified from: facts for the header.
    """

    mip: Mip
    spread: float
    design: object
    certificate: object
    held: object
    delay: float
    law: SampledLaw
    blend: float
    data: dict

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
                certify_sampled(part, row[0].controller, self.law.T, late,
                                cells=CELLS)
                for part in parts)
            for late, row in self.loops.items()
        }

    @cached_property
    def proven(self):
        """Whether all proofs hold, those of the sampled loops too."""
        return (self.certificate.proven and self.held.proven
                and self.radius < 1
                and all(x.proven for row in self.sampled.values()
                        for x in row))

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
                "estimates of theta, phi and phi', is stable, computed "
                f"within {delays} ms")

    @cached_property
    def firmware(self):
        """The `Firmware`, with the facts as its note."""
        note = tuple(f"{word}: {text}" for word, text in self.facts.items())
        return Firmware(
            self.law, blend=self.blend, frozen=FROZEN, note=note)

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
                "this controller isn't proven, so it isn't written: "
                "take a larger R, a smaller spread or delay; see "
                "certificate, held, loops and sampled")
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        texts = {f"provenance_{name}.json": json.dumps(
            self.facts, indent=2) + "\n"}
        for precision, suffix in (("double", ""), ("single", "_single")):
            texts[f"{name}{suffix}.h"] = c_header(
                self.firmware, f"{name}{suffix}", precision)
            texts[f"{name}{suffix}.c"] = c_source(
                self.firmware, f"{name}{suffix}", precision)
        texts[f"rc_{name}.c"] = rc_balance(self.firmware)
        texts[f"pyctrl_{name}.py"] = pyctrl_script(self.firmware)
        for file, text in texts.items():
            (folder / file).write_bytes(text.encode())
        return [folder / file for file in texts]


def recommend(mip, R=20.0, spread=0.04, T=0.01, delay=0.01, blend=0.005,
              data=None):
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
    data : dict, optional
        Facts about where mip comes from.

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
    if number("delay", delay) < 0:
        raise ValueError(f"delay must be 0 or more, in s, got {delay!r}")
    plants = polytope(mip, spread)
    design = design_lqr(plants, np.eye(5), [[R]], U)
    if design.status != "feasible":
        raise ValueError(f"no design: {design.advice}")
    certificate = design.certify()
    longest = T + delay
    held = analyse_delay(
        plants, certificate.K, U, tau=longest / 2, mu=longest / 2,
        delta=DECAY)
    return Deployment(
        mip, spread, design, certificate, held.certify(), delay,
        SampledLaw.of_gain(certificate.K, T), blend, data or {})


def deploy(body, wheels, **asked):
    """From the logs of the two experiments to a controller.

    Parameters
    ----------
    body, wheels : str or Path
        CSV files, as `Log.read` takes them.
    **asked
        As for `recommend`.

    Returns
    -------
    Deployment
    """
    found = identify(Log.read(body), Log.read(wheels))
    sd = np.sqrt(np.diag(found.covariance))
    data = {
        f"log of the {name}": f"{Path(path).name}, sha256 "
        + hashlib.sha256(Path(path).read_bytes()).hexdigest()
        for name, path in (("body", body), ("wheels", wheels))
    }
    data["identified"] = ", ".join(
        f"{name.replace('_', '/')} = {value:.5g} +- {1.96 * s:.2g}"
        for (name, value), s in zip(found.ratios.items(), sd))
    return recommend(found.mip, data=data, **asked)


def main(words=None):
    """The command; returns the `Deployment`."""
    parser = argparse.ArgumentParser(
        prog="python -m sosbook.mip.deployment", description=__doc__)
    parser.add_argument("body", nargs="?", default=DATA / "body.csv")
    parser.add_argument("wheels", nargs="?", default=DATA / "wheels.csv")
    parser.add_argument("folder", nargs="?", default="deployment")
    parser.add_argument("-R", type=float, default=20.0,
                        help="weight of the voltage")
    parser.add_argument("--spread", type=float, default=0.04)
    asked = parser.parse_args(words)
    found = deploy(asked.body, asked.wheels, R=asked.R, spread=asked.spread)
    for word, text in found.facts.items():
        print(f"{word}: {text}")
    for path in found.write(asked.folder):
        print(f"wrote {path}")
    return found


if __name__ == "__main__":
    main()
