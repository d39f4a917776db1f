"""The doors of "infeasible" for a law: what excludes every gain, exactly."""

from math import floor, log10

import numpy as np

from ...analysis.lyapunov import lyapunov
from ...exact.proof import Examined
from ...exact.rational import (
    decimals,
    exact,
    fractions,
    inverse,
    read_fractions,
    round_digits,
)
from ...exact.refusal import Refusal
from ...lmi import LMIProblem, Unknown
from ...requirements.vocabulary import SIGMA
from ...runtime.time_limit import OutOfTime, time_limit
from ...theorems import any_order
from ..broken import alone
from ..feasibility import answer
from ..known_certificate import Joined, parts_data
from ..request import Request
from ..request_as_data import loop_data, read_request
from ..solution import Solution
from .loops import corners_of

__all__ = [
    "SumOfPoles",
    "best_excluded",
    "excluded",
    "mean_pole",
    "refused_by_a_door",
    "refused_by_sum",
]

SECONDS = 20.0  # for each plant's multipliers
HIGHEST = 0.998  # of what was reached: below it a bound is sought
LOWER = 0.99, 0.95, 0.9, 0.5, 0.2, 0.05  # of it, in the order of trial
HALVINGS = 5  # of the way between two of them, as a ratio


class SumOfPoles(Refusal):
    """The poles' mean lies too far right, and no gain of the law moves it.

    The sum of the poles is the trace of E^-1 (A + B K C_y), and every K_k of the law
    has a product of trace zero there. ``text`` is that of a file with the plant, what
    the law joins to it, the K_k and the half-plane.
    """

    kind = "sum of poles"

    @classmethod
    def examine(cls, data):
        directions = [read_fractions(K) for K in data["gains"]]
        if not directions or data["U"]:
            raise ValueError("the gains of a law are needed, and no U")
        law, wide = Joined(data["law"], len(directions[0])), directions[0].shape
        asked = dict(coupling="multipliers", epsilon=None, E0=None)
        asked = data | asked | dict(requirements=[data["requirement"]])
        request = read_request(asked, gain=decimals(np.zeros(wide)), law=law)
        (r,), places = request.requirements, list(corners_of(request).items())
        k, parts = data["vertex"], request.law_parts
        if type(k) is not int or not 0 <= k < len(places) or r.parameter is not SIGMA:
            raise ValueError("a vertex, from 0, and a half-plane are needed")
        mean = mean_pole(places[k][1], parts, directions)
        if mean is None:
            raise ValueError("a gain moves the sum of the poles")
        gains = [fractions(K) for K in directions]
        known = dict(loop_data(request), law=parts_data(parts), gains=gains)
        again = cls.contents(known, r, k, places[k][0], mean)
        beyond = mean + exact(r.bound)
        failed = () if beyond > 0 else ("mean",)
        claims = () if failed else tuple(again["claims"])
        return again, Examined(claims, {"mean": float(beyond)}, failed)

    @classmethod
    def contents(cls, known, r, k, where, mean):
        """The data of the file.

        Parameters
        ----------
        known : dict
            Plant, U, K_A, law and gains.
        r : Requirement
            The half-plane.
        k, where : int and str
            The number and the words of the plant that has the poles.
        mean : Rational
            Of its poles.
        """
        claim = (
            f"no gain of the law moves the sum of the poles of {where}; one "
            f"of them has a real part of at least {_downwards(mean)}, so none keeps: "
            f"{r.statement}"
        )
        return {"claims": [claim], **known, "requirement": r.data(), "vertex": k}


def _downwards(x):
    """A rational in six digits, not above it."""
    words = f"{float(x):.6g}"
    if exact(float(words)) <= x:
        return words
    return f"{float(x) - 10.0 ** (floor(log10(abs(float(x)))) - 5):.6g}"


def mean_pole(d, parts, directions):
    """The mean of the poles of a plant d with a law; None if a gain moves it.

    Parameters
    ----------
    d : Descriptor
        Without the law, in rationals.
    parts : Parts
        What the law joins.
    directions : list of arrays
        Of its gains.
    """
    whole = parts.joined(d)
    back = inverse(whole.E)
    pushed, measured = back @ whole.Bu, parts.measured
    if any((pushed @ exact(K) @ measured).trace() != 0 for K in directions):
        return None
    return (back @ whole.A).trace() / len(whole.E)


