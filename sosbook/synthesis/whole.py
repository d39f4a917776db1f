"""The whole plant under the gain of a reduced model: what is found, what is proven."""

import warnings

import numpy as np
from scipy.sparse import csc_array, issparse

from ..analysis.large import energy_forms, least_eigenvalue
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
from ..plants.second_order import SecondOrderSystem
from ..requirements.base import Requirement
from ..runtime.time_limit import under_way
from .certificates import prove
from .feasibility import answer
from .found import found_on, lifted
from .points import point
from .request import Request

HALVES = 2.0 ** -np.arange(
    16
)  # of the rates of damping: weights of z' M z' in the energy
ABOVE = np.array([1.1, 1.3, 1.7, 3.0])  # times the decay: weights that are tried first
SPARSE = (
    "a plant in sparse matrices is too large for LMIs: only an energy that decays "
    "proves it, of a passive loop without integrators, for half-planes"
)


def proven_on(design, whole, digits):
    """An exact proof that a ``design``'s gain, lifted and rounded to so many ``digits``
    (several are tried without), keeps of one ``whole`` plant what is asked of the
    part's poles; the rest is about the part's coordinates, and a warning says so. Of a
    design for no part all is asked.
    """
    K, U = lifted(design, whole)
    asked = _asked_of_whole(design.request)
    sparse = isinstance(whole, SecondOrderSystem) and issparse(whole.M)
    if sparse:
        if U is not None or _decay(asked) is None:
            return Unproven(SPARSE)
        proof = _by_energy(whole, K, U, asked, digits)  # sooner than a search ends
        if proof is not None:
            return proof
    with under_way(f"no energy decays, and {SPARSE}" if sparse else ""):
        seen = found_on(design, whole)
    if seen.broken:
        cure = (
            "ask less of the whole: analyse_pid(whole, part.reduction.lift(K), ...) "
            "takes any region"
        )
        return Unproven(f"the whole doesn't keep it. By a search, {seen}; {cure}")
    if sparse:
        return Unproven(f"no energy was found that decays, and {SPARSE}. {seen}")
    proof, tries = None, DIGITS if digits is None else (digit_count(digits),)
    for few in tries:
        request = Request(whole, U, requirements=asked, gain=round_digits(K, few))
        with under_way(
            f"the poles of the whole keep it in floats; a P of {request.order} states "
            f"was sought for the gain in {few} digits"
        ):
            solution = point(request)
            if solution is None and design.request.plant.reduction is None:
                solution = answer(request, refuse=False)
        if solution is not None and solution.status == "feasible":
            with under_way(
                "the poles of the whole keep it in floats, and a P is found; its "
                f"{len(solution.margins)} blocks of up to {request.order} rows or more "
                "were being decided in exact arithmetic, which is the longest part"
            ):
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
    rates = whole.D.diagonal() / masses
    weights = [*(sigma * ABOVE), *(rates.max() * HALVES), *(rates.min() * HALVES[:8])]
    weights = [float(e) for e in weights if e > sigma]
    if not weights or not _damped(whole, K, sigma, min(weights)):
        return None
    for k, epsilon in enumerate(weights):
        with under_way(f"{k} of {len(weights)} energies were tried"):
            if _decays(whole, K, sigma, epsilon):
                return EnergyProof.of(EnergyProof.contents(whole, K, asked, epsilon))
    return None


def _damped(whole, K, sigma, epsilon):
    """Whether D - B K_D exceeds (sigma + epsilon) M: no larger epsilon mends that."""
    forms = energy_forms(whole, K, sigma, epsilon)
    if forms is None:
        return False
    decay = (csc_array(x)[whole.n :, whole.n :] for x in forms["decay"])
    return least_eigenvalue(*forms["mass"]) > 0 and least_eigenvalue(*decay) > 0


def _decays(whole, K, sigma, epsilon):
    """Whether the energy with this weight is one, and decays."""
    forms = energy_forms(whole, K, sigma, epsilon)
    return all(least_eigenvalue(*forms[name]) > 0 for name in ("energy", "decay"))


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
