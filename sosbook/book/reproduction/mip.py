"""Chapter 4: the tables of the mobile inverted pendulum."""

import control
import numpy as np

from ...pendulum import V_MAX, Mip, polytope, reduced, vertices
from ...pendulum.transfer import equal_peaks
from ...plants.descriptor import mean_descriptor
from ...plants.descriptor_system import DescriptorSystem
from ...requirements.cost import QuadraticCost
from ...synthesis.lqr import design_lqr
from ...synthesis.observer import design_observer, observer_loop
from ...synthesis.pid import analyse_loop, analyse_pid
from .. import thesis
from .table import Row, claim, compare, format_gain

__all__ = ["rows"]

MODEL = "25_pendulum_model"
DATA = "26_identification"
CONTROL = "27_pendulum_control"
OBSERVER = "24_observer"
LAWS = {
    "PD": ("Table 4.1", "pd", None, 4, 0),
    "PID": ("Table 4.2", "pid", [[0, 1]], 5, 3),
}  # place, field, U, states, vertex from 0


def rows():
    """What chapter 4 prints, and what became of it."""
    printed, robot = thesis.mip(), Mip.printed()
    yield from _model(printed, robot)
    plants = polytope(robot)
    for law in LAWS:
        for R in (1, 2, 5):
            yield from _gains(printed, robot, plants, law, R)
        yield _voltage(printed, plants, law)
    yield _rest(printed, plants)
    yield Row(
        CONTROL, "values of R", "Section 4.3.1", "R = 2, 3 and 5",
        "R = 1, 2 and 5", "differs",
        "the tables have 1, 2, 5; with R = 3 no row of them fits",
    )
    plant = reduced(Mip.printed())
    for R in (1, 2):
        yield from _observer(printed, plant, R)
    yield from _controller(printed, plant)


def _relative(printed, ours, tolerance):
    printed = np.asarray(printed)
    return compare(np.ones(printed.shape), ours / printed, tolerance)


def _model(printed, robot):
    found = equal_peaks([-30.11, -52.49], [1, 7.133, 110.6])
    verdict, _ = compare(-30.52, found, 0.005)
    yield Row(
        DATA, "the gain after the zero is moved", "(4.19), (4.20)",
        "-30.52", f"{found:.2f}", verdict,
        "equal peaks of the magnitude; the poles stay",
    )
    letters, four = printed.letters, vertices(robot)
    ours = [robot.a, four[1].a, four[2].a, robot.b, robot.c, robot.d,
            four[0].e, four[3].e, robot.f]
    print_ = [*letters["a"], *(letters[x] for x in "bcd"), *letters["e"],
              letters["f"]]
    verdict, gap = _relative(print_, ours, 0.01)
    yield Row(
        MODEL, "a to f", "Section 4.2.2",
        " ".join(f"{x:.4g}" for x in print_),
        " ".join(f"{x:.4g}" for x in ours), verdict,
        f"largest difference {100 * gap:.1f} %, from rounding; masses and "
        "lengths are chosen, not printed: M_b = 0.272, l = 0.040",
    )
    forms = [v.printed_form() for v in four]
    for name, sign in (("M", 1), ("D", -1), ("S", -1), ("B", 1)):
        theirs = getattr(printed, name)
        ours = np.array([getattr(p, name) for p in forms])
        unit = np.abs(theirs).max()
        verdict, gap = compare(theirs / unit, sign * ours / unit, 2e-4)
        why = f"largest difference {gap:.0e} of the largest entry"
        if sign < 0:
            why += (f"; print has -{name}, the right-hand side: with it "
                    "as left side the printed gains are unstable")
        yield Row(
            MODEL, f"{name} of the four vertices", "(4.25)",
            f"up to {unit:.4g}", f"{'-' * (sign < 0)}{name}, up to "
            f"{np.abs(ours).max():.4g}", verdict, why,
        )


