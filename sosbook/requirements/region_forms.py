"""The well-known regions: how they are made, and what they are called.

A region is made of floats, while its claim is read as decimals. Both are rounded
inwards: the region that is proven lies inside the one that is named.
"""

from decimal import MAX_EMAX, MIN_EMIN, Context, Decimal, Inexact
from functools import reduce
from typing import Self

import numpy as np
from flint import arb, ctx, fmpq

from ..exact.rational import exact
from ..plants.checks import finite, positive
from ..runtime.read_only import put
from .vocabulary import RHO, SIGMA, THETA

BALL_BITS = 200  # of the angles of sectors
EXACT = Context(prec=4000, Emax=MAX_EMAX, Emin=MIN_EMIN, traps=[Inexact])


class RegionForms:
    """Constructors of an `LMIRegion`, which remembers its form."""

    _form = "matrices"  # which constructor made it, of what
    _sizes: dict[str, float] = {}

    @classmethod
    def half_plane(cls, sigma: float, name: str = "half-plane") -> Self:
        """Re s < -sigma (2.18), under a name."""
        alpha = [[at_least(2, finite("sigma", sigma))]]
        text = f"{name} Re s < {plain(0.0 - sigma)}"
        region = cls(alpha, [[1]], name, text)
        return region._made("half-plane", SIGMA, 10, sigma=float(sigma))

    @classmethod
    def sector(cls, theta: float, apex: float = 0.0, name: str = "sector") -> Self:
        """The cone with Im s between ± (apex - Re s) tan(theta) (2.20), (A.15).

        Messages know it by its name.

        ``theta`` is HALF the opening angle, in radians, and ``name`` tells
        the sector from others. The float pair
        (sin, cos) and the apex are rounded inwards: the region that is
        proven lies inside the region that is named.
        """
        theta = finite("theta", theta)
        if not 0 < theta <= np.pi / 2:
            raise ValueError(
                f"theta = {theta} is outside (0, pi/2]: it is the "
                "half-angle of the sector, in radians; PoleRegion takes "
                "degrees as theta_deg=..."
            )
        # files hold decimals
        angle = min(exact(theta), fmpq(*theta.as_integer_ratio()))
        with ctx.workprec(BALL_BITS):  # correctly rounded: the same on every machine
            sin, cos = (float(x.mid()) for x in arb(angle).sin_cos())
        sin *= 1 - 4 * np.finfo(float).eps
        cos *= 1 + 4 * np.finfo(float).eps
        beta = np.array([[sin, cos], [-cos, sin]])
        apex = finite("apex", apex)
        alpha = at_least(-2, sin, apex)
        text = f"{name} of half-angle {degrees(sin, cos)} degrees"
        if apex:
            text += f" with apex {plain(apex)}"
        region = cls(alpha * np.eye(2), beta, name, text)
        return region._made("sector", THETA, 11, theta=theta, apex=apex)

    @classmethod
    def disk(cls, rho: float, centre: float = 0.0, name: str = "disk") -> Self:
        """|s - centre| < rho (2.19), (A.11), under a name."""
        rho = positive("rho", rho)
        centre = finite("centre", centre)
        alpha = [[-rho, -centre], [-centre, -rho]]
        text = f"{name} of radius {plain(rho)} around {plain(centre)}"
        region = cls(alpha, [[0, 1], [0, 0]], name, text)
        return region._made("disk", RHO, 12, rho=rho, centre=centre)

    @classmethod
    def strip(cls, left: float, right: float, name: str = "strip") -> Self:
        """left < Re s < right, under a name."""
        left, right = finite("left", left), finite("right", right)
        if left >= right:
            raise ValueError(f"left = {left} must be below right = {right}")
        alpha = np.diag([at_least(2, left), at_least(-2, right)])
        text = f"{name} {plain(left)} < Re s < {plain(right)}"
        region = cls(alpha, np.diag([-1, 1]), name, text)
        return region._made("strip", left=left, right=right)

    @classmethod
    def horizontal_strip(cls, omega: float, name: str = "horizontal strip") -> Self:
        """-omega < Im s < omega, under a name."""
        omega = positive("omega", omega)
        text = f"{name} |Im s| < {plain(omega)}"
        alpha = at_least(-2, omega) * np.eye(2)
        region = cls(alpha, [[0, 1], [-1, 0]], name, text)
        return region._made("horizontal strip", omega=omega)

    @classmethod
    def ellipse(cls, centre: float, a: float, b: float, name: str = "ellipse") -> Self:
        """((Re s - centre) / a)^2 + (Im s / b)^2 < 1, under a name.

        The right-hand side is rounded down by more than the quotients
        on the left can be wrong, so that the region that is proven
        lies inside the region that is named. The matrices are those of
        a disk where a = b, and alpha alone has a unit: the LMIs with a
        slack matrix depend on it.
        """
        centre = finite("centre", centre)
        a, b = positive("a", a), positive("b", b)
        error = 4 * np.finfo(float).eps * (1 + (1 / a + 1 / b) * (abs(centre) + a + b))
        if error > 1e-6:
            raise ValueError(
                f"the ellipse with half axes a = {a} and b = {b} around "
                f"centre = {centre} is too thin, or too small so far out, "
                "for floating point; take a disk or a strip"
            )
        size, middle = 2 * a * b / (a + b), 2 * b * centre / (a + b)
        alpha = [[size * (error - 1), -middle], [-middle, size * (error - 1)]]
        beta = [[0, 1], [(b - a) / (a + b), 0]]  # of no unit, as a disk's
        text = f"{name} of half axes {plain(a)} and {plain(b)} around {plain(centre)}"
        region = cls(alpha, beta, name, text)
        return region._made("ellipse", centre=centre, a=a, b=b)

    def _made(self, form, parameter=None, rank=None, **sizes):
        """Remember the constructor, for proofs, and the parameter of its bound."""
        put(self, _form=form, _sizes=sizes)
        if parameter is not None:
            put(self, parameter=parameter, bound=sizes[parameter.key], rank=rank)
        return self

    @classmethod
    def _of_form(cls, form, sizes, name):
        """The region that the constructor of a form makes."""
        make = form.replace("-", "_").replace(" ", "_")
        return getattr(cls, make)(**sizes, name=name)

    @property
    def circle(self) -> tuple[float, float] | None:
        """(centre, radius) of a disk, None of other regions."""
        if self._form != "disk":
            return None
        return self._sizes["centre"], float(self.bound)

    def bound_of(self, poles: np.ndarray) -> float:
        """The bound with which the outermost of some poles lies on the boundary."""
        if self.parameter is SIGMA:
            return float(-poles.real.max())
        if self.parameter is RHO:
            return float(np.abs(poles - self._sizes["centre"]).max())
        left = self._sizes["apex"] - poles.real
        return float(np.arctan2(np.abs(poles.imag), left).max())

    def claim(self) -> str:
        """The form in words, which the matrices imply, or the matrices."""
        from ..exact.checker.requirements import claim

        return claim(self.data())


def plain(x):
    """A float x with all its digits, but 5 instead of 5.0."""
    return repr(float(x)).removesuffix(".0")


def degrees(sin, cos):
    """The angle, between 0 and 90 degrees, of these floats ``sin`` and ``cos``, in
    degrees, as text, rounded up to a hundredth: the words never promise more than is
    proven.

    >>> degrees(0.6, 0.8)
    '36.87'
    """
    with ctx.workprec(BALL_BITS):
        angle = (arb(exact(float(sin))) / arb(exact(float(cos)))).atan()
        hundredths = int((angle * 18000 / arb.pi()).upper().ceil().unique_fmpz())
    return plain(hundredths / 100)


def at_least(*factors):
    """A float that isn't below a product, as binary numbers and as decimals."""
    factors = [float(x) for x in factors]
    bound = float(np.prod(factors))
    for read in (Decimal, lambda x: Decimal(repr(x))):
        product = reduce(EXACT.multiply, map(read, factors))
        while read(bound) < product:
            bound = float(np.nextafter(bound, np.inf))
    return bound
