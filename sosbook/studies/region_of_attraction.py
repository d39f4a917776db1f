"""How far a nonlinear loop may start from rest, by one ellipsoid.

A polytope stands for a nonlinear plant only while some output stays
within its range: sin(phi) = phi * factor has its factor in
[sinc(phi_max), 1] while |phi| <= phi_max. A common Lyapunov matrix P
decides how long that is.
"""

from dataclasses import dataclass

import numpy as np

from ..lmi import Unknown, block
from ..lmi.centre import Blocks, Unbounded, centre, minimize
from ..lmi.exact import exact, pivots
from ..plants.checks import matrix, positive
from ..requirements.pole_region import PoleRegion
from ..synthesis.certificates import prove
from ..synthesis.pid import analyse_pid
from ..synthesis.scaling import Frame
from ..theorems import control_bound, initial_state

__all__ = ["Basin", "basin"]


@dataclass(frozen=True, eq=False)
class Basin:
    """The ellipsoid x' P^-1 x <= 1, invariant within |row x| <= bound.

    Parameters
    ----------
    status : {"feasible", "infeasible", "undecided"}
        Whether a common P keeps the decay rate at all.
    reach : float
        ``reach * start`` lies in the ellipsoid; 0 if there is none.
    P : (N, N) array or None
    proven : bool
        Whether exact arithmetic confirms invariance, the bound on
        ``row x`` and that ``reach * start`` lies within.
    """

    status: str
    reach: float = 0.0
    P: np.ndarray = None
    proven: bool = False

    def boundary(self, count, seed=0):
        """Random states with x' P^-1 x = 1, one a row."""
        rng = np.random.default_rng(seed)
        points = rng.standard_normal((count, len(self.P)))
        points /= np.linalg.norm(points, axis=1)[:, None]
        return points @ np.linalg.cholesky(self.P).T

    def level(self, x):
        """x' P^-1 x of one state, or of every column."""
        return np.sum(x * np.linalg.solve(self.P, x), axis=0)


def basin(plant, K, U=None, sigma=0.0, *, row, bound, start,
          backoff=0.01):
    r"""The ellipsoid that reaches farthest along a direction.

    Parameters
    ----------
    plant : Polytope or SecondOrderSystem
        Holds the nonlinear plant as long as :math:`|c x| \le` bound.
    K : (m, N) array_like
        ``[K_P K_D K_I]``.
    U : (a, n) array_like, optional
        Which errors are integrated.
    sigma : float
        Rate, in rad/s, at which sqrt(x' P^-1 x) shall decay.
    row : (N,) array_like
        c, the output whose range the polytope presumes.
    bound : float
        The size that c x must not exceed.
    start : (N,) array_like
        Direction in which the ellipsoid shall be long.
    backoff : float
        Fraction of the optimal reach that is given back for margin.

    Returns
    -------
    Basin

    Raises
    ------
    ValueError
        On wrong shapes, or if ``start`` is zero.

    Notes
    -----
    Source: thesis (2.18) for the decay and the two matrices of (2.21),
    with c P in the place of Y = K P.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> ex = thesis.example_4()
    >>> found = basin(ex.plant, ex.K, ex.U, row=[1, 0, 0, 0, 0],
    ...               bound=np.pi / 2, start=[1, 1, 0, 0, 0])
    >>> print(f"{np.degrees(found.reach):.0f} degrees, {found.proven}")
    84 degrees, True
    """
    K = matrix("K", K)
    loop = analyse_pid(plant, K, U, PoleRegion(sigma=sigma))
    N = loop.request.order
    row = matrix("row", [row], (1, N))
    start = matrix("start", [start], (1, N))[0]
    bound, backoff = positive("bound", bound), positive("backoff", backoff)
    if not row.any() or not start.any():
        raise ValueError("row or start is zero: give c and a direction")
    if loop.status != "feasible":
        return Basin(loop.status)
    frame = Frame.of(loop.request)
    blocks, (P,) = loop.request.in_unknowns(frame)
    blocks["row"] = control_bound(P, row @ frame.T / bound @ P, 1.0)
    ray = frame.back @ start
    size = np.linalg.norm(ray)
    ray = ray / size

    # smallest t >= ray' P^-1 ray, from the P at hand
    t = Unknown("t", 1)
    long = blocks | {"start": block([[t, ray[None]], [ray[:, None], P]])}
    inside = frame.back @ loop.P @ frame.back.T
    inside = inside * bound**2 / (2 * (row @ loop.P @ row.T).item())
    x = np.append(P.pack(inside), 2 * ray @ np.linalg.solve(inside, ray))
    cost = np.zeros(len(x))
    cost[-1] = 1.0
    try:
        x, _ = minimize(Blocks.of(long.values(), [P, t]), cost, x, 1e-4)
    except Unbounded:
        return Basin("undecided")

    reach = (1 - backoff) / np.sqrt(x[-1])
    blocks["start"] = initial_state(P, reach * ray)
    inside = P.unpack(centre(Blocks.of(blocks.values(), [P]), x[:-1]))
    inside = frame.T @ inside @ frame.T.T
    return _proven(loop.request, (inside + inside.T) / 2, row, bound,
                   start, reach / size)


def _proven(request, P, row, bound, start, reach):
    reach = float(f"{reach:.6g}")
    certificate = prove(request, request.gain, P, 17)
    P, held = exact(certificate.P), certificate.proven
    c, edge = exact(row), exact(bound)
    for g in (
        control_bound(P, c @ P, edge**2),
        initial_state(P, exact(start) * exact(reach)),
    ):
        held = held and pivots(g)[-1] > 0
    return Basin("feasible", reach, certificate.P, bool(held))
