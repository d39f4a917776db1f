"""Plants and requests by seed: of many kinds, in many units, asked in odd ways."""

import itertools
from dataclasses import dataclass

import numpy as np

import sosbook as sos

#: Units that decimals keep exactly, and such that they don't.
FACTORS = (1e-6, 1e-3, 0.3, 1 / 9.81, 2.2046, 1e3, 1e6)


@dataclass(frozen=True, eq=False)
class Asked:
    """A request of `design_pid` and what it is made of."""

    seed: int  # makes the same request again
    words: str  # what is asked, for a report
    vertices: list
    keywords: dict  # those of `design_pid`, but for the plant

    @property
    def plant(self):
        """The plant, or the polytope."""
        if len(self.vertices) == 1:
            return self.vertices[0]
        return sos.Polytope(self.vertices)

    def __str__(self):
        return f"seed {self.seed}: {self.words}"


def request(seed):
    """A request that the constructors accept; a ``seed`` makes the same again."""
    rng = np.random.default_rng([seed, 37])
    while True:
        try:
            vertices, words = _vertices(rng)
            keywords, asked = _keywords(rng, vertices)
        except ValueError:  # nothing that can be asked, such as an empty region
            continue
        return Asked(seed, f"{words}; {asked}", vertices, keywords)


def in_units(asked, force, length, time):
    """The same physics where the units are so many times smaller.

    A bound of a cost and a weight of a noise aren't expressed anew: None for these.
    """
    if "requirements" in asked.keywords:  # a cost
        return None
    keywords, first = dict(asked.keywords), asked.vertices[0]
    n, a = first.n, len(keywords.get("U", ()))
    state = np.repeat([length, length / time, length * time], [n, n, a])
    vertices = [
        sos.SecondOrderSystem(
            v.M * (force / length * time**2),
            v.D * (force / length * time),
            v.S * (force / length),
            v.B,
            v.F,
        )
        for v in asked.vertices
    ]
    if "region" in keywords:
        keywords["region"] = _all(_slower(p, time) for p in keywords["region"].parts)
    if "gamma" in keywords:
        keywords["gamma"] *= length / force
    if "saturation" in keywords:
        bound = keywords["saturation"]
        keywords["saturation"] = sos.Saturation(bound.u_max * force, bound.x0 * state)
    words = f"{asked.words}; force {force:g}, length {length:g}, time {time:g}"
    return Asked(asked.seed, words, vertices, keywords)


def _slower(region, time):
    """A region of the poles where time is counted in smaller units."""
    data = {k: float(v) for k, v in region.data().items() if k in _SIZES}
    rates = {k: v / time for k, v in data.items() if k not in ("theta", "degrees")}
    make = sos.LMIRegion
    match region.data()["form"]:
        case "half-plane":
            return make.half_plane(rates["sigma"], region.name)
        case "sector":
            return make.sector(data["theta"], rates["apex"], region.name)
        case "disk":
            return make.disk(rates["rho"], rates["centre"], region.name)
        case "strip":
            return make.strip(rates["left"], rates["right"], region.name)
        case "horizontal strip":
            return make.horizontal_strip(rates["omega"], region.name)
    return make(region.alpha / time, region.beta, region.name)


_SIZES = ("sigma", "theta", "degrees", "apex", "rho", "centre", "left", "right",
          "omega")  # fmt: skip


def _all(regions):
    first, *others = regions
    for other in others:
        first = first & other
    return first


def _shortened(rng, matrices):
    """Half of the plants have numbers of three digits, as a person types them."""
    if rng.random() < 0.5:
        return matrices
    return [np.vectorize(lambda x: float(f"{x:.3g}"))(x) for x in matrices]


def _definite(rng, n, least=1.0):
    root = rng.standard_normal((n, n))
    return root @ root.T + least * np.eye(n)


def _vertices(rng):
    n = int(rng.choice([1, 2, 3, 4], p=[0.2, 0.4, 0.3, 0.1]))
    m = int(rng.integers(1, n + 1))
    kind = str(rng.choice(list(_KINDS)))
    M, D, S, B = _KINDS[kind](rng, n, m)
    F = rng.standard_normal((n, int(rng.integers(1, 3))))
    parts = dict(zip("MDSBF", _shortened(rng, [M, D, S, B, F])))
    parts["M"] = (parts["M"] + parts["M"].T) / 2
    if rng.random() < 0.6:
        return [sos.SecondOrderSystem(**parts)], f"{kind}, n = {n}, m = {m}"
    changes = [_change(rng, parts) for _ in range(rng.integers(1, 3))]
    vertices = []
    for corner in itertools.product((0, 1), repeat=len(changes)):
        moved = {name: x.copy() for name, x in parts.items()}
        for size, change in zip(corner, changes):
            for name, x in change.items():
                moved[name] = moved[name] + size * x
        vertices.append(sos.SecondOrderSystem(**moved))
    if rng.random() < 0.2:
        vertices.append(vertices[0])  # a vertex that comes twice
    order = rng.permutation(len(vertices))
    return [
        vertices[k] for k in order
    ], f"{kind}, n = {n}, m = {m}, {len(order)} corners"


