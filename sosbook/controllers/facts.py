"""What the header of a program says: what is proven, bounded, and simulated only."""

import re

import numpy as np

from ..exact.rational import exact
from ..plants.as_data import plant_data
from ..runtime.digests import digest

SPAN = 6.0  # times the slowest time constant, that a step is simulated
MOST_TICKS = 20_000  # of that
MIXED = re.compile(r"^\d| [+-] ")  # a name such as "2 z1" or "z1 - z2"
LOSE_EVERY = 97  # a tick: about one sample in a hundred


def facts_of(c, time_limit):
    """The columns (title, lines) of the header of a `Controller` c, and its proof files
    (end of the name, text); ``time_limit``: seconds for the sampled loop's proof.
    """
    sampled = c.certify(time_limit=time_limit)
    continuous = getattr(c.certificate, "kind", "") != getattr(sampled, "kind", "")
    words = "gain in continuous time" if continuous else "as designed"
    named = (("", words, c.certificate), ("_sampled", "", sampled))
    proven, proofs = [f"plant: sha256 {digest(plant_data(c.plant))[:16]}"], []
    for end, what, proof in named:
        if proof is not None and proof.proven:
            proofs.append((end, proof.text))
            words = "; ".join(proof.claims)
            sha = digest(proof.text.encode())
            proven.append(f"{f'{what}: ' if what else ''}{words} (file sha256 {sha})")
        else:
            what = what or "sampled loop"
            failed = ", ".join(map(str, getattr(proof, "failed", ()))) or "no proof"
            proven.append(f"{what}: NOT PROVEN, {failed}")
    if sampled.proven and not _whole(c, sampled.K):
        proven.append(
            "the sampled loop is proven with the controller's matrices times rows of "
            "what is measured, rounded to 17 digits; the bounds below are not rounded"
        )
    proven.append(
        f"all of this is about the linear loop, sampled every {c.T:g} s, acting "
        f"{c.delay:g} s late, {c.estimate.words}; constant plants"
    )
    if c.clock is not None:
        (short, long), (early, late) = c.clock
        proven.append(
            f"the proven clock of the sampled loop varies: ticks {short:g} to {long:g} "
            f"s apart, acting {early:g} to {late:g} s late, in any order; the program "
            f"counts ticks that are more than {c.faults.slack * c.T:.4g} s off. The "
            "bounds and steps below are of a clock that doesn't vary"
        )
    gains = ", ".join(
        f"{k:.6g} {f'({name})' if MIXED.search(name) else name}"
        for row in c.gain.K
        for k, name in zip(row, c.gain.signals)
    )
    proven.append(f"u = {gains}")
    return (
        ("proven", proven),
        ("bounded", bounded(c)),
        ("simulated only", simulated(c)),
    ), tuple(proofs)


def _whole(c, K):
    """Whether a proof is of a controller K that is c to the last digit."""
    pairs = [(c.B, c.rows, K.B), (c.D, c.rows, K.D)]
    if K.D_w is not None:
        pairs += [(c.B, c.noise_rows, K.B_w), (c.D, c.noise_rows, K.D_w)]
    return all((exact(M) @ exact(x) == exact(N)).all() for M, x, N in pairs)


def bounded(c):
    """What c's outputs are asked, proven of every plant; and by floats at corners."""
    lines = [
        f"spectral radius {c.radius:.5f}, largest sensitivity at the input "
        f"{c.sensitivity_peak():.3f}, at the corners, in floats"
    ]
    for k, signal in enumerate(c.outputs):
        if c.steps.any():
            lines.append(f"steps of the sensors move {signal}: {c.noise(output=k)}")
        for j, r in enumerate(c.set_points):
            speed = c.limits.ramp[j] if np.isfinite(c.limits.ramp[j]) else None
            try:
                if speed is None:
                    bound = c.step(1.0, j, k)
                    moved = f"a step of 1 of {r} asks {signal}"
                else:
                    bound = c.ramp(speed, j, k)
                    moved = (
                        f"{r} moves by at most {speed:g} a second, from rest, which "
                        f"asks {signal}"
                    )
            except ValueError:
                lines.append(
                    f"no bound of what {r} asks {signal}: at rest it isn't exactly "
                    "zero for every plant"
                )
                continue
            within = (bound.proven or 0.0) <= c.limits.u_max[k]
            lines.append(f"{moved}: {bound}{'' if within else ', without its limit'}")
    if np.isfinite(c.limits.u_max).all():
        for j, _ in enumerate(c.set_points):
            lines.append(str(c.reach(j)))
    return lines


def span(c, times=SPAN, most=MOST_TICKS):
    """Seconds of ``times`` c's slowest time constant and a ramp; at ``most`` ticks."""
    slowest = -c.T / np.log(min(c.radius, 1 - 1e-9))
    ramp = c.limits.ramp.min(initial=np.inf)
    return min(times * slowest + 1 / ramp, most * c.T)


def simulated(c):
    """What a step of each set point does at all corners, a sample in 97 lost."""
    seconds = span(c)
    lines = [
        "slew, faults, lost samples, limits beyond what is bounded above: no proof has "
        "them"
    ]
    for j, signal in enumerate(c.set_points):
        r = np.eye(len(c.set_points))[j]
        run = c.simulate(seconds, r=r, lose=lambda k: k % LOSE_EVERY == LOSE_EVERY - 1)
        most = abs(run.u).max(axis=(0, 1))
        words = ", ".join(f"{x:.4g} {s.unit}" for x, s in zip(most, c.outputs))
        k = c.followed[j]
        over = ""
        if k is not None:
            seen = run.x @ c.rows[k]
            over = f"overshoots by {100 * max(0.0, seen.max() - 1):.1f} %, "
        bad = "no fault" if not run.fault.any() else "FAULTS"
        lines.append(f"a step of 1 of {signal}: {over}asks {words} at most, {bad}")
    varies = "" if c.clock is None else " (but for stability)"
    lines.append(f"jitter{varies}, friction, backlash: not looked at")
    return lines
