"""Systems joined to every plant of a family: a family of the same parameters."""

import numpy as np

from ..exact.rational import exact
from .bernstein import NO_RANGES
from .descriptor import MATRICES, Descriptor, first_order
from .descriptor import OF_ARGUMENTS as NAMES
from .descriptor_system import DescriptorSystem, of_change, of_next
from .polynomials import Polynomials
from .second_order import SecondOrderSystem
from .uncertain import Uncertain

WORDS = {name: word for word, name in NAMES.items()}


def joined_family(plants, function, U=None, **rest):
    """The family of an affine ``function`` of a `Descriptor` in rationals, monomial by
    monomial of the ``plants``, an `Uncertain`, with ``U``; ``rest``: what else its
    `DescriptorSystem` takes.
    """
    dt = rest.get("dt")  # the parts are those of x(k+1)
    constant = (0,) * len(plants.box.names)
    monomials = {constant} | {m for x in plants.parts.values() for m in x.monomials}

    def at(monomial):
        some = {name: x.coefficient(monomial) for name, x in plants.parts.items()}
        if plants.kind is SecondOrderSystem:
            n = len(some["M"])
            sums = exact(np.zeros((0, n)) if U is None else np.array(U, float))
            K_A = exact(np.zeros((some["B"].shape[1], n)))
            return function(first_order(exact, **some, U=sums, K_A=K_A))
        d = Descriptor(**{NAMES.get(k, k): x for k, x in some.items()})
        if dt is None:
            return function(d)
        return of_next(function(of_change(d, dt).map(exact)), dt)

    nothing = at(None)
    found = {m: at(m) for m in monomials}
    result = {}
    for name in MATRICES:
        zero = getattr(nothing, name)
        if zero is None:
            continue
        entries = [{} for _ in zero.flat]
        for m, d in found.items():
            x = getattr(d, name)
            for terms, c in zip(entries, (x if m == constant else x - zero).flat):
                if c:
                    terms[m] = c
        shape, count = zero.shape, len(constant)
        result[WORDS.get(name, name)] = Polynomials.of(shape, entries, count)
    made = Uncertain.made(DescriptorSystem, plants.box, result, **rest)
    return made.cut(**plants.pieces)


def of_one(d, reduction=None, dt=None):
    """A plant ``d`` in rationals, a `Descriptor`, as the family without a parameter,
    whose files have each number as it is; ``reduction``: of what it is a part, or None;
    with ``dt`` it is the change of a plant of discrete time.
    """
    parts, d = {}, d if dt is None else of_next(d, dt)
    for name in MATRICES:
        x = getattr(d, name)
        if x is not None:
            entries = [{(): c} if c else {} for c in x.flat]
            parts[WORDS.get(name, name)] = Polynomials.of(x.shape, entries, 0)
    family = Uncertain.made(
        DescriptorSystem, NO_RANGES, parts, reduction=reduction, dt=dt
    )
    return family.polytope()
