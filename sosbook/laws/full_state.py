"""The law of the thesis: all of z and z' measured, some errors integrated."""

from dataclasses import dataclass
from typing import Any

from ..runtime.read_only import ReadOnly


@dataclass(frozen=True, eq=False)
class FullState(ReadOnly):
    """u = K [z; z'; x3], the law of a design without a ``law``: its LMIs are convex.

    Parameters
    ----------
    U : (a, n) array_like, optional
        Which displacement errors are integrated, as in `design_pid`.

    Examples
    --------
    >>> import sosbook as sos
    >>> plant = sos.SecondOrderSystem(1, 1, 1, 1)
    >>> sos.design_pid(plant, law=FullState([[1]])).K.shape
    (1, 3)
    """

    U: Any = None
