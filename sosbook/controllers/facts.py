"""Text of a program's header: proven, bounded and only simulated facts."""

import re
from functools import lru_cache

import numpy as np

from ..exact.proof import NOTHING
from ..exact.rational import exact
from ..plants.as_data import plant_data
from ..runtime.digests import digest
from .limits import FAULTS
from .trial import FAR, kept, steps_of

SPAN = 6.0  # times the slowest time constant, that a step is simulated
MOST_TICKS = 20_000  # of that
MIXED = re.compile(r"^\d| [+-] ")  # a name such as "2 z1" or "z1 - z2"
AWAY = 0.1  # of a step: what ends further from its rest isn't there yet
FINE = "no fault"
ALONE = "one program, sosbook, has made these bounds: no file holds them"
LOSE_EVERY = 97  # a tick: about one sample in a hundred


def facts_of(c, time_limit, step=None):
    """The columns (title, lines) of the header of a `Controller` c, its proof files
    (end of the name, text), and a `Trial` for each set point, of the size ``step``;
    ``time_limit``: seconds for the sampled loop's proof.
    """
    trials = steps_of(c, step)
    return *_facts(c, time_limit, trials), trials


@lru_cache(maxsize=4)
def _facts(c, time_limit, trials):
    """Columns and proofs of `facts_of`, which a program and its report both have."""
    sampled = c.certify(time_limit=time_limit)
    kinds = {getattr(x, "kind", "") for x in (c.certificate, sampled)}
    continuous = len(kinds) > 1 and not c.timing.steps
    words = "gain in continuous time" if continuous else "as designed"
    own = "the program at the plant's ticks" * c.timing.steps
    named = (("", words, c.certificate), ("_sampled", own, sampled))
    proven, proofs = [f"plant: sha256 {digest(plant_data(c.plant))[:16]}"], []
    for end, what, proof in named:
        if proof is not None and proof.settled:
            proofs.append((end, proof.text))
            words = "; ".join(proof.claims)
            if proof.examined.alone:
                words = f"by an enclosure of one program: {words}"
            sha = digest(proof.text.encode())
            proven.append(f"{f'{what}: ' if what else ''}{words} (file sha256 {sha})")
        elif getattr(proof, "why", "") == NOTHING:
            proven.append(f"in continuous time {NOTHING}")
        else:
            what = what or "sampled loop"
            failed = ", ".join(map(str, getattr(proof, "failed", ()))) or "no proof"
            proven.append(f"{what}: NOT PROVEN, {failed}")
    if sampled.proven and not (c.timing.steps or _whole(c, sampled.K)):
        proven.append(
            "the sampled loop is proven with the controller's matrices times rows of "
            "what is measured, rounded to 17 digits; the bounds below are not rounded"
        )
    acting = f"acting {c.delay:g} s late"
    if c.timing.steps:
        acting = "where u, computed after it is measured, acts until the next tick"
    proven.append(
        f"all of this is about the linear loop, sampled every {c.T:g} s, {acting}, "
        f"{c.estimate.words}; constant plants"
    )
    if c.clock.varies:
        (short, long), (early, late) = c.clock.ranges
        ticks = f"{short:g} s" if short == long else f"{short:g} to {long:g} s"
        proven.append(
            f"the proven clock of the sampled loop varies: ticks {ticks} "
            f"apart, acting {early:g} to {late:g} s late, in any order; the program "
            f"counts ticks that are more than {c.faults.slack * c.T:.4g} s off. The "
            "bounds and steps below are of a clock that doesn't vary"
        )
    proven += law_lines(c)
    return (
        (
            ("proven", proven),
            ("bounded", bounded(c, trials)),
            ("simulated only", simulated(c, trials)),
        ),
        tuple(proofs),
    )


def law_lines(c):
    """The gain of a controller c, a line for each output."""
    words = [f"({x})" if MIXED.search(x) else x for x in c.gain.signals]
    rows = (", ".join(f"{k:.6g} {x}" for k, x in zip(r, words)) for r in c.gain.K)
    return [f"{output.name} = {row}" for output, row in zip(c.outputs, rows)]


def _whole(c, K):
    """True if a proof is of a controller K that is c to the last digit."""
    pairs = [(c.B, c.readings.rows, K.B), (c.D, c.readings.rows, K.D)]
    if K.D_w is not None:
        pairs += [(c.B, c.readings.noise, K.B_w), (c.D, c.readings.noise, K.D_w)]
    return all((exact(M) @ exact(x) == exact(N)).all() for M, x, N in pairs)


