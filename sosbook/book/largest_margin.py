r"""The point that LMI Lab's ``feasp`` works towards: the largest margin.

The thesis's solver minimises t under L(x) <= t I and a bound on the length
of x, the list of all free entries of the unknowns. In the book's signs it
maximises t under

.. math::

    G_k(x) \succeq t I, \qquad \|x\| \le R .

Where all blocks are homogeneous (no norm bound, no input bound) the
direction of the best x doesn't depend on R: it is that of the shortest x
with all :math:`G_k(x) \succeq I`. This problem is strictly convex, so there
is one such x and one gain. It depends on the units of the data and on how
the blocks are written. `region_margin` and `delay_margin` write them as the
thesis does, in its units.

The optimum is computed to many digits here. By its manual ``feasp`` stops as
soon as t is positive, unless it is told to go on, so its answer may differ.
"""

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from ..language import Unknown
from ..plants.checks import finite, positive
from ..plants.descriptor import Descriptor, descriptors
from ..plants.second_order import Polytope, SecondOrderSystem
from ..runtime.libraries import library
from ..solver.blocks import Blocks
from ..solver.bounded import unpacked
from ..solver.deepest import deepest
from ..synthesis.request import Request
from ..theorems import Functional, Times, delay_functional, delay_stabilization

__all__ = ["LargestMargin", "delay_margin", "largest_margin", "region_margin"]

AGREEMENT_TOLERANCE = 1e-6  # relative: two rounds give the same point
MOST_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class LargestMargin:
    """The point of the largest margin of homogeneous LMIs.

    ``values``: from an unknown's name to its matrix, scaled such that t = 1;
    ``length``: the Euclidean length of x, the list of the unknowns' free entries, for
    these values. The largest t under ``|x| <= R`` is ``R / length``; ``margin``: the
    smallest eigenvalue of all blocks, computed again; 1 up to rounding errors; ``K``,
    (m, N): the gain, where the unknowns have one.
    """

    values: dict
    length: float
    margin: float
    K: np.ndarray | None = None


def largest_margin(expressions, unknowns):
    """The point of the largest margin under a bound on its length.

    ``expressions``: homogeneous blocks; each is symmetric whatever the unknowns are;
    ``unknowns``: what they are affine in. Of a symmetric one the entries on and below
    the diagonal count, once each. Returns the point, with t = 1. Raises ValueError if a
    block has a constant term, or if no point is inside; RuntimeError if the rounds
    don't agree.

    Clarabel minimises the length of x in coordinates in which the point of
    the round before looks like the identity, block by block; the first
    point is the deepest one. Without that its answers have two digits. The
    rounds end with one that agrees with the last one, or with the shortest
    one: some have worse last digits than others.

    Stability of x' = -a x: the shortest p with p >= 1 and 2 a p >= 1.

    >>> from sosbook.lmi import Unknown, he
    >>> P = Unknown("P", 1, symmetric=True)
    >>> shortest = largest_margin([P @ np.eye(1), he(np.array([[0.1]]) @ P)], [P])
    >>> round(shortest.length, 4)
    5.0
    """
    blocks = Blocks(expressions, unknowns)
    start = deepest(blocks)
    x = _inside(blocks, start.x)
    if x is None:
        raise ValueError("no point is inside the blocks: is the request feasible?")
    best = x
    for _ in range(MOST_ROUNDS):
        earlier, x = (x, best), _shortest(blocks, x)
        apart = min(np.linalg.norm(x - y) for y in earlier)
        best = min(x, best, key=np.linalg.norm)
        if apart < AGREEMENT_TOLERANCE * np.linalg.norm(x):
            break
    else:
        raise RuntimeError("the rounds don't agree: the optimum is known to no digit")
    return LargestMargin(
        unpacked(unknowns, x), float(np.linalg.norm(x)), _least(blocks, x)
    )


def region_margin(example):
    """The largest margin of an example whose request is a region alone.

    ``example``: with a plant and requirements, as `thesis.example_4`. Returns
    LargestMargin: with the gain ``K = Y inv(P)``. All blocks are those of thesis (2.18)
    to (2.20) at the vertices, and P > 0. Raises ValueError if gamma or an input bound
    is asked too: then the blocks have constants, which bound t whatever the length.
    """
    request = Request(example.plant, **example.requirements)
    if request.sizes.fixing:
        names = " and ".join(r.name for r in request.sizes.fixing)
        raise ValueError(
            f"example asks for {names} too: its blocks have constants, which "
            "bound the margin whatever the length; ask for a region alone"
        )
    expressions, unknowns = request.in_unknowns(None)
    deepest = largest_margin(expressions.values(), unknowns)
    P, Y = deepest.values["P"], deepest.values["Y"]
    return replace(deepest, K=np.linalg.solve(P, Y.T).T)


