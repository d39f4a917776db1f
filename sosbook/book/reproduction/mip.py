"""Chapter 4: the model of the mobile inverted pendulum, its numbers."""

import numpy as np

from ...pendulum import Mip, vertices
from ...pendulum.transfer import equal_peaks
from ...plants.second_order import SecondOrderSystem
from .. import thesis
from .table import compare, evaluate, shown

PARAMETER_SETS = ((0.272, 0.040, 0.027), (0.263, 0.0414, 0.0315))  # M_b, l, M_w
R_W = 0.032  # m, radius of a wheel


def rows():
    """The numbers of sections 4.1 and 4.2, recomputed."""
    printed = thesis.mip()
    yield from _experiments(printed)
    yield from _identified(printed)
    yield from _letters(printed)
    yield _known(printed)
    yield from _matrices(printed)
    yield from _claims(printed)


def _experiments(printed):
    b1, b0, f_c, d_c = printed.body
    ratios, spread = printed.ratios, printed.spread
    gain = equal_peaks([b1, b0], [1, f_c, d_c])
    yield evaluate("mip-gain", -ratios["e_c"], gain, ours=f"{gain:.2f}")
    used = [ratios[x] for x in ("f_c", "d_c", "e_a", "f_a")]
    yield evaluate("mip-ratios", used, [f_c, d_c, *printed.wheels[0]])
    apart = max(abs(second / first - 1) for first, second in zip(*printed.wheels))
    yield evaluate("mip-wheels", apart < spread, percent=100 * apart)
    body, wheels = (ratios["e_c"] / ratios["f_c"], ratios["e_a"] / ratios["f_a"])
    holds = wheels / body < (1 + spread) / (1 - spread)
    words = dict(body=body, wheels=wheels, percent=100 * (wheels / body - 1))
    yield evaluate("mip-one-robot", holds, **words)


def _range(x, s, geared):
    """The ends of a when ``geared``, 2 I_w, has its two Deltas, with a spread s."""
    return [
        x["a"][0] + geared * (low / high - 1)
        for low, high in ((1 - s, 1 + s), (1 + s, 1 - s))
    ]


def _identified(printed):
    """Judge if one M_b g l stands behind I_b, C_m, t_m and I_w."""
    constants, q, ours = printed.constants, printed.ratios, printed.identified
    torque = 2 * q["d_c"] * q["e_a"] / q["e_c"] * ours["I_w"]  # M_b g l
    implied = [
        q["f_c"] * torque / (2 * constants["R_g"] ** 2 * q["d_c"]),
        torque * constants["V_max"] * q["e_c"] / (2 * constants["R_g"] * q["d_c"]),
    ]
    theirs = [ours["C_m"], ours["t_m"]]
    gaps = np.subtract(implied, theirs) / [0.5e-8, 0.5e-4]
    shows = dict(printed=shown(theirs, ".4g"), ours=shown(implied, ".4g"))
    yield evaluate("mip-motor", 0.0, gaps, **shows, torque=torque)
    x, s = printed.letters, printed.spread
    mended = x["d"] / torque * ours["I_w"]
    explains = (
        compare(x["a"][1:], _range(x, s, 2 * I_w), 1.5e-7)[0] == "reproduced"
        for I_w in (ours["I_w"], mended)
    )
    words = dict(d=x["d"], I_w=ours["I_w"], percent=100 * (1 - torque / x["d"]))
    yield evaluate("mip-torque", *explains, **words, mended=mended, torque=torque)
    arm = torque / constants["g"]
    M_b = arm**2 / (torque / q["d_c"] - ours["I_b"])
    fits = (abs(M_b / constants[name] - 1) < 5e-3 for name in ("M_b", "M_w"))
    yield evaluate("mip-M_b", *fits, **constants, mass=M_b, arm=arm, l=arm / M_b)


