"""The search for cells of plants and clocks that prove a sampled loop."""

from dataclasses import replace

import numpy as np
from scipy.linalg import matrix_balance

from ..exact.definite import round_digits
from ..exact.rational import decimals
from ..language import Unknown, block, eye, he, kron
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText
from ..runtime.time_limit import check_time
from .balls import middle
from .cells import PlantCell
from .channel import equalled, joined_P, root, too_large
from .lyapunov import discrete_lyapunov
from .proof_file import undecided

__all__ = ["cover", "lyapunov", "too_slow"]

LYAPUNOV_DIGITS = 12  # significant decimal digits of the rounded matrices
ROUNDS = 12  # times that clocks which a P doesn't hold for join the search for it
DEPTH = 8  # times that a cell is halved for one set of Lyapunov matrices
PARTS = 1, 1 / 16, 1 / 256  # of W, for a cell, and for halves and quarters of its edges
HOPELESS = 4.0  # W's trace, times r^2 N, above which no multiplier is looked for


def cover(family, clocks, rate, budget):
    """(tree, failed) of `certify_sampled`, see `SampledProof`: a ``family`` of
    loops decays at a ``rate`` with a `TimeBox` of ``clocks``; at most a ``budget`` of
    cells is cut.
    """
    search = _Search(family, clocks, rate, budget)
    shape, tree = family.shape, {}
    queue = [(shape.whole(), tree)]
    while queue:
        check_time()
        weights, node = queue.pop()
        try:
            leaf, trouble, far = search.leaf(weights)
        except ZeroDivisionError:
            near = search.near(weights)
            return None, f"a plant of the polytope has no regular mass: near {near}"
        if trouble:
            return None, trouble
        if leaf:
            node.update(leaf)
            continue
        search.budget -= 1
        if len(shape.corners) == 1 or len(queue) + 2 > search.budget:
            few = budget if search.starved or len(shape.corners) > 1 else 0
            return None, f"{search.around(weights)}: {undecided(few)}"
        cut = _longest(shape, weights, far)
        node.update(halve=cut, halves=[{}, {}])
        queue += zip(shape.halves(weights, cut), node["halves"])
    return tree, ""


