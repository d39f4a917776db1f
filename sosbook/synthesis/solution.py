"""The solution of a request's LMIs: a point in the plant's units, or a refusal."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..runtime.read_only import ReadOnly
from .request import Request
from .scaling import Frame

if TYPE_CHECKING:
    from ..exact.refusal import Refusal


@dataclass(frozen=True, eq=False)
class Solution(ReadOnly):
    """``request``, ``status``, ``K``, ``P``, ``Y``, ``V``, ``margins``, ``frame``,
    ``multipliers``, ``own``, ``minimized``, ``reason``, ``infeasibility``, ``central``,
    ``parts``, ``searched``: as in `Design`, which explains them.
    """

    request: Request
    status: str
    K: np.ndarray | None = None
    P: np.ndarray | None = None
    Y: np.ndarray | None = None
    V: np.ndarray | None = None
    margins: dict | None = None
    frame: Frame | None = None
    multipliers: list | None = None
    own: dict | None = None
    minimized: tuple = ()
    reason: str = ""
    infeasibility: "Refusal | None" = None
    central: bool | None = None
    parts: tuple = ()
    searched: Any = None

    @property
    def asked(self) -> Request:
        """The request with what was to be minimised, numbers for the bounds."""
        both = (*self.request.requirements, *self.minimized)
        return replace(self.request, requirements=both)

    @property
    def condition(self) -> str:
        """The condition of "infeasible": "for mu = 1"; else empty."""
        if self.status == "infeasible" and not self.minimized:
            return getattr(self.infeasibility, "condition", "")
        return self.asked.sizes.condition
