"""Plants and requests that several tests share."""

import numpy as np

import sosbook as sos


def car_seat(mass):
    """Thesis, section 3.1, Example 2, in SI units; S22 = k1 + k2."""
    k1, k2, b1, b2 = 4e4, 5e3, 4e3, 500
    return sos.SecondOrderSystem(
        M=np.diag([mass, 1500]),
        D=[[b2, -b2], [-b2, b1 + b2]],
        S=[[k2, -k2], [-k2, k1 + k2]],
        B=np.eye(2),
        F=np.diag([0, 1]),
    )


def car_seats():
    """The polytope of Example 2 and what is asked of its loop."""
    start = [-0.1, -0.1, 0.09, 0.09, 0.05, 0.05]
    asked = dict(
        U=np.eye(2),
        region=sos.PoleRegion(sigma=0.9, theta=np.pi / 3, rho=15),
        gamma=0.1732,
        saturation=sos.Saturation(40000, start),
    )
    return sos.Polytope([car_seat(70), car_seat(120)]), asked


def chain(n):
    """n masses between walls, a force on each second one."""
    S = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return sos.SecondOrderSystem(
        np.eye(n), 0.1 * S, S, np.eye(n)[:, ::2], np.eye(n)[:, :1]
    )


def random_plant(rng, n, m, p=1, vertices=1, spread=0.0):
    """A plant, or a polytope around it, that nothing makes stable."""
    root = rng.standard_normal((n, n))
    parts = [
        np.eye(n) + 0.3 * root @ root.T,
        rng.standard_normal((n, n)),
        3 * rng.standard_normal((n, n)),
        rng.standard_normal((n, m)),
        rng.standard_normal((n, p)),
    ]
    found = [
        sos.SecondOrderSystem(*(
            x * (1 + spread * rng.uniform(-1, 1, x.shape)) for x in parts
        ))
        for _ in range(vertices)
    ]
    return found[0] if vertices == 1 else sos.Polytope(found)


def random_request(seed):
    """Keyword arguments of `design_pid`, of every kind."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    m = int(rng.integers(1, n + 1))
    a = int(rng.integers(0, m + 1))
    plant = random_plant(
        rng, n, m, 1, int(rng.integers(1, 4)), rng.choice([0, 0.05, 0.2])
    )
    asked = {"plant": plant}
    if a:
        asked["U"] = rng.standard_normal((a, n))
    region = {}
    if rng.random() < 0.6:
        region["sigma"] = 10 ** rng.uniform(-1, 0.3)
    if rng.random() < 0.4:
        region["theta"] = rng.uniform(0.2, np.pi / 2)
    if rng.random() < 0.4:
        region["rho"] = 10 ** rng.uniform(0.4, 1.5)
    if region:
        asked["region"] = sos.PoleRegion(**region)
    if rng.random() < 0.5:
        asked["gamma"] = 10 ** rng.uniform(-1.5, 1)
    if rng.random() < 0.5:
        asked["saturation"] = sos.Saturation(
            10 ** rng.uniform(0, 3), 0.3 * rng.standard_normal(2 * n + a)
        )
    return asked
