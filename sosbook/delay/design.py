"""Procedure 2.2: a PID controller for a plant with a delayed input."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..lmi.exact import exact, round_digits
from ..lmi.problem import LMIProblem
from ..lmi.proof import Proof, refute
from ..plants.checks import matrix
from ..synthesis.gains import Gains
from . import spectrum
from .request import DelayedLoop, DelayRequest, check_loop
from .simulation import simulate_delay

__all__ = [
    "DelayCertificate",
    "DelayDesign",
    "analyse_delay",
    "design_delay_pid",
]

# alpha in units of tau, in the order of trial
ALPHAS = (2.0, 1.0, 4.0, 0.5, 8.0, 0.25, 16.0)


@dataclass(frozen=True, eq=False)
class DelayCertificate(Proof):
    """An exact proof of a decay rate under delay, or its failure.

    Parameters
    ----------
    proven, claims, blocks, failed
        As in `Proof`.
    K : (m, N) array
        The gain that the proof is about: rounded to the printed digits.
    functional : dict
        The rational matrices of the functional and the multipliers, as
        decimal floats, in the coordinates of the LMIs.
    """

    K: np.ndarray
    functional: dict


@dataclass(frozen=True, eq=False, repr=False)
class DelayDesign(Gains):
    """A controller behind a delay and what is known about its loop.

    Parameters
    ----------
    request : DelayRequest
        The plant, the delay's interval and what was asked.
    status : {"feasible", "infeasible", "undecided"}
        Of the LMIs, as in `Design`. "undecided" too where no alpha of
        the search succeeds.
    K : (m, N) array or None
        ``[K_P K_D K_I]``, in ``u(t) = K x(t)``, which reaches the plant
        at the time t + delay.
    values : dict or None
        The unknown matrices by name, in the coordinates of the LMIs.
    margins : dict or None
        From a block's name to its smallest eigenvalue, after scaling
        its diagonal to one.
    multipliers : list of arrays or None
        Of the blocks, where there is no solution.
    """

    request: DelayRequest
    status: str
    K: np.ndarray = None
    values: dict = None
    margins: dict = None
    multipliers: list = None

    @property
    def alpha(self):
        """The alpha that was given or found, in seconds."""
        return self.request.alpha

    def _gain(self):
        if self.K is None:
            raise ValueError(
                f"the design is {self.status}: there is no gain; ask for "
                "a smaller delta or mu"
            )
        return self.K

    def certify(self, digits=6):
        """Prove the decay rate in exact arithmetic.

        Parameters
        ----------
        digits : int
            K is rounded to so many significant digits first: the proof
            is about the gain as it is printed.

        Returns
        -------
        DelayCertificate

        Notes
        -----
        The exponentials of the theorem are rounded to rationals on the
        side on which the theorem stays true.
        """
        if self.values is None:
            raise ValueError(
                f"the design is {self.status}: there is nothing to "
                "certify; ask for a smaller delta or mu"
            )
        return _prove(self, digits)

    @cached_property
    def infeasibility(self):
        """`InfeasibilityCertificate` where one was found, else None."""
        if self.multipliers is None:
            return None
        expressions, unknowns = self.request.in_unknowns(exact)
        return refute(expressions, unknowns, self.multipliers)

    def _loops(self):
        K = self._gain()
        return [spectrum.delayed_loop(d, K) for d in self.request.vertices]

    def _each(self, found):
        single = not hasattr(self.request.plant, "sample")
        return found[0] if single else found

    def roots(self, delay, count=10):
        """Rightmost characteristic roots for a constant delay.

        A list of arrays, one per vertex, for a Polytope.
        """
        return self._each([
            spectrum.characteristic_roots(A, Ad, delay, count)
            for A, Ad in self._loops()
        ])

    def slowest_decay(self):
        """The true decay rate over all constant delays of the interval.

        Returns
        -------
        rate, delay : float
            The smallest rate over the vertices, in 1/s (negative: the
            loop is unstable there), and the delay where it occurs.
        """
        low = self.request.tau - self.request.mu
        high = self.request.tau + self.request.mu
        return min(
            spectrum.slowest_decay(A, Ad, low, high)
            for A, Ad in self._loops()
        )

    def stable_delays(self, longest):
        """Intervals of constant delays up to ``longest`` that are stable.

        A list of them per vertex for a Polytope.
        """
        return self._each([
            spectrum.stable_delays(A, Ad, longest) for A, Ad in self._loops()
        ])

    def simulate(self, t, delay, r=None, w=None, x0=None, history=None):
        """`DelayedResponse` of the loop; a list of them per vertex.

        Parameters as in `simulate_delay`.
        """
        K = self._gain()
        return self._each([
            simulate_delay(d, K, t, delay, r, w, x0, history)
            for d in self.request.vertices
        ])


def design_delay_pid(plant, U=None, tau=None, mu=0.0, delta=0.0,
                     alpha=None, K_A=None, method="functional",
                     printed=False):
    r"""Design a PID controller whose input arrives late.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        With regular masses. A polytope gets one functional for all its
        plants; they may even change with time.
    U : (a, n) array_like, optional
        Which displacement errors are integrated.
    tau, mu : float
        The delay d(t) stays in [tau - mu, tau + mu], in seconds, and may
        vary there as fast as it likes; tau > 0, 0 <= mu <= tau.
    delta : float
        Decay rate, in 1/s; 0 asks for stability.
    alpha : float, optional
        The positive scalar of Theorem 2.3, in seconds. Without it the
        first of some multiples of tau that succeeds.
    K_A : None
        Must be left out (or zero): see Raises.
    method : {"functional", "shift"}
        "functional" is the thesis's theorem, corrected. "shift" designs
        for stability of :math:`e^{\delta t} x(t)`, whose input comes
        multiplied by :math:`e^{\delta d}`, an uncertain factor.
    printed : bool
        Read Theorem 2.3 as printed: unsound, for study only.

    Returns
    -------
    DelayDesign
        The analytic centre of the LMIs, under a lid, for they are a
        cone.

    Raises
    ------
    ValueError
        On bad input. Acceleration feedback through a delay makes a
        neutral loop, M z''(t) - B K_A z''(t - d), which the theorems
        don't cover.

    Notes
    -----
    Source: thesis, Procedure 2.2 and Theorem 2.3 with its errata.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> plant = SecondOrderSystem(
    ...     M=np.eye(2), D=[[1, -1], [-1, 1]], S=[[3, -2], [-2, 3]],
    ...     B=[[1], [0]])
    >>> d = design_delay_pid(plant, U=[[1, 0]], tau=0.4, mu=0.2,
    ...                      delta=0.1, alpha=0.8)
    >>> d.status, d.certify().proven, d.slowest_decay()[0] > 0.1
    ('feasible', True, True)
    """
    _no_acceleration(K_A)
    if isinstance(plant, DelayedLoop):
        raise ValueError(
            "a DelayedLoop leaves nothing to design: use analyse_delay")
    request = DelayRequest(
        plant, U, tau, mu, delta, alpha, method,
        misprints=("sign",) if printed else (),
    )
    return _searched(request)


def analyse_delay(plant, K=None, U=None, tau=None, mu=0.0, delta=0.0,
                  method="functional", order=2, K_A=None, printed=False,
                  alpha=None):
    """Find a certificate of decay under delay for a given gain.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DelayedLoop
    K : (m, N) array_like
        ``[K_P K_D K_I]``; left out for a `DelayedLoop`.
    U, tau, mu, delta, K_A
        As in `design_delay_pid`.
    method : {"functional", "shift", "legendre"}
        "functional" is Theorem A.3, corrected, with G free. "legendre"
        uses Bessel's inequality: sharper, for one plant.
    order : int
        Of "legendre": how many polynomials.
    printed : bool
        Read Theorem A.3 as printed: unsound, for study only.
    alpha : float, optional
        The factor in the printed (A.20), without unit; 1 without it.

    Returns
    -------
    DelayDesign
        With this very K; "infeasible" means that no functional of this
        form proves the rate, not that the loop is slower.

    Notes
    -----
    Source: thesis, Theorem A.3 with its errata; Seuret and Gouaisbaut
    (2015) for "legendre".

    Examples
    --------
    >>> from sosbook.delay import DelayedLoop
    >>> loop = DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])
    >>> analyse_delay(loop, tau=6.16, method="legendre").status
    'feasible'
    """
    _no_acceleration(K_A)
    if K is None and not isinstance(plant, DelayedLoop):
        raise ValueError("K is missing: give the gain to be analysed")
    check_loop(plant, K, U)
    if alpha is not None and not printed:
        raise ValueError(
            "alpha stands in the printed (A.20) only: leave it out")
    request = DelayRequest(
        plant, U, tau, mu, delta, alpha, method, order,
        ("sign", "transpose", "alpha") if printed else (), K,
    )
    return solve_delay(request)


def _no_acceleration(K_A):
    if K_A is not None and np.any(matrix("K_A", K_A)):
        raise ValueError(
            "K_A must be zero with a delayed input: it makes the loop "
            "neutral, M z''(t) - B K_A z''(t - d), which the theorems "
            "don't cover; leave K_A out"
        )


def _searched(request):
    if request.alpha is not None:
        return solve_delay(request)
    for ratio in ALPHAS:
        alpha = float(round_digits(request.tau * ratio, 2))
        found = solve_delay(request.at(alpha=alpha), refuse=False)
        if found.status == "feasible":
            return found
    return DelayDesign(request, "undecided", request.gain)


def solve_delay(request, refuse=True):
    """The `DelayDesign` of a request with all its scalars.

    Parameters
    ----------
    request : DelayRequest
    refuse : bool
        Look for multipliers that exclude a solution, which takes longer.
    """
    point = LMIProblem(request.blocks, request.unknowns()).solve(
        refuse, lid=True)
    if point.values is None:
        return DelayDesign(
            request, point.status, request.gain,
            multipliers=point.multipliers)
    values, margins = point.values, point.margins
    K, frame = request.gain, request.frame
    if K is None:
        K = np.linalg.solve(values["F"], values["X"].T).T
        K = frame.scale * np.linalg.solve(frame.T.T, K.T).T
    found = DelayDesign(request, "feasible", K, values, margins)
    if min(margins.values()) > 1e-9 or _prove(found, 17).proven:
        return found
    return DelayDesign(request, "undecided", K, values, margins)


def _prove(design, digits):
    """Every block in exact arithmetic, for the rounded gain."""
    if not isinstance(digits, int) or digits < 1:
        raise ValueError(f"digits must be 1 or more, got {digits!r}")
    request, frame = design.request, design.request.frame
    K = round_digits(design.K, digits)
    fixed = request if request.gain is None else request.at(gain=K)
    for places in (12, 17):
        values = {n: round_digits(v, places)
                  for n, v in design.values.items()}
        numbers = {n: exact(v) for n, v in values.items()}
        if request.gain is None:  # X = K F' of the rounded gain
            gain = exact(K) @ exact(frame.T) / exact(frame.scale)
            numbers["X"] = gain @ numbers["F"].T
        found = Proof.of(fixed.blocks(numbers, exact), _claims(request))
        if found["proven"]:
            break
    return DelayCertificate(**found, K=K, functional=values)


def _claims(request):
    if request.misprints:
        return ("the LMIs as printed hold: that proves nothing about "
                "the loop",)
    low, high = request.tau - request.mu, request.tau + request.mu
    delays = (
        f"the constant delay {request.tau:.12g} s" if request.mu == 0 else
        f"every delay in [{low:.12g}, {high:.12g}] s, however it varies"
    )
    rate = (
        f"decays at least as fast as exp(-{request.delta:.12g} t)"
        if request.delta else "is exponentially stable"
    )
    if isinstance(request.plant, DelayedLoop):
        subject = "the loop"
    elif len(request.vertices) > 1:
        subject = "every plant of the polytope, under u = K x(t - d),"
    else:
        subject = "the plant, under u = K x(t - d),"
    return (f"{subject} {rate} for {delays}",)
