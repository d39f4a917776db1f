r"""The model that an observer follows, with loads that stay, of all or of part of x.

Loads d that don't change are states of a larger plant, d' = 0. With x = Pi d and u =
Gamma d where A x + B u + B_d d = 0 and C x = 0, the input is u = K (x^ - Pi d^) + Gamma
d^. At rest the observer has C x^ = y, if L's rows of d have the rank of C, so (A + B K)
(x^ - Pi d^) = 0, and y = C Pi d^ = 0: whatever the plant is, if the loop is stable.

An observer of part of x believes its q sensors. With x = P_1 y + P_2 r and r = R x it
remembers s = r^ + L y alone: s' = (R + L C) (A x^ + B u).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..plants.checks import matrix, rank_deficient
from ..plants.descriptor import Descriptor, mean_descriptor
from ..runtime.read_only import ReadOnly

CLEAR = 1e-9  # relative: less is a rounding error
NO_REST = (
    "disturbance: no u keeps what is measured at zero under this load, so it can't be "
    "cancelled there: measure other places (C), or as many as there are inputs"
)


@dataclass(frozen=True, eq=False)
class ObserverModel(ReadOnly):
    """The model of an observer with the gain ``K``, (m, N), that sees ``C``, (q, N), of
    the plants at ``vertices``; ``loads``, (N, p), is where constant loads enter E x',
    or None; ``reduced``: whether the sensors are believed; ``place``: the region of the
    error's poles that was asked, of each vertex's own A + L C.
    """

    vertices: tuple
    K: np.ndarray
    C: np.ndarray
    loads: np.ndarray | None = None
    reduced: bool = False
    place: object = None

    def __post_init__(self):
        """Check that loads can be cancelled and that sensors can be believed."""
        if self.loads is not None:
            self._feed_forward  # noqa: B018
        if self.reduced and not len(self.C) < self.C.shape[1] + self._p:
            raise ValueError("reduced=True: all of the state is measured already")
        if self.reduced and rank_deficient(self.C @ self.C.T, CLEAR):
            raise ValueError("reduced=True: the rows of C depend on each other")
        super().__post_init__()

    @property
    def _p(self):
        return 0 if self.loads is None else self.loads.shape[1]

    @property
    def plain(self):
        """True if the memory is the estimate of x."""
        return self.loads is None and not self.reduced

    def _larger(self, d):
        """The plant ``d`` with its loads as states."""
        if self.loads is None:
            return d
        N, p = self.loads.shape
        E, A = np.eye(N + p), np.zeros((N + p, N + p))
        E[:N, :N], A[:N, :N], A[:N, N:] = d.E, d.A, self.loads
        B, W = (np.vstack([x, np.zeros((p, x.shape[1]))]) for x in (d.Bu, d.Bw))
        return replace(d, E=E, A=A, Bu=B, Bw=W)

    @cached_property
    def mean(self):
        """E, A and B of the mean vertex with its loads."""
        return self._larger(mean_descriptor(self.vertices))

    @cached_property
    def seen(self):
        """The rows of C on the state with its loads."""
        return np.hstack([self.C, np.zeros((len(self.C), self._p))])

    @cached_property
    def _feed_forward(self):
        """Pi and Gamma of the mean vertex."""
        d, (N, p) = mean_descriptor(self.vertices), self.loads.shape
        m, q = d.Bu.shape[1], len(self.C)
        rows = np.block([[d.A, d.Bu], [self.C, np.zeros((q, m))]])
        right = -np.vstack([self.loads, np.zeros((q, p))])
        found = np.linalg.lstsq(rows, right, rcond=None)[0]
        if np.abs(rows @ found - right).max() > CLEAR * np.abs(self.loads).max():
            raise ValueError(NO_REST)
        return found[:N], found[N:]

    @cached_property
    def gain(self):
        """K with the columns of d^."""
        if self.loads is None:
            return self.K
        rest, push = self._feed_forward
        return np.hstack([self.K, push - self.K @ rest])

    @cached_property
    def _parts(self):
        """R, P_1 and P_2."""
        q, C = len(self.C), self.seen
        R = np.linalg.svd(C)[2][q:]
        back = np.linalg.inv(np.vstack([C, R]))
        return R, back[:, :q], back[:, q:]

    def duals(self):
        """E, A and B of each plant whose state feedback is L'."""
        found = []
        for d in map(self._larger, self.vertices):
            E, A, seen = d.E, d.A, self.seen
            if self.reduced:
                R, _, P = self._parts
                flow = np.linalg.solve(E, A) @ P
                E, A, seen = np.eye(len(R)), R @ flow, seen @ flow
            none = np.zeros((len(seen.T), 0))
            found.append(Descriptor(E.T, A.T, seen.T, none, none.T))
        return found

    def observer_gain(self, K):
        """L of the gain K of the `duals`."""
        return K.T if self.reduced else np.linalg.solve(self.mean.E, K.T)

    def controller(self, L):
        """A, B, C, D from y to u, for an observer's gain L."""
        A, B, _ = self.mean.state_space()
        closed, K = A + B @ self.gain, self.gain
        if not self.reduced:
            return closed + L @ self.seen, -L, K, np.zeros((len(K), len(self.C)))
        (R, _, P), here = self._parts, self._of_sensors(L)
        push = (R + L @ self.seen) @ closed
        return push @ P, push @ here, K @ P, K @ here

    def _of_sensors(self, L):
        """The matrix from y to x^, where sensors are believed."""
        _, first, P = self._parts
        return first - P @ L

    def estimate(self, L, memory, y):
        """x^, and d^ below it, of a ``memory`` and what is measured, ``y``, by columns,
        under the observer's gain ``L``.
        """
        if not self.reduced:
            return memory
        return self._parts[2] @ memory + self._of_sensors(L) @ y


def loads_of(disturbance, N, Bu):
    """The matrix (N, p) of a ``disturbance``: True is one beside each input, ``Bu``."""
    if disturbance is None:
        return None
    if disturbance is True:
        return np.array(Bu, float)
    found = matrix("disturbance", disturbance, (N, None))
    if not found.shape[1] or rank_deficient(found.T @ found, CLEAR):
        raise ValueError("disturbance has no column, or dependent ones")
    return found
