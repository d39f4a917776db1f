"""The choice of U, which the thesis leaves open."""

import numpy as np

from ...plants.second_order import Polytope, SecondOrderSystem
from ...synthesis.integrators import admissible_U
from .. import thesis
from .table import evaluate


def rows():
    """The statements about U, and the answer for each plant."""
    for number in (1, 2, 3, 4):
        yield _example(number, getattr(thesis, f"example_{number}")())
    wheel, body = admissible_U(_pendulum())
    (both,) = admissible_U(_pendulum(), [np.eye(2)])
    holds = wheel.admissible and wheel.channels == (1,)
    holds = holds and not (body.admissible or both.admissible)
    yield evaluate("U-pendulum", holds, ours=_words((wheel, body, both)))


def _example(number, example):
    choices = admissible_U(example.plant)
    (theirs,) = (c for c in choices if np.array_equal(c.U, example.U))
    same = [c for c in choices if c.a == theirs.a]
    better = sum(c.distance > theirs.distance + 1e-9 for c in same)
    place = f"number {better + 1} of {len(same)} with a = {theirs.a}"
    if len(same) == 1:
        place = f"the only one with a = {theirs.a}"
    proven = {None: "", True: "is", False: "isn't"}[theirs.certified]
    more = proven and f"; this one {proven} proven for the whole polytope"
    holds = theirs.admissible and theirs.certified is not False
    words = dict(number=number, good=sum(c.admissible for c in choices), more=more)
    words |= dict(all=len(choices), distance=theirs.distance, rank=place)
    return evaluate("U-example", holds, **words)


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
