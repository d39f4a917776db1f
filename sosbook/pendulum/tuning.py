"""The weight and the decay that suit a robot, its clock and its delay.

The smallest weight of the voltage whose sampled loops keep their
distance from the critical point is searched, and then the fastest decay
that can be proven behind the hold.
"""

from decimal import Decimal

import numpy as np
from scipy.linalg import solve_continuous_are

from ..delay import DelayDesign, DelayRequest, solve_delay
from ..plants.descriptor import descriptors
from ..plants.gain import Gain
from ..sampled import certify_sampled
from ..synthesis.lqr import design_lqr
from .fit_spread import FitSpread
from .law import PID_SIGNALS, SampledLaw
from .margins import SampledLoop
from .optimal import optimal_law
from .rest import QUIET_SHARE, volts_at_rest
from .robot import WAITS
from .spread import polytope, vertices

__all__ = ["DELAY_SHARES", "design", "fall_time", "peak_of", "prove", "prove_sampled",
           "prove_varying", "recoverable_tilt", "timed"]  # fmt: skip

U = [[0, 1]]  # integrate phi
DELAY_SHARES = (0.0, 0.5, 1.0)  # of the largest delay, at which a loop is looked at
QUIET_SECONDS = 20.0  # of a simulation at rest, which tells whether a weight is loud
LOUDER_WEIGHTS = 9  # that are tried beyond the smallest: a thousand times as large
WEIGHTS = tuple(m * 10.0**k for k in range(-4, 6) for m in (1, 2, 5))
#: Of the decay that is asked for, one after the other.
DECAY_SHARES = 1, 0.5, 0.2, 0.1, 0.05, 0.0
#: Of T and the delay, to say which clock would do.
CLOCK_SHARES = 0.8 ** np.arange(1, 16)
DEFAULT_LAW = "observer"  # quiet where gears have play and encoders are coarse

#: Fall times: the error of a bridged reading grows by half, one of a frozen gyro or a
#: late clock by e, before the motors go off; encoders that rest may be at a wall; and
#: a rescue from 98 % of the tilt that no law exceeds is at its limit for log 50 = 3.9.
FALLS = dict(zip(WAITS, (0.4, 1.0, 4.0, 2.0, 1.0)))
#: Ticks, at least: by chance a sensor is silent, or a gyro repeats itself, so often.
LEAST = {"missing": 5, "frozen": 12}


def fall_time(mip):
    """The time in s in which a ``mip`` without voltage falls e times as far."""
    return float(1 / mip.plant().poles().real.max())


def timed(robot, mip):
    """A ``robot`` with a law and every wait: those not given by a ``mip``'s fall."""
    fall, told = fall_time(mip), {} if robot.law else {"law": DEFAULT_LAW}
    for name, falls in FALLS.items():
        if getattr(robot, name) is None:
            told[name] = round(max(falls * fall, LEAST.get(name, 0) * robot.T), 3)
    return robot.but(**told) if told else robot


def loops(robots, law, robot):
    """Rows of `SampledLoop` for no, half and all delay, by the delay."""
    return {
        late: tuple(
            SampledLoop(mip, law, late, "firmware", robot.blend) for mip in robots
        )
        for late in (share * robot.delay for share in DELAY_SHARES)
    }


def prove_sampled(parts, controller, robot, cells):
    """Proofs of sampled loops: by no, half and all delay one for each of ``parts``.

    They are of a ``controller``, a `SampledSystem`, with the robot's T and delay,
    and take so many ``cells``. The first delay without a proof is the last.
    """
    proofs = {}
    for late in (share * robot.delay for share in DELAY_SHARES):
        proofs[late] = tuple(
            certify_sampled(part, controller, robot.T, late, cells=cells)
            for part in parts
        )
        if not all(proof.proven for proof in proofs[late]):
            break
    return proofs


