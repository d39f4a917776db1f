"""Limits of every linear controller, of any order, with a law's sensors."""

import numpy as np

from ...exact.rational import (
    decimal,
    decimals,
    echelon,
    exact,
    fractions,
    inverse,
    null_basis,
    round_digits,
)
from ...exact.refusal import MultiplierRefusal
from ...language import block, eye, he
from ...lmi import LMIProblem, Unknown
from ...lmi.text import LMIText
from ...runtime.time_limit import OutOfTime
from ..at_once import loudest
from ..fixed_mode import parts_data
from ..request_as_data import loop_data
from .central import balanced
from .moving_gain import corners_of, vertex_of

SECONDS = 20.0  # for each plant's multipliers
HIGHEST = 0.998  # of what was reached: below it a bound is sought
LOWER = 0.99, 0.95, 0.9, 0.5, 0.2, 0.05  # of it, in the order of trial
HALVINGS = 8  # of the way between two of them, as a ratio
BITS = 20  # of a rounded matrix of coordinates


def unseen(P, here, rate, push, out, bound):
    r"""The block of motions that sensors don't see, or that inputs don't move.

    Parameters
    ----------
    P : (r, r) matrix-like
        Symmetric.
    here, rate : (r, k) matrix-like
        x and x' of k motions that span all, in r coordinates.
    push : (p, k) matrix-like
        Their disturbance w.
    out : (q, k) matrix-like
        Their output z.
    bound : scalar
        Of the H-infinity norm from w to z.

    Returns
    -------
    matrix-like
        Positive definite for a P where a linear controller keeps the norm below the
        bound, of any order, that has these sensors. So multipliers that exclude every
        P exclude every controller.

    Notes
    -----
    Of x' = A x + B_w w + B u, z = C_z x + D_zw w + D_zu u, y = C x + D_yw w take the x
    of a subspace and the w for which y = 0 and x' is in the subspace. A controller at
    rest answers y = 0 with u = 0, so there the bounded real lemma of the whole loop,
    with a Lyapunov matrix L, is about Y alone, the plant's corner of L. The norm is
    that of the transposed loop, whose lemma has L^-1; so the same is true with A', B',
    C', ... in the place of A, C, B, ... and X, the plant's corner of L^-1. X and Y
    belong together: [X I; I Y] >= 0, as for every L, and > 0 with a little more of Y.
    In coordinates x = V v of the one subspace and U of the other it is
    [X U'V; V'U Y] > 0.

    Where the subspaces are as large as can be the three blocks say all: P. Gahinet and
    P. Apkarian, A linear matrix inequality approach to H-infinity control, Int. J.
    Robust Nonlinear Control 4, 1994, where sensors have noise and inputs a weight.
    """
    top = bound * (push.T @ push) - he(here.T @ P @ rate)
    return block([[top, out.T], [out, bound * eye(out.shape[0])]])


class AnyOrder(MultiplierRefusal):
    """No linear controller with a law's sensors keeps a bound of the H-infinity norm,
    by the blocks of `unseen`. ``text`` is a file with the plant, what
    the law joins to it, the requirement, the motions and the multipliers.
    """

    kind = "infeasible any order"

    @classmethod
    def contents(cls, request, r, d, given):
        """The data of the file, without the multipliers: of a ``request`` with a law,
        what ``r`` bounds, one of its plants ``d`` in rationals, and units and motions,
        ``given`` by `_problems`.
        """
        one, k = vertex_of(request, d)
        law = {"law": parts_data(request.applied.parts), "requirement": r.data()}
        return {**loop_data(one), **law, "vertex": k, **given}


