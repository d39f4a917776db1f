"""From two logs to the pendulum: the identification of section 4.2."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from .fit import Fit
from .log import Log
from .log_fits import fit_body, fit_wheel, speed  # noqa: F401
from .model import Mip
from .rig import COUNTS_PER_TURN
from .spread import polytope

__all__ = ["Identified", "fitted", "identify"]

LEAST_SHARE = 0.02  # of the inertia on the motors' side: less is too stiff to simulate


@dataclass(frozen=True, eq=False)
class Identified:
    """A pendulum identified from two logs.

    ``ratios``: e_c, f_c, d_c of the body, e_a, f_a of the wheels: their mean;
    ``covariance``, (5, 5): the covariance of the ratios, in their order. The two logs
    are independent; ``mip``: the pendulum that fits the ratios best; ``body``: the fit
    to the log of the body's experiment; ``wheels``: one for each encoder.
    """

    ratios: dict
    covariance: np.ndarray
    mip: Mip
    body: Fit
    wheels: tuple

    @property
    def contradiction(self):
        """(e/f by the wheels) / (e/f by the body): one, on one robot.

        Far from one, a unit is wrong, such as ``counts``, or a sensor
        late. The thesis's numbers give 1.48. Where the body's fit has the wheels'
        f/e, this is by its log alone.
        """
        x = self.ratios
        return x["e_a"] / x["f_a"] / (self.body.alone or x["e_c"] / x["f_c"])

    def polytope(self, spread=0.04):
        """`polytope` of the pendulum, with a ``spread`` as that of (4.25)."""
        return polytope(self.mip, spread)


def fitted(experiment, log, counts, friction, share=None, near=None):
    """The fits to the ``log`` of an ``experiment``: the body's, or one for each wheel.

    ``counts`` and ``friction`` are as for `identify`, ``share`` and ``near`` as for
    `fit_body`.
    """
    if experiment == "body":
        return (fit_body(log, friction=friction, share=share, near=near),)
    wheels = (1,) if log.encoder2 is None else (1, 2)
    asked = dict(counts=counts, friction=friction, share=share)
    return tuple(fit_wheel(log, k, **asked) for k in wheels)


def ratios_of(body, wheels):
    """The five ratios of the fits: of several ``wheels`` the mean."""
    ratios = {x: body[x] for x in ("e_c", "f_c", "d_c")}
    for x in ("e_a", "f_a"):
        ratios[x] = float(np.mean([wheel[x] for wheel in wheels]))
    return ratios


def shares(ratios, robot):
    """Of the inertia on the motors' side of the gears: J / c, J / (2 I_w).

    The rotors' J is what the wheels' inertia is beyond discs', by the ``ratios``
    and the masses and lengths of a ``robot``.
    """
    of = Mip.from_ratios.__func__.__kwdefaults__ | robot
    c = of["M_b"] * of["g"] * of["l"] / ratios["d_c"]
    double = ratios["e_c"] / ratios["e_a"] * c
    J = double - of["M_w"] * of["r"] ** 2
    return [float(np.clip(J / x, LEAST_SHARE, 1 - LEAST_SHARE)) for x in (c, double)]


def identify(log_body, log_wheels, counts=COUNTS_PER_TURN, friction=False, **robot):
    """Identify a pendulum from the logs of its two experiments.

    ``log_body``: a log with the gyro, of a robot that is held by its wheels, upside
    down; ``log_wheels``: a log with encoder1 or both encoders, of a robot that lies on
    its back; ``counts``: counts per turn of a wheel; ``friction``: fit Coulomb friction
    too, and a play of the gears where the logs show one; ``**robot``: masses and
    lengths M_b, l, r, M_w, g, and rotors: see `Mip.from_ratios`. Returns the pendulum,
    its ratios with their covariance, and the fits. Raises ValueError: on wrong
    arguments, or logs that give no pendulum.

    Source: thesis section 4.2, with the pendulum's sine and the
    encoders' differencing in the models.
    """
    for name, log in (("log_body", log_body), ("log_wheels", log_wheels)):
        if not isinstance(log, Log):
            raise ValueError(f"{name} must be a Log: Log.read(path)")
    of_body, of_wheels, near = None, None, None
    if friction:  # what each side of the gears has of the inertia, roughly
        rough = [*fitted("body", log_body, counts, False)]
        rough.append(fitted("wheels", log_wheels, counts, False))
        of_body, of_wheels = shares(ratios_of(*rough), robot)
    wheels = fitted("wheels", log_wheels, counts, friction, of_wheels)
    if friction:
        near = wheels[0]
    (body,) = fitted("body", log_body, counts, friction, of_body, near)
    ratios = ratios_of(body, wheels)
    of = Mip.from_ratios.__func__.__kwdefaults__ | robot
    if ratios["d_c"] > of["g"] / of["l"]:
        raise ValueError(
            f"d/c = {ratios['d_c']:.4g} by the log of the body is more than gravity "
            f"gives a mass at l, g/l = {of['g'] / of['l']:.4g} 1/s^2: M_b l^2 is "
            "larger than the body's inertia about the axle. Check l, and that t is in "
            "seconds"
        )
    mean = sum(w.covariance[:2, :2] for w in wheels) / len(wheels) ** 2
    return Identified(
        ratios,
        block_diag(body.covariance[:3, :3], mean),
        Mip.from_ratios(**ratios, **robot),
        body,
        wheels,
    )
