"""Singular mass: acceleration feedback (Lemma 2.1)."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ..exact.definite import exact
from ..language import Unknown, he
from ..lmi.problem import LMIProblem, LMISolution
from ..lmi.text import LMIText
from ..plants.checks import is_word, positive
from ..plants.kinds import Prepared, SecondOrderPlant, checked_plant
from ..plants.response import Response
from ..plants.second_order import Polytope, SecondOrderSystem
from ..plants.signals import Sine, Step
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import ReadOnly
from ..runtime.threads import one_thread
from ..solver.loop import Unbounded
from .regularity import (
    MassRefusal,
    RegularityProof,
    mass_pairs,
    mass_refusal,
    prove_regular,
    refuse_regular,
    unreached,
)
from .result import Result

__all__ = ["Regularization", "prove_regular", "regularize"]


@dataclass(frozen=True, eq=False)
class Regularization(Result[RegularityProof], Prepared, ReadOnly):
    """An acceleration gain and what is known about M - B K_A.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or Uncertain
        The plant, or the polytope of plants.
    beta : float
        What was asked: a symmetric part above ``beta**2``.
    status : {"feasible", "infeasible", "undecided"}
        Decided by eigenvalues of the blocks or by multipliers that
        exclude a gain, never by a solver's word.
    K_A : (m, n) array or None
        Acceleration gain in u = K x + K_A e''.
    margins : dict or None
        From a block's name, "mass" or "mass 1", "mass 2", ..., to its
        smallest eigenvalue, after scaling its diagonal to one.
    central : bool or None
        Whether K_A is the analytic centre that `regularize` describes; None where
        it was to be something else.
    """

    plant: SecondOrderSystem | Polytope
    beta: float
    status: str
    K_A: np.ndarray | None = None
    margins: dict | None = None
    _multipliers: list | None = None
    central: bool | None = None

    noun = "regularization"

    def _matrices(self):
        return (("K_A", self.K_A),)

    @property
    def K(self) -> np.ndarray | None:
        """K_A: the gain that was designed."""
        return self.K_A

    def __repr__(self):
        if self.K_A is None:
            return f"<Regularization: {self.status}>"
        return f"<Regularization: {self.status}, smallest eigenvalue {self.bound:.3g}>"

    @property
    def regular(self) -> SecondOrderSystem | Polytope:
        """The plant with the mass M - B K_A."""
        gain = self._gain()
        vertices = [
            SecondOrderSystem(v.M - v.B @ gain, v.D, v.S, v.B, v.F, v.coordinates)
            for v in self.plant.vertices
        ]
        single = isinstance(self.plant, SecondOrderSystem)
        return vertices[0] if single else Polytope(vertices)

    def poles(self) -> np.ndarray:
        """Poles of the plant with the mass M - B K_A, in rad/s.

        Returns
        -------
        (2n,) array, or (vertices, 2n) for a Polytope
            One row for each vertex of a polytope.
        """
        regular = self.regular
        return regular.per_vertex(np.array([v.poles() for v in regular.vertices]))

    def simulate(
        self,
        t: ArrayLike,
        x0: ArrayLike | None = None,
        u: Sine | Step | None = None,
        w: Sine | Step | None = None,
    ) -> Response | list[Response]:
        """Simulate `regular`: the plant with K_A and no other controller.

        The arguments t, x0 and w are those of `SecondOrderSystem.simulate`.

        As `SecondOrderSystem.simulate`; u is what joins K_A z''.
        """
        return self.regular.simulate(t, x0, u, w)

    @property
    def bound(self) -> float:
        """Smallest eigenvalue of the symmetric part of M - B K_A.

        Over the vertices, and so over the whole polytope: it is a
        concave function of M and B.
        """
        gain = self._gain()
        masses = (he(v.M - v.B @ gain) / 2 for v in self.plant.vertices)
        return float(min(np.linalg.eigvalsh(mass)[0] for mass in masses))

    def applied(
        self, K_A: ArrayLike | None = None
    ) -> tuple[SecondOrderSystem | Polytope, np.ndarray]:
        """The plant and K_A, for a design function; refuses another K_A."""
        if K_A is not None:
            raise ValueError(
                "K_A is given, and the regularization has its own: give the "
                "plant instead, or leave K_A out"
            )
        return self.plant, self._gain()

    def _prove(self, digits: int | None) -> RegularityProof:
        # for a fixed K_A (2.12) is affine in M and B: the vertices prove it for all
        return prove_regular(self.plant, self.K_A, self.beta, digits)

    @cached_property
    def infeasibility(self) -> MassRefusal | None:
        """The exact proof that there is none, where one was found; else None.

        Its multipliers Z_k, (n, n) and positive semidefinite, satisfy
        sum Z_k B_k = 0 and value = sum <M_k - beta^2 I, Z_k> <= 0; a
        gain would make sum <M_k - B_k K_A - beta^2 I, Z_k> positive.
        """
        if self.status == "feasible":
            return None
        name, v, mass = unreached(self.plant)
        beta2 = exact(self.beta) ** 2
        if v is not None and mass <= beta2:
            return mass_refusal(self.plant, self.beta, {name: np.outer(v, v)})
        if self._multipliers is None:
            return None
        return refuse_regular(self.plant, self.beta, self._multipliers)

    @cached_property
    def advice(self) -> str:
        """Advice on a change; empty if feasible."""
        if self.status == "feasible":
            return ""
        _, v, mass = unreached(self.plant)
        if v is not None and mass <= exact(self.beta) ** 2:
            entries = ", ".join(f"{float(e):.4g}" for e in v)
            why = (
                f"in the direction v = [{entries}], which no input reaches, "
                f"the mass v' M v / v' v is {float(mass):.4g}"
            )
            if mass > 0:
                limit = float(mass) ** 0.5
                return f"Ask for a beta below {limit:.4g}: {why}."
            return (
                f"No beta helps: {why}, not positive. The lemma is only "
                "sufficient: multiply the equation of motion from the left "
                "by (M - B K0)', with a K0 that makes M - B K0 regular, and "
                "try again."
            )
        if regularize(self.plant, self.beta / 1e3).status == "feasible":
            return "Ask for a smaller beta."
        if self.status == "undecided":
            return (
                "Nothing was found, and nothing proves that there is no gain: "
                "split the polytope, or ask for another beta."
            )
        return (
            "No common K_A serves all vertices, though each has its own. "
            "Look for a plant between them where [M B] lacks full row rank, "
            "and split the polytope."
        )


@one_thread
def regularize(
    plant: SecondOrderPlant,
    beta: float = 0.1,
    *,
    choose: Literal["centre", "least norm"] = "centre",
) -> Regularization:
    r"""Find an acceleration gain that makes the mass regular.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or Uncertain
        The plant, or the polytope of plants.
    beta : float
        The smallest eigenvalue of the symmetric part of M - B K_A must
        exceed ``beta**2``, at every vertex.
    choose : {"centre", "least norm"}
        Which of the many gains. ``"centre"``: the analytic centre of
        (2.12) and of a bound \|M - B K_A\| < rho on the mass, with rho
        twice the norm of M (or twice the least that (2.12) admits, if
        that is larger). Where M is zero at every vertex nothing but beta
        has the unit of a mass: M - B K_A is then of the size of beta**2,
        for one plant with a square B between one and two of it.
        ``"least norm"``: the
        smallest Frobenius norm of K_A, for beta**2 raised by 1 % (less
        where that is infeasible); zero where the plant needs no gain.

    Returns
    -------
    Regularization
        The gain K_A, and what is known of the regular plant.

    Raises
    ------
    ValueError
        On bad input; an impossible request is no error, it comes back
        with status "infeasible".

    Notes
    -----
    Source: thesis, Lemma 2.1 (2.12). Neither choice depends on the unit
    of mass (with beta**2 in that unit), nor on vertices that differ in
    D, S, F only; the centre doesn't depend on the units of the inputs.
    Both do depend on the units of z where these differ among the
    coordinates, as the identity in (2.12) does.

    Examples
    --------
    >>> plant = SecondOrderSystem(
    ...     M=[[2, 0], [0, 0]], D=[[1, 0], [0, 1]], S=[[2, -1], [-1, 1]],
    ...     B=[[0], [1]])
    >>> regularized = regularize(plant, beta=0.1)
    >>> regularized.status, regularized.K_A.round(2) + 0, regularized.certify().proven
    ('feasible', array([[ 0.  , -2.31]]), True)
    """
    from .scaled_mass import ScaledMass

    around = checked_plant(plant, SecondOrderPlant)
    beta = positive("beta", beta)
    if not is_word(choose, ("centre", "least norm")):
        raise ValueError(f'choose must be "centre" or "least norm", got {choose!r}')
    refused = Regularization(around, beta, "infeasible")
    if refused.infeasibility is not None:
        return refused
    scaled = ScaledMass(around, beta)
    first = scaled.problem().find()
    if first.values is None:
        refused = replace(refused, status="undecided", _multipliers=first.multipliers)
        if refused.infeasibility is not None:
            return replace(refused, status="infeasible")
        return refused
    central = True if choose == "centre" else None
    pick = scaled.centre if central else scaled.least_norm
    try:
        K_A = pick(first.values)
    except Unbounded:  # a degenerate set: keep the feasible point
        K_A, central = scaled.gain(first.values["L"], scaled.basis), False
    K_A = np.where(np.abs(K_A) > 1e-9 * np.abs(K_A).max(), K_A, 0.0)
    point = LMISolution(_lemma(around, beta), {"K_A": K_A})
    found = Regularization(around, beta, point.status, K_A, point.margins)
    return replace(found, central=central)


def _lemma(plant, beta):
    """(2.12) at the vertices that differ in M or B, in the plant's units."""

    from ..theorems.regularization import regular_mass

    def write(values, number):
        return {
            name: regular_mass(number(M), number(B), values["K_A"], number(beta))
            for name, (M, B) in mass_pairs(plant).items()
        }

    return LMIProblem(LMIText(write, [Unknown("K_A", plant.m, plant.n)]))