def _gains(printed, robot, plants, law, R):
    place, name, U, N, vertex = LAWS[law]
    K = getattr(printed, name)[R]
    alone = vertices(robot)[vertex].plant()
    ours = design_lqr(alone, np.eye(N), [[R]], U).K
    verdict, gap = _relative(K, ours, 6e-4)
    yield Row(
        CONTROL, f"{law} gains, R = {R}", place, format_gain(K),
        format_gain(ours), verdict,
        f"the regulator (Q = I) of vertex {vertex + 1} alone, to "
        f"{gap:.0e}; the text says: of all four",
    )
    robust = design_lqr(plants, np.eye(N), [[R]], U)
    verdict, gap = _relative(K, robust.K, 6e-4)
    yield Row(
        CONTROL, f"{law} gains, R = {R}, by Theorem 2.4", place,
        format_gain(K), format_gain(robust.K), verdict,
        "four vertices and their pairs, proven cost below "
        f"{robust.request.cost.bound:.4g}; print is up to "
        f"{100 * gap:.0f} % off",
    )
    cost = QuadraticCost(np.eye(N), [[R]])
    given = analyse_pid(plants, K, U, coupling="slack", slack=0.003,
                        cost=cost, minimize="cost", backoff=1e-3)
    proof = given.certify()
    yield Row(
        CONTROL, f"{law}, R = {R}: robustly stable", place, "yes",
        f"proven, cost below {given.request.cost.bound:.4g}; true worst "
        f"of 54 plants {given.noise_cost(samples=50):.4g}",
        claim(proof.proven),
        "the printed digits, every plant of the polytope, exactly; "
        "noise of intensity one on each state",
    )


def _peak(plants, K, U, N):
    """Largest voltage per degree of tilt, linear, at the vertices."""
    start = np.zeros(N)
    start[0] = np.radians(1)
    loop = analyse_pid(plants, K, U, coupling="vertices")
    t = np.linspace(0, 3, 301)
    return max(np.abs(r.u).max() for r in loop.simulate(t, x0=start))


def _voltage(printed, plants, law):
    _, name, U, N, _ = LAWS[law]
    reach = {R: V_MAX / _peak(plants, K, U, N)
             for R, K in getattr(printed, name).items()}
    ours = ", ".join(f"{reach[R]:.0f}° for R = {R}" for R in reach)
    return Row(
        CONTROL, f"{law}: the voltage stays below {V_MAX} V",
        "Section 4.3.1", "for every R", f"for tilts up to {ours}",
        claim(min(reach.values()) > 5),
        "the start isn't printed; continuous control, linear model, no "
        "noise",
    )


def _rest(printed, plants):
    """Where the wheels stop under a constant torque on the body."""
    ends = {}
    for law, (_, name, U, N, _) in LAWS.items():
        K = getattr(printed, name)[5]
        loop = analyse_pid(plants, K, U, coupling="vertices")
        gains = [abs(x.dcgain()[1, 0]) for x in loop.closed_loop()]
        ends[law] = max(gains) / 1000
    return Row(
        CONTROL, "PID keeps the wheels' position, PD lets it vary",
        "Figs 4.11, 4.16", "yes",
        f"under constant torques of 1 mNm the wheels end up to "
        f"{ends['PD']:.2f} rad away with PD, {ends['PID']:.0f} with PID",
        claim(ends["PID"] < 1e-6 < ends["PD"]),
        "R = 5; the integral acts on phi, not on phi' as the text has it",
    )


def _design(plant, R):
    first, mean = plant.vertices[0], mean_descriptor(plant.vertices)
    alone = DescriptorSystem(first.E, first.A, first.Bu)
    push = 2 * np.linalg.solve(mean.E, mean.Bu)
    return design_observer(
        plant, design_lqr(alone, np.eye(3), [[R]]).K,
        np.vstack([push, 0 * push]), np.sqrt(np.diag([0.01, 0.1])))


