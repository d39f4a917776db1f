"""The slow modes of a plant as a smaller plant, whose LMIs are refused.

Let W A = L W E with real W of full rank, for the plant E x' = A x + B u. Multiplied by
W and W', a solution of the design LMIs of the plant is one for (L, W B): a design for
the plant contains one for each of its modes, as if that alone had the whole actuator.
Modes are irrational: `sosbook.exact.checker.modes` encloses them.

Without it every refusal of a whole wing in chapter 17 would be "undecided". There are
no other multipliers where the fast modes have LMIs that can be solved: those of all
modes are zero there, so that they see the slow modes alone.
"""

from dataclasses import dataclass

import numpy as np
from flint import acb_mat, arb_mat, ctx
from scipy.linalg import block_diag

from ..exact.definite import exact, inverse
from ..exact.rational import decimal, decimals, read_number
from ..exact.refusal import MultiplierRefusal
from ..plants.descriptor_system import DescriptorSystem
from ..synthesis.proofs import frame_data
from .proofs import problem_data

__all__ = ["Modes", "ModesRefusal", "slow_modes"]

BITS = 256  # of the modes, before they are rounded to floats
TINY = 1e-30  # of the fastest mode: what is smaller is zero
FAR = 0.1  # from an inverse: the modes are nearly dependent
NEARER = 0.99  # of the part's distance from the other modes: the checker measures it


@dataclass(frozen=True, eq=False)
class Modes:
    """Some modes of a plant, the ``part``, and its ``others``, in floats near to them.

    Of each real mode or pair (L, R, C): its block L, [a, -b; b, a] or [a], its rows R
    and its columns C, nearly with R E C = 1 and R A C = L; ``B``: the part's input.
    """

    part: list
    others: list
    B: np.ndarray

    def __str__(self):
        return _words(map(_eigenvalue, self.part))

    def plant(self):
        """The `DescriptorSystem` of the part."""
        A = block_diag(*(L for L, *_ in self.part))
        return DescriptorSystem(np.eye(len(A)), A, self.B)

    def contents(self):
        """The numbers that a file has of them."""
        whole = [*self.part, *self.others]
        own, others = (list(map(_eigenvalue, x)) for x in (self.part, self.others))
        gap = min((abs(a - b) for a in own for b in others), default=1.0)
        return {
            "spectrum": decimals([[s.real, s.imag] for s in own + others]),
            "rows": decimals(np.vstack([R for _, R, _ in whole])),
            "columns": decimals(np.hstack([C for *_, C in whole])),
            "push": decimals(self.B),
            "gap": decimal(float(f"{NEARER * gap:.3g}")),
        }


def slow_modes(vertex, rate):
    """The modes of a plant, ``vertex``, that are slower than a ``rate`` in 1/s.

    Yields the integrators with each slow mode, the slowest first, and then with all of
    them.
    """
    every = sorted(_modes(vertex), key=lambda mode: -_eigenvalue(mode).real)
    values = list(map(_eigenvalue, every))
    idle = [k for k, s in enumerate(values) if s == 0]
    slow = [k for k, s in enumerate(values) if s != 0 and s.real > -rate]
    for some in [[k] for k in slow] + [slow] * (len(slow) > 1):
        chosen = [*some, *idle]
        part = [every[k] for k in chosen]
        others = [mode for k, mode in enumerate(every) if k not in chosen]
        yield Modes(part, others, np.vstack([R for _, R, _ in part]) @ vertex.Bu)


def _modes(vertex):
    """(L, R, C) of each real mode or pair; none where they are nearly dependent."""
    back = inverse(exact(vertex.E))
    A = back @ exact(vertex.A)
    with ctx.workprec(BITS):
        values, right = acb_mat(_arb_mat(A)).eig(right=True, algorithm="approx")
        near = [complex(s.mid()) for s in values]
        tiny, blocks, columns = TINY * max(map(abs, near)), [], []
        for j, s in enumerate(near):
            if s.imag < -tiny:
                continue
            v = [right[i, j].mid() for i in range(len(A))]
            pivot = max(v, key=lambda e: float(abs(e)))
            v = [(e / pivot).mid() for e in v]
            columns.append([e.real for e in v])
            a = s.real if abs(s.real) > tiny else 0.0
            blocks.append(np.array([[a]]))
            if s.imag > tiny:
                columns.append([-e.imag for e in v])
                blocks[-1] = np.array([[a, -s.imag], [s.imag, a]])
        C = arb_mat(columns).transpose()
        try:
            R, C = map(_middle, (C.inv() * _arb_mat(back), C))
        except (ValueError, ZeroDivisionError):  # they aren't N, or dependent
            return []
    good = np.isfinite(R).all() and np.isfinite(C).all()
    if not good or abs(R @ vertex.E @ C - np.eye(len(C))).max() > FAR:
        return []
    modes, end = [], 0
    for L in blocks:
        own = slice(end, end := end + len(L))
        long = np.sqrt(np.linalg.norm(R[own]) / np.linalg.norm(C[:, own]))
        modes.append((L, R[own] / long, C[:, own] * long))
    return modes


def _eigenvalue(mode):
    (a, *_), *rest = mode[0]
    return complex(a, rest[0][0] if rest else 0.0)


def _middle(x):
    return np.array([[float(e.mid()) for e in row] for row in x.tolist()])


def _arb_mat(x):
    return arb_mat(*x.shape, x.ravel().tolist())


def _words(eigenvalues):
    return ", ".join(
        f"{s.real:.4g} ± {s.imag:.4g}j" if s.imag else f"{s.real:.4g}"
        for s in eigenvalues
    )


class ModesRefusal(MultiplierRefusal):
    """Multipliers that exclude a design for some modes of a plant alone.

    Its ``text`` is a file with the plant, numbers near its modes and multipliers for
    these, which exclude all modes near them, too.
    """

    kind = "infeasible delay modes"

    @property
    def part(self):
        """Which part of the plant the multipliers are about, in words."""
        data = self.data
        modes = [complex(*map(read_number, s)) for s in data["spectrum"]]
        ends = np.cumsum([1 + (s.imag != 0) for s in modes]).tolist()
        own = modes[: ends.index(len(data["push"])) + 1]
        return f"the modes {_words(own)} alone"

    @classmethod
    def contents(cls, request, vertex, modes, small, Z):
        """The data of a ``request``'s file for ``modes`` of a ``vertex``.

        It counts from 0; ``small`` is the same request for the numbers near the modes,
        which exact multipliers Z exclude.
        """
        room, Z = _with_room(Z)
        data = {
            **problem_data(request),
            "K": None,
            "coordinates": frame_data(small.frame),
            "vertex": vertex,
            **modes.contents(),
            "room": decimal(room),
        }
        return cls.written_from(data, Z, str)


def _with_room(Z):
    """(room, multipliers) of blocks that have more room, see `Modes` of the checker;
    from exact multipliers Z of those that have none. Half of what they leave is taken.
    """
    floats = {name: z.astype(float) for name, z in Z.items()}
    least = min(np.linalg.eigvalsh(z)[0] for z in floats.values())
    decays = [name for name in Z if name.startswith("decay")]
    room = float(f"{max(least, 0) / 2 / sum(floats[x].trace() for x in decays):.1e}")
    price = {
        x: exact(room) * Z[x].trace() / (1 + len(Z[x]) * exact(room)) for x in decays
    }
    whole = sum(price.values())
    less = {x: price.get(x, whole) * exact(np.eye(len(z))) for x, z in Z.items()}
    return room, {x: z - less[x] for x, z in Z.items()}
