"""The claim that it suffices to check the vertices."""

import numpy as np

from ...plants.descriptor import descriptors
from ...plants.second_order import Polytope, SecondOrderSystem
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion
from ...studies.polytopes import sample_plants, verify_on_samples, vertices_suffice
from ...synthesis.pid import analyse_pid, design_pid
from .. import counterexamples, thesis
from .table import Row, claim

__all__ = ["rows"]


def rows():
    """Rows on the vertices of polytopes, computed."""
    chapter = "09_when_vertices_are_not_enough"
    whole = "the vertices suffice"

    def row(item, place, ours, holds, why, printed=whole, of=whole):
        return Row(chapter, item, place, printed, ours, claim(holds), why, of)

    limit = Saturation(10, [1, 0, 0, 0])
    driven = counterexamples.actuated()
    design = design_pid(driven, gamma=3, saturation=limit, coupling="vertices", mu=1.0)
    right = design.poles(samples=50).real.max()
    yield row(
        "vertices are enough for (2.15)",
        "Theorem 2.1, proof",
        f"{_proven(design)} at both vertices; a plant between has a pole "
        f"near {right:+.2f}",
        right < 0,
        "A(a) P E(a)' is quadratic in a; a mechanical plant with both "
        "masses positive definite",
    )
    plants, P = counterexamples.mechanical()
    corners = analyse_pid(plants, np.zeros((1, 4)), coupling="vertices")
    right = plants.mean.poles().real.max()
    yield row(
        "vertices are enough for (2.18)",
        "Theorem 2.2, proof",
        f"{_proven(corners)} at both vertices; the plant halfway has a "
        f"pole near {right:+.2f}",
        right < 0,
        "A(a) P E(a)' is quadratic in a",
    )
    slow = counterexamples.slower_corners()
    corners = analyse_pid(
        slow, np.zeros((1, 4)), region=PoleRegion(rho=17), coupling="vertices"
    )
    top = max(abs(v.poles()).max() for v in sample_plants(slow, 21))
    yield row(
        "vertices are enough for (2.19)",
        "Theorem 2.2, proof",
        f"rho = 17 {_proven(corners)} at both vertices; a plant between "
        f"has a pole of modulus {top:.1f}",
        top < 17,
        "only M varies: -rho E P E' is concave in E",
    )
    yield row(
        "vertices are enough for (2.36)",
        "Theorem 2.4, proof",
        *_lqr(plants, P),
        "K = 0, R = I, and a small Q",
    )
    yield row(
        "if and only if",
        "Theorem 2.2",
        *_equivalence(),
        "z'' + 0.2 z' + k z = 0, k in [1, 100]: one P for all k is a "
        "restriction. For one plant the equivalence is true",
        printed="a common P exists iff the poles lie in D",
        of="if and only if",
    )
    for number, reason in (
        (
            2,
            "one mass varies, which stands in one row: E^-1 [A B_u B_w] stays "
            "in the hull of its vertices, where the claim is true",
        ),
        (4, "E is certain: the LMIs are affine"),
    ):
        ex = getattr(thesis, f"example_{number}")()
        own = design_pid(ex.plant, **ex.requirements, coupling="vertices")
        proof, kept = own.certify(), min(verify_on_samples(own).values())
        holds = vertices_suffice(ex.plant, ex.U, ex.K_A) and kept > 0
        holds &= proof.proven and proof.claims[0].startswith("every plant")
        yield row(
            f"vertices are enough in Example {number}",
            f"Example {number}",
            "yes; a design at the vertices is proven for every plant, and kept "
            "at 20 plants between"
            if holds
            else "no",
            holds,
            reason,
            of="",
        )


def _proven(design):
    return "proven" if design.certify().proven else "not proven"


def _lqr(plants, P):
    """(2.36) at the vertices for K = 0, and the plant halfway."""
    Q_F, R_F = 0.01 * np.eye(4), np.eye(1)
    corners = []
    for d in descriptors(plants):
        theta, EPQ = d.A @ P @ d.E.T, d.E @ P @ Q_F
        g = np.block(
            [
                [theta + theta.T, EPQ, np.zeros((4, 1))],
                [EPQ.T, -np.eye(4), np.zeros((4, 1))],
                [np.zeros((1, 8)), -R_F],
            ]
        )
        corners.append(np.linalg.eigvalsh(g)[-1] < 0)
    right = plants.mean.poles().real.max()
    verb = "holds" if all(corners) else "fails"
    return (
        f"(2.36) {verb} at both vertices; the plant halfway has a pole "
        f"near {right:+.2f}",
        right < 0 or not all(corners),
    )


def _equivalence():
    """Poles to the left of -0.05 for each k, but no common P."""
    ends = [SecondOrderSystem([[1]], [[0.2]], [[k]], [[1]]) for k in (1, 100)]
    plants = Polytope(ends)
    right = max(plant.poles().real.max() for plant in sample_plants(plants, 101))
    common = analyse_pid(
        plants, np.zeros((1, 2)), region=PoleRegion(0.05), coupling="pairs"
    )
    none = common.status == "infeasible" and common.infeasibility.proven
    return (
        f"rightmost pole {right:.2f} < -0.05 for each k; a common P is "
        + ("proven not to exist" if none else common.status),
        not (right < -0.05 and none),
    )