def _observer(printed, plant, R):
    K, L = printed.lqe[R]
    found = _design(plant, R)
    verdict, gap = _relative(K, found.K, 2e-4)
    yield Row(
        OBSERVER, f"K, R = {R}", "Table 4.3", format_gain(K),
        format_gain(found.K), verdict,
        f"the regulator (Q = I) of vertex 1 alone, to {gap:.0e}",
    )
    verdict, gap = _relative(L[1:], found.L[1:], 1e-3)
    yield Row(
        OBSERVER, f"L, R = {R}", "Table 4.3",
        "; ".join(" ".join(f"{x:.1f}" for x in row) for row in L),
        "; ".join(" ".join(f"{x:.1f}" for x in row) for row in found.L),
        verdict,
        "Theorem 2.5, four vertices, with Q_F and R_F swapped; rows 2 and "
        f"3 to {gap:.0e}, row 1 has one or two digits in print",
    )
    loop = observer_loop(plant, K, L, printed.C)
    proof = analyse_loop(loop.E, loop.A).certify()
    yield Row(
        OBSERVER, f"robustly stable, R = {R}", "Table 4.3", "yes",
        "proven for the printed K and L and every plant",
        claim(proof.proven),
        "pairs of vertices with K and L fixed; Theorem 2.5 itself speaks "
        "of the vertices only",
    )


def _controller(printed, plant):
    found = _design(plant, 2).controller()
    parts = [control.ss2tf(found[0, k]) for k in (0, 1)]
    gains = [-(found.C @ found.B)[0, k] for k in (0, 1)]
    zeros = [np.sort_complex(x.zeros()) for x in parts]
    zeros = [z[np.abs(z) < 1e6].real for z in zeros]
    poles = np.sort(found.poles().real)
    theirs = np.sort(printed.controller[2])
    yield _of_4_28("poles", theirs, poles)
    for name, (gain, at), ours, z in zip(
        ("theta'", "phi'"), printed.controller, gains, zeros
    ):
        yield _of_4_28(f"gain and zeros from {name}",
                       [gain, *np.sort(at)], [ours, *z])
    (g1, _), (g2, (far, _)), poles = printed.controller
    fast = poles[0]
    ours = [g1 / -fast, g2 * far / fast]
    theirs = [printed.reduced[0][0], printed.reduced[1][0]]
    verdict, gap = _relative(theirs, ours, 3e-4)
    yield Row(
        CONTROL, "gains without the fast pole and zero", "(4.29)",
        "-0.8476, -25.831", f"{ours[0]:.4f}, {ours[1]:.3f}", verdict,
        "the gain at s = 0 is kept; last digits differ",
    )
    verdict, gap = _discrete(printed)
    yield Row(
        CONTROL, "the controller at 100 Hz", "(4.30)",
        "A, B, C, D with four digits",
        f"transfer functions within {gap:.0e}", verdict,
        "the zero-order hold of (4.29): numerators and denominators",
    )


def _of_4_28(item, printed, ours):
    verdict, gap = _relative(printed, np.asarray(ours), 0.015)
    return Row(
        OBSERVER, item, "(4.28), R = 2",
        " ".join(f"{x:.5g}" for x in printed),
        " ".join(f"{x:.5g}" for x in ours), verdict,
        f"to {100 * gap:.1f} %; rounding L as in Table 4.3 moves the slow "
        "poles by 3 %; for u = -H y",
    )


def _discrete(printed):
    """Coefficients of (4.30) against the hold of (4.29)."""
    A, B, C, D = printed.discrete
    D = np.hstack([D, np.zeros((1, 2 - D.shape[1]))])
    *channels, poles = printed.reduced
    gaps = []
    for k, (gain, zeros) in enumerate(channels):
        H = control.zpk(zeros, poles, gain)
        held = control.sample_system(H, 0.01, "zoh")
        ours = control.ss2tf(control.ss(A, B[:, [k]], C, D[:, [k]], 0.01))
        gaps += [compare(x[0][0], y[0][0], 2e-4)[1] for x, y in (
            (held.num, ours.num), (held.den, ours.den))]
    return compare(max(gaps), 0, 2e-4)
