"""The plant between two samples of a computer, solved exactly.

At t = 0, T, 2 T, ... the computer measures the state and computes u(k).
The plant gets it ``delay`` seconds later and holds it for T seconds.
"""

from dataclasses import dataclass

import numpy as np
from flint import fmpq
from scipy.linalg import expm

from ..exact.definite import exact
from ..laws.taken import is_controller, law_of, order_of, taken
from ..loops import Loop
from ..plants.checks import finite, matrix, positive
from ..plants.gain import gain_of, input_names, signals
from ..plants.kinds import checked_plant
from ..runtime.libraries import library
from ..synthesis.request import Request
from .system import SampledSystem

__all__ = ["SampleTiming", "c2d", "generators", "input_vertices", "sampled_loop"]

LONGEST_DELAY_IN_SAMPLES = 1000  # samples that a delay may last
WHOLE_SAMPLE_TOLERANCE = fmpq(1, 10**9)  # of a sample; nearer delays are whole


def c2d(plant, T, delay=0.0, U=None):
    """The plant from sample to sample, under a delayed zero-order hold.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        The plant, regular in E.
    T : float
        Time between samples, in s.
    delay : float
        The time from sample to actuator, in s; it may have any length.
    U : (a, n) array_like, optional
        Which errors are integrated, in continuous time.

    Returns
    -------
    tuple of control.StateSpace
        One for each vertex, with ``dt = T``, from u(k) to its state
        [x; u(k-1); ...; u(k-d)], where d is delay / T, rounded up.

    Raises
    ------
    ValueError
        If M is singular, T <= 0, delay < 0 or longer than 1000 samples.

    Notes
    -----
    Source: Van Loan, Computing integrals involving the matrix
    exponential (1978); Astrom and Wittenmark, Computer-Controlled
    Systems, section 2.3. T and delay are read as decimals, and a delay
    within a billionth of a sample of a whole number of them is one: 0.3
    and 3 * 0.1 are three times 0.1.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
    >>> (step,) = c2d(cart, T=1.0, delay=0.5)
    >>> step.A  # the last column: half a second of u(k-1)
    array([[1.   , 1.   , 0.375],
           [0.   , 1.   , 0.5  ],
           [0.   , 0.   , 0.   ]])
    >>> step.B.T
    array([[0.125, 0.5  , 1.   ]])
    """
    timing = SampleTiming.of(T, delay)
    systems = []
    for d in input_vertices(plant, U):
        A, B = timing.held(d)
        outputs = np.eye(len(A)), np.zeros(B.shape)
        systems.append(library("control").ss(A, B, *outputs, dt=float(timing.T)))
    return tuple(systems)


def sampled_loop(plant, K, T, delay=0.0, U=None):
    """The matrix of the loop u(k) = K [x; older inputs], from k to k + 1.

    Parameters
    ----------
    plant
        As for `c2d`.
    K : (m, N) or (m, N + m d) array_like, SampledSystem or control.StateSpace
        Feedback of x = [z; z'; x3] alone, or of the older inputs, too;
        or a sampled controller from x(k) to u(k).
    T, delay, U
        As for `c2d`.

    Returns
    -------
    tuple of array
        One for each vertex, of the state [x; older inputs], and last
        the controller's own. The loop is stable if all eigenvalues lie
        inside the unit circle.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> cart = SecondOrderSystem([[1]], [[0]], [[0]], B=[[1]])
    >>> (F,) = sampled_loop(cart, [[-1, -1.5]], T=1.0)  # dead beat
    >>> bool(abs(F @ F).max() < 1e-12)
    True
    """
    timing, vertices = SampleTiming.of(T, delay), input_vertices(plant, U)
    K = by_name(K, checked_plant(plant, of="a clock"), U, T, delay)
    full, own = timing.feedback(K, vertices[0])
    return tuple(
        np.vstack([np.hstack(held) @ full, own]) for held in map(timing.held, vertices)
    )


