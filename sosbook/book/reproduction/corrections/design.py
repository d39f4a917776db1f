"""Corrections to sections 1.4 to 2.4.3 and 3.1, and to A.1 and A.2."""

from ..table import Erratum

__all__ = ["DESIGN_ERRATA"]

#: Descriptor form, LMIs, pole regions, Examples 1 to 4.
DESIGN_ERRATA = (
    Erratum(
        "misprint",
        "1.4, second objective",
        "non-singularities in the mass matrix",
        "singularities",
        "the acceleration gain is for a singular mass, section 2.3",
        "08_singular_mass",
    ),
    Erratum(
        "misprint",
        "(2.3)",
        "a 2 x 2 block matrix of E, A, B_u, B_w",
        "a tuple (E, A, B_u, B_w)",
        "the four blocks have sizes that don't fit together",
        "02_descriptor_form",
    ),
    Erratum(
        "single character",
        "(2.7)",
        "x3 = - integral of U e",
        "x3 = + integral of U e",
        "the matrix A that is printed for (2.8) has + U in its last row, and r "
        "enters there with - U: x3' = U z - U r = + U e. Computed: with the "
        "minus the printed gains of Example 1 are unstable, with the plus "
        "Table 3.1 is reproduced",
        "02_descriptor_form",
    ),
    Erratum(
        "misprint",
        "(2.8.1)",
        "+ (B K_A) r''",
        "- (B K_A) r'', in the second block row",
        "insert (2.6) into (2.1): the term moves to the left side as "
        "M - B K_A and leaves - B K_A r'' behind",
        "02_descriptor_form",
    ),
    Erratum(
        "misprint",
        "(2.8)-(2.10)",
        "[0 0 -U]^T r",
        "[0 0 -U^T]^T r",
        "the stacked column has a rows where U has a rows: U itself, "
        "not its transpose, acts on r",
        "02_descriptor_form",
    ),
    Erratum(
        "gap",
        "(2.13)",
        "sup over w of |y| / |w|",
        "add: from x(0) = 0",
        "any x(0) different from zero makes the quotient unbounded",
        "05_hinf",
    ),
    Erratum(
        "misprint",
        "Theorems 2.1, 2.2",
        "E = M - B K_A",
        "E = diag(I, M - B K_A, I)",
        "the theorems use E with 2n + a rows, as (2.8) defines it",
        "05_hinf",
    ),
    Erratum(
        "misprint",
        "(2.16)",
        "j = 1, ..., L",
        "no index j",
        "nothing in the inequality carries j",
        "05_hinf",
    ),
    Erratum(
        "gap",
        "Problem 1, item 3",
        "a bound on u for a set of initial conditions",
        "Lemma 2.2 takes one x(0); for a set, ask its first LMI at each corner",
        "(2.21) is affine in x(0): what holds at corners holds between them",
        "06_saturation",
    ),
    Erratum(
        "claim refuted",
        "Theorems 2.1, 2.2, 2.4, proofs",
        '"it suffices to check the LMIs at the vertices of the convex polytope" '
        "(2.2; the others likewise)",
        "true if E is certain or E^-1 [A B_u B_w] stays in the hull of "
        "its vertices, as in Examples 1-4; otherwise check the pairs "
        "too, or use a slack matrix",
        "A(a) P E(a)^T is quadratic in a; computed: vertices that pass "
        "with a proof, and an unstable plant between them, also for a "
        "design; for the disk even if only M varies",
        "09_when_vertices_are_not_enough",
        "the vertices suffice",
    ),
    Erratum(
        "claim refuted",
        "Theorem 2.2",
        "if and only if",
        "sufficient, for more than one vertex",
        "one P for all plants is a restriction; for one plant the "
        "equivalence is Chilali and Gahinet's",
        "04_lmi_regions",
        "if and only if",
    ),
    Erratum(
        "gap",
        "Lemma 2.2",
        "u = K x alone",
        "add a stability LMI for the same P, r = 0, w = 0, K_A = 0",
        "without it the ellipsoid needn't be invariant: the chapter "
        "shows an unstable loop that satisfies (2.21)",
        "06_saturation",
    ),
    Erratum(
        "misprint",
        "(A.15), (A.16)",
        "lower left entry - cos(theta) (z* - z)",
        "cos(theta) (z* - z)",
        "the matrix must be Hermitian; (2.20) has it right. It stands twice: a "
        "machine that reads hardly slips twice alike",
        "04_lmi_regions",
    ),
    Erratum(
        "misprint",
        "before (A.13)",
        "the sector S(0, 0, theta) if and only if there exists P",
        "A has its poles in the sector S(0, 0, theta) if and only if",
        "the sentence has no predicate; the one before (A.16) has it",
        "appendix_a",
    ),
    Erratum(
        "single character",
        "Theorem A.1",
        "for some positive beta",
        "for some positive beta-hat",
        "(A.6) has the hat",
        "appendix_a",
    ),
    Erratum(
        "single character",
        "Example 1",
        "half-plane Re(s) < 0.7",
        "Re(s) < -0.7",
        "Fig. 3.1 and the printed poles",
        "07_grasping_robot",
    ),
    Erratum(
        "gap",
        "Examples 1-4",
        "a sector with inner angle given by theta",
        "half-angle theta, inner angle 2 theta",
        "section 2.4.2 defines the inner angle as 2 theta, and the examples "
        "point to Fig. 2.1: the theta that they give is (2.20)'s half-angle",
        "07_grasping_robot",
    ),
    Erratum(
        "misprint",
        "Chapter 3, opening",
        "four numerical examples",
        "six, four of them without delay",
        "they are numbered 1 to 4, and 1 and 2 with delay",
        "07_grasping_robot",
    ),
    Erratum(
        "misprint",
        "Chapter 3, opening",
        "three delay-free examples",
        "four",
        "they are numbered 1 to 4",
        "07_grasping_robot",
    ),
    Erratum(
        "single character",
        "Example 2, S",
        "k1 + b2",
        "k1 + k2",
        "units, and the equation of motion. The printed gains are proven "
        "with either reading, so poles can't tell which one was used; "
        "Fig. 3.8 can: u2 ends at 40.0 kN with k1 + k2 (then the limit "
        "of 40 kN is just met) and at 35.5 kN with k1 + b2",
        "11_car_seat",
        "S of Example 2",
    ),
    Erratum(
        "gap",
        "Example 2",
        "u1, u2 adjust stiffness and damping",
        "u1, u2 are forces on seat and car",
        "B = I in (2.1): the inputs enter as forces; how a shock "
        "absorber's stiffness would make them isn't said",
        "11_car_seat",
    ),
    Erratum(
        "gap",
        "Example 3, Fig. 3.12",
        "u_max is respected",
        "say which u: K x respects it, u = K x + K_A e'' of (2.6) doesn't",
        "simulated from x(0) = 0 with the unit set point: u1(0) = m1 / "
        "(m1 - K_A11) times its K x; Lemma 2.2 leaves K_A e'' out, and "
        "set points",
        "12_singular_chain",
        "u_max in Fig. 3.12",
    ),
    Erratum(
        "claim refuted",
        "Example 3",
        '"an impulsive behavior due to an open-loop pole at infinite"',
        "a jump of z4' (index one); the impulse is in z4'' only",
        "A22 = -b4 is regular in (A.5); infinite_modes counts no impulsive mode",
        "08_singular_mass",
        "impulsive behaviour",
    ),
    Erratum(
        "improvement",
        "Procedure 2.1, step 3",
        "find K_A by Lemma 2.1",
        "possible whenever M is symmetric and not negative and [M B] has "
        "full row rank; in general iff N'(M + M')N > 0 with N a basis of "
        "the directions that B' annihilates (one plant)",
        "where M isn't of this kind the lemma may find nothing though "
        "some K_A makes M - B K_A regular, as for M = diag(-1, 0) and "
        "B = [0 1]^T; change the sign of its first row",
        "08_singular_mass",
    ),
    Erratum(
        "misprint",
        "Example 4",
        "polytopic set in (??)",
        "(2.4)",
        "an unresolved reference",
        "13_flexible_arm",
    ),
    Erratum(
        "misprint",
        "Table 3.3, first column",
        "-pi/2 and pi/2",
        "0 and ± pi/2",
        "sinc is even: -pi/2 and pi/2 are one vertex; the first row "
        "has the poles of sinc = 1",
        "13_flexible_arm",
        "labels of Table 3.3",
    ),
    Erratum(
        "gap",
        "Example 4",
        "U isn't given",
        "U = [0 1]",
        "it gives Table 3.3, U = [1 0] doesn't",
        "13_flexible_arm",
    ),
    Erratum(
        "gap",
        "Example 4, Figs 3.15 and 3.16",
        "set points with the polytope of sinc on [-pi/2, pi/2]",
        "factors in [cos(phi_max), 1], or [-1, 1] for every set point",
        "around a set point the factor is a mean of cos; the printed "
        "gains do have a common P over [-1, 1], at a lower rate, and "
        "phi1 keeps the error -(m g l / k) sin(phi1)",
        "13_flexible_arm",
    ),
)
