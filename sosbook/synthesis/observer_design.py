"""An observer and what is known about the loop with it."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..analysis.margins import DiskMargin
from ..exact.definite import round_digits
from ..exact.proof import first_proven
from ..laws.taken import taken
from ..plants.descriptor import mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import input_names, signals
from ..plants.response import Response, simulate, vector
from ..plants.sensed import row_words
from ..plants.signals import Sine, Step
from ..runtime.array_like import ArrayLike
from ..runtime.libraries import library
from ..runtime.read_only import ReadOnly
from .design import Design
from .error_loop import observed, observer_loop, vertices_of
from .observer_problem import ObserverProof, ObserverRefusal, refuse_observer
from .pid import analyse_pid
from .request import Request
from .result import Result

__all__ = ["ObserverDesign", "ObserverProof", "ObserverResponse"]


@dataclass(frozen=True, eq=False)
class ObserverResponse(Response):
    """Signals of a loop with an observer; columns belong to the times. ``t``, ``z``,
    ``dz``, ``e``, ``u``, ``x``, ``w``: as in `Response`; z is what the plant's C picks,
    and e = z; ``estimate``, (N, k): x^, the observer's state.
    """

    estimate: np.ndarray | None = None


@dataclass(frozen=True, eq=False, repr=False)
class ObserverDesign(Result[ObserverProof], ReadOnly):
    """An observer and what is known about the loop with it.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        The plant, or the polytope of plants.
    K : (m, N) array
        The state feedback, u = K x^.
    C : (q, N) array
        What is measured.
    status : {"feasible", "infeasible", "undecided"}
        Of Theorem 2.5, which speaks of the vertices only.
    L : (N, q) array or None
        In E^ x^' = A^ x^ + B^ u + E^ L (C x^ - y): stabilising L are
        mostly negative.
    bound : float or None
        tr J, which bounds the cost of the error at the vertices.
    margins : dict or None
        From a block's name to its smallest eigenvalue, after scaling
        its diagonal to one.
    values : dict or None
        The unknowns of Theorem 2.5 by name.
    problem : object or None
        The LMIs that were solved.
    multipliers : list of arrays or None
        Of their blocks, where there is no observer.
    reason : str
        Why there is no observer: what is proven, or what was excluded and what
        was merely not found. Empty for a feasible design.
    """

    plant: Any
    K: np.ndarray
    C: np.ndarray
    status: str
    L: np.ndarray | None = None
    bound: float | None = None
    margins: dict | None = None
    values: dict | None = None
    problem: Any = None
    multipliers: list | None = None
    reason: str = ""

    def __repr__(self):
        bound = "" if self.bound is None else f", bound {self.bound:.4g}"
        return f"<ObserverDesign: {self.status}{bound}>"

    def _matrices(self):
        return ("K", self.K), ("L", self._observer())

    def _observer(self):
        if self.L is None:
            raise ValueError(
                f"the design is {self.status}: there is no L; see its advice"
            )
        return self.L

    @cached_property
    def infeasibility(self) -> ObserverRefusal | None:
        """The exact proof that there is none, where one was found; else None."""
        if self.multipliers is None:
            return None
        return refuse_observer(self.problem)

    @cached_property
    def advice(self) -> str:
        """Advice on a change; empty if feasible.

        For the mean plant alone there is an observer: `design_observer` refuses a K
        that doesn't stabilise it, and a C that doesn't see what is unstable there.
        """
        if self.status == "feasible" or self.problem is None:
            return self.reason
        if len(self.problem.vertices) > 1:
            return (
                "The mean plant alone has such an observer: shrink the polytope, or "
                "take a gentler K."
            )
        return "Measure more (C), or take a gentler K."

    def loop(self) -> DescriptorSystem:
        """E x' = A x of the error and the state, a `DescriptorSystem`."""
        return observer_loop(self.plant, *self._gains())

    def poles(self) -> np.ndarray:
        """Poles of the loop with the observer, in rad/s.

        Returns
        -------
        (2N,) array, or (vertices, 2N) for a polytope
            One row for each vertex or sample of a polytope.
        """
        return self._opened.poles()

    def simulate(
        self,
        t: ArrayLike,
        x0: ArrayLike | None = None,
        w: Sine | Step | None = None,
        estimate: ArrayLike | None = None,
    ) -> Any:
        """`ObserverResponse` of the loop; a list of them per vertex.

        Parameters
        ----------
        t : (k,) array_like
            Increasing times, in seconds, from 0.
        x0 : (N,) array_like, optional
            Initial state; zero without it.
        w : Sine or Step, optional
            Disturbance.
        estimate : (N,) array_like, optional
            The observer's initial state; zero without it.
        """
        N = len(self._observer())
        x0, guess = vector("x0", x0, N), vector("estimate", estimate, N)
        start = np.concatenate([x0 - guess, x0])
        loops = self.loop().vertices
        return self.plant.per_vertex(
            [
                self._response(d, loop, t, start, w)
                for d, loop in zip(vertices_of(self.plant), loops)
            ]
        )

    def _response(self, d, loop, t, start, w):
        N = len(self.L)
        loop = replace(loop, Bw=np.vstack([d.Bw, d.Bw]))
        both = simulate(loop, np.zeros((0, 2 * N)), t, w=w, x0=start)
        x, estimate = both.x[N:], both.x[N:] - both.x[:N]
        u = self.K @ estimate
        A, B, Bw = d.state_space()
        z, rate = d.C @ x, A @ x + B @ u + Bw @ both.w
        return ObserverResponse(both.t, z, d.C @ rate, z, u, x, both.w, estimate)

    def _prove(self, digits: int | None) -> ObserverProof:
        given = self._observer()

        def attempt(digits, places):
            L = round_digits(given, digits)
            values = {name: round_digits(x, places) for name, x in self.values.items()}
            contents = ObserverProof.contents(self.problem, L, self.bound, values)
            return ObserverProof.of(contents)

        return first_proven(attempt, digits)

    def analyse(self, **asked: Any) -> Design:
        """`analyse_pid` of the whole polytope, with K and L fixed.

        Theorem 2.5 says nothing between the vertices; this does.

        Parameters
        ----------
        **asked
            Keywords of `analyse_pid`. The state is that of `loop`, the error and
            the plant's state, and the gain of u = K x^ is [-K K] there.

        Examples
        --------
        >>> from sosbook import SecondOrderSystem, design_observer
        >>> plant = SecondOrderSystem([[1]], [[0.1]], [[-1]], [[1]], [[1]])
        >>> observer = design_observer(
        ...     plant, [[-3, -2]], Q_F=[[0], [1], [0], [0]], R_F=[[0.1]])
        >>> found = observer.analyse(coupling="slack", minimize="gamma")
        >>> found.certify().proven, found.hinf() < found.gamma
        (True, True)
        """
        return analyse_pid(*observed(self.plant, *self._gains()), **asked)

    def _gains(self):
        return self.K, self._observer(), self.C

    @cached_property
    def _opened(self):
        """The loop as a `Design` that knows its gain, and nothing proven."""
        system, gain = observed(self.plant, *self._gains())
        return Design(Request(system, gain=gain), "undecided", gain)

    def sensitivity_peak(self, samples: int = 0, seed: int = 0) -> float:
        """The largest sensitivity at the plant's input, the observer in the loop.

        As `Design.sensitivity_peak`, which takes the same arguments.

        Parameters
        ----------
        samples : int
            For several vertices: how many random plants join them.
        seed : int
            Of the random plants.

        Notes
        -----
        The loop is opened where u = K x^ enters the plant; the observer goes on
        with the u that was meant. State feedback alone has margins that an
        observer may take away: Doyle, IEEE Trans. Automatic Control 23, 1978,
        756-757.
        """
        return self._opened.sensitivity_peak(samples, seed)

    def disk_margin(self, samples: int = 0, seed: int = 0) -> DiskMargin:
        """The least `DiskMargin` at the plant's input, the observer in the loop.

        ``samples`` and ``seed`` are as in `sensitivity_peak`.
        """
        return self._opened.disk_margin(samples, seed)

    def controller(self) -> Any:
        """The controller from y to u as python-control's StateSpace, with names."""
        L = self._observer()
        d = mean_descriptor(vertices_of(self.plant))
        A, B, _ = d.state_space()
        names = [row_words(x, signals(self.plant), repr) for x in self.C.tolist()]
        return library("control").ss(
            A + B @ self.K + L @ self.C,
            -L,
            self.K,
            np.zeros((len(self.K), len(self.C))),
            inputs=[x.replace(".", "_") for x in names],
            outputs=list(input_names(len(self.K))),
        )

    def its_law(self) -> tuple:
        """The controller as a `DynamicLaw` and its numbers."""
        return taken(self.plant, self.controller())
