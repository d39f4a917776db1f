"""Theorems 2.3 and A.3, and the two examples of section 3.2."""

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
from ..counterexamples import misprint
from .table import Row, claim, compare, format_gain

__all__ = ["rows", "slowest_mode"]

PROMISE = "rate 0.6 for every delay in [0.1 s, 0.3 s]"


def rows():
    """Rows of section 2.4.4 and of section 3.2, computed."""
    yield from _theorems()
    yield from _wing()
    yield from _masses()


def slowest_mode(plant, digits=4):
    """The plant's slowest mode as a single mass, y'' + d y' + s y = u.

    Parameters
    ----------
    plant : SecondOrderSystem
        Whose slowest poles form a complex pair.
    digits : int
        Decimals of d and s.

    Returns
    -------
    SecondOrderSystem

    Examples
    --------
    >>> mode = slowest_mode(thesis.delay_example_1(published=True).plant)
    >>> mode.D.item(), mode.S.item()
    (-0.1894, 6.3739)
    """
    poles = plant.poles()
    slow = poles[poles.real.argmax()]
    return SecondOrderSystem(
        [[1]], [[round(-2 * slow.real, digits)]],
        [[round(abs(slow) ** 2, digits)]], [[1]])


def _theorems():
    """A loop for each misprint: accepted, and unstable."""
    for name, place, words in (
        ("sign", "(2.24), (A.20)", "+ in the Z block"),
        ("transpose", "(A.21)", "A F' + F A'"),
        ("alpha", "(A.20)", "the factor alpha in Gamma"),
    ):
        request = misprint(name)
        accepted = solve_delay(request).status == "feasible"
        loop = request.plant
        low, high = request.tau - request.mu, request.tau + request.mu
        rate, at = slowest_decay(loop.A, loop.A_d, low, high)
        yield Row(
            "20_delay_theorem", f"the theorem with {words} proves decay",
            place, "exponentially stable",
            f"accepts a loop with a root of real part {-rate:+.3f}",
            claim(not (accepted and rate < 0)),
            f"at the constant delay {at:.4g} s, inside its interval; the "
            "other misprints are corrected",
        )


def _truth(ex):
    (d,) = descriptors(ex.plant, ex.U)
    return delayed_loop(d, ex.K)


def _wing():
    def row(item, place, printed, ours, verdict, why):
        return Row(
            "21_delay_examples", item, place, printed, ours, verdict, why)

    wrong = thesis.delay_example_1()
    wing = thesis.delay_example_1(published=True)
    for name, where in (("D", (0, 1)), ("S", (1, 1))):
        printed = getattr(wrong.plant, name)[where]
        ours = getattr(wing.plant, name)[where]
        largest = [
            ex.plant.poles().real.max() for ex in (wrong, wing)]
        yield row(
            f"{name}{where[0] + 1}{where[1] + 1} of the wing",
            "Example 1 with delay, (3.5)", f"{printed:g}", f"{ours:g}",
            "reproduced" if printed == ours else "differs",
            "Frazer, Duncan and Collar (1938), and NLEVP; largest real part "
            f"of the open loop {largest[0]:+.4f} as printed, "
            f"{largest[1]:+.4f} as published: only that wing flutters",
        )
    for who, ex in (("printed", wrong), ("published", wing)):
        A, Ad = _truth(ex)
        rate, at = slowest_decay(A, Ad, ex.tau - ex.mu, ex.tau + ex.mu)
        (_, longest), = stable_delays(A, Ad, 3.0)
        yield row(
            f"decay under the printed gains, {who} data",
            "Example 1 with delay", PROMISE,
            f"rate {rate:.3f} at the constant delay {at:.2f} s",
            claim(rate >= ex.delta),
            f"stable for constant delays below {longest:.4f} s",
        )
        found = design_delay_pid(ex.plant, **ex.requirements)
        mode = design_delay_pid(
            slowest_mode(ex.plant), **ex.requirements | {"U": [[1]]})
        proven = mode.status == "infeasible" and mode.infeasibility.proven
        yield row(
            f"Theorem 2.3 yields gains, {who} data", "Example 1 with delay",
            "tau = 0.2, mu = 0.1, delta = 0.6, alpha = 0.6", found.status,
            claim(found.status == "feasible"),
            "with the errata; for the slowest mode alone, its coefficients "
            "rounded to four digits, infeasibility is "
            + ("proven" if proven else "not proven"),
        )
    A, Ad = _truth(wing)
    nominal = -spectral_abscissa(A, Ad, wing.tau)
    proof = analyse_delay(
        wing.plant, wing.K, wing.U, wing.tau, 0.0, wing.delta).certify()
    yield row(
        "rate at the nominal delay, published data", "Example 1 with delay",
        "0.6", f"{nominal:.3f}; 0.6 is "
        + ("proven" if proof.proven else "not proven"),
        claim(proof.proven), "the constant delay 0.2 s, mu = 0",
    )
    small = 0.005
    own = design_delay_pid(
        wing.plant, **wing.requirements | {"mu": small})
    near = analyse_delay(
        wing.plant, wing.K, wing.U, wing.tau, small, wing.delta).certify()
    apart = np.linalg.norm(own.K - wing.K) / np.linalg.norm(wing.K)
    verdict, _ = compare(wing.K, own.K, 1e-3)
    yield row(
        "K_P, K_D, K_I of the wing", "Example 1 with delay",
        format_gain(wing.K), format_gain(own.K), verdict,
        f"ours for published data and mu = {small} s, {apart:.1%} apart; "
        "for that mu the printed gains' rate 0.6 is "
        + ("proven" if near.proven else "not proven"),
    )
    given = analyse_delay(wing.plant, wing.K, wing.U, wing.tau)
    ends = {
        name: given.simulate(
            [0, 40], ConstantDelay(wing.tau), r=r).z[:, -1]
        for name, r in (("one", [1, 0, 0]), ("all", [1, 1, 1]))
    }
    yield row(
        "e_a goes to zero at the nominal delay", "Fig. 3.18",
        "goes to zero", f"|e1| < 1e-4 after 40 s, published data",
        claim(abs(ends["one"][0] - 1) < 1e-4),
        "with the printed data the loop is unstable at this delay",
    )
    yield row(
        "z for a unity set-point", "Fig. 3.17", "unity",
        "z at rest = " + ", ".join(f"{v:.3f}" for v in ends["all"]),
        claim(np.abs(ends["all"] - 1).max() < 1e-3),
        "published data; one input holds the coordinate that U names, the "
        "others follow from S z = B u",
    )
    yield row(
        "the curves of Figs 3.17 and 3.18", "Figs 3.17, 3.18", "plotted",
        "redrawn", "not reproducible",
        "x(0), d(t) and the axes aren't in the text; redone from rest, "
        "r = (1, 0, 0), constant delays",
    )


