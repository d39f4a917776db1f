"""Optimal control by a computer: the sampled LQR."""

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm, matrix_balance, solve_discrete_are

from ..analysis.riccati import balanced_units
from ..plants.checks import matrix, numbers, rank_deficient
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import Gain, gain_of, signals
from ..plants.kinds import Plant, checked_plant
from ..plants.signals import Sine, Step, Steps
from ..requirements.cost import QuadraticCost
from ..requirements.pole_region import LMIRegion
from ..runtime.array_like import ArrayLike
from ..runtime.threads import one_thread
from ..synthesis.result import Result
from .discretize import SampleTiming, input_vertices, sampled_loop
from .lyapunov import discrete_lyapunov
from .proof import SampledProof, certify_sampled
from .response import simulate_sampled

__all__ = ["SampledLQR", "design_sampled_lqr", "sampled_cost"]


def sampled_cost(plant, K, Q, R, T, delay=0.0, U=None, x0=None):
    """The integral of x'Qx + u'Ru over all times of the sampled loop.

    ``plant``, ``K``: as for `sampled_loop`; ``Q``, (N, N): the weight of the state, as
    for `design_sampled_lqr`; ``R``, (m, m): the weight of u, which is what the plant
    gets; ``T``, ``delay``, ``U``: as for `sampled_loop`; ``x0``, (N,), with older
    inputs (N + m d,): where the motion starts; without them they are zero. Without it
    the costs from all unit vectors are added, of states and older inputs. Returns
    (vertices,) array: infinite for an unstable loop, whatever x0.

    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
    >>> weights = np.eye(2), [[1]]
    >>> gains = [[-1, -1.5]], [[-0.5, -1.1]]
    >>> [sampled_cost(cart, K, *weights, T=1.0).round(3) for K in gains]
    [array([6.35]), array([3.76])]
    """
    timing, vertices = SampleTiming.of(T, delay), input_vertices(plant, U)
    K = timing.gain(gain_of(K, checked_plant(plant, of="a clock"), U), vertices[0])
    Q, R = _weights(Q, R, vertices[0])
    N, order = len(vertices[0].E), K.shape[1]
    start = np.eye(order)
    if x0 is not None:
        start = numbers("x0", x0).reshape(-1, 1)
        if len(start) not in (N, order) or not np.isfinite(start).all():
            raise ValueError(
                f"x0 must have {N} finite entries, or {order} with the "
                f"older inputs; got the shape {np.shape(x0)}"
            )
        start = np.vstack([start, np.zeros((order - len(start), 1))])
    costs = [_cost_matrix(d, K, Q, R, timing) for d in vertices]
    return np.array(
        [np.inf if X is None else np.trace(start.T @ X @ start) for X in costs]
    )


@dataclass(frozen=True, eq=False, repr=False)
class SampledLQR(Result):
    """The sampled loop of least cost.

    Parameters
    ----------
    plant, U, Q, R, T, delay
        As in `design_sampled_lqr`.
    K : (m, N + m d) array
        In u(k) = K [x; u(k-1); ...; u(k-d)], with the d older inputs that
        still act, or are yet to act, after a sample.
    X : (N + m d, N + m d) array
        The cost from the initial state x0 is x0' X x0.
    """

    plant: Any
    U: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    T: float
    delay: float
    K: np.ndarray
    X: np.ndarray

    status = "feasible"  # else there is no stabilising Riccati solution
    pole_axis = "poles, from sample to sample"

    def _region(self):
        return LMIRegion.disk(1, name="unit circle")

    @property
    def gain(self) -> Gain:
        """K with the names of what it multiplies, the older inputs among them."""
        names = signals(self.plant, self.U)
        older = (self.K.shape[1] - len(names)) // self.plant.m
        return Gain(self.K, signals(self.plant, self.U, older))

    @property
    def margins(self) -> dict[str, float]:
        """How far the poles stay inside the unit circle."""
        return {"unit circle": 1 - self.radius}

    @property
    def infeasibility(self) -> None:
        """None: there is a design."""

    @property
    def advice(self) -> str:
        """Empty: there is a design."""
        return ""

    def loop(self) -> np.ndarray:
        """The matrix of the loop, as `sampled_loop` has it."""
        (F,) = sampled_loop(self.plant, self.K, self.T, self.delay, self.U)
        return F

    def poles(self) -> np.ndarray:
        """Poles of the loop from sample to sample, the largest first.

        Returns
        -------
        (N + m d,) array
            For a Polytope, which has one vertex here, (1, N + m d).
        """
        return self._per_vertex(self._eigenvalues()[None])

    def _per_vertex(self, values):
        return self.plant.per_vertex(values)

    def _eigenvalues(self):
        eigenvalues = np.linalg.eigvals(self.loop())
        return eigenvalues[np.argsort(-abs(eigenvalues), kind="stable")]

    @property
    def radius(self) -> float:
        """The largest modulus of the poles; below one."""
        return float(abs(self._eigenvalues()[0]))

    def simulate(
        self,
        t: ArrayLike,
        r: ArrayLike | Step | Steps | None = None,
        w: Sine | Step | Steps | None = None,
        x0: ArrayLike | None = None,
    ) -> Any:
        """The `SampledResponse` of the loop, between the samples too.

        The arguments t, r, w and x0 are those of `simulate_sampled`.

        Parameters as in `simulate_sampled`.
        """
        plant = self.plant
        if isinstance(plant, DescriptorSystem):
            raise ValueError(
                "a DescriptorSystem has no displacement z to be simulated: its "
                "state isn't [z; z'; x3]; use sampled_loop"
            )
        timing, vertices = (
            SampleTiming.of(self.T, self.delay),
            input_vertices(plant, self.U),
        )
        return self._per_vertex(
            [simulate_sampled(d, self.K, timing, t, r, w, x0) for d in vertices]
        )

    def certify(
        self,
        rate: float = 1.0,
        digits: int | None = None,
        time_limit: float | None = None,
        progress: bool = False,
    ) -> SampledProof:
        """Prove the loop stable at this ``rate`` by `certify_sampled`.

        ``digits`` are those of the gain; without it 6, 8, 10, 12 and 17
        are tried. After ``time_limit`` seconds nothing is proven, and the answer
        says so; ``progress`` shows a bar of them.
        """
        asked = dict(rate=rate, digits=digits, time_limit=time_limit, progress=progress)
        return certify_sampled(self.plant, self.K, self.T, self.delay, self.U, **asked)


