r"""Limits with anti-windup: a proof of the loop within a region, by a sector.

**Lemma.** Let u be a loop's outputs in units of their limits, and
:math:`|u_k| \le 1 / (1 - \kappa)` on :math:`x^\top P x \le c`. There a limit takes away
:math:`\tfrac \kappa 2 u + \delta` with :math:`|\delta_k| \le \tfrac \kappa 2 |u_k|`. If

.. math::

    \begin{bmatrix} P - H^\top H & 0 \\ 0 & (2/\kappa)^2 I \end{bmatrix} >
    \begin{bmatrix} F_1^\top \\ G^\top \end{bmatrix} P \begin{bmatrix} F_1 & G
    \end{bmatrix}

for the loop :math:`x_{k+1} = F_1 x_k + G \delta_k`, in which the share
:math:`\kappa / 2` of u is taken away, then every motion from the region stays in it and
ends at rest.

*Proof.* x'Px falls by more than |Hx|^2 - (2/kappa)^2 |delta|^2, which isn't negative.
[] P > H'H, so c = 1 / (1 - kappa)^2 will do.

Source: the circle criterion in a region, as in S. Tarbouriech et al., Stability and
Stabilization of Linear Systems with Saturating Actuators (2011), chapter 3.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from decimal import ROUND_FLOOR

import numpy as np
from flint import arb
from scipy.linalg import matrix_balance

from ..exact.rational import exact, round_digits
from ..language import Unknown, block
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText
from ..runtime.time_limit import OutOfTime, check_time, time_limit
from ..sampled.balls import balls, middle
from ..sampled.lyapunov import discrete_lyapunov
from ..solver.loop import Unbounded
from .bounds import four_digits, longest_cut, outputs_of, rest, root, rounded
from .cells import Joined, work

SECTORS = (0.99, 0.97, 0.94, 0.9, 0.8, 0.6, 0.3)  # kappa
ROOMS = (1e-4, 1e-3, 1e-2)  # of P's size: for the other plants of a cell
MOST_CELLS, MORE, LAST_CELLS = 32, 4, 512  # at first, then times, and at most
TRIED = 60  # frequencies, beside those of the poles


@dataclass(frozen=True)
class Reach:
    """Which steps a controller survives although its output is limited.

    A set point that jumps once, from rest, is covered, and no other motion: none that
    ramps into the limit. Larger steps may settle, too: often much larger ones do.

    Parameters
    ----------
    step : float or None
        A set point that jumps by so much, at rest, is reached: proven for every plant
        of the family, with the limit and its anti-windup; None where nothing was
        proven.
    sector : float or None
        kappa: which share of the output the limit may take away.
    cells : int
        How many parts of the family the proof has.
    unit : str
        Of the step.
    stopped : float or None
        After how many seconds the search was stopped, if it was.
    """

    step: float | None
    sector: float | None
    cells: int
    unit: str = ""
    stopped: float | None = None

    def __str__(self):
        late = ""
        if self.stopped is not None:
            late = f". Stopped after {self.stopped:g} s: reach(seconds=) goes on"
        if self.step is None:
            return f"no step is proven to settle with the limit{late}"
        return (
            f"steps up to {four_digits(self.step, ROUND_FLOOR)} {self.unit} from rest "
            "settle with the limit, "
            "for every constant plant: proven by one program, the limit may take away "
            f"{100 * self.sector:g} % of the output. Slew, ramps, faults, sensors' "
            f"steps and friction are no part of it; larger steps may settle, too{late}"
        )


@work
def proven_reach(c, j, seconds=30.0):
    """The `Reach` of a controller c for its set point j, within so many seconds."""
    at_rest = rest(c, j)
    unit = c.set_points[j].unit
    best = Reach(None, None, 0, unit)
    if at_rest is None:
        return best
    most, stopped = MOST_CELLS, True
    with suppress(OutOfTime), time_limit(seconds):
        while best.step is None and most <= LAST_CELLS:
            for kappa in SECTORS:
                step, cells = _covered(c, kappa, at_rest, best.step or 0.0, most)
                if step is not None and step > (best.step or 0.0):
                    best = Reach(step, kappa, cells, unit)
            most *= MORE
        stopped = False
    return replace(best, stopped=float(seconds) if stopped else None)


def _covered(c, kappa, at_rest, wanted, most):
    """The step that is proven with a sector, in how many cells, of so many at ``most``;
    None without proof.
    """
    u_max = c.limits.u_max
    limits = exact(np.diag(u_max))
    joined = Joined(c, -exact(c.W) @ limits, -limits, exact(kappa) / 2)
    H = outputs_of(c) / exact(u_max)[:, None]
    queue, least, count = [joined.family.shape.whole()], np.inf, 0
    while queue:
        check_time()
        weights = queue.pop()
        wholes = [middle(joined.family.loop(w, c.timing)) for w in weights]
        both = [F[: -joined.inputs] for F in wholes]
        if any(_louder(F, H.astype(float), 2 / kappa) for F in both):
            return None, count  # and so is every cell with this plant
        found = _cell(joined, weights, both, H, kappa, at_rest)
        count += 1
        if found is not None:
            least = min(least, found)
            if least <= wanted:
                return None, count
            continue
        if len(weights) == 1 or count + len(queue) + 2 > most:
            return None, count
        queue += joined.family.shape.halves(weights, longest_cut(joined, weights))
    return least, count


def _louder(F, H, level):
    """True if H x is as large as ``level`` times delta at some frequency of a loop
    [F_1 G] = ``F``, or the loop isn't stable: then the lemma has no P for it.
    """
    N = len(F)
    A, G = F[:, :N], F[:, N:]
    poles = np.linalg.eigvals(A)
    if abs(poles).max() >= 1:
        return True
    z = np.exp(1j * np.r_[0, np.geomspace(1e-4, np.pi, TRIED), np.angle(poles)])
    gains = H @ np.linalg.solve(z[:, None, None] * np.eye(N) - A, G + 0j)
    return bool(np.linalg.norm(gains, 2, (1, 2)).max() >= level)


def _cell(joined, weights, both, H, kappa, at_rest):
    """The proven step of one cell, ``both`` of whose loops are stable, or None."""
    m, g = joined.inputs, at_rest.astype(float)
    for room in ROOMS:
        inner = _common(both, H.astype(float), kappa, g, room)
        if inner is None:  # a larger room asks for more
            return None
        N = len(inner)
        L = np.zeros((N + m,) * 2)
        L[:N, :N] = inner
        L[N:, N:] = np.eye(m) * round_digits([2 / kappa], 6)[0]
        Lx, seen = balls(L[:N, :N]), balls(H)
        R = balls(np.zeros((N + m,) * 2))
        R[:N, :N] = Lx.T @ Lx - seen.T @ seen
        R[N:, N:] = balls(exact(np.eye(m)) * (2 / exact(kappa)) ** 2)
        if joined.cell(weights, L).least(R) > 0:
            size = Lx @ balls(at_rest)
            length = sum((e.abs_upper() ** 2 for e in size.flat), arb(0)).sqrt()
            return rounded(1 / ((1 - arb(exact(kappa))) * length), 0)
    return None


def _common(both, H, kappa, g, room):
    """L, of 12 digits, whose L'L is a P of the lemma for some loops, with room for
    others; None without.
    """
    m, N = both[0].shape[1] - len(both[0]), len(both[0])
    scale = _coordinates(both[0][:, :N], H)
    if scale is None:
        return None
    back = np.linalg.inv(scale)
    inside = [np.hstack([scale @ F[:, :N] @ back, scale @ F[:, N:]]) for F in both]
    seen = H @ back

    def write(values, number):
        X = values["X"]
        found = {"X": X}
        for k, F in enumerate(inside):
            A, G = number(F[:, :N]), number(F[:, N:])
            corner = X - number(seen.T @ seen + room * np.eye(N)) - A.T @ X @ A
            last = number(np.eye(m) * (2 / kappa) ** 2 * (1 - room)) - G.T @ X @ G
            found[f"loop {k}"] = block(
                [[corner, -(A.T @ X @ G)], [-(G.T @ X @ A), last]]
            )
        return found

    X = Unknown("X", N, symmetric=True)
    problem = LMIProblem(LMIText(write, [X]))
    x = scale @ g
    W = x @ x.T / np.trace(x.T @ x) + 1e-3 * np.eye(N)
    found = problem.find(refuse=False).values
    if found is None:
        return None
    with suppress(Unbounded):
        found = problem.minimize(W @ X, 1e-3, found).values
    inner = root(found["X"])
    return None if inner is None else round_digits(inner @ scale, 12)


def _coordinates(F, H):
    """Coordinates in which what the outputs see of the motions is near one; None where
    floats hold none.
    """
    units = matrix_balance(F, permute=False, separate=True)[1][0] ** -2.0
    P = discrete_lyapunov(F, H.T @ H)
    rest = discrete_lyapunov(F, np.diag(units))
    if not (np.isfinite(P).all() and np.isfinite(rest).all()):
        return None
    P = P + 1e-3 * np.trace(P / units) / np.trace(rest / units) * rest
    return root(P)