def prove_varying(parts, controller, robot, cells, seconds=None):
    """Proofs of sampled loops whose clock varies, one for each of ``parts``.

    As `prove_sampled`, of a ``controller`` in so many ``cells``, for every sequence of
    delays up to the robot's and of ticks that are late by at most its jitter. Empty
    where one isn't proven; all together take so many ``seconds`` at most, if given.
    """
    # sums of decimals: 0.005 - 0.0005 in floats is more than 0.0045
    T, late = (Decimal(repr(x)) for x in (robot.T, robot.jitter))
    clock, proofs = ((float(T - late), float(T + late)), (0.0, robot.delay)), []
    for part in parts:
        limit = seconds and seconds / len(parts)
        proof = certify_sampled(part, controller, *clock, cells=cells, time_limit=limit)
        if not proof.proven:
            return ()
        proofs.append(proof)
    return tuple(proofs)


def peak_of(robots, law, robot):
    """The largest peak of the sensitivity of the `loops` of robots and a law.

    The robot says how late the voltage acts and what is sensed.
    """
    return max(
        loop.sensitivity for row in loops(robots, law, robot).values() for loop in row
    )


def recoverable_tilt(mip, limit):
    """The largest tilt of a ``mip`` at rest that a voltage brings back, in rad.

    It is that of the linear plant: an input bounded by ``limit`` can't stop
    the unstable mode w'x' = p w'x + w'B V from beyond |w'B| limit / p.
    """
    (plant,) = descriptors(mip.plant())
    A, B, _ = plant.state_space()
    poles, left_vectors = np.linalg.eig(A.T)
    k = poles.real.argmax()
    w = left_vectors[:, k].real
    return float(abs(w @ B[:, 0] / w[0]) * limit / poles[k].real)


def design(mip, robot, spread, Q, R, peak, gears):
    """The `Design` of least cost or an `OptimalLaw`, for R or the smallest good one.

    ``mip``: the pendulum in the middle; ``robot``: the robot, whose law, T, delay and
    blend are used; ``spread``: the relative spread of e/c and e/a, or what a fit
    allows; ``Q``, (5, 5) array: the weight of the state and of the integral; ``R``:
    without it the smallest of 1, 2, 5, 10, ... with which all `loops` have a
    sensitivity of at most ``peak``, and whose `volts_at_rest`, with its ``gears``, are
    below a tenth of the limit; without such a one, the quietest of some that keep
    the peak; ``peak``: the largest sensitivity that is taken. Raises ValueError if
    there is no design, or no R will do; it says what clock would.
    """

    def made(R):
        if robot.law == "gain":
            return _designed(mip, spread, Q, R)
        return optimal_law(mip, robot, Q, R)

    if R is not None:
        return made(R)
    tried, laws = {}, {}

    def good(k):
        tried[k] = found = made(WEIGHTS[k])
        laws[k] = getattr(found, "law", None) or SampledLaw.of_gain(
            found.gain.but(found.certify().K), robot.T
        )
        return peak_of((mip, *vertices(mip, spread)), laws[k], robot) <= peak

    for k, weight in enumerate(WEIGHTS):
        if _guessed(mip, robot, Q, weight) <= peak and good(k):
            break
    else:
        if tried and isinstance(spread, FitSpread):
            raise ValueError(
                f"no R keeps the peak of the sensitivity at {peak:g} or below for all "
                f"robots that the logs allow. {spread.cure}"
            )
        raise ValueError(_too_slow(mip, robot, Q, peak))
    # the guess is of the plant in the middle, and a gain's of Riccati's equation
    while k > 0 and k - 1 not in tried and good(k - 1):
        k -= 1
    volts, quiet = {}, QUIET_SHARE * robot.limit
    for j in range(k, min(k + LOUDER_WEIGHTS, len(WEIGHTS))):
        if j > k and not good(j):
            break
        volts[j] = volts_at_rest(mip, laws[j], robot, QUIET_SECONDS, gears)
        if volts[j] <= quiet:
            break
    return tried[min(volts, key=volts.get)]


def _designed(mip, spread, Q, R):
    robust = design_lqr(polytope(mip, spread), Q, [[R]], U)
    if robust.status != "feasible":
        raise ValueError(f"no design for R = {R:g}: {robust.advice}")
    return robust


