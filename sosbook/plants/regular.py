"""Whether a matrix of polynomials is regular in a whole box."""

import numpy as np

from .bernstein import spelled
from .checks import rank_deficient

MOST_CELLS = 64  # boxes that are looked at


def check_regular(name, part, box, degrees):
    """Raise where a matrix is singular for some values of its parameters only.

    Around a regular E_0 all E with He(E_0^-1 E) > 0 are regular, and these are convex:
    the box is halved until the vertices have it. This is for a clear word in good
    time; no LMI with a singular E has a solution. What isn't decided in so many boxes,
    or is singular everywhere, passes.

    ``name``: what errors call the matrix; ``part``: the matrix; ``box``: the ranges;
    ``degrees``: of each parameter in Bernstein's form.
    """
    boxes, signs, last = [box], set(), box.inner
    for _ in range(MOST_CELLS):
        if not boxes:
            return
        box = boxes.pop()
        for point in (box.inner, box.middle, *box.corners()):
            E = part.at(box, point).astype(float)
            sign = 0.0 if rank_deficient(E, 1e-14) else np.linalg.slogdet(E)[0]
            if sign == 0 and not signs:  # at no special point: everywhere
                return
            signs.add(sign)
            if len(signs) > 1:
                where = f"at or beside {_words(box, point)}"
                if sign:
                    where = f"between {_words(box, last)} and {_words(box, point)}"
                raise ValueError(f"{name} is singular {where}: narrow the ranges")
            last = point
        middle = part.at(box, box.middle).astype(float)
        near = np.linalg.solve(middle, part.vertices(box, degrees).astype(float))
        least = np.linalg.eigvalsh(near + near.swapaxes(-1, -2))[:, 0]
        if (least <= 1e-9).any():
            boxes += box.halves(box.widest())


def _words(box, point):
    """The values of the parameters at a point."""
    return ", ".join(f"{k} = {spelled(x)}" for k, x in zip(box.names, point))
