"""The whole plant under the gain of a reduced model: what is found, what is proven."""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.sparse import issparse

from ..analysis.large import RIGHTMOST, SAME, Pencil, energy_forms, least_eigenvalue
from ..exact.definite import round_digits
from ..exact.proof import DIGITS, Examined, Unproven
from ..exact.proof_file import GainProof
from ..exact.rational import (
    decimal,
    decimals,
    digit_count,
    exact,
    read_array,
    read_number,
)
from ..plants.as_data import plant_data, read_plant
from ..plants.descriptor_system import DescriptorSystem
from ..plants.second_order import SecondOrderSystem
from ..requirements.base import Requirement
from ..runtime.read_only import ReadOnly
from .certificates import prove
from .feasibility import answer
from .points import point
from .request import Request

SHIFTS = 0.3, 1.0, 3.0  # of the part's frequencies: where a sparse whole is looked at
HALVES = 2.0 ** -np.arange(16)  # of the largest rate: weights of z' M z' in the energy
ABOVE = np.array([1.1, 1.3, 1.7, 3.0])  # times the decay: weights that are tried first
AT_EDGE = 1e-12  # of a pole's size: nearer to an edge floats can't tell the side


@dataclass(frozen=True, eq=False)
class Found(ReadOnly):
    """What a search in floats has found of a whole plant; see `Design.check_on`.

    ``poles``, (k,): poles that were refined, those furthest right first; of two
    conjugates one; ``of``: how many poles the whole has; ``broken``: what is asked of
    the poles and a refined one breaks, in words; where it lies at the edge to all
    digits that floats tell, too; ``unsettled``: how many more were seen that Newton's
    method didn't refine: they aren't among the poles, and nothing is said of them.
    """

    poles: np.ndarray
    of: int
    broken: tuple
    unsettled: int = 0

    @property
    def pole(self) -> complex:
        """The rightmost pole that was found, in rad/s."""
        return complex(self.poles[0])

    @property
    def kept(self) -> bool:
        """Whether no pole that was found breaks what is asked: that is no proof."""
        return not self.broken

    def __str__(self):
        s = self.pole
        place = f"{s.real:.6g}" + (f"±{s.imag:.6g}j" if s.imag else "")
        words = (
            f"found: the rightmost of {len(self.poles)} refined poles is {place} "
            f"rad/s; the whole has {self.of}, and one that wasn't found may lie "
            "further right"
        )
        if self.unsettled:
            words += f"; seen, but not refined: {self.unsettled}"
        return words + "".join(f"; broken: {claim}" for claim in self.broken)


def lifted(design, whole):
    """The gain of a ``design`` of a part on a ``whole`` plant's state, and the U of its
    integrators; a plant of the part's own size has them as they are.
    """
    request, K = design.request, design._gain()
    kind = DescriptorSystem if isinstance(request.plant, DescriptorSystem) else None
    if not isinstance(whole, kind or SecondOrderSystem):
        name = (kind or SecondOrderSystem).__name__
        raise ValueError(f"on must be one {name}, got {type(whole).__name__}")
    part = request.plant.reduction
    rows = whole.order if kind else whole.n
    own = request.order if kind else request.plant.n
    wanted = own if part is None else part.of
    if (rows, whole.m) != (wanted, request.plant.m):
        raise ValueError(
            f"on has {rows} coordinates and {whole.m} inputs, needs {wanted} and "
            f"{request.plant.m}: give the plant that was reduced, or one like it"
        )
    if request.K_A is not None and np.any(request.K_A):
        raise ValueError("a design with K_A isn't looked at on another plant")
    U = request.U
    if part is None:
        return K, U
    return part.lift(K), None if U is None else U @ part.back


def found_on(design, whole):
    """The `Found` poles of a ``whole`` plant or polytope under a ``design``'s gain."""
    worst = [_found(design, one) for one in _plants(whole)]
    return max(worst, key=lambda found: (len(found.broken), found.pole.real))


def _plants(whole):
    if isinstance(whole, DescriptorSystem):
        parts = [DescriptorSystem.of([d], whole.reduction) for d in whole.vertices]
        return [whole] if len(parts) == 1 else parts
    if not hasattr(whole, "vertices"):
        raise ValueError(f"on must be a plant, got {type(whole).__name__}")
    return list(whole.vertices)


