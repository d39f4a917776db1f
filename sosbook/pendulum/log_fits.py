"""The fit of one log: the body's experiment, or the wheels'."""

from dataclasses import replace
from math import ceil

import numpy as np
from scipy.linalg import block_diag

from ..analysis.fit import UnseenError
from .experiments import STICTION_SPEED, motion, motion_slopes
from .fit import Fit, output_error
from .play import motion_with_play
from .rig import COUNTS_PER_TURN
from .srivc import respond, srivc

__all__ = ["fit_body", "fit_wheel", "speed"]

BODY_MODELS = ("pendulum", "linear", "free zero")
#: rad/s, tried beside `STICTION_SPEED` where friction is fitted.
SHARPER_STICTION = 0.15, 0.05
BALANCES = (
    "does the robot balance, or a controller make V? It must hang upside down, under a "
    "sweep. "
)
FAST_GYRO = 35.0  # rad/s, 2000 deg/s: the scale of most gyros ends there
AGAIN = 20  # rounds of such a fit, which starts from one that is found
STEPS_PER_TIME_CONSTANT = 2.0  # of wheels; Runge and Kutta's run away below 0.36
COARSE_SHARE = 0.5  # of the samples bring a count; of fewer the angles are fitted
AS_GOOD_RATIO = 1.02  # of the residuals' rms to the best fit's: such a fit is as good
PLAYS = 0.005, 0.01, 0.02, 0.04, 0.08  # rad, 0.3 to 5 degrees; a fit begins at one
#: Of the residual: so much less says that there is one. Of thousands of samples, most
#: of whose residual is the counts' step, three per cent are no chance.
PLAY_IF_BETTER_THAN = 0.97
RUB_SHARES = 1.0, 0.6  # of the friction; without play it is taken for larger
AS_NEAR = 1.25  # of the residual: with the wheels' f/e the body's fit is as good
PLAY_STEP, PLAY_ROUNDS = 1e-3, 12  # the model has corners; the start is near


def fit_body(log, model="pendulum", friction=False, share=None, near=None):
    r"""The body's experiment: e/c, f/c, d/c.

    ``log``: a log with the gyro, of a body that hangs at rest at first; ``model``,
    {"pendulum", "linear", "free zero"}: the pendulum (4.16) with its sine; its
    linearisation (4.18); or (4.19), a linear one with one more parameter, "zero": (-e_c
    s + zero) / (s^2 + f_c s + d_c); ``friction``: fit Coulomb friction too, in V. Only
    with the pendulum; ``share``: of the inertia on the motors' side of the gears: with
    it, and friction, a play is fitted where the log shows one; ``near``, Fit: of the
    wheels, with friction: its f/e, which is the same motors', is taken where it
    explains the body's log nearly as well as its own, which friction and play hide in a
    small motion. The fit's parameters are e_c, f_c, d_c (, zero or friction), offset,
    what the gyro says at rest, in rad/s (, and play, in rad). Raises ValueError on a
    wrong model, no gyro, or a log that gives no swinging body.

    Source: thesis (4.16), (4.18), (4.19).
    """
    if model not in BODY_MODELS:
        raise ValueError(f"model must be one of {BODY_MODELS}, got {model!r}")
    if friction and model != "pendulum":
        raise ValueError("friction needs model='pendulum'")
    (gyro,), V, T = log.need("gyro"), log.V, log.T
    asked, top = BALANCES, abs(gyro).max()
    if top > FAST_GYRO:
        asked += f"gyro reads {top:.3g} rad/s: is it in deg/s? "
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

    how = dict(steps=1, stick=STICTION_SPEED)
    moved = Moved(V, log.steps, how)

    def pendulum(e, f, d, *friction_and_offset):
        rub, offset = (0.0, *friction_and_offset)[-2:]
        return moved.path(-e, f, d, rub)[1] + offset

    def slopes(values):
        e, f, d, rub = (*values[:-1], 0.0)[:4]
        parts = moved.slopes(-e, f, d, rub)[1][:, : len(values) - 1]
        return np.column_stack([-parts[:, 0], parts[:, 1:], np.ones(len(V))])

    if model == "free zero":
        start["zero"] = B[1]
    if friction:
        start["friction"] = 0.0
    start["offset"] = gyro.mean()
    if model in BODY_MODELS[1:]:
        fit = output_error(linear, gyro, start)
    else:
        try:
            fit = output_error(pendulum, gyro, start, slopes=slopes)
        except UnseenError as unseen:
            raise ValueError(f"{unseen}: {asked.strip()}") from None
    if friction:
        how["steps"] = 4
        fit = sharper(fit, pendulum, slopes, gyro, how)
    if share is not None:

        def loose(e, f, d, rub, offset, play):
            moved = motion_with_play(-e, f, d, V, log.steps, rub, play, share)
            return moved[1] + offset

        starts = [fit]
        if near is not None:
            starts.append(tied(fit, loose, near, gyro))
        fit = looser(fit, loose, gyro, starts)
        if near is not None and starts[1].rms < AS_NEAR * fit.rms:
            fit = replace(starts[1], alone=fit["e_c"] / fit["f_c"])
    return signs(fit, "body", "the gyro or the motors", asked)


