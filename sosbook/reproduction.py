"""What holds of what is printed: rows for the book's tables and tests.

Every "ours" is computed when `rows` is called; the verdict follows from
it. `errata` lists corrections to the printed text, with their evidence.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from . import thesis
from .analysis import hinf_norm, peak_input, poles
from .descriptor import descriptors
from .design import analyse_pid, design_pid
from .simulate import simulate

__all__ = ["Erratum", "Row", "VERDICTS", "errata", "rows"]

VERDICTS = {
    "reproduced": "our number equals the printed one to the tolerance",
    "property holds": "the claim is true, our numbers are our own",
    "differs": "our number is another one; the row says why",
    "not reproducible": "something that is needed isn't in the text",
}


@dataclass(frozen=True)
class Row:
    """One printed number or claim, and what became of it.

    Parameters
    ----------
    chapter : str
        File of the book's chapter that shows it.
    item, place : str
        What, and where in the thesis.
    printed, ours : str
    verdict : str
        A key of `VERDICTS`.
    why : str
        Tolerance, reason, or what is missing.
    """

    chapter: str
    item: str
    place: str
    printed: str
    ours: str
    verdict: str
    why: str

    def __post_init__(self):
        if self.verdict not in VERDICTS:
            raise ValueError(f"unknown verdict {self.verdict!r}")


@dataclass(frozen=True)
class Erratum:
    """One correction.

    Parameters
    ----------
    place, printed, correct : str
    evidence : str
        Why, and what computes it.
    chapter : str
        File of the chapter that shows it.
    """

    place: str
    printed: str
    correct: str
    evidence: str
    chapter: str


@cache
def rows():
    """All rows, computed. Takes about a second."""
    return tuple(_example_1())


def _compare(printed, ours, tolerance):
    """Verdict on numbers; poles are matched in sorted order."""
    gap = np.abs(np.asarray(printed) - np.asarray(ours)).max()
    return ("reproduced" if gap <= tolerance else "differs"), gap


def _claim(holds):
    return "property holds" if holds else "differs"


def _poles(values):
    upper = [p for p in np.atleast_1d(values) if p.imag >= 0]
    return ", ".join(
        f"{p.real:.4f}" + (f" ± {p.imag:.4f}j" if p.imag else "")
        for p in upper
    )


def _matched(printed, computed):
    """The computed poles in the order of the printed ones."""
    left = list(computed)
    return np.array([
        left.pop(int(np.argmin([abs(p - q) for q in left])))
        for p in printed
    ])


def _gain(K):
    return "; ".join(" ".join(f"{k:.4f}" for k in row) for row in K)


def _example_1():
    chapter = "07_grasping_robot"
    ex = thesis.example_1()
    (d,) = descriptors(ex.plant, ex.U)
    given = analyse_pid(ex.plant, ex.K, **ex.requirements)
    own = design_pid(ex.plant, **ex.requirements)
    smallest = design_pid(
        ex.plant, ex.U, ex.region, None, ex.saturation, minimize="gamma"
    )

    def row(item, place, printed, ours, verdict, why):
        return Row(chapter, item, place, printed, ours, verdict, why)

    computed = _matched(ex.open_loop_poles, ex.plant.poles())
    verdict, gap = _compare(ex.open_loop_poles, computed, 1e-4)
    yield row(
        "open-loop poles", "Table 3.1", _poles(ex.open_loop_poles),
        _poles(computed), verdict, f"largest difference {gap:.0e} rad/s",
    )
    computed = _matched(ex.closed_loop_poles, poles(d, ex.K))
    verdict, gap = _compare(ex.closed_loop_poles, computed, 2e-4)
    yield row(
        "closed-loop poles of the printed gains", "Table 3.1",
        _poles(ex.closed_loop_poles), _poles(computed), verdict,
        f"largest difference {gap:.0e} rad/s, with x3 = + integral of U e",
    )
    inside = min(
        x.min() for x in ex.region.distances(poles(d, ex.K)).values()
    )
    yield row(
        "all closed-loop poles lie in the D-region", "Fig. 3.1",
        "inside", f"{inside:.3f} rad/s from the boundary",
        _claim(inside > 0), "for the printed gains",
    )
    proof = given.certify(digits=7)
    yield row(
        "the printed gains satisfy (2.15), (2.18)-(2.21)",
        "Example 1", "designed to",
        "proven" if proof.proven else "no proof found",
        _claim(proof.proven),
        "a common P, checked in exact rational arithmetic",
    )
    verdict, gap = _compare(ex.K, own.K, 1e-4)
    yield row(
        "K_P, K_D, K_I", "Example 1", _gain(ex.K), _gain(own.K), verdict,
        "the LMIs have many solutions; LMI Lab stops at the first one it "
        "meets, ours is the analytic centre: same size, largest "
        f"difference {gap:.0f}",
    )
    norm = hinf_norm(d, ex.K)
    yield row(
        "H-infinity norm from w to z below 1.2570", "Example 1",
        f"< {ex.gamma}", f"{norm:.5f}", _claim(norm < ex.gamma),
        f"{ex.gamma / norm:.0f} times below the bound: the bound is an "
        "artefact of sharing P with Lemma 2.2 "
        f"(smallest bound we reach: {smallest.gamma:g}, 1 % backed off)",
    )
    peak = peak_input(d, ex.K, ex.saturation.x0)
    yield row(
        "|K x(t)| at most 150 from x(0)", "Example 1",
        f"<= {ex.saturation.u_max:g}", f"{peak:.1f}",
        _claim(peak <= ex.saturation.u_max), "with r = 0, w = 0",
    )
    t = np.linspace(0, ex.t_end, 3001)
    answer = simulate(d, ex.K, t, r=ex.set_point, w=ex.disturbance)
    size = np.linalg.norm(answer.u, axis=0).max()
    yield row(
        "u(t) stays below u_max in Fig. 3.3", "Fig. 3.3",
        f"<= {ex.saturation.u_max:g}", f"{size:.1f}",
        _claim(size <= ex.saturation.u_max),
        "from x(0) = 0, w on both channels; Lemma 2.2 says nothing about "
        "set points or disturbances, so this is luck, not a guarantee",
    )
    last = np.abs(answer.e[:, -1]).max()
    yield row(
        "the error goes to zero in steady state", "Fig. 3.3", "0",
        f"{last:.0e} at t = {ex.t_end:g} s", _claim(last < 1e-3),
        "for constant r",
    )
    yield row(
        "the curves of Figs 3.2 and 3.3", "Figs 3.2, 3.3",
        "plotted", "redrawn", "not reproducible",
        "x(0), the disturbed channels and the data aren't printed; the "
        "scenario is redone with x(0) = 0 and w on both channels",
    )


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
            "Theorems 2.1, 2.2, proofs",
            "to check the LMIs at the vertices suffices",
            "also check the pairs (or let E be certain)",
            "A(a) P E(a)^T is quadratic in a; two counterexamples are "
            "computed in the tests: both vertices pass, a plant between "
            "them is unstable",
            "08_how_far_to_trust",
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
    )
