"""Loops with a clock: requests that nobody chose, and their truth by exponentials."""

from itertools import product

import numpy as np
from scipy.linalg import expm

import sosbook as sos
from tests.hunt.laws import Ways, gain_of, polytope

WORDS, LONGEST = 40, 4  # sequences of ticks that are tried, and the ticks of each
BETWEEN = 5  # plants between the vertices
SLACK = 1e-9  # what floats may be wrong by


def request(vertices, rng):
    """(words, plant, K, keywords) of a sampled loop that `certify_sampled` takes."""
    first = vertices[0]
    fast = 1e-3 + max(abs(v.poles()).max() for v in vertices)
    K = gain_of(Ways(None), vertices, rng)
    if rng.random() < 0.3:
        K = 0 * K
    T = float(f"{10 ** rng.uniform(-2, 0.3) / fast:.3g}")
    delay, words = 0.0, f"T = {T}"
    if rng.random() < 0.6:
        delay = float(f"{T * rng.choice([0.3, 0.95, 1.0, 1.6, 3.0]):.4g}")
    clock = dict(T=T, delay=delay)
    if rng.random() < 0.4:  # jitter
        high = float(f"{T * rng.uniform(1.05, 1.6):.3g}")
        clock = dict(T=(T, high), delay=(0.0, float(f"{T * rng.uniform(0, 1):.3g}")))
        if rng.random() < 0.3:
            clock = dict(T=T, delay=(1.1 * T, 1.4 * T))
    if rng.random() < 0.5:  # a memory, as firmware has one: what it measures is slow
        n = 2 * first.n
        share = np.diag(np.round(rng.uniform(0.2, 0.9, n), 2))
        K = sos.sampled.SampledSystem(np.eye(n) - share, share, K / 2, K / 2, T)
    if rng.random() < 0.2:
        clock["rate"] = float(f"{1 - 10 ** rng.uniform(-4, -1):.4g}")
    kind = "a gain" if isinstance(K, np.ndarray) else "a law with a memory"
    return f"{kind}, {words}, {clock}", polytope(vertices), K, clock


def step(v, K, T, late, whole):
    """From tick to tick: [x; u before, the latest first; the law's memory].

    ``v``: M, D, S, B; of a delay ``whole`` ticks, and what is left is ``late``.
    """
    n, m = v["M"].shape[0], v["B"].shape[1]
    A = np.linalg.solve(v["M"], np.hstack([-v["S"], -v["D"], v["B"]]))
    A = np.vstack([np.eye(n, 2 * n + m, n), A, np.zeros((m, 2 * n + m))])
    law_A, law_B, law_C, law_D = K
    q, past, N = len(law_A), whole + 1, 2 * n
    size = N + m * past + q
    at = np.eye(size)
    x, xi = at[:N], at[N + m * past :]
    u = [law_D @ at[: law_D.shape[1]] + law_C @ xi]  # older inputs, too
    u += [at[N + m * k : N + m * (k + 1)] for k in range(past)]
    for seconds, held in ((late, u[whole + 1]), (T - late, u[whole])):
        both = expm(A * seconds)
        x = both[:N, :N] @ x + both[:N, N:] @ held
    kept = law_B @ at[:N] + law_A @ xi
    return np.vstack([x, *u[:past], kept])


def falls(whole, rng=None):
    """Whether the loops of a file's data fall as it says; None without an oracle."""
    rng = rng or np.random.default_rng(0)
    plant, K = whole["plant"], whole["K"]
    if whole["U"] or "vertices" not in plant or plant["kind"] != "second order":
        return None
    several = [{x: np.array(v[x], float) for x in "MDSB"} for v in plant["vertices"]]
    (n, m), count = several[0]["B"].shape, len(several)
    own = K if isinstance(K, dict) else {"A": [], "B": [], "C": [], "D": K}
    q = len(own["A"])
    law = [np.array(own[x], float) for x in "ABCD"]
    law[3] = law[3].reshape(m, -1)
    law[:3] = (x.reshape(s) for x, s in zip(law, ((q, q), (q, 2 * n), (m, q))))
    if whole.get("norm"):
        return None
    T, delay = (sorted(map(float, whole[x])) for x in ("T", "delay"))
    ticks = int((delay[0] + SLACK * T[0]) // T[0]) if T[0] == T[1] else 0
    late = [max(0.0, x - ticks * T[0]) for x in delay]
    if law[3].shape[1] not in {2 * n, *(2 * n + m * (ticks + k) for k in (0, 1))}:
        return None  # no such loop
    clocks = [c for c in product(T, late) if c[1] <= c[0] * (1 + SLACK)]
    clocks += [
        (x, min(y, x)) for x, y in zip(rng.uniform(*T, 3), rng.uniform(*late, 3))
    ]
    weights = [*np.eye(count), *rng.dirichlet(np.ones(count), BETWEEN * (count > 1))]
    for w in weights:
        v = {x: sum(a * p[x] for a, p in zip(w, several)) for x in "MDSB"}
        loops = [step(v, law, a, b, ticks) for a, b in clocks]
        words = [[F] for F in loops]
        if T[0] < T[1] or late[0] < late[1]:
            words += [
                [
                    loops[k]
                    for k in rng.integers(0, len(loops), rng.integers(2, LONGEST))
                ]
                for _ in range(WORDS)
            ]
        for word in words:
            F, k = word[0], len(word)
            for other in word[1:]:
                F = other @ F
            z = np.linalg.eigvals(F) - (float(whole["centre"]) if k == 1 else 0)
            if abs(z).max() ** (1 / k) > float(whole["rate"]) * (1 + SLACK):
                return False
    return True
