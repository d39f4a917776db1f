"""The loop of a gain: its poles, norms, peaks and motions."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import analysis
from ..plants.checks import count, finite
from ..plants.descriptor_system import OF_TICKS
from ..plants.second_order import Polytope
from ..requirements.cost import QuadraticCost, checked_cost
from ..runtime.array_like import ArrayLike
from .gains import Gains
from .result import Proven

if TYPE_CHECKING:
    from ..analysis.margins import DiskMargin
    from ..plants.response import Response
    from ..plants.signals import Sine, Step, Steps


class ClosedLoop(Gains[Proven]):
    """The loop of u = K x, at the vertices and between them, for a `Design`."""

    def _each(self, function):
        plant = self.request.plant
        return plant.per_vertex([function(d) for d in self.request.vertices])

    def _loops(self, samples, seed):
        """Descriptors of the vertices and of random plants between."""
        vertices, plant = self.request.vertices, self.request.plant
        if not count("samples", samples):
            return vertices
        if not isinstance(plant, Polytope) and len(vertices) == 1:
            raise ValueError(
                "samples asks for plants between several, but this is one plant: leave "
                "it out, or design for a Polytope or a DescriptorSystem with vertices"
            )
        inside = [
            replace(self.request, plant=one) for one in plant.sample(samples, seed)
        ]
        return vertices + tuple(d for request in inside for d in request.vertices)

    def open_loop(self) -> Any:
        """control.StateSpace from (u, w, r) to x; a list per vertex."""
        self._second_order("set point")
        return self._each(analysis.open_loop)

    def closed_loop(self) -> Any:
        """control.StateSpace from (w, r) to (z, u); a list per vertex."""
        K = self._gain()
        self._second_order("set point")
        return self._each(lambda d: analysis.closed_loop(d, K))

    def poles(self, samples: int = 0, seed: int = 0) -> np.ndarray:
        """Closed-loop poles, in rad/s; of a plant of discrete time its poles z.

        Parameters
        ----------
        samples : int
            For several vertices: how many random plants join them.
        seed : int
            Of the random plants.

        Returns
        -------
        (N,) array, or (vertices + samples, N) for a polytope
            One row for each vertex or sample of a polytope.
        """
        K = self._gain()
        poles = np.array([analysis.poles(d, K) for d in self._loops(samples, seed)])
        step = self._step
        return self.request.plant.per_vertex(
            poles if step is None else 1 + step * poles
        )

    @property
    def pole_axis(self) -> str:  # type: ignore[override]
        """The words below the picture of its poles."""
        return super().pole_axis if self._step is None else "poles z"

    @property
    def _step(self):
        """The tick of a plant of discrete time, or None."""
        return getattr(self.request, "step", None)

    def _of_time(self, what):
        """A ValueError for a plant of discrete time, of which there is no ``what``."""
        if self._step is not None:
            raise ValueError(OF_TICKS.format(what))

    def hinf(self, samples: int = 0, seed: int = 0) -> float:
        """The largest true H-infinity norm from w to z.

        Over the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        """
        K = self._gain()
        plant = self.request.plant
        if plant.p == 0 or plant.n == 0:
            lacking = "F" if plant.p == 0 else "C"
            raise ValueError(f"the plant has no {lacking}: there is no such norm")
        norm = partial(analysis.hinf_norm, step=self._step)
        return max(norm(d, K) for d in self._loops(samples, seed))

    def noise_cost(
        self, cost: QuadraticCost | None = None, samples: int = 0, seed: int = 0
    ) -> float:
        """The largest true quadratic cost under white noise.

        Parameters
        ----------
        cost : QuadraticCost, optional
            That of the request without it.
        samples, seed
            As in `poles`.
        """
        K, cost = self._gain(), self.request.cost if cost is None else cost
        if cost is None:
            raise ValueError(
                "cost is missing: the design was made without; give QuadraticCost(Q, R)"
            )
        cost = checked_cost(cost).stepped(self._step)
        return cost.truth(self._loops(samples, seed), K)

    def peak_input(self, samples: int = 0, seed: int = 0) -> float:
        """The largest signal that saturation bounds, from x0.

        That is |K x(t)|, or |K x + K_A z''| with ``acceleration``. Over
        the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        """
        K = self._gain()
        saturation = self.request.saturation
        if saturation is None:
            raise ValueError(
                "the design has no saturation, so no x0: simulate from the start that "
                "you mean, or design with saturation=Saturation(u_max, x0)"
            )
        return saturation.truth(self._loops(samples, seed), K, self.K_A)

    def peak_bound(self, x0: ArrayLike | None = None, energy: float = 0.0) -> float:
        """The bound of |K x(t)| by P, from x0, with r = 0.

        Parameters
        ----------
        x0 : (N,) array_like, optional
            Initial state; that of the saturation without it.
        energy : float
            The integral of w'w, which a design with gamma bears too.

        Returns
        -------
        float
            ``sqrt(|K P K'| (x0' P^-1 x0 + mu energy))``, for all plants
            that the LMIs cover; with a slack matrix the largest factors of
            the vertices. `peak_input` is the truth without w, and smaller.

        Notes
        -----
        Source: thesis Lemma 2.2, Theorem 2.1: V(x) = x' P^-1 x rises by
        less than mu w'w a second, and |K x|^2 is at most |K P K'| V.
        K_A z'' isn't in it.
        """
        K = self._gain()
        if self.P is None:
            raise ValueError(f"the design is {self.status}: there is no P")
        if x0 is None:
            saturation = self.request.saturation
            if saturation is None:
                raise ValueError(
                    "x0 is missing: the design has no saturation that names one"
                )
            points = [x for _, x in saturation.points]
        else:
            from ..plants.response import vector

            points = [vector("x0", x0, K.shape[1])]
        energy = finite("energy", energy)
        if energy < 0 or (energy and self.gamma is None):
            raise ValueError(
                "energy must not be negative, and only a design with gamma bears "
                f"any; got {energy!r}"
            )
        reach, height = [], []
        for P in [self.P] if self.V is None else self.P:
            spread = P if self.V is None else self.V @ np.linalg.solve(P, self.V.T)
            reach.append(np.linalg.norm(K @ spread @ K.T, 2))
            height += [x @ np.linalg.solve(spread, x) for x in points]
        rise = self.mu * energy if energy else 0.0
        return float(np.sqrt(max(reach) * (max(height) + rise)))

    def sensitivity_peak(self, samples: int = 0, seed: int = 0) -> float:
        """The largest sensitivity at the plant's input.

        Over the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        See `sosbook.analysis.margins.sensitivity_peak`.
        """
        K = self._gain()
        self._of_time("sensitivity_peak")
        return max(analysis.sensitivity_peak(d, K) for d in self._loops(samples, seed))

    def disk_margin(self, samples: int = 0, seed: int = 0) -> "DiskMargin":
        """The least `DiskMargin` at the plant's input.

        Over the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        """
        K = self._gain()
        self._of_time("disk_margin")
        margins = [analysis.disk_margin(d, K) for d in self._loops(samples, seed)]
        return min(margins, key=lambda margin: margin.radius)

    def simulate(
        self,
        t: ArrayLike,
        r: "ArrayLike | Step | Steps | None" = None,
        w: "Sine | Step | Steps | None" = None,
        x0: ArrayLike | None = None,
    ) -> "Response | list[Response]":
        """`Response` of the loop; a list of them per vertex.

        Parameters
        ----------
        t : (k,) array_like
            Increasing times in seconds, from 0.
        r : (n,) array_like, Step, Steps or Ramps, optional
            Set point; an array holds from t = 0 on.
        w : Sine, Step, Steps or Ramps, optional
            Disturbance.
        x0 : (N,) array_like, optional
            Initial state; zero without it. With a law that of the plant is enough,
            as in `Saturation`.
        """
        from ..analysis.precise import in_rationals

        K = self._gain()
        self._second_order("displacement z")
        x0 = self.request.applied.start(x0)
        return self._each(
            lambda d: analysis.simulate(d, K, t, r, w, x0, self.K_A, in_rationals(d, K))
        )
