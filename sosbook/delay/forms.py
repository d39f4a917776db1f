"""The LMIs of each method: their unknowns and their blocks.

A form writes the theorem's block matrices for a `DelayRequest`. What it
gets are loops in the request's coordinates, with tau as the unit of time.
"""

from ..language import Unknown
from . import interval, legendre, theorems


def _symmetric(name, size):
    return Unknown(name, size, symmetric=True)


class Krasovskii:
    """Theorems A.3 and 2.3, corrected: analysis and design.

    ``shifted``: whether a rate is shifted into the loop.
    """

    first_order = False  # the loop is E x' = A x + ..., with any E

    def __init__(self, shifted):
        self.shifted = shifted

    def unknowns(self, request):
        """The unknowns of the functional, and F, X of the gain."""
        N, m = request.states, request.plant.m
        unknowns = [
            _symmetric("P", N),
            Unknown("Q", N),
            _symmetric("S", N),
            _symmetric("R1", N),
            Unknown("R2", N),
            _symmetric("R3", N),
            *([_symmetric("Z", N)] if request.mu else []),
            Unknown("F", N),
        ]
        if request.gain is None:
            return [*unknowns, Unknown("X", m, N)]
        return [*unknowns, Unknown("G", N)]

    def blocks(self, request, values, number, loops):
        """The blocks of the functional and of each loop, by name."""
        t, v = request.times(number), {"Z": 0 * values["S"]} | values
        functional = theorems.Functional(
            *(v[name] for name in ("P", "Q", "S", "R1", "R2", "R3", "Z"))
        )
        whole, rates = theorems.delay_functional(functional, t)
        blocks = {"functional": whole, "R": rates}
        if request.mu and "sign" not in request.misprints:
            blocks["Z"] = v["Z"]
        alpha, misprints = request.relative_alpha(number), request.misprints
        for tag, d in loops:
            if request.gain is None:
                form = theorems.delay_stabilization(
                    d, functional, v["F"], v["X"], t, alpha, misprints
                )
            else:
                Ad = d.Bu @ request.scaled_gain(number)
                form = theorems.delay_decay(
                    d.E, d.A, Ad, functional, v["F"], v["G"], t, misprints, alpha
                )
            blocks["decay" + tag] = form
        return blocks


class Legendre:
    """Bessel's inequality over the nominal delay: analysis of one loop."""

    first_order = shifted = True
    order, orders_in_words = 2, "0, 1, 2, ..."
    orders = range(1000)

    def unknowns(self, request):
        N = request.states
        unknowns = [_symmetric("P", (1 + request.order) * N)]
        unknowns += [_symmetric(name, N) for name in ("S", "R")]
        return unknowns + ([_symmetric("Z", N)] if request.mu else [])

    def blocks(self, request, values, number, loops):
        t, order, v = request.times(number), request.order, dict(values)
        blocks = {"functional": legendre.legendre_functional(v["P"], v["S"], order, t)}
        blocks |= {name: v[name] for name in ("S", "R", "Z") if name in v}
        v.setdefault("Z", 0 * v["S"])
        for tag, d in loops:
            Ad = d.Bu @ request.scaled_gain(number)
            blocks["decay" + tag] = legendre.legendre_decay(
                d.A, Ad, v["P"], v["S"], v["R"], v["Z"], order, t
            )
        return blocks


class Interval:
    """The ends of the delay's interval kept apart: analysis of one loop."""

    first_order = shifted = True
    order, orders_in_words = 1, "0 or 1"
    orders = range(2)

    def unknowns(self, request):
        N, order = request.states, request.order
        before, within = request.mu < request.tau, request.mu > 0
        size = N * (1 + before + within) if order else N
        names = ["Q1", "R1"] * before + ["Q2", "R2"] * within
        unknowns = [_symmetric("P", size), *(_symmetric(name, N) for name in names)]
        return unknowns + ([Unknown("T", (1 + order) * N)] if within else [])

    def blocks(self, request, values, number, loops):
        """The blocks of the functional and of each loop and end, by name."""
        t, order = request.times(number), request.order
        P, Q1, Q2, R1, R2, T = (
            values.get(name) for name in ("P", "Q1", "Q2", "R1", "R2", "T")
        )
        blocks = {"functional": interval.interval_functional(P, Q1, Q2, order, t)}
        blocks |= {k: v for k, v in values.items() if k in ("Q1", "Q2", "R1", "R2")}
        if T is not None:
            blocks["kernel"] = interval.interval_kernel(R2, T, order)
        ends = ((" early", 0), (" late", 1)) if order and T is not None else (("", 0),)
        for tag, d in loops:
            Ad = d.Bu @ request.scaled_gain(number)
            for end, late in ends:
                blocks["decay" + tag + end] = interval.interval_decay(
                    d.A, Ad, P, Q1, Q2, R1, R2, T, order, t, late
                )
        return blocks


FORMS = {
    "functional": Krasovskii(shifted=False),
    "shift": Krasovskii(shifted=True),
    "legendre": Legendre(),
    "interval": Interval(),
}
