"""Checks of a log of a machine, and of a fit to it."""

import numpy as np

from .fit import covariance

CLIPPED_SAMPLES = 4  # samples in a row at the very largest value
TURNING = 8  # quanta that a smooth motion falls, so long before it rests at its top
MOST_LEFT = 0.25  # residual over signal, rms: beyond it the model isn't this log's
STRUCTURED = 3.0  # times its own jitter, a residual is more than noise
LITTLE_LEFT = 1e-4  # of the signal: so little is no doubt
LINE = 25.0  # times its mean: in a spectrum of noise no line is so high by chance
FAR_GUESS = 30.0  # times a guess, or its inverse
SURE = 6.0  # standard deviations
FOLLOWS = 0.02  # of what is new in an input, explained by the sensors' noise


def quantum(y):
    """The smallest step between two values of y."""
    values = np.unique(y)
    steps = np.diff(values)
    steps = steps[steps > 1e-9 * max(np.ptp(y), 1e-300)]
    return float(steps.min()) if len(steps) else 0.0


def roughness(y, r):
    """How many times its own noise a residual r of a sensor's y is; 1 of little."""
    rms = np.sqrt(np.mean(r**2))
    floor = max(np.std(np.diff(r)) / 2**0.5, quantum(y) / 12**0.5, 1e-300)
    return float(rms / floor) if rms > LITTLE_LEFT * np.std(y) else 1.0


def refuse_before(record, poles):
    """Raise where a sensor or an input of a record never moves, or t has another unit
    than the ``poles`` of the first guess.
    """
    for names, columns in ((record.inputs, record.u), (record.outputs, record.y)):
        for name, x in zip(names, columns.T):
            if (x == x[0]).all() and (columns is record.y or not x[0]):
                raise ValueError(f"{name} never changes: there is nothing to fit")
    fast, span = abs(poles.imag).max(), record.t[-1] - record.t[0]
    T, top = record.T, abs(poles).max()
    if fast * T > np.pi:
        raise ValueError(
            f"t: the samples are {T:g} s apart, and a mode of the first guess swings "
            f"with a period of {2 * np.pi / fast:.2g} s: t must be in seconds, or "
            "start is far off"
        )
    if 0 < top * span < 0.3:
        raise ValueError(
            f"t: the log takes {span:.2g} s, and the fastest mode of the first guess "
            f"{1 / top:.2g} s: t must be in seconds, or start is far off"
        )


