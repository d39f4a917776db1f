"""How far a nonlinear loop may start from rest, by one ellipsoid: a polytope stands for
it only while an output stays in its range (sin(phi) = phi * factor has its factor in
[sinc(phi_max), 1] while |phi| <= phi_max), and a common P decides how long.
"""

from dataclasses import dataclass

import numpy as np

from ...exact.definite import round_digits
from ...language import Unknown, block
from ...lmi.problem import LMIProblem
from ...lmi.proofs import LMIProof
from ...lmi.text import LMIText
from ...plants.checks import matrix, positive
from ...requirements.pole_region import PoleRegion
from ...solver.loop import Unbounded
from ...synthesis.pid import analyse_pid
from ...synthesis.scaling import Frame
from ...theorems import control_bound, initial_state

__all__ = ["RegionOfAttraction", "region_of_attraction"]

OPTIMUM_GAP = 1e-4  # relative


@dataclass(frozen=True, eq=False)
class RegionOfAttraction:
    """The ellipsoid x' ``P``^-1 x <= 1, invariant within |row x| <= bound; ``reach``
    times the start lies in it. ``status``: whether a common P keeps the decay rate at
    all; ``proof``: a file of the invariance, the bound and the reach.
    """

    status: str
    reach: float = 0.0
    P: np.ndarray | None = None
    proof: LMIProof | None = None

    @property
    def proven(self):
        """True if exact arithmetic confirms it all: see ``proof``."""
        return self.proof is not None and self.proof.proven

    def boundary(self, count, seed=0):
        """Random states with x' P^-1 x = 1, ``count`` of them, one a row.

        The ``seed`` says which.
        """
        rng = np.random.default_rng(seed)
        points = rng.standard_normal((count, len(self.P)))
        points /= np.linalg.norm(points, axis=1)[:, None]
        return points @ np.linalg.cholesky(self.P).T

    def level(self, x):
        """x' P^-1 x of one state, or of every column."""
        return np.sum(x * np.linalg.solve(self.P, x), axis=0)


def region_of_attraction(
    plant, K, U=None, sigma=0.0, *, row, bound, start, backoff=0.01
):
    """The `RegionOfAttraction` that reaches farthest along ``start``, (N,), of a
    ``plant`` that holds the nonlinear one as long as |``row`` x| <= ``bound``, under
    ``K`` with the integrals of ``U``; sqrt(x' P^-1 x) decays at the rate ``sigma``, and
    the fraction ``backoff`` of the reach is given back. By thesis (2.18) and the two
    matrices of (2.21), with row P in the place of Y. Raises ValueError on wrong shapes,
    or if ``start`` is zero.

    >>> from sosbook.book import thesis
    >>> ex = thesis.example_4()
    >>> basin = region_of_attraction(ex.plant, ex.K, ex.U, row=[1, 0, 0, 0, 0],
    ...               bound=np.pi / 2, start=[1, 1, 0, 0, 0])
    >>> round(np.degrees(basin.reach)), basin.proven
    (84, True)
    """
    region = PoleRegion(sigma=sigma)
    loop = analyse_pid(plant, K, U, region=region, coupling="pairs")  # for its P
    K = loop.request.gain
    N = loop.request.order
    row = matrix("row", [row], (1, N))
    start = matrix("start", [start], (1, N))[0]
    bound, backoff = positive("bound", bound), positive("backoff", backoff)
    if not row.any() or not start.any():
        raise ValueError("row or start is zero: give c and a direction")
    if loop.status != "feasible":
        return RegionOfAttraction(loop.status)
    request, ask = loop.request, _Ellipsoids(loop.request, row, bound, start)
    frame = Frame.of(request)
    size = bound / np.linalg.norm(row @ frame.T)
    frame = frame.times(float(round_digits(size, 2)))  # P of the size of I
    P = loop.P * bound**2 / (2 * (row @ loop.P @ row.T).item())
    for _ in range(2):  # where rates are far apart the first optimum is a rough one
        found = ask.farthest(frame, P)
        if found is None:
            return RegionOfAttraction("undecided")
        P, reach = found
        frame = Frame.at(request, np.linalg.cholesky(P), frame.scale)
    reach = float(f"{(1 - backoff) * reach:.6g}")
    proof = ask.proof(reach, ask.centred(frame, P, reach))
    return RegionOfAttraction("feasible", reach, proof.values["P"], proof)


class _Ellipsoids:
    """Ellipsoids x' P^-1 x <= 1 within |c x| <= bound; the request holds the gain."""

    def __init__(self, request, row, bound, start):
        self.request, self.row, self.bound, self.start = request, row, bound, start
        self.P = Unknown("P", request.order, symmetric=True)

    def kept(self, P, cast, frame):
        """Invariance, and c P c' <= bound^2, in coordinates or, exactly, without."""
        blocks = dict(self.request.blocks_at({"P": P}, cast, frame))
        if frame is None:
            row, bound = cast(self.row), cast(self.bound)
        else:
            row, bound = self.row @ frame.T / self.bound, 1.0
        return blocks | {"row": control_bound(P, row @ P, bound**2)}

    def farthest(self, frame, near):
        """The P that reaches farthest along the start, ``near`` another; how far."""
        ray = np.linalg.solve(frame.T, self.start)  # frame.back has six digits only
        length = np.linalg.norm(ray)
        ray = ray[:, None] / length

        def long(values, cast):  # t > ray' P^-1 ray
            t, P = values["t"], values["P"]
            reached = block([[t, ray.T], [ray, P]])
            return self.kept(P, cast, frame) | {"start": reached}

        near = frame.inward(near)
        near = (near + near.T) / 2
        t = 2 * ray.T @ np.linalg.solve(near, ray)
        least = Unknown("t", 1)
        problem = LMIProblem(LMIText(long, [self.P, least]))
        first = problem.find(False, {"P": near, "t": t}).values
        if first is None:
            return None
        try:
            best = problem.minimize(least, OPTIMUM_GAP, first).values
        except Unbounded:
            return None
        P = frame.T @ best["P"] @ frame.T.T
        return (P + P.T) / 2, 1 / np.sqrt(best["t"].item()) / length

    def centred(self, frame, near, reach):
        """The centre of all P that reach so far, or the one ``near`` it."""
        x0 = np.linalg.solve(frame.T, self.start) * reach

        def shorter(values, cast):
            P = values["P"]
            return self.kept(P, cast, frame) | {"start": initial_state(P, x0)}

        start = {"P": frame.inward(near)}
        found = LMIProblem(LMIText(shorter, [self.P])).solve(False, start=start).values
        if found is None:
            return near
        P = frame.T @ found["P"] @ frame.T.T
        return (P + P.T) / 2

    def proof(self, reach, P):
        """The proof in exact numbers, of the plant as it was given."""

        def plain(values, cast):
            x0 = cast(self.start) * cast(reach)
            P = values["P"]
            return self.kept(P, cast, None) | {"start": initial_state(P, x0)}

        words = (
            "x' P^-1 x <= 1 is invariant, and |c x| <= bound there",
            f"{reach!r} times the given start lies inside",
        )
        return LMIProblem(LMIText(plain, [self.P])).prove({"P": P}, words)
