"""The pendulums that two uncertain experiments allow."""

from dataclasses import replace

import numpy as np

from ..plants.checks import finite
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import Polytope
from .fit_spread import FitSpread
from .model import Mip  # noqa: F401 (for the examples)

__all__ = ["polytope", "reduced", "spread_words", "triangles", "vertices"]


def vertices(mip, spread=0.04):
    """Four pendulums: e/c and e/a off by the spread, either way.

    Parameters
    ----------
    mip : Mip
        The one in the middle, with I_w.
    spread : float or FitSpread
        The relative spread, between 0 and 1; or what a fit allows.

    Returns
    -------
    tuple of Mip
        In the order of (4.25): (e/c, e/a) times (1 - s, 1 - s),
        (1 - s, 1 + s), (1 + s, 1 - s), (1 + s, 1 + s). Of a `FitSpread` its 16.

    Raises
    ------
    ValueError
        If mip has no I_w, or the spread isn't in [0, 1).

    Examples
    --------
    >>> [round(1e3 * v.a, 4) for v in vertices(Mip.printed())]
    [0.4747, 0.4639, 0.4865, 0.4747]
    """
    if mip.I_w is None:
        raise ValueError(
            "mip has no I_w: give the inertia of a wheel with its gears, the part of a "
            "that the spread moves, as Mip.printed() has it"
        )
    if isinstance(spread, FitSpread):
        return spread.vertices(mip)
    if not 0 <= finite("spread", spread) < 1:
        raise ValueError(f"spread must lie in [0, 1), got {spread!r}")
    return tuple(
        scaled(mip, body, wheels)
        for body in (1 - spread, 1 + spread)
        for wheels in (1 - spread, 1 + spread)
    )


def scaled(mip, body, wheels):
    """A pendulum with e/c and e/a times so much; J, if any, moves with 2 I_w."""
    I_w = mip.I_w * body / wheels
    more = 2 * (I_w - mip.I_w)
    J = mip.J + more if mip.J else 0.0
    return replace(mip, a=mip.a + more, e=mip.e * body, I_w=I_w, J=J)


def polytope(mip, spread=0.04):
    """The plants of `vertices`, and all between them.

    M, D, S and B are affine in (I_w, e), and the pairs (I_w, e) that
    the two spreads allow fill a quadrilateral: the polytope holds just
    the plants it is meant to hold. `Mip.printed_form`, quadratic in
    them, hasn't this property.

    Parameters
    ----------
    mip, spread
        As for `vertices`.

    Returns
    -------
    Polytope
        A polytope with four vertices, or the box of a `FitSpread`.

    Notes
    -----
    Source: thesis (4.25), in the natural form of `Mip.plant`.

    Examples
    --------
    >>> polytope(Mip.printed()).N
    4
    """
    several = vertices(mip, spread)
    if isinstance(spread, FitSpread):
        return spread.plants(mip)
    return Polytope([v.plant() for v in several])


def triangles(mip, spread=0.04):
    """Two polytopes of three vertices that cover `polytope`.

    The four vertices lie in a plane, that of (I_w, e), so two triangles
    hold all the plants between them, and with fewer weights.

    Parameters
    ----------
    mip, spread
        As for `vertices`.

    Returns
    -------
    tuple of Polytope
        The triangles of the vertices 1, 4, 2 and 1, 4, 3. Of a `FitSpread` the box
        alone.

    Examples
    --------
    >>> [part.N for part in triangles(Mip.printed())]
    [3, 3]
    """
    whole = polytope(mip, spread)
    if isinstance(spread, FitSpread):
        return (whole,)
    plants = whole.vertices
    return tuple(Polytope([plants[0], plants[3], plants[k]]) for k in (1, 2))


def spread_words(spread):
    """A ``spread``, a number or a `FitSpread`, in a sentence."""
    if not isinstance(spread, FitSpread):
        return f"e/c and e/a off by {100 * spread:g} %, either way"
    return (
        "c, e, f and I_w in a box that holds them, all at once, with "
        f"{100 * spread.confidence:g} % (normal errors to first order, their "
        "covariance widened by the misfit; masses, lengths and g exact): along the "
        f"covariance's axes {spread.radius:.3g} standard deviations either way; it "
        f"reaches {', '.join(spread.reached)}"
    )


def reduced(mip, spread=0.04):
    """The plants of `polytope` without the wheels' angle.

    Two rates are measured, from which phi can't be observed: nothing in
    the equations of motion depends on it. What remains fits no
    second-order form.

    Parameters
    ----------
    mip, spread
        As for `vertices`.

    Returns
    -------
    DescriptorSystem
        It has a vertex for each of `vertices`; the state is [theta;
        theta'; phi'], the outputs are theta' and phi', and w is one
        torque on both equations of motion, as in `Mip.plant`.

    Notes
    -----
    Source: thesis (4.27), in the natural form of `Mip.plant`.

    Examples
    --------
    >>> plant = reduced(Mip.printed())
    >>> plant.order, len(plant.vertices), plant.n
    (3, 4, 2)
    """
    E, A, B, B_w = [], [], [], []
    for robot in vertices(mip, spread):
        plant, inertia = robot.plant(), np.eye(3)
        inertia[1:, 1:] = plant.M
        E.append(inertia)
        A.append(np.vstack([[0, 1, 0], np.hstack([-plant.S[:, :1], -plant.D])]))
        B.append(np.vstack([[[0]], plant.B]))
        B_w.append(np.vstack([[[0]], plant.F]))
    return DescriptorSystem(E, A, B, B_w, [[0, 1, 0], [0, 0, 1]])
