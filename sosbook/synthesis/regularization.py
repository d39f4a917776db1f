"""Singular mass: acceleration feedback (Lemma 2.1), modes at infinity."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from flint import fmpq, fmpq_mat
from scipy.linalg import eigh, orth

from ..lmi import Unknown, block, eye, he
from ..lmi.centre import Blocks, Phase, Unbounded, centre, margin, minimize, phase_one
from ..lmi.exact import exact, repair_multipliers, round_digits
from ..lmi.proof import InfeasibilityCertificate, Proof
from ..plants.checks import matrix, positive, rank_deficient
from ..plants.second_order import Polytope, SecondOrderSystem
from ..theorems.regularization import regular_mass
from .certificates import Certificate

__all__ = [
    "InfiniteModes",
    "Regularization",
    "infinite_modes",
    "prove_regular",
    "regularize",
]


@dataclass(frozen=True, eq=False)
class Regularization:
    """An acceleration gain and what is known about M - B K_A.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
    beta : float
        What was asked: a symmetric part above ``beta**2``.
    status : {"feasible", "infeasible", "undecided"}
        Decided by eigenvalues of the blocks or by multipliers that
        exclude a gain, never by a solver's word.
    K_A : (m, n) array or None
        Acceleration gain in u = K x + K_A e''.
    margins : dict or None
        From a block's name, "mass" or "mass 1", "mass 2", ..., to its
        smallest eigenvalue, after scaling its diagonal to one.
    """

    plant: SecondOrderSystem | Polytope
    beta: float
    status: str
    K_A: np.ndarray = None
    margins: dict = None
    _multipliers: list = None

    def __repr__(self):
        if self.K_A is None:
            return f"<Regularization: {self.status}>"
        return (
            f"<Regularization: {self.status}, smallest eigenvalue "
            f"{self.bound:.3g}>"
        )

    @property
    def regular(self):
        """The plant with the mass M - B K_A."""
        gain = self._gain()
        found = [
            SecondOrderSystem(v.M - v.B @ gain, v.D, v.S, v.B, v.F)
            for v in self.plant.vertices
        ]
        single = isinstance(self.plant, SecondOrderSystem)
        return found[0] if single else Polytope(found)

    @property
    def bound(self):
        """Smallest eigenvalue of the symmetric part of M - B K_A.

        Over the vertices, and so over the whole polytope: it is a
        concave function of M and B.
        """
        gain = self._gain()
        return float(min(
            np.linalg.eigvalsh(he(v.M - v.B @ gain) / 2)[0]
            for v in self.plant.vertices
        ))

    def _gain(self):
        if self.K_A is None:
            raise ValueError(
                f"the regularization is {self.status}: there is no gain; "
                "see its advice"
            )
        return self.K_A

    def certify(self, digits=6):
        """Prove (2.12) in exact arithmetic, for the rounded K_A.

        For a fixed K_A it is affine in M and B, so the vertices do
        prove it for the whole polytope: no pairs are needed here.

        Parameters
        ----------
        digits : int
            Significant digits to which K_A is rounded first.

        Returns
        -------
        Certificate
            Its ``K`` is the rounded K_A; it has no ``P``.
        """
        return prove_regular(self.plant, self._gain(), self.beta, digits)

    @cached_property
    def infeasibility(self):
        """`InfeasibilityCertificate` where one was found, else None.

        Its multipliers Z_k, (n, n) and positive semidefinite, satisfy
        sum Z_k B_k = 0 and value = sum <M_k - beta^2 I, Z_k> <= 0; a
        gain would make sum <M_k - B_k K_A - beta^2 I, Z_k> positive.
        """
        if self.status == "feasible":
            return None
        name, v, mass = _unreached(self.plant)
        beta2 = exact(self.beta) ** 2
        if v is not None and mass <= beta2:
            value = (mass - beta2) * (v @ v)
            return InfeasibilityCertificate(
                True, float(value), {name: np.outer(v, v)}
            )
        if self._multipliers is None:
            return None
        return _prove_singular(self.plant, self.beta, self._multipliers)

    @cached_property
    def advice(self):
        """What to change; empty if feasible."""
        if self.status == "feasible":
            return ""
        _, v, mass = _unreached(self.plant)
        if v is not None and mass <= exact(self.beta) ** 2:
            entries = ", ".join(f"{float(e):.4g}" for e in v)
            why = (
                f"in the direction v = [{entries}], which no input reaches, "
                f"the mass v' M v / v' v is {float(mass):.4g}"
            )
            if mass > 0:
                limit = float(mass) ** 0.5
                return f"Ask for a beta below {limit:.4g}: {why}."
            return (
                f"No beta helps: {why}, not positive. The lemma is only "
                "sufficient: multiply the equation of motion from the left "
                "by (M - B K0)', with a K0 that makes M - B K0 regular, and "
                "try again."
            )
        if regularize(self.plant, self.beta / 1e3).status == "feasible":
            return "Ask for a smaller beta."
        return (
            "No common K_A serves all vertices, though each has its own. "
            "Look for a plant between them where [M B] lacks full row rank, "
            "and split the polytope."
        )


def regularize(plant, beta=0.1, choose="centre"):
    r"""Find an acceleration gain that makes the mass regular.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
    beta : float
        The smallest eigenvalue of the symmetric part of M - B K_A must
        exceed ``beta**2``, at every vertex.
    choose : {"centre", "least norm"}
        Which of the many gains. ``"centre"``: the analytic centre of
        (2.12) and of a bound \|M - B K_A\| < rho on the mass, with rho
        twice the norm of M (or twice the least that (2.12) admits, if
        that is larger). ``"least norm"``: the
        smallest Frobenius norm of K_A, for beta**2 raised by 1 % (less
        where that is infeasible); zero where the plant needs no gain.

    Returns
    -------
    Regularization

    Raises
    ------
    ValueError
        On bad input; an impossible request is no error, it comes back
        with status "infeasible".

    Notes
    -----
    Source: thesis, Lemma 2.1 (2.12). Neither choice depends on the unit
    of mass (with beta**2 in that unit), nor on vertices that differ in
    D, S, F only; the centre doesn't depend on the units of the inputs.
    Both do depend on the units of z where these differ among the
    coordinates, as the identity in (2.12) does.

    Examples
    --------
    >>> plant = SecondOrderSystem(
    ...     M=[[2, 0], [0, 0]], D=[[1, 0], [0, 1]], S=[[2, -1], [-1, 1]],
    ...     B=[[0], [1]])
    >>> found = regularize(plant, beta=0.1)
    >>> found.status, found.K_A.round(2) + 0, found.certify().proven
    ('feasible', array([[ 0.  , -2.31]]), True)
    """
    if not isinstance(plant, (SecondOrderSystem, Polytope)):
        raise ValueError(
            "plant must be a SecondOrderSystem or a Polytope, got "
            f"{type(plant).__name__}"
        )
    beta = positive("beta", beta)
    if choose not in ("centre", "least norm"):
        raise ValueError(
            f'choose must be "centre" or "least norm", got {choose!r}'
        )
    refused = Regularization(plant, beta, "infeasible")
    if refused.infeasibility is not None:
        return refused
    problem = _Problem(plant, beta)
    phase = phase_one(Blocks.of(problem.blocks(), [problem.L]))
    if phase.x is None:
        refused = replace(
            refused, status=phase.verdict, _multipliers=phase.Z)
        proof = refused.infeasibility
        if proof is not None and proof.proven:
            return replace(refused, status="infeasible")
        return refused
    pick = problem.centre if choose == "centre" else problem.least_norm
    try:
        K_A = pick(phase.x)
    except Unbounded:  # a degenerate set: keep the feasible point
        K_A = problem.gain(problem.L.unpack(phase.x), problem.basis)
    K_A = np.where(np.abs(K_A) > 1e-9 * np.abs(K_A).max(), K_A, 0.0)
    margins = {
        name: margin(regular_mass(M, B, K_A, beta))
        for name, (M, B) in _pairs(plant).items()
    }
    good = min(margins.values()) > 1e-9
    if not good:  # too close for floats
        good = prove_regular(plant, K_A, beta, 17).proven
    status = "feasible" if good else "undecided"
    return Regularization(plant, beta, status, K_A, margins)


def prove_regular(plant, K_A, beta, digits=6):
    """Check (2.12) at all vertices in exact arithmetic.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
    K_A : (m, n) array
        Rounded to ``digits`` significant digits before the proof.
    beta : float

    Returns
    -------
    Certificate
        Its ``K`` is the rounded K_A; it has no ``P``.

    Examples
    --------
    >>> plant = SecondOrderSystem([[0]], [[1]], [[1]], B=[[1]])
    >>> prove_regular(plant, [[-0.02]], beta=0.1).proven
    True
    """
    if not isinstance(digits, int) or digits < 1:
        raise ValueError(f"digits must be 1 or more, got {digits!r}")
    K_A = matrix("K_A", K_A, (plant.m, plant.n))
    K_A = round_digits(K_A, digits)
    blocks = {
        name: regular_mass(exact(M), exact(B), exact(K_A), exact(beta))
        for name, (M, B) in _pairs(plant).items()
    }
    where = "the plant"
    if len(plant.vertices) > 1:
        where = "every plant of the polytope"
    claims = (
        f"for {where}, M - B K_A is regular",
        "the eigenvalues of its symmetric part exceed "
        f"beta^2 = {beta**2:.6g}",
    )
    return Certificate(**Proof.of(blocks, claims), K=K_A, P=None)


def _prove_singular(plant, beta, multipliers):
    """Exact multipliers of all vertices together, where they exist."""
    pairs, n = _pairs(plant), plant.n
    Z = {name: z[:n, :n] for name, z in zip(pairs, multipliers)}
    K_A = Unknown("K_A", plant.m, n)
    size = max(np.linalg.norm(z, 2) for z in Z.values())
    faces, blocks, W = {}, [], []
    for name, (M, B) in pairs.items():
        if np.linalg.norm(Z[name], 2) < 1e-4 * size:
            continue
        # inputs that Z annihilates confine it to Z = U W U'
        push = np.linalg.norm(Z[name] @ B, axis=0)
        still = push <= 1e-3 * np.linalg.norm(Z[name], 2) * np.linalg.norm(
            B, axis=0)
        U = _null_basis(B[:, still])
        if U.shape[1]:
            mass = exact(M) - exact(B) @ K_A
            faces[name] = U
            blocks.append(
                U.T @ (he(mass / 2) - exact(beta) ** 2 * eye(n)) @ U)
            back = np.linalg.pinv(U.astype(float))
            W.append(back @ Z[name] @ back.T)
    if not blocks:
        return InfeasibilityCertificate(False, np.nan, Z)
    flat = np.hstack([
        g.jacobian(K_A).reshape(K_A.size, -1) for g in blocks])
    free = _leading(_rational(flat.T))  # independent entries of K_A
    repaired = repair_multipliers(blocks, [K_A], W, free=free)
    if repaired is None:
        return InfeasibilityCertificate(False, np.nan, Z)
    Z = {
        name: u @ w @ u.T
        for (name, u), w in zip(faces.items(), repaired[0])
    }
    return InfeasibilityCertificate(True, float(repaired[1]), Z)


class _Problem:
    """(2.12) with masses and inputs of size one, in an unknown L.

    K_A = root^2 diag(force) basis L. The default basis leaves out what
    does nothing at any vertex: combinations of redundant inputs.
    """

    def __init__(self, plant, beta):
        self.M, self.B = zip(*_pairs(plant).values())
        self.beta = beta
        size = max(beta**2, *(np.linalg.norm(M, 2) for M in self.M))
        self.root = np.sqrt(size)
        stacked = np.vstack(self.B)
        norms = np.linalg.norm(stacked, axis=0)
        self.force = 1 / np.where(norms > 0, norms, 1)
        _, s, rows = np.linalg.svd(stacked * self.force)
        rank = max(int((s > 1e-10).sum()), 1)
        m, n = stacked.shape[1], len(self.M[0])
        self.basis = rows[:rank].T if rank < m else np.eye(m)
        self.L = Unknown("L", rank, n)

    def scaled(self, basis):
        """Masses and input matrices in these units."""
        effect = self.force[:, None] * basis
        return [
            (M / self.root**2, B @ effect) for M, B in zip(self.M, self.B)
        ]

    def blocks(self, L=None, basis=None, raised=1.0):
        """(2.12), of the default L and basis without others."""
        L = self.L if L is None else L
        beta = np.sqrt(raised) * self.beta / self.root
        return [
            regular_mass(M, B, L, beta)
            for M, B in self.scaled(self.basis if basis is None else basis)
        ]

    def gain(self, L, basis):
        return self.root**2 * self.force[:, None] * (basis @ L)

    def centre(self, x):
        """Analytic centre of (2.12) and |M - B K_A| < rho."""
        masses = [M - B @ self.L for M, B in self.scaled(self.basis)]

        def bounded(rho, *unknowns):
            return Blocks.of(
                self.blocks() + [_norm_below(rho, g) for g in masses],
                [self.L, *unknowns])

        rho = max(np.linalg.norm(g.constant, 2) for g in masses)
        found = phase_one(bounded(rho)) if rho > 0 else Phase("undecided")
        if found.x is None:  # then the least rho is larger
            L, size = {self.L: self.L.unpack(x)}, Unknown("rho", 1)
            start = max(np.linalg.norm(g.value(L), 2) for g in masses)
            cost = np.append(np.zeros(len(x)), 1.0)
            best, _ = minimize(
                bounded(size, size), cost, np.append(x, 1.5 * start), 1e-7)
            x, rho = best[:-1], best[-1]
        else:
            x = found.x
        x = centre(bounded(2 * rho), x)
        return self.gain(self.L.unpack(x), self.basis)

    def least_norm(self, x):
        """Smallest Frobenius norm of K_A."""
        m, n = len(self.force), len(self.M[0])
        if all(np.linalg.eigvalsh(he(M) / 2)[0] > self.beta**2
               for M in self.M):
            return np.zeros((m, n))
        L, t = Unknown("L", m, n), Unknown("t", 1)
        for raised in (1.01, 1.0001, 1.000001):
            mass = self.blocks(L, np.eye(m), raised)
            found = phase_one(Blocks.of(mass, [L]))
            if found.x is not None:
                break
        else:  # beta is all but the largest that can be had
            return self.gain(self.L.unpack(x), self.basis)
        x, weight = found.x, np.diag(self.force / self.force.max())
        for gap in (1e-2, 1e-9):  # the first pass finds the unit
            unit = np.linalg.norm(weight @ L.unpack(x))
            column = _column(weight @ L / unit)
            size = block([[t * eye(m * n), column], [column.T, t]])
            cost = np.append(np.zeros(L.size), 1.0)
            blocks = Blocks.of([*mass, size], [L, t])
            x = minimize(blocks, cost, np.append(x, 1.5), gap)[0][:-1]
        return self.gain(L.unpack(x), np.eye(m))


def _column(x):
    """The entries of a matrix, one below the other."""
    rows, columns = x.shape
    parts = [
        np.kron(e[:, None], np.eye(rows)) @ x @ e[:, None]
        for e in np.eye(columns)
    ]
    return sum(parts[1:], parts[0])


def _norm_below(size, x):
    """|x| < size, for a square matrix x, as a block."""
    one = eye(x.shape[0])
    return block([[size * one, x], [x.T, size * one]])


def _pairs(plant):
    """The different (M, B) of the vertices, by the name of the block."""
    found = {}
    for k, v in enumerate(plant.vertices, 1):
        name = "mass" if len(plant.vertices) == 1 else f"mass {k}"
        if not any(
            np.array_equal(v.M, M) and np.array_equal(v.B, B)
            for M, B in found.values()
        ):
            found[name] = v.M, v.B
    return found


def _rational(x):
    entries = x.flat if x.dtype == object else exact(x).flat
    return fmpq_mat(*x.shape, [fmpq(1) * e for e in entries])


def _leading(x):
    """Columns that carry a leading one in the row echelon form."""
    rows = x.rref()[0].table()
    return [
        next(j for j, e in enumerate(row) if e != 0)
        for row in rows if any(e != 0 for e in row)
    ]


def _null_basis(B):
    """Exact basis of the directions v with B' v = 0, as columns."""
    leading = _leading(_rational(B.T))
    rows = _rational(B.T).rref()[0].table()
    free = [j for j in range(len(B)) if j not in leading]
    N = np.full((len(B), len(free)), fmpq(0), dtype=object)
    for k, j in enumerate(free):
        N[j, k] = fmpq(1)
        for row, i in zip(rows, leading):
            N[i, k] = -row[j]
    return N


