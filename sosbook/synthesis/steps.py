"""The steps by which a request gets its answer, and those that refuse it exactly."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..plants.as_data import vertex_place
from ..runtime.later import later
from .payments import NOT_PAID
from .request import Request
from .solution import Solution

UNMOVED = 1e-9  # of the terms of a sum, below which floats take it for zero
ROUNDING = 1e-14  # of the input matrix, what floats leave of a zero
EDGE = 1e-5  # relative, of a region; a mode so near to it is looked at exactly, too
ROUNDING_MARGIN = 1e-6  # a margin below minus that is no rounding error
MODES_FIRST_ABOVE_STATES = 20  # from here on, looking for fixed modes first is cheap
TOO_NEAR = (
    "The numerics found a point whose margin, {:.1g} of the block {!r}, is below what "
    "floats can tell from zero; exact arithmetic doesn't confirm it."
)
NOT_ASKED = "The numerics found no point; a proof that there is none isn't asked."


@dataclass
class Case:
    """A ``request`` on its way through the steps: whether to ``refuse`` it, and which
    gain to ``prefer``, as in `answer`; ``first``: what `search` found last; ``whole``:
    whether with all pairs; ``poor``: a Solution whose margins floats can't tell from
    zero; ``part``: that of the modes that must move, where it is none of the whole;
    ``tried``: the names of the steps so far.
    """

    request: Request
    refuse: bool = True
    first: Any = None
    prefer: str | None = None
    whole: bool = False
    poor: Solution | None = None
    part: Solution | None = None
    tried: list = field(default_factory=list)

    @property
    def inside(self):
        """True if a search found a point."""
        return self.first is not None and self.first.values is not None

    @property
    def excluded(self):
        """True if a search found none, and a proof that there is none is asked."""
        return self.refuse and not self.inside

    @property
    def large(self):
        """True if a mode that no gain moves is sooner known than phase one begins."""
        K, large = self.request.gain, self.request.order > MODES_FIRST_ABOVE_STATES
        if not large or K is None:
            return large
        # where its poles seem to lie right, their exact places take long
        return not self.request.kept_by(K, self.request.of_poles)

    def left(self, text="", status="undecided", proof=None):
        """The Solution of a ``status`` without a point, its reason a ``text``, with a
        ``proof`` and what a search left of multipliers.
        """
        more, first = {}, self.first
        if first is not None and first.values is None:
            whole = first.problem.pairs is None  # else some blocks have none
            Z = first.multipliers if whole else None
            more = dict(frame=first.problem.frame, multipliers=Z)
        K = self.request.gain
        found = Solution(self.request, status, K, reason=text, **more)
        return replace(found, infeasibility=proof)

    def undecided(self):
        """The Solution after the last step: what was seen, and what was tried."""
        from .reasons import why_refused

        tried = f"Tried: {', '.join(dict.fromkeys(self.tried))}."
        if self.poor is not None:
            least = min(self.poor.margins, key=self.poor.margins.get)
            margin = self.poor.margins[least]
            paid = self.request.ground.near is None
            text = TOO_NEAR.format(margin, str(least)) if paid else NOT_PAID
            if margin < -ROUNDING_MARGIN:  # no point at all
                return self.left(f"{text} {tried}")
            return replace(self.poor, reason=f"{text} {tried}")
        text = why_refused(self.first) if self.refuse else NOT_ASKED
        return self.left(f"{text} {tried}")


@dataclass(frozen=True)
class Step:
    """One thing to try for an answer. Its ``name`` and its ``cost`` in words, whether
    it ``applies`` to a `Case`, and what ``tries`` it: a Solution, or None to go on.
    """

    name: str
    cost: str
    applies: Callable[[Case], bool]
    tries: Callable[[Case], Solution | None]


def taken(steps, case):
    """The first Solution that the ``steps`` have for a ``case``; else what is left."""
    for step in steps:
        if step.applies(case):
            case.tried.append(step.name)
            solution = step.tries(case)
            if solution is not None:
                return solution
    return case.undecided()


def by_mode(case, places=None):
    """Refuse a ``case`` by a pole that no gain moves to where it is asked, at all or
    some ``places`` of `FixedModeRefusal.place`.
    """
    from .fixed_mode import refuse_by_mode
    from .growing import GrowingRefusal
    from .reasons import pole_seen

    request, proof = case.request, refuse_by_mode(case.request, places)
    if proof is None:
        return None
    i, j = (k + 1 for k in proof.place)
    of = vertex_place(request.plant, i - 1)
    where = f" of {of}" if i == j else f" halfway between the vertices {i} and {j}"
    where = "" if len(request.vertices) == 1 else where
    whose = "This gain leaves" if request.plant.m else "This loop has"
    if isinstance(proof, GrowingRefusal):
        text = f"{whose} a pole{where} that violates {proof.requirement}: a form that "
        text = f"{text}grows along the loop proves it. {pole_seen(request)}".strip()
        return case.left(text, "infeasible", proof)
    mode = request.claims.place(proof.mode)
    text = f"{whose} a pole{where} at {mode}"
    if request.gain is None:
        text = f"No gain moves the mode{where} at {mode}: "
        text += "it is uncontrollable"
    text = f"{text}, which violates {proof.requirement}."
    return case.left(text, "infeasible", proof)


def _by_claim(home, name, why):
    """A function that tries a proof by the function ``name`` of a module, ``home``: the
    reason is its claim, and ``why``.
    """

    def tries(case):
        proof = later(f"synthesis.{home}", name)(case.request)
        if proof is None:
            return None
        claim = proof.claims[0]
        text = f"{claim[0].upper()}{claim[1:]}: {why}."
        return case.left(text, "infeasible", proof)

    return tries


def _by_mass(case):
    from .fixed_mode import refuse_by_mass

    proof = refuse_by_mass(case.request)
    if proof is None:
        return None
    i, j = (k + 1 for k in proof.vertices)
    text = f"Between the vertices {i} and {j} a plant has a singular mass matrix."
    return case.left(text, "infeasible", proof)


def by_multipliers(case):
    """Refuse a ``case`` by the multipliers that its search left."""
    from .reasons import NO_COMMON_P

    request, proof = case.request, case.first.infeasibility
    if proof is None:
        return None
    text = "Exact multipliers of the LMIs exclude every solution"
    text = f"{request.sizes.subject(text)}."
    if len(request.distinct) > 1 and len(request.lyapunov) == 1:
        text = f"{text} {NO_COMMON_P}"
    return case.left(text, "infeasible", proof)


def _of_the_state(case):
    return case.excluded and case.request.law.whole  # else K isn't the state's


def _of_a_response(case):
    bounds = (r.bounds_response() for r in case.request.requirements)
    return _of_the_state(case) and any(bound is not None for bound in bounds)


def _between(case):
    return _of_the_state(case) and case.request.coupling.between


MODE = "a mode that no gain moves"
RESPONSE = Step(
    "a response that no input reaches",
    "exact norms at some frequencies",
    _of_a_response,
    _by_claim("unreached", "refuse_by_response", "no input reaches that response"),
)
MASS = Step("a singular mass", "exact determinants", _between, _by_mass)

#: What excludes every gain without a search.
WITHOUT_LMIS = (
    Step(MODE, "exact poles of each vertex", _of_the_state, by_mode),
    RESPONSE,
    Step(
        "a disturbance in y at once",
        "an exact product",
        _of_a_response,
        _by_claim("at_once", "refuse_at_once", "w is louder than that in y at once"),
    ),
    MASS,
)


def _before(applies):
    """True where a case of a small plant ``applies`` before it is searched."""

    def at_first(case):
        small = case.request.order <= MODES_FIRST_ABOVE_STATES and case.first is None
        return small and _of_the_state(case) and bool(applies(case))

    return at_first


def seen_modes(request):
    """The places of vertices of a ``request`` at which floats see a mode that no input
    moves and that breaks what is asked of the poles: a row w with w A = s w E, w B = 0.
    Each w B is compared with the sizes of its terms, which units don't change, and with
    rounding errors. It says where an exact look comes first, and decides nothing.
    """
    some = [request.vertices[k] for k in request.distinct]
    E, A, B = (np.array([getattr(d, x) for d in some], float) for x in ("E", "A", "Bu"))
    try:
        s, rows = np.linalg.eig(np.linalg.solve(E, A).mT)
        B = np.linalg.solve(E, B)
        moved, terms = abs(rows.mT @ B), abs(rows.mT) @ abs(B)
        rounding = ROUNDING * np.linalg.norm(B, axis=1, keepdims=True)
        still = ((moved <= UNMOVED * terms) | (moved <= rounding)).all(axis=2)
        outside = np.zeros_like(still)
        for r in (*request.demands, request.claims.stability):
            if (form := r.pole_matrices()) is not None:
                outside[still] |= _outside(form, s[still])
    except np.linalg.LinAlgError:  # a singular E, or numbers beyond those of floats
        return []
    return [(request.distinct[k],) * 2 for k in np.flatnonzero(outside.any(axis=1))]


def _outside(form, s):
    """True for each of the poles s that floats don't see inside of a region, with the
    ``form`` of `Requirement.pole_matrices`.
    """
    alpha, beta = (x.astype(float) for x in form)
    X = beta * s[:, None, None]
    edge = EDGE * (abs(alpha).max() + abs(X).max(axis=(1, 2)))
    return np.linalg.eigvalsh(alpha + X + X.conj().mT)[:, -1] >= -edge


def _turned(case):
    """True if floats see determinants of the masses with two signs."""
    signs = np.linalg.slogdet(np.array([d.E for d in case.request.vertices], float))[0]
    return _between(case) and len(set(signs)) > 1


def _heard(case):
    if not _of_a_response(case):
        return False
    from .responses import hears_response

    return hears_response(case.request)


#: Of these what floats see at first sight; a search takes longer.
AT_FIRST_SIGHT = (
    Step(
        MODE,
        "exact poles; where floats see one",
        _before(lambda case: seen_modes(case.request)),
        lambda case: by_mode(case, seen_modes(case.request)),
    ),
    replace(
        RESPONSE, cost="exact norms; where floats see one", applies=_before(_heard)
    ),
    replace(
        MASS,
        cost="exact determinants; where floats see two signs",
        applies=_before(_turned),
    ),
)


def without_lmis(request, steps=WITHOUT_LMIS):
    """The refusal of a ``request`` by a mode, response or mass: a Solution or None; by
    all ``steps``, or those `AT_FIRST_SIGHT`.
    """
    case = Case(request)
    tries = (step.tries(case) for step in steps if step.applies(case))
    return next((found for found in tries if found is not None), None)
