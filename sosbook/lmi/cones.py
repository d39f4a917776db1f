"""The same blocks for general solvers: Clarabel cones and cvxpy.

They serve as cross-checks and for those who use other solvers; designs go
through `centre`.
"""

import numpy as np
from scipy import sparse

from ..runtime.libraries import library

__all__ = ["clarabel_minimize", "clarabel_phase_one", "cvxpy_constraints"]


def clarabel_minimize(blocks, cost):
    """Minimise cost.x over G_k(x) >= 0 with Clarabel.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k, affine in k variables.
    cost : (k,) array
        The linear objective.

    Returns
    -------
    x : (k,) array
        Clarabel's last point. Check the eigenvalues yourself.
    status : str
        Clarabel's verdict.
    """
    clarabel = library("clarabel")
    cones, rows, constants = [], [], []
    for c, s in zip(blocks.constants, blocks.slopes):
        # upper triangle column by column, off-diagonal times sqrt 2
        j, i = np.tril_indices(len(c))
        weight = np.where(i == j, 1.0, np.sqrt(2.0))
        rows.append(-(s[:, i, j] * weight).T)
        constants.append(c[i, j] * weight)
        cones.append(clarabel.PSDTriangleConeT(len(c)))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    k = blocks.variables
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix((k, k)),
        np.asarray(cost, float),
        sparse.csc_matrix(np.vstack(rows)),
        np.concatenate(constants),
        cones,
        settings,
    )
    solution = solver.solve()
    return np.array(solution.x), str(solution.status)


def clarabel_phase_one(blocks, ceiling=1.0):
    """The largest t <= ceiling with G_k(x) >= t I for some x.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k, affine in k variables.
    ceiling : float
        Keeps t bounded where the blocks are homogeneous.

    Returns
    -------
    x : (k,) array
        Where t is the largest.
    t : float
        Positive if the blocks are feasible.
    status : str
        Clarabel's verdict.
    """
    lifted = type(blocks)(
        [*blocks.constants, np.array([[ceiling]])],
        [
            np.concatenate([s, -np.eye(s.shape[1])[None]])
            for s in [*blocks.slopes, np.zeros((blocks.variables, 1, 1))]
        ],
    )
    cost = np.zeros(lifted.variables)
    cost[-1] = -1.0
    x, status = clarabel_minimize(lifted, cost)
    return x[:-1], x[-1], status


def cvxpy_constraints(request, margin=0.0):
    """A request's LMIs as cvxpy constraints, to be copied elsewhere.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    margin : float
        Demands G >= margin * I. Never write ``G >> margin``, for cvxpy
        subtracts a scalar from every entry.

    Returns
    -------
    constraints : list
        The cvxpy constraints.
    P, Y : cvxpy.Variable
        The unknowns. With ``coupling="slack"`` P is a list, one for each vertex. The
        other unknowns are variables of the constraints, also the sizes of P
        that single requirements demand.

    Examples
    --------
    >>> from sosbook.synthesis.request import Request
    >>> from sosbook import SecondOrderSystem
    >>> import cvxpy
    >>> plant = SecondOrderSystem([[1]], [[1]], [[1]], B=[[1]])
    >>> constraints, P, Y = cvxpy_constraints(Request(plant), 0.1)
    >>> problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.trace(P)), constraints)
    >>> problem.solve(solver="CLARABEL") > 0
    True
    """
    cvxpy = library("cvxpy")
    expressions, unknowns = request.in_unknowns(None)
    copies = {u: cvxpy.Variable(u.shape, symmetric=u.symmetric) for u in unknowns}
    variables = {u.name: x for u, x in copies.items()}
    constraints = []
    for affine in expressions.values():
        g = affine.value(copies)
        symmetric = (g + g.T) / 2
        constraints.append(symmetric >> margin * np.eye(g.shape[0]))
    P = [variables[name] for name in request.lyapunov]
    V = variables.get("V")
    Y = variables.get("Y")
    if Y is None:
        Y = request.gain @ (P[0] if V is None else V.T)
    return constraints, (P[0] if V is None else P), Y
