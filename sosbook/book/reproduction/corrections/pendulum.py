"""Corrections to sections 4.1 to 4.3 and to Appendix B."""

import numpy as np

from ... import thesis
from ..table import Erratum, filled

__all__ = ["pendulum"]

MODEL = "25_pendulum_model"
DESIGN = "27_pendulum_control"
OBSERVER = "24_observer"
SAMPLED = "28_discretisation"

#: The robot's model, its numbers, its controllers. What stands in braces is
#: computed from the printed numbers.
TEXTS = (
    Erratum(
        "misprint",
        "4.1",
        '"the friction between the wheels and the ground is zero"',
        "the wheels don't slip",
        "x_w = - r phi is rolling: static friction makes it so",
        MODEL,
    ),
    Erratum(
        "single character",
        "(4.2)",
        "P is the potential energy",
        "U is",
        "L = T - U, and (4.8)",
        MODEL,
    ),
    Erratum(
        "single character",
        "(4.3)",
        "2 M_w V_w^2",
        "M_w V_w^2",
        "two wheels with half of M_w V_w^2 each; as printed it would give "
        "a = r^2 (M_b + 4 M_w) + 2 I_w",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.4), (4.5)",
        "the components added: (- r phi' + 0)",
        "a vector: (- r phi', 0), and likewise in (4.5)",
        "x and y components; (4.7) has the square of the vector. It stands twice",
        MODEL,
    ),
    Erratum(
        "misprint",
        "4.1, x_b and C_b",
        "- r phi + l sin(theta)",
        "- r phi - l sin(theta)",
        "its derivative is (4.5); with the plus, b changes its sign in (4.10). "
        "It stands twice",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.6), (4.7)",
        "G_r^2 I_m",
        "R_g^2 I_a",
        "two names for the gear ratio, two for the rotor's inertia",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.7)",
        "- M_w r^2 phi'^2 and + M_w r^2 / 2 + R_g^2 I_a",
        "+ M_w r^2 phi'^2 and + (M_w r^2 / 2 + R_g^2 I_a) phi'^2",
        "(4.3) written out; it gives (4.10). Three signs and factors differ",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.3), (4.10.1)",
        "V_B, I_B, M_B",
        "V_b, I_b, M_b",
        "the lists under the equations have the small letters",
        MODEL,
    ),
    Erratum(
        "gap",
        "(4.6)",
        "the rotors' inertia R_g^2 I_a counts for phi alone",
        "it also couples theta and phi: b cos(theta) - 2 R_g^2 I_a "
        "(for R_g much larger than 1)",
        "a rotor turns theta' + R_g (phi' - theta'), not R_g phi'; on "
        "the printed numbers the coupling is a third smaller and the "
        "fast pole - 34.7 instead of - 45.9 rad/s",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.13)",
        "- b e V cos(theta) - a e, times V",
        "- b e cos(theta) - a e; b e cos(theta) + c e in the second row",
        "(4.12) solved: V stands there once. It is one too many in both rows",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.15)",
        "B = [e (a + b), - e (b + c)]^T",
        "[- e (a + b), e (b + c)]^T",
        "(4.13) linearised, and B of (4.25); the printed gains are "
        "unstable with (4.15)'s sign",
        MODEL,
        "sign of B",
    ),
    Erratum(
        "misprint",
        "(4.25), (4.27)",
        "D_i, S_i",
        "- D_i, - S_i",
        "the text has the right-hand sides of M z'' = ...; the printed "
        "gains are stable with - D_i, - S_i only",
        MODEL,
        "signs of D and S",
    ),
    Erratum(
        "misprint",
        "4.2.2, the body at rest",
        "thus M_b and M_w terms.",
        "thus the terms with M_b and M_w vanish",
        "the sentence has no predicate; the line below it leaves them out",
        MODEL,
    ),
    Erratum(
        "misprint",
        "4.2.2, known parameters",
        "M_b = 0.027, M_w = 0.263, r = 0.034, no l",
        "r = 0.032, M_b l = 0.01088, M_b + 2 M_w = 0.326; consistent "
        "with M_b = 0.272, l = 0.040, M_w = 0.027, but also with 0.263, "
        "0.0414, 0.0315",
        "r = g b / d, whatever M_b and l are. The printed masses are "
        "impossible: M_b would be negative, or I_b. With these a to f "
        "and (4.25) follow to the last digit; which of the solutions "
        "was used can't be told",
        MODEL,
        "the known parameters",
    ),
    Erratum(
        "misprint",
        "4.2.2, I_b, C_m, t_m, I_w",
        "4.98e-4, 2.39e-6, 0.0027, 6.1313e-5",
        "with d = 0.1066: C_m = 2.75e-6, t_m = 0.0031, "
        "I_w = 7.0457e-5, and I_b = 5.29e-4 if M_b = 0.272",
        "the text has M_b g l = 0.0928 behind these four (M_b = 0.263 and "
        "l = 0.036 give every digit) and 0.1066 behind a to f: 13 "
        "percent apart",
        MODEL,
        "one M_b g l",
    ),
    Erratum(
        "misprint",
        "4.2.2, I_b and C_m",
        "times Delta",
        "no Delta",
        "neither e/c nor e/a stands in them",
        MODEL,
    ),
    Erratum(
        "misprint",
        "4.2.2, I_w",
        "times Delta",
        "times Delta_1 / Delta_2",
        "e/c over e/a, each with its own; the printed range of a has "
        "0.96 / 1.04 to 1.04 / 0.96",
        MODEL,
    ),
    Erratum(
        "claim refuted",
        "4.2.2, f/a = 33.02",
        "f/a beside e/c, f/c and e/a, as of one robot to 4 percent",
        "it isn't used: a and f give f / (2 I_w) = 48.8",
        "the experiments' e / f, 4.28 and 6.32, are 48 percent apart; Delta allows 8",
        MODEL,
        "both experiments describe one robot",
    ),
    Erratum(
        "misprint",
        "(4.25)",
        "polytopic set in (??)",
        "(2.4)",
        "an unresolved reference",
        MODEL,
    ),
    Erratum(
        "misprint",
        "(4.25), C",
        "2 x 3, beside four states",
        "it belongs to (4.27)",
        "(2.11) with (4.25) has the state [theta, phi, theta', phi']",
        OBSERVER,
    ),
    Erratum(
        "misprint",
        "4.3.1",
        "R = 2, R = 3 and R = 5",
        "R = 1, R = 2 and R = 5",
        "Tables 4.1 and 4.2; with Q = I one gain is 1 / sqrt(R): "
        "1.0001, 0.7072, 0.4472",
        DESIGN,
        "values of R",
    ),
    Erratum(
        "single character",
        "4.3.1, the choices of U that fail",
        "U = [0 1] and U = I",
        "U = [1 0] and U = I",
        "[0 1] is the choice that works; the rank condition refuses "
        "[1 0] and I (and accepts [1 1], which wasn't tried)",
        DESIGN,
    ),
    Erratum(
        "misprint",
        "4.3.1",
        "the integral acts on the wheel speed phi'",
        "on the wheel angle phi",
        "U = [0 1] picks phi; an integral of phi' leaves a pole at "
        "zero with the gains of Table 4.2",
        DESIGN,
    ),
    Erratum(
        "misprint",
        "(4.27)",
        "B_1 = 1e-4 [0, - 0.2518, 0.4015]^T",
        "1e-4 [0, - 0.2324, 0.3706]^T",
        "E_1 and A_1 are vertex 1's, this is B_4 of (4.25)",
        OBSERVER,
        "B_1 of (4.27)",
    ),
    Erratum(
        "single character",
        "(4.27), state",
        "[theta, theta', phi]",
        "[theta, theta', phi']",
        "phi is the state that was left out",
        OBSERVER,
    ),
    Erratum(
        "misprint",
        "4.3.2, weights",
        "Q_F = sqrt(diag(0.01, 0.1)), R_F = [2 E^-1 B; 0]",
        "R_F and Q_F, swapped",
        "in (2.45) Q_F has a row per state and error, six, and R_F one per output, two",
        OBSERVER,
        "Q_F and R_F",
    ),
    Erratum(
        "single character",
        "(4.28), second channel",
        "from phi",
        "from phi'",
        "C of (4.27) measures the rates, and (4.29) has the dot; "
        "Table 4.3 gives (4.28) with them, for u = - H y",
        OBSERVER,
    ),
    Erratum(
        "single character",
        "4.3.2, Fig. 4.13, text",
        "R = 3",
        "R = 2",
        "the caption, and Table 4.3",
        OBSERVER,
    ),
    Erratum(
        "claim refuted",
        "Tables 4.1, 4.2",
        "solutions of Theorem 2.4 for four vertices",
        "regulators (Q = I) of vertex 1 and of vertex 4 alone",
        "to 1e-4 and 5e-4; one gain is 1 / sqrt(R). They are robustly "
        "stable all the same, proven",
        DESIGN,
        "Tables 4.1 and 4.2 solve Theorem 2.4",
    ),
    Erratum(
        "gap",
        "4.3.2",
        "1694 and 232.5 compared with 100 Hz",
        "in Hz they are {pole_in_hertz:.0f} and {zero_in_hertz:.0f}",
        "poles and zeros are in rad/s: the zero that is removed lies "
        "below 100 Hz, and below half of it",
        SAMPLED,
    ),
    Erratum(
        "gap",
        "4.3.2",
        '"all poles and zeros above or close to this frequency '
        '[100 Hz] can generate random results"',
        "say why: the hold maps a pole p to exp(p T) exactly, nothing is random",
        "exp({exponent:.2f}) = {factor:.0e} is a delay "
        "of one tick, and the zero at +{zero:g} costs {lag:.0f} "
        "degrees at 50 Hz: the advice to drop both is right",
        SAMPLED,
        "random results",
    ),
    Erratum(
        "gap",
        "(4.26), (B.1.1), (B.3)",
        "K_I e(k)",
        "K_I U e(k)",
        "K_I is one number, e has two entries; U = [0 1]",
        SAMPLED,
    ),
    Erratum(
        "gap",
        "(4.26), (B.3)",
        "no start of x_1, x_2",
        "x_2(0) = K_P z(0) / T_s, from the first tilt",
        "left at zero, the program takes any start for upright: the PD "
        "for R = 5 ends {wheel:.0f} degrees of wheel away for "
        "each degree",
        SAMPLED,
    ),
)


def _numbers():
    """What the texts leave open, from the printed (4.28) and Table 4.1."""
    printed = thesis.mip()
    _, (_, (zero, _)), (pole, *_) = printed.controller
    ((theta, phi, *_),) = printed.pd[5]
    return {
        "zero": zero,
        "pole": -pole,
        "pole_in_hertz": -pole / 2 / np.pi,
        "zero_in_hertz": zero / 2 / np.pi,
        "exponent": pole * 0.01,
        "factor": np.exp(pole * 0.01),
        "lag": np.degrees(np.arctan(2 * np.pi * 50 / zero)),
        "wheel": theta / phi,
    }


def pendulum():
    """The robot's model, its numbers, its controllers."""
    return filled(TEXTS, _numbers())