def _change(rng, parts):
    """What one uncertain number does: a mass, a lever, a spring, an actuator, a row."""
    n, m = parts["B"].shape
    i = int(rng.integers(n))
    unit = np.eye(n)[:, [i]]
    lever = np.round(rng.standard_normal((n, 1)), 1)
    size = rng.uniform(0.1, 0.8)
    match rng.choice(["mass", "lever", "spring", "actuator", "row", "all"]):
        case "mass":
            return {"M": size * abs(parts["M"][i, i]) * unit @ unit.T}
        case "lever":
            return {"M": np.round(size, 1) * lever @ lever.T}
        case "spring":
            return {"S": size * np.abs(parts["S"]).max() * lever @ lever.T}
        case "actuator":
            return {"B": size * unit @ rng.standard_normal((1, m))}
        case "row":
            return {"M": size * abs(parts["M"][i, i]) * unit @ unit.T,
                    "S": size * unit @ rng.standard_normal((1, n))}  # fmt: skip
    return {"M": 0.2 * parts["M"], "S": 0.2 * parts["S"], "F": 0.2 * parts["F"]}


def _chain(rng, n, m):
    k = rng.uniform(0.5, 4, n + 1)
    S = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    return np.diag(rng.uniform(0.5, 3, n)), 0.05 * S, S, np.eye(n)[:, :m]


def _modes(rng, n, m):
    """Lightly damped, far apart."""
    w = np.sort(10.0 ** rng.uniform(-0.5, 2, n))
    D = np.diag(2 * rng.uniform(0.002, 0.05, n) * w)
    return np.eye(n), D, np.diag(w**2), rng.standard_normal((n, m))


def _spinning(rng, n, m):
    G = rng.standard_normal((n, n))
    return (_definite(rng, n), 0.1 * np.eye(n) + G - G.T, _definite(rng, n),
            rng.standard_normal((n, m)))  # fmt: skip


def _anything(rng, n, m):
    D, S = rng.standard_normal((2, n, n))
    return _definite(rng, n), D, 3 * S, rng.standard_normal((n, m))


def _stiff(rng, n, m):
    S = _definite(rng, n) * 10.0 ** rng.uniform(-3, 5)
    return (
        np.diag(10.0 ** rng.uniform(-3, 3, n)),
        0.01 * S,
        S,
        rng.standard_normal((n, m)),
    )


def _nearly_alike(rng, n, m):
    """Modes that one input hardly tells from each other."""
    S = np.diag(4 + np.arange(n) * 10.0 ** rng.uniform(-6, -1))
    return np.eye(n), 0.1 * np.eye(n), S, np.ones((n, m)) + 0.1 * np.eye(n)[:, :m]


def _integers(rng, n, m):
    D, S = rng.integers(-2, 6, (2, n, n)).astype(float)
    return np.diag(rng.integers(1, 9, n)).astype(float), D, S, np.eye(n)[:, :m]


_KINDS = {
    "chain": _chain,
    "modes": _modes,
    "rotor": _spinning,
    "any plant": _anything,
    "stiff": _stiff,
    "nearly alike": _nearly_alike,
    "integers": _integers,
}


def _short(x):
    return float(f"{x:.3g}")


def _keywords(rng, vertices):
    """What is asked, and the words for it."""
    plant = vertices[0]
    n, m = plant.n, plant.m
    scale = float(np.median(np.abs(plant.poles()))) + 1e-3
    keywords = {}
    if rng.random() < 0.3:
        keywords["U"] = np.eye(n)[rng.permutation(n)[: rng.integers(1, m + 1)]]
    N = 2 * n + len(keywords.get("U", ()))
    if rng.random() < 0.75:
        keywords["region"] = _region(rng, scale)
    if rng.random() < 0.35:
        size = np.linalg.norm(plant.F) / max(1e-3, np.linalg.norm(plant.S))
        keywords["gamma"] = _short(10 ** rng.uniform(-2, 2) * size)
    if rng.random() < 0.25:
        x0 = np.zeros(N)
        x0[:n] = np.round(rng.standard_normal(n), 2) + 0.01
        force = 10 ** rng.uniform(-2, 3) * np.linalg.norm(plant.S)
        keywords["saturation"] = sos.Saturation(_short(force), x0)
    if rng.random() < 0.2:
        keywords["requirements"] = [_cost(rng, N, m)]
    if len(vertices) > 1:
        keywords["coupling"] = str(rng.choice(["pairs", "pairs", "slack", "vertices"]))
    words = ", ".join(keywords).replace("requirements", "cost")
    return keywords, words or "stability"


def _region(rng, scale):
    """One region, or several, of which some say the same or nearly so."""
    make = sos.LMIRegion
    sigma = _short(scale * 10 ** rng.uniform(-2, 0.5))
    theta, rho = _short(rng.uniform(0.2, 1.5)), _short(scale * rng.uniform(4, 30))
    one = {
        0: lambda: sos.PoleRegion(sigma=sigma),
        1: lambda: sos.PoleRegion(sigma=sigma, theta=theta),
        2: lambda: sos.PoleRegion(sigma=sigma, theta=theta, rho=max(rho, 1.1 * sigma)),
        3: lambda: sos.PoleRegion(rho=rho),
        4: lambda: make.strip(-rho, -sigma),
        5: lambda: make.horizontal_strip(rho),
        6: lambda: make.disk(rho, -rho - sigma),
    }[int(rng.integers(7))]()
    again = rng.random()
    if again < 0.08:
        return one & one
    if again < 0.16:
        return one & make.half_plane(float(np.nextafter(sigma, 1e9)), "one bit more")
    if again < 0.24:
        return one & make([[2 * sigma]], [[1.0]], "mine")
    return one


def _cost(rng, N, m):
    """A weight of full or of low rank, as a product of floats."""
    C = rng.standard_normal((int(rng.integers(1, N + 1)), N))
    Q = C.T @ C if rng.random() < 0.7 else np.eye(N)
    bound = _short(10 ** rng.uniform(0, 4))
    return sos.QuadraticCost(Q, np.eye(m), str(rng.choice(["states", "F"])), bound)