def speed(log, wheel=1, counts=COUNTS_PER_TURN):
    """Differenced counts, in rad/s: the mean since the last sample.

    ``log``: a log with that wheel's encoder; ``wheel``, {1, 2}; ``counts``: counts per
    turn of the wheel. Returns the speed between t[0] and t[1], and so on.
    """
    if wheel not in (1, 2):
        raise ValueError(f"wheel must be 1 or 2, got {wheel!r}")
    (count,) = log.need(f"encoder{wheel}")
    return np.diff(count) * 2 * np.pi / counts / log.steps[:-1]


def fit_wheel(
    log, wheel=1, differencing="modelled", counts=COUNTS_PER_TURN, friction=False,
    share=None,
):  # fmt: skip
    r"""The wheels' experiment: e/a, f/a, with a = 2 I_w.

    ``log``: a log with the wheel's encoder; ``wheel``, {1, 2}; ``differencing``,
    {"modelled", "plain"}: a difference of counts is the mean speed of one period, and
    so the model forms it; or, as is often done, it is taken for the speed at the
    period's end; ``counts``: counts per turn of the wheel; ``friction``: fit Coulomb
    friction too, in V. Only with "modelled"; ``share``: as for `fit_body`; the encoder
    is on the motors' side. The fit's parameters are e_a, f_a (, friction, play). Of
    an encoder so coarse that most samples bring no count the angles are fitted, with an
    offset: there the counts' step is no noise of a speed. Its residuals are speeds all
    the same. Raises ValueError on a wrong argument, no encoder, or a log that gives no
    wheel.

    Source: thesis (4.22).
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
    rate, V, T, steps = speed(log, wheel, counts), log.V, log.T, log.steps
    seldom = float(np.mean(rate != 0)) < COARSE_SHARE
    coarse = differencing == "modelled" and seldom
    held, smooth = V, np.append(0.0, rate)
    if not log.even:
        held, smooth = log.evenly(smooth)
    B, A = srivc(held, smooth, T, [0], 1, cutoff=30.0)
    start = dict(e_a=B[0], f_a=A[0])
    fine = max(4, ceil(STEPS_PER_TIME_CONSTANT * steps.max() * abs(A[0])))
    how = dict(steps=fine, stick=STICTION_SPEED)

    def seen(angles):
        return angles if coarse else np.diff(angles) / steps[:-1]

    def plain(e, f):
        return respond([e], [1.0, f], V, T)[1:]

    def modelled(e, f, *offset):
        return seen(respond([e], [1.0, f, 0.0], V, T) + sum(offset))

    moved = Moved(V, steps, how)

    def rubbing(e, f, *rub_and_offset):
        rub, offset = (0.0, *rub_and_offset, 0.0)[friction : friction + 2]
        return seen(moved.path(e, f, 0.0, rub)[0] + offset)

    def slopes(values):
        parts = moved.slopes(*values[:2], 0.0, values[2] if friction else 0.0)[0]
        parts = parts[:, [0, 1, 3]] if friction else parts[:, :2]
        by = [*parts.T, *([np.ones(len(V))] * coarse)]
        return np.column_stack([seen(x) for x in by])

    if friction:
        start["friction"] = 0.0
    if coarse:
        start["offset"] = 0.0
    turn = 2 * np.pi / counts
    middle = log.need(f"encoder{wheel}")[0] + 0.5
    y = turn * (middle - middle[0]) if coarse else rate
    if friction or not log.even:
        fit = output_error(rubbing, y, start, slopes=slopes)
    else:
        fit = output_error(plain if differencing == "plain" else modelled, y, start)
    if friction:
        fit = sharper(fit, rubbing, slopes, y, how)
    if coarse:
        speeds = rate - np.diff(y - fit.residuals) / steps[:-1]
        fit = replace(fit, residuals=speeds)
    elif share is not None:

        def loose(e, f, rub, play):
            args = V, steps, rub, play, share, "motors"
            return seen(motion_with_play(e, f, 0.0, *args)[0])

        fit = looser(fit, loose, y)
    why = f"encoder{wheel} or the motors"
    if coarse:
        why += f"; and {counts:g} counts a turn may be too coarse for this sweep"
    return signs(fit, "wheels", why)


class Moved:
    """The motion under the voltages V with its slopes, of which the last is kept.

    ``how`` has the steps and the stick of a `motion`, and may change.
    """

    def __init__(self, V, T, how):
        self.V, self.T, self.how, self.last = V, T, how, None

    def path(self, e, f, d, friction):
        """Angle and speed, see `motion`."""
        asked = e, f, d, friction, *self.how.values()
        if asked != self.last:
            self.found = motion(e, f, d, self.V, self.T, friction, **self.how)
            self.last = asked
        return self.found

    def slopes(self, *at):
        """Their slopes, see `motion_slopes`."""
        e, f, d, friction = at
        given = *self.path(*at), e, f, d, self.V, self.T, friction
        return motion_slopes(*given, **self.how)


def sharper(fit, model, slopes, y, how):
    """The closest of a fit and those with sharper friction, of what is as uncertain.

    ``how`` has the speed below which the ``model`` lets friction fade. Nobody knows how
    sharply gears stick: what a fit says under other assumptions that explain the log y
    as well widens its intervals.
    """
    start, fits = dict(zip(fit.names, fit.values)), [fit]
    for how["stick"] in SHARPER_STICTION:
        fits.append(output_error(model, y, start, rounds=AGAIN, slopes=slopes))
    first = min(fits, key=lambda fit: fit.rms)
    good = [fit for fit in fits if fit.rms < AS_GOOD_RATIO * first.rms]
    apart = np.array([fit.values - first.values for fit in good])
    more = np.abs(apart).max(axis=0)
    wider = first.covariance + np.diag((more / 2) ** 2)
    return replace(first, covariance=wider)


def looser(fit, model, y, starts=None):
    """The fit of a model with a play too, where that explains clearly more of y."""
    fits = [fit]
    for near in starts or [fit]:
        start = {x: near[x] for x in fit.names} | {"friction": abs(near["friction"])}
        try:
            fits.append(from_nearest(model, y, start))
        except ValueError:  # it ran away, or tells no play
            continue
    loose = min(fits, key=lambda x: x.rms)
    return loose if loose.rms < PLAY_IF_BETTER_THAN * fit.rms else fit


def from_nearest(model, y, start):
    """The fit of a model with a play to y, from the likeliest of `PLAYS`."""
    asked = [
        start | {"friction": share * start["friction"], "play": play}
        for share in RUB_SHARES
        for play in PLAYS
    ]
    nearest = min(asked, key=lambda x: np.sum((model(*x.values()) - y) ** 2))
    fit = output_error(model, y, nearest, step=PLAY_STEP, rounds=PLAY_ROUNDS)
    return replace(fit, misfit=fit.rms / float(np.std(y)))


def tied(fit, model, near, y):
    """The body's fit with f/e of the wheels', ``near``."""
    ratio = near["f_a"] / near["e_a"]

    def moved(e, d, *others):
        return model(e, ratio * e, d, *others)

    names = "e_c", "d_c", "friction", "offset"
    start = {x: fit[x] for x in names} | {"friction": abs(near["friction"])}
    found = from_nearest(moved, y, start)
    e, d, *others = found.values
    by_near = ratio * np.array([-1 / near["e_a"], 1 / near["f_a"]])
    T = np.zeros((6, 6))  # from these five and f/e to all six
    T[[0, 2, 3, 4, 5], range(5)] = 1
    T[1, 0], T[1, 5] = ratio, e
    known = by_near @ near.covariance[:2, :2] @ by_near
    return Fit(
        (*fit.names, "play"),
        np.array([e, ratio * e, d, *others]),
        T @ block_diag(found.covariance, known) @ T.T,
        found.residuals,
        misfit=found.misfit,
    )


def signs(fit, log, suspects, asked=""):
    """The fit, or a ValueError if it contradicts physics; ``asked``: what to ask first,
    beside the ``suspects`` in the ``log``.
    """
    wrong = [f"{x} = {fit[x]:.3g}" for x in fit.names if "_" in x and fit[x] <= 0]
    if wrong:
        raise ValueError(
            f"the log of the {log} gives {', '.join(wrong)}, which must be positive: "
            f"{asked + 'Else ' if asked else ''}check the sign of {suspects}, and the "
            "excitation: a slower, longer sweep with a larger V says more"
        )
    return fit