class _Search:
    """The search through one cell of plants after the other."""

    def __init__(self, family, clocks, rate, budget):
        self.family, self.clocks, self.rate = family, clocks, rate
        self.budget, self.starved = budget, False
        self.timings = [t for t in clocks.corners if t.remainder <= t.T]

    def near(self, weights):
        """Where a cell is, by the weights of the plant's vertices."""
        mean = np.zeros(weights.shape[1])
        mean[self.family.shape.order] = weights.astype(float).mean(axis=0)
        return "weights " + np.array2string(mean, np.inf, precision=3, separator=", ")

    def around(self, weights):
        """The same, for a cell about a place."""
        if len(self.family.shape.corners) == 1:
            return "the plant"
        return self.near(weights).replace("weights", "weights around", 1)

    def leaf(self, weights):
        """(leaf, trouble, far): what the tree has at a cell of plants.

        The ``leaf`` is None where there is none, ``trouble`` says why no cell has
        one, ``far`` is how far apart the corners are.
        """
        for _ in range(ROUNDS):
            loops = self._loops(weights, self.timings)
            if trouble := self._too_slow(weights, loops):
                return None, trouble, None
            L = self._coordinates(loops)
            inside = [[_within(F, L) for F in row] for row in loops]
            row = np.array(inside[0])
            far = np.linalg.norm(row[:, None] - row, 2, axis=(2, 3))
            last = int(np.argsort(far.sum(axis=0), kind="stable")[0])
            cell = PlantCell(self.family, weights, L, self.clocks, last)
            found, timing = self._alone(cell)
            plain = not (self.clocks.varies or self.family.held)
            if found is None and len(weights) > 1 and plain:
                L = lyapunov(loops[0], self.rate, centred=False)  # a plant bends less
                other = PlantCell(self.family, weights, L, self.clocks, last)
                found, _ = self._alone(other)
            if found is None and len(weights) > 1 and timing is None:
                found, timing = self._with_multipliers(cell, inside)
            if found is not None:
                return found, "", far
            if timing is None or timing in self.timings:
                return None, "", far
            self.timings.append(timing)
        return None, "", far

    def _loops(self, weights, timings):
        return [[middle(self.family.loop(w, t)) for w in weights] for t in timings]

    def _too_slow(self, weights, loops):
        """Which plant is too slow for one clock, or for two in turn; or nothing."""
        one = len(self.family.shape.corners) == 1
        k = self.family.held
        whole, N = loops, len(loops[0][0]) - k
        loops = [[F[:N, :N] for F in row] for row in loops]
        for j, (row, timing) in enumerate(zip(loops, self.timings)):
            for i, w in enumerate(weights):
                where = "the plant" if one else self.near(w[None])
                trouble = too_slow(row[i], self.rate, self.family.centre)
                trouble = trouble or too_large(whole[j][i], k)
                if trouble and timing.follows(timing):
                    clock = f", {timing.words}" * self.clocks.varies
                    return f"{where}{clock}: {trouble}"
                for other, before in zip(loops[:j], self.timings):
                    both = row[i] @ other[i]
                    if not (timing.follows(before) and before.follows(timing)):
                        continue
                    if trouble := too_slow(both, self.rate**2):
                        clocks = f"{before.words} and {timing.words} in turn"
                        return f"{where}, {clocks}: {trouble}"
        return ""

    def _coordinates(self, loops):
        if k := self.family.held:
            return _storage([F for row in loops for F in row], k)
        if not self.clocks.varies:
            return lyapunov(loops[0], self.rate)
        means = [sum(row) / len(row) for row in loops]
        L = _balanced(sum(means) / len(means))
        inside = [_within(F, L) for row in loops for F in row]
        return round_digits(_common(inside, self.rate) @ L, LYAPUNOV_DIGITS)

    def _with_multipliers(self, cell, inside):
        """As `_times`, with P at each corner and G that an LMI finds."""
        try:
            bent = [cell.expected(timing) for timing in self.timings]
        except ZeroDivisionError:  # the cell is too large to see that E is regular
            return None, None
        size = len(cell.L) * self.rate**2
        if not all(W is None or np.trace(W) <= HOPELESS * size for W in bent):
            return None, None  # too much, or beyond floats
        for share in PARTS:
            part = [None if W is None else share * W for W in bent]
            P, G = _multipliers(inside, part, self.rate, self.family.held)
            if P is not None:
                return self._parts(replace(cell, P=P), [*G, None])
        return None, None

    def _parts(self, cell, multipliers):
        """As `_times`, for a cell or for its halves with the P that it has."""
        tree, budget, whole = {}, self.budget, cell
        queue = [(cell, tree, 0)]
        while queue:
            check_time()
            cell, node, depth = queue.pop()
            times, timing = self._times(cell, multipliers)
            if times is not None:
                node.update(times)
                continue
            if (
                timing is not None
                or depth == DEPTH
                or len(queue) + 2 > self.budget
                or not all(self._holds(cell, t, multipliers) for t in self.timings)
            ):
                self.budget = budget
                return None, timing
            self.budget -= 1
            cut = cell.widest(self.timings[-1])
            node.update(halve=cut, halves=[{}, {}])
            queue += zip(cell.halves(cut), node["halves"], (depth + 1,) * 2)
        return _leaf(whole) | tree, None

    def _alone(self, cell):
        """As `_times`, with what a leaf has beside its clocks."""
        times, timing = self._times(cell, [None])
        return None if times is None else _leaf(cell) | times, timing

    def _times(self, cell, multipliers):
        """A leaf's clocks, or None and the clock that P doesn't hold for."""
        tree, budget, good = {}, self.budget, set()
        queue = [(self.clocks, tree)]
        while queue:
            check_time()
            box, node = queue.pop()
            if box.empty:
                continue
            for k, G in enumerate(multipliers):
                if cell.least(box, self.rate, G) > 0:
                    node.update({} if G is None else {"G": decimals(G)})
                    multipliers.insert(0, multipliers.pop(k))  # a neighbour's is near
                    break
            else:
                budget -= 1
                few = len(queue) + 2 > budget
                self.starved |= few and self.clocks.varies and box.cuts
                cuts = self.clocks.varies and box.cuts
                if few or not cuts or cell.bends_across(box):
                    return None, None
                for timing in box.corners:
                    if timing in good or timing.remainder > timing.T:
                        continue
                    if not self._holds(cell, timing, multipliers):
                        return None, timing
                    point = self.clocks.at(timing)
                    if all(cell.least(point, self.rate, G) <= 0 for G in multipliers):
                        return None, None  # the plants are too many
                    good.add(timing)
                node.update(halve=box.wider, halves=[{}, {}])
                queue += zip(box.halves(box.wider), node["halves"])
        self.budget = budget
        return {"times": tree} if tree else {}, None

    def _holds(self, cell, timing, multipliers):
        """True if P holds at one clock, in floats, if the plants' loops didn't bend."""
        one = np.eye(len(cell.L))
        P = [one] * len(cell.weights) if cell.P is None else cell.P
        (loops,) = self._loops(cell.weights, [timing])
        loops = [_within(F, cell.L) for F in loops]
        mean = sum(P) / len(P)
        several = [mean if G is None else G for G in multipliers]
        return any(
            all(_least(x, G, F, self.rate) > 0 for x, F in zip(P, loops))
            for G in several
        )


