"""The LMIs with free multipliers of one requirement, for some loops of a known gain."""

from functools import cached_property

import numpy as np
from scipy.linalg import matrix_balance

from ..analysis.riccati import lyapunov
from ..exact.definite import definite, exact, round_digits
from ..exact.proof import PLACES
from ..language import Unknown, eye
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText, floats
from ..requirements.known_gain import KnownVertex
from ..solver.loop import margin

FROM_STATES = 20  # of a smaller loop the search takes less than half a second
SMALL = 10.0 ** np.arange(-9, 0, 2)  # of G, beside F
DEFECTIVE = 1e-5  # the size of a state in all modes, beside the largest


class KnownLMIs(LMIProblem):
    """The blocks that a ``requirement`` writes at some ``loops``, the vertices, in
    coordinates in which P is near I, x = ``T`` xi if known.
    """

    def __init__(self, requirement, loops, T=None):
        self.requirement = requirement
        self.loops = loops = [loop.seen_by(requirement) for loop in loops]
        self.T, self.left, self.rate = coordinates(loops, T)
        N, k = len(self.T), requirement.multiplier_rows
        self.lyapunov = [Unknown(f"P {i + 1}", N, symmetric=True) for i in self._each]
        multipliers = [Unknown(name, k * N) for name in "FG"]
        probe = KnownVertex(loops[0], eye(N), eye(N), eye(N), left=self.left, T=self.T)
        own = requirement.known_gain_unknowns(probe)
        self.units = {u.name: float(round_digits(x, 2)) for u, x in own.items()}
        self.units["G"] = 1 / self.rate  # F is near P E^-1, G near it a time ago
        super().__init__(LMIText(self.write, [*self.lyapunov, *multipliers, *own]))

    @property
    def _each(self):
        return range(len(self.loops))

    def write(self, values, number):
        """The blocks by name, each scaled by the even loop's, at ``values`` and with
        data by ``number``; see `LMIText`.
        """
        blocks = self._written(values, number, self._vertex)
        return {name: self._scaled(name, g) for name, g in blocks.items()}

    def _written(self, values, number, vertex):
        vertices = (vertex(values, number, i) for i in self._each)
        return _blocks(self.requirement, vertices)

    def _vertex(self, values, number, i):
        """A vertex in these coordinates."""
        scaled = {n: values[n] * self.units.get(n, 1.0) for n in values}
        P, F, G, own = _taken(scaled, self.lyapunov[i].name)
        return KnownVertex(self.loops[i], P, F, G, own, number, self.left, self.T)

    @cached_property
    def _scales(self):
        """From a block's name to the diagonal that its rows are divided by."""
        N = len(self.T)
        at = {u.name: np.eye(*u.shape) for u in self.unknowns}

        def even(values, number, i):
            c = self._vertex(values, number, i)
            _, _, *rest = c.matrices
            vars(c)["matrices"] = np.eye(N), -self.rate * np.eye(N), *rest
            return c

        blocks = self._written(at, floats, even)
        sizes = {name: np.abs(np.diagonal(g)) for name, g in blocks.items()}
        return {
            name: 2.0 ** np.round(np.log2(np.where(d > 0, d, 1.0)) / 2)
            for name, d in sizes.items()
        }

    def _scaled(self, name, g):
        turn = np.diag(1 / self._scales[name])
        return turn @ g @ turn

    def even(self):
        """Values with P and F one in these coordinates, and G as small as lets the
        margin be the largest: of one large loop they may do without a search, whose
        F and G have hundreds of entries. None where there are other unknowns.
        """
        small = len(self.T) < FROM_STATES
        if small or len(self.loops) > 1 or self.unknowns[-1].name != "G":
            return None
        one = {u.name: np.eye(*u.shape) for u in self.unknowns}
        several = [one | {"G": size * one["G"]} for size in SMALL]
        return max(several, key=self.margin)

    def margin(self, values):
        """The smallest eigenvalue at ``values`` of all blocks, scaled to ones."""
        return min(map(margin, self.text.blocks(values).values()))

    def rounded(self, values):
        """Rounded ``values`` in the plant's own coordinates at which all blocks in
        rationals are definite; None if they aren't.
        """
        natural = {name: self._natural(name, x) for name, x in values.items()}
        for places in PLACES:
            rounded = {n: round_digits(x, places) for n, x in natural.items()}
            certain = {n: exact(x) for n, x in rounded.items()}
            blocks = rational_blocks(self.requirement, self.loops, certain)
            if all(definite(g)[0] for g in blocks.values()):
                return rounded
        return None

    def _natural(self, name, x):
        """An unknown in the plant's own coordinates."""
        back, N = np.linalg.inv(self.T), len(self.T)
        x = x * self.units.get(name, 1.0)
        if name.startswith("P "):
            x = back.T @ x @ back
            return (x + x.T) / 2
        if name in ("mu", "J"):
            return x
        one = np.eye(len(x) // N)  # a multiplier
        return np.kron(one, back.T) @ x @ np.kron(one, self.left)


def rational_blocks(requirement, loops, values):
    """The blocks of a ``requirement`` at ``loops`` and rational ``values`` by name."""
    taken = (_taken(values, f"P {i}") for i, _ in enumerate(loops, 1))
    return _blocks(
        requirement, (KnownVertex(x, *v, exact) for x, v in zip(loops, taken))
    )


def with_means(requirement, loops, some, means):
    """Decimals that keep a ``requirement`` at all ``loops``, from ``some`` and the
    ``means``, whose P have the weights of `bernstein.means`; or None.
    """
    stay = (k for k in range(len(loops)) if k not in means)
    P = {k: some[f"P {i}"] for i, k in enumerate(stay, 1)}
    P |= {k: sum(float(w) * P[i] for i, w in x.items()) for k, x in means.items()}
    values = {f"P {k + 1}": P[k] for k in sorted(P)}
    values |= {name: x for name, x in some.items() if name[:2] != "P "}
    certain = {name: exact(x) for name, x in values.items()}
    loops = [loop.seen_by(requirement) for loop in loops]
    blocks = rational_blocks(requirement, loops, certain)
    return values if all(definite(g)[0] for g in blocks.values()) else None


def _blocks(requirement, vertices):
    blocks = {}
    for i, c in enumerate(vertices, 1):
        blocks[f"P {i}"] = c.P
        for name, g in requirement.known_gain(c):
            blocks[f"{name} {i}".strip()] = g
    return blocks


def _taken(values, name):
    """P, F, G and the others of some values, for the vertex whose P has this name."""
    own = {n: x for n, x in values.items() if n[:2] != "P " and n not in "FG"}
    return values[name], values["F"], values["G"], own


def coordinates(loops, T=None):
    """T, left and a rate: in x = T xi, rows times left, the ``loops`` have P near I. T
    is that of Lyapunov's equation of the mean loop, slowed down or sped up a little, if
    none is known; E of the mean is I.
    """
    E, A = (sum(d.in_floats[k] for d in loops) / len(loops) for k in (0, 1))
    quotient = np.linalg.solve(E, A)
    poles, vectors = np.linalg.eig(quotient)
    rate = float(np.median(np.abs(poles))) or 1.0
    if T is None:
        T = _by_lyapunov(quotient, poles, vectors, rate)
    T = T / np.linalg.norm(T, 2)
    return T, np.linalg.inv(E @ T), rate


def _by_lyapunov(quotient, poles, vectors, rate):
    """T that makes P of Lyapunov's equation I, for x' = ``quotient`` x."""
    fastest = poles.real.max()
    shift = 0.9 * fastest if fastest < 0 else fastest + 0.1 * rate
    size = _sizes(quotient, vectors)
    try:
        slower = quotient - shift * np.eye(len(quotient))
        P = lyapunov(slower.T, -np.diag(size**-2.0))
        return np.linalg.inv(np.linalg.cholesky((P + P.T) / 2)).T
    except np.linalg.LinAlgError:
        return np.diag(size)


def _sizes(A, vectors):
    """How large the states of x' = ``A`` x are in its modes, the eigenvectors; by A's
    entries, in powers of two, where these ``vectors`` are nearly those of fewer modes:
    in a Jordan block some states would seem to have no size.
    """
    with np.errstate(all="ignore"):  # entries that no float holds side by side
        balance = matrix_balance(A, permute=False, separate=True)[1][0]
    if not (np.isfinite(balance).all() and balance.min() > 0):
        balance = np.ones(len(A))
    relative = vectors / balance[:, None]
    relative = np.linalg.norm(relative / np.linalg.norm(relative, axis=0), axis=1)
    if relative.min() < DEFECTIVE:
        return balance
    return np.maximum(np.linalg.norm(vectors, axis=1), 1e-12)
