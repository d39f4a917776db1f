"""Bisection over round numbers: how far one requirement can be pushed."""

from functools import lru_cache

import numpy as np

from ...bisection import narrowed
from ...plants.checks import count
from ...requirements.shorthand import bounds, parameter
from .ask import point, seen


class EdgeSearch:
    """Bisection over counted round numbers of so many ``digits`` of one parameter of an
    `Ask`, ``ask``, by its name; a larger count, or place, asks for more.
    """

    def __init__(self, ask, name, digits):
        self.parameter = parameter(name, ask.requirements)
        bound = ask.known.get(name)
        ask.at(**{name: bound or self.parameter.start}).request()  # refuses
        if count("digits", digits, 1) > 6:
            raise ValueError(f"digits = {digits!r} must be 1, 2, ... or 6")
        self.ask, self.name, self.digits = ask, name, digits
        self.sign = self.parameter.harder
        self.start = self.parameter.shown(bound or self.parameter.start)
        low, high = self.parameter.limits or (self.start / 1000, self.start * 1000)
        self.ends = sorted(self.place(end) for end in (low, high))
        self.seen, self.trials = {}, {}  # designs, and what was found, by place
        self.closely = False  # whether more than trials are asked for

    def place(self, value):
        """The place of the round number next to a value in the unit shown."""
        return self.sign * _rank(value, self.digits)

    def number(self, place):
        """The number at a place, in the unit shown."""
        return _number(self.sign * place, self.digits)

    def value(self, place):
        """The parameter's value at a place, in the unit of the design functions."""
        return self.parameter.value(self.number(place))

    def at(self, place):
        """The design at a place, solved once."""
        if place not in self.seen:
            asked = {self.name: self.value(place)}
            self.seen[place] = self.ask.finished(self.trials.get(place), **asked)
        return self.seen[place]

    def holds(self, place):
        """True if the request at a place is feasible; no refusal is proven for it."""
        if place in self.seen or not self.ask.has_trials:
            return _feasible(self.at(place))
        if place not in self.trials:
            if self.closely:
                return _feasible(self.at(place))
            easier = max((k for k in self.known() if k < place), default=None)
            near = self.seen.get(easier) or self.trials.get(easier)
            self.trials[place] = self.ask.trial(near, **{self.name: self.value(place)})
        return seen(self.trials[place])

    def known(self):
        """The places at which there is a design, or a point inside at least."""
        places = {k for k, first in self.trials.items() if seen(first)}
        return places | {k for k, design in self.seen.items() if _feasible(design)}

    def is_dark(self, place):
        """True if no design was found at a ``place``, with a proof or without."""
        return not self.holds(place)

    def look_closely(self):
        """Forget the trials that found nothing and look closely from now on."""
        self.trials = {k: g for k, g in self.trials.items() if seen(g)}
        self.closely = True

    def overlooked(self, place):
        """True if a closer look at a ``place`` finds a design that a trial didn't."""
        return place in self.trials and _feasible(self.at(place))

    def fails(self, place):
        """True if the request at a place is infeasible."""
        design = self.at(place)
        return design is None or design.status == "infeasible"

    def edge(self, easier=None, harder=None):
        """An `Edge`'s sides, designs, reason, between ``easier`` and ``harder``."""
        good = bad = None
        if harder is not None and harder.feasible is not None:
            good = self.place(self.parameter.shown(harder.feasible))
            self.seen[good] = harder.design
        if easier is not None and easier.infeasible is not None:
            bad = self.place(self.parameter.shown(easier.infeasible))
            self.seen[bad] = easier.excluded
        if good is None:
            origin = self.place(self.start) if bad is None else bad
            good = self.walk(origin, -1, self.holds)
            if good is None:
                self.look_closely()
                good = self.walk(origin, -1, self.holds)
        if bad is None:
            origin = self.place(self.start) if good is None else good
            bad = self.walk(origin, 1, self.is_dark)
        known = self.seen.keys() | self.trials.keys()
        tried = [k for k in known if bad is None or k < bad]
        if good is not None:  # the walks have come closer since
            good = max(filter(self.holds, tried))
        if bad is not None:
            above = [k for k in known if good is None or k > good]
            bad = min(filter(self.is_dark, above))
        top = self.last_design(good, bad)
        if top is not None and self.overlooked(top + 1):
            self.look_closely()
            bad = self.walk(top + 1, 1, self.is_dark)
            top = self.last_design(top + 1, bad)
        near = None if top is None else self.at(top)
        bottom = self.first_refusal(top, bad, near)
        return self.result(top, bottom)

    def so_far(self, reason):
        """The result that is proven among the places tried, and the ``reason`` for no
        more.
        """
        points = {k: point(g) for k, g in self.trials.items() if seen(g)}
        self.seen = points | self.seen
        tried = {k: d for k, d in self.seen.items() if d is not None}
        good = [k for k, d in tried.items() if _feasible(d) and certified(d)]
        bad = [k for k, d in tried.items() if d.status == "infeasible"]
        top, bottom = max(good, default=None), min(bad, default=None)
        return (*self.result(top, bottom)[:4], reason)

    def walk(self, place, way, test):
        """The first place this way that passes a test, in growing strides, or None."""
        factor = 1.5
        while not test(place):
            end = self.ends[way > 0]
            if (place - end) * way >= 0:
                return None
            far = self.place(self.number(place) * factor ** (way * self.sign))
            place = min(far, end) if way > 0 else max(far, end)
            factor *= factor
        return place

    def last_design(self, good, bad):
        """The last place from ``good`` to ``bad`` with a certified design, or None."""
        if good is None:
            return None
        if bad is None:
            bad = self.ends[1] + 1
            self.seen[bad] = None
        top = _first(self.is_dark, good, bad) - 1
        while not self.stands(top):
            top -= 1
            if top < good or not self.holds(top):
                return None
        return top

    def stands(self, place):
        """True if a place has a certified design, if need be in its own coordinates."""
        design = self.at(place)
        if not _feasible(design) or certified(design):
            return _feasible(design)
        if self.ask.sharpens(design):
            again = self.ask.solve(design, **{self.name: self.value(place)})
            if _feasible(again) and certified(again):
                self.seen[place] = again
        return self.seen[place] is not design

    def first_refusal(self, top, bad, near):
        """The first refused place from ``top`` to ``bad``, or None; see ``near``."""
        if bad is None:
            return None
        low = self.ends[0] - 1 if top is None else top
        if top is not None and self.refused(top + 1, near):
            return top + 1
        bad = self.walk(bad, 1, self.fails)
        if bad is None:
            return None
        bottom = _first(self.fails, low, bad)
        stride, last = 1, bottom - 1
        while not self.refused(bottom, near):  # too near for exact multipliers
            last, bottom = bottom, bottom + stride
            stride *= 2
            if bottom > self.ends[1]:
                return None
        return _first(lambda k: self.refused(k, near), last, bottom)

    def refused(self, place, near):
        """True if a place is refused with a proof, perhaps as ``near`` scales it."""
        design = self.at(place)
        if design is None:
            return True
        if design.status == "feasible" or provably_refused(design):
            return design.status != "feasible"
        if self.ask.sharpens(near):
            again = self.ask.solve(near, **{self.name: self.value(place)})
            if again.status != "feasible" and provably_refused(again):
                self.seen[place] = again
        return self.seen[place] is not design

    def result(self, top, bottom):
        """The values and designs at ``top`` and ``bottom``, and the reason."""
        reason = ""
        on, back = ("up", "down") if self.sign > 0 else ("down", "up")
        if top is None:
            least = self.number(self.ends[0])
            reason = f"no design {back} to {self.name} = {least:.6g}"
        elif bottom is None:
            most = f"{self.name} = {self.number(self.ends[1]):.6g}"
            reason = f"nothing is proven infeasible {on} to {most}"
        elif self.at(bottom) is None:
            reason = "beyond the edge the region is empty"
        ends = top, bottom
        values = [None if k is None else self.value(k) for k in ends]
        return *values, *(None if k is None else self.at(k) for k in ends), reason


