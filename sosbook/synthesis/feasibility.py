"""From a request to a point inside its LMIs and to their centre."""

from dataclasses import dataclass, replace
from time import monotonic
from typing import Any

import numpy as np

from ..lmi import Unknown
from ..lmi.bounded import any_centre, unpacked
from ..lmi.centre import (
    LONGEST_SOLUTION,
    Blocks,
    Phase,
    Unbounded,
    centre,
    margin,
    phase_one,
)
from ..lmi.exact import round_digits
from ..lmi.newton import newton_of
from ..lmi.read_only import ReadOnly
from ..lmi.time_limit import OutOfTime, check_time, time_limit
from ..plants.checks import positive
from .certificates import prove, prove_infeasible
from .cutting import EVERY, MANY, Cuts
from .exclusion import excluding_mass, excluding_mode, why_refused
from .problem import Request
from .scaling import Frame, in_plant_units, in_unknowns_of

__all__ = [
    "Solution",
    "answer",
    "finish",
    "follow",
    "gain_of",
    "guarded",
    "refused",
    "refused_by",
    "search",
    "solution_at",
    "written",
]

ROUNDING = 1e-6  # a margin below minus that is no rounding error
FAR = 1e3  # unknowns beyond it are measured in a bad unit
LARGE = 20  # from so many states on, looking for fixed modes first is cheap


@dataclass(frozen=True, eq=False)
class Solution(ReadOnly):
    """What `Design` knows of its LMIs.

    The fields request, status, K, P, Y, V, margins, frame, multipliers and own
    are explained there.

    Parameters
    ----------
    request, status, K, P, Y, V, margins, frame, multipliers, own
        As in `Design`.
    reason : str
        Why there is no design, in a sentence: what is proven, or what
        was excluded and what was merely not found; or why the design
        isn't all that was asked. Otherwise empty.
    exclusion : InfeasibilityCertificate or FixedModeCertificate or None
        The exact proof of "infeasible".
    """

    request: Request
    status: str
    K: np.ndarray | None = None
    P: np.ndarray | None = None
    Y: np.ndarray | None = None
    V: np.ndarray | None = None
    margins: dict | None = None
    frame: Frame | None = None
    multipliers: list | None = None
    own: dict | None = None
    reason: str = ""
    exclusion: Any = None


def guarded(request, seconds, work):
    """What ``work`` returns; undecided where time or numbers give out.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    seconds : float
        Limit of the time.
    work : callable
        Without arguments; returns a Solution.

    Returns
    -------
    Solution
        The result of ``work``, or an undecided Solution.
    """
    begun = monotonic()
    try:
        with time_limit(positive("time_limit", seconds)), np.errstate(all="ignore"):
            return work()
    except OutOfTime:
        if monotonic() - begun < seconds:  # somebody else's limit
            raise
        reason = f"Stopped after {seconds:g} s: raise time_limit, or ask for less."
    except MemoryError as error:
        reason = f"The request is too large: {error}."
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        mode = excluding_mode(request)  # exact, whatever floats say
        if mode is not None:
            return refused_by(request, mode)
        reason = f"The numerics gave up ({error}): are the units far apart?"
    return Solution(request, "undecided", request.gain, reason=reason)


def search(request, objective=()):
    """Phase one, in up to four frames.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    objective : tuple of Requirement
        Those whose bounds are free; numbers stand in for them.

    Returns
    -------
    phase, frame, blocks, unknowns, units
        The last variables of the blocks are the levels of the free
        bounds in these units.
    """
    names = tuple(r.parameter.key for r in objective)
    frame, tried = Frame.of(request, names), []
    if len(request.pairs) > MANY:
        found = _cutting_plane(request, frame, objective)
        if found is not None:
            return found
    for _ in range(4):
        check_time()
        blocks, unknowns, units = written(request, frame, objective)
        first = None if objective else frame.guess(unknowns)
        phase = phase_one(blocks, start=first)
        tried.append((phase, frame, blocks, unknowns, units))
        if phase.x is not None:
            return tried[-1]
        if phase.reach > LONGEST_SOLUTION:
            break
        frame = closer(request, frame, unknowns, phase.near, names)
    refused = [t for t in tried if t[0].verdict == "infeasible"] or tried
    best = min(max(t[0].reach for t in refused), LONGEST_SOLUTION)
    # beyond that, rounding errors decide which frame reaches further
    return next(t for t in refused if t[0].reach >= best / 10)


