"""One class for each competitor: what it is given and how it is asked.

`Peer.prepare` turns a `Task` into the solver's own data, `Peer.solve` finds
(P, Y) from them. "end to end" is both, with the way from the plant and on to
the gain; "solve only" is the second alone. Unless a class says otherwise the
question is: maximise t <= 1 subject to G >= t I for every block G, whose
diagonal was scaled to about one. t > 0 is a strict solution.
"""

import importlib.util
import itertools
import os
import sys
import warnings
from contextlib import contextmanager

import numpy as np
from scipy import sparse
from scipy.linalg import solve_continuous_are
from sosbook.maps.search import replaced, requirements

from sosbook.lmi.centre import Blocks, centre, minimize, phase_one
from sosbook.plants.descriptor import descriptors
from sosbook.synthesis.pid import design_pid

from .cones import Task, compiled

__all__ = ["PEERS", "NoAnswer", "Peer"]

MAX_T = "max t <= 1 with G >= t I, diagonals scaled"


class NoAnswer(Exception):
    """Raised where a solver ends without a point."""


class Peer:
    """A competitor; subclasses say how."""

    name = package = ""
    formulation = MAX_T
    note = ""
    framed = True  # worth a second try in the frame's coordinates
    largest = 20  # n beyond which it isn't asked
    most_vertices = 20
    feasible = True  # finds points of any LMIs
    optimises = True  # can minimise a cost, too
    coordinates = "raw"
    whole = None  # a function that is timed end to end, in one
    clocks = ("end to end", "solve only")

    @classmethod
    def suits(cls, case):
        """Whether it can be asked this kind of question."""
        if case.family == "lqr":
            return cls.optimises
        return cls.feasible

    @classmethod
    def reaches(cls, case):
        if case.family == "vertices":
            return case.size <= cls.most_vertices
        return case.size <= cls.largest

    @classmethod
    def installed(cls):
        return importlib.util.find_spec(cls.package) is not None

    def prepare(self, task):
        raise NotImplementedError

    def solve(self, data):
        """P and Y in the task's coordinates."""
        raise NotImplementedError


class Sosbook(Peer):
    name = package = "sosbook"
    formulation = "feasible point, stops as soon as every block is positive"
    framed, coordinates = False, "frame"
    largest = most_vertices = 10**6

    def prepare(self, task):
        expressions, unknowns = task.expressions()
        blocks = Blocks.of(expressions, unknowns)
        getattr(blocks, "structure", None)  # made now, not while solving
        return task, blocks, unknowns

    def solve(self, data):
        task, blocks, unknowns = data
        phase = phase_one(blocks, start=task.first(unknowns))
        if phase.x is None:
            raise NoAnswer(phase.verdict)
        return unpacked(unknowns, self.finish(task, blocks, phase.x))

    def finish(self, task, blocks, x):
        if task.objective is None:
            return x
        return minimize(blocks, task.cost(), x, gap=1e-5)[0]


class SosbookCentre(Sosbook):
    name = "sosbook, complete design"
    formulation = "the analytic centre, gains and margins: design_pid"
    optimises = False
    largest = 100
    whole = staticmethod(design_pid)  # the clock "end to end"

    def finish(self, task, blocks, x):
        return centre(blocks, x)


class _Direct(Peer):
    """Peers that take cone data: minimise cost.x, all blocks >= 0."""

    most_vertices = 256

    def prepare(self, task):
        expressions, unknowns = task.expressions()
        cones = compiled(expressions, unknowns)
        if task.objective is None:
            cones = cones.scaled().lifted()
            cost = np.append(np.zeros(cones.variables - 1), -1.0)
        else:
            cost = task.cost()
        return self.data(cones, cost), unknowns

    def solve(self, data):
        data, unknowns = data
        x = self.point(data)
        if x is None or not np.isfinite(x).all():
            raise NoAnswer("no finite point")
        return unpacked(unknowns, x[: sum(u.size for u in unknowns)])

    def data(self, cones, cost):
        raise NotImplementedError

    def point(self, data):
        raise NotImplementedError


