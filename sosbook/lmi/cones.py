"""The same blocks for general solvers, by cvxpy.

They serve as cross-checks and for those who use other solvers; designs go
through `centre`.
"""

import numpy as np

from ..runtime.libraries import library


def cvxpy_constraints(request, margin=0.0):
    """A request's LMIs as cvxpy constraints, to be copied elsewhere.

    ``request``: what is asked of the plant; ``margin``: demands G >= margin * I. Never
    write ``G >> margin``, for cvxpy subtracts a scalar from every entry. Returns
    constraints: the cvxpy constraints; P, Y: the unknowns. With ``coupling="slack"`` P
    is a list, one for each vertex. The other unknowns are variables of the constraints,
    also the sizes of P that single requirements demand.

    >>> from sosbook.synthesis.request import Request
    >>> from sosbook import SecondOrderSystem
    >>> import cvxpy
    >>> plant = SecondOrderSystem([[1]], [[1]], [[1]], B=[[1]])
    >>> constraints, P, Y = cvxpy_constraints(Request(plant), 0.1)
    >>> problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.trace(P)), constraints)
    >>> problem.solve(solver="CLARABEL") > 0
    True
    """
    expressions, unknowns = request.in_unknowns(None)
    constraints, copies = in_cvxpy(expressions, unknowns, margin)
    variables = {u.name: x for u, x in copies.items()}
    P = [variables[name] for name in request.lyapunov]
    V = variables.get("V")
    Y = variables.get("Y")
    if Y is None:
        Y = request.gain @ (P[0] if V is None else V.T)
    return constraints, (P[0] if V is None else P), Y


def in_cvxpy(expressions, unknowns, margin):
    """The constraints G >= ``margin`` I for the `Affine` ``expressions`` G by name, and
    the variable of each of the ``unknowns``.
    """
    cvxpy = library("cvxpy")
    copies = {u: cvxpy.Variable(u.shape, symmetric=u.symmetric) for u in unknowns}
    blocks = [g.value(copies) for g in expressions.values()]
    constraints = [(g + g.T) / 2 >> margin * np.eye(g.shape[0]) for g in blocks]
    return constraints, copies
