"""Exact proofs that the LMIs of a request have no solution.

Multipliers Z_k > 0 with sum <G_ka, Z_k> = 0 exclude a solution. Where the boundary of
the LMIs is touched anyway, by a mode that decays by itself or by an equation of the
loop that no delay enters, no such Z_k are regular. Then the blocks are compressed
first, to what remains to be decided: W' G W > 0 is necessary for G > 0.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import qr

from ..exact.definite import exact, in_floats, inverse, round_digits
from ..exact.rational import null_basis
from ..exact.repair import repair_multipliers
from ..language import Unknown, block, he
from ..solver.blocks import Blocks
from ..solver.deepest import deepest
from .modes import ModesRefusal, slow_modes
from .proofs import delay_refusal, refuse_delay
from .request import DelayedLoop

TOO_SINGULAR = np.linalg.LinAlgError, IndexError, ValueError  # multipliers in floats
_REPLACED = {"R1", "R2", "R3", "F", "G"}  # by less, where equations hold


def refusal_of(request, Z):
    """A proof that a ``request`` has no solution, by multipliers Z, or None."""
    ways = [lambda: _directly(request, Z)]
    if request.misprints:
        return ways[0]()
    if isinstance(request.plant, DelayedLoop):
        ways.append(lambda: _by_states(request))
    if request.gain is None:
        ways.append(lambda: _by_modes(request))
    elif request.method in ("functional", "shift"):
        ways.append(lambda: _without_fixed_equations(request))
    return next(
        (certificate for way in ways if (certificate := way()) is not None), None
    )


def _directly(request, Z):
    """A `DelayRefusal`, which is a file, or None."""
    try:
        return refuse_delay(request, Z)
    except TOO_SINGULAR:
        return None


def _excluding(floats, exactly):
    """Exact multipliers by name, of (expressions, unknowns) read twice; or None.

    None where `deepest` finds a solution, or no multipliers.
    """
    deep = deepest(Blocks(floats[0].values(), floats[1]))
    if deep.depth > 0 or deep.Z is None:
        return None
    expressions, unknowns = exactly
    try:
        repaired = repair_multipliers(list(expressions.values()), unknowns, deep.Z)
    except TOO_SINGULAR:
        return None
    return None if repaired is None else dict(zip(expressions, repaired[0]))


def _of_part(small):
    """Exact multipliers of a smaller request by name, or None."""
    return _excluding(small.in_unknowns(), small.in_unknowns(exact))


def _proven(proof):
    return proof if proof.proven else None


def _by_modes(request):
    """Refuse the LMIs of some slow modes of one vertex."""
    for k, vertex in enumerate(request.vertices):
        for modes in slow_modes(vertex, request.delta):
            small = replace(request, plant=modes.plant(), U=None)
            Z = _of_part(small)
            if Z is not None:
                contents = ModesRefusal.contents(request, k, modes, small, Z)
                certificate = _proven(ModesRefusal.of(contents))
                if certificate is not None:
                    return certificate
    return None


def _by_states(request):
    """Refuse the LMIs of states that no other states drive.

    Where the others rest, so they do for ever: a solution for the loop
    holds one for the part. Multipliers of the part, with zeros for the
    other states, are multipliers of the whole.
    """
    A, Ad = request.plant.A, request.plant.A_d
    drives = (A != 0) | (Ad != 0) | np.eye(len(A), dtype=bool)
    reach = np.linalg.matrix_power(drives.astype(int), len(A)) > 0
    parts = {tuple(np.flatnonzero(column)) for column in reach.T}
    for some in sorted(parts, key=lambda part: (len(part), part)):
        if len(some) == len(A):
            continue
        at = np.ix_(some, some)
        small = request.at(plant=DelayedLoop(A[at], Ad[at]), gain=None)
        Z = _of_part(small)
        if Z is None:
            continue
        whole = {name: _embedded(z, np.array(some), len(A)) for name, z in Z.items()}
        certificate = _proven(delay_refusal(request, whole))
        if certificate is not None:
            return certificate
    return None


def _embedded(z, some, N):
    """A matrix for ``some`` of N states each time, with zeros for the others."""
    count = len(z) // len(some)
    rows = np.concatenate([k * N + some for k in range(count)])
    whole = exact(np.zeros((count * N, count * N)))
    whole[np.ix_(rows, rows)] = z
    return whole


def _without_fixed_equations(request):
    """Refuse the LMIs where the loop's undelayed equations hold.

    Let L A_d = 0. Then L (E x' - A x) = 0 in the loop, and between t - tau
    and t the integral of that. The blocks have to be positive there too.
    What F and G multiply is C rho there, where C spans the kernel of L,
    and R is seen across the equations' directions only. The multipliers
    that are found there, W Z W', are singular ones of the whole blocks.

    A loop that alone excludes a solution takes less than all of them.
    """
    loops = dict(request.closed_loops(exact))
    parts = [{name: loop} for name, loop in loops.items()] if len(loops) > 1 else []
    found = (_without_equations_of(request, part) for part in (*parts, loops))
    return next((certificate for certificate in found if certificate), None)


def _without_equations_of(request, loops):
    """`_without_fixed_equations` by some ``loops`` alone, by their blocks' names."""
    rows = {name: _undelayed(*loop) for name, loop in loops.items()}
    common = _kernel(np.hstack([_kernel(k) for k in rows.values()]).T).T
    if not len(common):  # the delayed input reaches every equation
        return None
    unknowns = [u for u in request.unknowns() if u.name not in _REPLACED]
    values = {u.name: u for u in unknowns}
    N, across = request.states, _kernel(common)
    R, dual = Unknown("R", across.shape[1], symmetric=True), _left_inverse(across).T
    first, second = dual[:N], dual[N:]
    zero = exact(np.zeros((N, N)))
    values |= {
        "R1": first @ R @ first.T,
        "R2": second @ R @ first.T,
        "R3": second @ R @ second.T,
        "F": zero,
        "G": zero,
    }
    whole = request.blocks(values, exact)
    others = {n for n, _ in request.closed_loops(exact)} - loops.keys()
    expressions = {n: g for n, g in whole.items() if n not in others} | {"R": R}
    e2, multipliers, back = request.times(exact).epsilon2, {}, {"R": across}
    for name, (E, A, Ad) in loops.items():
        W, C = _kernel(_fixed(rows[name], common)), _kernel(_kernel(Ad.T).T)
        W = block([[W, 0], [0, exact(np.eye(N))]]) if request.mu else W
        parts = [e2 * A, -e2 * E, e2 * Ad, zero] + ([Ad] if request.mu else [])
        moving = _row_basis(W[: 2 * N])
        key = str((moving, C))  # one multiplier for loops with one A
        if key not in multipliers:
            name_of = f"F and G {len(multipliers) + 1}"
            multipliers[key] = Unknown(name_of, len(moving), C.shape[1])
        expressions[name], back[name] = W.T @ expressions[name] @ W, W
        if C.shape[1]:
            rho = _left_inverse(C) @ np.hstack(parts) @ W
            expressions[name] -= he(moving.T @ multipliers[key] @ rho)
    unknowns += [R, *(H for H in multipliers.values() if H.size)]
    floats = {name: in_floats(g) for name, g in expressions.items()}
    Z = _excluding((floats, unknowns), (expressions, unknowns))
    if Z is None:
        return None
    for name, W in back.items():
        Z[name] = W @ Z[name] @ W.T
    for name in others:
        Z[name] = exact(np.zeros(whole[name].shape))
    return _proven(delay_refusal(request, Z))


def _left_inverse(C):
    """(C' C)^-1 C'."""
    return inverse(C.T @ C) @ C.T if C.shape[1] else C.T


def _row_basis(x):
    """Rows that span those of a rational matrix, nearly orthonormal."""
    return _kernel(_kernel(x).T).T


def _undelayed(E, A, Ad):
    """Rows [-L A, L E] of the equations without A_d."""
    L = _kernel(Ad.T).T
    return np.hstack([-(L @ A), L @ E])


def _fixed(rows, common):
    """The rows that vanish on (x, x', x_tau, eta): the equations, and integrals."""
    N = rows.shape[1] // 2
    of_x, of_dx = common[:, :N], common[:, N:]
    return np.vstack(
        [np.hstack([rows, 0 * rows]), np.hstack([of_dx, 0 * of_dx, -of_dx, of_x])]
    )


def _kernel(rows):
    """A basis of the kernel of a rational matrix, as columns.

    Exact; nearly orthonormal, which is for the floats' sake only.
    """
    if not len(rows):
        return exact(np.eye(rows.shape[1]))
    order = qr(rows.astype(float), mode="r", pivoting=True)[1]
    basis = null_basis(rows[:, order])[np.argsort(order)]
    if not basis.size:
        return basis
    size = 10.0 ** -np.floor(np.log10(abs(basis.astype(float)).max(axis=0)))
    basis = basis * exact(size)
    upper = np.linalg.qr(basis.astype(float), mode="r")
    return basis @ exact(round_digits(np.linalg.inv(upper), 4))
