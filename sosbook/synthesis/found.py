"""Search, in floats, of a whole plant under the gain of a reduced model."""

from dataclasses import dataclass, replace

import numpy as np

from ..exact.rational import exact
from ..laws.full_state import FullState
from ..plants.descriptor_system import OF_TICKS, DescriptorSystem
from ..plants.reduction import NO_BASIS
from ..plants.second_order import SecondOrderSystem
from ..runtime.progress import each
from ..runtime.read_only import ReadOnly
from ..runtime.sparse import issparse
from ..runtime.time_limit import OutOfTime

SHIFTS = 0.3, 1.0, 3.0  # of the part's frequencies: where a sparse whole is looked at
NOT_SEEN = (
    "the sensor {} of the part sees modes of the whole that the part doesn't keep, and "
    "its rows don't say how: design with law=part.reduction.law(law), where law has "
    "the rows on the whole's coordinates, or keep the sensor's place by reduce(rows=)"
)
AT_EDGE = 1e-12  # of a pole's size: nearer to an edge floats can't tell the side


@dataclass(frozen=True, eq=False)
class Found(ReadOnly):
    """The result of a search, in floats, of a whole plant; see `Design.check_on`.

    ``poles``, (k,): poles that were refined, those furthest right first; of two
    conjugates one; ``of``: how many poles the whole has; ``broken``: what is asked of
    the poles and a refined one breaks, in words; where it lies at the edge to all
    digits that floats tell, too; ``unsettled``: how many more were seen that Newton's
    method didn't refine: they aren't among the poles, and nothing is said of them;
    ``right``: at least so many poles are right of the imaginary axis, by the signs of a
    factor of a symmetric sparse loop; None where that isn't counted; ``stopped``: where
    time was over or a broken claim ended the search, in words.
    """

    poles: np.ndarray
    of: int
    broken: tuple
    unsettled: int = 0
    right: int | None = None
    stopped: str = ""

    @property
    def pole(self) -> complex:
        """The rightmost pole that was found, in rad/s."""
        return complex(self.poles[0])

    @property
    def kept(self) -> bool:
        """True if the search ended and found nothing that breaks what is asked: that is
        no proof.
        """
        return not (self.broken or self.stopped)

    def __str__(self):
        """The rightmost pole found, and what wasn't settled, in words."""
        s = self.pole
        place = f"{s.real:.6g}"
        if abs(s.imag) > AT_EDGE * abs(s):
            place += f"±{abs(s.imag):.6g}j"
        words = (
            f"found: the rightmost of {len(self.poles)} refined poles is {place} "
            f"rad/s; the whole has {self.of}, and one that wasn't found may lie "
            "further right"
        )
        if self.unsettled:
            words += f"; seen, but not refined: {self.unsettled}"
        if self.right:
            words += f"; counted right of the imaginary axis: {self.right} or more"
        words += "".join(f"; broken: {claim}" for claim in self.broken)
        return words + (f"; {self.stopped}" if self.stopped else "")


def law_on(design, whole):
    """The law of a ``design`` of a part on a ``whole`` plant, and its K there."""
    request = design.request
    if request.K_A is not None and np.any(request.K_A):
        raise ValueError("a design with K_A isn't looked at on another plant")
    (law, K), plant = design.its_law(), request.plant
    K = design._gain() if law.whole else K
    plant = _bare(plant)
    part = plant.reduction
    kind = DescriptorSystem if isinstance(plant, DescriptorSystem) else None
    if not isinstance(whole, kind or SecondOrderSystem):
        name = (kind or SecondOrderSystem).__name__
        raise ValueError(f"on must be one {name}, got {type(whole).__name__}")
    if kind and whole.dt is not None:
        raise ValueError(OF_TICKS.format("on="))
    own, rows = (x.order if kind else x.n for x in (plant, whole))
    wanted = own if part is None else part.of
    if (rows, whole.m) != (wanted, plant.m):
        raise ValueError(
            f"on has {rows} coordinates and {whole.m} inputs, needs {wanted} and "
            f"{plant.m}: give the plant that was reduced, or one like it"
        )
    if part is None:
        return law, K
    if part.back is None:
        raise ValueError(NO_BASIS)
    if law.whole:
        U = None if law.U is None else law.U @ part.back
        return law.of_whole or FullState(U), part.lift(K)
    if law.of_whole is None:
        seen = law.readings(plant)
        uses = np.vstack([seen.C, seen.Ca]).reshape(-1, part.halves, part.kept) != 0
        mixed = np.count_nonzero(part.back, axis=1) > 1  # no coordinate of the whole
        strange = (uses & mixed).any(axis=(1, 2)).reshape(2, -1).any(axis=0)
        if strange.any():
            raise ValueError(NOT_SEEN.format(seen.names[strange.argmax()]))
    return law.of_whole or law.on_part(part.back, part.halves), K