def delay_margin(example, mu=None, second=1.0, misprints=()):
    """The `LargestMargin` of an ``example`` with a delayed input, by (2.22) to (2.25),
    corrected but for the ``misprints``: {"sign"}; ``K = X inv(F')`` in its units.
    ``mu``, in s, is another tolerance of the delay; ``second`` is how many units of
    time make a second. Raises ValueError without a point inside, RuntimeError as
    `largest_margin`.
    """
    if not {"sign"}.issuperset(misprints):
        raise ValueError(f'misprints may hold "sign", got {misprints!r}')
    mu = example.mu if mu is None else finite("mu", mu)
    second = positive("second", second)
    vertices, units = _in_time(example, second)
    tau, mu, alpha = (second * x for x in (example.tau, mu, example.alpha))
    rate = example.delta / second
    clock = Times(
        tau, mu, rate, np.exp(-2 * rate * tau) / tau, np.exp(-2 * rate * (tau + mu))
    )
    N, m = vertices[0].Bu.shape
    names = ("P", "S", "R1", "R3", "Z")[: 5 if mu else 4]
    symmetric = {n: Unknown(n, N, symmetric=True) for n in names}
    Q, R2, F, X = (*(Unknown(n, N) for n in ("Q", "R2", "F")), Unknown("X", m, N))
    v = Functional(Q=Q, R2=R2, **({"Z": np.zeros((N, N))} | symmetric))
    expressions = list(delay_functional(v, clock))
    for d in vertices:
        A, Bu, _ = d.state_space()
        standard = Descriptor(np.eye(N), A, Bu, d.Bw, d.C)
        g = delay_stabilization(standard, v, F, X, clock, alpha, misprints)
        I = np.eye(N)  # block 5 comes divided by mu from both sides
        T = block_diag(*([d.E, d.E, I, I, mu * I][: 5 if mu else 4]))
        expressions.append(T @ g @ T.T)
    deepest = largest_margin(expressions, [*symmetric.values(), Q, R2, F, X])
    gain = np.linalg.solve(deepest.values["F"], deepest.values["X"].T).T / units
    return replace(deepest, K=gain)


def _in_time(example, second):
    """The vertices in another unit of time, and what that does to x."""
    plant = example.plant
    n, a = plant.n, len(example.U)
    vertices = [
        SecondOrderSystem(second**2 * p.M, second * p.D, p.S, p.B, p.F)
        for p in plant.vertices
    ]
    units = np.r_[np.ones(n), np.full(n, second), np.full(a, 1 / second)]
    return descriptors(Polytope(vertices), example.U), units


def _inside(blocks, x):
    """x, scaled such that its smallest eigenvalue is one; None if it isn't inside."""
    least = _least(blocks, x)
    return x / least if least > 0 else None


def _least(blocks, x):
    return min(float(np.linalg.eigvalsh(g)[0]) for g in blocks(x))


def _shortest(blocks, x):
    """The shortest point with all blocks at least I, from coordinates around x."""
    cvxpy = library("cvxpy")
    white = [np.linalg.inv(np.linalg.cholesky(g)) for g in blocks(x)]
    slopes = [w @ s @ w.T for w, s in zip(white, blocks.slopes)]
    rows = np.concatenate([s.reshape(len(s), -1) for s in slopes], axis=1)
    back = np.linalg.inv(np.linalg.cholesky(rows @ rows.T))
    y = cvxpy.Variable(len(x))
    constraints = []
    for w, s in zip(white, slopes):
        q = len(w)
        flat = np.tensordot(back, s, 1).reshape(len(x), q * q).T
        g = cvxpy.reshape(flat @ y, (q, q), order="C") - w @ w.T
        constraints.append((g + g.T) / 2 >> 0)
    length = cvxpy.sum_squares(back.T @ y / np.linalg.norm(x))
    problem = cvxpy.Problem(cvxpy.Minimize(length), constraints)
    with warnings.catch_warnings():  # the rounds tell how accurate it is
        warnings.simplefilter("ignore")
        problem.solve(solver="CLARABEL")
    inside = _inside(blocks, back.T @ y.value)
    if inside is None:
        raise RuntimeError("Clarabel's point violates a block")
    return inside