def _unreached(plant):
    """A direction with no input and, nearly, the least mass v'Mv / v'v.

    Returns
    -------
    name, v, mass
        Of the worst vertex, in rationals; None where inputs reach all.
    """
    worst = None, None, None
    for name, (M, B) in _pairs(plant).items():
        N = _null_basis(B)
        if N.shape[1]:
            near = N.astype(float)
            _, w = eigh(near.T @ (he(M) / 2) @ near, near.T @ near)
            w = w[:, 0] / np.abs(w[:, 0]).max()
            v = N @ exact(round_digits(w, 8) + 0.0)
            mass = v @ exact(M) @ v / (v @ v)
            if worst[2] is None or mass < worst[2]:
                worst = name, v, mass
    return worst


@dataclass(frozen=True)
class InfiniteModes:
    """Modes of M z'' + D z' + S z = 0, as E x' = A x with x = [z; z'].

    Parameters
    ----------
    finite, infinite : int
        Numbers of finite and of infinite generalised eigenvalues of
        (A, E), E = diag(I, M); together 2n.
    impulses : int
        How many of the infinite ones are impulsive modes: the others
        are algebraic equations.
    index : int
        Of the descriptor system: 0 if M is regular, 1 if there are
        only algebraic equations, 2 or more with impulses.
    """

    finite: int
    infinite: int
    impulses: int
    index: int

    @property
    def impulsive(self):
        """Whether a jump of u can cause an impulse in x = [z; z']."""
        return self.impulses > 0


