r"""A plant with its sensors, each of which may be late.

What a sensor sees is :math:`s = C x + C_a \dot x + D_u u + N w`: a place, a speed, an
acceleration, a force. With :math:`\dot x` or u in it s jumps with u, and no sensor
does: it says y, with :math:`\lambda \dot y = s - y`. So y is a state of a larger plant,

.. math::

    \begin{bmatrix} E & 0 \\ -C_a & \lambda \end{bmatrix}
    \begin{bmatrix} \dot x \\ \dot y \end{bmatrix} =
    \begin{bmatrix} A & 0 \\ C & -1 \end{bmatrix} \begin{bmatrix} x \\ y \end{bmatrix} +
    \begin{bmatrix} B \\ D_u \end{bmatrix} u +
    \begin{bmatrix} B_w \\ N \end{bmatrix} w ,

affine in the matrices of the plant. A family stays one of the same parameters, nothing
is divided by an uncertain mass, its E is regular where the plant's is, and the loop is
well posed whatever the gain. All that is said of plants is said of it.

Without the lag a static gain of an acceleration is another loop on a computer: m a =
k a + f has a = f/(m - k), but a(k) = (k a(k-1) + f)/m diverges for k = -2 m however
short the tick is.
"""

from dataclasses import dataclass, replace
from functools import partial, reduce
from operator import and_

import numpy as np

from ..exact.rational import exact
from ..runtime.read_only import ReadOnly
from .descriptor import Descriptor, descriptors
from .descriptor_system import DescriptorSystem
from .gain import input_names, signals
from .joined import joined_family
from .outputs import Output
from .reduction import Reduction

ORDER = "C", "Ca", "Du", "Dw"


@dataclass(frozen=True, eq=False)
class Readings(ReadOnly):
    """The readings of some sensors: ``C`` x + ``Ca`` x' + ``Du`` u + ``Dw`` w, row by
    row, of a plant with so many ``n`` coordinates, zero where it has none; ``names`` of
    them, and those that were ``given``, "" for the others; ``first``: how many aren't
    rates.
    """

    C: np.ndarray
    Ca: np.ndarray
    Du: np.ndarray
    Dw: np.ndarray
    n: int
    names: tuple
    given: tuple
    first: int

    @classmethod
    def of(cls, plant, sensors, rates=None):
        """Those of a ``plant`` that two `Output`s weigh, ``sensors`` and ``rates``."""
        first_order = isinstance(plant, DescriptorSystem)
        n = 0 if first_order else plant.n
        N, m, p = plant.order if first_order else 2 * n, plant.m, plant.p
        ends = zip(("position", "velocity", "integral"), (0, n, 2 * n), (n, n, 0))
        places = {name: slice(k, k + size) for name, k, size in ends} if n else {}
        rows, named, first = np.zeros((0, 2 * N + m + p)), [], 0
        for output in (sensors, rates):
            for part in () if output is None else output.parts:
                if first_order and part.velocity is not None:
                    raise ValueError(
                        "velocity: a DescriptorSystem has no velocities; give "
                        "position= rows on its state x"
                    )
                part = _on_state(part) if first_order else part
                found = part.rows(places, N, m, p)
                q = len(found["C"])
                for x, width in (("Ca", N), ("Du", m), ("Dw", p)):
                    found[x] = np.zeros((q, width)) if found[x] is None else found[x]
                rows = np.vstack([rows, np.hstack([found[x] for x in ORDER])])
                many = "{}{}" if q > 1 and part.name else "{}"
                named += [many.format(part.name, k + 1) for k in range(q)]
            first = len(rows) if output is sensors else first
        states = signals(plant)
        words = *states, *(f"{x}'" for x in states), *input_names(m)
        names = [x or row_words(row, words) for x, row in zip(named, rows)]
        for x, name, row in zip(named, names, rows):
            if not x and (rows == row).all(axis=1).sum() > 1:
                raise ValueError(f"two sensors measure {name}: leave one out")
            if x and names.count(x) > 1:
                raise ValueError(f"two sensors are called {x}: give each its own name")
        parts = np.split(rows, [N, 2 * N, 2 * N + m], axis=1)
        return cls(*parts, n, tuple(names), tuple(named), first)

    def __len__(self):
        return len(self.names)

    @property
    def late(self):
        """Which of them see x' or u, so that they jump with u."""
        return self.Ca.any(axis=1) | self.Du.any(axis=1)

    @property
    def places(self):
        """Which of them are of places alone, for which there are set points."""
        n = self.n or self.C.shape[1]
        return ~self.late & ~self.C[:, n:].any(axis=1)

    def outputs(self):
        """The two outputs again, or None: on the states of the plant to which the late
        ones are joined.
        """
        late, (q, N) = self.late, self.C.shape
        rows = np.hstack([self.C, np.zeros((q, late.sum()))])
        rows[late] = np.eye(rows.shape[1])[N:]
        each = [
            Output(state=row, name="" if behind else name)
            if behind or not w.any()
            else Output(state=row, disturbance=w, name=name)
            for row, w, name, behind in zip(rows, self.Dw, self.given, late)
        ]
        parts = each[: self.first], each[self.first :]
        return [reduce(and_, some) if some else None for some in parts]


