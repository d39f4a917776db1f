"""From a request to a point inside its LMIs and to their centre."""

from dataclasses import dataclass, replace

import numpy as np

from ..lmi import Unknown
from ..lmi.centre import CERTAIN, Blocks, Phase, Unbounded, centre, margin, phase_one
from ..lmi.newton import newton_of
from ..lmi.problem import any_centre, unpacked
from .certificates import prove, prove_infeasible
from .problem import Request
from .scaling import Frame

__all__ = ["Solution", "answer", "finish", "follow", "gain_of", "search"]

MANY = 24  # from so many pairs of vertices on, a cutting plane is faster
MORE = 4  # pairs that join it at a time


@dataclass(frozen=True, eq=False)
class Solution:
    """What `Design` knows of its LMIs; see there."""

    request: Request
    status: str
    K: np.ndarray = None
    P: np.ndarray = None
    Y: np.ndarray = None
    V: np.ndarray = None
    margins: dict = None
    frame: Frame = None
    multipliers: list = None
    own: dict = None


def search(request, objective=()):
    """Phase one, in up to four frames.

    Parameters
    ----------
    request : Request
    objective : tuple of Requirement
        Those whose bounds are free; numbers stand in for them.

    Returns
    -------
    phase, frame, blocks, unknowns, units
        The last variables of the blocks are the levels of the free
        bounds in these units.
    """
    frame, tried = Frame.of(request), []
    if len(request.pairs) > MANY and not objective:
        found = _cutting_plane(request, frame)
        if found is not None:
            return found
    for _ in range(4):
        units = {r.parameter.key: r.level_unit(request, frame)
                 for r in objective}
        free = {name: Unknown(name, 1) for name in units}
        expressions, unknowns = request.in_unknowns(frame, levels={
            name: free[name] * unit for name, unit in units.items()})
        blocks = Blocks.of(
            expressions.values(), [*unknowns, *free.values()])
        first = None if objective else frame.guess(unknowns)
        phase = phase_one(blocks, start=first)
        tried.append((phase, frame, blocks, unknowns, units))
        if phase.x is not None:
            return tried[-1]
        if phase.reach > CERTAIN or len(request.fixed_modes()):
            break
        frame = closer(request, frame, unknowns, phase.near)
    refused = [t for t in tried if t[0].verdict == "infeasible"] or tried
    best = min(max(t[0].reach for t in refused), CERTAIN)
    # beyond that, rounding errors decide which frame reaches further
    return next(t for t in refused if t[0].reach >= best / 10)


def _cutting_plane(request, frame):
    """Phase one for many pairs of vertices: what `search` returns, or None.

    The centre of a few pairs' blocks; then those that it violates most
    join them, until it violates none.
    """
    expressions, unknowns = request.in_unknowns(frame)
    blocks = Blocks.of(expressions.values(), unknowns)
    newton = newton_of(blocks)
    owners = np.array([str(name.vertices) for name in expressions])
    chosen = ["()"]  # P, and whatever belongs to no pair
    x = frame.guess(unknowns)
    x = np.zeros(blocks.variables) if x is None else x
    while (least := newton.least(x)).min() <= 0:
        broken = owners[np.argsort(least)[:(least <= 0).sum()]]
        fresh = [o for o in dict.fromkeys(broken) if o not in chosen]
        chosen += fresh[:MORE]
        some = blocks.only(np.flatnonzero(np.isin(owners, chosen)))
        phase = phase_one(some, start=x)
        if phase.x is None:
            return None
        x = any_centre(some, unknowns, phase.x, enough=0.3)
    return Phase("feasible", x=x), frame, blocks, unknowns, {}


def closer(request, frame, unknowns, near):
    """A frame in which the least infeasible P is the identity.

    A solution of bad condition in the first frame may be plain there.
    """
    size = sum(u.size for u in unknowns)
    values = unpacked(unknowns, near[:size])
    P = sum(values[name] for name in request.lyapunov)
    sizes, directions = np.linalg.eigh(P)
    if sizes[-1] <= 0:  # it points nowhere
        return frame
    sizes = np.sqrt(np.maximum(sizes / sizes.max(), 1e-6))
    return Frame.at(request, frame.T @ (directions * sizes), frame.scale)