def _masses():
    def row(item, place, printed, ours, verdict, why):
        return Row(
            "21_delay_examples", item, place, printed, ours, verdict, why)

    ex = thesis.delay_example_2()
    asked = {k: v for k, v in ex.requirements.items() if k != "alpha"}
    proof = analyse_delay(ex.plant, ex.K, **asked).certify()
    A, Ad = _truth(ex)
    rate, at = slowest_decay(A, Ad, ex.tau - ex.mu, ex.tau + ex.mu)
    yield row(
        "decay under the printed gains, two masses", "Example 2 with delay",
        "rate 0.1 for every delay in [0.2 s, 0.6 s]",
        "proven" if proof.proven else "no proof found",
        claim(proof.proven),
        "exact rational arithmetic, Theorem A.3 with its errata; the true "
        f"rate over constant delays is {rate:.4f}, at {at:.1f} s",
    )
    own = design_delay_pid(ex.plant, **ex.requirements)
    yield row(
        "Theorem 2.3 yields gains, two masses", "Example 2 with delay",
        "tau = 0.4, mu = 0.2, delta = 0.1, alpha = 0.8", own.status,
        claim(own.status == "feasible" and own.certify().proven),
        "with the errata",
    )
    verdict, gap = compare(ex.K, own.K, 1e-3)
    yield row(
        "K_P, K_D, K_I of the two masses", "Example 2 with delay",
        format_gain(ex.K), format_gain(own.K), verdict,
        "the LMIs have many solutions, ours is the analytic centre under a "
        f"bound; largest difference {gap:.2f}, in K_D "
        f"{np.abs(ex.K_D - own.K_D).max():.2f}",
    )
    given = analyse_delay(ex.plant, ex.K, ex.U, ex.tau)
    end = given.simulate([0, 60], ConstantDelay(ex.tau), r=[1, 1])
    yield row(
        "e_a goes to zero for a constant set-point", "Fig. 3.20",
        "goes to zero", "|e1| < 1e-4 after 60 s",
        claim(abs(end.e[0, -1]) < 1e-4), "at the nominal delay",
    )
    yield row(
        "z for a constant set-point", "Fig. 3.19", "z follows r",
        f"z1 follows, z2 = {end.z[1, -1]:.4f} r1",
        claim(abs(end.e[1, -1]) < 1e-3),
        "at rest the second row of S z = B u reads 3 z2 = 2 z1",
    )
    yield row(
        "the curves of Figs 3.19 and 3.20", "Figs 3.19, 3.20", "plotted",
        "redrawn", "not reproducible",
        "the set-point, x(0), d(t) and the axes aren't in the text; redone "
        "from rest, r = (1, 0)",
    )