def _on_state(part):
    """A part of an `Output` whose positions are rows on the state."""
    own = part.given
    if "position" in own:
        own["state"] = own.pop("position")
    return Output(**own, name=part.name)


@dataclass(frozen=True, eq=False)
class Sensed(ReadOnly):
    """The plant as it was before its sensors were joined: ``rows``, (c, N), of what the
    late ones see at rest, the last states; ``n``: coordinates of the plant that it was.
    """

    rows: np.ndarray
    n: int
    bare: object

    @property
    def rest(self):
        """The matrix from x(0) to [x(0); y(0)]: each sensor has long stood at what it
        sees while nothing moves.
        """
        return np.vstack([np.eye(self.rows.shape[1]), self.rows])

    def whole(self, x0):
        """x(0) with the sensors at rest, if ``x0`` is without them."""
        known = x0 is None or np.shape(x0)[-1:] != self.rest.shape[1:]
        return x0 if known else np.asarray(x0, float) @ self.rest.T

    def asked(self, r):
        """A requirement ``r`` of the plant that it was, of what it became."""
        N = self.rows.shape[1]
        if r.outputs is not None:
            r = replace(r, outputs=in_states(r.outputs, N, self.n))
        joined = _Joined(self.rows, range(len(self.rows)), exact(self.rest))
        return r.joined(joined)


@dataclass(frozen=True)
class _Joined:
    """The matrices that `Requirement.joined` takes."""

    rows: np.ndarray
    states: range
    rest: np.ndarray


def plant_of(plant, K):
    """The ``plant``, with the sensors of a `Controller` K if it is that of K."""
    own = getattr(K, "plant", None)
    known = getattr(own, "sensed", None)
    return plant if known is None or known.bare != plant else own


def asked_of(plant, r):
    """A requirement ``r`` of what a ``plant`` was before sensors were joined, of it."""
    known = getattr(plant, "sensed", None)
    return r if known is None else known.asked(r)


def in_states(output, N, n):
    """An ``output`` of a plant of n coordinates with its rows on all N states."""
    if not n:
        return output
    parts = []
    for part in output.parts:
        own, at = part.given, dict(position=("state", 0), velocity=("state", n))
        at["acceleration"] = "rate", n
        for key in own.keys() & at.keys():
            name, first = at[key]
            x = own.pop(key)
            x = x * np.eye(n) if np.ndim(x) == 0 else x
            wide = np.zeros((len(x), N))
            wide[:, first : first + n] = x
            if np.ndim(own.get(name)) == 0 and name in own:
                own[name] = own[name] * np.eye(N)
            own[name] = own.get(name, 0.0) + wide
        parts.append(Output(**own, name=part.name))
    return reduce(and_, parts)


def sensed(plant, seen, lag):
    """The ``plant`` with the late ones of the `Readings` ``seen`` as states, whose time
    constant is ``lag`` s: a `DescriptorSystem`, a family if the plant is one.
    """
    late = seen.late
    parts = (exact(x[late]) for x in (seen.C, seen.Ca, seen.Du, seen.Dw))
    function = partial(_with_lags, *parts, exact(lag))
    names = (*signals(plant), *np.array(seen.names, object)[late])
    known = dict(sensed=Sensed(seen.C[late], seen.n, plant), states=names)
    known |= {"dt": plant.dt} if isinstance(plant, DescriptorSystem) else {}
    if plant.family is not None:
        return joined_family(plant.family, function, **known).polytope()
    vertices = plant.vertices
    if not isinstance(plant, DescriptorSystem):
        vertices = descriptors(plant)
    made = [kept(function(d.map(exact))) for d in vertices]
    part = Reduction.in_states(plant, len(made[0].E))
    return DescriptorSystem.of(made, part, **known)


def kept(d):
    """A plant ``d`` in rationals, a `Descriptor`, as one of floats that knows them."""
    floats = d.map(lambda x: x.astype(float))
    vars(floats)["_exactly"] = d
    return floats


def corners(a, b, c, d):
    """[a, b; c, d]."""
    return np.vstack([np.hstack([a, b]), np.hstack([c, d])])


def _with_lags(C, Ca, Du, Dw, lag, d):
    """The plant ``d``, in rationals, with sensors that are late."""
    c, N = len(C), len(d.E)
    none, one = exact(np.zeros((N, c))), exact(np.eye(c))

    def wide(x):
        return None if x is None else np.hstack([x, exact(np.zeros((len(x), c)))])

    return Descriptor(
        corners(d.E, none, -Ca, lag * one),
        corners(d.A, none, C, -one),
        np.vstack([d.Bu, Du]),
        np.vstack([d.Bw, Dw]),
        *(wide(d.C), d.Du, d.Dw, wide(d.Ca)),
    )


def row_words(row, names, number="{:g}".format):
    """A mixture of signals in words, "z1 - 2 z2": a ``row`` of shares of ``names``,
    that ``number`` writes.
    """
    text = ""
    for share, name in zip(row, names):
        if share:
            size = "" if abs(share) == 1 else f"{number(abs(share))} "
            sign = "-" if share < 0 else "+"
            sign = f" {sign} " if text else sign.strip("+")
            text += f"{sign}{size}{name}"
    return text
