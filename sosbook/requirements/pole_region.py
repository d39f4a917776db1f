"""Regions of the complex plane for closed-loop poles."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import minimize_scalar

from ..analysis.linear import poles
from ..plants.checks import matrix, number, positive
from ..theorems import pole_region, slack_pole_region
from .base import Requirement, sane_name
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
                    "parts must be LMIRegion objects, got "
                    f"{type(part).__name__}"
                )
            name, count = part.name, 1
            while name in names:
                count += 1
                name = f"{part.name}#{count}"
            names.add(name)
            if count > 1:
                part = LMIRegion(part.alpha, part.beta, name, part.text)
            parts.append(part)
        if not parts:
            raise ValueError("parts is empty: a region needs an LMIRegion")
        object.__setattr__(self, "parts", tuple(parts))

    def __and__(self, other):
        if not isinstance(other, Region):
            return NotImplemented
        return Region(self.parts + other.parts)

    def distances(self, poles):
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

    def contains(self, poles):
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
        The region in words, for certificates.

    Notes
    -----
    Source: Chilali and Gahinet (1996); thesis (A.7), (A.8).

    Examples
    --------
    >>> strip = LMIRegion.strip(-5, -1)
    >>> strip.contains([-2 + 3j, -2 - 3j]), strip.contains([-6])
    (True, False)
    """

    kind, promise, rank = "region", "poles", 12
    _again = None  # makes the same region with another bound

    def __init__(self, alpha, beta, name, text=None):
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

    @property
    def implies_stability(self):
        """Whether one scalar of it says Re s < -c with c >= 0."""
        return (
            self.alpha.shape == (1, 1)
            and self.alpha[0, 0] >= 0 and self.beta[0, 0] > 0
        )

    def _movable(self, parameter, bound, again, rank):
        for name, value in (("parameter", parameter), ("bound", bound),
                            ("_again", again), ("rank", rank)):
            object.__setattr__(self, name, value)
        return self

    @property
    def words(self):
        """The parameter's words, unless it has a name of its own."""
        named = self.name not in ("half-plane", "sector", "disk")
        return self.name if named or not self.parameter else super().words

    @property
    def titles(self):
        symbol = "" if self.words == self.name else f" {self.parameter.symbol}"
        return {"": self.name + symbol}

    def with_bound(self, bound):
        if self._again is None:
            return super().with_bound(bound)
        return self._again(bound)

    def contradicts(self, other):
        """A disk that lies right of a half-plane holds no pole of it."""
        if not (self._is_disk and isinstance(other, LMIRegion)
                and other.parameter is SIGMA):
            return False
        rho, shift = -self.alpha[0]
        return rho <= other.bound + shift

    def admits(self, s):
        return self.contains(s)

    def pair(self, loop, c):
        yield "", pole_region(
            c, loop.number(self.alpha), loop.number(self.beta))

    def slack(self, loop, c, i):
        yield "", slack_pole_region(
            c, loop.number(self.alpha), loop.number(self.beta), loop.epsilon)

    def claim(self):
        return f"its poles lie in the {self.text}"

    def truth(self, loops, K, K_A=None):
        """How far inside the worst pole lies, in rad/s: see `distances`."""
        spectra = np.array([poles(d, K) for d in loops])
        return self.distance(spectra).min()

    def kept(self, truth):
        return truth

    def rate(self):
        if self._is_disk:
            rho, shift = -self.alpha[0]
            return 0, rho / 2 + abs(shift)
        if self.implies_stability and self.alpha[0, 0] > 0:
            return 1, 2 * self.alpha[0, 0] / self.beta[0, 0]
        return None

    @property
    def _is_disk(self):
        return np.array_equal(self.beta, [[0, 1], [0, 0]])

    def characteristic(self, s):
        """The Hermitian matrices f(s) of (A.8), one for each pole."""
        s = np.asarray(s, complex)[..., None, None]
        return self.alpha + self.beta * s + self.beta.T * s.conj()

    def distance(self, poles):
        """See `Region.distances`."""
        top = np.linalg.eigvalsh(self.characteristic(poles))[..., -1]
        return -top / (2 * _numerical_radius(self.beta))

    @classmethod
    def half_plane(cls, sigma, name="half-plane"):
        """Re s < -sigma (2.18)."""
        alpha = [[2 * number("sigma", sigma)]]
        text = f"{name} Re s < {_words(0.0 - sigma)}"
        return cls(alpha, [[1]], name, text)._movable(
            SIGMA, float(sigma), partial(cls.half_plane, name=name), 10)

    @classmethod
    def sector(cls, theta, apex=0.0, name="sector"):
        """The cone |Im s| < (apex - Re s) tan(theta) (2.20), (A.15).

        ``theta`` is HALF the opening angle, in radians. The float pair
        (sin, cos) and the apex are rounded inwards: the region that is
        proven lies inside the region that is named.
        """
        theta = number("theta", theta)
        if not 0 < theta <= np.pi / 2:
            raise ValueError(
                f"theta = {theta} is outside (0, pi/2]: it is the "
                "half-angle of the sector, in radians"
            )
        sin = np.sin(theta) * (1 - 4 * np.finfo(float).eps)
        cos = np.cos(theta) * (1 + 4 * np.finfo(float).eps)
        beta = np.array([[sin, cos], [-cos, sin]])
        apex = number("apex", apex)
        alpha = np.nextafter(-2 * sin * apex, np.inf) if apex else 0.0
        text = f"{name} of half-angle {_degrees(theta)} degrees"
        if apex:
            text += f" with apex {_words(apex)}"
        return cls(alpha * np.eye(2), beta, name, text)._movable(
            THETA, theta, partial(cls.sector, apex=apex, name=name), 11)

    @classmethod
    def disk(cls, rho, centre=0.0, name="disk"):
        """|s - centre| < rho (2.19), (A.11)."""
        rho = positive("rho", rho)
        centre = number("centre", centre)
        alpha = [[-rho, -centre], [-centre, -rho]]
        text = f"{name} of radius {_words(rho)} around {_words(centre)}"
        return cls(alpha, [[0, 1], [0, 0]], name, text)._movable(
            RHO, rho, partial(cls.disk, centre=centre, name=name), 12)

    @classmethod
    def strip(cls, left, right, name="strip"):
        """left < Re s < right."""
        left, right = number("left", left), number("right", right)
        if left >= right:
            raise ValueError(f"left = {left} must be below right = {right}")
        alpha = np.diag([2 * left, -2 * right])
        text = f"{name} {_words(left)} < Re s < {_words(right)}"
        return cls(alpha, np.diag([-1, 1]), name, text)

    @classmethod
    def horizontal_strip(cls, omega, name="horizontal strip"):
        """|Im s| < omega."""
        omega = positive("omega", omega)
        text = f"{name} |Im s| < {_words(omega)}"
        return cls(-2 * omega * np.eye(2), [[0, 1], [-1, 0]], name, text)

    @classmethod
    def ellipse(cls, centre, a, b, name="ellipse"):
        """((Re s - centre) / a)^2 + (Im s / b)^2 < 1.

        The right-hand side is rounded down by more than the quotients
        on the left can be wrong, so that the region that is proven
        lies inside the region that is named.
        """
        centre = number("centre", centre)
        a, b = positive("a", a), positive("b", b)
        plus, minus = (1 / a + 1 / b) / 2, (1 / a - 1 / b) / 2
        error = 4 * np.finfo(float).eps * (
            1 + (1 / a + 1 / b) * (abs(centre) + a + b))
        if error > 1e-6:
            raise ValueError(
                f"the ellipse with half axes a = {a} and b = {b} around "
                f"centre = {centre} is too thin, or too small so far out, "
                "for floating point; take a disk or a strip"
            )
        alpha = [[error - 1, -centre / a], [-centre / a, error - 1]]
        text = (
            f"{name} of half axes {_words(a)} and {_words(b)} around "
            f"{_words(centre)}"
        )
        return cls(alpha, [[0, plus], [minus, 0]], name, text)


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

    def __init__(self, sigma=None, theta=None, rho=None):
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
                f"the region is empty: rho = {rho} must exceed "
                f"sigma = {sigma}"
            )
        for name, value in dict(
            sigma=sigma, theta=theta, rho=rho, parts=tuple(parts)
        ).items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(cls, parts):
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
        return (
            f"PoleRegion(sigma={self.sigma}, theta={self.theta}, "
            f"rho={self.rho})"
        )


def _same(part):
    return part.name, part.alpha.tolist(), part.beta.tolist()


def _words(x):
    """A float with all its digits, but 5 instead of 5.0."""
    return repr(float(x)).removesuffix(".0")


def _degrees(theta):
    """To four digits, rounded up: never more than is proven."""
    degrees = round(float(np.degrees(theta)), 10)
    return _words(round(np.ceil(degrees * 100) / 100, 2))


def _numerical_radius(beta):
    """The largest |x* beta x| over unit vectors x."""

    def height(angle):
        turned = np.exp(1j * angle) * beta
        return np.linalg.eigvalsh(turned + turned.conj().T)[-1] / 2

    grid = np.linspace(0, 2 * np.pi, 25)
    best = grid[np.argmax([height(a) for a in grid])]
    near = minimize_scalar(
        lambda a: -height(a), bounds=(best - 0.3, best + 0.3),
        method="bounded", options={"xatol": 1e-10},
    )
    return max(height(best), -near.fun)
