"""What the blocks of a request are affine in, and the blocks for values of it."""

import re
from functools import cached_property

import numpy as np

from ..language import Unknown
from ..lmi.text import floats
from ..plants.descriptor import twins
from ..runtime.names import sane_name

RESERVED = re.compile(r"P|P \d+|V|Y|size for .*")  # names of a request's unknowns


class InUnknowns:
    """The part of a `Request` that knows its unknowns by name."""

    def unknowns(self, levels=()):
        """Unknowns P, Y (P alone if the gain is given), sizes, the own ones.

        With ``coupling="slack"`` P 1, P 2, ..., V, Y and so on. The own
        ones of a requirement are multiplied by its size.

        ``levels``: as in `leader`.
        """
        N = self.order
        names = dict.fromkeys(self.lyapunov)
        unknowns = [Unknown(name, N, symmetric=True) for name in names]
        if self.coupling == "slack":
            unknowns.append(Unknown("V", N, N))
        if self.gain is None:
            unknowns.append(Unknown("Y", self.plant.m, N))
        for r in self.followers(self.leader(levels)):
            unknowns.append(Unknown(r.size_name, 1))
        for r in self.demands:
            unknowns.extend(r.unknowns(self))
        names = [u.name for u in unknowns]
        if len(set(names)) < len(names):
            raise ValueError(f"two unknowns have one name: {names}")
        return unknowns

    def _check_unknowns(self):
        """A ValueError where a requirement's own unknown has a name that is taken."""
        for r in self.requirements:
            for name in (sane_name(u.name) for u in r.unknowns(self)):
                if RESERVED.fullmatch(name):
                    raise ValueError(
                        f"{r.words}: an unknown of its own is called {name!r}, which "
                        "is one of every problem: give it another name"
                    )

    @cached_property
    def lyapunov(self):
        """Names of the unknown Lyapunov matrices; equal vertices share one."""
        if self.coupling != "slack":
            return ("P",)
        return tuple(f"P {i + 1}" for i in twins(self.certain))

    def in_unknowns(self, frame, number=floats, levels=(), sizes=(), pairs=None):
        """`blocks` in the `unknowns`.

        ``frame``, ``number``, ``levels``: as in `blocks`; ``sizes``: numbers for some
        of the unknown sizes, by their names; ``pairs``: as in `blocks`. Returns the
        blocks by name, and what they are affine in.
        """
        unknowns = self.unknowns(levels)
        unknowns = [u for u in unknowns if u.name not in sizes]
        values = {u.name: u for u in unknowns} | dict(sizes)
        return self.blocks_at(values, number, frame, levels, pairs), unknowns

    def blocks_at(self, values, number=floats, frame=None, levels=(), pairs=None):
        """`blocks` for values of the `unknowns`, by name, in a frame.

        ``number`` brings data into an arithmetic; ``levels`` are the free
        bounds, and ``pairs`` some of the pairs of vertices.
        """
        P, Y, V, own = self.taken_apart(values, number, frame)
        return self.blocks(P, Y, number, frame, V, levels, own, pairs)

    def taken_apart(self, values, number=floats, frame=None):
        """P, Y, V and own, as `blocks` takes them, of ``values`` by name.

        ``number`` and ``frame`` are as in `blocks`.
        """
        names = self.lyapunov
        P = [values[name] for name in names]
        values = {name: x for name, x in values.items() if name not in names}
        for name, unit in () if frame is None else frame.own.items():
            if name in values:
                values[name] = values[name] * number(np.array(unit)).item()
        V = values.pop("V", None)
        if self.coupling != "slack":
            (P,) = P
        if self.gain is None:
            Y = values.pop("Y")
        else:
            K = number(self.gain)
            if frame is not None:
                scale = number(np.array(frame.scale)).item()
                K = K @ number(frame.T) / scale
            Y = K @ (P if V is None else V).T
        return P, Y, V, values