class Clarabel(_Direct):
    name = package = "clarabel"
    note = "cone data made by the benchmark, not by cvxpy"
    largest, most_vertices = 16, 20  # beyond, the next one and cvxpy speak

    def data(self, cones, cost):
        right, matrix = cones.stacked(_upper)
        return conic(cones, cost, right, matrix)

    def point(self, data):
        import clarabel

        settings = clarabel.DefaultSettings()
        settings.verbose = False
        cones = [clarabel.PSDTriangleConeT(q) for q in data["sizes"]]
        solver = clarabel.DefaultSolver(
            data["P"], data["c"], data["A"], data["b"], cones, settings
        )
        return np.array(self.run(solver).x)

    def run(self, solver):
        return solver.solve()


class ClarabelEarly(Clarabel):
    name = "clarabel, stopped early"
    optimises = False
    largest, most_vertices = 20, 20  # 256 vertices take more than 10 GB
    formulation = MAX_T + "; stopped by a callback once t > 0 is secure"

    def run(self, solver):
        def secure(info):  # the residual is far below t
            t = -info.cost_primal
            return t > 0 and info.res_primal < 1e-3 * t

        solver.set_termination_callback(secure)
        return solver.solve()


class SCS(_Direct):
    most_vertices = 20
    name = package = "scs"
    formulation = MAX_T + "; accuracy 1e-4 (its default), at most 20000 iterations"

    def data(self, cones, cost):
        right, matrix = cones.stacked(_lower)
        return conic(cones, cost, right, matrix)

    def point(self, data):
        import scs

        solver = scs.SCS(
            dict(A=data["A"], b=data["b"], c=data["c"]),
            dict(s=data["sizes"]),
            verbose=False,
            eps_abs=1e-4,
            eps_rel=1e-4,
            max_iters=20_000,
        )
        return solver.solve()["x"]


class CVXOPT(_Direct):
    name = package = "cvxopt"
    formulation = MAX_T + "; gap 1e-4, which is quicker and still right"

    def data(self, cones, cost):
        from cvxopt import matrix, spmatrix

        def convert(A):
            if isinstance(A, np.ndarray):
                return matrix(A)
            A = A.tocoo()
            return spmatrix(A.data, A.row, A.col, A.shape)

        G = [convert(-A) for A in cones.matrices]
        h = [matrix(b.reshape(q, q)) for b, q in zip(cones.constants, cones.sizes)]
        # the last variable is t, maximised, or J, minimised
        loose = {} if cost[-1] > 0 else dict(abstol=1e-4, reltol=1e-4, feastol=1e-5)
        return matrix(cost), G, h, dict(show_progress=False, **loose)

    def point(self, data):
        from cvxopt import solvers

        c, G, h, options = data
        try:
            found = solvers.sdp(c, Gs=G, hs=h, options=options)
        except (ArithmeticError, ValueError) as error:
            raise NoAnswer(str(error)) from error
        return None if found["x"] is None else np.array(found["x"]).ravel()


class SDPA(_Direct):
    name, package = "sdpa", "sdpap"
    most_vertices = 20
    note = (
        "its compiled part alone, without the checks of sdpap.solve; "
        "default accuracy: looser ones gave wrong answers"
    )

    def data(self, cones, cost):
        right, matrix = cones.stacked(_every)
        return (
            sparse.csc_matrix(-matrix.T),
            sparse.csc_matrix(-cost[:, None]),
            sparse.csc_matrix(right[:, None]),
            tuple(cones.sizes),
        )

    def point(self, data):
        from sdpap.param import param
        from sdpap.sdpacall.sdpacall import solve_sdpa
        from sdpap.symcone import SymCone

        A, b, c, sizes = data
        options = param(dict(print="no", numThreads=1))
        with silence():
            found = solve_sdpa(A, b, c, SymCone(s=sizes), options)
        return found[1].toarray().ravel()