def refused_by_sum(request, loops):
    """The Solution of a request whose decay the sum of the poles excludes; or None.

    Parameters
    ----------
    request : Request
        With a law.
    loops : Loops
        Its loops, whose structure is read.
    """
    asked = [r for r in request.requirements if r.parameter is SIGMA]
    if not asked:
        return None
    r = max(asked, key=lambda r: r.bound)
    parts = request.law_parts
    for k, (where, d) in enumerate(corners_of(request).items()):
        mean = mean_pole(d, parts, loops.directions)
        if mean is None or mean + exact(r.bound) <= 0:
            continue
        gains = [fractions(exact(K)) for K in loops.directions]
        known = dict(loop_data(request), law=parts_data(parts), gains=gains)
        proof = SumOfPoles.of(SumOfPoles.contents(known, r, k, where, mean))
        text = f"{proof.claims[0][0].upper()}{proof.claims[0][1:]}."
        return Solution(request, "infeasible", None, reason=text, infeasibility=proof)
    return None


def excluded(request, d, r, gamma):
    """The refusal of every controller for a plant and a gamma, or None.

    Parameters
    ----------
    request : Request
        With a law, whose sensors count.
    d : Descriptor
        One of its plants, without a controller, in rationals.
    r : Requirement
        It bounds an H-infinity norm.
    gamma : float
        That bound.
    """
    some = slice(None) if r.inputs is None else list(r.inputs)
    seen, sensors, part = _seen(r, d), request.law_parts, request.plant.reduction
    if seen is None:
        return None
    noise, of = sensors.noise[:, some], "" if part is None else f" {part.words[:-2]}"
    problem = _problem(seen.explicit(), sensors.rows, noise, exact(gamma), of)
    proof = problem.find().infeasibility
    return proof if proof is not None and proof.proven else None


def best_excluded(request, r, reached):
    """The largest gamma found that no linear controller keeps, with its proof.

    Parameters
    ----------
    request : Request
        With a law.
    r : Requirement
        It bounds an H-infinity norm.
    reached : float
        What a gain reaches: the answer lies below.

    Returns
    -------
    tuple
        Gamma and the `LMIRefusal`, or None and None: exact multipliers aren't found
        everywhere, least where free masses or noiseless sensors leave them irrational.
    """
    best = None, None
    for d in corners_of(request).values():

        def proof(share, d=d):
            gamma = float(round_digits(share * reached, 4))
            found = excluded(request, d, r, gamma)
            return found and (gamma, found)

        high, found = HIGHEST, None
        for low in LOWER if best[0] is None else (1.01 * best[0] / reached,):
            found = proof(low) if low < high else None
            if found is not None:
                break
            high = low
        if found is None:
            continue
        best = found
        for _ in range(HALVINGS):
            middle = float(np.sqrt(low * high))
            found = proof(middle)
            if found is None:
                high = middle
            else:
                low, best = middle, found
    return best


