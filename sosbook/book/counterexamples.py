"""Where checking the vertices isn't enough.

A(a) P E(a)^T is quadratic in the weights a: with an uncertain E the
theorems' LMIs can hold at both vertices while a plant between them is
unstable, or has left the region.
"""

import numpy as np

from ..plants.checks import positive
from ..plants.descriptor import Descriptor
from ..plants.second_order import Polytope, SecondOrderSystem

__all__ = [
    "actuated",
    "mechanical",
    "misprint",
    "random_chain",
    "random_pair",
    "rotation",
    "slower_corners",
    "turn",
]


def misprint(name):
    """A `DelayRequest` for an unstable loop, with a root in the right half-plane for
    its longest delay, that Theorem A.3 accepts with the misprint ``name``, one of
    "sign", "transpose" and "alpha" of `sosbook.theorems.delay_decay`.

    >>> from sosbook.delay import solve_delay
    >>> solve_delay(misprint("sign")).status
    'feasible'
    """
    from ..delay import DelayedLoop, DelayRequest

    loops = {
        "sign": dict(plant=DelayedLoop([[1]], [[-0.1]]), mu=0.5, delta=0.1),
        "transpose": dict(plant=DelayedLoop([[0, 3], [-1, 1]], np.zeros((2, 2)))),
        "alpha": dict(plant=DelayedLoop([[0]], [[-1]]), mu=1.0, alpha=0.01),
    }
    if name not in loops:
        raise ValueError(f"name must be one of {', '.join(loops)}, got {name!r}")
    return DelayRequest(tau=1.0, misprints=(name,), **loops[name])


def rotation():
    """Two first-order systems E x' = A x, and P = I: at both vertices A P E^T + E P A^T
    = -0.2 I; halfway the eigenvalues of E^-1 A are 4.9 +- 5j.
    """
    S = np.array([[0.0, -1.0], [1.0, 0.0]])
    first = _uncontrolled(np.eye(2), -0.1 * np.eye(2) + 10 * S)
    second = _uncontrolled(S, -0.1 * S)
    return (first, second), np.eye(2)


def turn():
    """Two systems E x' = -x that differ in E only, and P = I: the second E is a
    rotation by 53 degrees (cosine 3/5). At both vertices all poles have modulus one;
    halfway it is 1.118. Every disk LMI with rho > 1 holds at both vertices with P = I.
    """
    turned = np.array([[0.6, -0.8], [0.8, 0.6]])
    first = _uncontrolled(np.eye(2), -np.eye(2))
    return (first, _uncontrolled(turned, -np.eye(2))), np.eye(2)


def _uncontrolled(E, A):
    nothing = np.zeros((len(E), 1))
    return Descriptor(E, A, nothing, nothing, np.eye(len(E)))


def mechanical():
    """A mechanical polytope with positive definite masses, and its P, (4, 4): (2.18)
    with sigma = 0 and K = 0 holds strictly at both vertices with it; the plant halfway
    has a pole near +3.91.
    """
    B = np.zeros((2, 1))
    first = SecondOrderSystem(
        M=np.diag([1.8, 0.2]),
        D=[[-3.6, 6.4], [-3, 0.7]],
        S=[[-0.2, 2.9], [-2.5, 0.8]],
        B=B,
    )
    second = SecondOrderSystem(
        M=np.diag([0.2, 1.8]), D=[[0.7, -0.3], [7.9, -0.9]], S=[[1, 0], [9.2, 3.9]], B=B
    )
    P = np.array(
        [
            [0.31, 0.11, -0.27, -0.02],
            [0.11, 1.24, -0.09, -0.44],
            [-0.27, -0.09, 1.02, 0.67],
            [-0.02, -0.44, 0.67, 3.43],
        ]
    )
    return Polytope([first, second]), P


def actuated():
    """The polytope of `mechanical` with a force on each mass, B = F = I: it can be
    stabilised as a whole, yet a design at the vertices may miss the plants between.
    """
    plants, _ = mechanical()
    one = np.eye(2)
    return Polytope(
        [SecondOrderSystem(v.M, v.D, v.S, one, one) for v in plants.vertices]
    )


def slower_corners():
    """A mechanical polytope in which only the mass varies; no input. Both masses are
    positive definite, all plants are stable. At the vertices the fastest pole has
    modulus 16.5 and 15.8, and one P proves the disk of radius 17 at both; between them
    it is 18.2.
    """
    D, S = [[6.28, -3.62], [3.47, 0.07]], [[1.15, 0.87], [-0.27, 2.69]]
    masses = [[0.39, 0.3], [0.3, 3.29]], [[0.32, 0.14], [0.14, 0.22]]
    return Polytope([SecondOrderSystem(M, D, S, np.zeros((2, 1))) for M in masses])


def random_chain(seed, masses=2, spread=0.3, box=True):
    """Some ``masses`` between two walls, each within 1 -+ ``spread`` of its nominal
    value, as a Polytope: all corners of the ``box``, or two, the odd masses light while
    the even ones are heavy and the converse. A force acts on each mass, the disturbance
    on the last one; the ``seed`` draws springs and dampers.
    """
    if positive("spread", spread) >= 1:
        raise ValueError(f"spread must be below one, got {spread!r}")
    rng = np.random.default_rng(seed)
    nominal = rng.uniform(0.5, 2, masses).round(2)
    springs = rng.uniform(1, 5, masses + 1).round(2)
    dampers = rng.uniform(0, 0.3, masses + 1).round(2)
    if box:
        signs = [
            [1 - 2 * (k >> i & 1) for i in range(masses)] for k in range(2**masses)
        ]
    else:
        pattern = (-1) ** np.arange(masses)
        signs = [pattern, -pattern]
    one, D, S = np.eye(masses), _links(dampers), _links(springs)
    M = [np.diag(nominal * (1 + spread * np.asarray(s))) for s in signs]
    return Polytope([SecondOrderSystem(m, D, S, one, one[:, -1:]) for m in M])


def _links(k):
    """Stiffness matrix of springs wall - 1 - 2 - ... - wall."""
    return np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)


def random_pair(seed, ratio=16.0):
    """A Polytope of two unrelated plants with two degrees of freedom, a force on each;
    the ``seed`` draws them. M is positive definite with principal masses in the
    ``ratio``, in a random frame; D and S are any: nothing makes these plants stable.
    """
    rng = np.random.default_rng(seed)
    vertices = []
    for _ in range(2):
        angle = rng.uniform(0, np.pi)
        cos, sin = np.cos(angle), np.sin(angle)
        frame = np.array([[cos, -sin], [sin, cos]])
        M = frame @ np.diag([1, positive("ratio", ratio)]) @ frame.T
        M = (M * rng.uniform(0.5, 1.5)).round(2)
        D = (2 * rng.standard_normal((2, 2))).round(1)
        S = (3 * rng.standard_normal((2, 2))).round(1)
        vertices.append(SecondOrderSystem(M, D, S, np.eye(2), np.eye(2)))
    return Polytope(vertices)
