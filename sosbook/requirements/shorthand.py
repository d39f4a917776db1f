"""The keywords of the design functions as requirements, and back again."""

import numpy as np

from .base import Requirement
from .channel import Channel
from .cost import QuadraticCost
from .hinf import HInfinity
from .input_bound import Saturation
from .pole_region import LMIRegion, PoleRegion, Region
from .vocabulary import PARAMETERS

KEYWORDS = ("region", "gamma", "saturation", "requirements")
NAMED = Channel, Saturation  # of which a request may have more than one, by name
NOT_GIVEN = object()  # a keyword that was left out, unlike one that is None


def collected(
    region=NOT_GIVEN, gamma=NOT_GIVEN, saturation=NOT_GIVEN, *, requirements=()
):
    """Keywords and requirement objects as one tuple, in the order of their ranks.
    ``region``, ``gamma`` and ``saturation`` take the place of what ``requirements``
    holds of their kind, and None leaves that out; a number ``gamma`` keeps the mu of
    an `HInfinity` there. Raises ValueError if an argument isn't what its name says, or
    two requirements of one kind have one name.
    """
    chosen = []
    try:
        requirements = tuple(requirements)
    except TypeError:
        raise ValueError(
            "requirements must be a sequence of requirements, got "
            f"{type(requirements).__name__}"
        ) from None
    for r in requirements:
        if isinstance(r, (Region, Saturation)) and not isinstance(r, LMIRegion):
            chosen.extend(r.parts)
        elif isinstance(r, Requirement):
            chosen.append(r)
        else:
            raise ValueError(
                f"requirements must hold Requirement objects, got {type(r).__name__}"
            )
    fresh = {}  # what takes the place of others of its kind
    if region is not NOT_GIVEN:
        if not isinstance(region, (Region, type(None))):
            raise ValueError(
                "region must be a PoleRegion or an LMIRegion, got "
                f"{type(region).__name__}"
            )
        fresh[LMIRegion] = () if region is None else region.parts
    if gamma is not NOT_GIVEN:
        if gamma is not None and not isinstance(gamma, HInfinity):
            mu = next((r.mu for r in chosen if _is(r, HInfinity)), None)
            gamma = HInfinity(gamma, mu)
        fresh[HInfinity] = () if gamma is None else (gamma,)
    if saturation is not NOT_GIVEN:
        if not isinstance(saturation, (Saturation, type(None))):
            raise ValueError("saturation must be a Saturation(u_max, x0)")
        fresh[Saturation] = () if saturation is None else saturation.parts
    chosen = [r for r in chosen if not any(_is(r, kind) for kind in fresh)]
    chosen += [r for some in fresh.values() for r in some]
    keys = [r.key for r in chosen]
    for key in keys:
        if keys.count(key) > 1:
            raise ValueError(
                f"two requirements are called {' '.join(dict.fromkeys(key))}: "
                + next(r.of_two for r in chosen if r.key == key)
            )
    return _in_order(chosen)


def asked_once(*, requirements=(), **keywords):
    """`collected`, of a user who must not ask anything in two places: raises
    ValueError, too, if one of the ``keywords`` asks for what is among the
    ``requirements``, for one of the two would be dropped.
    """
    among = {_place(r) for r in collected(requirements=requirements)}
    for name, value in keywords.items():
        if among & {_place(r) for r in collected(**{name: value})}:
            raise ValueError(
                f"{name} is given, and requirements holds a requirement of that kind: "
                "ask for it in one place"
            )
    return collected(**keywords, requirements=requirements)


def _is(r, kind):
    """True if r is what the keyword of its kind asks, and has no name of its own."""
    return isinstance(r, kind) and not (isinstance(r, NAMED) and r.named)


def _place(r):
    """The key that may come once: of bounds of a norm or an input, its name."""
    return r.key if isinstance(r, NAMED) else r.kind


def no_requirement(name, value):
    """Refuse a ``value`` that is a requirement in the place of a matrix, ``name``."""
    if isinstance(value, (Requirement, Region)):
        raise ValueError(
            f"{name} must be a matrix that picks the integrated errors, got "
            f"{type(value).__name__}: give requirements by name, as in region=..."
        )


def _in_order(requirements):
    return tuple(sorted(requirements, key=lambda r: r.rank))


MAKERS = {
    "sigma": lambda value: PoleRegion(sigma=value).parts[0],
    "theta": lambda value: PoleRegion(theta=value).parts[0],
    "rho": lambda value: PoleRegion(rho=value).parts[0],
    "gamma": HInfinity,
}


def parameter(name, requirements=()):
    """The `Parameter` of a name: of these requirements or a known one."""
    for r in requirements:
        if r.parameter is not None and r.parameter.key == name:
            return r.parameter
    if name not in PARAMETERS:
        raise ValueError(f"name = {name!r} must be one of {', '.join(PARAMETERS)}")
    return PARAMETERS[name]


def bounds(requirements):
    """The bounds of some requirements, by the names of what can be moved."""
    by_name = {}
    for r in requirements:
        if r.parameter is not None:
            by_name.setdefault(r.parameter.key, []).append(r.bound)
    return {
        name: values[0]
        for name, values in by_name.items()
        if len(values) == 1 and values[0]
    }


def moved(requirements, values):
    """The ``requirements`` with the bounds ``values``, by the parameters' names; what
    is missing joins them.
    """
    chosen = list(requirements)
    for name, value in values.items():
        places = [
            k
            for k, r in enumerate(chosen)
            if r.parameter is not None and r.parameter.key == name
        ]
        if len(places) > 1:
            raise ValueError(
                f"{name} belongs to {len(places)} requirements: which one "
                "is meant isn't clear"
            )
        if places:
            chosen[places[0]] = chosen[places[0]].with_bound(value)
            continue
        which = parameter(name)
        if name not in MAKERS:
            raise ValueError(f"{name} needs {which.needs}")
        chosen.append(MAKERS[name](value))
    return _in_order(chosen)


def contradictory(requirements):
    """True if two of some requirements exclude each other at sight."""
    return any(a.contradicts(b) for a in requirements for b in requirements)


class Shorthand:
    """The requirements by keyword, read from ``requirements``."""

    def _one(self, kind):
        return next((r for r in self.requirements if _is(r, kind)), None)

    @property
    def parts(self):
        """The parts of the region."""
        return tuple(r for r in self.requirements if isinstance(r, LMIRegion))

    @property
    def region(self):
        """Where the poles must lie, those of ticks as z; None if nothing is said."""
        parts = [getattr(part, "of_z", part) for part in self.parts]
        return PoleRegion.of(parts) if parts else None

    @property
    def gamma(self):
        """The bound of the H-infinity norm, or None."""
        hinf = self._one(HInfinity)
        return None if hinf is None else hinf.gamma

    @property
    def mu(self):
        """The scalar of Theorem 2.1 where it was given; None if it is free."""
        hinf = self._one(HInfinity)
        return None if hinf is None else hinf.mu

    def mu_of(self, own):
        """The scalar of Theorem 2.1 at the unknowns ``own`` of a solution; 1 where
        nothing else fixes the size of P.
        """
        hinf = self._one(HInfinity)
        if hinf is None:
            return 1.0
        if hinf.mu is not None:
            return hinf.mu
        size = (own or {}).get(hinf.size_name)
        return 1.0 if size is None else 1 / np.asarray(size).item()

    @property
    def saturation(self):
        """The bound of the input, or None."""
        return self._one(Saturation)

    @property
    def cost(self):
        """The quadratic cost, or None."""
        return self._one(QuadraticCost)
