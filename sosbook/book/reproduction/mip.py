"""Chapter 4: the model of the mobile inverted pendulum, its numbers."""

from functools import partial

import numpy as np

from ...pendulum import Mip, vertices
from ...pendulum.transfer import equal_peaks
from ...plants.second_order import SecondOrderSystem
from .. import thesis
from .table import Row, claim, compare, misprint

__all__ = ["numbers", "rows"]

model_row = partial(Row, "25_pendulum_model")
data_row = partial(Row, "26_identification")
PARAMETER_SETS = ((0.272, 0.040, 0.027), (0.263, 0.0414, 0.0315))  # M_b, l, M_w
R_W = 0.032  # m, radius of a wheel


def rows():
    """What sections 4.1 and 4.2 print, and what became of it."""
    printed = thesis.mip()
    yield from numbers(printed)
    yield from _claims(printed)


def numbers(printed):
    """Rows that follow from the printed numbers, digit by digit."""
    yield from _experiments(printed)
    yield from _identified(printed)
    yield from _letters(printed)
    yield from _matrices(printed)


def relative(printed, ours, tolerance):
    """Verdict and largest gap, relative to each printed number."""
    printed = np.asarray(printed, float)
    return compare(np.ones(printed.shape), np.asarray(ours) / printed, tolerance)


def digits(values, form=".4g"):
    """The numbers in one line."""
    return " ".join(format(float(x) + 0.0, form) for x in np.ravel(values))


def _experiments(printed):
    b1, b0, f_c, d_c = printed.body
    ratios = printed.ratios
    gain = equal_peaks([b1, b0], [1, f_c, d_c])
    yield data_row(
        "the gain after the zero is moved",
        "(4.19), (4.20)",
        f"{-ratios['e_c']:g}",
        f"{gain:.2f}",
        compare(-ratios["e_c"], gain, 0.005)[0],
        "equal peaks of the magnitude; the poles stay",
    )
    used = [ratios[x] for x in ("f_c", "d_c", "e_a", "f_a")]
    yield data_row(
        "the ratios are read off the transfer functions",
        "(4.20), (4.23), 4.2.2",
        digits(used),
        digits([f_c, d_c, *printed.wheels[0]]),
        relative(used, [f_c, d_c, *printed.wheels[0]], 1e-9)[0],
        "e/a and f/a are the first wheel's",
    )
    apart = max(abs(second / first - 1) for first, second in zip(*printed.wheels))
    yield data_row(
        "both wheels answer alike",
        "(4.23), (4.24), Fig. 4.7",
        "very close",
        f"{100 * apart:.1f} % apart",
        claim(apart < printed.spread),
        "threshold: the 4 % that the thesis allows for",
    )
    body, wheels = (ratios["e_c"] / ratios["f_c"], ratios["e_a"] / ratios["f_a"])
    yield data_row(
        "both experiments describe one robot",
        "Section 4.2.2",
        "one pair of motors, ±4 % on e/c and e/a",
        f"e/f = {body:.2f} from the body, {wheels:.2f} from the wheels: "
        f"{100 * (wheels / body - 1):.0f} % apart",
        claim(wheels / body < (1 + printed.spread) / (1 - printed.spread)),
        "threshold: 1.04 / 0.96. f/a = 33.02 is printed but not used afterwards",
        "both experiments describe one robot",
    )


