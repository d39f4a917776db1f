"""A measured frequency response beside those of a family of plants."""

from dataclasses import dataclass
from itertools import product
from os import PathLike
from pathlib import Path

import numpy as np

from ..runtime.libraries import library
from ..runtime.read_only import ReadOnly
from ..runtime.reading import named, numbers_of, read_bytes, read_rows
from ..runtime.sparse import issparse
from .checks import matrix
from .uncertain import Uncertain

HERTZ = "Hz"
UNITS = {"rad/s": 1.0, HERTZ: 2 * np.pi}  # in the heading of the first column
PARTS = "re", "im"
RESPONSES, FUNCTION = 58, 4  # the kinds of a data set of a universal file that has one
RATES = {11: 1, 12: 2}  # the kinds of what is a velocity or an acceleration there
#: What may have been measured instead: what it is of the response, at omega.
OTHERS = {
    "as velocities": lambda omega: 1j * omega,
    "as accelerations": lambda omega: -(omega**2),
    "with the other sign": lambda omega: -1.0,
}
CLOSER = 0.1  # of the distance in the median: so much nearer is what was measured
MOST_PLANTS = 243  # of a family, on a grid of its parameters


@dataclass(frozen=True, eq=False)
class MeasuredResponse(ReadOnly):
    """The response of one sensor to one actuator, as it was measured.

    Parameters
    ----------
    omega : (k,) array
        Frequencies in rad/s, not zero.
    H : (k,) array of complex
        What the sensor says of a displacement for each unit of the actuator: of an
        acceleration that divided by -omega^2.

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
            universal file (.uff, .unv) with data sets 58, which pyuff reads; its
            velocities and accelerations become displacements. The frequency zero is
            left out.
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
            return cls(UNITS[heading[0]] * x[x != 0], (re + 1j * im)[x != 0])

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
                found = [
                    ("{rsp_node}.{rsp_dir} by {ref_node}.{ref_dir}".format(**x), x)
                    for x in sets
                    if x["func_type"] == FUNCTION
                ]
            except ModuleNotFoundError:
                raise
            except Exception as error:  # a broken file brings it to all kinds of ends
                raise ValueError(f"it can't be read by pyuff: {error}") from None
            if len(found) != 1 and which not in range(len(found)):
                names = ", ".join(f"{k}: {name}" for k, (name, _) in enumerate(found))
                raise ValueError(f"which= must be one of {names or 'no response'}")
            _, data = found[0 if which is None else which]
            x, H = np.asarray(data["x"], float), np.asarray(data["data"], complex)
            omega, H = UNITS[HERTZ] * x[x != 0], H[x != 0]
            power = RATES.get(data["ordinate_spec_data_type"], 0)
            return cls(omega, H / (1j * omega) ** power)

    def beside(self, plants, sensor=0, actuator: int = 0) -> "Beside":
        """This response beside those of some plants.

        Parameters
        ----------
        plants : Uncertain, Polytope or SecondOrderSystem
            A family, whose band is that of a grid of its parameters with its corners,
            or of its vertices; or one plant, perhaps a sparse one.
        sensor : int or (n,) array_like
            The displacement that is measured, or a row on z.
        actuator : int
            Which input pushes.

        Raises
        ------
        ValueError
            If there is no such sensor or actuator.
        """
        several = _plants_of(plants)
        n, m = several[0].B.shape
        row = np.eye(n)[sensor] if np.ndim(sensor) == 0 else sensor
        row = matrix("sensor", [row], (1, n))[0]
        if actuator not in range(m):
            raise ValueError(f"actuator must be one of 0 to {m - 1}, got {actuator}")
        each = [
            [
                row @ _solve(v.S + 1j * w * v.D - w * w * v.M, v.B[:, actuator])
                for w in self.omega
            ]
            for v in several
        ]
        return Beside(self, np.array(each))


@dataclass(frozen=True, eq=False)
class Beside(ReadOnly):
    """A measured response beside those of several plants; its text says how many
    points lie within their band, in size and in phase, or how far they lie from the
    response of one plant.

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
        """How many of all points lie within the band, from 0 to 1; that of one plant is
        its response.
        """
        return float(self.inside.mean())

    @property
    def apart(self) -> np.ndarray:
        """(k,) array: how far each point lies from the nearest plant's, as a share of
        that; 0 within the band.
        """
        return abs(self.measured.H / self.plants - 1).min(0) * ~self.inside

    def __str__(self):
        """How far the points lie from the plants, and what else may be measured."""
        omega, apart = self.measured.omega, self.apart
        far = f"{omega[apart.argmax()]:.4g} rad/s"
        if len(self.plants) == 1:
            half = float(np.median(apart))
            said = (
                f"half of {len(apart)} points lie within {100 * half:.2g} % of the "
                f"plant's response, the furthest {100 * apart.max():.2g} % away, at "
                f"{far}"
            )
        else:
            said = (
                f"{self.inside.sum()} of {len(apart)} points lie within the band of "
                f"{len(self.plants)} plants"
            )
            said += f"; the furthest outside is at {far}" * bool(apart.any())
        for name, factor in OTHERS.items():
            read = MeasuredResponse(omega, self.measured.H / factor(omega))
            other = float(np.median(Beside(read, self.plants).apart))
            if other < CLOSER * np.median(apart):
                said += f"; read {name} half of them lie within {100 * other:.2g} %"
        return said


def _plants_of(plants):
    """The vertices of a polytope; of a family those on a grid of its parameters."""
    if isinstance(plants, Uncertain):
        box, counts = plants.box, (2, 3, 5, 9)
        few = [x for x in counts if x ** len(box.names) <= MOST_PLANTS] or counts[:1]
        ends = zip(map(float, box.low), map(float, box.high))
        grid = product(*(np.linspace(*pair, few[-1]) for pair in ends))
        return [plants.at(**dict(zip(box.names, values))) for values in grid]
    return list(plants.vertices)


def _solve(A, b):
    """A^-1 b, of a full or a sparse matrix."""
    if not issparse(A):
        return np.linalg.solve(A, b)
    from scipy.sparse.linalg import spsolve

    return spsolve(A.tocsc(), b)
