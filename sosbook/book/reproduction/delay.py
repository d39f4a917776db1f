"""Theorems 2.3 and A.3, and the two examples of section 3.2."""

from dataclasses import replace
from functools import partial

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
from .table import Row, below, claim, format_gain, misprint, proven, solution

__all__ = ["rows"]

row = partial(Row, "21_delay_examples")
PROMISE = "rate 0.6 for every delay in [0.1 s, 0.3 s]"


def rows():
    """Rows of section 2.4.4 and of section 3.2, computed."""
    yield from _theorems()
    yield from _wing()
    yield from _masses()


def _theorems():
    """A loop for each misprint: accepted, and unstable."""
    for name, place, misprinted in (
        ("sign", "(2.24), (A.20)", "+ in the Z block"),
        ("transpose", "(A.21)", "A F' + F A'"),
        ("alpha", "(A.20)", "the factor alpha in Gamma"),
    ):
        request = misread(name)
        accepts, mended = (
            solve_delay(x).status == "feasible"
            for x in (request, replace(request, misprints=()))
        )
        loop = request.plant
        low, high = request.tau - request.mu, request.tau + request.mu
        rate, at = slowest_decay(loop.A, loop.A_d, low, high)
        yield Row(
            "20_delay_theorem",
            f"the theorem with {misprinted} proves decay",
            place,
            "exponentially stable",
            ("accepts" if accepts else "refuses")
            + f" a loop with a root of real part {-rate:+.3f}",
            misprint(not (accepts and rate < 0), not (mended and rate < 0)),
            f"at the constant delay {at:.4g} s, inside its interval; the "
            "other misprints are corrected. With this one corrected too the "
            "loop is " + ("accepted" if mended else "refused"),
            f"the {name} of Theorem A.3",
        )


def _truth(ex):
    (d,) = descriptors(ex.plant, ex.U)
    return delayed_loop(d, ex.K)


def _wing():
    wrong = thesis.delay_example_1()
    wing = thesis.delay_example_1(published=True)
    yield from _misread(wrong, wing)
    data = {"printed": wrong, "published": wing}
    slow, long = {}, {}
    for who, ex in data.items():
        A, Ad = _truth(ex)
        slow[who] = slowest_decay(A, Ad, ex.tau - ex.mu, ex.tau + ex.mu)
        ((_, long[who]),) = stable_delays(A, Ad, 3.0)
    yield row(
        "decay under the printed gains",
        "Example 1 with delay",
        PROMISE,
        "; ".join(
            f"{who} data: rate {rate:.3f} at the constant delay {at:.2f} s"
            for who, (rate, at) in slow.items()
        ),
        claim(*(rate >= data[who].delta for who, (rate, _) in slow.items())),
        "stable for constant delays "
        + ", ".join(f"below {h:.4f} s ({who})" for who, h in long.items()),
        "the wing's promise",
    )
    answers = {
        who: design_delay_pid(ex.plant, **ex.requirements) for who, ex in data.items()
    }
    proofs = [x.infeasibility for x in answers.values()]
    yield row(
        "Theorem 2.3 yields gains",
        "Example 1 with delay",
        "tau = 0.2, mu = 0.1, delta = 0.6, alpha = 0.6",
        "; ".join(f"{x.status} ({who} data)" for who, x in answers.items()),
        claim(*(x.status == "feasible" for x in answers.values())),
        "with the errata, which are about all gains; infeasibility is "
        + ("proven" if all(x and x.proven for x in proofs) else "not proven")
        + " on both data sets: by "
        + " and by ".join(x.part if x else "nothing" for x in proofs),
        "the wing's promise",
    )
    A, Ad = _truth(wing)
    nominal = -spectral_abscissa(A, Ad, wing.tau)
    proof = proven(analyse_delay(wing.plant, wing.K, wing.U, wing.tau, 0.0, wing.delta))
    yield row(
        "rate at the nominal delay, published data",
        "Example 1 with delay",
        "0.6",
        f"{nominal:.3f}; 0.6 is " + ("proven" if proof else "not proven"),
        claim(proof),
        "the constant delay 0.2 s, mu = 0",
    )
    small = 0.005
    own = design_delay_pid(wing.plant, **wing.requirements | {"mu": small})
    provable = proven(
        analyse_delay(wing.plant, wing.K, wing.U, wing.tau, small, wing.delta)
    )
    apart = np.linalg.norm(own.K - wing.K) / np.linalg.norm(wing.K)
    solved = [x.status == "feasible" for x in answers.values()]
    _, reason = solution(wing.K, own.K, 1e-3, provable, proven(own))
    yield row(
        "K_P, K_D, K_I of the wing",
        "Example 1 with delay",
        format_gain(wing.K),
        format_gain(own.K),
        # of the LMIs that print asks, and of those with a smaller mu
        claim(all(solved), provable and proven(own)),
        "the printed mu has no gains (above), so which LMIs these solve can't be "
        f"told. For the published data, rate 0.6 and mu = {small} s {reason}, "
        f"{apart:.1%} apart",
    )
    yield _tracks(wing, "Fig. 3.18", 40, "published data")