def at_an_end(record):
    """Samples of a record, (N, q), at which a sensor may have reached its end.

    It stays at its largest or smallest value longer than a smooth motion of the speed
    before it would.
    """
    held = np.zeros(record.y.shape, bool)
    for y, mask in zip(record.y.T, held.T):
        step = quantum(y)
        for end in (y.min(), y.max()):
            edges = np.flatnonzero(np.diff(np.r_[False, y == end, False]))
            for first, last in edges.reshape(-1, 2):
                size = last - first
                before = y[max(first - (size + 1) // 2, 0)]
                if size >= CLIPPED_SAMPLES and abs(before - end) > TURNING * step:
                    mask[first:last] = True
    return held


def refuse_ends(found, record, held):
    """Raise where the model that was found for the other samples of a record goes on
    beyond what is ``held``.
    """
    for name, y, r, mask in zip(record.outputs, record.y.T, found.residuals.T, held.T):
        noise = max(quantum(y), np.sqrt(np.mean(r[~mask] ** 2)))
        for end, way in ((y.min(), -1), (y.max(), 1)):
            at = mask & (y == end)
            if at.any() and -way * r[at].mean() > 3 * noise:
                raise ValueError(
                    f"{name} stays at {end:.5g} for {at.sum()} samples, where the "
                    f"model goes on to {end + way * abs(r[at]).max():.3g}: the sensor "
                    "is at its end. Widen its range, or move less"
                )


def refuse_model(residuals, record, keep):
    """Raise where residuals at samples to keep are too much of a record's sensor."""
    left = np.sqrt(np.mean(residuals**2, axis=0, where=keep > 0))
    shares = left / record.y.std(axis=0)
    for name, share in zip(record.outputs, shares):
        if share > MOST_LEFT:
            raise ValueError(
                f"the fit leaves {100 * share:.2g} % of {name}: the log isn't this "
                "machine's, or it moves when the log begins (rest=False), a load acts, "
                "a sign, a unit, t or the order of columns is wrong, or start is too "
                "far off"
            )


def doubts_of(found, record, slopes, guess):
    """Sentences about a fit that was found for a record, from a guess on.

    ``slopes``: of its weighed model, by logarithms of the parameters.
    """
    for name, x, first in zip(found.names, found.values, guess):
        if not 1 / FAR_GUESS < x / first < FAR_GUESS:
            yield (
                f"{name} is {x / first:.2g} times its guess: are t in seconds and u "
                "and y in the plant's units?"
            )
    modelled = record.y - found.residuals
    for name, y, r in zip(record.outputs, record.y.T, found.residuals.T):
        if (times := roughness(y, r)) > STRUCTURED:
            yield (
                f"the fit of {name} leaves {times:.1f} times its own noise: something "
                "isn't modelled, such as friction (friction=), play, a late sensor, a "
                "load, or motion at the beginning (rest=False). The intervals hold "
                "none of it"
            )
        elif (omega := line_of(r, record)) is not None:
            yield (
                f"what the fit leaves of {name} isn't noise alone, most at {omega:.3g} "
                "rad/s: if the log hardly excites a mode, another machine looks alike. "
                "Sweep across all modes, or begin with a nearer start"
            )
    late, sd = lateness(found.residuals, record.t, slopes, modelled)
    if abs(late) > max(SURE * sd, record.T / 4):
        yield (
            f"the sensors seem to be {abs(late) / record.T:.2g} samples "
            f"{'late' if late > 0 else 'early'} against the inputs: read them before u "
            "acts, in the same row"
        )
    chance = max(FOLLOWS, 20 * modelled.shape[1] / len(modelled))
    for name, u in zip(record.inputs, record.u.T):
        if (share := follows(u, found.residuals, modelled)) > chance:
            yield (
                f"{name} follows the sensors' noise ({100 * share:.0f} % of what is "
                "new in it): the log is one of a closed loop, in which a load on the "
                "machine looks like another machine. Open it, or add a sweep to u "
                "that is much larger than what the controller does"
            )


def line_of(r, record):
    """The frequency of a line in the spectrum of a residual r, in rad/s, or None."""
    power = abs(np.fft.rfft(r - r.mean())) ** 2
    at = power.argmax()
    if power[at] <= LINE * power.mean():
        return None
    return float(2 * np.pi * np.fft.rfftfreq(len(r), record.T)[at])


def lateness(residuals, t, slopes, modelled):
    """How much later than modelled all sensors are, in s, and its deviation.

    To first order: ``residuals``, (N, q), at times t that are like the outputs' rates,
    beside what other parameters would make, the weighed ``slopes``, (N q, p).
    """
    rates = np.gradient(modelled, t, axis=0)
    rates = rates - rates.mean(axis=0)
    weights = 1 / np.sqrt(np.mean(residuals**2, axis=0)).clip(1e-300)
    r = residuals * weights
    J = np.hstack([slopes, -(rates * weights).reshape(-1, 1)])
    size = np.linalg.norm(J[:, -1])
    J[:, -1] /= size
    shift = np.linalg.lstsq(J, r.ravel(), None)[0][-1]
    return shift / size, covariance(J, r)[-1, -1] ** 0.5 / size


def follows(u, residuals, modelled):
    """The share of what is new in an input that the sensors' noise explains."""
    n = 6
    lags = [np.roll(u, k) for k in range(1, n + 1)]
    lags += [np.roll(x, k) for x in modelled.T for k in range(n)]
    known = np.column_stack([*lags, np.ones_like(u)])[n:]
    noise = [np.roll(x, k) for x in residuals.T for k in range(2)]
    noise = np.column_stack(noise)[n:]

    def rest(x):
        scale = np.linalg.norm(known, axis=0).clip(1e-300)
        return x - known @ (np.linalg.lstsq(known / scale, x, 1e-10)[0].T / scale).T

    new, heard = rest(u[n:]), rest(noise)
    if not new.any():
        return 0.0
    left = new - heard @ np.linalg.lstsq(heard, new, None)[0]
    return 1 - (left @ left) / (new @ new)
