"""A measured frequency response beside those of a family of plants."""

from dataclasses import dataclass
from itertools import product
from os import PathLike
from pathlib import Path

import numpy as np

from ..runtime.libraries import library
from ..runtime.read_only import ReadOnly
from ..runtime.reading import named, numbers_of, read_bytes, read_rows
from .checks import matrix
from .uncertain import Uncertain

HERTZ = "Hz"
UNITS = {"rad/s": 1.0, HERTZ: 2 * np.pi}  # in the heading of the first column
PARTS = "re", "im"
RESPONSES = 58  # the kind of data set of a universal file that holds them
MOST_PLANTS = 243  # of a family, on a grid of its parameters


@dataclass(frozen=True, eq=False)
class MeasuredResponse(ReadOnly):
    """The response of one sensor to one actuator, as it was measured.

    Parameters
    ----------
    omega : (k,) array
        Frequencies in rad/s, not zero.
    H : (k,) array of complex
        What the sensor says for each unit of the actuator.

    Examples
    --------
    >>> import sosbook as sos
    >>> omega = np.array([1.0, 2.0])
    >>> plants = sos.Uncertain(lambda k: sos.SecondOrderSystem(1, 1, k, 1), k=(8, 10))
    >>> seen = MeasuredResponse(omega, 1 / (9.1 - omega**2 + 1j * omega))
    >>> print(seen.beside(plants))
    2 of 2 points lie within the band of 9 plants
    """

    omega: np.ndarray
    H: np.ndarray

    def __post_init__(self):
        omega, H = np.asarray(self.omega, float), np.asarray(self.H, complex)
        if omega.ndim != 1 or omega.shape != H.shape or not len(omega):
            raise ValueError(
                "omega and H must be two lists of one length, of one sensor and one "
                f"actuator, got the shapes {omega.shape} and {H.shape}"
            )
        if not (
            np.isfinite(H).all() and (omega > 0).all() and np.isfinite(omega).all()
        ):
            raise ValueError("omega must be above 0, and H finite")
        object.__setattr__(self, "omega", omega)
        object.__setattr__(self, "H", H)
        super().__post_init__()

    @classmethod
    def read(cls, path: str | PathLike, which: int | None = None) -> "MeasuredResponse":
        """The response in a file.

        Parameters
        ----------
        path : str or path
            A table (.csv) under the heading ``Hz,re,im`` or ``rad/s,re,im``; or a
            universal file (.uff, .unv) with data sets 58, which pyuff reads.
        which : int, optional
            Of several data sets that one, from 0.

        Raises
        ------
        ValueError
            If the heading is another one, a line has no numbers, or it isn't said which
            of several responses is meant.
        """
        if Path(path).suffix.lower() in (".uff", ".unv"):
            return cls._universal(path, which)
        rows = read_rows(path)
        heading = [x.strip() for x in rows[0]] if rows else []
        with named(path):
            if heading[:1] not in [[x] for x in UNITS] or tuple(heading[1:]) != PARTS:
                raise ValueError(
                    "its first line must be Hz,re,im or rad/s,re,im, got "
                    f"{','.join(heading)!r:.80}"
                )
            x, re, im = numbers_of(path, rows, heading).T
            return cls(UNITS[heading[0]] * x, re + 1j * im)

    @classmethod
    def _universal(cls, path, which):
        """`read` of a universal file."""
        read_bytes(path)  # within its limit, or an error that names it
        with named(path):
            try:
                file = library("pyuff").UFF(str(path))
                kinds = [int(kind) for kind in file.get_set_types()]
                places = [k for k, kind in enumerate(kinds) if kind == RESPONSES]
                sets = [file.read_sets(k) for k in places]
                found = [(f"{x['rsp_node']} by {x['ref_node']}", x) for x in sets]
            except ModuleNotFoundError:
                raise
            except Exception as error:  # a broken file brings it to all kinds of ends
                raise ValueError(f"it can't be read by pyuff: {error}") from None
            if len(found) != 1 and which not in range(len(found)):
                names = ", ".join(f"{k}: {name}" for k, (name, _) in enumerate(found))
                raise ValueError(f"which= must be one of {names or 'no response'}")
            _, data = found[0 if which is None else which]
            x, H = np.asarray(data["x"], float), np.asarray(data["data"], complex)
            return cls(UNITS[HERTZ] * x[x > 0], H[x > 0])

    def beside(self, plants, sensor=0, actuator: int = 0) -> "Beside":
        """This response beside those of some plants.

        Parameters
        ----------
        plants : Uncertain or Polytope
            A family, whose band is that of a grid of its parameters with its corners,
            or of its vertices.
        sensor : int or (n,) array_like
            The displacement that is measured, or a row on z.
        actuator : int
            Which input pushes.

        Raises
        ------
        ValueError
            If there is one plant, which has no band, or no such sensor or actuator.
        """
        several = _plants_of(plants)
        n, m = several[0].B.shape
        row = np.eye(n)[sensor] if np.ndim(sensor) == 0 else sensor
        row = matrix("sensor", [row], (1, n))[0]
        if actuator not in range(m):
            raise ValueError(f"actuator must be one of 0 to {m - 1}, got {actuator}")
        each = [
            [
                row
                @ np.linalg.solve(v.S + 1j * w * v.D - w * w * v.M, v.B[:, actuator])
                for w in self.omega
            ]
            for v in several
        ]
        return Beside(self, np.array(each))