def _rank(value, digits):
    """The place of the nearest number with so many digits among all of them."""
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    base = 10 ** (digits - 1)
    return int(exponent) * 9 * base + round(float(mantissa) * base) - base


def _number(rank, digits):
    base = 10 ** (digits - 1)
    exponent, steps = divmod(rank, 9 * base)
    return float(f"{base + steps}e{exponent - digits + 1}")


def round_numbers(which, low, high, digits):
    """The round numbers from ``low`` to ``high``, of so many ``digits`` in the unit of
    a `Parameter`, ``which``, the least demanding first.
    """
    ends = [_rank(which.shown(end), digits) for end in (low, high)]
    numbers = [_number(k, digits) for k in range(ends[0], ends[1] + 1)]
    top = np.inf if which.limits is None else which.limits[1]
    numbers = [which.value(x) for x in numbers if x <= top]
    return numbers if which.harder > 0 else numbers[::-1]


def shown(name, value):
    """A value of the parameter of this name in the unit shown, degrees for an angle."""
    return parameter(name).shown(value)


def _first(test, low, high):
    """The smallest place above low that passes, if high does."""
    return narrowed(lambda k: not test(k), low, high, lambda a, b: (a + b) // 2)[1]


def _feasible(design):
    """True if a design, which may be None, is feasible."""
    return design is not None and design.status == "feasible"


@lru_cache(maxsize=256)
def certified(design):
    """True if a design has an exact proof: an edge asks for what a search has asked."""
    return design.certify().proven


def provably_refused(design):
    """True if a design has an exact proof that there is none."""
    return bool(design.infeasibility)


def requirements(request):
    """The bounds that a request asks for, by their parameters' names."""
    return bounds(request.requirements)
