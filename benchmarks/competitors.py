"""One class for each competitor: how it is asked a question.

Each is given the blocks of a `benchmarks.questions` question. Where there is a
cost it is minimised. Otherwise the question is: maximise t <= 1 subject to
G >= t I for every block G, whose diagonal was scaled to about one; t > 0 is a
strict solution.
"""

import importlib.util
import os
import sys
import warnings
from contextlib import contextmanager

import numpy as np
from scipy import sparse

from .cones import compiled
from .questions import NoAnswer


class Competitor:
    """A competitor; subclasses say how.

    ``asked`` is in words what it is asked; ``prepare`` is not timed, and what making
    the ``data`` takes is told beside the time.
    """

    name = package = ""
    asked = "max t <= 1 with G >= t I"
    growth = 4  # time grows at least like this power of the degrees of freedom

    @classmethod
    def installed(cls):
        return importlib.util.find_spec(cls.package) is not None

    def prepare(self, make):
        """What may be done once, from a maker of the question."""

    def answer(self, make):
        """The question and its answer in the plant's coordinates."""
        return self.ready(make)()

    def ready(self, make):
        """`answer` as a function that begins with finished data."""
        question = make()
        expressions, unknowns = question.expressions()
        data = self.data(expressions, unknowns, question.cost)
        return lambda: (question, home(question, unknowns, self.solve(*data)))

    def data(self, expressions, unknowns, cost):
        """The arguments of `solve`: the question in the competitor's own form."""
        return expressions, unknowns, cost

    def solve(self, *data):
        """The unknowns' free entries in a row."""
        raise NotImplementedError


def home(question, unknowns, x):
    """An answer from the unknowns' entries in a row."""
    count = sum(u.size for u in unknowns)
    if x is None or len(x) < count or not np.isfinite(x[:count]).all():
        raise NoAnswer("no finite point")
    parts = np.split(
        np.asarray(x, float)[:count], np.cumsum([u.size for u in unknowns])
    )
    return question.home({u.name: u.unpack(p) for u, p in zip(unknowns, parts)})


class Sosbook(Competitor):
    """Everything that a user gets: centre, gains and margins."""

    name = package = "sosbook"
    asked = "the complete design"

    def ready(self, make):
        question = make()
        return lambda: (question, question.design())


class Direct(Competitor):
    """Those that take cone data: minimise cost.x, all blocks >= 0."""

    def data(self, expressions, unknowns, cost):
        cones = compiled(expressions, unknowns)
        if cost is None:
            cones = cones.scaled().lifted()
            cost = np.append(np.zeros(cones.variables - 1), -1.0)
        return self.formed(cones, cost)

    def formed(self, cones, cost):
        """The sizes of the blocks, the right side, the matrix and the cost."""
        return cones.sizes, *cones.stacked(self.rows), cost


class Clarabel(Direct):
    """Cone data made by the benchmark, and an end as soon as t > 0 is secure."""

    name = package = "clarabel"
    asked = Competitor.asked + ", stopped as soon as t > 0 is secure"

    def rows(self, q):
        """Upper triangle column by column, off-diagonal times sqrt 2."""
        j, i = np.tril_indices(q)
        return i * q + j, np.where(i == j, 1.0, np.sqrt(2.0))

    def solve(self, sizes, right, matrix, cost):
        import clarabel

        settings = clarabel.DefaultSettings()
        settings.verbose = False
        kinds = [clarabel.PSDTriangleConeT(q) for q in sizes]
        P = sparse.csc_matrix((len(cost),) * 2)
        solver = clarabel.DefaultSolver(P, cost, -matrix, right, kinds, settings)
        if cost[-1] < 0:  # the last variable is t

            def secure(info):  # the residual is far below t
                t = -info.cost_primal
                return t > 0 and info.res_primal < 1e-3 * t

            solver.set_termination_callback(secure)
        return np.array(solver.solve().x)


class SCS(Direct):
    """Accuracy 1e-4 (its default)."""

    name = package = "scs"
    growth = 2

    def rows(self, q):
        """Lower triangle column by column, off-diagonal times sqrt 2."""
        j, i = np.triu_indices(q)
        return i * q + j, np.where(i == j, 1.0, np.sqrt(2.0))

    def solve(self, sizes, right, matrix, cost):
        import scs

        solver = scs.SCS(
            dict(A=-matrix, b=right, c=cost),
            dict(s=sizes),
            verbose=False,
            eps_abs=1e-4,
            eps_rel=1e-4,
            max_iters=20_000,
        )
        return solver.solve()["x"]