class Cvxpy(Peer):
    name = "cvxpy + clarabel"
    package = "cvxpy"
    note = "problem built by hand from the theorems and compiled each time"
    clocks = ("end to end",)

    def prepare(self, task):
        return task

    def solve(self, data):
        return cvxpy_answer(*cvxpy_problem(data))


class CvxpyCentre(Peer):
    name = "cvxpy + clarabel, centre"
    package = "cvxpy"
    formulation = "the analytic centre: maximise the sum of log det G"
    note = "the point that sosbook's complete design stands on"
    clocks = ("end to end",)
    optimises = False
    largest = 4

    def prepare(self, task):
        return task

    def solve(self, data):
        import cvxpy

        P, Y = (cvxpy.Variable(u.shape, symmetric=u.symmetric) for u in data.unknowns)
        blocks = data.blocks(P, Y).values()
        volume = sum(cvxpy.log_det((g + g.T) / 2) for g in blocks)
        return cvxpy_answer(cvxpy.Problem(cvxpy.Maximize(volume)), [P, Y])


class CvxpyDPP(Peer):
    name = "cvxpy + clarabel, DPP"
    package = "cvxpy"
    formulation = MAX_T + "; gamma^2, sigma and u_max^2 are Parameters"
    optimises = False
    clocks = ("solve only",)
    note = "compiled once before; solve only, with new parameter values"
    largest = 8

    def prepare(self, task):
        import cvxpy

        parameters = []

        def parameter(value):
            found = cvxpy.Parameter(value=value)
            parameters.append((found, value))
            return found

        problem, variables = cvxpy_problem(task, parameter)
        data = problem, variables, parameters
        self.solve(data)  # compiles
        return data

    steps = itertools.cycle([1.0, 1.0 + 1e-9])

    def solve(self, data):
        problem, variables, parameters = data
        factor = next(self.steps)
        for found, value in parameters:
            found.value = value * factor
        return cvxpy_answer(problem, variables)


class Picos(Peer):
    name, package = "picos + cvxopt", "picos"
    note = "products L X R summed by PICOS, compiled each time"
    clocks = ("end to end",)
    largest = 16

    def prepare(self, task):
        return task, compiled(*task.expressions()).diagonals()

    def solve(self, data):
        import picos

        task, diagonals = data
        expressions, unknowns = task.expressions()
        variables = [
            picos.SymmetricVariable(u.name, u.shape[0])
            if u.symmetric
            else picos.RealVariable(u.name, u.shape)
            for u in unknowns
        ]
        X = dict(zip(unknowns, variables))
        problem = picos.Problem()
        problem.options.verbosity = -1
        if task.objective is None:
            t = picos.RealVariable("t")
            problem.add_constraint(t <= 1)
            problem.set_objective("max", t)
        else:
            t = 0
            J = variables[task.objective]
            problem.set_objective("min", picos.trace(J))
        for g, d in zip(expressions, diagonals):
            total = picos.Constant(g.constant.astype(float))
            for term in g.terms:
                x = X[term.unknown].T if term.transposed else X[term.unknown]
                left = picos.Constant(term.left.astype(float))
                right = picos.Constant(term.right.astype(float))
                total = total + left * x * right
            total = 0.5 * (total + total.T)
            problem.add_constraint(total >> t * picos.Constant(np.diag(d)))
        try:
            problem.solve(solver="cvxopt", primals=None, duals=False)
        except (picos.SolutionFailure, ArithmeticError, ValueError) as error:
            raise NoAnswer(str(error)) from error
        if any(v.value is None for v in variables):
            raise NoAnswer("no point")
        found = [np.atleast_2d(np.array(v.value, float)) for v in variables]
        return [v.reshape(u.shape) for v, u in zip(found, unknowns)]


