"""How a robot with two wheels turns: the plants behind its heading.

The wheels' difference delta = phi_R - phi_L says where the robot heads:
psi = r delta / track, positive to the left. With half the voltages' difference
W = V_R - V_L more on the right and less on the left, equal motors leave the
sum of both torques as it is: balancing doesn't notice.
"""

from itertools import product

import numpy as np

from ..plants.second_order import Polytope, SecondOrderSystem
from .model import COORDINATES
from .spread import vertices

__all__ = ["inertia_bounds", "turning_plants", "unequal_plant"]


def inertia_bounds(mip, robot):
    """Least and largest a_d of a_d delta'' + f delta' = e W, in kg m^2.

    Virtual work gives a_d = 4 (I_z + M_w track^2 / 2) (r / track)^2 + 2 I_w,
    with I_z the body's inertia about the vertical. Without the robot's
    ``turning`` I_z lies between zero and M_b (track / 2)^2, that of a body
    whose mass lies within the circle through both wheels: then a_d is at
    least 2 M_w r^2 + 2 I_w, and at most the pendulum's a.

    ``mip``: the pendulum, with its I_w; ``robot``: its masses and lengths.
    """
    body = robot.turning or (0.0, robot.M_b * (robot.track / 2) ** 2)
    scale = 4 * (robot.r / robot.track) ** 2
    wheels = 2 * robot.M_w * robot.r**2 + 2 * mip.I_w
    return tuple(scale * I_z + wheels for I_z in body)


def turning_plants(mip, robot, spread=0.04):
    """How the robot turns: two polytopes that cover all allowed plants.

    The plant is (a_d / e) delta'' + (f / e) delta' = W, and the two quotients
    fill a rectangle, of which each polytope is a half.

    ``mip``: the pendulum in the middle, with its I_w; ``robot``: the robot's
    description, with its track; ``spread``: as for `polytope`, whose pendulums'
    quotients the rectangle holds. Returns the rectangle, then its two triangles.
    """
    if mip.I_w is None:
        raise ValueError(
            "mip has no I_w: give the inertia of a wheel with its gears, as "
            "Mip.printed() has it"
        )
    if robot.track is None:
        raise ValueError(
            "the robot has no track: give the distance between its wheels, in m"
        )
    around = vertices(mip, spread)
    quotients = [x / m.e for m in around for x in inertia_bounds(m, robot)]
    inertia = min(quotients), max(quotients)
    damping = min(m.f / m.e for m in around), max(m.f / m.e for m in around)
    plants = [
        SecondOrderSystem([[m]], [[d]], [[0]], B=[[1]], coordinates=("delta",))
        for m, d in product(inertia, damping)
    ]
    parts = (0, 1, 2, 3), (0, 3, 1), (0, 3, 2)
    return tuple(Polytope([plants[k] for k in part]) for part in parts)


def unequal_plant(mip, inertia, more, crossed):
    """The plant of z = [theta, phi, delta] and u = [V, W] with unequal motors.

    ``mip``: the pendulum, with the sums e and f of both motors; ``inertia``: as in
    `inertia_bounds`, in kg m^2; ``more``, ``crossed``: the right motor's e and f are
    larger by these shares than the mean, and the left's smaller. Returns
    SecondOrderSystem: with three angles and two voltages.
    """
    two, e, f = mip.plant(), mip.e, mip.f
    M, D, S = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    M[:2, :2], M[2, 2] = two.M, inertia
    D[:2, :2], D[2, 2] = two.D, f
    D[:2, 2] = -f * crossed / 2, f * crossed / 2
    D[2, :2] = -2 * f * crossed, 2 * f * crossed
    S[:2, :2] = two.S
    B = [[-e, -e * more / 2], [e, e * more / 2], [2 * e * more, e]]
    return SecondOrderSystem(M, D, S, B=B, coordinates=(*COORDINATES, "delta"))