def written(request, frame, objective=(), sizes=()):
    """The blocks of a request in a frame, with the levels of free bounds.

    These, which the objective names, are variables.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    frame : Frame
        The coordinates.
    objective : tuple of Requirement
        As in `search`.
    sizes : dict, optional
        As in `Request.in_unknowns`.

    Returns
    -------
    blocks, unknowns, units
        The blocks know their ``names``; the rest as in `search`.
    """
    units = {r.parameter.key: r.level_unit(request, frame.owned(r)) for r in objective}
    free = {name: Unknown(name, 1) for name in units}
    expressions, unknowns = request.in_unknowns(
        frame,
        levels={name: free[name] * unit for name, unit in units.items()},
        sizes=sizes,
    )
    blocks = Blocks.of(expressions.values(), [*unknowns, *free.values()])
    blocks.names = list(expressions)
    return blocks, unknowns, units


def _cutting_plane(request, frame, objective):
    """Phase one for many pairs of vertices: what `search` returns, or None.

    The centre of a few pairs' blocks; then those that it violates most
    join them, until it violates none.
    """
    blocks, unknowns, units = written(request, frame, objective)
    cuts = Cuts(blocks, blocks.names)
    x = None if objective else frame.guess(unknowns)
    x = np.zeros(blocks.variables) if x is None else x
    while not cuts.holds(x):
        check_time()
        cuts.join(x)
        some = cuts.some()
        phase = phase_one(some, start=x)
        if phase.x is None:
            return None
        x = any_centre(some, some.unknowns, phase.x, enough=0.3)
    return Phase("feasible", x=x), frame, blocks, unknowns, units


def closer(request, frame, unknowns, near, levels=()):
    """A frame in which the least infeasible P is the identity.

    A solution of bad condition in the first frame may be plain there.

    Parameters
    ----------
    request, levels
        As in `Frame.of`.
    frame : Frame
    unknowns : list of Unknown
    near : array
        Of the unknowns, and more.
    """
    size = sum(u.size for u in unknowns)
    values = unpacked(unknowns, near[:size])
    P = sum(values[name] for name in request.lyapunov)
    sizes, directions = np.linalg.eigh(P)
    if sizes[-1] <= 0:  # it points nowhere
        return frame
    top = sizes.max()
    sizes = np.sqrt(np.maximum(sizes / top, 1e-6))
    units = {}
    for name, unit in frame.sizes.items():
        size = np.clip(values[name].item() / top, 1e-6, 1e6)
        units[name] = float(round_digits(unit / np.sqrt(size), 2))
    return Frame.at(
        request, frame.T @ (directions * sizes), frame.scale, None, levels, units
    )


def answer(request):
    """The Solution of a request that leaves nothing open."""
    if request.order > LARGE:  # sooner known than phase one begins
        known = excluding_mode(request)
        if known is not None:
            return refused_by(request, known)
    phase, frame, blocks, unknowns, _ = search(request)
    if phase.x is None:
        return refused(request, phase, frame)
    try:
        found = finish(request, frame, blocks, unknowns, phase.x)
    except OutOfTime:
        found = solution_at(request, frame, unknowns, phase.x)
        words = "Stopped on the way to the centre: this is some point inside."
        return replace(found, reason=words)
    if found.status == "feasible":
        return found
    reason = _too_thin(found)
    if min(found.margins.values()) < -ROUNDING:  # no point at all
        return Solution(request, "undecided", request.gain, reason=reason)
    return replace(found, reason=reason)


def _too_thin(found):
    """Why a point that phase one has found isn't good enough."""
    least = min(found.margins, key=found.margins.get)
    return (
        f"The numerics found a point whose margin, {found.margins[least]:.1g} of the "
        f"block {str(least)!r}, is below what floats can tell from zero; "
        "exact arithmetic doesn't confirm it."
    )


def refused(request, phase, frame):
    """The Solution of a request for which phase one in a frame found no point.

    "infeasible" where exact arithmetic excludes every point: by a mode
    that no gain moves, or by multipliers. Otherwise "undecided".
    """
    mode = excluding_mode(request)
    if mode is not None:
        return refused_by(request, mode, frame, phase.Z)
    found = Solution(
        request, "undecided", request.gain, frame=frame, multipliers=phase.Z
    )
    mass = excluding_mass(request)
    if mass is not None:
        i, j = (k + 1 for k in mass.vertices)
        text = f"Between the vertices {i} and {j} a plant has a singular mass matrix."
        return replace(found, status="infeasible", reason=text, exclusion=mass)
    if phase.Z is not None:
        proof = prove_infeasible(request, frame, phase.Z)
        if proof.proven:
            text = "Exact multipliers of the LMIs exclude every solution"
            text = " ".join(filter(None, (text, request.condition))) + "."
            return replace(found, status="infeasible", reason=text, exclusion=proof)
    return replace(found, reason=why_refused(request, phase, frame))


