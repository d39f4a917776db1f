"""Outputs: rows on z, z', z'', x3, u and w."""

from dataclasses import dataclass, replace
from functools import reduce
from operator import and_

import numpy as np
from scipy.linalg import block_diag

from ..exact.checker.outputs import SIGNALS, in_words
from ..exact.rational import decimal, exact, read_array, read_number
from ..runtime.array_like import ArrayLike
from ..runtime.names import sane_name
from ..runtime.read_only import ReadOnly
from .checks import finite, matrix
from .descriptor import Descriptor

COUNTED = {
    "integral": "integrals, the rows of U",
    "input": "inputs",
    "disturbance": "disturbances",
    "state": "states",
    "rate": "states",
}
MEANT = {"position": "state", "velocity": "state", "acceleration": "rate"}


@dataclass(frozen=True, eq=False, repr=False)
class Output(ReadOnly):
    """Rows on what a plant does: the y that a requirement bounds.

    Each argument holds rows, as many as the others, and what they give is added up:
    ``Output(position=[[1, -1]], velocity=[[0.1, 0]])`` is z1 - z2 + 0.1 z1'. A number
    stands for that multiple of the identity: ``input=0.01`` is 0.01 u. ``first &
    second`` has the rows of both.

    Parameters
    ----------
    position, velocity, acceleration : (q, n) array_like or number, optional
        Rows on z, z' and z'' of a plant of second order. The acceleration needs no
        division by an uncertain mass where each plant has a Lyapunov matrix of its
        own: ``coupling="slack"``, and "multipliers" for a known gain.
    integral : (q, a) array_like or number, optional
        Rows on x3, the integrals of U z.
    input : (q, m) array_like or number, optional
        Rows on u = K x. Where there is a K_A, its share K_A z'' isn't in it: give it
        as an acceleration.
    disturbance : (q, p) array_like or number, optional
        Rows on w.
    state, rate : (q, N) array_like or number, optional
        Rows on all states x, and on x'; the only ones for a `DescriptorSystem`, which
        has no z.
    name : str
        What it is called in words.

    Raises
    ------
    ValueError
        If it has no row, or rows of different counts.

    Examples
    --------
    >>> ride = Output(acceleration=[[1, 0]], name="comfort")
    >>> ride & Output(position=[[20, -20]]) & Output(input=1e-3)
    <Output: comfort = [[1, 0]] z''; [[20, -20]] z; 0.001 u>
    """

    position: np.ndarray | float | None = None
    velocity: np.ndarray | float | None = None
    acceleration: np.ndarray | float | None = None
    integral: np.ndarray | float | None = None
    input: np.ndarray | float | None = None
    disturbance: np.ndarray | float | None = None
    state: np.ndarray | float | None = None
    rate: np.ndarray | float | None = None
    name: str = ""

    def __init__(
        self,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        integral: ArrayLike | None = None,
        input: ArrayLike | None = None,
        disturbance: ArrayLike | None = None,
        *,
        state: ArrayLike | None = None,
        rate: ArrayLike | None = None,
        name: str = "",
    ) -> None:
        """Check the rows; all parts have equally many."""
        given, put = locals(), object.__setattr__
        rows = {}
        for key in SIGNALS:
            x = given[key]
            if x is not None:
                x = finite(key, x) if np.ndim(x) == 0 else _rows(key, x)
                rows[key] = len(x) if np.ndim(x) else None
            put(self, key, x)
        if not rows:
            raise ValueError("an Output has no rows: give position=, input=, ...")
        several = {k: q for k, q in rows.items() if q is not None}
        if len(set(several.values())) > 1:
            words = ", ".join(f"{k} has {q}" for k, q in several.items())
            raise ValueError(
                f"the rows of an Output are added up, so there must be as many of "
                f"each: {words}. Stack outputs by &"
            )
        put(self, "name", sane_name(name) if name else "")

    def __and__(self, other: "Output") -> "Output":
        if not isinstance(other, Output):
            return NotImplemented
        both = object.__new__(Output)
        for key, value in (dict.fromkeys(SIGNALS) | {"name": ""}).items():
            object.__setattr__(both, key, value)
        object.__setattr__(both, "_joined", self.parts + other.parts)
        return both

    @property
    def parts(self) -> "tuple[Output, ...]":
        """Those that were joined; itself, if none were."""
        return vars(self).get("_joined") or (self,)

    def __repr__(self):
        return f"<Output: {self.words}>"

    def __eq__(self, other):
        if not isinstance(other, Output):
            return NotImplemented
        return self.data() == other.data()

    def __hash__(self):
        return hash(self.words)

    @property
    def given(self) -> dict:
        """Its rows, or numbers, by argument."""
        return {k: getattr(self, k) for k in SIGNALS if getattr(self, k) is not None}

    @property
    def words(self) -> str:
        """The output in one line, without the noise of a float's last digits.

        Examples
        --------
        >>> Output(position=[[3 * 0.068, 0.1]]).words
        '[[0.204, 0.1]] z'
        """
        said = self._said(lambda x: decimal(float(f"{x:.15g}")))
        return "; ".join(map(in_words, said))

    def rows(self, places: dict, order: int, m: int, p: int) -> dict:
        """C, C_a, D_u and D_w of the output in a plant with these coordinates.

        Parameters
        ----------
        places : dict
            Which states are "position", "velocity" and "integral": slices. Those that
            the plant hasn't are missing.
        order, m, p : int
            The numbers of its states x, inputs u and disturbances w.

        Returns
        -------
        dict
            "C" and "Ca" (q, order), "Du" (q, m) and "Dw" (q, p), arrays of floats;
            None of the last three where the output has none.

        Raises
        ------
        ValueError
            If rows have another width than the plant, or it has no such states.

        Examples
        --------
        >>> places = {"position": slice(0, 1), "velocity": slice(1, 2)}
        >>> found = Output(position=2, acceleration=[[3]]).rows(places, 2, 1, 0)
        >>> found["C"].tolist(), found["Ca"].tolist(), found["Du"]
        ([[2.0, 0.0]], [[0.0, 3.0]], None)
        """
        whole = slice(0, order)
        where = {  # the matrix, its width, and which of its columns
            **{k: ("C", order, at) for k, at in places.items()},
            "state": ("C", order, whole),
            "rate": ("Ca", order, whole),
            "input": ("Du", m, slice(0, m)),
            "disturbance": ("Dw", p, slice(0, p)),
        }
        if "velocity" in places:
            where["acceleration"] = ("Ca", order, places["velocity"])
        stacked: dict = {"C": [], "Ca": [], "Du": [], "Dw": []}
        used = {"C"}
        for part in self.parts:
            own: dict = {}
            for key, x in part.given.items():
                if key not in where:
                    raise ValueError(_nothing(key))
                name, width, at = where[key]
                count = at.stop - at.start
                x = x * np.eye(count) if np.ndim(x) == 0 else x
                if x.shape[1] != count or not count:
                    raise ValueError(_width(key, x, count))
                full = np.zeros((len(x), width))
                full[:, at] = x
                if name in own and len(own[name]) == len(full):
                    full = full + own[name]
                own[name] = full
            counts = {len(x) for x in own.values()}
            if len(counts) > 1 or not min(counts):
                raise ValueError(
                    f"{in_words(*part.data())}: a number stands for a multiple of the "
                    "identity, which has other rows here: give a matrix"
                )
            used |= own.keys()
            for name, width in {"C": order, "Ca": order, "Du": m, "Dw": p}.items():
                stacked[name].append(own.get(name, np.zeros((*counts, width))))
        return {k: np.vstack(x) if k in used else None for k, x in stacked.items()}

    def resized(self, old: int, new: int) -> "Output":
        """The same output where ``old`` states are the first of ``new``, or the other
        way round: rows on all states get zeros, or lose them.

        Raises
        ------
        ValueError
            If rows lose what isn't zero.

        Examples
        --------
        >>> Output(state=[[1, 0]]).resized(2, 3)
        <Output: [[1, 0, 0]] x>
        """
        parts = []
        for part in self.parts:
            own = part.given
            for key in own.keys() & {"state", "rate"}:
                x = own[key]
                if np.ndim(x) and x.shape[1] == old:
                    if x[:, new:].any():
                        raise ValueError(f"{key} weighs a state that isn't there")
                    wide = np.zeros((len(x), max(new - old, 0)))
                    own[key] = np.hstack([x[:, :new], wide])
            parts.append(Output(**own, name=part.name))
        return reduce(and_, parts)

    def through(self, basis: np.ndarray, halves: int) -> "Output":
        """The same output of a plant whose z is ``basis``, (n, r), times another z.

        A state is ``halves`` of such parts: 2 of [z; z'], 1 of a `DescriptorSystem`'s.

        Examples
        --------
        >>> Output(position=[[1, 2]], input=[[3]]).through(np.eye(2)[:, 1:], 2)
        <Output: [[2]] z + [[3]] u>
        """
        joined = block_diag(*[basis] * halves)
        wide = dict(state=joined, rate=joined)
        wide |= dict.fromkeys(("position", "velocity", "acceleration"), basis)
        parts = []
        for part in self.parts:
            own = part.given
            for key in own.keys() & wide.keys():
                to = wide[key]
                x = own[key] if np.ndim(own[key]) else own[key] * np.eye(len(to))
                if x.shape[1] != len(to):
                    raise ValueError(
                        f"{key} has rows of width {x.shape[1]}, needs {len(to)}"
                    )
                own[key] = x @ to
            parts.append(Output(**own, name=part.name))
        return reduce(and_, parts)

    def seen(self, d: Descriptor) -> Descriptor:
        """The plant ``d``, a `Descriptor`, with this output."""
        n, N, number = d.n, len(d.E), exact if d.E.dtype == object else np.array
        ends = zip(("position", "velocity", "integral"), (0, n, 2 * n), (n, n, d.a))
        places = {name: slice(k, k + size) for name, k, size in ends} if n else {}
        found = self.rows(places, N, d.Bu.shape[1], d.Bw.shape[1])
        found = {k: None if x is None else number(x) for k, x in found.items()}
        return _with_noise(replace(d, **found))

    def data(self) -> list:
        """Its data in a proof file: rows in decimals by argument, part by part."""
        return self._said(decimal)

    def _said(self, number):
        def said(x):
            return [list(map(number, row)) for row in x] if np.ndim(x) else number(x)

        return [
            ({"name": p.name} if p.name else {})
            | {key: said(x) for key, x in p.given.items()}
            for p in self.parts
        ]

    @staticmethod
    def read(data: list) -> "Output":
        """The output of the ``data`` of a file, in decimals or numbers."""
        if not isinstance(data, list) or not data:
            raise ValueError("outputs must be a list of objects with rows by argument")
        return reduce(and_, map(_of_data, data))