class CVXOPT(Direct):
    """Gap 1e-4 where any point will do, which is quicker and still right."""

    name = package = "cvxopt"

    def formed(self, cones, cost):
        from cvxopt import matrix, spmatrix

        def convert(A):
            if isinstance(A, np.ndarray):
                return matrix(A)
            A = A.tocoo()
            return spmatrix(A.data, A.row, A.col, A.shape)

        G = [convert(-A) for A in cones.matrices]
        h = [matrix(b.reshape(q, q)) for b, q in zip(cones.constants, cones.sizes)]
        return G, h, matrix(cost), bool(cost[-1] < 0)

    def solve(self, G, h, cost, any_point):
        from cvxopt import solvers

        loose = dict(abstol=1e-4, reltol=1e-4, feastol=1e-5) if any_point else {}
        options = dict(show_progress=False, **loose)
        try:
            found = solvers.sdp(cost, Gs=G, hs=h, options=options)
        except (ArithmeticError, ValueError) as error:
            raise NoAnswer(str(error)) from error
        return None if found["x"] is None else np.array(found["x"]).ravel()


class SDPA(Direct):
    """Its compiled part alone, without the checks of sdpap.solve."""

    name, package = "sdpa", "sdpap"

    def rows(self, q):
        return np.arange(q * q), np.ones(q * q)

    def formed(self, cones, cost):
        right, matrix = cones.stacked(self.rows)
        data = -matrix.T, -cost[:, None], right[:, None]
        return tuple(cones.sizes), *map(sparse.csc_matrix, data)

    def solve(self, sizes, *data):
        from sdpap.param import param
        from sdpap.sdpacall.sdpacall import solve_sdpa
        from sdpap.symcone import SymCone

        options = param(dict(print="no", numThreads=1))
        with silence():
            found = solve_sdpa(*data, SymCone(s=sizes), options)
        return found[1].toarray().ravel()


class Cvxpy(Competitor):
    """The blocks written with cvxpy's variables, compiled each time."""

    name, package = "cvxpy + clarabel", "cvxpy"

    def solve(self, expressions, unknowns, cost):
        import cvxpy

        variables = {
            u: cvxpy.Variable(u.shape, symmetric=u.symmetric) for u in unknowns
        }
        blocks = [written(g, variables) for g in expressions]
        if cost is None:
            t = cvxpy.Variable()
            sizes = compiled(expressions, unknowns).diagonals()
            limits = [g >> t * np.diag(d) for g, d in zip(blocks, sizes)]
            problem = cvxpy.Problem(cvxpy.Maximize(t), [t <= 1, *limits])
        else:
            goal = cvxpy.Minimize(cvxpy.trace(variables[unknowns[-1]]))
            problem = cvxpy.Problem(goal, [g >> 0 for g in blocks])
        solved(problem)
        if any(v.value is None for v in variables.values()):
            raise NoAnswer(problem.status)
        return np.concatenate([u.pack(v.value) for u, v in variables.items()])


class CvxpyDPP(Competitor):
    """Compiled once, within the limit; timed is a second solve."""

    name, package = "cvxpy + clarabel, DPP", "cvxpy"
    asked = Competitor.asked + ", compiled before"

    def prepare(self, make):
        import cvxpy

        question = make()
        expressions, unknowns = question.expressions()
        cones, cost = compiled(expressions, unknowns), question.cost
        if cost is None:
            cones = cones.scaled().lifted()
            cost = np.append(np.zeros(cones.variables - 1), -1.0)
        self.parameter = cvxpy.Parameter(value=1.0, nonneg=True)
        self.x = cvxpy.Variable(cones.variables)
        blocks = []
        for c, A, q in zip(cones.constants, cones.matrices, cones.sizes):
            g = cvxpy.reshape(self.parameter * c + A @ self.x, (q, q), order="C")
            blocks.append((g + g.T) / 2 >> 0)
        self.problem = cvxpy.Problem(cvxpy.Minimize(cost @ self.x), blocks)
        self.question, self.unknowns = question, unknowns
        solved(self.problem)

    def ready(self, make):
        return self.again

    def again(self):
        self.parameter.value = 1.0 if self.parameter.value > 1 else 1.0 + 1e-9
        solved(self.problem)
        return self.question, home(self.question, self.unknowns, self.x.value)


COMPETITORS = {
    c.name: c for c in (Sosbook, Clarabel, Cvxpy, CvxpyDPP, CVXOPT, SDPA, SCS)
}


def written(g, variables):
    """An `Affine` expression with cvxpy's variables: its products, summed."""
    total = g.constant.astype(float)
    for term in g.terms:
        X = variables[term.unknown]
        X = X.T if term.transposed else X
        total = total + term.left.astype(float) @ X @ term.right.astype(float)
    return (total + total.T) / 2


def solved(problem):
    import cvxpy

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            problem.solve(solver="CLARABEL")
        except cvxpy.SolverError as error:
            raise NoAnswer(str(error)) from error


@contextmanager
def silence():
    """What a compiled solver prints goes nowhere."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
