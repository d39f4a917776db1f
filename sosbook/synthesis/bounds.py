"""Bounds of a design, or a neighbour: asked, proven with a P of its own, and true."""

from dataclasses import dataclass, replace
from html import escape
from math import isfinite
from time import monotonic
from typing import Any

from ..plants.checks import SizeError
from ..runtime.later import later
from ..runtime.time_limit import LEAST_TIME, OutOfTime, checked_seconds, time_limit
from .feasibility import guarded
from .objectives import at_optimum
from .slack import designed, feasible, with_slack
from .solution import Solution

ANY_ORDER = "synthesis.structured.any_order"
SECONDS = 60.0  # for a neighbouring design, and for what is true of it
NEXT_BACKOFF = 0.01  # of its least bound, as everywhere
BACKOFF = 0.001  # what is proven is so much easier than the truth, as a fraction
DIGITS = 4  # of what is proven
AS_ASKED = (
    "With <= or >= it is what was asked, by the proof of the design: no sharper bound "
    "was proven in the time."
)


@dataclass(frozen=True, eq=False)
class Bound:
    """A requirement of a gain, in three numbers: the bound as asked, the best one that
    is ``proven``, to four digits, with a P of its own (``part`` is the proof), and the
    worst ``true`` value that a search has found. No linear controller of any order
    keeps ``excluded``, which the ``refusal`` proves; ``as_asked``: whether the proof of
    the design gives what was asked.
    """

    requirement: Any
    asked: float
    proven: float | None
    true: float
    part: Any
    excluded: float | None = None
    refusal: Any = None
    as_asked: bool = False


class Bounds(tuple):
    """The `Bound` of each requirement that has one, of an ``iterable``: a table."""

    __slots__ = ()

    def __getitem__(self, key):
        """That of a requirement's name, or of a place."""
        if not isinstance(key, str):
            return super().__getitem__(key)
        for b in self:
            if key in (b.requirement.name, _key(b)):
                return b
        raise KeyError(f"no bound is called {key!r:.80}, only {[*map(_key, self)]}")

    def rows(self):
        """Words, asked, proven and true, and what is excluded, in text."""
        for b in self:
            p = b.requirement.parameter
            numbers = [b.asked, b.proven, b.true, b.excluded]
            texts = ["-" if x is None else f"{p.shown(x):.4g}" for x in numbers]
            if b.as_asked:
                texts[1] = f"{'>=' if p.harder > 0 else '<='} {texts[0]}"
            yield b.requirement.words, *texts[: len(self._heads)]

    @property
    def _heads(self):
        some = any(b.excluded is not None for b in self)
        return ("asked", "proven", "true", *("no linear controller keeps",) * some)

    @property
    def _note(self):
        return AS_ASKED if any(b.as_asked for b in self) else ""

    def __repr__(self):
        table = [("", *self._heads), *self.rows()]
        wide = [max(map(len, column)) for column in zip(*table)]
        lines = [
            "  ".join(
                [
                    row[0].ljust(wide[0]),
                    *(x.rjust(w) for x, w in zip(row[1:], wide[1:])),
                ]
            )
            for row in table
        ]
        return "\n".join([*lines, *filter(None, [self._note])])

    def _repr_html_(self):
        head = "".join(f"<th>{x}</th>" for x in ("requirement", *self._heads))
        rows = "".join(
            "<tr>" + "".join(f"<td>{escape(x)}</td>" for x in row) + "</tr>"
            for row in self.rows()
        )
        note = f"<p>{escape(self._note)}</p>" if self._note else ""
        return f"<table><tr>{head}</tr>{rows}</table>{note}"


def _key(bound):
    return bound.requirement.parameter.key


def bounds_of(request, K, seconds):
    """The `Bounds` of a gain ``K`` for each bound of a ``request`` by itself, after so
    many ``seconds``, with multipliers: see `sosbook.synthesis.known_gain.least`.
    """
    from .at_once import excluded_at_once
    from .known_gain import Kept, least, worst
    from .ranges import family

    known = replace(request, gain=K, coupling="multipliers")
    plants, found = family(known), []
    asked = [r for r in known.requirements if r.parameter and r.takes_multipliers]
    seconds, begun = checked_seconds(seconds, needed=True), monotonic()
    for r in asked:
        bad = worst(known, r, plants)
        part, beyond = Kept(r, "undecided", bad), (None, None)
        try:
            with time_limit(max(seconds - (monotonic() - begun), LEAST_TIME)):
                part = least(known, r, plants, BACKOFF, DIGITS, bad)
                bounded = isfinite(bad.truth)
                if known.law.whole:
                    beyond = excluded_at_once(request, r)
                elif bounded and r.bounds_response() is not None:
                    best_excluded = later(ANY_ORDER, "best_excluded")
                    beyond = best_excluded(known, r, float(bad.truth))
        except OutOfTime as over:
            if over.end < begun + seconds:  # somebody else's limit
                raise
        proven = part.requirement.bound if part.status == "feasible" else None
        found.append(Bound(r, r.bound, proven, float(bad.truth), part, *beyond))
    return Bounds(found)


