"""What is asked of everybody: LMIs in some coordinates, and a judge.

A question has blocks that shall be positive definite, some unknowns, and
perhaps a cost to be least. Its ``design`` is what sosbook makes of it. Any
answer is brought to the plant's own coordinates and judged there: by the
eigenvalues of the blocks, and, where there is an optimum or a loop to look at,
by that.

The LMIs are written down when somebody asks for them: sosbook doesn't, who
makes its own.
"""

from functools import cached_property

import numpy as np
from scipy.linalg import eigvals, solve_continuous_are, solve_continuous_lyapunov

import sosbook as sos
from sosbook.delay.request import DelayRequest
from sosbook.lmi.problem import LMIProblem
from sosbook.lmi.text import LMIText
from sosbook.plants.descriptor import descriptors
from sosbook.solver.loop import margin
from sosbook.synthesis.observer_problem import ObserverProblem
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame

from .lqr import LqrTask

SMALLEST = 1e-9  # margin that floats can tell from zero
LARGEST_EXCESS = 1e-3  # of a cost over the optimum


class NoAnswer(Exception):
    """Raised where a competitor ends without a point."""


def right(judgement):
    """Whether an answer is right: its blocks hold, or its cost is the least."""
    if "excess" in judgement:
        return judgement["excess"] < LARGEST_EXCESS
    return judgement["margin"] > SMALLEST


class Pid:
    """A gain by `design_pid`; ``asked`` are its arguments.

    ``framed`` questions are in the coordinates that sosbook chooses, others in
    the plant's own.
    """

    cost = None

    def __init__(self, plant, asked, framed=False):
        self.plant, self.asked, self.framed = plant, asked, framed

    @classmethod
    def of(cls, request, framed=False):
        """The question of a request that was made already."""
        question = cls(request.plant, None, framed)
        vars(question)["request"] = request
        return question

    @cached_property
    def request(self):
        return Request(self.plant, **self.asked)

    @cached_property
    def lmis(self):
        one = np.eye(self.request.order)
        frame = Frame.of(self.request) if self.framed else Frame(one, one, one, 1.0)
        return ScaledLMIs(self.request, frame)

    def expressions(self):
        """The blocks as `Affine` expressions, and the unknowns."""
        lmis = self.lmis
        return list(lmis.text.in_unknowns().values()), lmis.unknowns

    def home(self, values):
        """The answer in the plant's units, of the unknowns by name."""
        return self.lmis.in_plant_units(values)

    def design(self):
        found = sos.design_pid(self.plant, **self.asked)
        if found.status != "feasible":
            raise NoAnswer(f"{found.status}: {getattr(found, 'reason', '')}"[:200])
        return dict(P=found.P, Y=found.Y, V=found.V, own=found.own or {})

    def judge(self, answer):
        """Smallest eigenvalue of the blocks, each diagonal scaled to one."""
        P, Y, V, own = (answer[name] for name in ("P", "Y", "V", "own"))
        blocks = self.request.blocks(P, Y, V=V, own=own)
        return dict(margin=min(margin(g) for g in blocks.values()))


class Lqr:
    """The least cost with Q = I and R = I under noise at F (Theorem 2.4)."""

    def __init__(self, plant, asked, framed=False):
        self.plant, self.asked, self.framed = plant, asked, framed

    @cached_property
    def task(self):
        return LqrTask.of(self.plant, self.framed)

    @cached_property
    def cost(self):
        return self.task.cost()

    def expressions(self):
        return self.task.expressions()

    def home(self, values):
        return dict(K=self.task.gain(*(values[name] for name in ("P", "Y", "J"))))

    def design(self):
        m, N = self.plant.m, 2 * self.plant.n
        found = sos.design_lqr(self.plant, np.eye(N), np.eye(m), noise="F")
        if found.status != "feasible":
            raise NoAnswer(found.status)
        return dict(K=found.K)

    def judge(self, answer):
        """Excess of the loop's true cost over that of the Riccati equation."""
        K = answer["K"]
        A, B, Bw = descriptors(self.plant)[0].state_space()
        X = solve_continuous_are(A, B, np.eye(len(A)), np.eye(B.shape[1]))
        loop = A + B @ K
        if not np.isfinite(K).all() or eigvals(loop).real.max() >= 0:
            return dict(excess=np.inf)
        Z = solve_continuous_lyapunov(loop.T, -np.eye(len(A)) - K.T @ K)
        return dict(excess=abs(np.trace(Bw.T @ Z @ Bw) / np.trace(Bw.T @ X @ Bw) - 1))


