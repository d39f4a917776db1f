"""Procedure 2.1: from a plant and requirements to a PID controller."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..laws.taken import taken
from ..plants.coupling import Coupling
from ..plants.kinds import Plant, Prepared, checked_plant
from ..requirements.base import Requirement
from ..requirements.hinf import HInfinity
from ..requirements.input_bound import Saturation
from ..requirements.pole_region import Region
from ..runtime.array_like import ArrayLike
from ..runtime.threads import one_thread
from .design import Design
from .procedure import design_asked
from .search import USUAL, Search

if TYPE_CHECKING:
    from ..laws.base import Law

Word = Literal["auto", "pairs", "vertices", "slack"]  # of couplings
KnownWord = Word | Literal["multipliers"]


@one_thread
def design_pid(
    plant: Plant | Prepared,
    U: ArrayLike | None = None,
    *,
    region: Region | None = None,
    gamma: float | HInfinity | None = None,
    saturation: Saturation | None = None,
    K_A: ArrayLike | None = None,
    coupling: Word | tuple[str, float] | Coupling = "auto",
    minimize: str | Mapping[str, float] | None = None,
    requirements: Iterable[Requirement] = (),
    law: "Law | None" = None,
    maximize: Literal["sigma"] | None = None,
    search: Search = USUAL,
) -> Design:
    r"""Design a robust PID controller (PD without ``U``).

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain, DescriptorSystem or Regularization
        What `regularize` returns brings its K_A with it.
    U : (a, n) array_like, optional
        Which displacement errors are integrated.
    region : PoleRegion or LMIRegion, optional
        Where the closed-loop poles must lie.
    gamma : float or HInfinity, optional
        Bound of the H-infinity norm from w to z; an `HInfinity` with a number ``mu``
        holds the scalar of Theorem 2.1, which is free without it.
    saturation : Saturation, optional
        Bound of K x(t) from a given initial state.
    K_A : (m, n) array_like, optional
        Acceleration gain, where the mass is singular.
    coupling : {"auto", "pairs", "vertices", "slack"}, pair or Coupling
        ``"auto"`` takes ``"pairs"``, and ``"slack"`` where these have no solution
        and those have, or an acceleration of an uncertain mass is weighed: ``reason``
        says so, ``request.coupling`` which it was. A least
        bound is that of the pairs if there is one; of a family with powers of
        parameters, whose ranges are cut while its least bound falls, the lower one.
        ``"pairs"`` is sound, with one Lyapunov matrix for all plants. No
        pair is asked where the vertices suffice: see
        `sosbook.studies.polytopes.vertices_suffice`.
        ``"slack"`` is sound too, with one for each vertex, for plants
        that don't change with time; ``"pairs"`` also covers those that
        move through the polytope, as fast as they like. Its LMIs hold a scalar in s,
        which is sought: the first that succeeds, or with ``minimize="gamma"`` the
        best. ``("slack", 0.1)`` holds it.
        ``"vertices"`` is the thesis's reading, which proves nothing between
        vertices of different ``E`` unless they suffice.
    minimize : {None, "gamma", "u_max", "cost"} or dict, optional
        Find the smallest bound and design for it, backed off by the
        fraction ``search.backoff`` and rounded up to three digits. A dict of
        weights, ``{"gamma": 1.0, "u_max": 1e-3}``, minimises the
        weighted sum of the squares ("cost" as it is). The bounds
        themselves are left out: no ``gamma``, ``Saturation(None, x0)``,
        ``[QuadraticCost(Q, R)]``. Where the search gives up, the design keeps the
        smallest bound that was found, or a larger one if that takes enormous gains,
        and its ``reason`` says what is known of smaller ones.
        A plant that meets all the rest by itself gets K = 0: the least u_max is
        zero then, and the request names a small positive number.
    requirements : sequence of Requirement, optional
        More of what is asked, as the `QuadraticCost` under white noise (Theorem 2.4).
        region, gamma and saturation are shorthand for such objects, and no kind is
        asked in both ways. For the least cost alone see `design_lqr`.
    law : Law, optional
        What the controller measures and remembers: `PIDLaw`, `DynamicLaw`; without it
        all of z and z' is measured, as with `FullState`. A gain of a law is searched,
        for its inequalities aren't convex, and then proven by multipliers, as by
        `analyse_pid`. "infeasible" is still a proof; what the search doesn't find is
        "undecided", with what was reached. ``minimize`` takes one bound then, and its
        value is the best that was found.
    maximize : {None, "sigma"}
        With a ``law``: the fastest decay that the search finds, backed off.
    search : Search
        Where the search begins, how far it goes, which of the gains it takes, and its
        ``time_limit``.

    Returns
    -------
    Design
        The analytic centre of everything that was asked for. Where that
        set is unbounded, a block "scale" bounds it. Where a line search
        finds nothing, the status is "undecided".

    Raises
    ------
    ValueError
        On bad input; an impossible request is no error, it comes back
        with status "infeasible".

    Notes
    -----
    Source: thesis, Procedure 2.1 (Theorems 2.1, 2.2 and Lemma 2.2).
    Stability is always demanded.

    A region says nothing of the gain, and the centre may have a large one.
    Small gains come from a bound of the input from a state: the least that will
    do, or a few times it, which leaves the centre more room (see the example).

    Examples
    --------
    >>> from sosbook import PoleRegion, Saturation, SecondOrderSystem
    >>> robot = SecondOrderSystem(
    ...     M=np.diag([10, 11]), D=[[4, 1], [1, 5]], S=[[8, 4], [-4, 9]],
    ...     B=np.eye(2), F=np.eye(2))
    >>> d = design_pid(robot, U=np.eye(2), gamma=1.257)
    >>> d.status, d.certify().proven
    ('feasible', True)

    The same poles with any gain, and with little force from a state:

    >>> asked = dict(plant=robot, region=PoleRegion(sigma=0.5, rho=40))
    >>> x0 = [0.1, 0.1, 0, 0]
    >>> large = design_pid(**asked)
    >>> least = design_pid(**asked, minimize="u_max",
    ...                    saturation=Saturation(None, x0)).request.saturation
    >>> small = design_pid(**asked, saturation=Saturation(3 * least.u_max, x0))
    >>> bool(np.linalg.norm(large.K) > 50 * np.linalg.norm(small.K))
    True

    An encoder on the motor and nothing else:

    >>> from sosbook import PIDLaw, Polytope
    >>> arm = Polytope([
    ...     SecondOrderSystem(M=np.diag([1, J]), D=[[0.15, -0.05], [-0.05, 0.05]],
    ...                       S=[[9, -9], [-9, 9]], B=[[1], [0]]) for J in (1, 2)])
    >>> law = PIDLaw(position=[[1, 0]], integrate=True, filter=0.02)
    >>> d = design_pid(arm, law=law, region=PoleRegion(sigma=0.4))
    >>> d.status, list(d.gains), d.certify().proven
    ('feasible', ['K_P', 'K_D', 'K_I'], True)
    """
    return design_asked(
        plant, U, K_A=K_A, law=law, coupling=coupling, minimize=minimize,
        maximize=maximize, search=search, region=region, gamma=gamma,
        saturation=saturation, requirements=requirements,
    )  # fmt: skip


@one_thread
def analyse_pid(
    plant: Plant | Prepared,
    K: Any = None,
    U: ArrayLike | None = None,
    *,
    region: Region | None = None,
    gamma: float | HInfinity | None = None,
    saturation: Saturation | None = None,
    K_A: ArrayLike | None = None,
    coupling: KnownWord | tuple[str, float] | Coupling = "auto",
    minimize: str | Mapping[str, float] | None = None,
    requirements: Iterable[Requirement] = (),
    law: "Law | None" = None,
    search: Search = USUAL,
) -> Design:
    """Find a certificate for a given gain.

    Parameters
    ----------
    plant
        As in `design_pid`.
    K : (m, N) array_like, dict, design or StateSpace
        ``[K_P K_D K_I]``. With a ``law`` what `Design.K` or `Design.gains` hold. A
        `Gain`, a design or its ``gains`` are taken by the names of their signals. A
        design of a law and an `ObserverDesign` bring their law along; so does
        python-control's StateSpace, by the names of its inputs and outputs. It is left
        out where the plant has no input: for loops with a filter or an actuator, as
        ``DescriptorSystem(E, A, None, B_w, C)``, whose cost has R = [].
    U, region, gamma, saturation, K_A
        As in `design_pid`.
    coupling : {"auto", "multipliers", "pairs", "slack", "vertices"}, pair or Coupling
        ``"multipliers"``: each requirement has Lyapunov matrices of its own, one
        for each vertex, and free multipliers; where that isn't enough the polytope
        is halved. A plant that breaks what is asked is looked for first. It is for
        plants that don't change with time, as is ``"slack"``: claims say "every
        constant plant". ``"auto"`` takes it for several vertices where ``"pairs"``,
        which covers plants that change, too, finds nothing, or something is
        minimised; but ``"pairs"`` where a requirement has no such LMIs, or is tied by
        a number ``mu``. ``request.coupling`` says which it was. The others are as in
        `design_pid`.
    minimize, requirements
        As in `design_pid`.
    law : Law, optional
        What the controller measures and remembers; without it all of z and z'. Its
        loop is proven by multipliers.
    search : Search
        Its ``backoff`` and ``time_limit``; nothing else is searched.

    Returns
    -------
    Design
        With this very K. With multipliers "infeasible" means that a plant
        provably breaks what is asked: ``reason`` names it, ``infeasibility`` is
        the proof. Otherwise it means that there is provably no common Lyapunov
        matrix P for what is asked; of one plant whose poles alone are asked that is
        the same as a pole out of place.

    Notes
    -----
    A claim that holds with some room for every plant is proven by multipliers after
    finitely many halvings, and one that fails clearly is broken by a plant that
    the search finds or the halvings reach; so it is with poles and norms, and, without
    a law, with costs and input bounds. What lies at the edge, or takes too long,
    is "undecided".

    Examples
    --------
    >>> from sosbook import PoleRegion, Polytope, SecondOrderSystem
    >>> carts = Polytope([SecondOrderSystem(m, 0.1, 1, 1) for m in (0.5, 2)])
    >>> kept = analyse_pid(carts, [[-3, -2]], region=PoleRegion(sigma=0.52))
    >>> kept.request.coupling
    Multipliers()
    >>> print(kept.certify())
    proven:
    - every constant plant of the polytope, under u = K x, is stable
    - its poles lie in the half-plane Re s < -0.52
    >>> broken = analyse_pid(carts, [[-3, -2]], region=PoleRegion(sigma=0.53))
    >>> broken.status, broken.infeasibility.proven
    ('infeasible', True)

    A loop as it is:

    >>> from sosbook import DescriptorSystem
    >>> loop = DescriptorSystem(np.eye(2), [[[0, 1], [-2, -3]], [[0, 1], [-3, -2]]])
    >>> analyse_pid(loop).certify().claims
    ('every constant or changing plant of the polytope is stable',)
    """
    if K is None:
        if isinstance(plant, Prepared) or checked_plant(plant).m:
            raise ValueError("K is missing: give the gain to be analysed")
        K = np.zeros((0, checked_plant(plant).order))
    law, K = taken(plant, K, law, U)
    search.taking("backoff time_limit", "a given gain")
    return design_asked(
        plant, None, K_A=K_A, law=law, gain=K, coupling=coupling, minimize=minimize,
        search=search, region=region, gamma=gamma, saturation=saturation,
        requirements=requirements,
    )  # fmt: skip
