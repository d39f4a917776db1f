"""A chain that one force shakes and one motor holds: what no input takes away."""

import numpy as np

from ....bisection import lowest
from ....exact.definite import exact
from ....plants.controllability import fixed_part
from ....plants.descriptor import descriptors
from ....plants.second_order import SecondOrderSystem
from ....requirements.pole_region import PoleRegion
from ....synthesis.pid import design_pid
from ..page import matrices, significant
from .mover import Mover, choice, slider

BELOW = 0.999  # of what is left: refused there
ABOVE = 1.02, 1.05, 1.1, 1.2  # of it: designed for, the first that is proven
FASTEST = 40  # times the largest frequency: of a design's poles, which limits its gain
MATCHED = 0.01  # of the free motion: designed for where nothing is left
FREQUENCIES = 400  # of which the loudest is looked at closely
NONE = 1e-9  # of the free motion: that is left where the motor pushes as w does


def reach(plant, top):
    """A chain of masses; the reader picks the motor's place and a frequency.

    The page computes what the best input leaves at each frequency. What is refused
    and what can be kept is proven here, for each pair of places.

    ``plant``: with an input at each mass, and a disturbance at each; ``top``: the
    largest frequency, in rad/s.

    >>> one = np.eye(2)
    >>> chain = SecondOrderSystem(one, one, [[2, -1], [-1, 2]], one, one)
    >>> reach(chain, 5)
    Reach: motor, gust, omega, gamma
    """
    n = plant.n
    found = [[_found(plant, i, j, top) for j in range(n)] for i in range(n)]
    free = 1000 * max(pair["free"] for row in found for pair in row)
    start = round(found[n // 2][0]["at"], 1)
    names = [f"mass {k + 1}" for k in range(n)]
    return Mover(
        "reach",
        "What the motor can't help",
        "Drag the frequency: where does the motor in the middle stop nothing at all, "
        "and how do the masses move? Then put it elsewhere. Where is nothing left?",
        [
            choice("motor", "The motor u pushes", names, n // 2),
            choice("gust", "The disturbance w shakes", names),
            slider("omega", "Frequency ω", " rad/s", (0.1, top), 0.1, start),
            slider("gamma", "You ask for at most γ", " mm/N", (0.5, free), 0.5, 20),
        ],
        answer={"motor": 0},
        plant=matrices(plant, "MDS"),
        top=top,
        found=found,
    )


def _found(plant, i, j, top):
    """The proven bounds with the motor at mass i and the disturbance at mass j."""
    M, D, S, B, F = (getattr(plant, x) for x in "MDSBF")
    one = SecondOrderSystem(M, D, S, B[:, [i]], F[:, [j]])

    def sizes(omega):
        G = np.linalg.inv(S - omega**2 * M + 1j * omega * D)
        u, w = G @ B[:, i], G @ F[:, j]
        left = w - u * (u.conj() @ w) / (u.conj() @ u)
        return np.linalg.norm(w), np.linalg.norm(left)

    grid = np.linspace(0, top, FREQUENCIES)
    free, left = np.array([sizes(x) for x in grid]).T
    k, step = left.argmax(), grid[1]
    ends = max(0, grid[k] - step), grid[k] + step
    at, bound = lowest(lambda x: -sizes(x)[1], *ends, 1e-5)
    bound = -bound
    (d,) = descriptors(one)
    part = fixed_part(*map(exact, (d.E, d.A, d.Bu)))
    modes = [complex(x.ball(64)) for x in part.modes()]
    excluded, asked = 0.0, [MATCHED * free.max()]
    if bound <= NONE * free.max():
        at = 0.0  # nothing is left anywhere
    else:
        refused = design_pid(one, gamma=significant(BELOW * bound, 4))
        if refused.status == "infeasible" and refused.infeasibility.proven:
            excluded = refused.request.gamma
        asked = [x * bound for x in ABOVE]
    disk = PoleRegion(rho=FASTEST * top)
    designs = (design_pid(one, gamma=significant(x, 4), region=disk) for x in asked)
    reached = (
        d.gamma for d in designs if d.status == "feasible" and d.certify().proven
    )
    return {
        "free": significant(free.max(), 4),
        "excluded": excluded,
        "at": significant(at, 4),
        "reached": next(reached, None),
        "fixed": [[s.real, s.imag] for s in modes if s.imag >= 0],
    }