@dataclass(frozen=True, eq=False)
class Beside(ReadOnly):
    """A measured response beside those of several plants; its text says how many
    points lie within their band, in size and in phase.

    ``measured``: the `MeasuredResponse`; ``plants``: (plants, k), their responses.
    """

    measured: MeasuredResponse
    plants: np.ndarray

    @property
    def angles(self) -> tuple[np.ndarray, np.ndarray]:
        """The phases (k,) of the measured and (plants, k) of the plants' responses, in
        rad: each as near to the plants' mean direction as it can be.
        """
        middle = (self.plants / abs(self.plants)).sum(0)
        turn = np.angle(middle)
        H, G = (np.angle(x * middle.conj()) for x in (self.measured.H, self.plants))
        return turn + H, turn + G

    @property
    def inside(self) -> np.ndarray:
        """(k,) array of bool: size and phase lie between those of the plants."""
        phase, phases = self.angles
        size, sizes = abs(self.measured.H), abs(self.plants)
        between = [
            (x >= y.min(0)) & (x <= y.max(0))
            for x, y in ((size, sizes), (phase, phases))
        ]
        return between[0] & between[1]

    @property
    def share(self) -> float:
        """How many of all points lie within the band, from 0 to 1."""
        return float(self.inside.mean())

    def __str__(self):
        inside = self.inside
        said = (
            f"{inside.sum()} of {len(inside)} points lie within the band of "
            f"{len(self.plants)} plants"
        )
        if inside.all():
            return said
        off = abs(np.log(self.measured.H / self.plants)).min(0) * ~inside
        k = int(off.argmax())
        return f"{said}; the furthest outside is at {self.measured.omega[k]:.4g} rad/s"


def _plants_of(plants):
    """The vertices of a polytope; of a family those on a grid of its parameters."""
    if isinstance(plants, Uncertain):
        box, counts = plants.box, (2, 3, 5, 9)
        few = [x for x in counts if x ** len(box.names) <= MOST_PLANTS] or counts[:1]
        ends = zip(map(float, box.low), map(float, box.high))
        grid = product(*(np.linspace(*pair, few[-1]) for pair in ends))
        return [plants.at(**dict(zip(box.names, values))) for values in grid]
    several = list(plants.vertices)
    if len(several) < 2:
        raise ValueError("one plant has no band: give an Uncertain or a Polytope")
    return several
