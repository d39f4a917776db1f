"""The LMIs of a request in well conditioned coordinates, as an `LMIProblem`: where they
are solved, refused and measured, and a point becomes a `Solution` in the plant's units.
"""

from dataclasses import replace

import numpy as np

from ..language import Unknown, eye
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText, floats
from ..requirements.magnitudes import Magnitudes
from ..runtime.time_limit import check_time_of_eigenvalues
from ..solver.loop import margin
from .cutting import CUTTING_PLANE_ABOVE_PAIRS
from .pair_stacks import named_margins
from .payments import paid
from .scaling import in_unknowns_of
from .solution import Solution


class ScaledLMIs(LMIProblem):
    """The blocks of a ``request`` in a ``frame``. The levels (see `Parameter`) of the
    ``free`` requirements are unknowns, the last ones, in ``units`` by their parameters'
    names, estimated without; ``sizes`` has numbers for some of the unknown sizes, by
    name; ``pairs`` are those of the vertices whose blocks are written, all without it.
    """

    def __init__(self, request, frame, free=(), sizes=None, pairs=None, units=None):
        self.request, self.frame, self.free = request, frame, tuple(free)
        self.pairs = pairs
        self.sizes = dict(sizes or {})
        self.units = units or {
            r.parameter.key: Magnitudes(r, request, frame.owned(r)).level or 1.0
            for r in self.free
        }
        unknowns = request.unknowns(self.units)
        self.matrices = [u for u in unknowns if u.name not in self.sizes]
        levels = [Unknown(_level(name), 1) for name in self.units]
        super().__init__(LMIText(self.write, [*self.matrices, *levels]))

    def write(self, values, number):
        """All blocks from `BlockName` to matrix, at ``values`` and with data by
        ``number``.
        """
        return self.written_for(self.pairs, values, number)

    def written_for(self, pairs, values, number=floats):
        """The blocks of some ``pairs`` of vertices, at ``values`` and with data by
        ``number``.
        """
        (P, Y, V, own), levels = self.taken_apart(values, number)
        return self.request.blocks(P, Y, number, self.frame, V, levels, own, pairs)

    def taken_apart(self, values, number=floats):
        """(P, Y, V, own) and levels of ``values``, as `Request.blocks` takes them, by
        ``number``.
        """
        values = {**values, **self.sizes}
        levels = {
            name: values.pop(_level(name)) * number(np.array(unit)).item()
            for name, unit in self.units.items()
        }
        return self.request.taken_apart(values, number, self.frame), levels

    def of_pairs(self, pairs):
        """The same LMIs for some of the pairs of vertices."""
        return ScaledLMIs(
            self.request, self.frame, self.free, self.sizes, pairs, self.units
        )

    def _limited(self, work, first=None):
        return work()  # `guarded` limits the time of a whole request

    def refuse(self, Z):
        """The file of exact multipliers from ``Z``, one for each block: see
        `refuse_design`.
        """
        if self.free:  # a file speaks of numbers
            return super().refuse(Z)
        from .proofs import refuse_design

        return refuse_design(self.request, self.frame, Z, self.pairs)

    def limit(self):
        """The LMIs, in the unknown `matrices`, that remain where the free levels exceed
        all bounds. A level is added to some rows of a block's diagonal: what is left of
        the block without these rows is all that large levels leave of it.
        """
        kept, levels = {}, self.unknowns[len(self.matrices) :]
        for name, g in self.text.expressions.items():
            raised = sum(abs(g.jacobian(u)[0]) for u in levels).any(axis=0)
            if not raised.all():
                kept[name] = eye(len(raised))[~raised]

        def write(values, number):
            values = {**values, **{u.name: number(np.zeros(u.shape)) for u in levels}}
            blocks = self.text.blocks(values, number)
            return {name: some @ blocks[name] @ some.T for name, some in kept.items()}

        return LMIProblem(LMIText(write, self.matrices))

    def guess(self):
        """Unknowns to start from, by name: the frame's gain, else I; None without one.
        In the frame the Riccati equation's P is I, and so is a slack matrix near it.
        """
        frame, one = self.frame, np.eye(self.request.order)
        values = dict.fromkeys(("V", *self.request.lyapunov), one)
        values |= {"Y": frame.gain} | dict.fromkeys(frame.sizes, np.eye(1))
        if frame.gain is None or any(u.name not in values for u in self.unknowns):
            return None
        return {u.name: values[u.name] for u in self.unknowns}

    def free_directions(self):
        """Directions in which the points may have no end, (k,) arrays: a mode v of the
        plant that lies where it is asked without any input lets P grow by v v* forever,
        unless something else bounds P.
        """
        request, frame = self.request, self.frame
        if len(request.vertices) > 1 or request.gain is not None:
            return
        (d,) = request.ground.at(frame)
        A, *_ = d.state_space()
        check_time_of_eigenvalues(len(A))
        modes, vectors = np.linalg.eig(A)
        zero = {u.name: np.zeros(u.shape) for u in self.unknowns}
        for k in np.argsort(modes.real):
            if modes[k].imag >= 0:
                grown = np.outer(vectors[:, k], vectors[:, k].conj()).real
                yield self.text.packed(zero | dict.fromkeys(request.lyapunov, grown))

    def bounds(self, values):
        """The bounds of the free requirements at ``values``, by parameter: the unknown
        is the level times the requirement's size.
        """
        bounds = {}
        for r in self.free:
            key = r.parameter.key
            level = values[_level(key)] * self.units[key]
            level = (level / values.get(r.size_name, 1.0)).item()
            bounds[key] = r.parameter.bound(level)
        return bounds

    def weights(self, objective):
        """Those of the variables in the sum of levels with weights ``objective``."""
        cost = np.zeros(sum(u.size for u in self.unknowns))
        cost[-len(self.units) :] = [
            objective[name] * unit for name, unit in self.units.items()
        ]
        return cost / cost.max()

    def joined(self, values, sizes):
        """The unknowns at a point of ``values`` that was found with numbers for some
        ``sizes``: these multiply the own unknowns of a requirement here, and its level.
        """
        values = values | {name: np.array([[s]]) for name, s in sizes.items()}
        names = [(r, u.name) for r, u in self.request.owned]
        names += [(r, _level(r.parameter.key)) for r in self.free]
        for r, name in names:
            values[name] = values[name] * sizes.get(r.size_name, 1.0)
        return values

    # from the frame to the plant's units, and back

    def gain(self, values):
        """K in the plant's own units, of the ``values`` of the unknowns by name."""
        if self.request.gain is not None:
            return self.request.gain
        right = self.request.coupling.divisor(values)
        K = np.linalg.solve(right, values["Y"].T).T
        return np.linalg.solve(self.frame.T.T, K.T).T * self.frame.scale

    def solution(self, values, request=None):
        """The `Solution` at ``values`` of the unknowns, for the same ``request`` or one
        with other bounds, which the point keeps, too.
        """
        request = request or self.request
        natural = self.in_plant_units(values)
        K, P, Y, V, own = (natural[name] for name in ("K", "P", "Y", "V", "own"))
        many = (
            len(request.pairs) > CUTTING_PLANE_ABOVE_PAIRS
            and request.ground.near is None
        )
        if V is None and many:
            margins = named_margins(request, P, Y, own)
        else:
            blocks = request.blocks(P, Y, V=V, own=own)
            blocks = paid(request, blocks, P, Y, own)
            margins = {name: margin(g) for name, g in blocks.items()}
        good = min(margins.values()) > 1e-9
        if not good:  # too close for floats, even for the sign of what remains
            from .proofs import prove

            proof = prove(request, K, P, 17, V, own)
            good, margins = proof.proven, proof.margins() or margins
        status = "feasible" if good else "undecided"
        return Solution(request, status, K, P, Y, V, margins, self.frame, own=own)

    def in_plant_units(self, values):
        """K, P, Y, V and own of ``values`` in the plant's units, as in `Solution`. P is
        that of the last requirement in `Sizes.fixing`; the sizes are relative to it.
        """
        request, frame, K = self.request, self.frame, self.gain(values)
        one = np.ones((1, 1))
        size = {
            r.size_name: values.get(r.size_name, one).item()
            for r in request.sizes.fixing
        }
        natural = {n: s / frame.sizes.get(n, 1.0) ** 2 for n, s in size.items()}
        *others, shrink = natural.values() or [1.0]
        T, coupling = frame.T, request.coupling
        P = [T @ values[name] @ T.T / shrink for name in request.lyapunov]
        P = [(p + p.T) / 2 for p in P]
        V = T @ values["V"] @ T.T / shrink if "V" in values else None
        own = {
            u.name: values[u.name]
            / size.get(r.size_name, 1.0)
            * frame.own.get(u.name, 1.0)
            for r, u in request.owned
        }
        if not request.sizes.ties:
            own.update({n: np.array([[s / shrink]]) for n, s in zip(natural, others)})
        Y = K @ coupling.divisor({"P": P[0], "V": V}).T
        return dict(K=K, P=np.asarray(coupling.given(P)), Y=Y, V=V, own=own)

    def point(self, solution):
        """The unknowns at a ``solution`` of the same shape and unknowns, whose bounds
        are those of its request, by name; None if it lacks some. The inverse of
        `in_plant_units`.
        """
        values = in_unknowns_of(self.request, self.frame, solution, self.units)
        for r in self.free if values is not None else ():
            key, size = r.parameter.key, values.get(r.size_name, np.ones((1, 1)))
            level = solution.request.owner(key).bound ** r.parameter.power
            values[_level(key)] = level / self.units[key] * size
        if values is None or any(
            np.shape(values[u.name]) != u.shape for u in self.unknowns
        ):
            return None
        return {u.name: values[u.name] for u in self.unknowns}

    def led(self, values, request):
        """A point of free levels, ``values``, as one of the same ``request`` with
        bounds that it keeps: the LMIs in a frame in which the unknown P is that of
        `Sizes.leader`, and their unknowns by name, all divided by the leader's size.
        """
        frame, leader = self.frame, request.sizes.leader()
        before = request.sizes.leader(self.units)
        if leader is not before and request.sizes.followers(leader):
            values = values | {before.size_name: np.ones((1, 1))}
            size, unit = values[leader.size_name].item(), frame.sizes[leader.size_name]
            units = {before.size_name: 1.0} | frame.sizes
            followers = [r.size_name for r in request.sizes.followers(leader)]
            frame = replace(
                frame.times(unit),
                sizes={name: units[name] / unit for name in followers},
            )
            values = {name: x / size for name, x in values.items()}
        lmis = ScaledLMIs(request, frame)
        return lmis, {u.name: values[u.name] for u in lmis.unknowns}


def _level(name):
    return f"level of {name}"
