"""Exact proofs of an observer at the vertices, or that there is none, as files."""

import numpy as np

from ..exact.definite import exact, in_floats, inverse
from ..exact.proof_file import ProofFile, significant
from ..exact.rational import decimal, decimals, null_basis, read_array
from ..exact.refusal import MultiplierRefusal
from ..exact.repair import repair_multipliers
from ..language import Affine
from ..lmi.text import rationals
from ..solver.blocks import Blocks
from ..solver.deepest import deepest


class ObserverCertificate(ProofFile):
    """An exact proof of Theorem 2.5 at the vertices, or its failure.

    ``text`` is that of the file.
    """

    kind = "observer"

    @property
    def L(self):
        """The gain that the proof is about, rounded to the printed digits."""
        return read_array(self.data["L"], None, None)

    @property
    def digits(self):
        """Significant digits of the gain's longest entry."""
        return significant(self.L)

    @classmethod
    def contents(cls, problem, L, bound, values):
        """The data of the file for a problem, a rounded L and exact values.

        ``bound`` is what tr J is below.
        """
        return {
            **problem.data(),
            "L": decimals(L),
            "bound": decimal(bound),
            "unknowns": {name: decimals(x) for name, x in values.items()},
        }


class ObserverRefusal(MultiplierRefusal):
    """Multipliers that exclude every observer by Theorem 2.5; see `MultiplierRefusal`.

    ``text`` is that of the file.
    """

    kind = "infeasible observer"

    @classmethod
    def contents(cls, problem):
        """The data of the file for a problem, without the multipliers."""
        return problem.data()


def refuse_observer(problem):
    """The `ObserverRefusal` of a ``problem``, an `ObserverProblem`; or None.

    P1, P2 and Y may be scaled down, and J up: what decides is whether
    he(A'P + C'Y) < 0 at all. Y may be anything, so it decides only where
    C e = 0. Multipliers of that, W Z W', are multipliers of all blocks.

    """
    lmi, N = problem.open(), len(problem.T[0])
    whole = lmi.in_unknowns(rationals)
    unseen = null_basis(exact(problem.C) @ inverse(exact(problem.T[0])).T)
    for errors in (unseen[:, :0], unseen):  # the state alone, or with an error
        multipliers = _exact_multipliers(whole, lmi.unknowns, errors, N)
        if multipliers is not None:
            data = ObserverRefusal.contents(problem)
            return ObserverRefusal.of(
                ObserverRefusal.written_from(data, multipliers, str)
            )
    return None


def _exact_multipliers(whole, unknowns, errors, N):
    """Multipliers by block for some errors (columns) and all N states, or None."""
    unknowns = unknowns[:2] if errors.shape[1] else unknowns[1:2]
    few, back = {u.name: whole[u.name] for u in unknowns}, {}
    for name, g in whole.items():
        if name.startswith("decay"):
            W = exact(np.zeros((len(g.constant), N + errors.shape[1])))
            W[:N, N:], W[N : 2 * N, :N] = errors, exact(np.eye(N))
            g, back[name] = W.T @ g @ W, W
            terms = [t for t in g.terms if t.unknown in unknowns]
            few[name] = Affine(g.constant, terms)
    deep = deepest(Blocks([in_floats(g) for g in few.values()], unknowns))
    if deep.depth > 0 or deep.Z is None:
        return None
    try:
        repaired = repair_multipliers(list(few.values()), unknowns, deep.Z)
    except (np.linalg.LinAlgError, IndexError, ValueError):
        return None  # the float multipliers are too singular
    if repaired is None:
        return None
    multipliers = dict(zip(few, repaired[0]))
    return multipliers | {name: W @ multipliers[name] @ W.T for name, W in back.items()}