def _found(design, whole):
    K, U = lifted(design, whole)
    pencil = _pencil(whole, K, U)
    poles = pencil.everywhere() if not issparse(pencil.S) else _looked(design, pencil)
    forms = [  # what is asked of the poles, in words, and its alpha and beta
        (r.statement, [np.array(x, float) for x in r.pole_matrices()])
        for r in design.request.of_poles
    ]
    out = {words: _outside(form, [s for s, _ in poles]) for words, form in forms}
    if not issparse(pencil.S):  # all are there, and few need be refined
        few = {*np.argsort([-s.real for s, _ in poles])[:RIGHTMOST].tolist()}
        few |= {int(np.argmax(values)) for values in out.values()}
        poles = [poles[k] for k in sorted(few)]
    refined: dict = {}
    unsettled: list = []
    for s, q in poles:
        s, q = (s, q) if s.imag >= 0 else (s.conj(), q.conj())
        one = pencil.refined(s, q)
        if one is None:
            unsettled.append(s)
        elif not _among(refined, one[0]):
            refined.setdefault(*one)
    lost: list = []
    for s in unsettled:
        lost += [] if _among([*refined, *lost], s) else [s]
    if not refined:
        raise ArithmeticError("no pole of the whole could be refined")
    doubts = np.array(list(refined.values()))
    refined = np.array(list(refined))
    broken = [w for w, form in forms if _outside(form, refined, doubts).max() >= 0]
    refined = np.array(sorted(refined, key=lambda s: -s.real))
    a = 0 if U is None else len(U)
    first = isinstance(whole, DescriptorSystem)
    order = whole.order if first else 2 * whole.n + a
    return Found(refined, order, tuple(broken), len(lost))


def _among(poles, s):
    return any(abs(s - x) <= SAME * abs(x) for x in poles)


def _pencil(whole, K, U):
    if isinstance(whole, DescriptorSystem):
        (d,) = whole.vertices
        N, m = d.Bu.shape
        K = np.hstack([K, np.zeros((m, N))])
        return Pencil(np.zeros((N, N)), d.E, -d.A, d.Bu, K, np.zeros((0, N)))
    U = np.zeros((0, whole.n)) if U is None else U
    return Pencil(whole.M, whole.D, whole.S, whole.B, K, U)


def _looked(design, pencil):
    """Poles and vectors near some points of the imaginary axis, of a sparse whole."""
    own = np.abs(np.atleast_2d(design.poles())[0])
    top = np.sqrt(abs(pencil.S).sum(axis=0).max() / abs(pencil.M).diagonal().min())
    slow, fast = own[own > 0].min(), own.max()
    shifts = [*(c * slow for c in SHIFTS), *(c * fast for c in SHIFTS), top]
    shifts += np.geomspace(slow, top, len(SHIFTS) + 2)[1:-1].tolist()
    return [pair for w in shifts for pair in pencil.near(1j * w)]


def _outside(form, poles, doubts=0.0):
    """How far outside of a region each pole may lie; it is inside if that's negative.
    No region has its edge: a pole that floats can't tell from that is outside.
    """
    alpha, beta = form
    s = np.asarray(poles)[:, None, None]
    values = np.linalg.eigvalsh(alpha + s * beta + s.conj() * beta.T)[:, -1]
    doubts = doubts + AT_EDGE * np.abs(poles)
    return values + AT_EDGE * np.abs(alpha).max() + 2 * doubts * np.linalg.norm(beta)


def proven_on(design, whole, digits):
    """An exact proof that a ``design``'s gain, lifted and rounded to so many ``digits``
    (several are tried without), keeps of one ``whole`` plant what is asked of the
    part's poles; the rest is about the part's coordinates, and a warning says so. Of a
    design for no part all is asked.
    """
    K, U = lifted(design, whole)
    seen = found_on(design, whole)
    cure = (
        "ask less of the whole: analyse_pid(whole, part.reduction.lift(K), ...) "
        "takes any region"
    )
    if seen.broken:
        return Unproven(f"the whole doesn't keep it. By a search, {seen}; {cure}")
    asked = _asked_of_whole(design.request)
    if isinstance(whole, SecondOrderSystem) and issparse(whole.M):
        return _by_energy(whole, K, U, asked, digits) or Unproven(
            f"the energy of so large a plant proves no more than passive loops. {seen}"
        )
    proof = None
    for few in DIGITS if digits is None else (digit_count(digits),):
        request = Request(whole, U, requirements=asked, gain=round_digits(K, few))
        solution = point(request)
        if solution is None and design.request.plant.reduction is None:
            solution = answer(request, refuse=False)
        if solution is not None and solution.status == "feasible":
            proof = prove(request, solution.K, solution.P, own=solution.own)
            if proof.proven:
                return proof
    if isinstance(whole, SecondOrderSystem):
        proof = _by_energy(whole, K, U, asked, digits) or proof
    return proof or Unproven(
        "no point of the LMIs was found from the modes of the whole that floats can "
        f"tell from their edge. {seen}"
    )


