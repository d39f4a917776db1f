"""A quarter of a car over a bump, under gains that are designed and proven here."""

from ..page import matrices
from .mover import Mover, choice, slider


def ride(cars, designs, hint, **answer):
    """A car on a bump; a slider goes through designs, bound by bound.

    The page simulates; what it calls proven comes from the designs' `bounds`.

    ``cars``: plants with the heights of body and wheel, one input and the road as w.
    Their one parameter is the body's mass in tonnes, in which they are straight;
    ``designs``: for each name, what was made small, a dict: the `Design` for each bound
    of the stroke. The bounds are the same for all names, evenly spaced; ``hint``: what
    to try; ``answer``: as for `task`.

    >>> import sosbook as sos
    >>> def car(m):
    ...     return sos.SecondOrderSystem(
    ...         [[m, 0], [0, 1]], [[1, -1], [-1, 1]], [[1, -1], [-1, 9]], [[1], [-1]],
    ...         [[0], [9]])
    >>> cars = sos.Uncertain(car, m=(2, 3))
    >>> asked = sos.HInfinity(9, outputs=sos.Output(position=[[1, -1]]), name="stroke")
    >>> found = sos.design_pid(cars, requirements=[asked])
    >>> ride(cars, {"stroke alone": {9: found}}, "Move the mass.")
    Ride: made, stroke, m, bump
    """
    ((name, low, high),) = zip(cars.box.names, cars.box.low, cars.box.high)
    low, high = float(low), float(high)
    corners = [cars.at(**{name: x}) for x in (low, high)]
    strokes = list(next(iter(designs.values())))
    ends = (strokes[0], strokes[-1])
    return Mover(
        "ride",
        "A car over a bump",
        hint,
        [
            choice("made", "The force makes small", ["(no force)", *designs], 1),
            slider("stroke", "Stroke at most", " × the road", ends, *_step(strokes)),
            slider("m", "Mass of the body", " t", (low, high), 0.01, low),
            slider("bump", "Bump lasts", " s", (0.05, 0.5), 0.01, 0.1),
        ],
        answer=answer or None,
        plants=[matrices(c, "MDSBF") for c in corners],
        masses=[low, high],
        strokes=strokes,
        designs=[[_found(d) for d in found.values()] for found in designs.values()],
    )


def _step(strokes):
    """The slider's step, and where it starts: in the middle."""
    step = strokes[1] - strokes[0] if len(strokes) > 1 else 1
    return step, strokes[len(strokes) // 2]


def _found(design):
    """The proven gain of a design, and its bounds; its status where there is none."""
    proof = design.certify()
    if design.status != "feasible" or not proof.proven:
        return {"status": design.status, "K": None}
    bounds = [{"name": b.requirement.name, "proven": b.proven} for b in design.bounds()]
    return {"status": "feasible", "K": proof.K[0].tolist(), "bounds": bounds}
