"""LMI regions of the complex plane, as requirements on closed-loop poles."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .. import analysis, theorems
from ..bisection import lowest
from ..exact.rational import decimal, decimals, exact, read_array, read_number
from ..plants.checks import matrix
from ..plants.coupled import Coupled, SlackVertex
from ..plants.descriptor import Descriptor
from ..runtime.array_like import ArrayLike
from ..runtime.later import later
from ..runtime.names import sane_name
from ..runtime.read_only import put
from .base import Requirement
from .known_gain import KnownVertex
from .posed import PosedLoop
from .region_forms import RegionForms, degrees
from .vocabulary import SIGMA


@dataclass(frozen=True, eq=False)
class Region:
    """An intersection of LMI regions.

    Parameters
    ----------
    parts : tuple of LMIRegion
        The regions that are intersected. A name that comes twice gets
        a number: "disk", "disk#2".

    Raises
    ------
    ValueError
        If there is no part, or one of them isn't an LMIRegion.
    """

    parts: tuple

    def __post_init__(self):
        """Check the parts and their names."""
        parts, names = [], set()
        try:
            given = tuple(self.parts)
        except TypeError:
            raise ValueError(
                "parts must be a sequence of LMIRegion objects, got "
                f"{type(self.parts).__name__}"
            ) from None
        for part in given:
            if not isinstance(part, LMIRegion):
                raise ValueError(
                    f"parts must be LMIRegion objects, got {type(part).__name__}"
                )
            name, count = part.name, 1
            while name in names:
                count += 1
                name = f"{part.name}#{count}"
            names.add(name)
            if count > 1:
                part = part.named(name)
            parts.append(part)
        if not parts:
            raise ValueError("parts is empty: a region needs an LMIRegion")
        put(self, parts=tuple(parts))

    def __and__(self, other):
        if not isinstance(other, Region):
            return NotImplemented
        return Region(self.parts + other.parts)

    def distances(self, poles: ArrayLike) -> dict[str, np.ndarray]:
        """How far inside each part the poles lie.

        Parameters
        ----------
        poles : array_like of complex
            Points of the plane, in rad/s.

        Returns
        -------
        dict
            From a part's name to an array of the shape of ``poles``:
            positive inside. For half-plane, sector and disk it is the
            distance to the boundary, in rad/s; for other regions a
            lower bound of it.
        """
        return {part.name: part.distance(poles) for part in self.parts}

    def contains(self, poles: ArrayLike) -> bool:
        """True if all poles lie strictly inside."""
        return all((d > 0).all() for d in self.distances(poles).values())


class LMIRegion(RegionForms, Region, Requirement):
    r"""The region :math:`\alpha + \beta s + \beta^\top \bar s < 0`.

    Parameters
    ----------
    alpha : (k, k) array_like
        A symmetric matrix.
    beta : (k, k) array_like
        Any real matrix but zero.
    name : str
        Names the LMI block that demands it: letters, digits, spaces and
        hyphens.
    text : str, optional
        The region in words, for messages. Proofs state the matrices of a
        region that none of the constructors below makes.

    Notes
    -----
    Source: Chilali and Gahinet (1996); thesis (A.7), (A.8).

    Examples
    --------
    >>> strip = LMIRegion.strip(-5, -1)
    >>> strip.contains([-2 + 3j, -2 - 3j]), strip.contains([-6])
    (True, False)
    """

    kind, promise, rank, bound = "region", "poles", 12, None
    alpha: np.ndarray
    beta: np.ndarray
    text: str
    affine_in_quotient = True
    of_two = "join regions by &, as in PoleRegion(1) & PoleRegion(2), or name each"

    def __init__(
        self, alpha: ArrayLike, beta: ArrayLike, name: str, text: str | None = None
    ) -> None:
        alpha = matrix("alpha", alpha)
        k = alpha.shape[0]
        if alpha.shape != (k, k) or not np.array_equal(alpha, alpha.T):
            raise ValueError("alpha must be symmetric")
        beta = matrix("beta", beta, (k, k))
        if not beta.any():
            raise ValueError("beta is zero: the region has no boundary")
        sane_name(name)
        put(self, alpha=alpha, beta=beta, name=name, text=text or name, parts=(self,))

    def __repr__(self):
        alpha, beta = self.alpha.tolist(), self.beta.tolist()
        return f"LMIRegion({alpha}, {beta}, {self.name!r})"

    def named(self, name: str) -> "LMIRegion":
        """The same region under another name."""
        region = LMIRegion(self.alpha, self.beta, name, self.text)
        return region._made(self._form, **self._sizes)

    def data(self) -> dict:
        contents = {"kind": self.kind, "name": self.name, "form": self._form}
        contents |= {key: decimal(value) for key, value in self._sizes.items()}
        if self._form == "sector":
            contents["degrees"] = degrees(*self.beta[0])
        return contents | {"alpha": decimals(self.alpha), "beta": decimals(self.beta)}

    @classmethod
    def of_data(cls, data: dict) -> "LMIRegion":
        if data["form"] not in FORMS:
            k = len(data["alpha"])
            sizes = [read_array(data[x], k, k) for x in ("alpha", "beta")]
            return cls(*sizes, data["name"])
        fixed = ("kind", "name", "form", "degrees", "alpha", "beta")
        sizes = {k: read_number(v) for k, v in data.items() if k not in fixed}
        return cls._of_form(data["form"], sizes, data["name"])

    @property
    def implies_stability(self) -> bool:
        """True if one scalar of the region says Re s < -c with c >= 0."""
        return (
            self.alpha.shape == (1, 1) and self.alpha[0, 0] >= 0 and self.beta[0, 0] > 0
        )

    @property
    def words(self) -> str:
        """The parameter's words, unless it has a name of its own."""
        named = self.name not in ("half-plane", "sector", "disk")
        return self.name if named or not self.parameter else super().words

    @property
    def titles(self) -> dict:
        symbol = "" if self.words == self.name else f" {self.parameter.symbol}"
        return {"": self.name + symbol}

    def with_bound(self, bound: float) -> "Requirement":
        if self.parameter is None:
            return super().with_bound(bound)
        sizes = self._sizes | {self.parameter.key: bound}
        return self._of_form(self._form, sizes, self.name)

    def repeats(self, other: Any) -> bool:
        if not isinstance(other, LMIRegion) or other.alpha.shape != self.alpha.shape:
            return False
        pairs = zip(_of_size_one(self), _of_size_one(other))
        return all((one == two).all() for one, two in pairs)

    def contradicts(self, other: Any) -> bool:
        """True if an ``other`` region lies apart at sight.

        A disk that lies right of a half-plane holds no pole of it. With some v,
        v' f(s) v >= 0 wherever Re s <= -sigma: floats suggest v, rationals decide.
        """
        if self._disk is None or not isinstance(other, LMIRegion):
            return False
        if other.parameter is not SIGMA:
            return False
        wall = self.alpha - other.bound * (self.beta + self.beta.T)
        v = np.linalg.eigh(wall)[1][:, -1]
        v = exact((v / np.abs(v).max()).round(6))
        (alpha, beta), sigma = self.pole_matrices(), exact(other.bound)
        slope = v @ beta @ v
        return bool(slope <= 0 and v @ alpha @ v - 2 * sigma * slope >= 0)

    def pole_matrices(self) -> tuple:
        return exact(self.alpha), exact(self.beta)

    def stepped(self, step: float | None) -> "LMIRegion":
        if step is None:
            return self
        if self.parameter is SIGMA and (self.bound or 0) > 0:
            raise ValueError(
                f"sigma = {self.bound:g} is a decay of continuous time, and the plant "
                f"is one with dt = {step:g} s: poles z that decay as fast lie in the "
                f"disk LMIRegion.disk({np.exp(-self.bound * step):.6g})"
            )
        return later("requirements.in_steps", "InSteps")(self, step)

    def matrices(self, number: Any) -> tuple:
        """alpha and beta in the arithmetic of ``number``."""
        return number(self.alpha), number(self.beta)

    def pair(self, loop: PosedLoop, c: Coupled) -> Iterable:
        yield "", theorems.pole_region(c, *self.matrices(loop.number))

    def slack(self, loop: PosedLoop, c: SlackVertex, i: int) -> Iterable:
        how = *self.matrices(loop.number), loop.epsilon
        yield "", theorems.slack_pole_region(c, *how)

    def known_gain(self, c: KnownVertex) -> Iterable:
        alpha, beta = self.matrices(c.number)
        if self.multiplier_rows == len(alpha):
            form = alpha, beta, 0 * alpha
        else:  # (|s - q|^2 - rho^2) / rho < 0
            rho, q = -alpha[:1, :1], -alpha[:1, 1:]
            form = q * q / rho - rho, -q / rho, 1 / rho
        yield "", theorems.free_pole_region(c, *form)

    @property
    def multiplier_rows(self) -> int:
        """One for a disk as it is usually written, else as many as alpha has."""
        usual = np.array_equal(self.beta, [[0, 1], [0, 0]])
        usual = usual and self.alpha[0, 0] == self.alpha[1, 1]
        return 1 if usual else len(self.alpha)

    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        """How far inside the worst pole lies, in rad/s: see `distances`.

        The poles are those of all ``loops`` under K and K_A.
        """
        return self.distance(np.array([analysis.poles(d, K) for d in loops])).min()

    def reached(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        """The bound with which the region just doesn't hold all poles, if it has one.

        The poles are those of all ``loops`` under K and K_A.
        """
        return self.bound_of(np.array([analysis.poles(d, K) for d in loops]))

    def kept(self, truth: float) -> float:
        return truth

    def rate(self) -> tuple | None:
        if self._disk is not None:
            rho, centre = self._disk
            return 0, rho / 2 + abs(centre)
        if self.implies_stability and self.alpha[0, 0] > 0:
            return 1, 2 * self.alpha[0, 0] / self.beta[0, 0]
        rough = np.abs(self.alpha).max() / np.abs(self.beta).max()
        return (2, rough) if rough else None

    @property
    def _disk(self):
        """Radius and centre, however the matrices of a disk are written; else None.
        With H = beta + beta', and j the entry 1, 2 of beta - beta', the determinant at
        s = x + iy is det(alpha + x H) - j^2 y^2. That of a disk is j^2 (rho^2 - |s -
        c|^2).
        """
        if self.alpha.shape != (2, 2):
            return None
        if np.array_equal(self.beta, [[0, 1], [0, 0]]):
            usual = self.alpha[0, 0] == self.alpha[1, 1]
            return tuple(-self.alpha[0]) if usual else None
        H, j = self.beta + self.beta.T, self.beta[0, 1] - self.beta[1, 0]
        size = np.abs(self.beta).max() ** 2
        if abs(np.linalg.det(H) + j**2) > ROUNDING * size or j**2 < ROUNDING * size:
            return None
        a, h = self.alpha, H
        mixed = a[0, 0] * h[1, 1] + a[1, 1] * h[0, 0] - 2 * a[0, 1] * h[0, 1]
        centre = mixed / (2 * j**2)
        square = np.linalg.det(a) / j**2 + centre**2
        inside = np.linalg.eigvalsh(a + centre * h)[-1] < 0
        return (float(np.sqrt(square)), float(centre)) if inside else None

    def characteristic(self, s: ArrayLike) -> np.ndarray:
        """The Hermitian matrices f(s) of (A.8), one for each pole."""
        try:
            s = np.asarray(s, complex)[..., None, None]
        except (TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"poles must be complex numbers: {error}") from None
        return self.alpha + self.beta * s + self.beta.T * s.conj()

    def distance(self, poles: ArrayLike) -> np.ndarray:
        """How far inside each of some poles lies; see `Region.distances`."""
        top = np.linalg.eigvalsh(self.characteristic(poles))[..., -1]
        return -top / (2 * self._radius)

    @cached_property
    def _radius(self):
        return _numerical_radius(self.beta)


ROUNDING = 1e-10  # relative, of a disk whose matrices were turned
FORMS = "half-plane", "sector", "disk", "strip", "horizontal strip", "ellipse"


def _of_size_one(part):
    """alpha and beta in rationals, divided by the size of beta's first entry."""
    alpha, beta = part.pole_matrices()
    size = next(abs(e) for e in beta.flat if e != 0)
    return alpha / size, beta / size


def _numerical_radius(beta):
    """The largest |x* beta x| over unit vectors x."""
    if beta.shape == (1, 1):
        return abs(beta[0, 0])

    def height(angle):
        turned = np.exp(1j * angle) * beta
        return np.linalg.eigvalsh(turned + turned.conj().T)[-1] / 2

    grid = np.linspace(0, 2 * np.pi, 25)
    best = grid[np.argmax([height(a) for a in grid])]
    _, near = lowest(lambda a: -height(a), best - 0.3, best + 0.3, 1e-10)
    return max(height(best), -near)


def by_matrices(requirement):
    """A ``requirement`` as one that the kernel knows: an author's region by its
    matrices, None if an author's says nothing of poles.
    """
    form = requirement.pole_matrices()
    if requirement.of_package or form is None:
        return requirement if requirement.of_package else None
    return LMIRegion(*(x.astype(float) for x in form), requirement.name)
