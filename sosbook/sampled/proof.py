"""Proofs, in ball arithmetic, that sampled loops are stable."""

from functools import partial
from itertools import product
from time import monotonic
from typing import Any

from flint import ctx

from ..exact.definite import round_digits
from ..exact.proof import DIGITS, Stopped, first_proven, proven_within
from ..laws.taken import is_controller
from ..plants.checks import count, finite, positive
from ..plants.kinds import Plant, checked_plant
from ..plants.sensed import asked_of, plant_of
from ..requirements.base import Requirement
from ..runtime.array_like import ArrayLike
from ..runtime.threads import one_thread
from ..synthesis.request import Request
from .channel import checked_norm
from .cover import cover
from .discretize import by_name, input_vertices
from .loops import BALL_BITS, SampledFamily
from .proof_file import MORE, PARTS, Found, SampledProof, undecided
from .timing import TimeBox

__all__ = ["SampledProof", "certify_sampled"]

MOST_VERTICES = 12  # of a family whose ranges are cut


@one_thread
def certify_sampled(
    plant: Plant,
    K: Any,
    T: float | tuple[float, float],
    delay: float | tuple[float, float] = 0.0,
    U: ArrayLike | None = None,
    rate: float = 1.0,
    digits: int | None = None,
    cells: int = 64,
    centre: float = 0.0,
    norm: Requirement | None = None,
    time_limit: float | None = None,
    progress: bool = False,
) -> SampledProof:
    """Prove a sampled loop stable, for every plant and for a clock that varies.

    Parameters
    ----------
    plant
        As for `c2d`. All floats are read as decimals.
    K : (m, N) or (m, N + m d) array_like, design, Controller or control.StateSpace
        A gain (or a design's, by its names) is rounded to ``digits`` significant
        digits before the proof; of a sampled controller, of any memory, all digits
        are taken. Its inputs are the plant's states and its outputs the plant's
        inputs: they are found by name, in any order. Without names they are taken in
        order, and the claim says so. Of a law that a design or a controller of
        continuous time brings along its program at T is taken.
    T : float or (low, high)
        Time between samples, in s. A range: every sequence of intervals in it. A
        controller's ``dt`` is one of them, and its matrices stay what they are.
    delay : float or (low, high)
        As for `c2d`. A range, or a delay beside a range of T: every sequence of
        delays in it, none longer than the interval in which it falls. Beside one T
        it may be (0.013, 0.034) for T = 0.01, too. Over more than one tick the plant
        holds the newest command that has arrived, and one that comes after a newer
        one is never used: see `sosbook.sampled.ages`. No file's text holds that.
    U
        As for `c2d`.
    rate : float
        Prove that motions decay at least as rate^k, from sample to sample.
    digits : int, optional
        Without it 6, 8, 10, 12 and 17 are tried.
    cells : int
        How many cells of plants and of clocks may resist one set of Lyapunov
        matrices and are halved, at most; four times as many, again and again, until a
        ``time_limit`` is over, if one is given.
    centre : float
        With another one than 0: prove that all eigenvalues of each plant's loop lie in
        the disk with this centre and the radius ``rate``, which lies in the unit disk;
        of one clock that doesn't vary.
    norm : HInfinity, optional
        Prove this bound, too, from disturbances w that are held from tick to tick to
        outputs at the ticks: sums over the ticks of |y|^2 stay below gamma^2 times
        those of |w|^2, in the order of any clock that varies.
    time_limit : float, optional
        Seconds after which nothing is proven, and the answer says so.
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    SampledProof
        The proof is about constant plants: a plant that changes from sample to
        sample isn't covered. Not proven doesn't mean unstable: ``failed`` says
        whether a plant, and a clock, was found that is.

    Notes
    -----
    The exponentials of the exact data are enclosed in balls. In a cell of plants,
    and in one of clocks, the loop F is the mixture of the corners' F_i up to its
    second derivatives, which are enclosed for the whole cell; the theorem of
    `sosbook.sampled.cells` takes them away. Then a text is sought that the
    stand-alone checker decides by integers alone, see `sosbook.exact.checker.sampled`;
    where none is found in so small cells as it needs, ``python -m sosbook verify`` says
    that this package alone decides the file. The plants between vertices are cut as
    a box where they are one, else as a simplex; with many vertices that aren't a
    box there are too many halves.

    With a range a Lyapunov matrix of a plant holds for all its clocks. Stability
    for each constant clock would need less, and isn't enough: two of them in turn
    may be unstable.

    Examples
    --------
    >>> from sosbook import Polytope, SecondOrderSystem
    >>> cart = Polytope([
    ...     SecondOrderSystem([[M]], [[0]], [[0]], [[1]]) for M in (1, 2)])
    >>> print(certify_sampled(cart, [[-1, -1.5]], T=0.2, delay=0.1))
    ... # doctest: +NORMALIZE_WHITESPACE
    proven:
    - the sampled loop of every constant plant of the polytope, with a tick every 0.2 s
      and a delay of 0.1 s, is stable
    >>> print(certify_sampled(cart, [[-1, -1.5]], T=(0.1, 0.3), delay=(0, 0.1)))
    ... # doctest: +NORMALIZE_WHITESPACE
    proven:
    - the sampled loop of every constant plant of the polytope is stable for every
      sequence of sampling intervals in [0.1, 0.3] s and delays in [0.0, 0.1] s, none
      longer than its interval
    """
    begun = monotonic()
    asked = U, rate, digits, cells, centre, norm, time_limit, progress
    found = search(plant, K, T, delay, *asked)
    left = None if time_limit is None else time_limit - (monotonic() - begun)
    return found.by_balls if left is not None and left <= 0 else found.in_text(left)