class Delay:
    """A gain by `design_delay_pid`, for every delay of an interval."""

    cost = None

    def __init__(self, plant, asked, framed=False):
        self.plant, self.asked, self.framed = plant, asked, framed

    @cached_property
    def request(self):
        request = DelayRequest(self.plant, **self.asked)
        if not self.framed:
            one = np.eye(request.states)
            vars(request)["frame"] = Frame(one, one, one, 1.0)
        return request

    @cached_property
    def lmis(self):
        return LMIProblem(LMIText(self.request.blocks, self.request.unknowns()))

    def expressions(self):
        return list(self.lmis.text.in_unknowns().values()), self.lmis.unknowns

    def home(self, values):
        return dict(frame=self.request.frame, values=values)

    def design(self):
        found = sos.design_delay_pid(self.plant, **self.asked)
        if found.status != "feasible":
            raise NoAnswer(f"{found.status}: {found.reason}"[:200])
        return dict(frame=found.request.frame, values=found.values)

    def judge(self, answer):
        """As for `Pid`, in the plant's own coordinates.

        In a frame x = T xi, and the equations are multiplied by ``left``: A F'
        was left A T F'. With C the inverse of left all blocks undergo a
        congruence with C if F becomes C F T', X becomes X C' times the unit of
        the input, and every other unknown becomes C . C'.
        """
        frame, values = answer["frame"], answer["values"]
        T, C, one = frame.T, np.linalg.inv(frame.left), np.eye(self.request.states)
        plain = DelayRequest(self.plant, **self.asked)
        vars(plain)["frame"] = Frame(one, one, one, 1.0)
        home = {name: C @ x @ C.T for name, x in values.items() if name not in "FX"}
        home["F"] = C @ values["F"] @ T.T
        home["X"] = frame.scale * values["X"] @ C.T
        blocks = plain.blocks(home)
        return dict(margin=min(margin((g + g.T) / 2) for g in blocks.values()))


class Observer:
    """The observer of least cost by `design_observer` (Theorem 2.5).

    The coordinates are those of the package's LMIs, for everybody.
    """

    def __init__(self, plant, asked, framed=True):
        self.plant, self.asked = plant, asked

    @cached_property
    def problem(self):
        (d,) = descriptors(self.plant)
        given = (self.asked[name] for name in ("K", "Q_F", "R_F", "C"))
        return ObserverProblem(self.plant, (d,), *given, [d.Bw])

    @cached_property
    def lmis(self):
        return self.problem.open()

    @cached_property
    def cost(self):
        J = self.lmis.unknowns[-1]
        cost = np.zeros(sum(u.size for u in self.lmis.unknowns))
        cost[-J.size :] = J.pack(np.eye(J.shape[0])).astype(float)
        return cost

    def expressions(self):
        return list(self.lmis.text.in_unknowns().values()), self.lmis.unknowns

    def home(self, values):
        return dict(L=self.problem.gain(values))

    def design(self):
        found = sos.design_observer(self.plant, **self.asked)
        if found.status != "feasible":
            raise NoAnswer(found.status)
        return dict(L=found.L)

    def judge(self, answer):
        """Excess of the error's true cost over that of the dual Riccati equation."""
        A, _, Bw = descriptors(self.plant)[0].state_space()
        C, L = self.asked["C"], answer["L"]
        Q, R = self.asked["Q_F"][: len(A)], self.asked["R_F"]
        Q, R = Q @ Q.T, R @ R.T
        X = solve_continuous_are(A.T, C.T, Q, R)
        loop = A + L @ C
        if not np.isfinite(L).all() or eigvals(loop).real.max() >= 0:
            return dict(excess=np.inf)
        Z = solve_continuous_lyapunov(loop, -Q - L @ R @ L.T)
        return dict(excess=abs(np.trace(Bw.T @ Z @ Bw) / np.trace(Bw.T @ X @ Bw) - 1))


#: The kinds of questions by name.
KINDS = dict(pid=Pid, lqr=Lqr, delay=Delay, observer=Observer)
