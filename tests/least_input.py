"""The least input bound of a plant's LMIs, by cvxpy and Clarabel alone."""

import warnings

import cvxpy
import numpy as np

from sosbook.requirements.lmi_region import LMIRegion

PRICE = 1e-6  # of P, which needs a bound: good modes want it infinite


def least_input(request, vertices=None):
    """The least u_max of Theorem 2.2 and Lemma 2.2 for all vertices, or for those that
    are given; None where it isn't found.
    """
    N, m = request.order, request.plant.m
    P, Y = cvxpy.Variable((N, N), symmetric=True), cvxpy.Variable((m, N))
    level = cvxpy.Variable()
    x0 = request.saturation.x0[:, None]
    asked = [
        (r.alpha, r.beta) for r in request.requirements if isinstance(r, LMIRegion)
    ]
    asked.append((np.zeros((1, 1)), np.eye(1)))
    constraints = [
        cvxpy.bmat([[np.eye(1), x0.T], [x0, P]]) >> 0,
        cvxpy.bmat([[P, Y.T], [Y, level * np.eye(m)]]) >> 0,
    ]
    for d in request.vertices if vertices is None else vertices:
        A, B = (np.linalg.solve(d.E, x) for x in (d.A, d.Bu))
        Theta = A @ P + B @ Y
        for alpha, beta in asked:
            g = cvxpy.kron(alpha, P) + cvxpy.kron(beta, Theta)
            g = g + cvxpy.kron(beta.T, Theta.T)
            constraints.append((g + g.T) / 2 << 0)
    problem = cvxpy.Problem(cvxpy.Minimize(level + PRICE * cvxpy.trace(P)), constraints)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            problem.solve(solver="CLARABEL")
        except cvxpy.error.SolverError:
            return None
    if level.value is None:
        return None
    return float(np.sqrt(max(level.value, 0.0)))