def excluded(request, d, r, gamma):
    """The refusal of every controller with the sensors of a ``request``'s law that
    keeps ``gamma`` of ``r``, for one of its plants, ``d``, in rationals and without a
    controller; or None. Of ticks no file says it.
    """
    if request.step is not None:
        return None
    some = slice(None) if r.inputs is None else list(r.inputs)
    sensors = request.applied.parts
    r, plant = of_plant_alone(r, d, sensors)
    if r is None:
        return None
    data = plant.explicit(), sensors.rows, sensors.noise[:, some]
    for problem, given in _problems(*data, exact(gamma)):
        Z = problem
        if not isinstance(problem, dict):
            solution = problem.find()
            if solution.status == "feasible":  # so are the others
                return None
            refused = solution.infeasibility
            Z = refused.multipliers if refused is not None and refused.proven else None
        if Z is not None:
            asked = AnyOrder.contents(request, r.with_bound(gamma), d, given)
            proof = AnyOrder.of(AnyOrder.written_from(asked, Z, str))
            if proof.proven:
                return proof
    return None


def best_excluded(request, r, reached):
    """The largest gamma found that no linear controller keeps, below what a gain
    ``reached``, with its `LMIRefusal`: of ``r`` and a ``request`` with a law. None and
    None where no multipliers in rationals are found; where the time is over, the best
    so far.
    """
    best = None, None
    try:
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
    except OutOfTime:
        if best[0] is None:
            raise
    return best


def of_plant_alone(r, d, parts):
    """``r`` of a plant ``d`` without the ``parts`` that a law joins, and d with its
    output; None and None where that has the law's states in it.
    """
    try:
        r = r.resized(len(d.E) + len(parts.states), len(d.E))
        return r, r.seen(d)
    except ValueError:
        return None, None


def unseen_motions(A, B, C, D):
    """V, and here, rate, push: motions of x' = ``A`` x + ``B`` w with ``C`` x + ``D`` w
    = 0, in rationals and coordinates near orthonormal. x = V here stays in the range of
    V, the largest subspace for which there is a w, x' = V rate, and push is w. Source:
    H. L. Trentelman, A. A. Stoorvogel and M. Hautus, Control theory for linear systems,
    2001, chapter 7: the weakly unobservable subspace.
    """
    V = exact(np.eye(len(A)))
    while True:
        out = null_basis(V.T).T  # zero where x is in V
        held = np.vstack([np.hstack([C @ V, D]), np.hstack([out @ A @ V, out @ B])])
        motions = _tidy(null_basis(held))
        here, push = motions[: V.shape[1]], motions[V.shape[1] :]
        rows = echelon(here.T)[0] if here.size else []
        if len(rows) == V.shape[1]:
            break
        V = _tidy(V @ exact(np.array(rows, object).T)) if rows else V[:, :0]
    rate = here
    if V.shape[1]:
        rate = inverse(V.T @ V) @ (V.T @ (A @ V @ here + B @ push))
    return V, here, rate, push


def _tidy(V):
    """Rational columns with the same range, near orthonormal."""
    if 0 in V.shape:
        return V
    R = np.linalg.inv(np.linalg.qr(V.astype(float))[1])
    return V @ exact(_rounded(R))


def _rounded(T):
    """A matrix of floats to some bits of each column's largest entry."""
    scale = 2.0 ** np.floor(np.log2(np.abs(T).max(axis=0)))
    return np.round(T / scale * 2**BITS) / 2**BITS * scale