def by_balls(plant, K, T, delay=0.0, **asked):
    """As `certify_sampled`, of what is ``asked``: it has no text, and balls decide."""
    return search(plant, K, T, delay, **asked).by_balls


def search(
    plant, K, T, delay=0.0, U=None, rate=1.0, digits=None, cells=64, centre=0.0,
    norm=None, time_limit=None, progress=False,
):  # fmt: skip
    """The cells of a proof, `Found` in balls: of what `certify_sampled` is asked."""
    rate, centre = _rate(rate), finite("centre", centre)
    plant = plant_of(checked_plant(plant, of="a clock"), K)
    clocks, floats = TimeBox.of(T, delay), input_vertices(plant, U)
    if centre and (clocks.varies or abs(centre) + rate > 1):
        raise ValueError(
            f"centre = {centre}: a disk of radius rate = {rate} must lie in the unit "
            "disk, and the clock must not vary"
        )
    if norm is not None:
        norm = asked_of(plant, checked_norm(norm))
        if rate != 1 or centre:
            raise ValueError("norm is proven with rate=1 and centre=0: leave them out")
        Request(plant, U, requirements=[norm])  # raises where widths are wrong
    cells, K = count("cells", cells, least=1), by_name(K, plant, U, T, delay)
    for timing, d in product(clocks.corners, floats):
        timing.held(d)  # raises where a motion overflows
    timing = clocks.of_controller(K)

    whole = is_controller(K)

    def attempt(digits, _, plant=plant, floats=floats, cells=cells):
        gain = K if whole else round_digits(timing.gain(K, floats[0]), digits)
        with ctx.workprec(BALL_BITS):
            family = SampledFamily.of(plant, floats, timing, gain, centre, norm)
            for box in clocks.finer:
                tree, failed = cover(family, box, rate, cells)
                if tree is not None or undecided(0) not in failed:
                    break
            if tree is not None and not box.cuts:
                tree = {PARTS: box.parts} | tree
        asked = plant, U, T, delay, gain, rate, tree, failed, centre, norm
        shape = family.shape if tree is not None and box.cuts else None
        return Found(SampledProof.contents(*asked), shape)

    tries, few = (17,) if whole else DIGITS, cells

    def work():
        nonlocal few
        first = first_proven(attempt, digits, tries, places=(12,))
        while time_limit is not None and undecided(few) in first.failed:
            few *= MORE
            more = partial(attempt, cells=few)
            first = first_proven(more, digits, tries, places=(12,))
        for nearer in () if first.proven else _nearer(plant):
            more = nearer, input_vertices(nearer, U)
            found = attempt(tries[-1] if digits is None else digits, 12, *more)
            if found.proven:
                return found
        return first

    found = proven_within(time_limit, work, progress)
    if isinstance(found, Stopped):
        why = f"{found.why}: {few // MORE} cells were too few" * (few > cells)
        return unproven(why or found.why, plant, K, T, delay, U, rate, centre, norm)
    return found


def unproven(why, plant, K, T, delay, U=None, rate=1.0, centre=0.0, norm=None):
    """`Found` nothing, and ``why``, in words."""
    if not is_controller(K):
        K = TimeBox.of(T, delay).of_controller(K).gain(K, input_vertices(plant, U)[0])
    asked = plant, U, T, delay, K, rate, None, why, centre, norm
    return Found(SampledProof.contents(*asked))


def _nearer(plant):
    """Polytopes around a family with powers, with more and more pieces."""
    family = plant.family
    while family is not None and not family.multi_affine:
        powers = [name for name, degree in family.degree.items() if degree > 1]
        family = family.cut(**{name: 2 * family.pieces[name] for name in powers})
        if family.count > MOST_VERTICES:
            return
        yield family.polytope()


def _rate(rate):
    if not positive("rate", rate) <= 1:
        raise ValueError(f"rate must be at most 1, for stability; got {rate!r}")
    return float(rate)
