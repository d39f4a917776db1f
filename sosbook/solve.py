"""From a request to its analytic centre, with the line searches."""

from dataclasses import dataclass, replace

import numpy as np

from .frame import Frame, typical_rate
from .lmi import Unknown, block, eye
from .lmi.centre import (
    CERTAIN,
    Blocks,
    Unbounded,
    centre,
    margin,
    minimize,
    phase_one,
)
from .lmi.certificate import round_digits
from .proof import prove, prove_infeasible
from .request import Request

__all__ = ["Solution", "feasible", "finish", "solve"]

# epsilon in units of 1 / (typical rate), in the order of trial
SLACK_STEPS = (1 / 4, 1 / 2, 1 / 8, 1, 1 / 16, 2, 1 / 64, 4, 1 / 256)


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


def solve(request, smallest=False, free_mu=False, backoff=0.01, start=None):
    """Solve a request; search what it leaves open.

    Parameters
    ----------
    request : Request
        With ``coupling="slack"`` and no ``slack`` the scalar is searched.
    smallest : bool
        Find the smallest gamma.
    free_mu : bool
        Search mu.
    backoff : float
        What is added to the smallest gamma, as a fraction.
    start : Solution, optional
        Of a request of the same shape: where to start from.

    Returns
    -------
    Solution
    """
    if free_mu:
        request, found = _search_mu(request)
        if not found:
            return Solution(request, "undecided", request.gain)
    if request.coupling == "slack" and request.slack is None:
        request, found = _search_slack(request, smallest)
        if not found:
            return Solution(request, "undecided", request.gain)
    if smallest:
        return _at_smallest_gamma(request, backoff)
    answer = _follow(request, start) or _solve(request)
    if free_mu and answer.status == "infeasible":  # for this mu only
        return replace(answer, status="undecided")
    return answer


def feasible(request):
    """Whether phase one finds a solution of this very request."""
    if request.coupling == "slack" and request.slack is None:
        return _search_slack(request, False)[1]
    return _search(request)[0].x is not None


def _search(request, smallest=False):
    """Phase one, in up to four frames.

    Returns
    -------
    phase, frame, blocks, unknowns, unit
        With ``smallest`` the last variable of the blocks is gamma^2 in
        that unit.
    """
    frame, tried = Frame.of(request), []
    for _ in range(4):
        gamma2, more, unit = _square(request.gamma), [], None
        if smallest:
            C = request.vertices[0].C @ frame.T
            unit = request.mu * np.linalg.norm(C, 2) ** 2
            more = [Unknown("gamma2", 1)]
            gamma2 = more[0] * unit
        expressions, unknowns = request.in_unknowns(frame, gamma2)
        blocks = Blocks.of(expressions.values(), unknowns + more)
        phase = phase_one(blocks)
        tried.append((phase, frame, blocks, unknowns, unit))
        if phase.x is not None:
            return tried[-1]
        if phase.reach > CERTAIN:
            break
        frame = _closer(request, frame, unknowns, phase.near)
    return max(tried, key=lambda found: (
        found[0].verdict == "infeasible", found[0].reach))


def _closer(request, frame, unknowns, near):
    """A frame in which the least infeasible P is the identity.

    A solution of bad condition in the first frame may be plain there.
    """
    size = sum(u.size for u in unknowns)
    values = _unpack(unknowns, near[:size])
    P = sum(v for u, v in zip(unknowns, values) if u.symmetric)
    sizes, directions = np.linalg.eigh(P)
    if sizes[-1] <= 0:  # it points nowhere
        return frame
    sizes = np.sqrt(np.maximum(sizes / sizes.max(), 1e-6))
    return Frame.at(request, frame.T @ (directions * sizes), frame.scale)


def _square(gamma):
    return None if gamma is None else gamma**2


def _solve(request):
    phase, frame, blocks, unknowns, _ = _search(request)
    if phase.x is not None:
        return finish(request, frame, blocks, unknowns, phase.x)
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


def _follow(request, start):
    """The Solution near another one, or None.

    What is infeasible or unbounded is left to the way that doesn't
    depend on the start.
    """
    if start is None or start.status != "feasible":
        return None
    frame = Frame.at(request, start.frame.T, start.frame.scale)
    expressions, unknowns = request.in_unknowns(
        frame, _square(request.gamma))
    blocks = Blocks.of(expressions.values(), unknowns)
    x = _packed(request, frame, unknowns, start)
    phase = phase_one(blocks, start=x)
    if phase.x is None:
        return None
    try:
        x = centre(blocks, phase.x)
    except Unbounded:
        return None
    return _solution(request, frame, unknowns, x)


def _packed(request, frame, unknowns, start):
    """The variables in a frame, from a Solution of the same shape."""
    V = start.P if start.V is None else start.V
    right = frame.back @ V @ frame.back.T
    gain = start.K @ frame.T / frame.scale
    P = [frame.back @ p @ frame.back.T for p in np.atleast_3d(start.P.T).T]
    values = {"V": right, "Y": gain @ right.T}
    lyapunov = [u for u in unknowns if u.name.startswith("P")]
    values.update((u.name, p) for u, p in zip(lyapunov, P, strict=True))
    return np.concatenate([u.pack(values[u.name]) for u in unknowns])


def finish(request, frame, blocks, unknowns, x):
    """The analytic centre as a Solution, from a feasible point."""
    try:
        x = centre(blocks, x)
    except Unbounded:
        joined, x = _bounded(blocks, unknowns, x)
        try:
            x = centre(joined, x)
        except Unbounded:
            pass  # a degenerate set: keep the feasible point
    return _solution(request, frame, unknowns, x)


