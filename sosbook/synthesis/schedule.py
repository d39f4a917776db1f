"""A design's gain as a function of measured parameters, and motions through them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import comb
from typing import Any

import numpy as np

from ..plants.response import times, vector
from ..plants.schedule import Schedule
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly

ACCURACY = 1e-9  # relative, of a motion


@dataclass(frozen=True, eq=False)
class Moving(ReadOnly):
    """A motion while parameters move; columns belong to the times ``t``.

    ``x``, (N, k): the state, with the law's own; ``u``, (m, k): the input;
    ``parameters``: from a name to its values.
    """

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    parameters: Mapping[str, np.ndarray]


class ScheduledGain:
    """The gain K(p) of a design with a law `Scheduled`.

    Parameters
    ----------
    design : Design
        Whose plant has inputs for each corner of what is measured.
    """

    def __init__(self, design: Any) -> None:
        family = design.request.plant.family
        if family is None or not family.schedule:
            raise ValueError(
                "the design has no schedule: design with law=Scheduled(names)"
            )
        design._gain()
        self.request, self._family, self._gain = design.request, family, design.K
        #: The measured names, their ranges and the corners' weights.
        self.corners = Schedule(family.schedule, family.box)
        #: The gain at each corner, (corners, m, q), of what the law sees.
        self.gains = self._by_corner(design.K)

    def _by_corner(self, rows):
        return rows.reshape(len(self.corners.corners), -1, *rows.shape[1:])

    def K(self, /, **values: float) -> np.ndarray:
        """The gain, (m, q), at some ``values`` of what is measured, by name."""
        return self.mixed(self.gains, **values)

    def mixed(self, several: ArrayLike, /, **values: float) -> np.ndarray:
        """The mean of what the corners say by their weights, as the program has it.

        Parameters
        ----------
        several : (corners, ...) array_like
            Of each corner, such as its input.
        **values : float
            Of what is measured, by name.
        """
        several = np.asarray(several, float)
        total = np.zeros(several.shape[1:])
        for weight, x in zip(self.corners.weights(**values), several, strict=True):
            total = total + weight * x
        return total

    def simulate(
        self,
        t: ArrayLike,
        motion: Mapping[str, "float | Callable[[float], float]"],
        x0: ArrayLike,
    ) -> Moving:
        """The motion from a state while the parameters move.

        Parameters
        ----------
        t : (k,) array_like
            Increasing times, in seconds, from 0.
        motion : dict
            Of each parameter, measured or not, a number, or a function of the time.
        x0 : (N,) array_like
            Initial state; that of the plant is enough.

        Returns
        -------
        Moving
            By Runge and Kutta's method of order 8, to a relative error of 1e-9 a step.
        """
        from scipy.integrate import solve_ivp

        box, ticks = self._family.box, times(t)
        if not isinstance(motion, Mapping) or motion.keys() != set(box.names):
            raise ValueError(
                f"motion needs a number or a function of {', '.join(box.names)}, and "
                "nothing else"
            )
        moving = {
            k: x if callable(x) else (lambda _, x=x: x) for k, x in motion.items()
        }

        def at(s):
            return {name: float(moving[name](s)) for name in box.names}

        start = self.request.applied.start(np.asarray(x0, float))
        start = vector("x0", start, self.request.order)
        found = solve_ivp(
            lambda s, x: self._rate(at(s), x), (0.0, ticks[-1]), start, "DOP853", ticks,
            rtol=ACCURACY, atol=ACCURACY * max(np.abs(start).max(), 1e-9),
        )  # fmt: skip
        if not found.success:
            raise ArithmeticError(f"the motion wasn't found: {found.message}")
        along = [at(s) for s in ticks]
        wide = (self.request.applied.state_gain(self._gain) @ found.y).T
        measured = [{name: p[name] for name in self.corners.names} for p in along]
        u = [self.mixed(self._by_corner(x), **p) for x, p in zip(wide, measured)]
        parameters = {name: np.array([p[name] for p in along]) for name in box.names}
        return Moving(ticks, found.y, np.array(u).T, parameters)

    def _rate(self, point, x):
        """x' of a state x at some values of all parameters, by name."""
        shares = [1.0]
        for name, low, high in zip(self._family.box.names, *self._ends):
            d, p = int(self._family.degree[name]), point[name]
            if not low <= p <= high:
                raise ValueError(f"{name} = {p:g} isn't in [{low:g}, {high:g}]")
            s = (p - low) / (high - low)
            own = [comb(d, i) * s**i * (1 - s) ** (d - i) for i in range(d + 1)]
            shares = [a * b for a, b in product(shares, own)]
        E, A = (np.tensordot(shares, stack, 1) for stack in self._stacks)
        return np.linalg.solve(E, A @ x)

    @cached_property
    def _ends(self):
        box = self._family.box
        return [[float(x) for x in ends] for ends in (box.low, box.high)]

    @cached_property
    def _stacks(self):
        """E and A of the loop at Bernstein's coefficients of the ranges, not cut."""
        applied, K = self.request.applied, self._gain
        plant = self._family.within(self._family.box).polytope()
        loops = applied.vertices(plant, K, self.request.K_A)
        gain = applied.state_gain(K)
        closed = np.array([d.A + d.Bu @ gain for d in loops])
        return np.array([d.E for d in loops]), closed