def _problem(d, rows, noise, gamma, of):
    """The blocks of `any_order` in units in which the plant is near one.

    They are named, and ``of`` which plant.
    """
    back, N = inverse(d.E), len(d.E)
    m, q = d.Bu.shape[1], len(rows)

    def zero(x, shape):
        return exact(np.zeros(shape)) if x is None else x

    matrices = [
        back @ d.A, back @ d.Bw, back @ d.Bu, d.C, rows,
        zero(d.Dw, (len(d.C), d.Bw.shape[1])),
        zero(d.Du, (len(d.C), m)), noise,
    ]  # fmt: skip
    A, Bw, B, Cz, C, Dzw, Dzu, Dyw = (x.astype(float) for x in matrices)
    rate = float(np.abs(np.linalg.eigvals(A)).max()) or 1.0
    T = _coordinates(A / rate, Bw, Cz)
    left = np.linalg.inv(T)
    of_w = 1 / (np.linalg.norm(left @ Bw, 2) / rate or 1.0)
    of_z = 1 / (np.linalg.norm(Cz @ T, 2) or 1.0)
    of_u = 1 / (np.linalg.norm(left @ B, 2) / rate or 1.0)
    of_y = 1 / (np.linalg.norm(C @ T, 2) or 1.0)
    T, slow, of_w, of_z, of_u, of_y = (
        exact(2.0 ** np.round(np.log2(x))) if np.ndim(x) == 0 else exact(x)
        for x in (T, 1 / rate, of_w, of_z, of_u, of_y)
    )
    left = inverse(T)
    A, Bw, B, Cz, C, Dzw, Dzu, Dyw = matrices
    scaled = (
        slow * (left @ A @ T), slow * of_w * (left @ Bw), slow * of_u * (left @ B),
        of_z * (Cz @ T), of_y * (C @ T), of_z * of_w * Dzw, of_z * of_u * Dzu,
        of_y * of_w * Dyw,
    )  # fmt: skip
    level = of_z * of_w * gamma
    unknowns = [
        Unknown("X", N, symmetric=True), Unknown("Y", N, symmetric=True),
        Unknown("Ah", N, N), Unknown("Bh", N, q), Unknown("Ch", m, N),
        Unknown("Dh", m, q),
    ]  # fmt: skip

    def write(values, number):
        exactly = number(np.array([1.0])).dtype == object
        data = scaled if exactly else [x.astype(float) for x in scaled]
        P, loop = any_order(data, values, level if exactly else float(level))
        return {f"P{of}": P, f"loop{of}": loop}

    return LMIProblem(write, unknowns, time_limit=SECONDS)


def _coordinates(A, B, C):
    """Rounded coordinates in which what w moves and what z sees are of one size."""
    N = len(A)
    slower = A - (max(np.linalg.eigvals(A).real.max(), 0) + 0.1) * np.eye(N)
    reach = lyapunov(slower, -B @ B.T)
    seen = lyapunov(slower.T, -C.T @ C)
    reach += 1e-6 * np.trace(reach) / N * np.eye(N)
    seen += 1e-6 * np.trace(seen) / N * np.eye(N)
    try:
        L = np.linalg.cholesky(reach)
        U, s, _ = np.linalg.svd(L.T @ seen @ L)
        T = L @ U * s**-0.25 if s.all() else L  # an output without x, as u alone
    except np.linalg.LinAlgError:
        return np.eye(N)
    scale = 2.0 ** np.floor(np.log2(np.abs(T).max(axis=0)))
    return np.round(T / scale * 2**20) / 2**20 * scale


def refused_by_a_door(request):
    """The Solution of a request that excludes every controller at a corner; or None.

    One requirement at a time: by all of the state, and for a norm by every controller
    that sees what the law sees.
    """
    corners, part = corners_of(request), request.plant.reduction
    for where, d in corners.items():
        for r in request.requirements:
            proof, who = _all_of_the_state(request, d, r), "that sees all of the state"
            if proof is None and r.bounds_response() is not None:
                who = "of any order, with these sensors,"
                proof = excluded(request, d, r, r.bound)
            if proof is not None:
                at = f" at {where}" if len(corners) > 1 else ""
                text = f"No linear controller {who} keeps{at}: {r.statement}."
                if part is not None:
                    text = f"O{part.words[1:]}n{text[1:]}"
                return Solution(
                    request, "infeasible", None, reason=text, infeasibility=proof
                )
    return None


def _all_of_the_state(request, d, r):
    """The refusal of a requirement of a plant d by a state feedback, or None.

    Where x is measured without noise a static K does what any linear controller does:
    poles that can be moved go anywhere, and for the norm see P. P. Khargonekar, I. R.
    Petersen and M. A. Rotea, IEEE Trans. Automat. Control 33, 1988.
    """
    noisy = (request.law_parts.noise != 0).any()
    if r.pole_matrices() is None and (r.bounds_response() is None or noisy):
        return None
    seen = _seen(r, d)
    plant = seen and alone(seen, request.plant)
    if plant is None:
        return None
    try:
        one = Request(plant, requirements=[r.of_plant()])
        with time_limit(SECONDS):
            solution = answer(one)
    except (OutOfTime, np.linalg.LinAlgError, ArithmeticError):
        return None
    refused = solution.status == "infeasible" and solution.infeasibility.proven
    return solution.infeasibility if refused else None


def _seen(r, d):
    """A plant d with the output of r; None where that has the law's states in it."""
    try:
        return r.seen(d)
    except ValueError:
        return None