def _guessed(mip, robot, Q, R):
    """The peak for the one plant in the middle; a gain's is Riccati's."""
    try:
        if robot.law != "gain":
            return peak_of([mip], optimal_law(mip, robot, Q, R).law, robot)
        gain = Gain(_riccati(mip, Q, R), PID_SIGNALS)
        return peak_of([mip], SampledLaw.of_gain(gain, robot.T), robot)
    except ValueError:  # no gain of the integral, or no solution in floats
        return np.inf


def _riccati(mip, Q, R):
    """The gain of least cost for one plant, in continuous time."""
    (plant,) = descriptors(mip.plant(), U)
    A, B, _ = plant.state_space()
    return -B.T @ solve_continuous_are(A, B, Q, [[R]]) / R


def _too_slow(mip, robot, Q, peak):
    """The clock that is fast enough, in words."""
    sentence = (
        f"no R keeps the peak of the sensitivity at {peak:g} or below "
        f"with T = {1000 * robot.T:g} ms and a delay of "
        f"{1000 * robot.delay:g} ms: {_fastest(mip)}, and the faster of "
        "both is too fast for this clock"
    )
    seeing = robot.but(law="observer")
    if robot.law != "observer" and any(
        _guessed(mip, seeing, Q, R) <= peak for R in WEIGHTS[::2]
    ):
        sentence += '. law = "observer" would do with it'
    for share in CLOCK_SHARES:
        clock = robot.but(T=robot.T * share, delay=robot.delay * share)
        if any(_guessed(mip, clock, Q, R) <= peak for R in WEIGHTS[::2]):
            return (
                f"{sentence}. About {1 / clock.T:.0f} Hz and "
                f"{1000 * clock.delay:.2g} ms would do"
            )
    return f"{sentence}, and one of {1 / clock.T:.0f} Hz wouldn't do either"


def _fastest(mip):
    """The motions that the clock has to follow, in words: the fall and the motors."""
    poles = mip.plant().poles().real
    fall, motor = poles.max(), -poles.min()
    return (
        f"the robot's fall grows by e in {1000 / fall:.3g} ms and the motors' own "
        f"back-EMF settles their speed in {1000 / motor:.3g} ms"
    )


def prove(plants, U, robot, K, decay):
    """The `DelayDesign` of the fastest decay that can be proven for a gain.

    It tries ``decay`` by either theorem, then smaller ones. What is proven is a
    decay for every delay from 0 to T + delay + jitter, however it varies.

    ``plants``, Polytope: the plants; ``U``, (a, n) array_like: which angles are
    integrated; ``robot``: its times are used; ``K``, (m, 2 n + a) array: the gain;
    ``decay``: the most that is asked for, in 1/s. Raises ValueError if not even
    stability can be proven; it says what is known of the loop itself.
    """
    half = (robot.T + robot.delay + robot.jitter) / 2
    true, at = DelayDesign(
        DelayRequest(plants, U, half, half, gain=K), "undecided", K
    ).slowest_decay()
    if true <= 0:
        raise ValueError(
            f"a loop of the polytope is unstable for a delay of "
            f"{1000 * at:.3g} ms, which the hold and the computer may make: "
            "take a larger R, a smaller T, delay or spread"
        )
    rates = {share * decay for share in DECAY_SHARES if share * decay < true}
    tried = {}
    for rate in sorted(rates | {0.0}, reverse=True):
        for method in ("functional", "shift"):
            request = DelayRequest(
                plants, U, half, half, delta=rate, method=method, gain=K
            )
            # a proof that there is none takes long: only of the last one
            delayed = solve_delay(request, refuse=not rate)
            if delayed.status == "feasible" and delayed.certify().proven:
                return delayed
            tried[method] = delayed.status
    raise ValueError(
        f"no decay rate is proven for delays from 0 to {2000 * half:g} ms, "
        "however they vary ("
        + ", ".join(f"{method}: {status}" for method, status in tried.items())
        + "). For constant delays the loops decay at "
        f"{true:.3g}/s or faster, so it is the proof that lacks means and "
        'not the gain: take a smaller spread, a larger R, or law = "observer", '
        "of which constant delays alone are proven"
    )