def _with_noise(d):
    """A `Descriptor` d whose output sees of w what is in u, too."""
    if d.Uw is None or d.Du is None:
        return d
    through = d.Du @ d.Uw
    return replace(d, Dw=through if d.Dw is None else d.Dw + through)


def _of_data(part):
    """The `Output` of one part of a file's data."""
    if not isinstance(part, dict):
        raise ValueError('an output must be an object, such as {"position": [[1, 0]]}')
    for key in part:
        if key not in (*SIGNALS, "name"):
            raise ValueError(
                f"{key!r:.80} isn't known of an output: {', '.join(SIGNALS)}, name"
            )

    def value(x):
        if isinstance(x, str):
            return read_number(x)
        plain = isinstance(x, list) and any(isinstance(e, str) for r in x for e in r)
        return read_array(x, None, None) if plain else x

    rest = {k: value(x) for k, x in part.items() if k != "name"}
    return Output(**rest, name=part.get("name", ""))


def _rows(key, x):
    x = matrix(key, [x] if np.ndim(x) == 1 else x)
    if not len(x):
        raise ValueError(f"{key} has no row")
    return x


def _nothing(key):
    if key in ("position", "velocity", "acceleration", "integral"):
        return (
            f"{key}: this plant's states aren't z, z' and x3: give rows on all of x by "
            f"{MEANT.get(key, 'state')}="
        )
    return f"{key} isn't known of this plant"


def _width(key, x, count):
    what = COUNTED.get(key, "degrees of freedom")
    if not count:
        return f"{key} is weighed, but the plant has no {what}"
    return f"{key} has rows of width {x.shape[1]}, but the plant has {count} {what}"
