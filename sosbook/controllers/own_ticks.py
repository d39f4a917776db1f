r"""A controller of a plant of discrete time: its program is a law of that plant.

The program's tick is the plant's. With the memory s, the readings y = R x + N w and the
plant's clock dt its two lines

.. math::

    s(k + 1) = A s(k) + B y(k), \qquad u(k) = C s(k) + D y(k)

are dt v = (A - I) s + B y with the change v = (s(k + 1) - s(k)) / dt, and u = [D C]
[y; s]: a law whose memory is given and whose gain is [D C]. So the theorems of a gain
that is known prove the program's loop in z as they prove any other, and as A - I, B, C,
D, R and N are decimals in the file no digit is rounded between the proof and the
program.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..laws import Law
from ..laws.base import Parts
from ..laws.structure import Structure, placed
from ..requirements.lmi_region import LMIRegion
from ..synthesis.pid import analyse_pid
from ..synthesis.search import Search


@dataclass(frozen=True, eq=False)
class OfProgram(Law):
    """The law that the program of a ``controller`` is at its plant's own ticks."""

    controller: Any

    def on(self, plant: Any) -> tuple:
        return plant, self

    def parts(self, plant: Any) -> Parts:
        c = self.controller
        (l, q), one = c.B.shape, exact(np.eye(len(c.A)))
        A, B, rows, noise = map(exact, (c.A, c.B, c.readings.rows, c.readings.noise))
        take, stay = exact(np.eye(q + l, q)), exact(np.eye(q + l, l, -q))
        sensors = tuple(s.name for s in c.readings.signals)
        states = tuple(f"memory {k}" for k in range(1, l + 1))
        own = exact(plant.dt) * one, A - one, B, take, stay
        return Parts(rows, noise, *own, 0, sensors, states, (*sensors, *states))

    def structure(self, plant: Any) -> Structure:
        c = self.controller
        shape = len(c.C), c.B.shape[1] + len(c.A)
        return placed(shape, {"K": ((0, shape[0]), (0, shape[1]))}, None, {})

    def words(self, plant: Any) -> str:
        return "the program as it is"


def proven(c, asked):
    """The proof of a controller c's loop at its plant's own ticks; ``asked``: what
    `Questions.certify` is asked: a ``norm``, a ``rate``, seconds.
    """
    if strange := sorted(asked.keys() - {"norm", "rate", "time_limit"}):
        raise ValueError(
            f"{strange[0]} is of a clock that runs between the ticks, and the plant is "
            f"one of discrete time: its loop is proven at {c.T:g} s alone, with norm=, "
            "rate= and time_limit="
        )
    rate, norm, seconds = map(asked.get, ("rate", "norm", "time_limit"))
    design = analyse_pid(
        c.plant,
        np.hstack([c.D, c.C]),
        law=OfProgram(c),
        region=None if rate in (None, 1) else LMIRegion.disk(rate),
        requirements=() if norm is None else (norm,),
        search=Search() if seconds is None else Search(time_limit=seconds),
    )
    return design.certify(time_limit=seconds)