def answer(request):
    """The Solution of a request that leaves nothing open."""
    phase, frame, blocks, unknowns, _ = search(request)
    if phase.x is not None:
        found = finish(request, frame, blocks, unknowns, phase.x)
        if found.status == "feasible" or not len(request.fixed_modes()):
            return found
    refused = Solution(
        request, phase.verdict, request.gain, frame=frame,
        multipliers=phase.Z,
    )
    if phase.verdict == "undecided" and (
        len(request.fixed_modes())
        or phase.Z is not None
        and prove_infeasible(request, frame, phase.Z).proven
    ):
        return replace(refused, status="infeasible")
    return refused


def follow(request, start):
    """The Solution near another one, or None.

    What is infeasible or unbounded is left to the way that doesn't
    depend on the start.
    """
    if start is None or start.status != "feasible":
        return None
    frame = Frame.at(request, start.frame.T, start.frame.scale)
    expressions, unknowns = request.in_unknowns(frame)
    blocks = Blocks.of(expressions.values(), unknowns)
    x = _packed(request, frame, unknowns, start)
    if x is None:
        return None
    phase = phase_one(blocks, start=x, multipliers=False)
    if phase.x is None:
        return None
    try:
        x = centre(blocks, phase.x)
    except Unbounded:
        return None
    return _solution(request, frame, unknowns, x)


def _packed(request, frame, unknowns, start):
    """The variables in a frame, from a Solution of the same shape.

    None if that doesn't know the requirements' own unknowns.
    """
    V = start.P if start.V is None else start.V
    right = frame.back @ V @ frame.back.T
    gain = start.K @ frame.T / frame.scale
    P = [frame.back @ p @ frame.back.T for p in np.atleast_3d(start.P.T).T]
    values = {"V": right, "Y": gain @ right.T}
    values.update(zip(request.lyapunov, P, strict=True))
    known = start.own or {}
    for name, unit in request.own_units(frame).items():
        if name not in known:
            return None
        values[name] = known[name] / unit
    if any(np.shape(values[u.name]) != u.shape for u in unknowns):
        return None
    return np.concatenate([u.pack(values[u.name]) for u in unknowns])


def finish(request, frame, blocks, unknowns, x):
    """The analytic centre as a Solution, from a feasible point."""
    x = any_centre(blocks, unknowns, x)
    return _solution(request, frame, unknowns, x)


def _solution(request, frame, unknowns, x):
    values = unpacked(unknowns, x)
    lyapunov = [values[name] for name in request.lyapunov]
    slack = request.coupling == "slack"
    right = values["V"] if slack else lyapunov[0]
    K = gain_of(request, frame, unknowns, x)
    lyapunov = [frame.T @ p @ frame.T.T for p in lyapunov]
    lyapunov = [(p + p.T) / 2 for p in lyapunov]
    P = np.array(lyapunov) if slack else lyapunov[0]
    V = frame.T @ right @ frame.T.T if slack else None
    Y = K @ (V.T if slack else P)
    own = {name: values[name] * unit
           for name, unit in request.own_units(frame).items()}
    margins = {
        name: margin(g)
        for name, g in request.blocks(P, Y, V=V, own=own).items()
    }
    good = min(margins.values()) > 1e-9
    if not good:  # too close for floats
        good = prove(request, K, P, 17, V, own).proven
    status = "feasible" if good else "undecided"
    return Solution(request, status, K, P, Y, V, margins, frame, own=own)


def gain_of(request, frame, unknowns, x):
    """K of a point of the LMIs, in the plant's own units."""
    if request.gain is not None:
        return request.gain
    known = unpacked(unknowns, x)
    right = known["V"] if request.coupling == "slack" else known["P"]
    K = np.linalg.solve(right, known["Y"].T).T
    return np.linalg.solve(frame.T.T, K.T).T * frame.scale
