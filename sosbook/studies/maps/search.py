"""Bisection over round numbers: how far one requirement can be pushed."""

from dataclasses import replace

import numpy as np

from ...lmi.centre import Blocks, phase_one
from ...requirements.pole_region import PoleRegion
from ...requirements.vocabulary import HARDER_UP
from ...synthesis.feasibility import Solution, finish
from ...synthesis.pid import Design, design_pid
from ...synthesis.problem import Request
from ...synthesis.scaling import Frame

__all__ = ["Ask", "Search", "again", "certified", "refuted", "region_of",
           "replaced", "requirements", "round_numbers", "shown"]

# where the search starts if a requirement isn't asked
START = {"sigma": 1.0, "theta": np.pi / 4, "rho": 10.0, "gamma": 1.0,
         "u_max": 1.0}


class Ask:
    """A request in which any requirement can be replaced."""

    def __init__(self, plant, U, region, gamma, saturation, options):
        if not isinstance(region, (PoleRegion, type(None))):
            raise ValueError(
                "region must be a PoleRegion, whose sigma, theta and rho "
                f"can be moved, got {type(region).__name__}"
            )
        self.plant, self.U, self.options = plant, U, options
        self.saturation = saturation
        self.known = _values(region, gamma, saturation)

    def at(self, **values):
        other = object.__new__(Ask)
        other.__dict__.update(self.__dict__, known=self.known | values)
        return other

    def request(self):
        known = self.known
        fixed = {k: v for k, v in self.options.items()
                 if k in ("K_A", "coupling")}
        return Request(self.plant, self.U, region_of(known) or None,
                       known.get("gamma"), self.saturation, **fixed)

    def solve(self, near=None, **values):
        """A Design, or None where the region is empty.

        With a design nearby, in coordinates in which its P is I: close
        to the edge they are the better ones.
        """
        known = self.known | values
        region = region_of(known)
        if region is None:
            return None
        searches = {self.options.get("coupling"), self.options.get("mu")}
        if near is not None and not searches & {"slack", "free"}:
            return again(replaced(near.request, known), near)
        limit = self.saturation and replace(
            self.saturation, u_max=known["u_max"])
        return design_pid(self.plant, self.U, region or None,
                          known.get("gamma"), limit, **self.options)


class Search:
    """Bisection over round numbers; larger places ask for more."""

    def __init__(self, ask, name, digits):
        if name not in HARDER_UP:
            raise ValueError(
                f"name = {name!r} must be one of {', '.join(HARDER_UP)}"
            )
        if name == "gamma" and ask.plant.p == 0:
            raise ValueError("gamma needs a plant with F: say where the "
                             "disturbance enters")
        if name == "u_max" and ask.saturation is None:
            raise ValueError("u_max needs saturation=Saturation(u_max, x0): "
                             "the bound holds from x0 only")
        if not isinstance(digits, int) or not 1 <= digits <= 6:
            raise ValueError(f"digits = {digits!r} must be 1, 2, ... or 6")
        self.ask, self.name, self.digits = ask, name, digits
        self.sign = 1 if HARDER_UP[name] else -1
        self.start = shown(name, ask.known.get(name) or START[name])
        low, high = (1.0, 90.0) if name == "theta" else (
            self.start / 1000, self.start * 1000)
        self.ends = sorted(self.place(end) for end in (low, high))
        self.seen = {}

    def place(self, value):
        return self.sign * _rank(value, self.digits)

    def number(self, place):
        return _number(self.sign * place, self.digits)

    def value(self, place):
        number = self.number(place)
        return float(np.radians(number)) if self.name == "theta" else number

    def at(self, place):
        if place not in self.seen:
            self.seen[place] = self.ask.solve(
                **{self.name: self.value(place)})
        return self.seen[place]

    def holds(self, place):
        design = self.at(place)
        return design is not None and design.status == "feasible"

    def fails(self, place):
        design = self.at(place)
        return design is None or design.status == "infeasible"

    def edge(self, easier=None, harder=None):
        """The two sides and their designs, as in `Edge`, and the reason.

        Between the edges of easier and harder surroundings, if given.
        """
        good = bad = None
        if harder is not None and harder.feasible is not None:
            good = self.place(shown(self.name, harder.feasible))
            self.seen[good] = harder.design
        if easier is not None and easier.infeasible is not None:
            bad = self.place(shown(self.name, easier.infeasible))
            self.seen[bad] = easier.excluded
        if good is None:
            origin = self.place(self.start) if bad is None else bad
            good = self.walk(origin, -1, self.holds)
        if bad is None:
            origin = self.place(self.start) if good is None else good
            bad = self.walk(origin, 1, self.fails)
        tried = [k for k in self.seen if bad is None or k < bad]
        if good is not None:  # the walks have come closer since
            good = max(filter(self.holds, tried))
        if bad is not None:
            above = [k for k in self.seen if good is None or k > good]
            bad = min(filter(self.fails, above))
        top = self.last_design(good, bad)
        near = None if top is None else self.at(top)
        bottom = self.first_refusal(top, bad, near)
        return self.result(top, bottom)

    def walk(self, place, way, test):
        """The first place found this way, in growing strides, or None."""
        factor = 1.5
        while not test(place):
            end = self.ends[way > 0]
            if (place - end) * way >= 0:
                return None
            far = self.place(
                self.number(place) * factor ** (way * self.sign))
            place = min(far, end) if way > 0 else max(far, end)
            factor *= factor
        return place

    def last_design(self, good, bad):
        if good is None:
            return None
        if bad is None:
            bad = self.ends[1] + 1
            self.seen[bad] = None
        top = _first(lambda k: not self.holds(k), good, bad) - 1
        while not (self.sharpen(top) or certified(self.at(top))):
            top -= 1
            if top < good or not self.holds(top):
                return None
        return top

    def sharpen(self, place):
        """Whether it is certified in its own coordinates: the sharper ones."""
        again = self.ask.solve(
            self.at(place), **{self.name: self.value(place)})
        good = again.status == "feasible" and certified(again)
        if good:
            self.seen[place] = again
        return good

    def first_refusal(self, top, bad, near):
        if bad is None:
            return None
        low = self.ends[0] - 1 if top is None else top
        if top is not None and self.refused(top + 1, near):
            return top + 1
        bottom = _first(self.fails, low, bad)
        stride, last = 1, bottom - 1
        while not self.refused(bottom, near):  # too near for exact multipliers
            last, bottom = bottom, bottom + stride
            stride *= 2
            if bottom > self.ends[1]:
                return None
        return _first(lambda k: self.refused(k, near), last, bottom)

    def refused(self, place, near):
        design = self.at(place)
        if design is None:
            return True
        if design.status == "feasible" or refuted(design):
            return design.status != "feasible"
        if near is not None:
            again = self.ask.solve(near, **{self.name: self.value(place)})
            if again.status != "feasible" and refuted(again):
                self.seen[place] = again
        return self.seen[place] is not design

    def result(self, top, bottom):
        reason = ""
        if top is None:
            reason = (f"no design down to {self.name} = "
                      f"{self.number(self.ends[0]):.6g}")
        elif bottom is None:
            reason = (f"nothing is proven infeasible up to {self.name} = "
                      f"{self.number(self.ends[1]):.6g}")
        elif self.at(bottom) is None:
            reason = "beyond the edge the region is empty"
        return (
            None if top is None else self.value(top),
            None if bottom is None else self.value(bottom),
            None if top is None else self.at(top),
            None if bottom is None else self.at(bottom),
            reason,
        )