def neighbours(request, relaxed):
    """Sentences on designs for a ``request`` without a gain: with each of the
    ``relaxed`` requirements eased, without which there is one, or with all, of none.
    """
    if request.gain is not None:
        return ""
    asked = tuple(r for r in relaxed or request.requirements if r.parameter)
    seconds = SECONDS / max(len(asked), 1)
    if not relaxed:
        return _nearest(request, asked, SECONDS)
    several = [
        (_least if _minimised(r) else _nearest)(request, (r,), seconds) for r in asked
    ]
    return " ".join(filter(None, several))


def _least(request, relaxed, seconds):
    """A sentence, or nothing, on the least bound of one requirement that was found in
    some ``seconds``, and what is true of that loop.
    """
    (r,) = relaxed
    key, objective = r.parameter.key, {r.parameter.key: 1.0}

    def work():
        settled = with_slack(request, objective, refuse=True)
        if settled is None:
            return Solution(request, "undecided")
        return at_optimum(settled, objective, NEXT_BACKOFF)

    try:
        found = guarded(request, seconds, work)
    except SizeError:  # in these units nobody could write it down
        return ""
    if found.status != "feasible":
        return ""
    table = bounds_of(found.request, found.K, seconds)
    one = next(b for b in table if b.requirement.key == r.key)
    text = f"With {key} = {one.asked:g} there is a design; of its loop {one.true:.4g} "
    text += "is true"
    if one.proven is None:
        return f"{text}."
    text += f", and {one.proven:.4g} proven with a P of its own"
    rest = [b for b in table if b is not one]
    if one.proven <= r.bound and all(b.proven is not None for b in rest):
        text += f": its gain keeps {key} = {r.bound:g}, as was asked"
    return f"{text}."


SHARES = 1.05, 1.2, 1.6, 2.5, 6.0, 25.0  # of a bound that gives way, in this order
TOO_FAR = f"Nothing was found with {SHARES[-1]:g} times less asked of"
NARROWED = 3  # halvings between the last share without a point and the first with one


def nearest(relaxed, keeps):
    """Bounds, by key, of the ``relaxed`` requirements, eased by one share, the nearest
    to the asked ones that ``keeps``, a function, is true of; or None.
    """

    def eased(share):
        pairs = ((r.parameter, r.bound) for r in relaxed)
        return {p.key: p.eased(bound, share) for p, bound in pairs}

    low, found = 1.0, None
    for share in SHARES:
        if keeps(eased(share)):
            found = share
            break
        low = share
    for _ in range(NARROWED if found else 0):
        middle = (low * found) ** 0.5
        if keeps(eased(middle)):
            found = middle
        else:
            low = middle
    return found and eased(found)


def _nearest(request, relaxed, seconds):
    """A sentence, or nothing, on those of the ``relaxed`` that have to be eased, all
    by one share: the numbers with which a design was found in some ``seconds``.
    """
    owners = {r.parameter.key: r for r in relaxed}

    def keeps(bounds):
        return feasible(request.with_bounds(bounds))

    def work():
        bounds = nearest(relaxed, keeps)
        if bounds is None:
            words = " and ".join(r.words for r in relaxed)
            return Solution(request, "undecided", reason=f"{TOO_FAR} {words}.")
        for key in owners if len(owners) > 1 else ():  # not all of them are in the way
            less = {k: b for k, b in bounds.items() if k != key}
            bounds = less if keeps(less) else bounds
        asked = request.with_bounds(bounds)
        return designed(asked, {}, NEXT_BACKOFF, None, None)

    found = guarded(request, seconds, work)
    if found.status != "feasible":
        return found.reason if found.reason.startswith(TOO_FAR) else ""
    told, was = [], []
    for key, r in owners.items():
        best = found.request.owner(key).bound
        if best != r.bound:
            told.append(f"{r.words} = {r.parameter.shown(best):.6g}")
            was.append(f"{r.parameter.shown(r.bound):.6g}")
    told, was = " and ".join(told), " and ".join(was)
    return f"With {told} there is a design (asked: {was})."


def _minimised(r):
    """True if the bound of r can be minimised, and read again with a P of its own."""
    return r.parameter is not None and r.parameter.power and r.takes_multipliers