def _identified(printed):
    """Whether one M_b g l stands behind I_b, C_m, t_m and I_w."""
    constants, q, ours = printed.constants, printed.ratios, printed.identified
    torque = 2 * q["d_c"] * q["e_a"] / q["e_c"] * ours["I_w"]  # M_b g l
    implied = [
        q["f_c"] * torque / (2 * constants["R_g"] ** 2 * q["d_c"]),
        torque * constants["V_max"] * q["e_c"] / (2 * constants["R_g"] * q["d_c"]),
    ]
    theirs = [ours["C_m"], ours["t_m"]]
    gaps = np.subtract(implied, theirs)
    yield data_row(
        "C_m and t_m follow from I_w and the ratios",
        "Section 4.2.2",
        digits(theirs),
        digits(implied),
        compare(0, gaps / [0.5e-8, 0.5e-4], 1)[0],
        f"all three with M_b g l = {torque:.5f} N m; tolerance: half of the last digit",
    )
    d, a, s = printed.letters["d"], printed.letters["a"], printed.spread
    mended = d / torque * ours["I_w"]

    def explains(I_w):
        """Whether I_w gives the printed range of a, by its two Deltas."""
        ends = [
            a[0] + 2 * I_w * (x / y - 1) for x, y in ((1 - s, 1 + s), (1 + s, 1 - s))
        ]
        return compare(a[1:], ends, 1.5e-7)[0] == "reproduced"

    yield model_row(
        "one M_b g l behind all constants",
        "Section 4.2.2",
        f"d = {d:g}, I_w = {ours['I_w']:g}",
        f"I_w = {mended:.5g} belongs to this d; {torque:.4f} stands behind the "
        "printed C_m, t_m and I_w",
        misprint(explains(ours["I_w"]), explains(mended)),
        f"{100 * (1 - torque / d):.0f} % apart: two sets of constants were used. "
        "Test: does I_w give the printed range of a?",
        "one M_b g l",
    )
    arm = torque / constants["g"]
    M_b = arm**2 / (torque / q["d_c"] - ours["I_b"])
    yield model_row(
        "M_b behind I_b, C_m, t_m and I_w",
        "Section 4.2.2",
        f"M_b = {constants['M_b']:g}, M_w = {constants['M_w']:g}",
        f"M_b = {M_b:.3f}",
        misprint(*(abs(M_b / constants[name] - 1) < 5e-3 for name in ("M_b", "M_w"))),
        f"I_w gives M_b l = {arm:.6f}, I_b then M_b l^2: so l = "
        f"{arm / M_b:.3f}, and M_b is what is printed for M_w",
        "the known parameters",
    )


def _letters(printed):
    q, x, s = printed.ratios, printed.letters, printed.spread
    c = x["d"] / q["d_c"]
    e, f = q["e_c"] * x["c"], q["f_c"] * x["c"]
    theirs = [x["c"], *x["e"], x["f"]]
    ours = [c, (1 - s) * e, (1 + s) * e, f]
    gaps = np.abs(np.array(ours) / theirs - 1)
    verdict, _ = compare(0, gaps / [6e-4, 2.5e-3, 2.5e-3, 8e-3], 1)
    yield model_row(
        "c, e and f follow from d and the ratios",
        "Section 4.2.2",
        digits(theirs),
        digits(ours),
        verdict,
        f"largest difference {100 * gaps.max():.1f} %: f has two digits, e three",
    )
    geared = e / q["e_a"]  # 2 I_w
    ours = [
        x["a"][0] + geared * (low / high - 1)
        for low, high in ((1 - s, 1 + s), (1 + s, 1 - s))
    ]
    yield model_row(
        "the range of a follows from its middle",
        "Section 4.2.2",
        digits(x["a"][1:]),
        digits(ours),
        compare(x["a"][1:], ours, 1.5e-7)[0],
        "2 I_w times Delta_1 / Delta_2; the rest of a is certain",
    )
    r = printed.constants["g"] * x["b"] / x["d"]
    yield model_row(
        "r, the wheels' radius",
        "Section 4.2.2",
        f"{printed.constants['r']:g}",
        f"{r:.4f}",
        misprint(
            *(
                abs(value / r - 1) < 1e-3
                for value in (printed.constants["r"], round(r, 3))
            )
        ),
        "r = g b / d, whatever M_b and l are",
        "the known parameters",
    )
    sets = {"printed": None} | dict(zip(("first", "second"), PARAMETER_SETS))
    fits = {}
    for name, values in sets.items():
        if values is None:
            M_w, M_b = printed.constants["M_w"], printed.constants["M_b"]
            l, radius = x["d"] / M_b / printed.constants["g"], r
        else:
            (M_b, l, M_w), radius = values, R_W
        ours = [
            radius**2 * (M_b + 2 * M_w) + geared,
            M_b * l * radius,
            M_b * l * printed.constants["g"],
        ]
        positive = x["c"] - M_b * l**2 > 0  # I_b
        fits[name] = (
            positive
            and relative([x["a"][0], x["b"], x["d"]], ours, 2e-3)[0] == "reproduced"
        )
    total = (x["a"][0] - geared) / r**2
    yield model_row(
        "a, b and d follow from the known parameters",
        "Section 4.2.2",
        f"{x['a'][0]:.4g} {x['b']:.4g} {x['d']:.4g}",
        f"M_b l = {x['b'] / r:.5f}, M_b + 2 M_w = {total:.3f}; not from the "
        "printed masses with any l",
        claim(*fits.values()),
        "two equations for M_b, M_w and l, which isn't printed: M_b, l, M_w "
        "= "
        + " and ".join(", ".join(f"{v:g}" for v in s) for s in PARAMETER_SETS)
        + " both fit, so what was used can't be told; we took the first",
    )


