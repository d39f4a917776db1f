"""The design of a controller behind a delay."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..bisection import narrowed
from ..plants.signals import Sine, Step
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly
from ..synthesis.gains import Gains
from . import spectrum
from .crossings import stable_delays
from .inner_points import solvable
from .profiles import ConstantDelay
from .proofs import DelayProof, prove_delay
from .request import DelayRequest
from .simulation import simulate_delay


@dataclass(frozen=True, eq=False, repr=False)
class DelayDesign(Gains[DelayProof], ReadOnly):
    """A controller behind a delay and what is known about its loop.

    Parameters
    ----------
    request : DelayRequest
        The plant, the delay's interval and what was asked.
    status : {"feasible", "infeasible", "undecided"}
        The verdict on the LMIs. "feasible" by the eigenvalues of the blocks,
        "infeasible" by an exact proof only.
    K : (m, N) array or None
        ``[K_P K_D K_I]``, in ``u(t) = K x(t)``, which reaches the plant
        at the time t + delay.
    values : dict or None
        The unknown matrices by name, in the coordinates of the LMIs.
    margins : dict or None
        From a block's name to its smallest eigenvalue, after scaling
        its diagonal to one.
    infeasibility : DelayRefusal or ModesRefusal or FixedModeRefusal or None
        The exact proof that the LMIs have no solution, with status "infeasible"; a
        FixedModeRefusal is that of a mode which no gain moves.
    reason : str
        In words, why nothing is proven, and how slow a given gain's loop is in floats;
        of a feasible design: which of the gains K is.
    central : bool or None
        False, for these LMIs are a cone and have no analytic centre; None where K
        was given.
    source : Loop or None
        Where K is made of a law's gains: the loop of that law without the delay.
    """

    request: DelayRequest
    status: str
    K: np.ndarray | None = None
    values: dict | None = None
    margins: dict | None = None
    infeasibility: Any = None
    reason: str = ""
    central: bool | None = None
    source: Any = None

    @property
    def gains(self) -> dict[str, np.ndarray]:
        """As of a `Design`: of the law, where K is made of a law's gains."""
        return super().gains if self.source is None else self.source.design.gains

    @property
    def loop(self) -> Any:
        """As of a `Design`, without the delay."""
        return super().loop if self.source is None else self.source

    def controller(self, *measured: Any, T: float, **asked: Any) -> Any:
        """As of a `Design`, without the delay.

        Parameters
        ----------
        *measured
            The names of what is measured, of a design without a law.
        T : float
            Time between samples, in s.
        **asked
            What else a `Design` takes; ``delay`` is that from a sample to the actuator.
        """
        make = super().controller if self.source is None else None
        return (make or self.source.design.controller)(*measured, T=T, **asked)

    def statements(self) -> list[str]:
        """The demand on the loop in a sentence."""
        request = self.request
        low, high = request.tau - request.mu, request.tau + request.mu
        when = f"behind a delay of {request.tau:.4g} s"
        if request.mu:
            when = f"behind delays of {low:.4g} to {high:.4g} s, however they vary"
        decay = f"decays at least as e^(-{request.delta:.4g} t)"
        return [f"every motion {decay if request.delta else 'dies out'} {when}"]

    def its_law(self) -> tuple:
        """As of a `Design`."""
        return super().its_law() if self.source is None else self.source.its_law()

    @property
    def alpha(self) -> float | None:
        """The alpha that was given or found, in seconds."""
        return self.request.alpha

    def _prove(self, digits: int | None) -> DelayProof:
        return prove_delay(self.request, self.K, self.values, digits)

    @cached_property
    def advice(self) -> str:
        """Advice on a smaller request; empty if feasible.

        Found by solving again with less rate, variation or delay, in eighths.
        """
        if self.status == "feasible":
            return ""
        asked = self.request
        for names, words in (
            (("delta",), "a rate delta of {:.3g} 1/s"),
            (("mu",), "a variation mu of {:.3g} s"),
            (("tau", "mu"), "a delay tau of {:.3g} s with mu = {:.3g} s"),
        ):
            given = [getattr(asked, name) for name in names]

            def less(eighths, names=names, given=given):
                return dict(
                    zip(names, (float(f"{x * eighths / 8:.3g}") for x in given))
                )

            least = 1 if "tau" in names else 0
            if not given[0] or not solvable(asked.at(**less(least))):
                continue
            most = narrowed(
                lambda k, less=less: solvable(asked.at(**less(k))),
                *(least, 8),
                lambda good, bad: (good + bad) // 2,
            )[0]
            return f"Ask for less: {words.format(*less(most).values())} has a proof."
        return (
            "Nothing was found with a smaller delta, mu or tau alone: ask less "
            "of several, or see that the loop without delay can be made stable."
        )

    def _loops(self):
        K = self._gain()
        return [spectrum.delayed_loop(d, K) for d in self.request.vertices]

    def _roots(self, delay, count):
        loops = self._loops()
        return [spectrum.characteristic_roots(*each, delay, count) for each in loops]

    def _each(self, results):
        return self.request.plant.per_vertex(results)

    def poles(self, delay: float | None = None, count: int = 10) -> np.ndarray:
        """The rightmost characteristic roots for a constant delay, in rad/s.

        Parameters
        ----------
        delay : float, optional
            In seconds; tau without it.
        count : int
            How many; there are infinitely many.

        Returns
        -------
        (k,) array, or (vertices, k) for a Polytope
            As `roots` has them, cut to the shortest of the vertices.
        """
        delay = self.request.tau if delay is None else delay
        rows = self._roots(delay, count)
        shortest = min(map(len, rows))
        return self._each(np.array([row[:shortest] for row in rows]))

    def roots(self, delay: float, count: int = 10) -> np.ndarray:
        """The rightmost characteristic roots for a constant delay, ``count`` of them.

        A list of arrays, one per vertex, for a Polytope.
        """
        return self._each(self._roots(delay, count))

    def slowest_decay(self) -> tuple[float, float]:
        """The true decay rate over all constant delays of the interval.

        Returns
        -------
        rate, delay : float
            The smallest rate over the vertices, in 1/s (negative: the
            loop is unstable there), and the delay where it occurs.
        """
        low = self.request.tau - self.request.mu
        high = self.request.tau + self.request.mu
        return min(spectrum.slowest_decay(A, Ad, low, high) for A, Ad in self._loops())

    def stable_delays(self, longest: float) -> Any:
        """Intervals of constant delays up to ``longest`` that are stable.

        A list of them per vertex for a Polytope.
        """
        return self._each([stable_delays(A, Ad, longest) for A, Ad in self._loops()])

    def simulate(
        self,
        t: ArrayLike,
        delay: Any = None,
        r: ArrayLike | None = None,
        w: Sine | Step | None = None,
        x0: ArrayLike | None = None,
        history: Any = None,
    ) -> Any:
        """The `DelayedResponse` of the loop; a list of them, one a vertex.

        The arguments t, delay, r, w, x0 and history are those of `simulate_delay`.

        Without a delay it is the constant one, tau.
        """
        K = self._gain()
        delay = ConstantDelay(self.request.tau) if delay is None else delay
        return self._each(
            [
                simulate_delay(d, K, t, delay, r, w, x0, history)
                for d in self.request.vertices
            ]
        )