def _asked_of_whole(request):
    """What is asked of the whole: of the poles alone, where the design is of a part."""
    if request.plant.reduction is None:
        return list(request.requirements)
    asked = [r for r in request.requirements if r.pole_matrices() is not None]
    if left := [r.words for r in request.requirements if r not in asked]:
        warnings.warn(
            f"of the whole the poles alone are proven: {', '.join(left)} is asked in "
            "the part's coordinates. Ask it in the whole's by analyse_pid(whole, "
            "part.reduction.lift(K), ...)",
            stacklevel=2,
        )
    return asked


def _by_energy(whole, K, U, asked, digits):
    """The `EnergyProof` of all that is asked, or None: half-planes alone can be."""
    sigma = _decay(asked)
    if sigma is None or U is not None:
        return None
    K = round_digits(K, DIGITS[0] if digits is None else digit_count(digits))
    masses = whole.M.diagonal()
    if not masses.min() > 0:
        return None
    rate = (whole.D.diagonal() / masses).max()
    for epsilon in (*(sigma * ABOVE), *(rate * HALVES)):
        if epsilon > sigma:
            seen = _energy(whole, K, sigma, float(epsilon))
            if seen is not None and min(seen.values()) > 0:
                return EnergyProof.of(
                    EnergyProof.contents(whole, K, asked, float(epsilon))
                )
    return None


def _decay(requirements):
    """The decay in rad/s that half-planes ask for, rounded up; None of other regions,
    which no energy proves.
    """
    sigma = 0.0
    for r in requirements:
        alpha, beta = r.pole_matrices() or (np.zeros((0, 0)),) * 2
        if alpha.shape != (1, 1) or not beta.item() > 0:
            return None
        bound = exact(alpha).item() / (2 * exact(beta).item())
        while exact(sigma) < bound:
            sigma = max(float(np.nextafter(sigma, np.inf)), float(bound))
    return sigma


def _energy(whole, K, sigma, epsilon):
    """What is proven of the forms' least eigenvalues; None where M isn't symmetric."""
    forms = energy_forms(whole, K, sigma, epsilon)
    return forms and {name: least_eigenvalue(*form) for name, form in forms.items()}


class EnergyProof(GainProof):
    """That the energy of a large plant decays under a gain: see `energy_forms`. Its
    ``text`` is a file with the plant, whose sparse matrices have their entries, the
    half-planes that are asked, the gain and epsilon, the weight of z' M z' in the
    energy; it is decided by sparse factors in floats, with their rounding bounded.
    """

    kind = "energy"

    @classmethod
    def examine(cls, data):
        plant = read_plant(data["plant"])
        if not isinstance(plant, SecondOrderSystem):
            raise ValueError("an energy is that of one plant of second order")
        K = read_array(data["K"], plant.m, 2 * plant.n)
        asked = [Requirement.read(r) for r in data["requirements"]]
        epsilon, sigma = read_number(data["epsilon"]), _decay(asked)
        again = cls.contents(plant, K, asked, epsilon)
        if sigma is None:
            return again, Examined.nothing("an energy proves half-planes alone")
        least = _energy(plant, K, sigma, epsilon)
        if least is None:
            return again, Examined.nothing("M isn't symmetric")
        failed = tuple(name for name, value in least.items() if not value > 0)
        return again, Examined(() if failed else tuple(again["claims"]), least, failed)

    @classmethod
    def contents(cls, plant, K, asked, epsilon):
        """The data of the file of a ``plant``, a gain ``K``, what is asked, epsilon."""
        stable = "the plant, under u = K x, is stable"
        return {
            "claims": list(dict.fromkeys([stable, *(r.statement for r in asked)])),
            "plant": plant_data(plant),
            "U": [],
            "K_A": None,
            "requirements": [r.data() for r in asked],
            "K": decimals(K),
            "epsilon": decimal(epsilon),
        }