def refused_by(request, certificate, frame=None, multipliers=None):
    """The Solution of a request that a mode excludes, by a certificate.

    The frame and the multipliers are those of the LMIs, if there are any.
    """
    mode, given = certificate.mode, request.gain is not None
    i, j = (k + 1 for k in certificate.place)
    where = (
        f" of vertex {i}" if i == j else f" halfway between the vertices {i} and {j}"
    )
    if len(request.vertices) == 1:
        where = ""
    text = (
        f"This gain leaves a pole{where} at {mode:.4g} rad/s"
        if given
        else f"No gain moves the mode{where} at {mode:.4g} rad/s: it is uncontrollable"
    )
    return Solution(
        request,
        "infeasible",
        request.gain,
        frame=frame,
        multipliers=multipliers,
        reason=f"{text}, which violates {certificate.requirement}.",
        exclusion=certificate,
    )


def follow(request, start):
    """The Solution of a request near another one, ``start``, or None.

    What is infeasible or unbounded is left to the way that doesn't
    depend on the start.
    """
    if start is None or start.status != "feasible":
        return None
    known = start.frame.sizes
    frame = Frame.at(request, start.frame.T, start.frame.scale)
    if known.keys() == frame.sizes.keys():
        frame = replace(frame, sizes=known)
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
    return solution_at(request, frame, unknowns, x)


def _packed(request, frame, unknowns, start):
    """The variables in a frame, from a Solution of the same shape, or None."""
    values = in_unknowns_of(request, frame, start)
    if values is None or any(np.shape(values[u.name]) != u.shape for u in unknowns):
        return None
    return np.concatenate([u.pack(values[u.name]) for u in unknowns])


def finish(request, frame, blocks, unknowns, x):
    """The analytic centre as a Solution of a request, from a feasible point x.

    The blocks are those of the request in the frame, affine in the
    ``unknowns``.

    With more than a thousand pairs of vertices it is the centre of some
    of their blocks, those that a cutting plane needs.
    """
    if np.abs(x).max() > FAR and request.followers(request.leader()):
        frame, blocks, unknowns, x = _nearer(request, frame, blocks, unknowns, x)
    if len(request.pairs) > EVERY:
        cuts = Cuts(blocks, blocks.names)
        x = cuts.solve(x, lambda some, x: any_centre(some, unknowns, x))
    else:
        x = any_centre(blocks, unknowns, x)
    return solution_at(request, frame, unknowns, x)


def _nearer(request, frame, blocks, unknowns, x):
    """The same point and blocks in a frame in which P and the sizes are one.

    The guess of a size may be wrong by orders of magnitude, and what is
    far away looks as if the set had no bound.
    """
    K = gain_of(request, frame, unknowns, x)
    found = in_plant_units(request, frame, unpacked(unknowns, x), K)
    point = Solution(request, "feasible", K, **found)
    try:
        there = Frame.of_solution(request, point, unit=True)
    except np.linalg.LinAlgError:
        return frame, blocks, unknowns, x
    fresh, fresh_unknowns, _ = written(request, there)
    moved = _packed(request, there, fresh_unknowns, point)
    if moved is None or newton_of(fresh).least(moved).min() <= 0:
        return frame, blocks, unknowns, x
    return there, fresh, fresh_unknowns, moved


def solution_at(request, frame, unknowns, x):
    """The Solution of a point x inside a request's LMIs in a frame.

    The variables are those of the ``unknowns``.
    """
    K = gain_of(request, frame, unknowns, x)
    found = in_plant_units(request, frame, unpacked(unknowns, x), K)
    P, Y, V, own = found["P"], found["Y"], found["V"], found["own"]
    margins = {
        name: margin(g) for name, g in request.blocks(P, Y, V=V, own=own).items()
    }
    good = min(margins.values()) > 1e-9
    if not good:  # too close for floats
        good = prove(request, K, P, 17, V, own).proven
    status = "feasible" if good else "undecided"
    return Solution(request, status, K, P, Y, V, margins, frame, own=own)


def gain_of(request, frame, unknowns, x):
    """K of a point x of a request's LMIs in a frame, in the plant's own units.

    The variables are those of the ``unknowns``.
    """
    if request.gain is not None:
        return request.gain
    known = unpacked(unknowns, x)
    right = known["V"] if request.coupling == "slack" else known["P"]
    K = np.linalg.solve(right, known["Y"].T).T
    return np.linalg.solve(frame.T.T, K.T).T * frame.scale