def _solution(request, frame, unknowns, x):
    values = _unpack(unknowns, x)
    lyapunov = [
        v for u, v in zip(unknowns, values) if u.name.startswith("P")
    ]
    slack = request.coupling == "slack"
    right = values[len(lyapunov)] if slack else lyapunov[0]
    if request.gain is None:
        K = np.linalg.solve(right, values[-1].T).T
        K = np.linalg.solve(frame.T.T, K.T).T * frame.scale
    else:
        K = request.gain
    lyapunov = [frame.T @ p @ frame.T.T for p in lyapunov]
    lyapunov = [(p + p.T) / 2 for p in lyapunov]
    P = np.array(lyapunov) if slack else lyapunov[0]
    V = frame.T @ right @ frame.T.T if slack else None
    Y = K @ (V.T if slack else P)
    margins = {
        name: margin(g) for name, g in request.blocks(
            P, Y, _square(request.gamma), V=V).items()
    }
    good = min(margins.values()) > 1e-9
    if not good:  # too close for floats
        good = prove(request, K, P, 17, V).proven
    status = "feasible" if good else "undecided"
    return Solution(request, status, K, P, Y, V, margins, frame)


def _unpack(unknowns, x):
    ends = np.cumsum([u.size for u in unknowns])[:-1]
    return [u.unpack(part) for u, part in zip(unknowns, np.split(x, ends))]


def _bounded(blocks, unknowns, x, r=16.0):
    """The blocks, joined by blocks "scale" that bound the unknowns.

    P is joined with Y in [[r I - P, Y'], [Y, r I]] > 0. Where every
    block is homogeneous the gain doesn't depend on r. It grows until
    there is a point inside, which is returned too: x if that will do.
    """
    P = [u for u in unknowns if u.symmetric]
    rest = [u for u in unknowns if not u.symmetric]
    lids = [block([[-p]]) for p in P]
    if len(P) == 1 and len(rest) == 1:
        (Y,), lids = rest, []
        rest = []
        lids = [block([[-P[0], Y.T], [Y, 0 * eye(Y.shape[0])]])]
    for X in rest:
        rows, cols = X.shape
        lids.append(block([[0 * eye(cols), X.T], [X, 0 * eye(rows)]]))
    while True:
        roof = [g + r * eye(len(g.constant)) for g in lids]
        joined = Blocks.of([*blocks.expressions, *roof], blocks.unknowns)
        if joined.contain(x):
            return joined, x
        found = phase_one(joined).x
        if found is not None:
            return joined, found
        r *= 16


def _smallest_gamma(request, gap):
    """Smallest gamma, its point, or phase one's outcome; the frame."""
    probe = replace(request, gamma=1.0)
    phase, frame, blocks, unknowns, unit = _search(probe, smallest=True)
    if phase.x is None:
        return None, phase, frame
    cost = np.zeros(blocks.variables)
    cost[-1] = 1.0
    best = _minimize(blocks, unknowns, cost, phase.x, gap)
    return np.sqrt(best[-1] * unit), best[:-1], frame


def _minimize(blocks, unknowns, cost, x, gap):
    """The minimum, if need be with bounded unknowns."""
    try:
        return minimize(blocks, cost, x, gap)[0]
    except Unbounded:  # perhaps in a direction that costs nothing
        bounds = 1e5, 1e7
    try:
        near, far = (
            minimize(joined, cost, inside, gap)[0]
            for joined, inside in (
                _bounded(blocks, unknowns, x, r) for r in bounds)
        )
    except Unbounded:
        far = None
    if far is None or far[-1] < 0.99 * near[-1]:
        raise ValueError(
            'minimize="gamma" has no minimum: the bound goes to zero or '
            "is reached by infinite gains only; limit them with saturation "
            "or a disk (rho)"
        )
    return near


def _at_smallest_gamma(request, backoff):
    gamma, x, frame = _smallest_gamma(request, 1e-5)
    if gamma is None:
        return Solution(request, x.verdict, request.gain)
    gamma *= 1 + backoff
    digits = 2 - int(np.floor(np.log10(gamma)))
    gamma = float(np.round(np.ceil(gamma * 10.0**digits) / 10.0**digits,
                           max(digits, 0)))
    request = replace(request, gamma=gamma)
    expressions, unknowns = request.in_unknowns(frame, gamma**2)
    blocks = Blocks.of(expressions.values(), unknowns)
    return finish(request, frame, blocks, unknowns, x)


def _search_slack(request, smallest):
    """The request with a slack scalar, and whether one was found."""
    unit = 1 / typical_rate(request)
    tried = {}
    for step in SLACK_STEPS:
        slack = float(round_digits(unit * step, 2))
        trial = replace(request, slack=slack)
        if not smallest:
            if feasible(trial):
                return trial, True
            continue
        bound = _smallest_gamma(trial, 1e-3)[0]
        if bound is not None:
            tried[slack] = bound
    if not tried:
        return trial, False
    best = min(tried, key=tried.get)
    return replace(request, slack=best), True


def _search_mu(request):
    """The request with the mu of the smallest gamma, and whether any."""
    if request.coupling == "slack" and request.slack is None:
        raise ValueError(
            'mu="free" and a free slack are two searches at once: give '
            "slack a number"
        )
    known = {}

    def bound(mu):
        if mu not in known:
            found = _smallest_gamma(replace(request, mu=mu), 1e-2)[0]
            known[mu] = np.inf if found is None else found
        return known[mu]

    mu = 1.0
    while bound(mu) == np.inf:  # a large mu asks nothing of w
        mu *= 256
        if mu > 1e24:
            return request, False
    for ratio in (16.0, 4.0, 1.6, 1.2):
        for step in (ratio, 1 / ratio):
            while bound(_near(mu * step)) < 0.99 * bound(mu):
                mu = _near(mu * step)
    return replace(request, mu=mu), True


def _near(mu):
    return float(round_digits(mu, 2))