@dataclass(frozen=True)
class SampleTiming:
    """The time T between samples and a delay, in exact rationals.

    ``T``, fmpq: time between samples, in s; ``whole_samples``: how many whole samples
    the delay lasts; ``remainder``, fmpq: what is left of the delay, in s; less than T;
    ``shared``: whether the state holds the input before even where nothing is left;
    ``steps``: the plant is one of discrete time, whose `Descriptor` is that of its
    change in a tick, (x(k+1) - x(k)) / T: there is no motion between the ticks.
    """

    T: fmpq
    whole_samples: int
    remainder: fmpq
    shared: bool = False
    steps: bool = False

    @classmethod
    def of(cls, T, delay):
        """The timing of a time T and a delay, floats that are read as decimals.

        Raises ValueError if they are bad.
        """
        T, late = exact(positive("T", T)), exact(finite("delay", delay))
        if late < 0:
            raise ValueError(f"delay must not be negative, got {delay!r}")
        if late > LONGEST_DELAY_IN_SAMPLES * T:
            raise ValueError(
                f"delay = {delay} lasts more than {LONGEST_DELAY_IN_SAMPLES} samples "
                f"of T = {float(T)}: take a longer T, or check the units"
            )
        whole = int((late / T + fmpq(1, 2)).floor())
        if abs(late / T - whole) <= WHOLE_SAMPLE_TOLERANCE:  # 3 * 0.1 is three samples
            return cls(T, whole, fmpq(0))
        whole = int((late / T).floor())
        return cls(T, whole, late - whole * T)

    @property
    def acting(self):
        """(age, seconds) of the inputs that act in a tick, the first one first."""
        whole, rest = self.whole_samples, self.remainder
        return (whole + 1, rest), (whole, self.T - rest)

    def follows(self, before):
        """True if the tick may come after the one ``before``: it always may."""
        return True

    @property
    def words(self):
        """It, in words."""
        T, late = float(self.T), float(self.remainder)
        return f"T = {T:.6g}" + f", delay = {late:.6g}" * self.shared

    @property
    def at_once(self):
        """The same ticks, without a delay."""
        return SampleTiming(self.T, 0, fmpq(0), steps=self.steps)

    @property
    def n_past_inputs(self):
        """d, how many older inputs the state holds."""
        return self.whole_samples + (self.shared or self.remainder > 0)

    def gain(self, K, d):
        """K of [x; older inputs] for a plant d, from a K that may be of x alone."""
        N, m = d.Bu.shape
        K = matrix("K", K, (m, None))
        order = N + m * self.n_past_inputs
        if K.shape[1] not in (N, order):
            raise ValueError(
                f"K has {K.shape[1]} columns, needs {N}"
                + (f", or {order} with the older inputs" if order > N else "")
            )
        return np.hstack([K, np.zeros((m, order - K.shape[1]))])

    def feedback(self, K, d, number=lambda x: x):
        """The maps from [x; older; own] to [x; older; u(k)] and to own(k + 1).

        K is a gain or a sampled controller of a plant d; ``number`` brings
        matrices into another arithmetic.

        ``own`` is the state of a controller; a gain K has none.
        """
        N, m = d.Bu.shape
        order = N + m * self.n_past_inputs
        if not is_controller(K):
            K = self.gain(K, d)
            return np.vstack([number(np.eye(order)), number(K)]), number(
                np.zeros((0, order))
            )
        timeless = K.dt is True or (K.dt is None and not K.nstates)
        if (K.ninputs, K.noutputs) != (N, m) or (
            not timeless and K.dt != float(self.T)
        ):
            raise ValueError(
                f"K must be a controller with {N} inputs and {m} outputs, "
                f"sampled with dt = {float(self.T)!r}, to the last digit; got "
                f"{K.ninputs}, {K.noutputs} and dt = {K.dt!r}"
            )
        past = np.zeros((K.nstates + m, m * self.n_past_inputs))
        rows = np.hstack([np.vstack([K.B, K.D]), past, np.vstack([K.A, K.C])])
        same = np.eye(order, order + K.nstates)
        own, u = np.split(rows, [K.nstates])
        return number(np.vstack([same, u])), number(own)

    def read(self, K, d):
        """How w enters u(k) and own(k + 1) by what a controller K of a plant d reads,
        in rationals; None of one that reads no w.
        """
        B, D = getattr(K, "B_w", None), getattr(K, "D_w", None)
        if D is None:
            return None
        if D.shape[1] != d.Bw.shape[1]:
            raise ValueError(
                f"K reads {D.shape[1]} disturbances, but the plant has "
                f"{d.Bw.shape[1]}: give B_w and D_w a column for each"
            )
        return exact(D), exact(B)

    def selector(self, N, m):
        """For N states, m inputs, from [x; older; u(k)] to x and what is `acting`."""
        S = np.zeros((N + m * len(self.acting), N + m * (self.n_past_inputs + 1)))
        S[:N, :N] = np.eye(N)
        for k, (age, _) in enumerate(self.acting):
            if age <= self.n_past_inputs:
                row, column = N + k * m, N + (age - 1) * m if age else S.shape[1] - m
                S[row : row + m, column : column + m] = np.eye(m)
        return S

    def shift_register(self, N, m):
        """For N states and m inputs, from [x; older; u(k)] to the next older inputs."""
        S = np.zeros((m * self.n_past_inputs, N + m * (self.n_past_inputs + 1)))
        kept = max(len(S) - m, 0)
        S[m:, N : N + kept] = np.eye(kept)
        S[:m, -m:] = np.eye(m)[: len(S)]
        return S

    def segments(self, A, B):
        """How x and what is `acting` of x' = A x + B u move: (matrix, how long)."""
        several = zip(generators(A, B, len(self.acting)), self.acting)
        return [(M, t) for M, (_, t) in several if t != 0]

    def flow(self, M, span):
        """The map over a ``span`` of seconds of x' = M x, in floats."""
        step = M * float(span)
        return np.eye(len(M)) + step if self.steps else expm(step)

    def held(self, d):
        """The two matrices of `c2d`, for one vertex d."""
        A, B, _ = d.state_space()
        N, m = B.shape
        flow = np.eye(N + m * len(self.acting))
        with np.errstate(over="ignore", invalid="ignore"):
            for M, span in self.segments(A, B):
                flow = self.flow(M, span) @ flow
        if not np.isfinite(flow).all():
            raise ValueError(
                f"T = {float(self.T)}: the plant's motion overflows from "
                "one sample to the next; take a shorter T"
            )
        both = np.vstack([flow[:N] @ self.selector(N, m), self.shift_register(N, m)])
        return both[:, :-m], both[:, -m:]