def _bare(plant):
    """A ``plant`` without the sensors that were joined to it."""
    known = getattr(plant, "sensed", None)
    return known.bare if known else plant


def found_on(design, whole, progress=False):
    """The `Found` poles of a ``whole`` plant or polytope under a ``design``'s gain; of
    several plants those of the worst. With ``progress`` a bar counts the places.
    """
    worst, plants = None, _plants(whole)
    for k, one in enumerate(plants):
        try:
            found = _found(design, one, progress)
        except OutOfTime:
            if worst is None:
                raise
            more = f"time was over after {k} of {len(plants)} vertices"
            return replace(worst, stopped=worst.stopped or more)
        if worst is None or _badness(found) > _badness(worst):
            worst = found
    return worst


def _badness(found):
    return len(found.broken), bool(found.stopped), found.pole.real


def _plants(whole):
    if isinstance(whole, DescriptorSystem):
        own = whole.reduction, whole.sensed, whole.states, whole.dt
        parts = [DescriptorSystem.of([d], *own) for d in whole.vertices]
        return [whole] if len(parts) == 1 else parts
    if not hasattr(whole, "vertices"):
        raise ValueError(f"on must be a plant, got {type(whole).__name__}")
    return list(whole.vertices)


def _found(design, whole, progress):
    design._of_time("check_on")
    search = _Search(design, _pencil(design, whole))
    search.run(progress)
    if not search.refined:
        raise ArithmeticError("no pole of the whole could be refined")
    return search.found(search.pencil.order)


class _Search:
    """Poles of a ``pencil`` and what they break of what is asked of a ``design``."""

    def __init__(self, design, pencil):
        self.pencil, self.design = pencil, design
        self.asked = list(design.request.of_poles)
        self.forms = [
            [np.array(x, float) for x in r.pole_matrices()] for r in self.asked
        ]
        self.refined: dict[complex, float] = {}  # poles, and their doubts
        self.unsettled: list[complex] = []
        self.right: int | None = None
        self.stopped = ""

    def run(self, progress):
        """Find what can be found, until time is over or something is broken."""
        sparse = issparse(self.pencil.S)
        seen = [] if sparse else self.pencil.everywhere()
        done, places = 0, self._places() if sparse else []
        try:
            for done, (place, count) in enumerate(
                each(places, "place", progress and sparse)
            ):
                new = self.pencil.near(place, count)
                for s, _, doubt in new:
                    if doubt is not None:
                        self._keep(s, doubt)
                left = [x for x in new if x[2] is None]
                seen += left
                if left:
                    self._refine(*max(left, key=lambda x: self._outside(x[0])))
                if self.refined and self._broken() and done + 1 < len(places):
                    self.stopped = (
                        f"the search ended there, at {done + 1} of {len(places)} places"
                    )
                    break
            self._refine_few(seen)
        except OutOfTime as over:
            if not self.refined:
                raise
            where = f" after {done} of {len(places)} places" if sparse else ""
            self.stopped = f"time was over{where}: {over}"

    def found(self, order):
        """The `Found` of a whole with so many poles."""
        poles = sorted(self.refined, key=lambda s: -s.real)
        lost: list = []
        for s in self.unsettled:
            lost += [] if _among([*poles, *lost], s) else [s]
        broken = tuple(r.statement for r in self._broken())
        return Found(
            np.array(poles), order, broken, len(lost), self.right, self.stopped
        )

    def _broken(self):
        poles, doubts = map(np.array, zip(*self.refined.items()))
        unstable = bool(self.right)
        return [
            r
            for r, form in zip(self.asked, self.forms)
            if _outside(form, poles, doubts).max() >= 0
            or (unstable and r.implies_stability)
        ]

    def _outside(self, s):
        return max(_outside(form, [s]).item() for form in self.forms)

    def _refine_few(self, poles):
        """Refine the rightmost ones, and of each claim the one that keeps it least."""
        from ..analysis.large import RIGHTMOST

        if not poles:
            return
        places = np.array([s for s, *_ in poles])
        few: list = []
        for k in np.argsort(-places.real).tolist():
            s = places[k] if places[k].imag >= 0 else places[k].conj()
            if not _among([x for x, _ in few], s):
                few.append((s, k))
            if len(few) == RIGHTMOST:
                break
        worst = [int(np.argmax(_outside(form, places))) for form in self.forms]
        for k in dict.fromkeys([*(k for _, k in few), *worst]):
            self._refine(*poles[k])

    def _refine(self, s, q, _):
        s, q = (s, q) if s.imag >= 0 else (s.conj(), q.conj())
        if _among(self.refined, s):
            return
        one = self.pencil.refined(s, q)
        if one is None:
            self.unsettled.append(s)
        else:
            self._keep(*one)

    def _keep(self, s, doubt):
        s = s if s.imag >= 0 else s.conjugate()
        if not _among(self.refined, s):
            self.refined[s] = doubt

    def _places(self):
        """Points where poles of a sparse whole are sought, and how many there: on the
        positive real axis first, where the count of negative eigenvalues says that some
        are, then near the frequencies of the part, and between these and the fastest.
        """
        pencil = self.pencil
        own = np.abs(np.atleast_2d(self.design.poles())[0])
        slow, fast = own[own > 0].min(), own.max()
        top = np.sqrt(abs(pencil.S).sum(axis=0).max() / abs(pencil.M).diagonal().min())
        self.right, places = pencil.right_of_zero()
        places += [(1j * c * w, 0) for w in (slow, fast) for c in SHIFTS]
        places += [(fast, 0), (3 * fast, 0), (1j * top, 0)]
        between = np.geomspace(slow, top, len(SHIFTS) + 2)[1:-1]
        return places + [(1j * w, 0) for w in between.tolist()]