def bounded(c, trials):
    """Bounds of c's outputs, proven for every plant; and by floats at corners.

    ``trials``: a `Trial` for each set point.
    """
    lines = [
        ALONE,
        f"spectral radius {c.radius:.5f}, largest sensitivity at the input "
        f"{c.sensitivity_peak():.3f}, at the corners, in floats",
    ]
    for k, signal in enumerate(c.outputs):
        if c.readings.steps.any():
            lines.append(
                f"steps of the sensors move {signal}: {c.bounds.noise(output=k)}"
            )
        for j, (r, trial) in enumerate(zip(c.set_points, trials)):
            if not trial.asks:
                lines.append(
                    f"no bound of what {r} asks {signal}: at rest it isn't exactly "
                    "zero for every plant"
                )
                continue
            if np.isfinite(speed := c.limits.ramp[j]):
                bound = c.bounds.ramp(speed, j, k)
                moved = (
                    f"{r} moves by at most {speed:g} a second, from rest, which "
                    f"asks {signal}"
                )
            else:
                bound, moved = trial.asks[k], f"{stepped(trial, r)} asks {signal}"
            within = (bound.proven or 0.0) <= c.limits.u_max[k]
            lines.append(f"{moved}: {bound}{'' if within else ', without its limit'}")
    for j, (r, trial) in enumerate(zip(c.set_points, trials)):
        if trial.asks:
            found = c.bounds.step_response(trial.size, j)
            lines.append(
                f"{stepped(trial, r)}, of the loop without limits, at its ticks: "
                f"{found.output} overshoots by {found.words('overshoot')}, and is "
                f"within 2 % after {found.words('settling_time')}"
            )
    if (profile := c.limits.profile) is not None:
        limits = profile.velocity, profile.acceleration, profile.jerk
        far = "" if profile.range is None else f"{profile.range:.6g} of zero, and "
        moved = (
            f"every motion of {c.set_points[0]} within {far}{limits[0]:.6g} a second, "
            f"{limits[1]:.6g} and {limits[2]:.6g} of acceleration and jerk, as the one "
            "file of moves makes them,"
        )
        for k, signal in enumerate(c.outputs):
            bound = c.motions.follow(*limits, output=k, range=profile.range)
            within = (bound.proven or np.inf) <= c.limits.u_max[k]
            end = "" if within else ", without its limit"
            lines.append(f"{moved} asks {signal}: {bound}{end}")
        lines.append(
            f"{moved} leaves its output from its rest, at the ticks: "
            f"{c.motions.follow(*limits)}"
        )
    if np.isfinite(c.limits.u_max).all():
        for j, r in enumerate(c.set_points):
            which = f"{r.name}: " if len(c.set_points) > 1 else ""
            lines.append(f"{which}{c.bounds.reach(j)}")
    return lines


def stepped(trial, r):
    """A ``trial`` of a set point r, a `Signal`, in words."""
    unit = f" {r.unit}" if r.unit else ""
    return f"a step of {trial.size:.4g}{unit} of {r.name} ({trial.why})"


def span(c, times=SPAN, most=MOST_TICKS, size=1.0):
    """Seconds of ``times`` c's slowest time constant and a ramp, of a step of so much a
    ``size``; at ``most`` ticks.
    """
    slowest = -c.T / np.log(min(c.radius, 1 - 1e-9))
    return min(times * slowest + (size / c.limits.ramp).max(initial=0.0), most * c.T)


def simulated(c, trials):
    """The step of each of ``trials`` at all corners; if c bridges lost samples, one in
    97 is lost.
    """
    lost, loses = "none is lost here, as the first is a fault: see watch(lost=)", False
    if c.faults.ticks(c.T)["lost"]:
        lost, loses = f"one of {LOSE_EVERY} is lost here", True
    lines = [
        "slew, faults, lost samples, limits beyond what is bounded above: no proof has "
        f"them; of the samples {lost}"
    ]
    for j, (signal, trial) in enumerate(zip(c.set_points, trials)):
        run = step_run(c, j, trial.size, loses)
        most = abs(run.u).max(axis=(0, 1))
        words = ", ".join(f"{x:.4g} {s.unit}".strip() for x, s in zip(most, c.outputs))
        how, over = ended(c, run, j, trial.size), ""
        if how == FINE and (k := c.followed[j]) is not None:
            most = (run.x @ c.readings.rows[k]).max() / trial.size - 1
            over = f"overshoots by {100 * max(0.0, most):.1f} %, "
        lines.append(f"{stepped(trial, signal)}: {over}asks {words} at most, {how}")
    varies = " (but for stability)" if c.clock.varies else ""
    lines.append(f"jitter{varies}, friction, backlash: not looked at")
    lines.append(
        "friction and play (backlash) can keep a proven loop in a lasting oscillation, "
        "which no proof here covers: simulate(friction=, backlash=) shows it for yours"
    )
    return lines


@lru_cache(maxsize=4)
def step_run(c, j, size, loses):
    """The `Run` of a step of set point j of a controller c, which a program's header
    and its report both show; ``loses``: whether it loses a sample now and then.
    """
    more = {"lose": _lost} if loses else {}
    r = size * np.eye(len(c.set_points))[j]
    return c.simulate(span(c, size=size), r=r, **more)


def _lost(tick):
    """True if the sample of a ``tick`` is lost here."""
    return tick % LOSE_EVERY == LOSE_EVERY - 1


def ended(c, run, j=None, size=1.0):
    """How a ``run`` of c ended, in words; set point ``j``, ``size``: see `kept`."""
    shown = kept(c, run, j, size)
    cut = int(shown.argmin())
    last = int(shown[cut]) - 1
    if fault := run.fault[cut, last]:
        return f"FAULTS after {run.t[last]:.4g} s ({FAULTS[fault]}, corner {cut + 1})"
    if shown[cut] < len(run.t):
        return (
            f"goes FURTHER than {FAR:g} times its step after {run.t[last]:.4g} s "
            f"(corner {cut + 1})"
        )
    if j is not None and (k := c.followed[j]) is not None:
        r = size * np.eye(len(c.set_points))[j]
        rest = c.static(r=r)[0] @ c.readings.rows[k] if c.radius < 1 else np.inf
        away = abs(run.x[:, -1] @ c.readings.rows[k] - rest)
        if (away > max(AWAY * size, 2 * c.readings.steps[k])).any():
            return f"no fault, but it is NOT AT REST after {run.t[-1] + c.T:.4g} s"
    return FINE
