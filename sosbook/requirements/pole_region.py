"""Regions of the complex plane for closed-loop poles."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from math import prod
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from ..analysis.linear import poles
from ..lmi.rational import decimal, decimals, exact, read_array, read_number
from ..plants.checks import matrix, number, positive
from ..plants.descriptor import Coupled, Descriptor, SlackVertex
from ..theorems import pole_region, slack_pole_region
from .base import Requirement, sane_name
from .loop import Loop
from .vocabulary import RHO, SIGMA, THETA

__all__ = ["LMIRegion", "PoleRegion", "Region"]


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
        parts, names = [], set()
        for part in self.parts:
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
        object.__setattr__(self, "parts", tuple(parts))

    def __and__(self, other):
        if not isinstance(other, Region):
            return NotImplemented
        return Region(self.parts + other.parts)

    def distances(self, poles: ArrayLike) -> dict[str, np.ndarray]:
        """How far inside each part the poles lie.

        Parameters
        ----------
        poles : array_like of complex
            In rad/s.

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
        """Whether all poles lie strictly inside."""
        return all((d > 0).all() for d in self.distances(poles).values())


class LMIRegion(Region, Requirement):
    r"""The region :math:`\alpha + \beta s + \beta^\top \bar s < 0`.

    Parameters
    ----------
    alpha : (k, k) array_like
        Symmetric.
    beta : (k, k) array_like
        Any real matrix.
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
    of_poles = True
    _again = None  # makes the same region with another bound
    _form = "matrices"  # which constructor made it, of what
    _sizes: dict[str, float] = {}

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
        object.__setattr__(self, "alpha", alpha)
        object.__setattr__(self, "beta", beta)
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "text", text or name)
        object.__setattr__(self, "parts", (self,))

    def __repr__(self):
        alpha, beta = self.alpha.tolist(), self.beta.tolist()
        return f"LMIRegion({alpha}, {beta}, {self.name!r})"

    def named(self, name: str) -> "LMIRegion":
        """The same region under another name."""
        region = LMIRegion(self.alpha, self.beta, name, self.text)
        return region._made(self._form, **self._sizes)

    def _made(self, form, **sizes):
        """Remember the constructor; proofs say its form in words."""
        object.__setattr__(self, "_form", form)
        object.__setattr__(self, "_sizes", sizes)
        return self

    def data(self) -> dict:
        contents = {"kind": self.kind, "name": self.name, "form": self._form}
        contents |= {key: decimal(value) for key, value in self._sizes.items()}
        if self._form == "sector":
            contents["degrees"] = _degrees(*self.beta[0])
        return contents | {"alpha": decimals(self.alpha), "beta": decimals(self.beta)}

    @classmethod
    def of_data(cls, data: dict) -> "LMIRegion":
        make = FORMS.get(data["form"])
        if make is None:
            k = len(data["alpha"])
            sizes = [read_array(data[x], k, k) for x in ("alpha", "beta")]
            return cls(*sizes, data["name"])
        fixed = ("kind", "name", "form", "degrees", "alpha", "beta")
        sizes = {k: read_number(v) for k, v in data.items() if k not in fixed}
        return make(**sizes, name=data["name"])

    @property
    def implies_stability(self) -> bool:
        """Whether one scalar of it says Re s < -c with c >= 0."""
        return (
            self.alpha.shape == (1, 1) and self.alpha[0, 0] >= 0 and self.beta[0, 0] > 0
        )

    def _movable(self, parameter, bound, again, rank):
        for name, value in (
            ("parameter", parameter),
            ("bound", bound),
            ("_again", again),
            ("rank", rank),
        ):
            object.__setattr__(self, name, value)
        return self

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
        if self._again is None:
            return super().with_bound(bound)
        return self._again(bound)

    def repeats(self, other: Any) -> bool:
        """Whether its blocks are those of an ``other`` requirement."""
        if not isinstance(other, LMIRegion) or other.alpha.shape != self.alpha.shape:
            return False
        return all(
            np.array_equal(one, two)
            for one, two in zip(_of_size_one(self), _of_size_one(other))
        )

    def contradicts(self, other: Any) -> bool:
        """Whether an ``other`` region lies apart at sight.

        A disk that lies right of a half-plane holds no pole of it.
        """
        if not (
            self._is_disk and isinstance(other, LMIRegion) and other.parameter is SIGMA
        ):
            return False
        rho, shift = -self.alpha[0]
        return rho <= other.bound + shift

    def holds_at(self, root: Any) -> bool | None:
        return root.inside(exact(self.alpha), exact(self.beta))

    def pair(self, loop: Loop, c: Coupled) -> Iterable:
        yield "", pole_region(c, loop.number(self.alpha), loop.number(self.beta))

    def slack(self, loop: Loop, c: SlackVertex, i: int) -> Iterable:
        yield (
            "",
            slack_pole_region(
                c, loop.number(self.alpha), loop.number(self.beta), loop.epsilon
            ),
        )

    def claim(self) -> str:
        """The form in words, which the matrices imply, or the matrices."""
        form, sizes = self._form, {k: decimal(x) for k, x in self._sizes.items()}
        if form == "half-plane":
            place = f"Re s < {decimal(-self._sizes['sigma'])}"
        elif form == "sector":
            place = f"of half-angle {_degrees(*self.beta[0])} degrees"
            if self._sizes["apex"]:
                place += f" with apex {sizes['apex']}"
        elif form == "disk":
            place = "of radius {rho} around {centre}".format(**sizes)
        elif form == "strip":
            place = "{left} < Re s < {right}".format(**sizes)
        elif form == "horizontal strip":
            place = "|Im s| < {omega}".format(**sizes)
        elif form == "ellipse":
            place = "of half axes {a} and {b} around {centre}".format(**sizes)
        else:
            form = "region alpha + beta s + beta' s* < 0,"
            place = f"with alpha = {_rows(self.alpha)} and beta = {_rows(self.beta)}"
        return f"its poles lie in the {form} {place}"

    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        """How far inside the worst pole lies, in rad/s: see `distances`.

        The poles are those of all ``loops`` under K and K_A.
        """
        spectra = np.array([poles(d, K) for d in loops])
        return self.distance(spectra).min()

    def kept(self, truth: float) -> float:
        return truth

    def rate(self) -> tuple | None:
        if self._is_disk:
            rho, shift = -self.alpha[0]
            return 0, rho / 2 + abs(shift)
        if self.implies_stability and self.alpha[0, 0] > 0:
            return 1, 2 * self.alpha[0, 0] / self.beta[0, 0]
        return None

    @property
    def _is_disk(self):
        return np.array_equal(self.beta, [[0, 1], [0, 0]])

    def characteristic(self, s: ArrayLike) -> np.ndarray:
        """The Hermitian matrices f(s) of (A.8), one for each pole."""
        s = np.asarray(s, complex)[..., None, None]
        return self.alpha + self.beta * s + self.beta.T * s.conj()

    def distance(self, poles: ArrayLike) -> np.ndarray:
        """How far inside each of some poles lies; see `Region.distances`."""
        top = np.linalg.eigvalsh(self.characteristic(poles))[..., -1]
        return -top / (2 * _numerical_radius(self.beta))

    @classmethod
    def half_plane(cls, sigma: float, name: str = "half-plane") -> "LMIRegion":
        """Re s < -sigma (2.18), under a name."""
        alpha = [[_at_least(2, number("sigma", sigma))]]
        text = f"{name} Re s < {_words(0.0 - sigma)}"
        region = cls(alpha, [[1]], name, text)._movable(
            SIGMA, float(sigma), partial(cls.half_plane, name=name), 10
        )
        return region._made("half-plane", sigma=float(sigma))

    @classmethod
    def sector(
        cls, theta: float, apex: float = 0.0, name: str = "sector"
    ) -> "LMIRegion":
        """The cone with Im s between ± (apex - Re s) tan(theta) (2.20), (A.15).

        Messages know it by its name.

        ``theta`` is HALF the opening angle, in radians, and ``name`` tells
        the sector from others. The float pair
        (sin, cos) and the apex are rounded inwards: the region that is
        proven lies inside the region that is named.
        """
        theta = number("theta", theta)
        if not 0 < theta <= np.pi / 2:
            raise ValueError(
                f"theta = {theta} is outside (0, pi/2]: it is the "
                "half-angle of the sector, in radians; PoleRegion takes "
                "degrees as theta_deg=..."
            )
        sin = np.sin(theta) * (1 - 4 * np.finfo(float).eps)
        cos = np.cos(theta) * (1 + 4 * np.finfo(float).eps)
        beta = np.array([[sin, cos], [-cos, sin]])
        apex = number("apex", apex)
        alpha = _at_least(-2, sin, apex)
        text = f"{name} of half-angle {_degrees(sin, cos)} degrees"
        if apex:
            text += f" with apex {_words(apex)}"
        region = cls(alpha * np.eye(2), beta, name, text)._movable(
            THETA, theta, partial(cls.sector, apex=apex, name=name), 11
        )
        return region._made("sector", theta=theta, apex=apex)

    @classmethod
    def disk(cls, rho: float, centre: float = 0.0, name: str = "disk") -> "LMIRegion":
        """|s - centre| < rho (2.19), (A.11), under a name."""
        rho = positive("rho", rho)
        centre = number("centre", centre)
        alpha = [[-rho, -centre], [-centre, -rho]]
        text = f"{name} of radius {_words(rho)} around {_words(centre)}"
        region = cls(alpha, [[0, 1], [0, 0]], name, text)._movable(
            RHO, rho, partial(cls.disk, centre=centre, name=name), 12
        )
        return region._made("disk", rho=rho, centre=centre)

    @classmethod
    def strip(cls, left: float, right: float, name: str = "strip") -> "LMIRegion":
        """left < Re s < right, under a name."""
        left, right = number("left", left), number("right", right)
        if left >= right:
            raise ValueError(f"left = {left} must be below right = {right}")
        alpha = np.diag([_at_least(2, left), _at_least(-2, right)])
        text = f"{name} {_words(left)} < Re s < {_words(right)}"
        region = cls(alpha, np.diag([-1, 1]), name, text)
        return region._made("strip", left=left, right=right)

    @classmethod
    def horizontal_strip(
        cls, omega: float, name: str = "horizontal strip"
    ) -> "LMIRegion":
        """-omega < Im s < omega, under a name."""
        omega = positive("omega", omega)
        text = f"{name} |Im s| < {_words(omega)}"
        alpha = _at_least(-2, omega) * np.eye(2)
        region = cls(alpha, [[0, 1], [-1, 0]], name, text)
        return region._made("horizontal strip", omega=omega)

    @classmethod
    def ellipse(
        cls, centre: float, a: float, b: float, name: str = "ellipse"
    ) -> "LMIRegion":
        """((Re s - centre) / a)^2 + (Im s / b)^2 < 1, under a name.

        The right-hand side is rounded down by more than the quotients
        on the left can be wrong, so that the region that is proven
        lies inside the region that is named.
        """
        centre = number("centre", centre)
        a, b = positive("a", a), positive("b", b)
        plus, minus = (1 / a + 1 / b) / 2, (1 / a - 1 / b) / 2
        error = 4 * np.finfo(float).eps * (1 + (1 / a + 1 / b) * (abs(centre) + a + b))
        if error > 1e-6:
            raise ValueError(
                f"the ellipse with half axes a = {a} and b = {b} around "
                f"centre = {centre} is too thin, or too small so far out, "
                "for floating point; take a disk or a strip"
            )
        alpha = [[error - 1, -centre / a], [-centre / a, error - 1]]
        text = (
            f"{name} of half axes {_words(a)} and {_words(b)} around {_words(centre)}"
        )
        region = cls(alpha, [[0, plus], [minus, 0]], name, text)
        return region._made("ellipse", centre=centre, a=a, b=b)


FORMS = {
    "half-plane": LMIRegion.half_plane,
    "sector": LMIRegion.sector,
    "disk": LMIRegion.disk,
    "strip": LMIRegion.strip,
    "horizontal strip": LMIRegion.horizontal_strip,
    "ellipse": LMIRegion.ellipse,
}


class PoleRegion(Region):
    """The thesis's D-region (Fig. 2.1); any part may be left out.

    Parameters
    ----------
    sigma : float, optional
        Re s < -sigma, in rad/s.
    theta : float, optional
        HALF the angle of the sector around the negative real axis, in
        radians, at most pi/2.
    rho : float, optional
        |s| < rho, in rad/s.
    theta_deg : float, optional
        theta in degrees, instead of radians.

    Raises
    ------
    ValueError
        If nothing is given, a value is out of range, or the
        intersection is empty.

    Notes
    -----
    Source: Theorem 2.2, (2.18)-(2.20).

    Examples
    --------
    >>> region = PoleRegion(sigma=0.7, theta=np.pi / 4, rho=5)
    >>> region.distances([-1 + 0.5j])["half-plane"]
    array([0.3])
    """

    def __init__(
        self,
        sigma: float | None = None,
        theta: float | None = None,
        rho: float | None = None,
        *,
        theta_deg: float | None = None,
    ) -> None:
        if theta_deg is not None:
            if theta is not None:
                raise ValueError("give theta (in radians) or theta_deg, not both")
            theta = float(np.radians(number("theta_deg", theta_deg)))
            if not 0 < theta <= np.pi / 2:
                raise ValueError(
                    f"theta_deg = {theta_deg} is outside (0, 90]: it is the "
                    "half-angle of the sector"
                )
        parts = []
        if sigma is not None:
            if number("sigma", sigma) < 0:
                raise ValueError(
                    f"sigma = {sigma} is negative; for a region that "
                    "reaches right of the imaginary axis use "
                    "LMIRegion.half_plane"
                )
            parts.append(LMIRegion.half_plane(sigma))
        if theta is not None:
            parts.append(LMIRegion.sector(theta))
        if rho is not None:
            parts.append(LMIRegion.disk(rho))
        if not parts:
            raise ValueError("PoleRegion needs sigma, theta or rho")
        if None not in (sigma, rho) and rho <= sigma:
            raise ValueError(
                f"the region is empty: rho = {rho} must exceed sigma = {sigma}"
            )
        for name, value in dict(
            sigma=sigma, theta=theta, rho=rho, parts=tuple(parts)
        ).items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, parts: Sequence[LMIRegion]) -> Region:
        """The region of these parts: a PoleRegion where they make one."""
        bounds = {p.parameter.key: p.bound for p in parts if p.parameter}
        if len(bounds) == len(parts):
            try:
                region = cls(**bounds)
            except ValueError:
                return Region(parts)
            if [_same(p) for p in parts] == [_same(p) for p in region.parts]:
                return region
        return parts[0] if len(parts) == 1 else Region(parts)

    def __repr__(self):
        return f"PoleRegion(sigma={self.sigma}, theta={self.theta}, rho={self.rho})"


def _same(part):
    return part.name, part.alpha.tolist(), part.beta.tolist()


def _of_size_one(part):
    size = max(np.abs(part.alpha).max(), np.abs(part.beta).max())
    return part.alpha / size, part.beta / size


def _words(x):
    """A float with all its digits, but 5 instead of 5.0."""
    return repr(float(x)).removesuffix(".0")


def _degrees(sin, cos):
    """The angle that is proven, to a hundredth of a degree, rounded up."""
    angle = (arb(exact(float(sin))) / arb(exact(float(cos)))).atan()
    hundredths = int((angle * 18000 / arb.pi()).upper().ceil().unique_fmpz())
    return _words(hundredths / 100)


def _at_least(*factors):
    """A float that isn't below a product, as binary numbers and as decimals."""
    factors = [float(x) for x in factors]
    bound = float(np.prod(factors))
    for read in (Fraction, lambda x: Fraction(repr(x))):
        while read(bound) < prod(map(read, factors)):
            bound = float(np.nextafter(bound, np.inf))
    return bound


def _rows(x):
    return "[" + ", ".join("[" + ", ".join(r) + "]" for r in decimals(x)) + "]"


def _numerical_radius(beta):
    """The largest |x* beta x| over unit vectors x."""

    def height(angle):
        turned = np.exp(1j * angle) * beta
        return np.linalg.eigvalsh(turned + turned.conj().T)[-1] / 2

    grid = np.linspace(0, 2 * np.pi, 25)
    best = grid[np.argmax([height(a) for a in grid])]
    near = minimize_scalar(
        lambda a: -height(a),
        bounds=(best - 0.3, best + 0.3),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return max(height(best), -near.fun)