def _leaf(cell):
    several = {} if cell.P is None else {"P": decimals(cell.P)}
    return {"L": decimals(cell.L), "last": cell.last} | several


def _least(P, G, F, rate):
    """The smallest eigenvalue of the theorem's block, without W."""
    return np.linalg.eigvalsh(
        np.block([[rate**2 * P, (G @ F).T], [G @ F, G + G.T - P]])
    )[0]


def too_slow(F, rate, centre=0.0):
    """The words where the radius of F, by floats, isn't below the rate; else empty.

    F is a loop less its ``centre``.
    """
    radius = abs(np.linalg.eigvals(F)).max()
    if radius < rate * (1 - 1e-9):
        return ""
    if centre:
        return f"it has an eigenvalue {radius:.6g} away from {centre:.6g}"
    return f"its spectral radius is {radius:.6g}"


def _storage(loops, k):
    """Coordinates in which no loop with k channels might be longer than one. They have
    their own, and the state begins where what w does to it and it does to z are equal.
    """
    N, mean = len(loops[0]) - k, sum(loops) / len(loops)
    L = np.eye(len(mean))
    L[:N, :N] = _balanced(mean[:N, :N])
    L = equalled(_within(mean, L), N) @ L
    inside = [_within(F, L) for F in loops]
    return round_digits(_common(inside, 1.0, held=k) @ L, LYAPUNOV_DIGITS)


def lyapunov(loops, rate, centred=True):
    """A regular L so that |L x| might decay at a rate in all of some loops: of several,
    ``centred`` or not, of the analytic centre, or any point inside.
    """
    mean = sum(loops) / len(loops)
    L = _refined(_balanced(mean), [mean], rate)
    if max(np.linalg.norm(_within(F, L), 2) for F in loops) >= rate:
        L = _refined(L, loops, rate, centred)
    return round_digits(L, LYAPUNOV_DIGITS)


def _within(F, L):
    return L @ F @ np.linalg.inv(L)


def _balanced(F):
    """The coordinates in which F has rows and columns of one size."""
    return np.diag(1 / matrix_balance(F, permute=False, separate=True)[1][0])


def _refined(L, loops, rate, centred=True):
    """A better L: of one Lyapunov equation, or the LMIs of some."""
    loops = [_within(F, L) for F in loops]
    worst = max(abs(np.linalg.eigvals(F)).max() for F in loops)
    pace = max(np.sqrt(min(worst, rate) * rate), 0.1 * rate)
    if len(loops) > 1:
        return _common(loops, pace, centred) @ L
    if worst >= rate:
        return L
    F = loops[0] / pace
    return root(discrete_lyapunov(F, np.eye(len(F)))) @ L


