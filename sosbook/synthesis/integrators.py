"""Which errors can be integrated: the choice of U, which the thesis leaves open
(section 5).

The answer is a rank condition on S, B and U alone, [-S B; U 0] of full row rank: no
transmission zero at s = 0 from u to U z. K_A, M and D have no part in it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import null_space

from ..exact.definite import exact
from ..language import Unknown, he
from ..lmi.problem import LMIProblem
from ..lmi.proofs import LMIProof
from ..lmi.text import LMIText
from ..plants.as_data import vertex_place
from ..plants.checks import matrix, rank_deficient
from ..plants.kinds import SecondOrderPlant, checked_plant
from ..plants.second_order import Polytope
from ..plants.simplex import halves
from ..runtime.array_like import ArrayLike
from ..runtime.sparse import issparse
from ..runtime.threads import one_thread
from .fixed_mode import refuse_by_mode
from .request import Request

MOST_CHANNELS = 12  # 4095 choices
MOST_PIECES = 64
PROOF_DIGITS = 12


@dataclass(frozen=True, eq=False, repr=False)
class IntegratorChoice:
    """One choice of U and what it is worth.

    Parameters
    ----------
    U : (a, n) array
        The rows of U z are integrated.
    channels : tuple of int
        Displacements that U reads, from 0.
    admissible : bool
        Whether the integrators are controllable at every vertex. If
        not, no gain stabilises the loop: see `admissible_U`.
    distance : float
        Between 0 and 1. The smallest ``eps`` for which changes dS, dB
        with ``|[dS/|S| dB/|B|]| = eps`` (spectral norms) make U
        inadmissible; the smallest over the vertices. Zero if U is
        inadmissible.
    certified : bool or None
        Of a Polytope: whether U is *proven* admissible for every plant
        in it, in exact arithmetic: see `certify`. None for one plant.
    proof : LMIProof or None
        Where it is certified, the proof as a file.
    """

    U: np.ndarray
    channels: tuple
    admissible: bool
    distance: float
    certified: bool | None = None
    proof: LMIProof | None = None

    @property
    def a(self) -> int:
        """Number of integrators."""
        return len(self.U)

    def certify(self) -> LMIProof:
        """The exact proof that U is admissible for every plant of the Polytope.

        Returns
        -------
        LMIProof
            For each piece of the polytope a matrix X with R X + X' R' > 0 at
            its corners, R = [-S B; U 0]: see `proven_everywhere`. ``save`` makes
            it a file. That the pieces make up the polytope is in its words.

        Raises
        ------
        ValueError
            If nothing is proven: ``certified`` says it.
        """
        if self.proof is None:
            why = (
                "of one plant the rank is that of floats"
                if self.certified is None
                else "the choice isn't proven for every plant"
            )
            raise ValueError(f"there is nothing to certify: {why}")
        return self.proof

    def __repr__(self):
        names = ", ".join(f"z{k + 1}" for k in self.channels)
        word = "admissible" if self.admissible else "inadmissible"
        text = f"<{self.a} on {names}: {word}, distance {self.distance:.3g}"
        if self.certified is not None and self.admissible:
            text += ", proven" if self.certified else ", not proven"
        return text + ">"


@one_thread
def admissible_U(
    plant: SecondOrderPlant, candidates: Iterable[ArrayLike] | None = None
) -> tuple[IntegratorChoice, ...]:
    r"""Every choice of integrators, the admissible ones first.

    With :math:`(A_0, B_0)` stabilisable, a U gives a stabilisable loop
    with integrators if and only if

    .. math:: \operatorname{rank}
        \begin{bmatrix} -S & B \\ U & 0 \end{bmatrix} = n + a .

    Then every constant set point of U z is followed and every constant
    disturbance rejected by every stabilising gain. Otherwise no gain
    stabilises.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or Uncertain
        The plant, or the polytope of plants.
    candidates : sequence of (a, n) array_like, optional
        Which U to judge: any real matrices, such as ``[[1, 1]]`` for the
        sum of two errors. Without it: every set of at most m channels.

    Returns
    -------
    tuple of IntegratorChoice
        First those that are admissible, and of a Polytope those that are proven
        so; of each kind the most integrators first, then the largest distance.

    Raises
    ------
    ValueError
        If the plant itself can't be stabilised: then no U helps. If it
        has more than 12 displacements and no candidates are given.

    Notes
    -----
    Source: the open question of the thesis's section 5; the rank
    condition is Davison and Smith's (1971) for second-order systems.

    Examples
    --------
    Two masses in a row, the first one driven and tied to a wall:

    >>> from sosbook import SecondOrderSystem
    >>> plant = SecondOrderSystem(
    ...     M=np.eye(2), D=np.zeros((2, 2)), S=[[2, -1], [-1, 1]],
    ...     B=[[1], [0]])
    >>> admissible_U(plant)
    (<1 on z1: admissible, distance 0.354>, <1 on z2: admissible, distance 0.298>)
    """
    plant = checked_plant(plant, SecondOrderPlant)
    if candidates is None:
        candidates = _selections(plant)
    elif issparse(candidates) or not np.iterable(candidates):
        raise ValueError(
            f"candidates must be a list of matrices U, got {type(candidates).__name__}"
        )
    else:
        candidates = [
            matrix(f"candidates[{k}]", U, (None, plant.n))
            for k, U in enumerate(candidates)
        ]
    if any(len(U) == 0 for U in candidates):
        raise ValueError("a candidate has no row: that is a PD controller")
    _check_stabilisable(plant)
    choices = [_judge(plant, U) for U in candidates]
    return tuple(sorted(choices, key=_rank))


def _rank(choice):
    unsafe = not choice.admissible, choice.certified is False
    return *unsafe, -choice.a, -round(choice.distance, 9)


def _selections(plant):
    n, m = plant.n, plant.m
    if n > MOST_CHANNELS:
        raise ValueError(
            f"the plant has {n} displacements and 2^{n} choices: pass the "
            "candidates to be judged"
        )
    return [
        np.eye(n)[list(channels)]
        for a in range(1, min(m, n) + 1)
        for channels in combinations(range(n), a)
    ]


def _check_stabilisable(plant):
    """Raise where a vertex has an unstable mode that no gain moves."""
    for k, v in enumerate(plant.vertices):
        at = vertex_place(plant, k)
        where = f" at {at}" if at else ""
        fixed = refuse_by_mode(Request(v, K_A=_regular(v)))
        at_rest = rank_deficient(np.hstack([v.S, v.B]))
        if at_rest or fixed is not None:
            s = 0j if at_rest else fixed.mode
            raise ValueError(
                f"the plant can't be stabilised{where}: u doesn't reach "
                f"its mode at s = {s.real:.3g}{s.imag:+.3g}j, so no U "
                "helps; add an input"
            )


def _regular(v):
    """An acceleration gain that makes M - B K_A nonsingular."""
    left, sizes, right = np.linalg.svd(v.M)
    null = sizes < 1e-12 * max(sizes[0], 1e-300)
    scale = (sizes[0] or 1.0) / (np.linalg.norm(v.B, 2) ** 2 or 1.0)
    return -scale * v.B.T @ left[:, null] @ right[null]


def _judge(plant, U):
    channels = tuple(int(k) for k in np.flatnonzero(U.any(axis=0)))
    good = not any(rank_deficient(_zero_matrix(v, U)) for v in plant.vertices)
    distance, certified, proof = 0.0, None, None
    if good:
        distance = min(_distance(v, U) for v in plant.vertices)
    if isinstance(plant, Polytope):
        proof = proven_everywhere(plant, U) if good else None
        certified = proof is not None
    return IntegratorChoice(U, channels, good, distance, certified, proof)


def _zero_matrix(v, U):
    """[-S B; U 0]: its row rank drops at a transmission zero s = 0."""
    return np.block([[-v.S, v.B], [U, np.zeros((len(U), v.m))]])


def _distance(v, U):
    """Smallest singular value of [S N/|S|  B/|B|], with U N = 0."""
    rest = v.S @ null_space(U) / (np.linalg.norm(v.S, 2) or 1.0)
    reach = v.B / (np.linalg.norm(v.B, 2) or 1.0)
    both = np.hstack([rest, reach])
    return float(min(np.linalg.svd(both, compute_uv=False)[v.n - 1], 1.0))


def proven_everywhere(plant, U):
    r"""Prove that U is admissible for every plant of a polytope.

    With :math:`R = [-S\ B; U\ 0]`, affine in the weights, a matrix X
    with :math:`R_i X + X^\top R_i^\top > 0` at the vertices proves full
    row rank of every mixture: a vertex test that is sound. Where no X
    is found, the polytope is halved, and each half gets its own.

    ``plant``: the polytope; ``U``, (a, n): the rows of U z are integrated. Returns the
    `LMIProof`; None where a plant disproves it, whose rank drops or whose determinant
    has another sign, or 64 pieces don't prove it.

    Both vertices pass, the plant halfway between them doesn't:

    >>> from sosbook import Polytope, SecondOrderSystem
    >>> def plant(s):
    ...     return SecondOrderSystem(np.eye(2), np.eye(2),
    ...                              [[2, -1], [-1, s]], [[1], [0]])
    >>> proven_everywhere(Polytope([plant(1), plant(2)]), np.array([[1, 0]])).proven
    True
    >>> proven_everywhere(Polytope([plant(1), plant(-1)]), np.array([[1, 0]]))
    """
    corners = np.array([_zero_matrix(v, U) for v in plant.vertices])
    if any(map(rank_deficient, corners)):
        return None
    rows, columns = _scales(corners)
    exactly = exact(corners)
    pieces, budget, proven = [np.eye(len(corners))], MOST_PIECES, []
    while pieces:
        weights = pieces.pop()
        R = np.tensordot(weights, corners, 1)
        scaled = rows[:, None] * R * columns
        budget -= 1
        if budget < 0 or _refused(scaled):
            return None
        piece = _proven(weights, exactly, scaled, rows, columns)
        if piece is None:
            far = np.linalg.norm(scaled[:, None] - scaled[None], axis=(2, 3))
            pieces += halves(weights, far)
        else:
            proven.append(piece)
    text = "; ".join(" ".join(f"{e:.6g}" for e in row) for row in U)
    claim = (
        f"[-S B; U 0] with U = [{text}] has full row rank at every plant of the "
        f"polytope, in pieces of it that make it up ({len(proven)})"
    )
    together = _ranks([mixtures for mixtures, _ in proven])
    values = {f"X {k}": X for k, (_, X) in enumerate(proven)}
    return together.prove(values, (claim,), digits=PROOF_DIGITS)


def _scales(corners):
    """Diagonal scalings that bring the entries near one."""
    size = np.abs(corners).max(axis=0)
    rows, columns = np.ones(len(size)), np.ones(size.shape[1])
    for _ in range(3):
        now = rows[:, None] * size * columns
        rows /= np.sqrt(now.max(axis=1))
        now = rows[:, None] * size * columns
        top = now.max(axis=0)
        columns /= np.sqrt(np.where(top > 0, top, 1))
    return rows, columns


def _refused(R):
    if any(map(rank_deficient, R)):
        return True
    return R.shape[1] == R.shape[2] and len(set(np.linalg.slogdet(R)[0])) > 1


def _proven(weights, corners, scaled, rows, columns):
    """The corners and one X for all: first a guess, then the LMI; None without."""
    shares = exact(weights)
    mixtures = [sum(w * R for w, R in zip(s, corners)) for s in shares]

    def holding(X):
        X = columns[:, None] * X / rows  # a congruence of R X + X'R'
        proof = _ranks([mixtures]).prove({"X 0": X}, digits=PROOF_DIGITS)
        return (mixtures, X) if proof.proven else None

    first = holding(np.linalg.pinv(scaled.mean(axis=0)))
    if first is not None:
        return first
    point = _ranks([scaled]).find().values
    return None if point is None else holding(point["X 0"])


def _ranks(pieces):
    """R X + X' R' > 0 at each corner R of some pieces, one X for each piece."""
    rows, columns = pieces[0][0].shape

    def write(values, number):
        return {
            f"piece {k}, corner {c}": he(R @ values[f"X {k}"])
            for k, corners in enumerate(pieces)
            for c, R in enumerate(corners)
        }

    unknowns = [Unknown(f"X {k}", columns, rows) for k in range(len(pieces))]
    return LMIProblem(LMIText(write, unknowns))
