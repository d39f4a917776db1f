"""The choice of U, which the thesis leaves open."""

from functools import partial

import numpy as np

from ...plants.second_order import Polytope, SecondOrderSystem
from ...synthesis.integrators import admissible_U
from .. import thesis
from .table import Row, claim

__all__ = ["rows"]

row = partial(Row, "10_choosing_the_integrators")


def rows():
    """What is said about U, and the answer for each plant."""
    for number, make in enumerate(
        (thesis.example_1, thesis.example_2, thesis.example_3, thesis.example_4), 1
    ):
        yield _example(number, make())
    wheel, body = admissible_U(_pendulum())
    (both,) = admissible_U(_pendulum(), [np.eye(2)])
    holds = (
        wheel.admissible
        and wheel.channels == (1,)
        and not body.admissible
        and not both.admissible
    )
    yield row(
        "U = [0 1] is the only choice that works, for U = I the "
        "system isn't controllable",
        "Section 4.3.1",
        "found by trying",
        _words((wheel, body, both)),
        claim(holds),
        "at rest the robot stands upright, so the body's angle has no set "
        "point; proven for the whole polytope; [1 1] works as well",
    )


def _example(number, example):
    choices = admissible_U(example.plant)
    (theirs,) = (c for c in choices if np.array_equal(c.U, example.U))
    same = [c for c in choices if c.a == theirs.a]
    better = sum(c.distance > theirs.distance + 1e-9 for c in same)
    place = f"number {better + 1} of {len(same)} with a = {theirs.a}"
    if len(same) == 1:
        place = f"the only one with a = {theirs.a}"
    proven = theirs.certified is None or theirs.certified
    good = sum(c.admissible for c in choices)
    more = {
        None: "",
        True: "; this one is proven for the whole polytope",
        False: "; this one isn't proven for the whole polytope",
    }[theirs.certified]
    return row(
        f"Example {number}: U, chosen at random, is controllable",
        "Section 5",
        "conditions for U: future work",
        f"{good} of {len(choices)} choices are admissible{more}",
        claim(theirs.admissible and proven),
        f"distance {theirs.distance:.3g}, {place}",
    )


def _words(choices):
    return "; ".join(
        f"{np.array2string(c.U.astype(int)).replace(chr(10), '')}: "
        f"{'admissible' if c.admissible else 'inadmissible'}"
        for c in choices
    )


def _pendulum():
    """The mobile inverted pendulum, from the printed a, ..., f of (4.15)."""
    letters = thesis.mip().letters
    b, c, d, f = (letters[x] for x in "bcdf")
    return Polytope(
        [
            SecondOrderSystem(
                [[c, b], [b, a]], [[f, -f], [-f, f]], [[-d, 0], [0, 0]], [[-e], [e]]
            )
            for a in letters["a"][1:]
            for e in letters["e"]
        ]
    )
