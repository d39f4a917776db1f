"""The LMIs of Theorem 2.5 for a plant, a state feedback and weights; their proofs."""

from dataclasses import replace

import numpy as np
from scipy.linalg import cholesky

from ..analysis.riccati import balanced_units, lyapunov, riccati
from ..exact.definite import exact, in_floats, inverse, round_digits
from ..exact.proof_file import ProofFile, significant
from ..exact.rational import decimal, decimals, null_basis, read_array
from ..exact.refusal import MultiplierRefusal
from ..exact.repair import repair_multipliers
from ..language import Affine, Unknown, block
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText, rationals
from ..plants.as_data import plant_data
from ..plants.checks import check_rank, inverse_by_rows
from ..plants.descriptor import mean_descriptor, twins
from ..solver.blocks import Blocks
from ..solver.deepest import deepest
from ..theorems import observer_cost, observer_decay
from ..theorems.lqr import trace_bound
from .centre import AMID
from .error_loop import error_loop

OPTIMUM_GAP = 1e-8  # relative, to which the optimum is known


class ObserverProblem:
    """Theorem 2.5 for the ``vertices`` of a ``plant`` and ``K``, ``Q_F``, ``R_F``,
    ``C`` and ``noises``, B_w of each vertex, as in `design_observer`. The dual state is
    T xi with T = diag(T1, T2), near the solution's coordinates, rounded to six digits
    and read as exact. Raises ValueError if there is no observer of the mean plant.
    """

    def __init__(self, plant, vertices, K, Q_F, R_F, C, noises):
        """Choose the coordinates by the mean plant's observer."""
        self.plant, self.vertices, self.K, self.C = plant, vertices, K, C
        self.Q_F, self.R_F, self.noises = Q_F, R_F, noises
        mean = mean_descriptor(vertices)
        A, B, _ = mean.state_space()
        N = len(A)
        check_rank(R_F, "R_F must be regular: each output has noise")
        noise, R = Q_F[:N] @ Q_F[:N].T, R_F @ R_F.T
        units = 1 / balanced_units(A.T, C.T, noise, R)  # x = units xi
        A, B = A / units[:, None] * units, B / units[:, None]
        K, C = K * units, C * units
        source = noise / np.outer(units, units)
        small = 1e-6 * (np.trace(source) / N or 1.0) * np.eye(N)
        if np.linalg.eigvals(A + B @ K).real.max() >= 0:
            raise ValueError("K doesn't stabilise the mean plant: design it first")
        try:
            X = riccati(A.T, C.T, source + small, R)
            gain = np.linalg.solve(R, C @ X)  # L' = -gain
            errors = A - gain.T @ C
            if not np.linalg.eigvals(errors).real.max() < 0:
                raise np.linalg.LinAlgError("the error doesn't decay")
        except np.linalg.LinAlgError:
            raise ValueError(
                "C doesn't see an unstable mode of the mean plant (or one "
                "on the imaginary axis): measure more, or take that state "
                "out"
            ) from None
        rest = lyapunov(A + B @ K, errors @ X + X @ errors.T)
        self.T = [
            round_digits(np.linalg.inv(cholesky(x, lower=True)).T / units[:, None], 6)
            for x in (X, rest)
        ]
        sizes = np.linalg.norm(gain * units @ self.T[0], axis=1)
        self.sizes = round_digits(np.where(sizes > 0, sizes, 1.0), 2)  # of Y's rows
        self.left = round_digits(inverse_by_rows(mean.E @ self.T[0]), 6)
        self.unit = float(
            round_digits(max(np.linalg.norm(self.left @ w, 2) for w in noises), 2)
        )

    def data(self):
        """The plant and what was asked, as decimals."""
        mean = mean_descriptor(self.vertices)
        return {
            "plant": plant_data(self.plant),
            **{x: decimals(getattr(self, x)) for x in ("K", "C", "Q_F", "R_F")},
            "noises": [decimals(w) for w in self.noises],
            "model": {x: decimals(getattr(mean, x)) for x in ("E", "A", "Bu")},
            "coordinates": {
                "T": [decimals(x) for x in self.T],
                "left": decimals(self.left),
                "unit": decimal(self.unit),
            },
        }

    def unknowns(self, L=None):
        """P1, P2, Y (left out where L is given) and J."""
        N = len(self.T[0])
        unknowns = [
            Unknown("P1", N, symmetric=True),
            Unknown("P2", N, symmetric=True),
            Unknown("Y", len(self.C), N),
            Unknown("J", self.noises[0].shape[1], symmetric=True),
        ]
        return unknowns if L is None else [*unknowns[:2], unknowns[3]]

    def blocks(self, values, number=lambda x: x, L=None, bound=None):
        """All blocks by name at ``values`` of the unknowns, matrices or expressions,
        with arrays by ``number``; with ``L``, (N, q), Y = L' P1 is put in, else it is
        the unknown, whose rows have their ``sizes``; ``bound`` is that of tr J.
        """
        T1, T2 = map(number, self.T)
        T = block([[T1, 0], [0, T2]])
        back, back1 = inverse(T).T, inverse(T1).T
        left, unit = number(self.left), number(np.array(self.unit)).item()
        C, Q_F, R_F = number(self.C) @ back1, number(self.Q_F), self.R_F
        P1, P2, J = (values[name] for name in ("P1", "P2", "J"))
        if L is None:
            Y = number(np.diag(self.sizes)) @ values["Y"]
        else:
            Y = (number(L).T @ T1) @ P1
        blocks = {"P1": P1, "P2": P2}
        if bound is not None:
            limit = number(np.array(bound)).item() / unit**2
            blocks["trace"] = trace_bound(J, limit)
        mean = mean_descriptor(self.vertices).map(number)
        gain = number(self.K)
        noisy = [replace(d, Bw=w) for d, w in zip(self.vertices, self.noises)]
        for k in sorted(set(twins(noisy))):  # repetitions count once
            i, noise = k + 1, self.noises[k]
            d = self.vertices[k].map(number)
            E, A = error_loop(d, mean, gain)
            loop = T.T @ (inverse(E) @ A) @ back
            blocks[f"decay {i}"] = observer_decay(
                loop, C, P1, P2, Y, T.T @ Q_F, number(R_F)
            )
            blocks[f"cost {i}"] = observer_cost(
                left @ d.E @ T1, left @ number(noise) / unit, P1, J
            )
        return blocks

    def open(self):
        """The `LMIProblem` with L to be found and no bound of tr J."""
        return LMIProblem(LMIText(self.blocks, self.unknowns()))

    def gain(self, values):
        """L at ``values`` of the unknowns: L' = Y P1^-1 in the plant's coordinates."""
        Y = self.sizes[:, None] * values["Y"]
        return np.linalg.solve(self.T[0].T, np.linalg.solve(values["P1"], Y.T))

    def optimum(self):
        """The least tr J in the plant's units, and the `LMISolution`. Many observers
        may have it: of those that miss it by less than `AMID` times its accuracy it is
        the analytic centre, which neither units nor the order of vertices change.
        """
        problem = self.open()
        (J,) = (u for u in problem.unknowns if u.name == "J")
        best = problem.minimize(J, OPTIMUM_GAP)
        if best.values is None:
            return None, best
        least = float(np.trace(best.values["J"])) * self.unit**2
        nearly = (1 + AMID * OPTIMUM_GAP) * least
        amid = self.bounded(None, nearly).solve(refuse=False, start=best.values)
        return least, best if amid.values is None else amid

    def bounded(self, L, bound):
        """The `LMIProblem` of this L, None to be found, and a bound of tr J."""

        def write(values, number):
            return self.blocks(values, number, L, bound)

        return LMIProblem(LMIText(write, self.unknowns(L)))


class ObserverProof(ProofFile):
    """An exact proof of Theorem 2.5 at the vertices, or its failure; ``text`` is a
    file.
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
        """The data of the file for a ``problem``, a rounded ``L``, the ``bound`` of tr
        J and ``values``.
        """
        return {
            **problem.data(),
            "L": decimals(L),
            "bound": decimal(bound),
            "unknowns": {name: decimals(x) for name, x in values.items()},
        }


class ObserverRefusal(MultiplierRefusal):
    """Multipliers, in a file's ``text``, that exclude every observer by Theorem 2.5."""

    kind = "infeasible observer"

    @classmethod
    def contents(cls, problem):
        """The data of the file for a problem, without the multipliers."""
        return problem.data()


def refuse_observer(problem):
    """The `ObserverRefusal` of a ``problem``, an `ObserverProblem`, or None: he(A'P +
    C'Y) < 0 decides, where C e = 0, for P1, P2 and Y may be small and J large.
    """
    lmi, N = problem.open(), len(problem.T[0])
    whole = lmi.text.in_unknowns(rationals)
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
