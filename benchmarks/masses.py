"""Plants made of masses and springs: chains, grids, trees, buildings, modes.

Each function gives a plant and what is asked of it, by the arguments of
the kind of request that `benchmarks.catalogue` names. Those with a ``seed``
draw masses and stiffnesses, so that no size is like another.
"""

import numpy as np

import sosbook as sos

SPREAD = 0.2  # of a random mass or stiffness, a fraction


def network(n, ties):
    """The stiffness matrix of springs, (i, j, k) each; j = None is the ground.

    Examples
    --------
    >>> network(2, [(0, 1, 3.0), (0, None, 1.0)])
    array([[ 4., -3.],
           [-3.,  3.]])
    """
    S = np.zeros((n, n))
    for i, j, k in ties:
        S[i, i] += k
        if j is not None:
            S[j, j] += k
            S[i, j] -= k
            S[j, i] -= k
    return S


def spread_over(n, every=4):
    """Unit columns: a force on one mass of every so many, one at least."""
    count = max(1, n // every)
    places = np.floor((np.arange(count) + 0.5) * n / count).astype(int)
    return np.eye(n)[:, places]


def drawn(rng, count):
    """Numbers around one."""
    return 1 + SPREAD * rng.uniform(-1, 1, count)


def free_chain(n):
    """Unit masses in a row, free but for springs of 0.1 to the ground.

    Springs of one and dampers of 0.02 between neighbours; a force on every
    fourth mass. Of the loop nothing but the place of its poles is asked.
    """
    T = network(n, [(i, i + 1, 1.0) for i in range(n - 1)])
    plant = sos.SecondOrderSystem(
        np.eye(n), 0.02 * (T + 0.1 * np.eye(n)), T + 0.1 * np.eye(n), spread_over(n)
    )
    region = sos.PoleRegion(sigma=0.1, theta=np.radians(75), rho=8)
    return plant, dict(region=region)


def grid(n, seed=0):
    """Masses in a rectangle, tied to their neighbours and softly to the ground.

    The rectangle is as near to a square as n allows. The forces are spread
    over it; the disturbance acts where they do, and so does its bound.
    """
    rng = np.random.default_rng([seed, n])
    rows = max(r for r in range(1, int(np.sqrt(n)) + 1) if n % r == 0)
    place = np.arange(n).reshape(rows, -1)
    pairs = [*zip(place[:, :-1].ravel(), place[:, 1:].ravel())]
    pairs += zip(place[:-1].ravel(), place[1:].ravel())
    S = network(n, [(i, j, k) for (i, j), k in zip(pairs, drawn(rng, len(pairs)))])
    S = S + 0.5 * np.diag(drawn(rng, n))
    B = spread_over(n)
    plant = sos.SecondOrderSystem(
        np.diag(drawn(rng, n)), 0.1 * np.eye(n) + 0.02 * S, S, B, B
    )
    region = sos.PoleRegion(sigma=0.1, rho=8)
    return plant, dict(region=region, gamma=1.5)


def tree(n, seed=0):
    """Masses on a random tree, of an uncertain stiffness at the root.

    Each mass hangs on one drawn before it, the first one on the ground. The
    root's spring is one or two. A force acts on every other mass.
    """
    rng = np.random.default_rng([seed, n])
    ties = [
        (i, int(rng.integers(i)), k) for i, k in zip(range(1, n), drawn(rng, n - 1))
    ]
    M, B = np.diag(drawn(rng, n)), spread_over(n, 2)
    vertices = []
    for root in (1.0, 2.0):
        S = network(n, [*ties, (0, None, root)])
        vertices.append(sos.SecondOrderSystem(M, 0.05 * M + 0.05 * S, S, B, B))
    return sos.Polytope(vertices), dict(
        region=sos.PoleRegion(sigma=0.1, rho=6), gamma=6.0, coupling=("slack", 0.2)
    )


def building(n, seed=0):
    """A shear frame on ground that shakes; a brace in every other storey.

    Storeys get lighter and softer with their height. A brace pushes two floors
    apart. The stiffness of all storeys is uncertain by a fifth, together.
    Masses in units of the lowest floor, rates in units of the lowest storey's.
    """
    rng = np.random.default_rng([seed, n])
    height = np.linspace(1, 0.6, n)
    M = np.diag(height * drawn(rng, n))
    stiffness = height * drawn(rng, n)
    between = np.eye(n) - np.eye(n, k=1)  # forces of a brace on the floors
    B = between[:, ::2]
    ties = [(i, i - 1 if i else None, k) for i, k in enumerate(stiffness)]
    S = network(n, ties)
    vertices = [
        sos.SecondOrderSystem(
            M, 0.02 * M + 0.02 * S, f * S, B, -M @ np.ones((n, 1)) / np.sqrt(n)
        )
        for f in (0.8, 1.2)
    ]
    return sos.Polytope(vertices), dict(
        region=sos.PoleRegion(sigma=0.03, rho=8), coupling=("slack", 0.2)
    )


def modes(n, seed=0):
    """Random modes in random coordinates, two forces on them.

    Frequencies from 1 to 5 rad/s, damped by half a percent to two percent. The
    input is bounded from a random state of length one.
    """
    plant, rng = random_modes(n, seed)
    x0 = rng.standard_normal(2 * n)
    limit = sos.Saturation(30.0, x0 / np.linalg.norm(x0))
    region = sos.PoleRegion(sigma=0.02, rho=12)
    return plant, dict(region=region, saturation=limit)


def stations(n, seed=3, damping=0.005):
    """Space stations: lightly damped modes far apart, in coordinates that mix them.

    Frequencies from 2 to 400 rad/s; some modes are too slow for the region.
    """
    rng = np.random.default_rng(seed)
    w = np.sort(10 ** rng.uniform(0.3, 2.6, n))
    V = np.linalg.qr(rng.normal(size=(n, n)))[0]
    D, S = (V * (2 * damping * w)) @ V.T, (V * w**2) @ V.T
    B, F = 0.01 * rng.normal(size=(n, 3)), 0.01 * rng.normal(size=(n, 1))
    plant = sos.SecondOrderSystem(np.eye(n), (D + D.T) / 2, (S + S.T) / 2, B, F)
    return plant, dict(region=sos.PoleRegion(0.02))


def random_modes(n, seed, inputs=2):
    """The plant of `modes`, and what draws on."""
    rng = np.random.default_rng([seed, n])
    rates = np.sort(rng.uniform(1, 5, n))
    damping = rng.uniform(0.005, 0.02, n)
    Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
    mix = Q * np.sqrt(drawn(rng, n))  # not orthogonal: M isn't I
    B = Q @ rng.choice([-1, 1], (n, min(n, inputs))) * drawn(rng, n)[:, None]
    return sos.SecondOrderSystem(
        mix @ mix.T,
        mix * (2 * damping * rates) @ mix.T,
        mix * rates**2 @ mix.T,
        B,
        np.ones((n, 1)) / np.sqrt(n),
    ), rng


def uncertain_masses(count, n=8):
    """A chain between two walls, some of whose masses are uncertain by a fifth.

    The vertices suffice: each number changes one mass.

    Parameters
    ----------
    count : int
        Vertices, a power of two up to 2^n.
    """
    return _between_walls(0.2 * signs(count, n))


def tied_masses(count, n=4):
    """The same chain with loads that are somewhere between two neighbours.

    Each number takes a tenth from one mass and gives it to the next one, so that
    the pairs of vertices are needed.

    Parameters
    ----------
    count : int
        Vertices, a power of two up to 2^(n - 1).
    """
    moved = 0.1 * signs(count, n - 1)
    none = np.zeros((count, 1))
    return _between_walls(np.hstack([moved, none]) - np.hstack([none, moved]))


def _between_walls(change):
    n = change.shape[1]
    S = network(n, [(i, i + 1, 1.0) for i in range(n - 1)]) + np.eye(n)
    B = spread_over(n, 2)
    vertices = [sos.SecondOrderSystem(np.diag(1 + c), 0.1 * S, S, B, B) for c in change]
    region = sos.PoleRegion(sigma=0.1, rho=6)
    return sos.Polytope(vertices), dict(region=region, gamma=2.0)


def uncertain_springs(count, n=8):
    """A chain, some of whose springs to the ground are uncertain by a tenth.

    Parameters
    ----------
    count : int
        Vertices, a power of two up to 2^n.
    """
    T = network(n, [(i, i + 1, 1.0) for i in range(n - 1)]) + 0.5 * np.eye(n)
    B = np.eye(n)[:, ::4]
    vertices = [
        sos.SecondOrderSystem(
            np.eye(n), 0.1 * np.eye(n) + 0.05 * T, T + np.diag(1 + 0.1 * c), B, B
        )
        for c in signs(count, n)
    ]
    region = sos.PoleRegion(sigma=0.1, theta=np.radians(86), rho=4)
    return sos.Polytope(vertices), dict(U=B.T, region=region, gamma=0.3)


def signs(count, n):
    """Rows of signs for the first of n numbers, all combinations, then zeros."""
    k = int(count).bit_length() - 1
    if 2**k != count or k > n:
        raise ValueError(f"count must be a power of two up to {2**n}, got {count}")
    rows = 1 - 2 * (np.arange(count)[:, None] >> np.arange(k)[::-1] & 1)
    return np.hstack([rows, np.zeros((count, n - k))])


def delayed_chain(n):
    """Masses between two walls; a force on every other one arrives late."""
    S = network(n, [(i, i + 1, 1.0) for i in range(n - 1)]) + np.eye(n)
    plant = sos.SecondOrderSystem(np.eye(n), 0.2 * S, S, np.eye(n)[:, ::2])
    return plant, dict(tau=0.2, mu=0.1, delta=0.05, alpha=0.4)


def delayed_modes(n, seed=0):
    """Random modes whose forces arrive late, after an uncertain time."""
    plant, _ = random_modes(n, seed)
    return plant, dict(tau=0.1, mu=0.05, delta=0.002, alpha=0.2)
