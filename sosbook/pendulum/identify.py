"""From two logs to the pendulum: the identification of section 4.2."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import block_diag

from .experiments import STICTION_SPEED, motion, slopes
from .fit import Fit, output_error
from .log import Log
from .model import Mip
from .rig import COUNTS_PER_TURN
from .spread import polytope
from .srivc import respond, srivc

__all__ = ["Identified", "fit_body", "fit_wheel", "fitted", "identify", "speed"]

BODY_MODELS = ("pendulum", "linear", "free zero")
SHARPER_STICTION = (
    0.15,
    0.05,
)  # rad/s, tried beside `STICTION_SPEED` where friction is fitted
COARSE_COUNT = 0.5  # one count a sample over the speed's deviation: coarser is no noise
AS_GOOD_RATIO = 1.02  # of the residuals' rms to the best fit's: such a fit is as good


def fit_body(log, model="pendulum", friction=False):
    r"""The body's experiment: e/c, f/c, d/c.

    Parameters
    ----------
    log : Log
        A log with the gyro, of a body that hangs at rest at first.
    model : {"pendulum", "linear", "free zero"}
        The pendulum (4.16) with its sine; its linearisation (4.18);
        or (4.19), a linear one with one more parameter, "zero":
        (-e_c s + zero) / (s^2 + f_c s + d_c).
    friction : bool
        Fit Coulomb friction too, in V. Only with the pendulum.

    Returns
    -------
    Fit
        Its parameters are e_c, f_c, d_c (, zero or friction) and offset, what
        the gyro says at rest, in rad/s.

    Raises
    ------
    ValueError
        On a wrong model, no gyro, or a log that gives no swinging body.

    Notes
    -----
    Source: thesis (4.16), (4.18), (4.19).

    Examples
    --------
    >>> from sosbook.pendulum.rig import shipped
    >>> round(fit_body(shipped("body"))["d_c"], 1)
    110.6
    """
    if model not in BODY_MODELS:
        raise ValueError(f"model must be one of {BODY_MODELS}, got {model!r}")
    if friction and model != "pendulum":
        raise ValueError("friction needs model='pendulum'")
    (gyro,), V, T = log.need("gyro"), log.V, log.T
    if model != "pendulum" and not log.even:
        raise ValueError(
            "a log whose samples aren't equally far apart needs model='pendulum'"
        )
    zeros = [1, 0] if model == "free zero" else [1]
    held, smooth = (V, gyro) if log.even else log.evenly(gyro)
    B, A = srivc(held, smooth - smooth.mean(), T, zeros, 2, cutoff=10.0)
    start = dict(e_c=-B[0], f_c=A[0], d_c=A[1])

    def linear(e, f, d, *zero_and_offset):
        zero, offset = (0.0, *zero_and_offset)[-2:]
        return respond([-e, zero], [1.0, f, d], V, T) + offset

    swing = Experiment(V, log.steps)

    def pendulum(e, f, d, *friction_and_offset):
        rub, offset = (0.0, *friction_and_offset)[-2:]
        return swing.motion(-e, f, d, rub)[1] + offset

    def pendulum_slopes(e, f, d, *friction_and_offset):
        rub = (0.0, *friction_and_offset)[-2]
        _, (de, *others) = swing.slopes(-e, f, d, rub)
        others = others if friction else others[:2]
        return np.stack([-de, *others, np.ones(len(V))], axis=1)

    if model == "free zero":
        start["zero"] = B[1]
    if friction:
        start["friction"] = 0.01 * np.ptp(V)
    start["offset"] = gyro.mean()
    models = (linear,) if model in BODY_MODELS[1:] else (pendulum, pendulum_slopes)
    fit = output_error(models[0], gyro, start, *models[1:])
    if friction:
        start, fits = dict(zip(fit.names, fit.values)), [fit]
        for stick in SHARPER_STICTION:
            swing = Experiment(V, log.steps, 4, stick)
            fits.append(output_error(pendulum, gyro, start, pendulum_slopes))
        fit = best(fits)
    return signs(fit, "body", "the gyro or the motors")


def speed(log, wheel=1, counts=COUNTS_PER_TURN):
    """Differenced counts, in rad/s: the mean since the last sample.

    Parameters
    ----------
    log : Log
        A log with that wheel's encoder.
    wheel : {1, 2}
    counts : float
        Counts per turn of the wheel.

    Returns
    -------
    (N - 1,) array
        The speed between t[0] and t[1], and so on.
    """
    if wheel not in (1, 2):
        raise ValueError(f"wheel must be 1 or 2, got {wheel!r}")
    (count,) = log.need(f"encoder{wheel}")
    return np.diff(count) * 2 * np.pi / counts / log.steps[:-1]


def fit_wheel(
    log, wheel=1, differencing="modelled", counts=COUNTS_PER_TURN, friction=False
):
    r"""The wheels' experiment: e/a, f/a, with a = 2 I_w.

    Parameters
    ----------
    log : Log
        A log with the wheel's encoder.
    wheel : {1, 2}
    differencing : {"modelled", "plain"}
        A difference of counts is the mean speed of one period, and so
        the model forms it; or, as is often done, it is taken for the
        speed at the period's end.
    counts : float
        Counts per turn of the wheel.
    friction : bool
        Fit Coulomb friction too, in V. Only with "modelled".

    Returns
    -------
    Fit
        Its parameters are e_a, f_a (, friction).

    Raises
    ------
    ValueError
        On a wrong argument, no encoder, or a log that gives no wheel.

    Notes
    -----
    Source: thesis (4.22).

    Examples
    --------
    >>> from sosbook.pendulum.rig import shipped
    >>> fit = fit_wheel(shipped("wheels"))
    >>> low, high = fit.interval("e_a")
    >>> low < 208.8 < high
    True
    """
    if differencing not in ("modelled", "plain"):
        raise ValueError(
            f"differencing must be 'modelled' or 'plain', got {differencing!r}"
        )
    if friction and differencing == "plain":
        raise ValueError("friction needs differencing='modelled'")
    if differencing == "plain" and not log.even:
        raise ValueError(
            "a log whose samples aren't equally far apart needs differencing='modelled'"
        )
    y, V, T = speed(log, wheel, counts), log.V, log.T
    held, smooth = V, np.append(0.0, y)
    if not log.even:
        held, smooth = log.evenly(smooth)
    B, A = srivc(held, smooth, T, [0], 1, cutoff=30.0)
    start = dict(e_a=B[0], f_a=A[0])

    def plain(e, f):
        return respond([e], [1.0, f], V, T)[1:]

    def modelled(e, f):
        return np.diff(respond([e], [1.0, f, 0.0], V, T)) / T

    steps = log.steps
    spin = Experiment(V, steps, 4)

    def rubbing(e, f, friction=0.0):
        return np.diff(spin.motion(e, f, 0.0, friction)[0]) / steps[:-1]

    def rubbing_slopes(e, f, *rub):
        (de, df, _, dr), _ = spin.slopes(e, f, 0.0, *rub)
        angles = np.array([de, df, dr] if rub else [de, df])
        return (np.diff(angles) / steps[:-1]).T

    if friction:
        start["friction"] = 0.01 * np.ptp(V)
    if friction or not log.even:
        models = rubbing, rubbing_slopes
    else:
        models = (plain if differencing == "plain" else modelled,)
    fit = output_error(models[0], y, start, *models[1:])
    if friction:
        start, fits = dict(zip(fit.names, fit.values)), [fit]
        for stick in SHARPER_STICTION:
            spin = Experiment(V, steps, 4, stick)
            fits.append(output_error(rubbing, y, start, rubbing_slopes))
        fit = best(fits)
    quantum = 2 * np.pi / counts / T
    if differencing == "modelled" and quantum > COARSE_COUNT * np.std(y):
        angles = np.cumsum(np.append(0.0, (y - fit.residuals) * steps[:-1]))
        fit = coarse(fit, angles, quantum * T, steps[:-1], *models)
    return signs(fit, "wheels", f"encoder{wheel} or the motors")


class Experiment:
    """The motions under one voltage, and how they move with the parameters."""

    def __init__(self, V, T, steps=1, stick=STICTION_SPEED):
        self.V, self.T, self.steps, self.stick = V, T, steps, stick
        # a fit asks for the slopes where it has just asked for the motion
        self.motion = lru_cache(maxsize=1)(self._motion)

    def _motion(self, e, f, d, friction=0.0):
        return motion(e, f, d, self.V, self.T, friction, self.steps, self.stick)

    def slopes(self, e, f, d, friction=0.0):
        """Those of `motion`: angle and speed, each by e, f, d and friction."""
        path = self.motion(e, f, d, friction)
        V, T = self.V, self.T
        return slopes(*path, e, f, d, V, T, friction, self.steps, self.stick)


def coarse(fit, angles, one, steps, *models):
    """A fit to counts so coarse that they aren't noise, made honest.

    The fit is repeated on its own model's angles, rounded down to
    counts from several starts: their mean says the bias, their spread
    the uncertainty.
    """
    again = []
    for part in (0.1, 0.3, 0.5, 0.7, 0.9):
        counted = one * np.floor(angles / one + part)
        y, start = np.diff(counted) / steps, dict(zip(fit.names, fit.values))
        again.append(output_error(models[0], y, start, *models[1:]).values)
    off = np.array(again) - fit.values
    bias = off.mean(axis=0)
    more = np.diag(bias**2 + off.var(axis=0))
    return Fit(fit.names, fit.values - bias, fit.covariance + more, fit.residuals)


def best(fits):
    """The closest of some fits, as uncertain as those as good make it.

    Nobody knows how sharply the gears stick: what a fit says under
    other assumptions that explain the log as well widens its
    intervals.
    """
    first = min(fits, key=lambda fit: fit.rms)
    good = [fit for fit in fits if fit.rms < AS_GOOD_RATIO * first.rms]
    apart = np.array([fit.values - first.values for fit in good])
    more = np.abs(apart).max(axis=0)
    return Fit(
        first.names,
        first.values,
        first.covariance + np.diag((more / 2) ** 2),
        first.residuals,
    )


def signs(fit, log, suspects):
    """The fit, or a ValueError if it contradicts physics."""
    wrong = [f"{x} = {fit[x]:.3g}" for x in fit.names if "_" in x and fit[x] <= 0]
    if wrong:
        raise ValueError(
            f"the log of the {log} gives {', '.join(wrong)}, which must be "
            f"positive: check the sign of {suspects}, and the excitation"
        )
    return fit


@dataclass(frozen=True, eq=False)
class Identified:
    """What two logs say about a pendulum.

    Parameters
    ----------
    ratios : dict
        e_c, f_c, d_c of the body, e_a, f_a of the wheels: their mean.
    covariance : (5, 5) array
        The covariance of the ratios, in their order. The two logs are
        independent.
    mip : Mip
        The pendulum that fits the ratios best.
    body : Fit
        The fit to the log of the body's experiment.
    wheels : tuple of Fit
        One for each encoder.
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
        late. The thesis's numbers give 1.48.
        """
        x = self.ratios
        return x["e_a"] / x["f_a"] / (x["e_c"] / x["f_c"])

    def polytope(self, spread=0.04):
        """`polytope` of the pendulum, with a ``spread`` as that of (4.25)."""
        return polytope(self.mip, spread)


def fitted(experiment, log, counts, friction):
    """The fits to the ``log`` of an ``experiment``: the body's, or one for each wheel.

    ``counts`` and ``friction`` are as for `identify`.
    """
    if experiment == "body":
        return (fit_body(log, friction=friction),)
    wheels = (1,) if log.encoder2 is None else (1, 2)
    return tuple(fit_wheel(log, k, counts=counts, friction=friction) for k in wheels)


def identify(log_body, log_wheels, counts=COUNTS_PER_TURN, friction=False, **robot):
    """Identify a pendulum from the logs of its two experiments.

    Parameters
    ----------
    log_body : Log
        A log with the gyro, of a robot that is held by its wheels, upside
        down.
    log_wheels : Log
        A log with encoder1 or both encoders, of a robot that lies on its back.
    counts : float
        Counts per turn of a wheel.
    friction : bool
        Fit Coulomb friction too.
    **robot
        Masses and lengths M_b, l, r, M_w, g, and rotors: see
        `Mip.from_ratios`.

    Returns
    -------
    Identified
        The pendulum, its ratios with their covariance, and the fits.

    Raises
    ------
    ValueError
        On wrong arguments, or logs that give no pendulum.

    Notes
    -----
    Source: thesis section 4.2, with the pendulum's sine and the
    encoders' differencing in the models.

    Examples
    --------
    >>> from sosbook.pendulum.rig import shipped
    >>> fit = identify(shipped("body"), shipped("wheels"))
    >>> round(fit.mip.e, 4), round(fit.mip.f, 4)
    (0.0294, 0.0069)
    """
    for name, log in (("log_body", log_body), ("log_wheels", log_wheels)):
        if not isinstance(log, Log):
            raise ValueError(f"{name} must be a Log: Log.read(path)")
    (body,) = fitted("body", log_body, counts, friction)
    wheels = fitted("wheels", log_wheels, counts, friction)
    ratios = {x: body[x] for x in ("e_c", "f_c", "d_c")}
    for x in ("e_a", "f_a"):
        ratios[x] = float(np.mean([wheel[x] for wheel in wheels]))
    mean = sum(w.covariance[:2, :2] for w in wheels) / len(wheels) ** 2
    return Identified(
        ratios,
        block_diag(body.covariance[:3, :3], mean),
        Mip.from_ratios(**ratios, **robot),
        body,
        wheels,
    )