def _letters(printed):
    """Rows of the letters c, e, f and r, computed from the printed ratios."""
    q, x, s = printed.ratios, printed.letters, printed.spread
    c = x["d"] / q["d_c"]
    e, f = q["e_c"] * x["c"], q["f_c"] * x["c"]
    theirs = [x["c"], *x["e"], x["f"]]
    ours = [c, (1 - s) * e, (1 + s) * e, f]
    gaps = np.abs(np.array(ours) / theirs - 1)
    shows = dict(
        printed=shown(theirs, ".4g"), ours=shown(ours, ".4g"), percent=100 * gaps.max()
    )
    yield evaluate("mip-letters", 0.0, gaps / [6e-4, 2.5e-3, 2.5e-3, 8e-3], **shows)
    yield evaluate("mip-range", x["a"][1:], _range(x, s, e / q["e_a"]))
    r, of = _radius(printed), printed.constants["r"]
    passes = (abs(value / r - 1) < 1e-3 for value in (of, round(r, 3)))
    yield evaluate("mip-r", *passes, printed=of, r=r)


def _radius(printed):
    """The wheels' radius, whatever M_b and l are."""
    return printed.constants["g"] * printed.letters["b"] / printed.letters["d"]


def _known(printed):
    """Judge if a, b and d follow from the printed masses, or from other sets."""
    q, x, g = printed.ratios, printed.letters, printed.constants["g"]
    r, geared = _radius(printed), q["e_c"] * x["c"] / q["e_a"]
    mass, fits = printed.constants["M_b"], []
    for M_b, l, M_w, radius in (
        (mass, x["d"] / mass / g, printed.constants["M_w"], r),
        *((*known, R_W) for known in PARAMETER_SETS),
    ):
        ours = [radius**2 * (M_b + 2 * M_w) + geared, M_b * l * radius, M_b * l * g]
        gaps = np.array(ours) / [x["a"][0], x["b"], x["d"]] - 1
        positive = x["c"] - M_b * l**2 > 0  # I_b
        fits.append(positive and np.abs(gaps).max() <= 2e-3)
    sets = " and ".join(", ".join(f"{v:g}" for v in s) for s in PARAMETER_SETS)
    words = x | dict(a=x["a"][0], arm=x["b"] / r, total=(x["a"][0] - geared) / r**2)
    return evaluate("mip-known", *fits, **words, sets=sets)


def _matrices(printed):
    forms = [v.printed_form() for v in vertices(Mip.printed())]
    for name, sign in (("M", 1), ("D", -1), ("S", -1), ("B", 1)):
        theirs = getattr(printed, name).reshape(4, -1)
        ours = sign * np.array([getattr(p, name).ravel() for p in forms])
        shows = dict(printed=shown(theirs[0], ".4g"), ours=shown(ours[0], ".4g"))
        yield evaluate(
            "mip-matrix", theirs, ours, **shows, name="-" * (sign < 0) + name
        )


def _claims(printed):
    """Rows of the signs of (4.25) and (4.27) and of the equilibria, by poles."""
    K = printed.pd[1]

    def stable(plants):
        loops = (
            SecondOrderSystem(p.M, p.D - p.B @ K[:, 2:], p.S - p.B @ K[:, :2], p.B)
            for p in plants
        )
        # the wheels' angle is fed back, so no pole is at zero
        return all(loop.poles().real.max() < 0 for loop in loops)

    def read(sign):
        four = zip(printed.M, printed.D, printed.S, printed.B)
        return [SecondOrderSystem(M, sign * D, sign * S, B) for M, D, S, B in four]

    yield evaluate("mip-signs", stable(read(1)), stable(read(-1)))
    forms = [v.printed_form() for v in vertices(Mip.printed())]
    turned = [SecondOrderSystem(p.M, p.D, p.S, -p.B) for p in forms]
    yield evaluate("mip-sign-of-B", stable(turned), stable(forms))
    robot = Mip.printed()
    up = robot.plant()
    down = SecondOrderSystem(
        [[robot.c, -robot.b], [-robot.b, robot.a]], up.D, -up.S, up.B
    )
    poles = down.poles()
    hangs = poles[abs(poles) > 1e-6].real.max()  # nothing holds the wheels' angle
    held = np.roots([robot.c, robot.f, robot.d])
    rises = up.poles().real.max()
    holds = rises > 1e-6 and hangs < 0 and held.real.max() < 0
    words = dict(up=rises, down=hangs, real=held[0].real, imag=abs(held[0].imag))
    yield evaluate("mip-equilibria", holds, **words)