def _among(poles, s):
    from ..analysis.large import SAME

    return any(abs(s - x) <= SAME * abs(x) for x in poles)


def _pencil(design, whole):
    """The `Pencil` of the loop of a ``design``'s law and gain with the ``whole``."""
    from ..analysis.large import Pencil

    law, K = law_on(design, whole)
    if law.whole:
        a = 0 if law.U is None else len(law.U)
        K, C = np.split(K, [K.shape[1] - a], axis=1)
        A, G = np.zeros((a, a)), np.zeros((a, K.shape[1]))
        if a:
            G[:, : whole.n] = law.U
    elif isinstance(whole, SecondOrderSystem) and issparse(whole.M):
        of_part, K = design.its_law()
        few = of_part.parts(_bare(design.request.plant)).controller(exact(K))
        few = (x.astype(float) for x in few)
        K, A, G, C = _on_sparse(whole, law.readings(whole), law.lag, *few)
    else:
        whole, law = law.on(whole)
        parts = law.parts(whole)
        A, B, C, D = parts.controller(exact(K))
        K, G = D @ parts.rows, B @ parts.rows
        A, C, K, G = (x.astype(float) for x in (A, C, K, G))
    if isinstance(whole, DescriptorSystem):
        (d,) = whole.vertices
        none = np.zeros(d.E.shape)
        K, G = (np.hstack([x, 0.0 * x]) for x in (K, G))
        return Pencil(none, d.E, -d.A, d.Bu, K, A, G, C)
    return Pencil(whole.M, whole.D, whole.S, whole.B, K, A, G, C)


def _on_sparse(whole, seen, lag, A, B, C, D):
    """K, A, G and C of a `Pencil` of the controller x_c' = A x_c + B y, u = C x_c + D y
    on a sparse ``whole`` that ``seen`` reads: late readings are states of it, with z''
    of the plant's equation in the place of an acceleration.
    """
    from scipy.sparse.linalg import splu

    late, n = seen.late, whole.n
    K, G = (x[:, ~late] @ seen.C[~late] for x in (D, B))
    if not late.any():
        return K, A, G, C
    rates, forces = np.split(seen.Ca[late], [n], axis=1)
    shares = splu(whole.M.T.tocsc()).solve(forces.T).T
    rows = seen.C[late] - np.hstack([shares @ whole.S, shares @ whole.D - rates])
    push = seen.Du[late] + shares @ whole.B
    one = np.eye(len(push))
    A = np.block([[A, B[:, late]], [push @ C, push @ D[:, late] - one]])
    G, C = np.vstack([G, rows + push @ K]), np.hstack([C, D[:, late]])
    scale = np.r_[np.ones(len(A) - len(push)), np.full(len(push), 1 / lag)][:, None]
    return K, scale * A, scale * G, C


def _outside(form, poles, doubts=0.0):
    """How far outside of a region each pole lies; one at its edge is outside, too."""
    alpha, beta = form
    s = np.asarray(poles)[:, None, None]
    values = np.linalg.eigvalsh(alpha + s * beta + s.conj() * beta.T)[:, -1]
    doubts = doubts + AT_EDGE * np.abs(poles)
    return values + AT_EDGE * np.abs(alpha).max() + 2 * doubts * np.linalg.norm(beta)