def generators(A, B, count=2):
    """How x and ``count`` inputs of x' = A x + B u move: under the first, and so on."""
    N, m = B.shape
    several = [np.zeros((N + m * count,) * 2, B.dtype) for _ in range(count)]
    for k, M in enumerate(several):
        M[:N, :N], M[:N, N + k * m :][:, :m] = A, B
    return several


def by_name(K, plant, U=None, T=None, delay=0.0):
    """A gain or controller K of a ``plant`` with integrators ``U``, found by names.

    A Controller is taken from the plant's state, and the program of a law that K brings
    along, whose clock is T and ``delay``, too. The inputs of a sampled controller are
    the states and its outputs the plant's inputs, in any order, where they were named;
    what nobody named (python-control writes u[0], y[0]) is taken in order, and the
    claim says so. Raises ValueError where names don't fit.

    >>> from sosbook import SecondOrderSystem
    >>> K = SampledSystem([[0]], [[1, 2]], [[1]], [[3, 4]], 0.1, inputs=("z1'", "z1"))
    >>> by_name(K, SecondOrderSystem(1, 0, 0, 1)).D
    array([[4., 3.]])
    """
    law = law_of(U, None)
    if not hasattr(K, "of_state") and not (is_controller(K) and K.dt != 0):
        law, K = taken(plant, K, U=U)
    if not law.whole:
        if any(isinstance(x, (tuple, list)) for x in (T, delay)):
            raise ValueError(
                "K has a law of continuous time, and the clock varies: say which its "
                "program is made for, K = sosbook.Loop(plant, K).at(T).controller"
            )
        K = Loop(plant, law, K).at(T, delay).controller
    K = getattr(K, "of_state", K)
    if not is_controller(K):
        return gain_of(K, plant, U)
    states, given = signals(plant, U), input_names(plant.m)
    columns, rows = order_of(K, "input", states), order_of(K, "output", given)
    if columns is None and rows is None:
        return K
    known = columns is not None and (rows is not None or len(given) == 1)
    columns = np.arange(K.ninputs) if columns is None else columns
    rows = np.arange(K.noutputs) if rows is None else rows
    C, D, D_w = np.asarray(K.C)[rows], np.asarray(K.D)[rows], getattr(K, "D_w", None)
    read = getattr(K, "B_w", None), None if D_w is None else D_w[rows]
    matrices = K.A, np.asarray(K.B)[:, columns], C, D[:, columns], K.dt, *read
    return SampledSystem(*matrices, *((states, given) if known else ()))


def input_vertices(plant, U):
    """One `Descriptor` for each vertex of a plant with integrators U.

    Its E is regular. No regularization is taken: no sampler holds its K_A z''.
    """
    plant = checked_plant(plant, of="a clock")
    try:
        return Request(plant, U).vertices
    except ValueError as error:
        if "is singular" not in str(error):
            raise
        raise ValueError(
            "M is singular: between samples the plant isn't a differential "
            "equation in [z; z']; take the massless states out first"
        ) from None