def _problems(d, C, Dyw, gamma):
    """Multipliers, by block, of what w does at once; both inequalities with their
    coupling; each by itself, with P > 0 and without, in
    units in which the plant is near one, with what a file says of units and motions.
    What follows from fewer of them has multipliers that are zero in the others: asked
    by itself, also of obstacles on the imaginary axis, it has them in rationals.
    """
    back, m = inverse(d.E), d.Bu.shape[1]
    A, Bw, B, Cz = back @ d.A, back @ d.Bw, back @ d.Bu, d.C
    Dzw, Dzu = (
        exact(np.zeros((len(Cz), n))) if x is None else x
        for x, n in ((d.Dw, Bw.shape[1]), (d.Du, m))
    )
    a, b, c = (x.astype(float) for x in (A, Bw, Cz))
    rate = float(np.abs(np.linalg.eigvals(a)).max()) or 1.0
    try:
        T = _rounded(balanced(a / rate, b, c))
    except np.linalg.LinAlgError:
        T = np.eye(len(a))
    of_w = rate / (np.linalg.norm(np.linalg.solve(T, b), 2) or rate)
    of_z = 1 / (np.linalg.norm(c @ T, 2) or 1.0)
    sizes = {"slow": 1 / rate, "of_w": of_w, "of_z": of_z}
    sizes = {name: 2.0 ** np.round(np.log2(x)) for name, x in sizes.items()}
    units = {name: decimal(x) for name, x in sizes.items()} | {"T": decimals(T)}
    slow, of_w, of_z = map(exact, sizes.values())
    T = exact(T)
    left = inverse(T)
    A, Bw = slow * (left @ A @ T), slow * of_w * (left @ Bw)
    B = slow * (left @ B)
    Cz, C = of_z * (Cz @ T), C @ T
    Dzw, Dzu, Dyw = of_z * of_w * Dzw, of_z * Dzu, of_w * Dyw
    level = of_z * of_w * gamma
    sides, spaces, motions = {}, {}, {}
    for name, (a, b, c, d, out, through) in {
        "X": (A.T, Cz.T, B.T, Dzu.T, Bw.T, Dzw.T),
        "Y": (A, Bw, C, Dyw, Cz, Dzw),
    }.items():
        found = _at_once(name, b, d, through, level)
        if found is not None:
            yield found[0], {"units": units, "sides": {name: found[1]}}
        V, here, rate, push = unseen_motions(a, b, c, d)
        if push.shape[1]:
            spaces[name] = V
            parts = dict(V=V, here=here, rate=rate, push=push)
            motions[name] = {x: fractions(y) for x, y in parts.items()}
            sides[name] = here, rate, push, out @ V @ here + through @ push
    sizes = {name: V.shape[1] for name, V in spaces.items() if V.shape[1]}
    if not sizes:
        return

    def problem(names, signed):
        """(LMIProblem, the file's data) of some sides."""
        known = [name for name in names if name in sizes]

        def write(values, number):
            """The blocks of the sides, and of P if it is ``signed``."""
            exactly = number(np.array([1.0])).dtype == object

            def data(x):
                return x if exactly else x.astype(float)

            one, none = level if exactly else float(level), np.zeros((0, 0))
            blocks = {
                _WORDS[x]: unseen(values.get(x, none), *map(data, sides[x]), one)
                for x in names
            }
            if signed and len(known) == 2:
                link = data(spaces["X"].T @ spaces["Y"])
                P = block([[values["X"], link], [link.T, values["Y"]]])
                blocks["together"] = P
            elif signed:
                blocks["together"] = values[known[0]]
            return blocks

        unknowns = [Unknown(x, sizes[x], symmetric=True) for x in known]
        given = {"units": units, "sides": {x: motions[x] for x in names}}
        return LMIProblem(LMIText(write, unknowns), time_limit=SECONDS), given

    yield problem(sides, True)
    for signed in (True, False):
        for name in sizes if len(sides) == 2 else ():
            yield problem([name], signed)


def _at_once(name, B, D, through, level):
    """The multiplier, by block, of x = 0 and a w with ``D`` w = 0 whose ``through`` w
    is too loud, and what a file says of that motion; or None.
    """
    still = null_basis(D)
    found = loudest(through @ still, still)
    if found is None or found[2] < level**2:
        return None
    push = (still @ found[0])[:, None]
    V, some = B @ push, exact(np.ones((1, 1)))
    if not (V != 0).any():
        V, some = V[:, :0], some[:0]
    parts = dict(V=V, here=0 * some, rate=some, push=push)
    v = np.vstack([[[exact(1.0)]], -found[1][:, None] / level])
    return {_WORDS[name]: v @ v.T}, {x: fractions(y) for x, y in parts.items()}


_WORDS = {"X": "not moved", "Y": "not seen"}  # which motions
