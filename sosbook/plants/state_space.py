"""State spaces of other programs: of continuous time, of second order if they can."""

import numpy as np

from ..exact.rational import exact
from ..runtime.saying import warn_outside
from .checks import rank_deficient
from .condensing import schur
from .descriptor_system import NO_RATE, DescriptorSystem
from .massless import kept, massless_directions
from .second_order import SecondOrderSystem

LETTERS = "E", "A", "B", "B_w", "C", "D"
STEPS = "dt", "ts", "t"  # what programs call the time between two samples
BLOCK = "ABCD", "nx"  # as Modelica writes a state space, and its number of states


def plant_of_state_space(where, given, asked, condensed=False):
    """The plant of ``given`` A and others; of second order where it can be. ``asked``:
    whether what errors call ``where`` is known to be a state space; ``condensed``:
    whether states without a derivative are solved for.
    """
    dt = _step(given)
    if "ABCD" in given:
        given = _parts(*(given[name] for name in BLOCK))
    A, D_u = given["A"], given.get("D")
    E, B, B_w, C = (given.get(name) for name in ("E", "B", "B_w", "C"))
    if D_u is not None and not D_u.any():
        D_u = None
    E = np.eye(len(A)) if E is None else E
    given = E, A, B, B_w, C, D_u
    try:
        system = DescriptorSystem(*(_solved(*given) if condensed else given), dt=dt)
    except ValueError as error:
        cure = NO_RATE in str(error) and not condensed and _follow(E, A)
        raise ValueError(f"{error}{'; or pass condensed=True' * cure}") from None
    alike = len({np.shape(x) for x in (A, B, C)}) == 1 and len(A) > 1
    if alike and not asked and (system.C != np.eye(len(A))).any():
        raise ValueError(
            f"A, B and C are all {len(A)} x {len(A)}: for A z'' + B z' + C z pass "
            "names={'M': 'A', 'D': 'B', 'S': 'C'}, for a state space names={'A': 'A'}"
        )
    plant = None if dt else second_order(*system.vertices)
    if plant is None:
        return system
    if C is not None:
        warn_outside(
            f"{where} is of second order, and its C is left out: outputs are z; "
            "design_observer takes another as C="
        )
    return plant


def _follow(E, A):
    """True if the states without a derivative follow the others at once."""
    N, L = (np.array(x, float) for x in massless_directions(E, 0 * E))
    return N.size > 0 and N.shape == L.shape and not rank_deficient(L.T @ A @ N)


def _solved(E, A, B, B_w, C, D_u):
    """The arguments of a `DescriptorSystem` without the states that E x' doesn't have,
    which are solved for exactly, as `condense` does.
    """
    N, L = massless_directions(E, 0 * E)
    if not N.size:
        return E, A, B, B_w, C, D_u
    n = len(A)
    B, B_w = (np.zeros((n, 0)) if x is None else x for x in (B, B_w))
    C = np.eye(n) if C is None else C
    D_u = np.zeros((len(C), B.shape[1])) if D_u is None else D_u
    none = np.zeros((len(C), B_w.shape[1]))
    rows, columns = kept(L)[0], kept(N)[0]
    whole = exact(np.block([[A, B, B_w], [C, D_u, none]]))
    high = np.vstack([L, exact(np.zeros((len(C), L.shape[1])))])
    right = np.hstack([whole[:, columns], whole[:, n:]])
    places = [*rows, *range(n, n + len(C))]
    parts = schur(whole[:, :n] @ N, right, high, places, len(columns))
    if parts is None:
        raise ValueError("the states that E x' doesn't have don't follow the others")
    r, k, m = len(rows), len(columns), B.shape[1]
    (A, B, B_w), (C, D_u, D_w) = (
        np.split(x, [k, k + m], axis=1) for x in np.split(parts, [r])
    )
    D_u, D_w = (x if x.any() else None for x in (D_u, D_w))
    return E[np.ix_(rows, columns)], A, B, B_w, C, D_u, D_w


def is_step(name):
    """True if a file of a state space may call the time between samples by ``name``."""
    return name.lower() in STEPS or "sampl" in name.lower()


def _step(given):
    """The time between two samples in a file of these, of 0 or none None."""
    for name in filter(is_step, given):
        step = np.asarray(given[name])
        if step.size != 1 or not step.item():
            continue
        known = name.lower() in STEPS[:2]
        if not known or step.dtype.kind not in "iuf" or not step.item() > 0:
            raise ValueError(
                f"{name} = {step.item()} beside A: if it is the time between two "
                "samples call it dt, in seconds; of continuous time leave it out"
            )
        return float(step.item())
    return None


def second_order(d):
    """The plant of a vertex ``d`` with x = [z; z'] in any order, or None."""
    N, half = len(d.A), len(d.A) // 2
    inputs = np.hstack([d.Bu, d.Bw])
    if d.Du is not None or not d.Bu.size or (d.E != np.eye(N)).any():
        return None
    target = {  # rows x_i' = x_j
        i: int(row.argmax())
        for i, row in enumerate(d.A)
        if not inputs[i].any() and np.count_nonzero(row) == 1 and row.max() == 1
    }
    other = [i for i, j in target.items() if j not in target]
    for z in list(range(half)), list(range(0, N, 2)), other:
        v = [target.get(i, -1) for i in z]
        if sorted(z + v) == list(range(N)):
            D, S = (0.0 - d.A[np.ix_(v, x)] for x in (v, z))
            F = d.Bw[v] if d.Bw.size else None
            return SecondOrderSystem(np.eye(half), D, S, d.Bu[v], F)
    return None


def _parts(whole, states):
    """A, B, C and D of the matrix [A B; C D]."""
    n = int(states.item()) if states.size == 1 else 0
    if not 1 <= n <= min(whole.shape) or n != states.item():
        raise ValueError(f"nx must say how many rows of ABCD {whole.shape} are A's")
    parts = whole[:n, :n], whole[:n, n:], whole[n:, :n], whole[n:, n:]
    return {name: x for name, x in zip("ABCD", parts) if x.size}
