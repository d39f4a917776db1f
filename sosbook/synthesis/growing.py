"""Exact proofs that a large loop has a pole outside of a region: something grows."""

import numpy as np
from scipy.linalg import LinAlgError

from ..exact.proof import PLACES
from ..exact.rational import decimals, round_digits
from ..exact.refusal import Refusal
from ..requirements.base import Requirement
from ..requirements.lmi_region import by_matrices
from ..requirements.stability import Stability
from ..runtime.time_limit import check_time, check_time_of_eigenvalues
from .request_as_data import loop_data

FROM_STATES = 25  # below, the exact polynomial of the loop takes no longer
CLEARLY = 1e-10  # of the fastest pole: so far outside it must be
DIGITS = 6  # of what needn't be sharp
BELOW = 1e-9  # of the region's level, by which the file's may be less


class GrowingRefusal(Refusal):
    """A form that grows along a loop with a given gain, and is positive somewhere: the
    loop has a pole outside of what is asked.

    Its ``text`` is a file with a witness v, of which v* (alpha + beta s + beta'
    conj(s)) v = level + 2 Re(b s): every pole that keeps what is asked lies where that
    is negative. It has a symmetric P with (b A)' P E + E' P (b A) + level E' P E > 0,
    for the loop E x' = A x, and an x with x' E' P E x > 0. By Lyapunov's theorem no
    such P and x are there if all poles keep it. A complex b stands for a matrix of two
    rows.
    """

    kind = "growing"

    @property
    def place(self):
        """As `FixedModeRefusal.place`."""
        return tuple(self.data["place"])

    @property
    def requirement(self):
        """The requirement that a pole breaks, in words."""
        asked = self.data["requirement"]
        r = Stability() if asked is None else Requirement.read(asked)
        return r.words or r.name


def refuse_by_growth(request, place, asked):
    """The `GrowingRefusal` of a ``request`` with a gain at a ``place``, for the one of
    the requirements ``asked`` that a pole breaks the most; None if none is found.
    """
    E, A = loop_at(request, place)
    check_time_of_eigenvalues(len(A))
    try:
        poles, V = np.linalg.eig(np.linalg.solve(E, A))
        W = np.linalg.inv(V)
    except (LinAlgError, np.linalg.LinAlgError):
        return None
    worst = worst_pole(poles, asked)
    if worst is None:
        return None
    k, r = worst
    r = by_matrices(r)
    alpha, beta = (x.astype(float) for x in r.pole_matrices())
    s = poles[k]
    v = np.linalg.eigh(alpha + beta * s + beta.T * s.conj())[1][:, -1]
    v = round_digits(v.real, DIGITS) + 1j * round_digits(v.imag, DIGITS)
    level, b = (v.conj() @ alpha @ v).real, v.conj() @ beta @ v
    rates = 2 * (b * poles).real
    level = _level(rates, rates[k], level - BELOW * abs(level))
    signs = np.where(rates + level > 0, 1.0, -1.0)
    back = np.linalg.inv(E)
    H = back.T @ (W.conj().T * signs) @ W @ back
    P, x = H.real, V[:, k].real
    if b.imag:
        P, x = _doubled(H), np.concatenate([V[:, k].real, V[:, k].imag])
    P = (P + P.T) / (2 * abs(P).max())
    stable = r.key == Stability().key
    for digits in PLACES:
        check_time()
        proof = GrowingRefusal.of(
            {
                **loop_data(request),
                "K": decimals(request.gain),
                "requirement": None if stable else r.data(),
                "place": list(place),
                "witness": decimals(np.array([v.real, v.imag]).T),
                "level": decimals([[level]])[0][0],
                "form": decimals(round_digits(P, digits)),
                "start": decimals(round_digits(x[:, None], DIGITS)),
            }
        )
        if proof.proven:
            return proof
    return None


def loop_at(request, place):
    """E and A of the loop of a ``request`` with a gain at a ``place``, in floats."""
    pair = [request.vertices[k] for k in place]
    E, A, B = (
        sum(np.array(getattr(d, x), float) for d in pair) / 2 for x in ("E", "A", "Bu")
    )
    return E, A + B @ request.gain


def worst_pole(poles, asked):
    """(which of the ``poles`` lies outside the most, by its number, and of which of the
    requirements ``asked``), of the fastest pole's size; None if none clearly does.
    """
    found, size = (CLEARLY, None), abs(poles).max()
    for r in asked:
        form = r.pole_matrices()
        if form is None:
            continue
        alpha, beta = (np.array(x, float) for x in form)
        at = poles[:, None, None]
        out = np.linalg.eigvalsh(alpha + at * beta + at.conj() * beta.T)[:, -1]
        out = out / (size * abs(beta).max() or 1.0)
        if out.max() > found[0]:
            found = out.max(), (int(out.argmax()), r)
    return found[1]


def _level(rates, most, level):
    """A level, at most a region's and above ``most``, far from minus all ``rates``."""
    inner = np.sort(rates[(rates > -level) & (rates <= most)])
    tries = np.append(level, -(inner[1:] + inner[:-1]) / 2)
    tries = tries[tries + most > 0]
    return min(round_digits(tries, 12), key=lambda x: -abs(rates + x).min())


def _doubled(H):
    """A Hermitian H as a symmetric matrix of twice its size."""
    return np.block([[H.real, -H.imag], [H.imag, H.real]])