def _misread(wrong, wing):
    """Whether the printed gains can belong to the printed digits."""

    def abscissa(name, where, value):
        """That of the published wing with one entry changed."""
        parts = {x: getattr(wing.plant, x).copy() for x in "MDSB"}
        parts[name][where] = value
        changed = replace(wing, plant=SecondOrderSystem(**parts))
        return spectral_abscissa(*_truth(changed), wing.tau)

    for name, where in (("D", (0, 1)), ("S", (1, 1))):
        printed, ours = (float(getattr(ex.plant, name)[where]) for ex in (wrong, wing))
        found = {x: abscissa(name, where, x) for x in (printed, ours)}
        yield row(
            f"{name}{where[0] + 1}{where[1] + 1} of the wing",
            "Example 1 with delay, (3.5)",
            f"{printed:g}",
            f"{ours:g}",
            misprint(*(value < 0 for value in found.values())),
            "Frazer, Duncan and Collar (1938), and NLEVP. Test: do the "
            "printed gains stabilise the wing at the nominal delay, the "
            "other entry as published? Largest real part "
            + ", ".join(f"{value:+.3f} with {x:g}" for x, value in found.items()),
            f"{name}{where[0] + 1}{where[1] + 1} of the wing",
        )


def _tracks(ex, place, end, circumstances):
    """Whether U e goes to zero for r = (1, ..., 1), nominal delay."""
    design = analyse_delay(ex.plant, ex.K, ex.U, ex.tau)
    run = design.simulate([0, end], ConstantDelay(ex.tau), r=np.ones(ex.plant.n))
    error = abs((ex.U @ run.e[:, -1]).item())
    positions = ", ".join(f"{z:.3f}" for z in run.z[:, -1])
    return row(
        "e_a goes to zero for a constant set-point",
        place,
        "tracked, (2.6)",
        f"|e_a| {below(error, 1e-4)} after {end} s",
        claim(error < 1e-4),
        f"{circumstances}, nominal delay, r = (1, ..., 1): then z = "
        f"({positions}), for U names z1",
    )


def _masses():
    ex = thesis.delay_example_2()
    asked = {k: v for k, v in ex.requirements.items() if k != "alpha"}
    proof = proven(analyse_delay(ex.plant, ex.K, **asked))
    A, Ad = _truth(ex)
    rate, at = slowest_decay(A, Ad, ex.tau - ex.mu, ex.tau + ex.mu)
    yield row(
        "decay under the printed gains, two masses",
        "Example 2 with delay",
        "rate 0.1 for every delay in [0.2 s, 0.6 s]",
        "proven" if proof else "no proof found",
        claim(proof),
        "exact rational arithmetic, Theorem A.3 with its errata; the true "
        f"rate over constant delays is {rate:.4f}, at {at:.1f} s",
    )
    own = design_delay_pid(ex.plant, **ex.requirements)
    yield row(
        "Theorem 2.3 yields gains, two masses",
        "Example 2 with delay",
        "tau = 0.4, mu = 0.2, delta = 0.1, alpha = 0.8",
        own.status,
        claim(proven(own)),
        "with the errata",
    )
    verdict, reason = solution(ex.K, own.K, 1e-3, proof, proven(own))
    yield row(
        "K_P, K_D, K_I of the two masses",
        "Example 2 with delay",
        format_gain(ex.K),
        format_gain(own.K),
        verdict,
        f"{reason}, in K_D {np.abs(ex.K_D - own.K_D).max():.2f}",
    )
    yield _tracks(ex, "Fig. 3.20", 60, "as printed")
