"""Motions of a plant under inputs that are held, for many values at once."""

import numpy as np
from scipy.linalg import expm

from ..plants.descriptor import descriptors
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import SecondOrderSystem

SAME_TIME = 1e-3  # of a period: times are rounded to so much
FINE = 8  # pieces of a period in which friction lets go, holds or turns


def matrices(plant, outputs=None):
    """A, B, C, D of a ``plant`` and its ``outputs``, an Output: x' = A x + B u, and y =
    C x + D u; all states of second order or C without any.
    """
    if not isinstance(plant, (SecondOrderSystem, DescriptorSystem)):
        raise ValueError(
            f"the builder must return a SecondOrderSystem or a DescriptorSystem, got "
            f"{plant!r:.60}"
        )
    if getattr(plant, "dt", None):
        raise ValueError("the plant is of discrete time: identify one of continuous")
    (d,) = descriptors(plant)
    d = d if outputs is None else outputs.seen(d)
    A, B = np.linalg.solve(d.E, d.A), np.linalg.solve(d.E, d.Bu)
    C, D = d.C, np.zeros((len(d.C), B.shape[1])) if d.Du is None else d.Du
    if d.Ca is not None:
        C, D = C + d.Ca @ A, D + d.Ca @ B
    return A, B, C, D


class HeldInputs:
    """Motions of plants of one size under the same inputs, from rest.

    ``u``, (N, m): held from each sample to the next; ``steps``, (N,): how long in s.
    """

    def __init__(self, u, steps):
        grid = steps.mean() * SAME_TIME
        times = np.concatenate([[0], np.cumsum(steps)]) / grid
        lengths, self.which = np.unique(np.diff(times.round()), return_inverse=True)
        if np.ptp(steps) == 0:
            lengths, self.which = steps[:1] / grid, np.zeros(len(u), int)
        self.u, self.lengths = u, lengths * grid

    def flows(self, A, B, share=1.0):
        """Flow and push of A and B over a share of a step: (P, lengths, n, n + m)."""
        n, m = B.shape[1:]
        whole = np.zeros((len(A), n + m, n + m))
        whole[:, :n] = np.concatenate([A, B], axis=2)
        spans = self.lengths[:, None, None] * share
        return expm(whole[:, None] * spans)[..., :n, :]

    def free_and_pushed(self, A, B, free=False):
        """States (P, N, n, 1) before u[k] acts, of plants A (P, n, n) and B (P, n, m).

        With ``free`` n columns more: the motions that begin in each state.
        """
        P, n, N = len(A), A.shape[1], len(self.u)
        flows = self.flows(A, B)[:, self.which[:-1] if len(self.lengths) > 1 else [0]]
        x = np.zeros((P, N, n, 1 + n * free))
        x[:, 1:, :, 0] = (flows[..., n:] @ self.u[:-1, :, None])[..., 0]
        if free:
            x[:, 0, :, 1:] = np.eye(n)
        Phi, span = flows[..., :n], 1
        if len(self.lengths) > 1:
            Phi = np.concatenate([np.zeros((P, 1, n, n)), Phi], axis=1)
        while span < N:  # each state knows the last ``span`` pushes, then twice as many
            late = Phi[:, span:] if Phi.shape[1] > 1 else Phi
            x[:, span:] += late @ x[:, :-span]
            if Phi.shape[1] > 1:
                Phi = np.concatenate([Phi[:, :span], late @ Phi[:, :-span]], axis=1)
            else:
                Phi = Phi @ Phi
            span *= 2
        return x

    def rubbed(self, A, B, pull, rows, forces):
        """The same of plants A and B under Coulomb friction: (P, N, n, 1).

        ``pull``, (P, n, f): what unit forces of friction do to x'; ``rows``, (f, n):
        the speeds against which they act; ``forces``, (P, f): how large they are. While
        all slide on, the forces are constant and the motion is exact. Else a period has
        `FINE` pieces: a speed that would change its sign in one of them stays at zero
        then, or goes on from zero, in what is left of it.
        """
        B, parts = np.concatenate([B, -pull], axis=2), [B.shape[1], self.u.shape[1]]
        whole = self._pieces(A, B, parts, 1)
        fine = self._pieces(A, B, parts, FINE)
        slows = -np.einsum("jn,plnj->plj", rows, fine[2])  # of each speed, by its force
        x, path = np.zeros(A.shape[:2]), np.zeros((len(A), len(self.u), len(A[0]), 1))
        for k, at in enumerate(self.which):
            path[:, k, :, 0], speeds = x, x @ rows.T
            Phi, drive, stop = whole[0][:, at], whole[1][:, k], whole[2][:, at]
            rub = np.sign(speeds) * forces
            slid = (Phi @ x[..., None] + stop @ rub[..., None])[..., 0] + drive
            if (speeds * (slid @ rows.T) > 0).all():
                x = slid
                continue
            Phi, drive, stop = fine[0][:, at], fine[1][:, k], fine[2][:, at]
            for _ in range(FINE):
                before, x = x, (Phi @ x[..., None])[..., 0] + drive
                for j, row in enumerate(rows):
                    share = _held(before @ row, x @ row, forces[:, j] * slows[:, at, j])
                    x = x + (share * forces[:, j])[:, None] * stop[..., j]
        return path

    def _pieces(self, A, B, parts, count):
        """Of one of ``count`` pieces of a period: flows, pushes and rubs (see `rubbed`,
        ``parts``: how many states and inputs).
        """
        Phi, push, stop = np.split(self.flows(A, B, 1 / count), np.cumsum(parts), 3)
        return Phi, (push[:, self.which] @ self.u[:, :, None])[..., 0], stop


def _held(before, free, most):
    """The friction in a piece of time, -1 to 1, by the speed before, and after it if
    nothing rubbed, and by how much it can slow at most.
    """
    still = abs(before) <= 1e-9 * most
    way = np.where(still, np.sign(free), np.sign(before))
    after = free - way * most
    stops = still | (after * way < 0)  # or does it slide on?
    left = np.where(still, 1.0, after / np.where(still, 1.0, after - before))
    drive = free - np.where(still, 0.0, before)  # of the whole piece
    onwards = left * np.sign(drive) * np.maximum(abs(drive) - most, 0)
    return np.where(stops, (free - onwards) / most, way)
