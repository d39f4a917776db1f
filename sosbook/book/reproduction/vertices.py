"""The claim that it suffices to check the vertices."""

import numpy as np
from scipy.linalg import block_diag

from ...plants.descriptor import descriptors
from ...plants.second_order import Polytope, SecondOrderSystem
from ...requirements.hinf import HInfinity
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion
from ...studies.polytopes import sample_plants, verify_on_samples, vertices_suffice
from ...synthesis.pid import analyse_pid, design_pid
from .. import counterexamples, thesis
from .table import evaluate, proven, said


def rows():
    """Rows on the vertices of polytopes, computed."""
    limit = Saturation(10, [1, 0, 0, 0])
    driven = counterexamples.actuated()
    asked = dict(gamma=HInfinity(3, mu=1.0), saturation=limit)
    design = design_pid(driven, **asked, coupling="vertices")
    right = design.poles(samples=50).real.max()
    proof = said(proven(design))
    yield evaluate("vertices-2.15", right < 0, proof=proof, pole=right)
    plants, P = counterexamples.mechanical()
    corners = analyse_pid(plants, np.zeros((1, 4)), coupling="vertices")
    right, proof = plants.mean.poles().real.max(), said(proven(corners))
    yield evaluate("vertices-2.18", right < 0, proof=proof, pole=right)
    slow = counterexamples.slower_corners()
    corners = analyse_pid(
        slow, np.zeros((1, 4)), region=PoleRegion(rho=17), coupling="vertices"
    )
    top = max(abs(v.poles()).max() for v in sample_plants(slow, 21))
    yield evaluate("vertices-2.19", top < 17, proof=said(proven(corners)), top=top)
    yield _lqr(plants, P, right)
    yield _equivalence()
    for number in (2, 4):
        ex = getattr(thesis, f"example_{number}")()
        own = design_pid(ex.plant, **ex.requirements, coupling="vertices")
        proof, kept = own.certify(), min(verify_on_samples(own).values())
        holds = vertices_suffice(ex.plant, ex.U, ex.K_A) and kept > 0
        holds &= proof.proven and proof.claims[0].startswith("every ")
        yield evaluate(f"vertices-example-{number}", holds)


def _lqr(plants, P, right):
    """(2.36) at the vertices for K = 0, and the plant halfway."""
    Q_F, R_F = 0.01 * np.eye(4), np.eye(1)
    corners = []
    for d in descriptors(plants):
        theta, EPQ = d.A @ P @ d.E.T, d.E @ P @ Q_F
        g = block_diag(np.block([[theta + theta.T, EPQ], [EPQ.T, -np.eye(4)]]), -R_F)
        corners.append(np.linalg.eigvalsh(g)[-1] < 0)
    verb = "holds" if all(corners) else "fails"
    holds = right < 0 or not all(corners)
    return evaluate("vertices-2.36", holds, verb=verb, pole=right)


def _equivalence():
    """Poles to the left of -0.05 for each k, but no common P."""
    ends = [SecondOrderSystem([[1]], [[0.2]], [[k]], [[1]]) for k in (1, 100)]
    plants = Polytope(ends)
    right = max(plant.poles().real.max() for plant in sample_plants(plants, 101))
    common = analyse_pid(
        plants, np.zeros((1, 2)), region=PoleRegion(0.05), coupling="pairs"
    )
    none = common.status == "infeasible" and common.infeasibility.proven
    status = "proven not to exist" if none else common.status
    return evaluate("equivalence", not (right < -0.05 and none), pole=right, P=status)