@one_thread
def design_sampled_lqr(
    plant: Plant,
    Q: ArrayLike,
    R: ArrayLike,
    T: float,
    delay: float = 0.0,
    U: ArrayLike | None = None,
) -> SampledLQR:
    r"""The gain that minimises a continuous cost, for a computer.

    Minimises :math:`\int_0^\infty x^\top Q x + u^\top R u \, dt`, with
    what happens between the samples, over all inputs that are constant
    from sample to sample.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        The plant, with one vertex.
    Q : (N, N) array_like
        Weight of the state [z; z'; x3], symmetric, not negative.
    R : (m, m) array_like
        Weight of the input, symmetric and positive definite.
    T, delay, U
        As for `c2d`.

    Returns
    -------
    SampledLQR
        The gain, its cost and the sampled loop.

    Raises
    ------
    ValueError
        On bad input, more than one vertex, a plant that u(k) can't
        stabilise, or a Q that doesn't see a mode on the unit circle.

    Notes
    -----
    Source: Franklin, Powell and Workman, Digital Control of Dynamic
    Systems, section 9.3.4; the integrals are Van Loan's (1978). The
    input of each sample is charged when it is computed: this moves cost
    from one sample to another but not the optimum.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
    >>> fast = design_sampled_lqr(cart, np.diag([1, 0]), [[1]], T=1e-3)
    >>> fast.K.round(2)  # near [-1, -sqrt(2)]
    array([[-1.  , -1.41]])
    >>> late = design_sampled_lqr(cart, np.diag([1, 0]), [[1]], 0.5, 0.7)
    >>> late.K.shape, late.radius < 1
    ((1, 4), True)
    """
    timing, vertices = SampleTiming.of(T, delay), input_vertices(plant, U)
    if len(vertices) > 1:
        raise ValueError(
            f"plant has {len(vertices)} vertices, and no Riccati equation "
            "holds for all: pick one plant, such as its mean, or design "
            "with design_lqr and prove with certify_sampled"
        )
    (d,) = vertices
    Q, R = _weights(Q, R, d)
    _check_stabilisable(d, timing)
    known = None
    with suppress(np.linalg.LinAlgError, ValueError):  # no stable half is found
        known = _least(d, Q, R, timing)
    if known is None:
        raise ValueError(
            "the Riccati equation has no stabilising solution in floats: "
            "Q doesn't see a mode on the unit circle (weight it), or T is "
            "out of scale with the plant (take another)"
        )
    return SampledLQR(plant, U, Q, R, float(timing.T), float(delay), *known)


