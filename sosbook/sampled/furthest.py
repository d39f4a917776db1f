"""The furthest claim of a sampled loop that is proven, by bisection."""

from time import monotonic
from typing import Any

from ..bisection import narrowed
from ..exact.proof import Stopped
from ..laws.taken import is_controller
from ..plants.checks import positive
from ..plants.kinds import Plant, checked_plant
from ..plants.sensed import plant_of
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds
from ..runtime.time_limit import time_limit as limited
from .channel import checked_norm
from .discretize import by_name
from .proof import search, unproven
from .proof_file import SampledProof

__all__ = ["furthest_sampled"]


@one_thread
def furthest_sampled(
    plant: Plant,
    K: Any,
    T: float | tuple[float, float],
    delay: float | tuple[float, float] = 0.0,
    find: str = "T",
    tolerance: float = 1e-3,
    time_limit: float | None = None,
    **asked: Any,
) -> SampledProof:
    """The longest interval, the longest delay, the least rate or bound that is proven.

    Parameters
    ----------
    plant, K, T, delay
        As for `certify_sampled`.
    find : {"T", "delay", "rate", "norm"}
        What is sought: the longest interval, where T is (low, high); the longest
        delay, where ``delay`` is (low, high); or the smallest rate up to the one
        that is asked for, 1 without one; or the smallest bound up to that of ``norm``.
    tolerance : float
        The bisection ends within this share of the range, which is below 1.
    time_limit : float, optional
        Seconds after which the best proof until then is the answer.
    **asked
        What else `certify_sampled` takes.

    Returns
    -------
    SampledProof
        Its ``T``, ``delay``, ``rate``, ``norm`` say how far it goes. One that isn't
        proven, where the nearest claim isn't. A claim beyond it wasn't proven; that it
        is false isn't said.

    Examples
    --------
    For each constant interval up to 1.7294 s this loop is stable:

    >>> import sosbook as sos
    >>> one, A, B = [[1, 0], [0, 1]], [[0, 1], [0, -0.1]], [[0], [0.1]]
    >>> plant = sos.DescriptorSystem(one, A, B)
    >>> proof = furthest_sampled(plant, [[-3.75, -11.5]], T=(0.01, 3))
    >>> proof.proven, round(proof.T[1], 2)
    (True, 1.73)
    """
    plant = plant_of(checked_plant(plant, of="a clock"), K)
    K = by_name(K, plant, asked.get("U"), T, delay)
    slowest = asked.pop("rate", 1.0)
    ranges = {"T": T, "delay": delay, "rate": (slowest, 0.0)}
    norm = asked.get("norm")
    if norm is not None:
        ranges["norm"] = checked_norm(norm).bounds_response(), 0.0
    if find not in ranges:
        raise ValueError(f"find must be one of {sorted(ranges)}, got {find!r}")
    ends = ranges[find]
    if not isinstance(ends, (tuple, list)) or len(ends) != 2 or ends[0] == ends[1]:
        raise ValueError(f"{find} must be (low, high) to find the furthest one")
    near, far = map(float, ends)
    if not positive("tolerance", tolerance) < 1:
        raise ValueError(f"tolerance must be a share below 1, got {tolerance!r}")
    width = tolerance * abs(far - near)
    falls = find in ("rate", "norm")
    nearest = near if falls else near + width
    if find == "T" and is_controller(K) and K.dt not in (None, True):
        nearest = max(nearest, float(K.dt))  # no clock without the controller's own
    tried = []

    def holds(end):
        values = asked | {"T": T, "delay": delay, "rate": slowest}
        values[find] = end if find == "rate" else (near, end)
        if find == "norm":
            values[find] = norm.with_bound(end)
        tried.append(search(plant, K, **values))
        return tried[-1].proven

    seconds, begun = checked_seconds(time_limit), monotonic()
    try:
        with limited(seconds):
            if (falls or not holds(far)) and holds(nearest):
                narrowed(holds, nearest, far, width)
    except OutOfTime:
        if seconds is None:
            raise
    proofs = [proof for proof in tried if proof.proven]
    if proofs:
        left = None if seconds is None else seconds - (monotonic() - begun)
        late = left is not None and left <= 0
        return proofs[-1].by_balls if late else proofs[-1].in_text(left)
    if tried:
        return tried[-1].by_balls
    asked = {k: x for k, x in asked.items() if k in ("U", "centre", "norm")}
    asked["rate"] = slowest
    return unproven(Stopped(seconds).why, plant, K, T, delay, **asked).by_balls