def _common(loops, pace, centred=True, held=0):
    """The coordinates in which no loop is longer than a pace; the identity if none.

    ``held``: so many last ones are multiplied by one number.
    """

    def decay(values, cast):
        P = joined_P(values, "P", held)
        drops = [P * pace**2 - F.T @ P @ F for F in loops]
        return {"P": P} | {f"loop {k}": g for k, g in enumerate(drops)}

    N = len(loops[0])
    unknowns = [Unknown("P", N - held, symmetric=True)]
    problem = LMIProblem(LMIText(decay, unknowns + [Unknown("c", 1)] * bool(held)))
    if centred:
        solution = problem.solve(refuse=False, within_bounds=True).values
    else:
        solution = problem.find(refuse=False).values
    if solution is None:
        return np.eye(N)
    L = np.eye(N)
    size = solution["c"].item() if held else 1.0
    L[: N - held, : N - held] = root(solution["P"] / size)
    return L


def _multipliers(loops, bent, rate, held=0):
    """P for each corner and G for each clock of the theorem; None, None if none."""
    N, count = len(loops[0][0]), len(loops[0])
    unknowns = [Unknown(f"P{i}", N - held, symmetric=True) for i in range(count)]
    unknowns += [Unknown("c", 1)] * bool(held)
    for j, W in enumerate(bent):
        unknowns.append(Unknown(f"G{j}", N))
        if W is not None:
            unknowns.append(Unknown(f"s{j}", 1))

    def write(values, number):
        """The blocks of each clock and corner."""
        blocks = {}
        for j, (row, W) in enumerate(zip(loops, bent)):
            G = values[f"G{j}"]
            for i, F in enumerate(row):
                P = joined_P(values, f"P{i}", held)
                top, cross = P * rate**2, G @ F
                rows = [[top, cross.T], [cross, he(G) - P]]
                if W is not None:
                    s = values[f"s{j}"]
                    rows = [
                        [top - kron(s, W), cross.T, 0],
                        [cross, he(G) - P, G],
                        [0, G.T, kron(s, eye(N))],
                    ]
                blocks[f"{j}, {i}"] = block(rows)
        return blocks

    problem = LMIProblem(LMIText(write, unknowns))
    sizes = {"P": N - held, "G": N}  # the identity is near, where s is large
    start = {x.name: np.eye(sizes.get(x.name[0], 1)) for x in unknowns}
    for j, W in enumerate(bent):
        if W is not None:
            start[f"s{j}"] /= np.sqrt(max(np.linalg.norm(W, 2), 1e-30))
    found = problem.solve(refuse=False, within_bounds=True, start=start).values
    if found is None:
        return None, None
    P = np.array([np.eye(N)] * count)
    P[:, : N - held, : N - held] = [found[f"P{i}"] for i in range(count)]
    size = found["c"].item() if held else np.trace(P.mean(axis=0)) / N
    P[:, : N - held, : N - held] /= size
    P = round_digits((P + P.transpose(0, 2, 1)) / 2, LYAPUNOV_DIGITS)
    G = [round_digits(found[f"G{j}"] / size, LYAPUNOV_DIGITS) for j in range(len(bent))]
    return P, G


def _longest(shape, weights, far):
    """Where to cut a cell: the two corners, or the axis, furthest apart."""
    if not far.any():  # the corners' loops are the same
        w = weights.astype(float)
        far = np.linalg.norm(w[:, None] - w[None], axis=2)
    if shape.axes:
        pairs = np.arange(len(far))
        steps = [2 ** (shape.axes - 1 - k) for k in range(shape.axes)]
        return int(np.argmax([far[pairs, pairs ^ step].sum() for step in steps]))
    i, j = np.unravel_index(far.argmax(), far.shape)
    return [int(i), int(j)]