class Riccati(Peer):
    name, package = "scipy, Riccati", "scipy"
    formulation = "no LMI: the Riccati equation"
    note = "for one certain plant an LQR needs no LMI"
    framed = feasible = False

    def prepare(self, task):
        A, B, Bw = descriptors(task.plant)[0].state_space()
        return A, B, Bw, np.eye(len(A)), np.eye(B.shape[1])

    def solve(self, data):
        A, B, Bw, Q, R = data
        X = solve_continuous_are(A, B, Q, R)
        P = np.linalg.inv(X)
        return P, -B.T @ X @ P, Bw.T @ X @ Bw


PEERS = {
    peer.name: peer
    for peer in (
        Sosbook,
        SosbookCentre,
        Clarabel,
        ClarabelEarly,
        Cvxpy,
        CvxpyDPP,
        CvxpyCentre,
        CVXOPT,
        SDPA,
        SCS,
        Picos,
        Riccati,
    )
}


def conic(cones, cost, right, matrix):
    """Data of Clarabel and SCS."""
    k = cones.variables
    return dict(
        P=sparse.csc_matrix((k, k)), c=cost, A=-matrix, b=right, sizes=cones.sizes
    )


def cvxpy_problem(task, parameter=None):
    """The task as a cvxpy Problem; with Parameters where they are asked."""
    import cvxpy

    variables = [cvxpy.Variable(u.shape, symmetric=u.symmetric) for u in task.unknowns]
    if parameter is None:
        blocks = task.blocks(*variables)
    else:
        blocks = _with_parameters(task, *variables, parameter)
    if task.objective is not None:
        goal = cvxpy.Minimize(cvxpy.trace(variables[task.objective]))
        return cvxpy.Problem(
            goal, [(g + g.T) / 2 >> 0 for g in blocks.values()]
        ), variables
    t = cvxpy.Variable()
    constraints = [t <= 1]
    weights = compiled(*task.expressions()).diagonals()
    for g, d in zip(blocks.values(), weights):
        constraints.append((g + g.T) / 2 >> t * np.diag(d))
    return cvxpy.Problem(cvxpy.Maximize(t), constraints), variables


def _with_parameters(task, P, Y, parameter):
    """The blocks, with gamma^2, sigma and u_max^2 as cvxpy Parameters."""
    gamma = task.request.gamma
    levels = {} if gamma is None else {"gamma": parameter(gamma**2)}
    blocks = task.blocks(P, Y, levels)
    asked = requirements(task.request)
    for name, key, factor in (
        ("sigma", "half-plane", 2),
        ("u_max", "u_max", np.sqrt(2)),
    ):
        if name not in asked:
            continue
        other = replaced(task.request, asked | {name: factor * asked[name]})
        other = Task(other, task.frame).blocks(P, Y)
        size = parameter(1.0)  # in units of what was asked
        for block in blocks:
            if block.split(" ")[0] == key:
                slope = other[block] - task.blocks(P, Y)[block]
                blocks[block] = blocks[block] + (size - 1) * slope
    return blocks


def cvxpy_answer(problem, variables):
    import cvxpy

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            problem.solve(solver="CLARABEL")
        except cvxpy.SolverError as error:
            raise NoAnswer(str(error)) from error
    if any(v.value is None for v in variables):
        raise NoAnswer(problem.status)
    return [v.value for v in variables]


def unpacked(unknowns, x):
    ends = np.cumsum([u.size for u in unknowns])[:-1]
    return [u.unpack(part) for u, part in zip(unknowns, np.split(x, ends))]


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


def _upper(q):
    """Upper triangle column by column, off-diagonal times sqrt 2."""
    j, i = np.tril_indices(q)
    return i * q + j, np.where(i == j, 1.0, np.sqrt(2.0))


def _lower(q):
    """Lower triangle column by column, off-diagonal times sqrt 2."""
    j, i = np.triu_indices(q)
    return i * q + j, np.where(i == j, 1.0, np.sqrt(2.0))


def _every(q):
    return np.arange(q * q), np.ones(q * q)