def _least(d, Q, R, timing):
    """K and X of the discrete Riccati equation, solved in units of states and inputs,
    powers of two, that balance the continuous one; None for an unstable loop.
    """
    m, (A, B, _) = len(R), d.state_space()
    units = balanced_units(A, B, Q, R)
    force = 2.0 ** np.round(-np.log2(R.diagonal()) / 2)
    d = d.change(np.diag(1 / units), np.diag(units), force)
    Q, R = Q * np.outer(units, units), R * np.outer(force, force)
    A, B = timing.held(d)
    H = _stage_cost(timing, d, Q, R)
    parts = H[:-m, :-m], H[-m:, -m:], H[:-m, -m:]
    X = solve_discrete_are(A, B, parts[0], parts[1], s=parts[2])
    K = -np.linalg.solve(parts[1] + B.T @ X @ B, B.T @ X @ A + parts[2].T)
    X = _cost_matrix(d, K, Q, R, timing)
    both = np.append(units, np.tile(force, timing.n_past_inputs))
    return None if X is None else (force[:, None] * K / both, X / np.outer(both, both))


def _stage_cost(timing, d, Q, R):
    """The cost of one sample, in [x; older; u(k)]: with all of u(k)."""
    A, B, _ = d.state_space()
    N, m = B.shape
    W = np.zeros((N + 2 * m, N + 2 * m))
    W[:N, :N] = Q
    H, flow = np.zeros(W.shape), np.eye(len(W))
    for M, span in timing.segments(A, B):
        onward, cost = _integral(M, W, float(span))
        H, flow = H + flow.T @ cost @ flow, onward @ flow
    H = timing.selector(N, m).T @ H @ timing.selector(N, m)
    H[-m:, -m:] += float(timing.T) * R
    return (H + H.T) / 2


def _waiting(timing, R, N):
    """The weight that takes off the older inputs' cost, which was charged before."""
    late = timing.whole_samples * timing.T + timing.remainder
    spans = [min(timing.T, late - i * timing.T) for i in range(timing.n_past_inputs)]
    weight = np.zeros((N + len(R) * timing.n_past_inputs,) * 2)
    weight[N:, N:] = np.kron(np.diag([float(s) for s in spans]), R)
    return weight


def _integral(M, W, span):
    """e^(M t) at t = span and the integral of e^(M't) W e^(Mt) to there.

    Van Loan's exponential for a short span, which is then doubled: e to
    the minus M t would overflow where M has a fast stable mode.
    """
    n = len(M)
    length = np.linalg.norm(M, 1) * span
    halvings = int(np.ceil(np.log2(length))) if length > 1 else 0
    both = expm(np.block([[-M.T, W], [np.zeros((n, n)), M]]) * (span / 2**halvings))
    flow = both[n:, n:]
    cost = flow.T @ both[:n, n:]
    for _ in range(halvings):
        cost, flow = cost + flow.T @ cost @ flow, flow @ flow
    return flow, cost


def _weights(Q, R, d):
    N, m = d.Bu.shape
    cost = QuadraticCost(Q, R)
    return matrix("Q", cost.Q, (N, N)), matrix("R", cost.R, (m, m))


def _check_stabilisable(d, timing):
    """Hautus's test; the delay has no part in it."""
    A, B, _ = d.state_space()
    flow, inputs = timing.at_once.held(d)
    scale = matrix_balance(A, permute=False, separate=True)[1][0]
    for z in np.linalg.eigvals(flow):
        if abs(z) < 1 - 1e-9 or not _hidden(flow, inputs, z, scale):
            continue
        fixed = any(
            _hidden(A, B, s, scale)
            for s in np.linalg.eigvals(A)
            if s.real > -1e-9 * np.linalg.norm(A)
        )
        raise ValueError(
            "the plant can't be stabilised: u doesn't reach its mode at z "
            f"= {z:.3g}; " + ("add an input" if fixed else "with another T it does")
        )


def _hidden(A, B, s, scale):
    """True if u doesn't reach the mode s; ignores rounding errors."""
    A, B = A / scale[:, None] * scale, B / scale[:, None]
    pencil = np.hstack([A - s * np.eye(len(A)), B])
    sizes = np.repeat([abs(A).max(), abs(B).max()], [len(A), B.shape[1]])
    return rank_deficient(np.where(abs(pencil) < 1e-12 * sizes, 0, pencil))


def _cost_matrix(d, K, Q, R, timing):
    """X of the cost x0' X x0; None for an unstable loop."""
    A, B = timing.held(d)
    F = A + B @ K
    if abs(np.linalg.eigvals(F)).max() >= 1:
        return None
    full = np.vstack([np.eye(len(F)), K])
    X = discrete_lyapunov(F, full.T @ _stage_cost(timing, d, Q, R) @ full)
    if not np.isfinite(X).all():
        return None
    X = X + _waiting(timing, R, len(d.E))
    return (X + X.T) / 2
