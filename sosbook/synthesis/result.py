"""The common base of all design results."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from ..runtime.array_like import ArrayLike

if TYPE_CHECKING:
    from ..exact.proof import Unproven

Proven = TypeVar("Proven")


class Result(ABC, Generic[Proven]):
    """The protocol of `Design`, `DelayDesign` and the other results.

    Where something is said of each vertex the rule of shapes is: for one
    plant the thing itself, for a polytope (of one vertex too) one for
    each vertex. Arrays gain a first axis, other things come in a list:
    ``poles()`` is (N,) or (vertices, N), ``simulate(t)`` is a response
    or a list of them.

    Attributes
    ----------
    status : {"feasible", "infeasible", "undecided"}
    K : array or None
        The gain that was designed.
    margins : dict or None
        From a name to a number that is positive where what it names
        holds; None without a gain.
    central : bool or None
        Whether K is that of the analytic centre of all that was asked, which
        is unique; None where K isn't chosen by a centre.
    """

    noun = "design"  # what messages call it
    pole_axis = "poles, rad/s"  # below the picture of its poles
    central: bool | None = None
    margins: Any = None

    def certify(
        self,
        digits: int | None = None,
        time_limit: float | None = None,
        progress: bool = False,
    ) -> "Proven | Unproven":
        """Prove what was asked in exact arithmetic.

        Floats, the plant's too, are read as decimals: 0.1 is 1/10. The exponentials
        of a delay are rounded on the side on which the theorem stays true. A long proof
        that was just made is decided by floats with bounds of all their errors, which
        say less than rationals and nothing else; its ``verify`` and ``save`` decide in
        rationals, as every reader of its file does.

        Parameters
        ----------
        digits : int, optional
            The gain is rounded to so many significant digits first: the proof is
            about the gain as it is printed. Without it 6, 8, 10, 12 and 17 are
            tried, and the proof says which. A gain that was given isn't rounded.
        time_limit : float, optional
            Seconds after which nothing is proven, and the answer says so.
        progress : bool
            Show a bar of the seconds that have passed.

        Returns
        -------
        Proof or Unproven
            What was proven, and what failed. Of its own ``K``, the rounded one: use
            that one where a gain leaves the program. ``save`` makes it a file. Where
            there is no design the answer is why, in words; the proof that there is
            none is `infeasibility`.
        """
        if self.margins is None:
            return self._nothing_to_prove()
        from ..exact.proof import proven_within

        return proven_within(time_limit, lambda: self._prove(digits), progress)

    def _prove(self, digits: int | None) -> Proven:
        """The proof of what was found, with so many digits: see `certify`."""
        raise NotImplementedError

    @property
    @abstractmethod
    def infeasibility(self) -> Any:
        """The exact proof that nothing exists, where one was found."""

    @property
    @abstractmethod
    def advice(self) -> str:
        """Advice on a change, in words; empty if feasible."""

    @abstractmethod
    def poles(self) -> np.ndarray:
        """Poles of the loop: (N,), or (vertices, N) for a polytope."""

    @abstractmethod
    def simulate(self, t: ArrayLike) -> Any:
        """The loop's response at the times t; a list for a polytope."""

    def __repr__(self):
        name = type(self).__name__
        if not self.margins:
            return f"<{name}: {self.status}>"
        worst = min(self.margins, key=self.margins.get)
        return (
            f"<{name}: {self.status}, smallest margin "
            f"{self.margins[worst]:.2g} ({worst})>"
        )

    def _repr_html_(self):
        """The notebook's card: verdict, poles, gains, margins, advice."""
        from ..display.card import card

        has_gain = self.K is not None and self.margins is not None
        return card(
            type(self).__name__,
            self.status,
            np.atleast_2d(self.poles()) if has_gain else (),
            self._region(),
            self._matrices() if has_gain else (),
            self.margins,
            self._next(),
            self.pole_axis,
        )

    def _region(self):
        """Where the poles must lie; None where nothing is asked."""

    def _matrices(self):
        """(name, matrix) of what was designed."""
        return (("K", self.K),)

    def _next(self):
        """Sentences on the next step."""
        more = "certify() proves it in exact arithmetic, simulate(t) shows it."
        more = more if self.status == "feasible" else self.advice
        return getattr(self, "reason", ""), more

    def _nothing_to_prove(self):
        """The answer of `certify` where there is no design."""
        from ..exact.proof import NOTHING, Unproven

        if getattr(self, "reason", "") == NOTHING:
            return Unproven(NOTHING)
        proof = self.infeasibility if self.status == "infeasible" else None
        there = " That is proven: see its infeasibility." if proof else ""
        words = (
            f"the {self.noun} is {self.status}. {getattr(self, 'reason', '')}{there}"
        )
        return Unproven(f"{words.strip()} Its advice says what to change.")

    def _gain(self):
        if self.K is None:
            raise ValueError(
                f"the {self.noun} is {self.status}: there is no gain to take; its "
                f"reason says why, see its advice, too. {getattr(self, 'reason', '')}"
            )
        return self.K
