"""The pendulum and the program of a deployment, as a file of numbers."""

import json
from dataclasses import asdict, dataclass

import numpy as np

from ..plants.checks import numbers
from ..runtime.reading import named, path_of, read_json
from .firmware import Firmware
from .fit_spread import FitSpread
from .law import SampledLaw
from .model import Mip
from .robot import Robot
from .steering import Steering

__all__ = ["Model"]

FORMAT = "sosbook pendulum model 1"
LAW = "A", "B", "C", "D", "W", "start"
PLANT = "M", "D", "S", "B"


@dataclass(frozen=True, eq=False)
class Model:
    """The robot, law and proofs of a program, read back from its folder.

    ``mip``: the pendulum in the middle; ``robot``: the robot's description; ``spread``:
    the relative spread of e/c and of e/a that was proven, or that of a fit; ``law``:
    the law; ``K_steering``, (1, 3): the gain of the `Steering` of a robot that steers.
    """

    mip: Mip
    robot: Robot
    spread: object
    law: SampledLaw
    K_steering: object = None

    @classmethod
    def of(cls, deployment):
        """The model of a ``deployment``."""
        d, designed = deployment, deployment.steering
        return cls(
            d.mip, d.robot, d.spread, d.law, designed.law.K if designed else None
        )

    @classmethod
    def read(cls, folder):
        """The model in a ``folder`` that `Deployment.write` wrote, or in its file.

        Raises ValueError if there is none, or more than one, or it isn't what `text`
        writes.
        """
        path = path_of(folder)
        paths = sorted(path.glob("model_*.json")) if path.is_dir() else [path]
        if len(paths) != 1:
            raise ValueError(
                f"{folder} has {len(paths)} files model_*.json, but must have one: "
                "give the folder that the command wrote, or one of the files"
            )
        table = read_json(paths[0])
        if not isinstance(table, dict) or table.get("format") != FORMAT:
            raise ValueError(
                f"{paths[0]} isn't a model of this version ({FORMAT}): write the "
                "programs again"
            )
        try:
            return cls._of(table, str(paths[0]))
        except (LookupError, TypeError, AttributeError, ArithmeticError) as error:
            raise ValueError(
                f"{paths[0]} lacks something that a model has, or it has another "
                f"shape ({type(error).__name__}: {str(error)!r:.80}): write the "
                "programs again"
            ) from None

    @classmethod
    def _of(cls, table, source):
        """The model of a file's contents; what is missing raises anything."""
        law = table["law"]
        order = len(law["start"])
        shapes = dict(A=(order, order), B=(order, 4), C=(1, order), D=(1, 4))
        shapes |= dict(W=(order, 1), start=(order,))
        with named(source):
            matrices = {x: np.reshape(numbers(x, law[x]), shapes[x]) for x in LAW}
            return cls(
                Mip(**table["pendulum"]),
                Robot.of(table["robot"], source),
                _spread(table["spread"]),
                SampledLaw(**matrices, T=law["T"]),
                table.get("gain of steering"),
            )

    @property
    def text(self):
        """The file's text: JSON, whose numbers are exact."""
        robot = {x: value for x, value in vars(self.robot).items() if value is not None}
        law = {x: getattr(self.law, x).tolist() for x in LAW} | {"T": self.law.T}
        plant = self.mip.plant()
        table = {
            "format": FORMAT,
            "pendulum": asdict(self.mip),
            "linear plant, M z'' + D z' + S z = B V of z = [theta, phi]": {
                x: getattr(plant, x).tolist() for x in PLANT
            },
            "spread": _noted(self.spread),
            "law": law,
            "robot": robot,
        }
        if self.K_steering is not None:
            table["gain of steering"] = np.asarray(self.K_steering).tolist()
        return json.dumps(table, indent=1) + "\n"

    @property
    def firmware(self):
        """The `Firmware` that the program is."""
        return Firmware.of(self.law, self.robot)

    @property
    def steering(self):
        """The `Steering` beside it; None of a robot that doesn't steer."""
        if self.K_steering is None:
            return None
        robot = self.robot
        return Steering(
            self.firmware, self.K_steering, robot.steering, robot.track, robot.r
        )


def _noted(spread):
    """A spread as JSON has it: a number, or a fit's covariance and confidence."""
    if not isinstance(spread, FitSpread):
        return spread
    return {
        "covariance of c, e, f, I_w, relative": spread.covariance.tolist(),
        "confidence": spread.confidence,
    }


def _spread(noted):
    """The spread that was noted."""
    return FitSpread(*noted.values()) if isinstance(noted, dict) else noted
