"""Theorems 2.3 and A.3, and the two examples of section 3.2."""

from dataclasses import replace

import numpy as np

from ...delay import (
    ConstantDelay,
    analyse_delay,
    delayed_loop,
    design_delay_pid,
    slowest_decay,
    solve_delay,
    spectral_abscissa,
    stable_delays,
)
from ...plants.descriptor import descriptors
from ...plants.second_order import SecondOrderSystem
from .. import thesis
from ..counterexamples import misprint as misread
from .table import below, evaluate, proven, said, shown, solution


def rows():
    """Rows of section 2.4.4 and of section 3.2, computed."""
    yield from _theorems()
    yield from _wing()
    yield from _masses()


def _theorems():
    """A loop for each misprint: accepted, and unstable."""
    for name in ("sign", "transpose", "alpha"):
        request = misread(name)
        accepts, mended = (
            solve_delay(x).status == "feasible"
            for x in (request, replace(request, misprints=()))
        )
        loop = request.plant
        low, high = request.tau - request.mu, request.tau + request.mu
        rate, at = slowest_decay(loop.A, loop.A_d, low, high)
        holds = [not (x and rate < 0) for x in (accepts, mended)]
        words = dict(accepts="accepts" if accepts else "refuses", root=-rate, at=at)
        words |= dict(mended="accepted" if mended else "refused")
        yield evaluate(f"delay-{name}", *holds, **words)


def _truth(ex):
    (d,) = descriptors(ex.plant, ex.U)
    return delayed_loop(d, ex.K)


def _wing():
    """Rows of the wing: its printed and its published matrices."""
    wrong = thesis.delay_example_1()
    wing = thesis.delay_example_1(published=True)
    yield from _misread(wrong, wing)
    data = {"printed": wrong, "published": wing}
    slow, long = {}, {}
    for who, ex in data.items():
        A, Ad = _truth(ex)
        slow[who] = slowest_decay(A, Ad, ex.tau - ex.mu, ex.tau + ex.mu)
        ((_, long[who]),) = stable_delays(A, Ad, 3.0)
    yield evaluate(
        "wing-decay",
        *(rate >= data[who].delta for who, (rate, _) in slow.items()),
        ours="; ".join(
            f"{who} data: rate {rate:.3f} at the constant delay {at:.2f} s"
            for who, (rate, at) in slow.items()
        ),
        stable=", ".join(f"below {h:.4f} s ({who})" for who, h in long.items()),
    )
    answers = {
        who: design_delay_pid(ex.plant, **ex.requirements) for who, ex in data.items()
    }
    solved = [x.status == "feasible" for x in answers.values()]
    proofs = [x.infeasibility for x in answers.values()]
    yield evaluate(
        "wing-yields",
        *solved,
        ours="; ".join(f"{x.status} ({who} data)" for who, x in answers.items()),
        proof=said(all(x and x.proven for x in proofs)),
        parts=" and by ".join(x.part if x else "nothing" for x in proofs),
    )
    nominal = -spectral_abscissa(*_truth(wing), wing.tau)
    proof = proven(analyse_delay(wing.plant, wing.K, wing.U, wing.tau, 0.0, wing.delta))
    yield evaluate("wing-nominal", proof, nominal=nominal, proof=said(proof))
    small = 0.005
    own = design_delay_pid(wing.plant, **wing.requirements | {"mu": small})
    provable = proven(
        analyse_delay(wing.plant, wing.K, wing.U, wing.tau, small, wing.delta)
    )
    apart = np.linalg.norm(own.K - wing.K) / np.linalg.norm(wing.K)
    _, reason = solution(wing.K, own.K, 1e-3, provable, proven(own))
    # of the LMIs that print asks, and of those with a smaller mu
    holds = all(solved), provable and proven(own)
    words = dict(printed=shown(wing.K), ours=shown(own.K), small=small)
    yield evaluate("wing-gains", *holds, **words, reason=reason, apart=apart)
    yield _tracks("wing-tracks", wing, 40)


def _misread(wrong, wing):
    """Judge if the printed gains can belong to the printed digits."""

    def abscissa(name, where, value):
        """That of the published wing with one entry changed."""
        parts = {x: getattr(wing.plant, x).copy() for x in "MDSB"}
        parts[name][where] = value
        changed = replace(wing, plant=SecondOrderSystem(**parts))
        return spectral_abscissa(*_truth(changed), wing.tau)

    for name, where in (("D", (0, 1)), ("S", (1, 1))):
        printed, ours = (float(getattr(ex.plant, name)[where]) for ex in (wrong, wing))
        found = {x: abscissa(name, where, x) for x in (printed, ours)}
        yield evaluate(
            "wing-entry",
            *(value < 0 for value in found.values()),
            entry=f"{name}{where[0] + 1}{where[1] + 1}",
            printed=f"{printed:g}",
            ours=f"{ours:g}",
            real=", ".join(f"{value:+.3f} with {x:g}" for x, value in found.items()),
        )


def _tracks(name, ex, end):
    """Judge if U e goes to zero for r = (1, ..., 1), nominal delay."""
    design = analyse_delay(ex.plant, ex.K, ex.U, ex.tau)
    run = design.simulate([0, end], ConstantDelay(ex.tau), r=np.ones(ex.plant.n))
    error = abs((ex.U @ run.e[:, -1]).item())
    positions = ", ".join(f"{z:.3f}" for z in run.z[:, -1])
    return evaluate(name, error < 1e-4, error=below(error, 1e-4), end=end, z=positions)


def _masses():
    ex = thesis.delay_example_2()
    asked = {k: v for k, v in ex.requirements.items() if k != "alpha"}
    proof = proven(analyse_delay(ex.plant, ex.K, **asked))
    rate, at = slowest_decay(*_truth(ex), ex.tau - ex.mu, ex.tau + ex.mu)
    yield evaluate("masses-decay", proof, rate=rate, at=at)
    own = design_delay_pid(ex.plant, **ex.requirements)
    yield evaluate("masses-yields", proven(own), ours=own.status)
    gap = np.abs(ex.K_D - own.K_D).max()
    yield evaluate("masses-gains", ex.K, own.K, proof, proven(own), K_D=gap)
    yield _tracks("masses-tracks", ex, 60)