def _rank(value, digits):
    """Of the nearest number with so many digits, among all of them."""
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    base = 10 ** (digits - 1)
    return int(exponent) * 9 * base + round(float(mantissa) * base) - base


def _number(rank, digits):
    base = 10 ** (digits - 1)
    exponent, steps = divmod(rank, 9 * base)
    return float(f"{base + steps}e{exponent - digits + 1}")


def round_numbers(name, low, high, digits):
    """Those between two values, the least demanding first."""
    ends = [_rank(shown(name, end), digits) for end in (low, high)]
    numbers = [_number(k, digits) for k in range(ends[0], ends[1] + 1)]
    if name == "theta":
        numbers = [np.radians(x) for x in numbers if x <= 90]
    return numbers if HARDER_UP[name] else numbers[::-1]


def shown(name, value):
    """In the unit of the page: angles in degrees."""
    return float(np.degrees(value)) if name == "theta" else float(value)


def _first(test, low, high):
    """The smallest place above low that passes, if high does."""
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if test(middle) else (middle, high)
    return high


def certified(design):
    return design.certify().proven


def refuted(design):
    return bool(design.infeasibility and design.infeasibility.proven)


def _values(region, gamma, saturation):
    found = {name: getattr(region, name, None)
             for name in ("sigma", "theta", "rho")}
    found["gamma"] = gamma
    found["u_max"] = getattr(saturation, "u_max", None)
    return {name: value for name, value in found.items() if value}


def requirements(request):
    """What a request asks of each requirement, by name."""
    return _values(request.region, request.gamma, request.saturation)


def region_of(known):
    """A PoleRegion, () if nothing is asked, None if it is empty."""
    box = {k: known[k] for k in ("sigma", "theta", "rho") if k in known}
    if box.get("rho", np.inf) <= box.get("sigma", 0):
        return None
    return PoleRegion(**box) if box else ()


def again(request, near):
    """Solve in coordinates in which the P of a design nearby is I."""
    T = np.linalg.cholesky(near.P)
    T = T / np.abs(T).max()
    frame = Frame.at(request, T, np.linalg.norm(near.K @ T, 2))
    expressions, unknowns = request.in_unknowns(
        frame, request.gamma and request.gamma**2)
    blocks = Blocks.of(expressions.values(), unknowns)
    phase = phase_one(blocks)
    found = Solution(request, phase.verdict, frame=frame,
                     multipliers=phase.Z)
    if phase.x is not None:
        found = finish(request, frame, blocks, unknowns, phase.x)
    return Design(**vars(found))


def replaced(request, known):
    return replace(
        request, region=region_of(known) or None, gamma=known.get("gamma"),
        saturation=request.saturation and replace(
            request.saturation, u_max=known["u_max"]))
