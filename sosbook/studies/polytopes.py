"""Vertices, pairs or a slack matrix: what each proves, and what is true between."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..plants.checks import count as whole
from ..plants.checks import finite, is_word
from ..plants.coupling import COUPLINGS, Coupling, coupling_of
from ..plants.descriptor_system import DescriptorSystem
from ..plants.hull import quotient_in_hull
from ..plants.kinds import checked_plant
from ..plants.second_order import Polytope, SecondOrderSystem
from ..plants.uncertain import Uncertain
from ..requirements.stability import Stability
from ..runtime.progress import each
from ..synthesis.design import Design
from ..synthesis.pid import design_pid
from ..synthesis.request import Request

__all__ = [
    "compare",
    "hull_gap",
    "sample_plants",
    "scale_polytope",
    "verify_many",
    "verify_on_samples",
    "vertices_suffice",
]


def scale_polytope(plants, factor):
    """The polytope, enlarged or shrunk about its mean.

    Parameters
    ----------
    plants : Polytope
        The polytope.
    factor : float
        0 gives the mean at every vertex, 1 the polytope itself.

    Examples
    --------
    >>> pair = Polytope([SecondOrderSystem([[m]], [[1]], [[1]], [[1]])
    ...                  for m in (1, 3)])
    >>> [v.M.item() for v in scale_polytope(pair, 0.5).vertices]
    [1.5, 2.5]
    """
    finite("factor", factor)
    mean = _polytope(plants).mean
    several = [
        [(getattr(mean, x), getattr(v, x)) for x in "MDSBF"] for v in plants.vertices
    ]
    return Polytope(
        [SecondOrderSystem(*(a + factor * (b - a) for a, b in x)) for x in several]
    )


def sample_plants(plants, count=20, seed=0):
    """Plants to look at: ``count`` along each segment between two of the ``plants``'
    vertices, and with more than two as many at random (``seed``).
    """
    samples, count, plants = [], whole("count", count, 2), _several(plants)
    corners = np.eye(len(plants.vertices))
    for i, j in combinations(range(len(corners)), 2):
        for a in np.linspace(0, 1, count):
            samples.append(plants.at((1 - a) * corners[i] + a * corners[j]))
    if len(corners) > 2:
        samples += plants.sample(count, seed)
    return samples or [plants.at([1])]


def verify_on_samples(design, count=20, seed=0):
    """How well a design keeps what was asked, at the worst of many plants.

    Parameters
    ----------
    design : Design
        A design for a Polytope or a DescriptorSystem, with a gain.
    count, seed : int
        As in `sample_plants`.

    Returns
    -------
    dict
        All positive where every promise is kept: "poles" (distance from
        the imaginary axis and into the region, rad/s), for each other
        requirement the bound less the true value, by its parameter.

    Examples
    --------
    >>> from sosbook.book.counterexamples import random_chain
    >>> design = design_pid(random_chain(0), gamma=1.0)
    >>> kept = verify_on_samples(design)
    >>> sorted(kept), min(kept.values()) > 0
    (['gamma', 'poles'], True)
    """
    if not isinstance(design, Design):
        raise ValueError(f"design must be a Design, got {type(design).__name__}")
    request = design.request
    if design.K is None:
        raise ValueError(f"the design is {design.status}: nothing to keep")
    plants = sample_plants(request.plant, count, seed)
    loops = [d for one in plants for d in replace(request, plant=one).vertices]
    kept = {}
    for r in (Stability(), *request.requirements):
        value = float(r.kept(r.truth(loops, design.K, request.K_A)))
        kept[r.promise] = min(value, kept.get(r.promise, np.inf))
    return kept


def compare(plant, couplings=COUPLINGS, **asked):
    """The same request with each coupling.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        The polytope.
    couplings : sequence of {"vertices", "pairs", "slack"}
        The conditions on pairs of vertices to compare, as in `design_pid`.
    **asked
        Keywords of `design_pid`.

    Returns
    -------
    dict
        The `Design` for each coupling's name.

    Examples
    --------
    >>> from sosbook.book.counterexamples import actuated
    >>> from sosbook import PoleRegion
    >>> compared = compare(actuated(), region=PoleRegion(rho=10))
    >>> [compared[name].status for name in ("vertices", "pairs", "slack")]
    ['feasible', 'infeasible', 'feasible']
    """
    kinds = _listed(couplings)
    return {kind.word: design_pid(plant, coupling=kind, **asked) for kind in kinds}


def verify_many(polytopes, couplings=COUPLINGS, **asked):
    """Designs for many polytopes, and what became of their promises.

    Parameters
    ----------
    polytopes : sequence of Polytope or DescriptorSystem
        The polytopes to compare the conditions on.
    couplings : sequence of {"vertices", "pairs", "slack"}
        As in `compare`.
    **asked
        Keywords, as in `compare`.

    Returns
    -------
    dict
        An array for each coupling's name: for each polytope the
        smallest of `verify_on_samples`, or NaN where there is no design.

    Examples
    --------
    >>> from sosbook.book.counterexamples import actuated
    >>> from sosbook import PoleRegion
    >>> compared = verify_many([actuated()], ("vertices", "pairs"),
    ...                region=PoleRegion(rho=10))
    >>> compared["vertices"] < 0, compared["pairs"]
    (array([ True]), array([nan]))
    """
    couplings = _listed(couplings)
    worst = {kind.word: [] for kind in couplings}
    for plants in each([_several(plants) for plants in polytopes], "polytope"):
        for name, design in compare(plants, couplings, **asked).items():
            found = design.K is not None
            kept = min(verify_on_samples(design).values()) if found else np.nan
            worst[name].append(kept)
    return {name: np.array(kept) for name, kept in worst.items()}


def vertices_suffice(plants, U=None, K_A=None):
    """True if LMIs at the vertices are known to hold for all plants between.

    Then coupling "pairs" asks for no pair. It is so for one plant, for a certain
    M - B K_A, and for boxes in which each uncertain quantity of it changes one
    row of the equations, or one column times a row. Vertices that are such a box but
    for rounding are read as it.

    Parameters
    ----------
    plants : Polytope or DescriptorSystem
        The polytope.
    U, K_A : arrays, optional
        As in `design_pid`.

    Returns
    -------
    bool
        True is proven, in exact arithmetic. False means that no reason was found.

    Examples
    --------
    >>> from sosbook.book.counterexamples import actuated, random_chain
    >>> vertices_suffice(random_chain(0)), vertices_suffice(actuated())
    (True, False)
    """
    request = Request(_several(plants), U, K_A=K_A)
    return quotient_in_hull(request.ground.certain, request.at_corners)


def hull_gap(plants, U=None, K_A=None, count=20, seed=0):
    """How far E^-1 [A B_u B_w] leaves the hull of its vertices.

    Zero (to rounding) means that checking the vertices is enough for
    the plants looked at; `vertices_suffice` proves it for all.

    Parameters
    ----------
    plants : Polytope or DescriptorSystem
        The polytope.
    U, K_A : arrays, optional
        As in `design_pid`.
    count, seed : int
        As in `sample_plants`.

    Returns
    -------
    float
        The largest distance from the hull, relative to the matrix.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> hull_gap(thesis.example_2().plant, U=np.eye(2)) < 1e-9
    True
    """
    from scipy.optimize import nnls

    corners = _standard_forms([_several(plants)], U, K_A)
    largest = np.abs(corners).max(axis=1, keepdims=True)
    largest[largest == 0] = 1
    corners = np.vstack([corners / largest, np.ones(corners.shape[1])])
    targets = _standard_forms(sample_plants(plants, count, seed), U, K_A)
    targets = np.vstack([targets / largest, np.ones(targets.shape[1])])
    return float(max(nnls(corners, t)[1] / np.linalg.norm(t) for t in targets.T))


def _several(plants):
    """A polytope of plants of either order."""
    if isinstance(plants, Uncertain):
        plants = checked_plant(plants)
    return plants if isinstance(plants, DescriptorSystem) else _polytope(plants)


def _polytope(plants):
    if not isinstance(plants, Polytope):
        raise ValueError(
            f"plants must be a Polytope, got {type(plants).__name__}: "
            "Polytope([...]) makes one of plants"
        )
    return plants


def _listed(couplings):
    """A list of couplings that design, from words or objects."""
    if isinstance(couplings, str) or not isinstance(couplings, Iterable):
        raise ValueError(f"couplings must be a list of names, got {couplings!r:.80}")
    found = list(couplings)
    for one in found:
        if not (is_word(one, COUPLINGS) or isinstance(one, (Coupling, tuple))):
            raise ValueError(f"coupling must be one of {COUPLINGS}, got {one!r:.80}")
    return list(map(coupling_of, found))


def _standard_forms(plants, U, K_A):
    """A matrix with the entries of E^-1 [A B_u B_w], one column a vertex of each."""
    loops = [d for one in plants for d in Request(one, U, K_A=K_A).vertices]
    return np.array([np.hstack(d.state_space()).ravel() for d in loops]).T
