"""Procedure 2.1: from a plant and requirements to a PID controller."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..analysis import linear
from ..analysis.response import simulate
from ..plants.checks import positive
from ..plants.descriptor import descriptors
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import Polytope, SecondOrderSystem
from ..requirements.shorthand import collected, moved
from ..requirements.vocabulary import PARAMETERS
from .certificates import prove, prove_infeasible
from .feasibility import Solution, answer
from .gains import Gains
from .objectives import feasible, solve
from .problem import Request

__all__ = ["Design", "analyse_loop", "analyse_pid", "design_pid"]


@dataclass(frozen=True, eq=False, repr=False)
class Design(Gains, Solution):
    """A controller and everything that is known about its loop.

    Parameters
    ----------
    request : Request
        The plant and what was asked.
    status : {"feasible", "infeasible", "undecided"}
        Decided by the eigenvalues of the blocks, or by multipliers that
        exclude a design; never by a solver's word. "infeasible" is a
        theorem where ``infeasibility.proven``; elsewhere the multipliers
        exclude a large ball of (P, Y), in coordinates in which the least
        infeasible P is near the identity, or a mode is uncontrollable
        to ten digits.
    K : (m, N) array or None
        ``[K_P K_D K_I]``, in ``u = K [z; z'; x3]``. A gain that was
        given to `analyse_pid` stays, whatever the status.
    P : (N, N), Y : (m, N) arrays or None
        The solution of the LMIs; ``K = Y P^-1``. With a slack matrix P
        holds one for each vertex, and ``K = Y V'^-1``.
    V : (N, N) array or None
        The slack matrix, with ``coupling="slack"``.
    margins : dict
        From a block's name to its smallest eigenvalue, after scaling
        its diagonal to one; all positive for a feasible design.
    frame : Frame
        The coordinates in which the LMIs were solved.
    multipliers : list of arrays or None
        Of the blocks, in that frame, where there is no design.
    """

    @property
    def K_A(self):
        """Acceleration gain, (m, n), as given."""
        plant = self.request.plant
        if self.request.K_A is None:
            return np.zeros((plant.m, plant.n))
        return np.asarray(self.request.K_A, float)

    @property
    def gamma(self):
        """The H-infinity bound that the design keeps, or None."""
        return self.request.gamma

    @property
    def mu(self):
        """The scalar of Theorem 2.1 that was used."""
        return self.request.mu

    @property
    def slack(self):
        """The scalar of the slack LMIs that was used, in seconds."""
        return self.request.slack

    def _gain(self):
        if self.K is None:
            raise ValueError(
                f"the design is {self.status}: there is no gain; see its "
                "advice"
            )
        return self.K

    def certify(self, digits=6):
        """Prove the design in exact arithmetic.

        Parameters
        ----------
        digits : int
            K is rounded to so many significant digits first: the proof
            is about the gain as it is printed.

        Returns
        -------
        Certificate
        """
        if self.P is None:
            raise ValueError(
                f"the design is {self.status}: there is nothing to "
                "certify; see its advice and infeasibility"
            )
        return prove(self.request, self.K, self.P, digits, self.V, self.own)

    def to_cvxpy(self, margin=0.0):
        """The same LMIs as cvxpy constraints, for other solvers.

        Parameters
        ----------
        margin : float
            Demands G >= margin * I of each block G.

        Returns
        -------
        constraints : list
        P, Y : cvxpy.Variable, or Y an expression where K is given

        Examples
        --------
        >>> import cvxpy
        >>> plant = SecondOrderSystem([[1]], [[1]], [[1]], B=[[1]])
        >>> constraints, P, Y = design_pid(plant).to_cvxpy(margin=0.1)
        >>> problem = cvxpy.Problem(cvxpy.Minimize(0), constraints)
        >>> problem.solve(solver="CLARABEL")
        0.0
        """
        from ..lmi.cones import cvxpy_constraints

        return cvxpy_constraints(self.request, margin)

    @cached_property
    def infeasibility(self):
        """`InfeasibilityCertificate` where one was found, else None."""
        if self.multipliers is None:
            return None
        return prove_infeasible(
            self.request, self.frame, self.multipliers
        )

    @cached_property
    def advice(self):
        """Which requirement to relax first; empty if feasible.

        Found by solving again with each requirement left out.
        """
        if self.status == "feasible":
            return ""
        fixed = self.request.fixed_modes()
        if len(fixed):
            return (
                f"No gain moves the mode at {fixed[0]:.4g}: it is "
                "uncontrollable; change B, or ask for less there."
            )
        asked = self.request.requirements
        enough = [r for r in asked if feasible(self.request.without(r))]
        if not enough:
            if self.request.gain is not None:
                if not asked:
                    return "No common P proves that this gain is stable."
                return (
                    "No common P proves what is asked of this gain, even "
                    "with any single requirement left out."
                )
            if len(asked) < 2:
                return "No gain makes this loop provably stable."
            return (
                "Leaving out any single requirement isn't enough: relax "
                "several of " + _words(asked) + "."
            )
        enough.sort(key=self._weight, reverse=True)
        text = f"Relax the {_words(enough[:1])} first"
        if enough[1:]:
            text += "; leaving out one of these would do as well: "
            text += _words(enough[1:])
        return text + "."

    def _weight(self, requirement):
        """Share of the multipliers that a requirement's blocks carry."""
        if self.multipliers is None:
            return 0.0
        expressions, _ = self.request.in_unknowns(self.frame)
        return sum(
            np.trace(z) for name, z in zip(expressions, self.multipliers)
            if name.requirement == requirement.key
        )

    def _each(self, function):
        """Per vertex; unpacked for a single plant."""
        found = [function(d) for d in self.request.vertices]
        return found if len(found) > 1 or isinstance(
            self.request.plant, Polytope) else found[0]

    def _loops(self, samples, seed):
        """Descriptors of the vertices and of random plants between."""
        vertices, plant = self.request.vertices, self.request.plant
        if not samples:
            return vertices
        if not isinstance(plant, Polytope):
            raise ValueError("samples needs a Polytope; the plant is one")
        inside = Polytope(plant.sample(samples, seed))
        return vertices + descriptors(
            inside, self.request.U, self.request.K_A
        )

    def open_loop(self):
        """control.StateSpace from (u, w, r) to x; a list per vertex."""
        self._second_order("set point")
        return self._each(linear.open_loop)

    def closed_loop(self):
        """control.StateSpace from (w, r) to (z, u); a list per vertex."""
        K = self._gain()
        self._second_order("set point")
        return self._each(lambda d: linear.closed_loop(d, K))

    def poles(self, samples=0, seed=0):
        """Closed-loop poles, in rad/s.

        Parameters
        ----------
        samples : int
            For a Polytope: how many random plants join the vertices.
        seed : int
            Of the random plants.

        Returns
        -------
        (N,) array, or one row per vertex and sample
        """
        K = self._gain()
        found = [linear.poles(d, K) for d in self._loops(samples, seed)]
        single = isinstance(self.request.plant, SecondOrderSystem)
        return found[0] if single else np.array(found)

    def hinf(self, samples=0, seed=0):
        """The largest true H-infinity norm from w to z.

        Over the vertices and random plants; parameters as in `poles`.
        """
        K = self._gain()
        if self.request.plant.p == 0:
            raise ValueError("the plant has no F: there is no such norm")
        return max(
            linear.hinf_norm(d, K) for d in self._loops(samples, seed)
        )

    def noise_cost(self, cost=None, samples=0, seed=0):
        """The largest true quadratic cost under white noise.

        Parameters
        ----------
        cost : QuadraticCost, optional
            That of the request without it.
        samples, seed
            As in `poles`.
        """
        K, cost = self._gain(), cost or self.request.cost
        if cost is None:
            raise ValueError("cost is missing: the design was made without")
        return cost.truth(self._loops(samples, seed), K)

    def peak_input(self, samples=0, seed=0):
        """The largest signal that saturation bounds, from x0.

        That is |K x(t)|, or |K x + K_A z''| with ``acceleration``. Over
        the vertices and random plants; parameters as in `poles`.
        """
        K = self._gain()
        saturation = self.request.saturation
        if saturation is None:
            raise ValueError("the design has no saturation, so no x0")
        return saturation.truth(self._loops(samples, seed), K, self.K_A)

    def simulate(self, t, r=None, w=None, x0=None):
        """`Response` of the loop; a list of them per vertex.

        Parameters
        ----------
        t : (k,) array_like
            Increasing times in seconds, from 0.
        r : (n,) array_like, optional
            Constant set point.
        w : Sine, optional
            Disturbance.
        x0 : (N,) array_like, optional
            Initial state; zero without it.
        """
        K = self._gain()
        self._second_order("displacement z")
        return self._each(
            lambda d: simulate(d, K, t, r, w, x0, self.K_A)
        )


def _words(requirements):
    return ", ".join(r.words for r in requirements)


def design_pid(plant, U=None, region=None, gamma=None, saturation=None,
               K_A=None, coupling="pairs", mu=None, slack=None,
               minimize=None, backoff=0.01, start=None, cost=None,
               requirements=()):
    r"""Design a robust PID controller (PD without ``U``).

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
    U : (a, n) array_like, optional
        Which displacement errors are integrated.
    region : PoleRegion or LMIRegion, optional
        Where the closed-loop poles must lie.
    gamma : float, optional
        Bound of the H-infinity norm from w to z.
    saturation : Saturation, optional
        Bound of K x(t) from a given initial state.
    K_A : (m, n) array_like, optional
        Acceleration gain, where the mass is singular.
    coupling : {"pairs", "vertices", "slack"}
        ``"pairs"`` is sound, with one Lyapunov matrix for all plants.
        ``"slack"`` is sound too, with one for each vertex, for plants
        that don't change with time; ``"pairs"`` also covers those that
        move through the polytope, as fast as they like.
        ``"vertices"`` is the thesis's reading, which proves nothing
        between vertices of different ``E``.
    mu : float or "free", optional
        Any positive value keeps Theorem 2.1 true; 1, the printed one,
        is taken without it.
        ``"free"`` searches the one with the smallest provable gamma.
    slack : float, optional
        The scalar epsilon of the slack LMIs, in seconds. Without it a
        line search: the first value that succeeds, or with
        ``minimize="gamma"`` the best.
    minimize : {None, "gamma", "u_max", "cost"} or dict, optional
        Find the smallest bound and design for it, backed off by the
        fraction ``backoff`` and rounded up to three digits. A dict of
        weights, ``{"gamma": 1.0, "u_max": 1e-3}``, minimises the
        weighted sum of the squares ("cost" as it is). The bounds
        themselves are left out: no ``gamma``, ``Saturation(None, x0)``,
        ``QuadraticCost(Q, R)``.
    backoff : float
        See ``minimize``.
    start : Design, optional
        A neighbouring design, of the same plant or one like it, to
        start from: faster, the answer is the same. One that isn't
        feasible is no help and is passed over.
    cost : QuadraticCost, optional
        Bound of the quadratic cost under white noise (Theorem 2.4); for
        the least cost alone see `design_lqr`.
    requirements : sequence of Requirement, optional
        More of what is asked; region, gamma, saturation and cost are
        shorthand for such objects.

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

    Examples
    --------
    >>> robot = SecondOrderSystem(
    ...     M=np.diag([10, 11]), D=[[4, 1], [1, 5]], S=[[8, 4], [-4, 9]],
    ...     B=np.eye(2), F=np.eye(2))
    >>> d = design_pid(robot, U=np.eye(2), gamma=1.257)
    >>> d.status, d.certify().proven
    ('feasible', True)
    """
    return _design(
        mu, minimize, backoff, start, plant=plant, U=U, region=region,
        gamma=gamma, saturation=saturation, K_A=K_A, coupling=coupling,
        slack=slack, cost=cost, requirements=requirements,
    )


def analyse_pid(plant, K, U=None, region=None, gamma=None,
                saturation=None, K_A=None, coupling="pairs", mu=None,
                slack=None, minimize=None, backoff=0.01, cost=None,
                requirements=()):
    """Find a certificate for a given gain.

    Parameters
    ----------
    K : (m, N) array_like
        ``[K_P K_D K_I]``; the other parameters as in `design_pid`.

    Returns
    -------
    Design
        With this very K; "infeasible" means that no common Lyapunov
        matrix P proves what is asked, not that it fails.
    """
    if K is None:
        raise ValueError("K is missing: give the gain to be analysed")
    return _design(
        mu, minimize, backoff, None, plant=plant, U=U, region=region,
        gamma=gamma, saturation=saturation, K_A=K_A, coupling=coupling,
        slack=slack, gain=K, cost=cost, requirements=requirements,
    )


def analyse_loop(E, A, B_w=None, C=None, region=None, gamma=None,
                 coupling="pairs", requirements=()):
    """Find a certificate for a closed loop E x' = A x + B_w w, y = C x.

    For loops that `analyse_pid` doesn't describe: with an observer, a
    filter, actuator dynamics.

    Parameters
    ----------
    E, A, B_w, C
        As in `DescriptorSystem`: matrices, or lists of them for a polytope.
    region, gamma, coupling, requirements
        As in `design_pid`; gamma bounds the norm from w to y.

    Returns
    -------
    Design
        "infeasible" means that no common Lyapunov matrix proves what is
        asked. Stability is always demanded.

    Examples
    --------
    >>> loop = analyse_loop(np.eye(2), [[[0, 1], [-2, -3]],
    ...                                 [[0, 1], [-3, -2]]])
    >>> loop.certify().claims
    ('every plant of the polytope is stable',)
    """
    loop = DescriptorSystem(E, A, None, B_w, C)
    request = Request(
        loop, coupling=coupling, gain=np.zeros((0, loop.order)),
        **_given(region=region, gamma=gamma, requirements=requirements),
    )
    return Design(**vars(answer(request)))


def _design(mu, minimize, backoff, start, plant, U, K_A, coupling, slack,
            gain=None, **asked):
    free = isinstance(mu, str)
    if free and mu != "free":
        raise ValueError(f'mu must be a number or "free", got {mu!r}')
    asked = collected(**_given(mu=None if free else mu, **asked))
    objective = _objective(minimize, asked)
    if free:
        if "gamma" not in objective and not any(
                r.name == "gamma" for r in asked):
            raise ValueError('mu="free" needs gamma or minimize="gamma"')
        if coupling == "slack" and slack is None:
            raise ValueError(
                'mu="free" and a free slack are two searches at once: give '
                "slack a number")
    if objective:  # numbers stand in
        asked = moved(asked, dict.fromkeys(objective, 1.0))
    request = Request(plant, U, K_A=K_A, coupling=coupling, slack=slack,
                      gain=gain, requirements=asked,
                      **_given(mu=None if free else mu))
    if start is not None:
        _check_start(start, request)
    found = solve(
        request, objective, "gamma" if free else None,
        positive("backoff", backoff), start,
    )
    return Design(**vars(found))


def _given(**asked):
    """The keywords that ask something."""
    return {name: value for name, value in asked.items() if value is not None}


def _check_start(start, request):
    if not isinstance(start, Design):
        raise ValueError(
            f"start must be a Design, got {type(start).__name__}"
        )
    other = start.request
    if (other.order, other.plant.m, len(other.vertices)) != (
        request.order, request.plant.m, len(request.vertices)
    ) or (other.coupling == "slack") != (request.coupling == "slack"):
        raise ValueError(
            "start has other sizes, vertices or coupling than this "
            "request: leave it out"
        )


def _objective(minimize, asked):
    """Weights by name, of what isn't asked as a number."""
    if minimize is None:
        return {}
    own = {r.parameter.key: r.parameter for r in asked if r.parameter}
    known = {name: p for name, p in (PARAMETERS | own).items() if p.power}
    if isinstance(minimize, str) and minimize in known:
        minimize = {minimize: 1.0}
    if not isinstance(minimize, dict) or not minimize or not set(
        minimize
    ) <= known.keys():
        names = ", ".join(f'"{name}"' for name in known)
        raise ValueError(
            f"minimize must be None, {names} or a dict of their weights, "
            f"got {minimize!r}"
        )
    for name in minimize:
        _check_open(known[name], asked)
    return {
        name: positive(f"minimize[{name!r}]", weight)
        for name, weight in minimize.items()
    }


def _check_open(which, asked):
    """Raise if a bound that shall be minimised is given, or can't be."""
    owners = [r for r in asked if r.parameter is which]
    if which.open and (not owners):
        raise ValueError(f'minimize="{which.key}" needs {which.open}')
    if any(r.bound is not None for r in owners):
        raise ValueError(
            f'give {which.key} or minimize="{which.key}", not both'
            + (f": {which.open}" if which.open else "")
        )
