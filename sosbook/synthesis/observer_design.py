"""An observer and what is known about the loop with it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.definite import round_digits
from ..exact.proof import first_proven
from ..laws.taken import taken
from ..plants.gain import input_names, signals
from ..plants.response import Response, simulate, vector
from ..plants.sensed import row_words
from ..plants.signals import Sine, Step
from ..runtime.array_like import ArrayLike
from ..runtime.later import later
from ..runtime.libraries import library
from ..runtime.read_only import ReadOnly
from .design import Design
from .error_loop import observed, vertices_of
from .observer_model import ObserverModel
from .observer_problem import ObserverProof, ObserverRefusal, refuse_observer
from .pid import analyse_pid
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
    model : ObserverModel or None
        What the observer follows, and the ``place`` of its poles, if these were asked:
        with loads L has their rows below, and where sensors are believed it has those
        of the rest alone.
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
    model: Any = None

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

    @property
    def loop(self) -> Any:
        """The `Loop` of the plant and the observer, whose memory is x^."""
        return later("loops", "Loop")(self.plant, *self.its_law())

    def poles(self) -> np.ndarray:
        """Poles of the loop with the observer, in rad/s.

        Returns
        -------
        (2N,) array, or (vertices, 2N) for a polytope
            One row for each vertex or sample of a polytope.
        """
        return self.loop.design.poles()

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
        estimate : array_like, optional
            The observer's initial memory, of as many numbers as L has rows; zero
            without it.
        """
        self.loop.design._of_time("simulate")
        N, request = self.C.shape[1], self.loop.request
        memory = vector("estimate", estimate, len(self._observer()))
        start = np.append(vector("x0", x0, N), memory)
        K = request.state_gain
        motions = [(d, simulate(d, K, t, w=w, x0=start)) for d in request.vertices]
        return self.plant.per_vertex([self._response(*each) for each in motions])

    def _response(self, d, both):
        A, B, Bw = d.state_space()
        x, memory = np.split(both.x, [self.C.shape[1]])
        estimate = self._model.estimate(self.L, memory, self.C @ x)
        z, rate = d.C @ both.x, A @ both.x + B @ both.u + Bw @ both.w
        whole = both.t, z, d.C @ rate, z, both.u, x, both.w, estimate
        return ObserverResponse(*whole)

    def _prove(self, digits: int | None) -> ObserverProof:
        given = self._observer()
        if self.model is not None:  # of the loop, which has K's poles, too
            place = self.model.place
            inside = place.contains(self.poles())
            return self.loop.prove(*(place.parts if inside else ()))

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
            Keywords of `analyse_pid`. The state is that of `observer_loop`, the error
            and the plant's state, and the gain of u = K x^ is [-K K] there.

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
        if not self._model.plain:
            raise ValueError(
                "analyse speaks of an observer of x alone: take observer.loop.prove("
                "...), or analyse_pid(plant, observer, ...)"
            )
        return self.K, self._observer(), self.C

    @property
    def _model(self):
        if self.model is not None:
            return self.model
        return ObserverModel(tuple(vertices_of(self.plant)), self.K, self.C)

    def controller(self) -> Any:
        """The controller from y to u as python-control's StateSpace, with names."""
        flow, push, out, at_once = self._model.controller(self._observer())
        names = [row_words(x, signals(self.plant), repr) for x in self.C.tolist()]
        dt = getattr(self.plant, "dt", 0)
        if dt:
            flow, push = np.eye(len(flow)) + dt * flow, dt * push
        return library("control").ss(
            flow,
            push,
            out,
            at_once,
            inputs=[x.replace(".", "_") for x in names],
            outputs=list(input_names(len(self.K))),
            dt=dt or 0,
        )

    def its_law(self) -> tuple:
        """The controller as a `DynamicLaw` and its numbers."""
        return taken(self.plant, self.controller())