def infinite_modes(plant):
    r"""Count the modes that a singular mass sends to infinity.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope

    Returns
    -------
    InfiniteModes
        A tuple of them, one per vertex, for a polytope.

    Raises
    ------
    ValueError
        If ``det(s^2 M + s D + S)`` vanishes for every s.

    Notes
    -----
    The plant is free of impulses if and only if L' D R is regular, the
    columns of L and R being bases of the left and right null space of
    M: thesis (A.3)-(A.5) for E = diag(I, M), where A22 = -L' D R.
    Counted by the Wong sequence, ranks to ten digits after scaling.

    Examples
    --------
    >>> parts = dict(M=[[1, 0], [0, 0]], S=[[2, -1], [-1, 1]], B=[[0], [1]])
    >>> infinite_modes(SecondOrderSystem(D=[[1, 0], [0, 1]], **parts))
    InfiniteModes(finite=3, infinite=1, impulses=0, index=1)
    >>> infinite_modes(SecondOrderSystem(D=[[1, 0], [0, 0]], **parts))
    InfiniteModes(finite=2, infinite=2, impulses=1, index=2)
    """
    if isinstance(plant, Polytope):
        return tuple(infinite_modes(v) for v in plant.vertices)
    if not isinstance(plant, SecondOrderSystem):
        raise ValueError(
            "plant must be a SecondOrderSystem or a Polytope, got "
            f"{type(plant).__name__}"
        )
    E, A = _scaled_pencil(plant)
    if all(rank_deficient(s * E - A, 1e-12)
           for s in (0.31 + 1.7j, -2.3 + 0.6j, 0.9 - 1.1j)):
        raise ValueError(
            "plant has a singular pencil: det(s^2 M + s D + S) vanishes "
            "for every s, so u doesn't determine the motion; use the "
            "plant with M - B K_A, see regularize"
        )
    W = np.zeros((len(E), 0))
    dimensions = [0]
    while True:
        image = orth(A @ W, rcond=1e-10) if W.size else W
        _, s, rows = np.linalg.svd(E - image @ (image.T @ E))
        W = rows[s < 1e-10].T
        if W.shape[1] == dimensions[-1]:
            break
        dimensions.append(W.shape[1])
    infinite = dimensions[-1]
    algebraic = dimensions[min(1, len(dimensions) - 1)]
    return InfiniteModes(
        len(E) - infinite, infinite, infinite - algebraic,
        len(dimensions) - 1,
    )


def _scaled_pencil(plant):
    """E and A after scaling rows, coordinates and time to size one."""
    parts = np.stack([plant.M, plant.D, plant.S])
    for _ in range(3):
        for axis in (1, 2):
            size = np.abs(parts).max(axis=(0, 3 - axis), keepdims=True)
            parts = parts / np.where(size > 0, size, 1)
    M, D, S = parts
    m, d, s = (np.linalg.norm(x, 2) for x in parts)
    omega = 1.0
    if m > 0 and max(d, s) > 0:
        omega = np.sqrt(s / m) if s > 0 else d / m
    elif s > 0 and d > 0:
        omega = s / d
    M, D = M * omega**2, D * omega
    size = max(np.linalg.norm(x, 2) for x in (M, D, S)) or 1.0
    M, D, S = M / size, D / size, S / size
    n = plant.n
    zero, one = np.zeros((n, n)), np.eye(n)
    E = np.block([[one, zero], [zero, M]])
    A = np.block([[zero, one], [-S, -D]])
    return E, A