def _matrices(printed):
    four = vertices(Mip.printed())
    forms = [v.printed_form() for v in four]
    for name, sign in (("M", 1), ("D", -1), ("S", -1), ("B", 1)):
        theirs = getattr(printed, name)
        ours = sign * np.array([getattr(p, name) for p in forms])
        zeros = theirs == 0
        verdict, gap = relative(
            np.where(zeros, 1, theirs), np.where(zeros, 1 + ours, ours), 4e-4
        )
        minus = "-" * (sign < 0)
        yield model_row(
            f"{minus}{name} of the four vertices",
            "(4.25)",
            digits(theirs[0]),
            digits(ours[0]),
            verdict,
            f"all four, each entry: largest difference {gap:.0e}, rounding; "
            "with the masses and lengths of our choice",
        )


def _claims(printed):
    K = printed.pd[1]

    def stable(plants):
        loops = (
            SecondOrderSystem(p.M, p.D - p.B @ K[:, 2:], p.S - p.B @ K[:, :2], p.B)
            for p in plants
        )
        # the wheels' angle is fed back, so no pole is at zero
        return all(loop.poles().real.max() < 0 for loop in loops)

    def read(sign_D, sign_S):
        return [
            SecondOrderSystem(M, sign_D * D, sign_S * S, B)
            for M, D, S, B in zip(printed.M, printed.D, printed.S, printed.B)
        ]

    yield model_row(
        "signs of D and S",
        "(4.25), (4.27)",
        "D, S",
        "-D, -S",
        misprint(stable(read(1, 1)), stable(read(-1, -1))),
        "test: does the PD for R = 1 stabilise the four vertices as (2.1) "
        "reads them? The text has the right-hand sides",
        "signs of D and S",
    )
    forms = [v.printed_form() for v in vertices(Mip.printed())]
    turned = [SecondOrderSystem(p.M, p.D, p.S, -p.B) for p in forms]
    yield model_row(
        "sign of B",
        "(4.15)",
        "[e (a + b), -e (b + c)]",
        "[-e (a + b), e (b + c)]",
        misprint(stable(turned), stable(forms)),
        "the same test; B of (4.25) has the right sign",
        "sign of B",
    )
    robot = Mip.printed()
    up = robot.plant()
    down = SecondOrderSystem(
        [[robot.c, -robot.b], [-robot.b, robot.a]], up.D, -up.S, up.B
    )
    poles = down.poles()
    poles = poles[abs(poles) > 1e-6]  # nothing holds the wheels' angle
    held = np.roots([robot.c, robot.f, robot.d])
    yield model_row(
        "upright is unstable, hanging is stable",
        "Section 4.1.1",
        "equilibria 1 and 2",
        f"rightmost poles {up.poles().real.max():+.2f} and "
        f"{poles.real.max():+.2f} rad/s; with the wheels held, (4.17), "
        f"{held[0].real:.2f} ± {abs(held[0].imag):.1f}j",
        claim(
            up.poles().real.max() > 1e-6
            and poles.real.max() < 0
            and held.real.max() < 0
        ),
        "linearised, without voltage; but for the pole at 0 of the wheels' angle",
    )
