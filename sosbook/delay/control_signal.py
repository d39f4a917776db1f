"""The control signal of a delayed motion, as a cubic in each step."""

import numpy as np

GAUSS_POINTS = (1 + np.sqrt(3 / 5) * np.array([-1, 0, 1])) / 2
# column j: coefficients in 1, s, s^2 of the parabola that is 1 at GAUSS_POINTS[j]
PARABOLAS = np.linalg.inv(np.vander(GAUSS_POINTS, increasing=True))
ENDS = np.vander([0.0, 1.0], 3, increasing=True) @ PARABOLAS


def _hermite(s):
    """Weights of [value, slope] at 0 and at 1, last axis."""
    first, last = [(1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2], s**2
    return np.stack([*first, last * (3 - 2 * s), last * (s - 1)], -1)


class ControlSignal:
    """The control signal u so far; a step's cubic is a row of ``table``.

    ``nodes``: ends of the steps; K: the gain; ``level``: K [r; 0; 0]; ``past``: the
    state before t = 0; ``tolerance``: in seconds.
    """

    def __init__(self, nodes, K, level, past, tolerance):
        self.nodes, self.K, self.level = nodes, K, level
        self.past, self.tolerance = past, tolerance
        self.table = np.zeros((len(nodes) - 1, 4, len(K)))

    def __call__(self, s, late):
        """u at the times s, from the controller where ``late``."""
        row, weights, fixed = self.look_up(s, late)
        return fixed + (weights[..., None] * self.table[row]).sum(-2)

    def look_up(self, s, late):
        """Row of the table, weights of its entries, what is known: of u at s.

        It is the controller's where ``late``.
        """
        # of rounding, and of jumps that a delay doesn't tell
        s = np.where(late, np.maximum(s, 0), np.minimum(s, 0))
        row = np.searchsorted(self.nodes, s - self.tolerance) - 1
        row = row.clip(0, len(self.table) - 1)
        start = self.nodes[row]
        weights = _hermite((s - start) / (self.nodes[row + 1] - start))
        weights[~late] = 0
        fixed = np.zeros((*s.shape, len(self.K)))
        fixed[~late] = np.reshape(
            [self.K @ self.past(one) for one in s[~late]], (-1, len(self.K))
        )
        return row, weights, fixed

    def march(self, A, B, x0, asked, late, h, kind, flow, weights, push, outside):
        """The state at the nodes, from x0.

        A, B are the plant's matrices, ``asked`` the times whose input arrives, from the
        controller where ``late``, h the steps and ``kind`` theirs; ``flow``,
        ``weights`` and ``push`` are what the state, the input and the disturbance do in
        a step, ``outside`` what isn't fed back in x'.
        """
        K, table, points = self.K, self.table, len(GAUSS_POINTS)
        (N, m), count = B.shape, len(h)
        row, cubic, fixed = self.look_up(asked, np.repeat(late[:, None], points, 1))
        own = np.arange(count)
        inside = late[:, None] & (row >= own[:, None])
        row = np.minimum(row, own[:, None])
        implicit = inside.any(1)
        needs = np.where(late[:, None], row, -1).max(1)

        KA, KB = K @ A, K @ B
        cubic = cubic[:, :, None]
        outside = outside @ K.T
        wide = weights.reshape(-1, N, points * m)
        solve = self.solutions(
            implicit, inside, cubic[:, :, 0], h, KA, KB, weights, kind
        )

        x = np.empty((count + 1, N))
        x[0] = x0
        pairs = np.lib.stride_tricks.sliding_window_view(x, (2, N))[:, 0]
        both = np.hstack([K.T, KA.T])

        def write(i, j, come=None):
            """Rows i to j of the table, from the states at their ends."""
            ends = pairs[i:j] @ both
            table[i:j, 0::2] = ends[..., :m] - self.level
            slopes = ends[..., m:] + outside[i:j]
            if come is not None:
                slopes += ENDS @ come @ KB.T
            table[i:j, 1::2] = h[i:j, None, None] * slopes

        flows = list(flow)
        kinds, needs = kind.tolist(), needs.tolist()
        i = 0
        while i < count:
            j = i + 1
            if implicit[i]:
                x[j] = flows[kinds[i]] @ x[i] + push[i]
                write(i, j)  # as if the input were zero
            else:
                while j < count and needs[j] < i:
                    j += 1
            come = fixed[i:j] + (cubic[i:j] @ table[row[i:j]])[:, :, 0]
            flat = come.reshape(j - i, -1, 1)
            if implicit[i]:
                flat = solve[i] @ flat
                come = flat.reshape(come.shape)
            new = (wide[kind[i:j]] @ flat)[..., 0] + push[i:j]
            now = x[i]
            for k, change in enumerate(new, i):
                now = flows[kinds[k]] @ now + change
                x[k + 1] = now
            write(i, j, come)
            i = j
        return x

    def solutions(self, implicit, inside, cubic, h, KA, KB, weights, kind):
        """From the input's known part to the input, of each ``implicit`` step.

        Its own cubic depends on the input that it gives: its end value on all of it,
        its slopes also directly. ``inside``: which of its points; KA = K A, KB = K B;
        ``cubic``, h, ``weights`` and ``kind`` are those of `march`.
        """
        steps, m = np.flatnonzero(implicit), len(KB)
        W, size = weights[kind[steps]], h[steps, None, None, None]
        end = np.einsum("mn,knjl->kmjl", self.K, W)
        ends = [size * KB[:, None, :] * side[:, None] for side in ENDS]
        ends[1] = ends[1] + size * np.einsum(
            "mn,kjnl->kmjl", KA, W.transpose(0, 2, 1, 3)
        )
        c = (cubic * inside[..., None])[steps][..., None, None, None]
        ends = ends[0], end, ends[1]
        part = sum(c[:, :, k] * e[:, None] for k, e in enumerate(ends, 1))
        part = part.reshape(len(steps), 3 * m, 3 * m)
        return dict(zip(steps.tolist(), np.linalg.inv(np.eye(3 * m) - part)))
