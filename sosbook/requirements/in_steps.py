"""Requirements of a plant of discrete time, whose loops are those of the change."""

from dataclasses import fields, replace
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import put
from .base import Requirement
from .lmi_region import LMIRegion


class InSteps(LMIRegion):
    """A region ``of_z``, of the poles z of a plant of discrete time with the tick
    ``step``, as the region of s = (z - 1) / step. There z is 1 + step s, and alpha
    becomes (alpha + beta + beta') / step. Files have the region of z.
    """

    owns_its_kind = True

    def __init__(self, of_z: LMIRegion, step: float) -> None:
        put(self, of_z=of_z, step=step)
        alpha, beta = (x.astype(float) for x in self.pole_matrices())
        put(self, alpha=alpha, beta=beta, name=of_z.name, text=of_z.text, parts=(self,))
        put(self, parameter=of_z.parameter, bound=of_z.bound, rank=of_z.rank)
        put(self, _form=of_z._form, _sizes=of_z._sizes)

    def __repr__(self):
        return f"{self.of_z!r}.stepped({self.step!r})"

    def stepped(self, step: float | None) -> "LMIRegion":
        return self.of_z.stepped(step)

    def named(self, name: str) -> "LMIRegion":
        return self.of_z.named(name).stepped(self.step)

    def with_bound(self, bound: float) -> "Requirement":
        return self.of_z.with_bound(bound).stepped(self.step)

    def matrices(self, number: Any) -> tuple:
        alpha, beta = self.of_z.matrices(number)
        return (alpha + beta + beta.T) / number(np.array(self.step)).item(), beta

    def pole_matrices(self) -> tuple:
        return self.matrices(exact)

    @property
    def implies_stability(self) -> bool:
        """True if it is a disk inside the unit disk."""
        sizes = self._sizes
        if self._form != "disk":
            return False
        return exact(sizes["rho"]) + abs(exact(sizes["centre"])) <= 1

    def distance(self, poles: ArrayLike) -> np.ndarray:
        return self.step * super().distance(poles)

    def contradicts(self, other: Any) -> bool:
        return self.of_z.contradicts(getattr(other, "of_z", other))

    def bound_of(self, poles: np.ndarray) -> float:
        return self.of_z.bound_of(1 + self.step * poles)

    def data(self) -> dict:
        return self.of_z.data()

    def claim(self) -> str:
        from ..exact.checker.regions import of_z

        return of_z(self.of_z.claim())


def with_step(r: Requirement, step: float | None) -> Requirement:
    """A requirement ``r`` that has a field for it with the tick ``step``."""
    if "step" in {f.name for f in fields(r)}:  # type: ignore[arg-type]
        return replace(r, step=step)  # type: ignore[call-arg, type-var]
    raise ValueError(
        f"{r.words} is for plants of continuous time: of one with dt regions of the "
        "poles, norms and a quadratic cost are proven"
    )


def timed(r: Requirement, step: float | None) -> Requirement:
    """The requirement ``r`` of a plant with this tick, ``step``, or of continuous time;
    it must not be that of another tick.
    """
    if r.step == step:
        return r
    if r.step is not None:
        raise ValueError(
            f"{r.words} is that of a request for a plant with dt={r.step!r}, and this "
            "plant has another: make the requirement again"
        )
    return r.stepped(step)
