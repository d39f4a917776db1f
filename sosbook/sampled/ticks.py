"""A controller's loop with one plant, from tick to tick, in floats."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..analysis.linear import peak_gain
from .discretize import SampleTiming
from .lyapunov import discrete_lyapunov

GRID = 160  # frequencies from a thousandth of Nyquist's to it


def frequencies(T, F=None):
    """Frequencies of a clock of T seconds, in rad/s; those of F's eigenvalues too."""
    grid = np.geomspace(1e-3, 1, GRID) * np.pi / T
    if F is None:
        return grid
    turns = np.abs(np.angle(np.linalg.eigvals(F))) / T
    return np.unique(np.concatenate([grid, turns[turns > grid[0]]]))


@dataclass(frozen=True, eq=False)
class Ticks:
    """x+ = F x + noise n + set_point r + load w + pushed f + limited (v - u), u = H x +
    direct n + direct_r r + direct_w w, at the ticks of a ``timing``. The state x is the
    plant's, its older inputs, and the controller's; ``noise`` is the sensors', ``load``
    that of w, which is held over a tick, pushes the ``plant`` and enters its readings
    by ``read``, (q, p); ``pushed`` is a disturbance at the plant's input, ``limited``
    what the limits take away.
    """

    F: np.ndarray
    noise: np.ndarray
    set_point: np.ndarray
    pushed: np.ndarray
    limited: np.ndarray
    H: np.ndarray
    direct: np.ndarray
    direct_r: np.ndarray
    timing: SampleTiming
    plant: object
    read: np.ndarray

    @property
    def T(self):
        """The time between ticks, in s."""
        return float(self.timing.T)

    @classmethod
    def of(cls, parts, rows, timing, d, read=None):
        """The loop of ``parts`` A, B, B_r, C, D, D_r, W (see
        `sosbook.controllers.memory`) and ``timing`` with a plant d, of which rows x +
        read w is measured: ``rows``, (q, N); ``read``, zero without it.
        """
        A, B = timing.held(d)
        seen = np.hstack([rows, np.zeros((len(rows), len(A) - rows.shape[1]))])
        B_c, C, D = parts["B"], parts["C"], parts["D"]
        F = np.block([[A + B @ D @ seen, B @ C], [B_c @ seen, parts["A"]]])
        D_r, W = parts["D_r"], parts["W"]
        pairs = (B @ D, B_c), (B @ D_r, parts["B_r"]), (B, np.zeros_like(W)), (B, W)
        H = np.hstack([D @ seen, C])
        known = H, D, D_r, timing, d
        read = np.zeros((len(rows), d.Bw.shape[1])) if read is None else read
        return cls(F, *map(np.vstack, pairs), *known, read)

    @cached_property
    def load(self):
        """How a w that is held over a tick acts on the state."""
        found, d = self.noise @ self.read, self.plant
        if d.Bw.size:
            held = self.timing.at_once.held(replace(d, Bu=d.Bw))[1]
            found[: len(d.E)] += held[: len(d.E)]
        return found

    @property
    def direct_w(self):
        """How w acts on u at once."""
        return self.direct @ self.read

    def at_rest(self, r, w):
        """The plant's state and u where it comes to rest under constant r and w."""
        push = self.set_point @ r + self.load @ w
        rest = np.linalg.solve(np.eye(len(self.F)) - self.F, push)
        u = self.H @ rest + self.direct_r @ r + self.direct_w @ w
        return rest[: len(self.plant.E)], u

    @cached_property
    def radius(self):
        """The largest modulus of an eigenvalue."""
        return float(abs(np.linalg.eigvals(self.F)).max())

    @cached_property
    def sensitivity_peak(self):
        """The largest sensitivity at the plant's input; infinite if unstable."""
        if self.radius >= 1:
            return np.inf
        z = np.exp(1j * frequencies(self.T, self.F) * self.T)
        at = z[:, None, None] * np.eye(len(self.F)) - self.F
        S = np.eye(len(self.H)) + self.H @ np.linalg.solve(at, self.pushed + 0j)
        return float(np.linalg.norm(S, 2, axis=(1, 2)).max())

    def peak_of(self, direct):
        """The H-infinity norm of S - I + ``direct`` I, S being the sensitivity."""
        return held_gain(self.F, self.pushed, self.H, direct * np.eye(len(self.H)))

    def norm(self, d, inputs=None):
        """The H-infinity norm from a w that is held over a tick, from its ``inputs`` or
        all, to the output of d at the ticks, a `Descriptor` of the plant.
        """
        if d.Ca is not None:
            raise ValueError(
                "outputs: an acceleration jumps at the ticks; take positions, "
                "velocities, integrals or inputs of a sampled loop"
            )
        some = slice(None) if inputs is None else list(inputs)
        C = np.zeros((len(d.C), len(self.F)))
        C[:, : d.C.shape[1]] = d.C
        D = np.zeros((len(C), d.Bw.shape[1])) if d.Dw is None else d.Dw
        if d.Du is not None:
            C, D = C + d.Du @ self.H, D + d.Du @ self.direct_w[:, some]
        return held_gain(self.F, self.load[:, some], C, D)

    def noise_rms(self, steps):
        """(m,) rms of u if sensors have independent errors of steps / sqrt(12);
        infinite where floats don't hold it.
        """
        G = self.noise * (steps / np.sqrt(12))
        X = discrete_lyapunov(self.F.T, G @ G.T)
        if not np.isfinite(X).all():
            return np.full(len(self.H), np.inf)
        direct = self.direct * (steps / np.sqrt(12))
        total = self.H @ X @ self.H.T + direct @ direct.T
        return np.sqrt(np.maximum(np.diag(total), 0))

    def impulses(self, G, direct, count):
        """(count, m, k): u after an impulse in each of k inputs at tick 0, which act on
        the state by G, (N, k), and on u at once by ``direct``, (m, k).
        """
        found, x = np.empty((count, len(self.H), G.shape[1])), G
        found[0] = direct
        for k in range(1, count):
            found[k] = self.H @ x
            x = self.F @ x
        return found


def held_gain(F, G, C, D):
    """The H-infinity norm of x+ = F x + G w, C x + D w: that of the system of
    continuous time which z = (1 + s) / (1 - s) makes of it.
    """
    if abs(np.linalg.eigvals(F)).max(initial=0) >= 1:
        return np.inf
    one = np.eye(len(F))
    back = np.linalg.inv(F + one)
    A, B = back @ (F - one), np.sqrt(2) * back @ G
    return float(peak_gain(A, B, np.sqrt(2) * C @ back, D - C @ back @ G))
