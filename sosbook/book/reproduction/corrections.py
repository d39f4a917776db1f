"""Corrections to the printed text."""

from functools import cache

from .pendulum import pendulum
from .table import Erratum

__all__ = ["errata"]


@cache
def errata():
    """Corrections to the printed text that this edition relies on."""
    return (
        Erratum(
            "(2.3)", "a 2 x 2 block matrix of E, A, B_u, B_w",
            "a tuple (E, A, B_u, B_w)",
            "the four blocks have sizes that don't fit together",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.7)", "x3 = - integral of U e",
            "x3 = + integral of U e",
            "with the minus the printed gains of Example 1 are unstable; "
            "with the plus Table 3.1 is reproduced",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.8.1)", "+ (B K_A) r''", "- (B K_A) r'', in the second "
            "block row",
            "insert (2.6) into (2.1): the term moves to the left side as "
            "M - B K_A and leaves - B K_A r'' behind",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.8)-(2.10)", "[0 0 -U]^T r", "[0 0 -U^T]^T r",
            "the stacked column has a rows where U has a rows: U itself, "
            "not its transpose, acts on r",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.13)", "sup over w of |y| / |w|", "add: from x(0) = 0",
            "any x(0) different from zero makes the quotient unbounded",
            "05_hinf",
        ),
        Erratum(
            "Theorems 2.1, 2.2", "E = M - B K_A",
            "E = diag(I, M - B K_A, I)",
            "the theorems use E with 2n + a rows, as (2.8) defines it",
            "05_hinf",
        ),
        Erratum(
            "(2.16)", "j = 1, ..., L", "no index j",
            "nothing in the inequality carries j", "05_hinf",
        ),
        Erratum(
            "Theorems 2.1, 2.2, 2.4, proofs",
            '"it suffices to check the LMIs at the vertices of the convex '
            'polytope"',
            "true if E is certain or E^-1 [A B_u B_w] stays in the hull of "
            "its vertices, as in Examples 1-4; otherwise check the pairs "
            "too, or use a slack matrix",
            "A(a) P E(a)^T is quadratic in a; computed: vertices that pass "
            "with a proof, and an unstable plant between them, also for a "
            "design; for the disk even if only M varies",
            "09_when_vertices_are_not_enough",
        ),
        Erratum(
            "Theorem 2.2", "if and only if",
            "sufficient, for more than one vertex",
            "one P for all plants is a restriction; for one plant the "
            "equivalence is Chilali and Gahinet's", "04_lmi_regions",
        ),
        Erratum(
            "Lemma 2.2", "u = K x alone",
            "add a stability LMI for the same P, r = 0, w = 0, K_A = 0",
            "without it the ellipsoid needn't be invariant: the chapter "
            "shows an unstable loop that satisfies (2.21)",
            "06_saturation",
        ),
        Erratum(
            "(A.15), (A.16)",
            "lower left entry - cos(theta) (z* - z)",
            "cos(theta) (z* - z)",
            "the matrix must be Hermitian; (2.20) has it right",
            "04_lmi_regions",
        ),
        Erratum(
            "Example 1", "half-plane Re(s) < 0.7", "Re(s) < -0.7",
            "Fig. 3.1 and the printed poles", "07_grasping_robot",
        ),
        Erratum(
            "Examples 1-4", "inner angle theta",
            "half-angle theta (inner angle 2 theta)",
            "Theorem 2.2 and (2.20) use the half-angle",
            "07_grasping_robot",
        ),
        Erratum(
            "Chapter 3, opening", "three delay-free examples",
            "four", "they are numbered 1 to 4", "07_grasping_robot",
        ),
        Erratum(
            "Example 2, S", "k1 + b2", "k1 + k2",
            "units, and the equation of motion; the printed gains are "
            "proven with either reading, so poles can't decide",
            "11_car_seat",
        ),
        Erratum(
            "Example 2", "u1, u2 adjust stiffness and damping",
            "u1, u2 are forces on seat and car",
            "B = I in (2.1): the inputs enter as forces", "11_car_seat",
        ),
        Erratum(
            "Example 2, Fig. 3.8", "u doesn't exceed u_max",
            "true without any margin, and for this w only",
            "holding r = (1, 1) takes |S r| = k1 = u_max; with -w the "
            "signal exceeds it", "11_car_seat",
        ),
        Erratum(
            "Example 3, Fig. 3.12", "u_max is respected",
            "K x respects it; u = K x + K_A e'' doesn't",
            "simulated from x(0) = 0 with the unit set point: u1(0) = m1 / "
            "(m1 - K_A11) times its K x; Lemma 2.2 leaves K_A e'' out",
            "12_singular_chain",
        ),
        Erratum(
            "Example 3", '"an impulsive behavior due to an open-loop pole at '
            'infinite"',
            "a jump of z4' (index one); the impulse is in z4'' only",
            "A22 = -b4 is regular in (A.5); infinite_modes counts no "
            "impulsive mode", "08_singular_mass",
        ),
        Erratum(
            "Procedure 2.1, step 3", "find K_A by Lemma 2.1",
            "possible for some beta iff N'(M + M')N > 0 with N a basis of "
            "the directions that B' annihilates (one plant)",
            "M = diag(-1, 0), B = [0 1]^T: proven infeasible for every "
            "beta, though some K_A makes M - B K_A regular",
            "08_singular_mass",
        ),
        Erratum(
            "Example 4", "polytopic set in (??)", "(2.4)",
            "an unresolved reference", "13_flexible_arm",
        ),
        Erratum(
            "Example 4, S2", "50.64", "50 + 2/pi = 50.6366",
            "the second row of Table 3.3 was computed with 50 + 2/pi",
            "13_flexible_arm",
        ),
        Erratum(
            "Table 3.3, first column", "-pi/2 and pi/2", "0 and ± pi/2",
            "sinc is even: -pi/2 and pi/2 are one vertex; the first row "
            "has the poles of sinc = 1", "13_flexible_arm",
        ),
        Erratum(
            "Example 4", "U isn't given", "U = [0 1]",
            "it gives Table 3.3, U = [1 0] doesn't", "13_flexible_arm",
        ),
        Erratum(
            "Example 4, Figs 3.15 and 3.16",
            "set points with the polytope of sinc on [-pi/2, pi/2]",
            "factors in [cos(phi_max), 1], or [-1, 1] for every set point",
            "around a set point the factor is a mean of cos; the printed "
            "gains do have a common P over [-1, 1], at a lower rate, and "
            "phi1 keeps the error -(m g l / k) sin(phi1)",
            "13_flexible_arm",
        ),
        Erratum(
            "(2.1)", "mu(t) <= |mu(t)| <= tau", "|mu(t)| <= mu <= tau",
            "every number is at most its modulus; Theorem 2.3 needs a bound "
            "mu, so that d(t) stays in [tau - mu, tau + mu]",
            "19_input_delay",
        ),
        Erratum(
            "(2.10.1)", "+ B_u K [r^T(t - d) r'^T(t - d) 0]^T",
            "- B_u K [r^T(t - d) r'^T(t - d) 0]^T",
            "insert (2.9.2) into (2.9.1): its minus stays",
            "19_input_delay",
        ),
        Erratum(
            "(2.9), Theorem 2.3", "E = diag(I, M - B K_A, I)",
            "E = diag(I, M, I): no K_A with a delayed input",
            "K_A e'' reaches the plant late: M z''(t) - B K_A z''(t - d) is "
            "a neutral loop, to which the theorem doesn't apply",
            "19_input_delay",
        ),
        Erratum(
            "(2.24), (A.20)", "Z / epsilon2 times + mu in the last block",
            "- mu Z / epsilon2",
            "a negative definite matrix has no positive diagonal block "
            "unless Z < 0, and then V isn't positive; computed: as printed "
            "it accepts x' = x - 0.1 x(t - d), whose root is +0.96 for "
            "d = 1",
            "20_delay_theorem",
        ),
        Erratum(
            "(A.21)", "A F^T + F A^T", "F A + A^T F^T",
            "the null term 2 x^T F (-x' + A x + A_d x(t - d)) gives F A; "
            "(2.25) has its transform right; computed: as printed it accepts "
            "an unstable loop without any delay",
            "20_delay_theorem",
        ),
        Erratum(
            "(A.20)", "Gamma^T = mu [A_d^T F^T, alpha A_d^T G^T, 0, 0]",
            "without alpha",
            "A.3 has no alpha: it comes in by G = alpha F in Theorem 2.3; "
            "computed: with a small alpha it accepts x' = -x(t - d) on "
            "[0, 2], unstable at d = 2",
            "20_delay_theorem",
        ),
        Erratum(
            "(A.21), third diagonal block", "-epsilon1 (R3 + tau S)*",
            "-epsilon1 (R3 + tau S)",
            "the star stands for a symmetric block, of which a diagonal one "
            "has none", "20_delay_theorem",
        ),
        Erratum(
            "(2.25)", "G-bar, not defined", "alpha F-bar",
            "G = alpha F, multiplied by F-bar and F-bar^T, is alpha F-bar^T",
            "20_delay_theorem",
        ),
        Erratum(
            "(2.25)", "E (...) E^T in the upper left blocks",
            "E beside F-bar only: leave out the congruence with "
            "diag(E, E, I, I)",
            "the same for one plant; for an uncertain mass print is "
            "quadratic in E, and the vertices don't cover the plants "
            "between", "20_delay_theorem",
        ),
        Erratum(
            "(2.24), (2.25), Theorem 2.3, proof", "X^T B^T, E^-1 B K",
            "X^T B_u^T, E^-1 B_u K",
            "X has m rows and 2n + a columns; B has only n rows, B_u 2n + a",
            "20_delay_theorem",
        ),
        Erratum(
            "Theorems 2.3, A.3", "0 <= mu",
            "0 < mu; for mu = 0 delete the last block row and column",
            "with mu = 0 the last diagonal block is zero and the strict "
            "inequality has no solution", "20_delay_theorem",
        ),
        Erratum(
            "Theorem 2.3", "alpha different from zero",
            "0 < alpha < 1 / delta",
            "multiply (2.24), its sign corrected, from both sides by "
            "(alpha v, -v, alpha v, 0, 0): F-bar and X drop out, and for "
            "other alpha what is left isn't negative",
            "20_delay_theorem",
        ),
        Erratum(
            "Theorem 2.3, proof", "[P Q R1 R2 R3 Z], diag(E, E, I, I)",
            "[P Q S R1 R2 R3 Z], diag(E, E, I, I, I)",
            "S-bar stands in the LMIs too; (2.24) has five block rows",
            "20_delay_theorem",
        ),
        Erratum(
            "Procedure 2.2", "for solving Problem 2.4.4",
            "for solving Problem 2",
            "2.4.4 is the section's number", "20_delay_theorem",
        ),
        Erratum(
            "Procedure 2.2, step 2", "define delta, alpha and mu",
            "define tau too, with mu <= tau",
            "epsilon1 and epsilon2 need tau; no step sets it",
            "20_delay_theorem",
        ),
        Erratum(
            "Procedure 2.2", "four steps",
            "add a fifth: verify the LMIs for the rounded K, and the roots "
            "at constant delays",
            "the gains of Example 1 with delay would have failed it",
            "21_delay_examples",
        ),
        Erratum(
            "(3.5), D12", "2.5", "2.45",
            "Frazer, Duncan and Collar (1938), and NLEVP", "21_delay_examples",
        ),
        Erratum(
            "(3.5), S22", "27", "2.7",
            "the same sources; only with 2.7 the wing flutters, and the "
            "printed gains stabilise it at the nominal delay",
            "21_delay_examples",
        ),
        Erratum(
            "Example 1 with delay", "the rate 0.6 holds for mu = 0.5 tau",
            "it holds for mu = 0.025 tau",
            "published data; at d = 0.3 s the printed gains' loop has a root "
            "of real part +0.10; the corrected theorem proves the rate 0.6 "
            "for mu = 0.005 s, and its centre is 4 % from print there",
            "21_delay_examples",
        ),
        Erratum(
            "Figs 3.17, 3.19", "a set-point for z",
            "a set point for the coordinate that U names",
            "one input: at rest S z = B u leaves one coordinate free; "
            "z = (1, 0.04, -0.78) and (1, 0.67)",
            "21_delay_examples",
        ),
        Erratum(
            "Lemma 2.3", "|W| tr(...)", "lambda_max(W) tr J",
            "tr(W J) <= lambda_max(W) tr J; the chapter has a loop whose "
            "true cost exceeds det W tr J", "23_lqr",
        ),
        Erratum(
            "Lemma 2.3, proof",
            "Lambda (Psi - P) + (Psi - P) Lambda^T + Theta <= 0",
            "Lambda^T (Psi - P) + (Psi - P) Lambda <= 0",
            "subtract (2.31) from (2.29): Theta cancels, and the transposes "
            "are the other way", "23_lqr",
        ),
        Erratum(
            "Lemma 2.3, proof; (2.36)", "<= 0 implies that Lambda is Hurwitz",
            "add strictness, or detectability of (Theta, Lambda)",
            "z'' + z = u with Q = 0, P = I, Y = 0 satisfies (2.36) and "
            "swings forever; the bound itself holds at every time, without "
            "stability", "23_lqr",
        ),
        Erratum(
            "Theorem 2.4", "P, Q of size n x n, Y of size m x n",
            "N x N and m x N, N = 2n + a (2n without U)",
            "the state of (2.8) is [z; z'; x3]", "23_lqr",
        ),
        Erratum(
            "(2.37)", "J - B_w^T E^-1 P^-1 E^-1 B_w",
            "J - B_w^T E^-T P^-1 E^-1 B_w",
            "Omega^T = B_w^T E^-T; (2.38) has it right", "23_lqr",
        ),
        *pendulum(),
    )
