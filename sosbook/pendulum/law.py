"""Control laws as a robot's computer runs them: one step per sample."""

from dataclasses import dataclass, replace

import numpy as np

from ..laws.taken import order_of
from ..plants.checks import matrix, positive
from ..plants.gain import Gain
from ..runtime.libraries import library

__all__ = ["PD_SIGNALS", "PID_SIGNALS", "TRACKING_TIME", "SampledLaw", "pendulum_gain"]

#: What a robot measures, y of its law, which a gain [K_P K_D] multiplies; phi is
#: absolute.
PD_SIGNALS = ("theta", "phi", "theta'", "phi'")
#: What a gain [K_P K_D K_I] multiplies.
PID_SIGNALS = (*PD_SIGNALS, "integral of phi")
TRACKING_TIME = 0.5  # s, with which a sum follows what the limit withholds


@dataclass(frozen=True, eq=False)
class SampledLaw:
    """A linear law of the samples y = [theta, phi, theta', phi'].

    x(k+1) = A x(k) + B y(k) + W (V(k) - u(k)),
    u(k) = C x(k) + D y(k), with V(k) the voltage after the limit.

    Parameters
    ----------
    A : (N, N) array_like
        How the state moves.
    B : (N, 4) array_like
        How the samples act on the state.
    C : (1, N) array_like
        How the state acts on the voltage.
    D : (1, 4) array_like
        How the samples act on the voltage, in V per rad and V per rad/s.
    T : float
        Time between samples, in s.
    W : (N, 1) array_like, optional
        Anti-windup: how what the limit withheld acts on the state.
        Without it the state knows nothing of the limit.
    start : (N,) array_like, optional
        The state at the start, per rad of tilt; zero without it.
    note : tuple of str
        Where the law comes from; the header of its C program carries it.

    Raises
    ------
    ValueError
        On wrong shapes, entries that aren't finite, or T <= 0.

    Examples
    --------
    >>> gain = Gain([[20, 0.8, 2, 0.9, 0.4]], PID_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> law.order, law.D
    (1, array([[20. ,  0.8,  2. ,  0.9]]))
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    T: float
    W: np.ndarray | None = None
    start: np.ndarray | None = None
    note: tuple[str, ...] = ()

    def __post_init__(self):
        """Check the shapes; W and start are zeros by default."""
        A = np.asarray(self.A, float)
        if A.ndim != 2:
            raise ValueError(f"A must be a matrix, got the shape {A.shape}")
        N, width = len(A), len(PD_SIGNALS)
        W = np.zeros((N, 1)) if self.W is None else self.W
        start = np.zeros(N) if self.start is None else self.start
        start = np.reshape(np.asarray(start, float), (-1, 1))
        for name, value, shape in (
            ("A", A, (N, N)),
            ("B", self.B, (N, width)),
            ("C", self.C, (1, N)),
            ("D", self.D, (1, width)),
            ("W", W, (N, 1)),
            ("start", start, (N, 1)),
        ):
            checked = matrix(name, value, shape)
            object.__setattr__(self, name, checked)
        object.__setattr__(self, "start", self.start[:, 0])
        object.__setattr__(self, "T", positive("T", self.T))

    @property
    def order(self):
        """Number of states."""
        return len(self.A)

    def noted(self, *lines):
        """The same law with the ``lines``, str, as its note."""
        return replace(self, note=lines)

    @classmethod
    def of_gain(cls, gain, T, tracking_time=TRACKING_TIME):
        """V = K [theta, phi, theta', phi', x3] of measured states; x3 sums T phi.

        Parameters
        ----------
        gain : Gain
            The ``gain`` of a design for a pendulum's plant, of `PD_SIGNALS` or
            `PID_SIGNALS` in any order.
        T : float
            Time between samples, in s.
        tracking_time : float
            While the voltage is at its limit, K_I x3 follows what is
            withheld with this time constant, in s.

        Raises
        ------
        ValueError
            If the gain doesn't say what it multiplies, or that isn't what a robot
            measures and sums.

        Notes
        -----
        Source: thesis (2.8), sampled; back calculation against windup
        as in Astrom and Hagglund, PID Controllers, section 3.5.

        Examples
        --------
        >>> gain = Gain([[20, 0.8, 2, 0.9, 0.4]], PID_SIGNALS)
        >>> SampledLaw.of_gain(gain, 0.01).W
        array([[0.05]])
        """
        K = pendulum_gain(gain)
        T, tracking_time = positive("T", T), positive("tracking_time", tracking_time)
        if K.shape[1] == 4:
            none = np.zeros((0, 4))
            return cls(none[:, :0], none, none[:, :1].T, K, T)
        K_I = K[0, 4]
        if K_I == 0:
            raise ValueError("K's last entry, K_I, is zero: leave it out")
        W = [[T / (tracking_time * K_I)]]
        return cls([[1]], [[0, T, 0, 0]], K[:, 4:], K[:, :4], T, W)

    @classmethod
    def appendix_b(cls, gain, T):
        """The thesis's realisation: both rates, summed by Euler's rule.

        The state x1 sums K_I U e and x2 sums T x1 + K_P e, with e the two
        rates; neither angle is measured. The thesis lacks U and names two
        signals wrongly. ``start`` presets x2, without which the law doesn't
        know at which tilt it begins.

        Parameters
        ----------
        gain : Gain
            As for `of_gain`.
        T : float
            Time between samples, in s.

        Notes
        -----
        Source: thesis (4.26), Appendix B.

        Examples
        --------
        >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
        >>> SampledLaw.appendix_b(gain, 0.01).start
        array([   0., 2000.])
        """
        K, T = pendulum_gain(gain), positive("T", T)
        K_I = K[0, 4] if K.shape[1] == 5 else 0.0
        A, B = [[1, 0], [T, 1]], [[0, 0, 0, K_I], [0, 0, *K[0, :2]]]
        return cls(A, B, [[0, T]], [[0, 0, *K[0, 2:4]]], T, start=[0, K[0, 0] / T])

    @classmethod
    def of_controller(cls, controller, T, W=None, start=None):
        """The zero-order hold of a controller from both rates to V.

        Parameters
        ----------
        controller : control.StateSpace or control.TransferFunction
            A controller from [theta', phi'] to V, in continuous time, or
            already sampled with this T. Inputs that have names have these two.
        T : float
            Time between samples, in s.
        W, start : array_like, optional
            As in `SampledLaw`.

        Notes
        -----
        Source: thesis (4.30), which is u = -H y.

        Examples
        --------
        >>> import control
        >>> lag = control.ss([[-1]], [[1, 0]], [[1]], [[0, 0]])
        >>> law = SampledLaw.of_controller(lag, 0.1)
        >>> float(law.A[0, 0].round(4)), law.B.round(4)
        (0.9048, array([[0.    , 0.    , 0.0952, 0.    ]]))
        """
        control = library("control")
        system = control.ss(controller)
        if (system.ninputs, system.noutputs) != (2, 1):
            raise ValueError("controller must take [theta', phi'] and give one voltage")
        rates = order_of(system, "input", PD_SIGNALS[2:])
        held = system
        if system.isctime(strict=True):
            held = control.sample_system(system, positive("T", T), "zoh")
        elif not (
            system.dt is True or (system.dt is None and not system.nstates)
        ) and system.dt != float(T):
            raise ValueError(
                f"controller is sampled with {system.dt!r}, not with T = {float(T)!r}"
            )
        rates = slice(None) if rates is None else rates
        seen = held.B[:, rates], held.D[:, rates]
        B, D = (np.hstack([np.zeros((len(x), 2)), x]) for x in seen)
        return cls(held.A, B, held.C, D, T, W, start)


def pendulum_gain(gain):
    """K of a `Gain` in the order of `PD_SIGNALS` or `PID_SIGNALS`.

    A ValueError says why a ``gain`` isn't a pendulum's.
    """
    measured = ", ".join(PD_SIGNALS)
    if not isinstance(gain, Gain):
        raise ValueError(
            "gain must be a Gain: an array doesn't say what its columns multiply. "
            "Give design.gain, or Gain(K, PD_SIGNALS) or Gain(K, PID_SIGNALS) if K "
            f"is of {measured} and, with five columns, of the {PID_SIGNALS[-1]}"
        )
    for names in (PD_SIGNALS, PID_SIGNALS):
        if set(names) == set(gain.signals) and len(gain.K) == 1:
            return gain.columns(names)
    older = [name for name in gain.signals if name.endswith(")")]
    others = [x for x in gain.signals if x not in (*PID_SIGNALS, *older)]
    lost = [name for name in PD_SIGNALS if name not in gain.signals]
    if older and not others:
        why = (
            f"it multiplies older voltages, {', '.join(older)}, which this law doesn't "
            'keep: a regulator that knows the delay is law = "observer" of '
            "a robot's description"
        )
    elif len(gain.K) > 1:
        why = f"it has {len(gain.K)} outputs, and both motors get one voltage"
    else:
        why = f"it multiplies {', '.join(gain.signals)}" + (
            f" and not {', '.join(lost)}" * bool(lost)
        )
    raise ValueError(
        f"gain isn't of a balancing robot: {why}. The robot measures {measured} and "
        f"sums phi; Mip.plant() has these names"
    )
