"""The loops of a law as its gain moves, in floats, and units of that gain."""

from dataclasses import replace
from functools import cached_property
from itertools import product

import numpy as np

from ...exact.rational import exact
from ...laws.base import plain
from ...plants.descriptor import MATRICES
from ..ranges import Ranges

TINY = 1e-9  # of the largest entry of G: below it a sensor doesn't see an input


class MovingGain:
    """x' = (A + B K C_y) x + (W + B K D_y) w, and what requirements see of it, of
    ``plants`` in floats, joined with the law's states. ``measured`` and ``noisy``, (q,
    N) and (q, p), are C_y and D_y, and ``form`` says which gains are free.
    """

    def __init__(self, plants, measured, noisy, form):
        self.plants, self.form = plants, form
        self.measured, self.noisy = measured, noisy
        self.directions, self.first = form.directions, form.first
        self._channels = {}

    def __len__(self):
        return len(self.plants)

    def with_more(self, plants):
        """The same with some ``plants`` more."""
        return MovingGain([*self.plants, *plants], self.measured, self.noisy, self.form)

    @cached_property
    def matrices(self):
        """A, B and W, each a stack: E is divided out."""
        solved = [
            np.linalg.solve(d.E, np.hstack([d.A, d.Bu, d.Bw])) for d in self.plants
        ]
        N, m = self.plants[0].Bu.shape
        return np.split(np.array(solved), [N, N + m], axis=2)

    def channel(self, r, m):
        """The stacks of W, C, D, D_w, and D_y, as ``r`` sees them, of ``m`` inputs u:
        the output knows no v.
        """
        if r.key not in self._channels:
            own = []
            for d in self.plants:
                Du = None if d.Du is None else d.Du[:, :m]
                one = r.seen(replace(d, Bu=d.Bu[:, :m], Du=Du)).explicit()
                size, rest = len(one.C), d.Bu.shape[1] - m
                D = np.zeros((size, m)) if one.Du is None else one.Du
                D = np.hstack([D, np.zeros((size, rest))])
                W = np.linalg.solve(one.E, one.Bw)
                through = np.zeros((size, W.shape[1])) if one.Dw is None else one.Dw
                own.append((W, one.C, D, through))
            some = slice(None) if r.inputs is None else list(r.inputs)
            stacks = [np.array(x) for x in zip(*own)]
            self._channels[r.key] = (*stacks, self.noisy[:, some])
        return self._channels[r.key]

    def K(self, kappa):
        """The gain of the free numbers ``kappa``."""
        rows = self.directions.reshape(len(self.directions), -1)
        return self.first + np.dot(kappa[None], rows).reshape(self.first.shape)

    def slope(self, S):
        """The derivative in kappa, from ``S``, that in K."""
        return np.einsum("kij,ij->k", self.directions, S)

    def closed(self, K):
        """The stack A + B ``K`` C_y."""
        A, B, *_ = self.matrices
        return A + B @ (K @ self.measured)

    def descriptor(self, i, K, m):
        """The loop ``i`` under ``K``, ``m`` inputs left open, and its state gain."""
        d = self.plants[i]
        pushed, through = d.Bu[:, m:] @ K[m:], K[:m] @ self.noisy
        Du, Dw = d.Du, d.Dw
        if Du is not None:
            Du = Du[:, :m]
            Dw = Du @ through if Dw is None else Dw + Du @ through
        loop = replace(
            d,
            A=d.A + pushed @ self.measured,
            Bu=d.Bu[:, :m],
            Bw=d.Bw + pushed @ self.noisy + d.Bu[:, :m] @ through,
            Du=Du,
            Dw=Dw,
        )
        return loop, K[:m] @ self.measured

    def sizes(self, s):
        """Units of u and y: in them the plant's answer at a real ``s`` is about one, by
        Sinkhorn's scaling of its entries' logarithms: covariant in every unit.
        """
        A, B, *_ = (x.mean(axis=0) for x in self.matrices)
        point = self.beside_poles(s) * np.eye(len(A))
        G = np.abs(self.measured @ np.linalg.solve(point - A, B))
        seen = np.argwhere(G > TINY * G.max(initial=0))
        q, m = G.shape
        rows, right = np.zeros((len(seen), q + m)), np.zeros(len(seen))
        for k, (j, i) in enumerate(seen):
            rows[k, j], rows[k, q + i] = 1.0, -1.0
            right[k] = np.log(G[j, i])
        logs = np.linalg.lstsq(rows, right, rcond=None)[0]
        return np.exp(logs[q:]), np.exp(logs[:q])

    def units(self, s):
        """The unit of each free number at a real s."""
        of_u, of_y = self.sizes(s)
        each = np.log(np.outer(of_u, 1 / of_y))
        weights = (self.directions != 0) + 0.0
        return np.exp((weights * each).sum(axis=(1, 2)) / weights.sum(axis=(1, 2)))

    @cached_property
    def poles(self):
        """Of the mean plant and the law."""
        return np.linalg.eigvals(self.matrices[0].mean(axis=0))

    def beside_poles(self, s):
        """The real ``s``, or the next one above, in steps of a half, that no pole is
        near. At an unstable pole the plant's answer is infinite, and says nothing of
        units; a pendulum's only rate is one. A quarter of s is far enough for a factor
        of four.
        """
        while (np.abs(self.poles - s) < s / 4).any():
            s *= 1.5
        return s

    @cached_property
    def rates(self):
        """The slowest and the fastest pole of the mean plant and the law, in rad/s."""
        sizes = np.abs(self.poles)
        sizes = sizes[sizes > 1e-6 * sizes.max(initial=0)]
        if not len(sizes):  # free masses and integrators: any rate will do
            return 1.0, 1.0
        return float(sizes.min()), float(sizes.max())


def corners_of(request):
    """Plants of a ``request`` with a law: their `Descriptor` in rationals, by name.
    They are the vertices that differ, or the corners of the ranges: with powers of
    parameters a vertex needn't be a plant of the family.
    """
    family = request.plant.family
    if family is None:
        vertices, several = plain(request.plant, request.K_A), request.distinct
        return {
            f"the vertex {i + 1}" if len(several) > 1 else "the plant": vertices[i]
            for i in several
        }
    ranges = Ranges(request)
    return {
        ranges.point_words(p): plain(family.exactly_at(p), request.K_A)[0]
        for p in product(*zip(family.box.low, family.box.high))
    }


def loops_of(request):
    """The `MovingGain` of a request with a law, of its corners."""
    parts, form = request.applied.parts, request.law.structure(request.plant)
    joined = [parts.joined(d).map(_float) for d in corners_of(request).values()]
    return MovingGain(joined, _float(parts.measured), _float(parts.noisy), form)


def _float(x):
    return np.asarray(exact(x), float)


def vertex_of(request, d, asked=()):
    """The part ``asked`` of the plant of a ``request`` without its law, and the vertex
    that is its corner ``d``.
    """
    one = replace(request, law=None, gain=None, requirements=asked, coupling="vertices")
    for k in range(len(one.vertices)):
        (v,) = one.vertices_in(exact, [k])
        if all((getattr(v, x) == getattr(d, x)).all() for x in MATRICES[:4]):
            return one, k
    raise AssertionError("a corner of a plant is one of its vertices")
