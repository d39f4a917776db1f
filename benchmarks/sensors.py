"""Plants with the sensors that people have: python -m benchmarks.sensors [number ...].

Each plant has a law. The fastest decay is searched and proven; then, where the plant
has a disturbance, the least H-infinity norm with a tenth of the input in the output
and with three tenths of that decay. What is proven is held against the truth: the
worst of vertices, edges and random plants, by numpy's eigenvalues alone. CPU seconds,
into sensors.json, which chapter 36 prints; with numbers only these plants are run,
and nothing is stored.
"""

import json
import sys
from itertools import product
from pathlib import Path
from time import process_time

import numpy as np

import sosbook as sos

from .masses import network
from .records import store
from .run import machine

RESULTS = Path(__file__).with_name("sensors.json")
SAMPLES = 400  # random plants between the vertices


def chain(springs, wall, masses, damping=0.05):
    """M, D, S of masses in a row, the first one also on a spring to a wall."""
    ties = [(i, i + 1, k) for i, k in enumerate(springs)]
    S = network(len(masses), [*ties, (0, None, wall)])
    return np.diag(np.array(masses, float)), damping * S, S


def some(n, *at):
    """Rows of the identity."""
    return np.eye(n)[list(at)]


def family(build, **ranges):
    """The polytope of the corners of some ranges."""
    corners = product(*ranges.values())
    return sos.Polytope([build(**dict(zip(ranges, c))) for c in corners])


def three_masses(k):
    return sos.SecondOrderSystem(
        *chain([k, k], 1, (1, 1, 1)), some(3, 0).T, some(3, 2).T
    )


def two_masses(m):
    return sos.SecondOrderSystem(*chain([1], 0.5, (1, m)), some(2, 0).T, some(2, 1).T)


def carts(m, k):
    return sos.SecondOrderSystem(*chain([k], 1, (1, m)), np.eye(2), some(2, 1).T)


def quarter_car(m):
    k, c, tyre, wheel = 16e3, 1e3, 160e3, 45.0
    D, S = [[c, -c], [-c, c]], [[k, -k], [-k, k + tyre]]
    return sos.SecondOrderSystem(np.diag([m, wheel]), D, S, [[1], [-1]], [[0], [tyre]])


def cart_and_pendulum(m):
    cart, long, g = 1.0, 0.5, 9.81
    M = [[cart + m, m * long], [m * long, m * long**2]]
    S = [[0, 0], [0, -m * g * long]]
    return sos.SecondOrderSystem(M, np.diag([0.1, 0.01]), S, [[1], [0]], [[0], [1]])


def flexible_joint(J, k):
    D, S = [[0.15, -0.05], [-0.05, 0.05]], [[k, -k], [-k, k]]
    return sos.SecondOrderSystem(np.diag([1, J]), D, S, [[1], [0]], [[0], [1]])


def rotor(speed):
    D = 0.02 * np.eye(2) + 0.6 * speed * np.array([[0, 1], [-1, 0]])
    return sos.SecondOrderSystem(np.eye(2), D, -4 * np.eye(2), np.eye(2), np.eye(2))


def building(a, b):
    parts = chain([100 * b, 80 * b], 120 * b, (a, a, 0.8 * a), 0.002)
    B = [[1, 0], [0, -1], [0, 1]]
    return sos.SecondOrderSystem(*parts, B, np.ones((3, 1)))


def damped_masses(m, k, d):
    D, S = [[0.1 + d, -d], [-d, d]], [[1 + k, -k], [-k, k]]
    return sos.SecondOrderSystem(np.diag([1, m]), D, S, [[1], [0]], [[0], [1]])


def five_masses(m, k):
    parts = chain([k] * 4, 1, (1, 1, m, 1, 1))
    return sos.SecondOrderSystem(*parts, some(5, 0, 2, 4).T, some(5, 1).T)


def hovering_body(m):
    M = np.diag([m, 0.1 + 0.05 * (m - 1), 0.2]) + 0.02 * (m - 1)
    B = [[1, 1, 1], [0.3, -0.3, 0], [0.2, 0.2, -0.4]]
    return sos.SecondOrderSystem(M, 0.02 * np.eye(3), np.zeros((3, 3)), B, np.eye(3))


def benchmark(k):
    S = k * np.array([[1, -1], [-1, 1]])
    return sos.SecondOrderSystem(np.eye(2), np.zeros((2, 2)), S, [[1], [0]], [[0], [1]])


def _plants():
    """(name, plant, law) of each."""
    PID, both = sos.PIDLaw, np.eye(2)
    one = some(3, 0)
    k3 = family(three_masses, k=(0.8, 1.25))
    mk = dict(m=(0.5, 1.5), k=(0.8, 1.6))
    yield "three masses, z1 and z1', PID", k3, PID(one, one, integrate=True)
    yield "three masses, z1, PID", k3, PID(one, integrate=True, filter=0.05)
    first = some(2, 0)
    yield "two masses, mass, PD", family(two_masses, m=(0.5, 1.5)), PID(first, first)
    law = PID(both, both, integrate=True, structure="diagonal")
    yield "carts, mass and spring, decentralised PID", family(carts, **mk), law
    law = PID(both, integrate=True, filter=0.1, structure="diagonal")
    yield "carts, positions, decentralised PID", family(carts, **mk), law
    stroke = [[1, -1]]
    yield (
        "quarter car, stroke, PD",
        family(quarter_car, m=(250, 350)),
        PID(stroke, stroke),
    )
    cart = family(cart_and_pendulum, m=(0.1, 0.3))
    yield "cart and pendulum, positions, PD", cart, PID(both, filter=0.01)
    arm = family(flexible_joint, J=(1, 2), k=(8, 12))
    yield "flexible joint, motor, PID", arm, PID(first, integrate=True, filter=0.02)
    law = PID(both, integrate=True, filter=0.02, structure=[["a", 0], [0, "a"]])
    yield "rotor, equal gains, positions, PID", family(rotor, speed=(0, 8)), law
    drifts = [[1, 0, 0], [0, -1, 1]]
    house = family(building, a=(0.85, 1.15), b=(0.8, 1.2))
    yield (
        "building, drifts and rates, PD",
        house,
        PID(drifts, drifts, structure="diagonal"),
    )
    mkd = dict(m=(0.7, 1.4), k=(0.7, 1.4), d=(0.02, 0.1))
    law = PID(first, first, integrate=True)
    yield "two masses, m, k and d, PID", family(damped_masses, **mkd), law
    three = some(5, 0, 2, 4)
    five = family(five_masses, m=(0.6, 1.6), k=(0.8, 1.3))
    yield "five masses, decentralised PD", five, PID(three, three, structure="diagonal")
    body = family(hovering_body, m=(1, 2))
    yield "hovering body, positions, full PD", body, PID(np.eye(3), filter=0.05)
    far = some(2, 1)
    pair = family(benchmark, k=(0.5, 2))
    yield "two masses, the far one, order 3", pair, sos.DynamicLaw(3, far)
    yield "two masses, k = 1, order 2", benchmark(1), sos.DynamicLaw(2, far)


PLANTS = tuple(_plants())


def mixtures(plant, seed=1):
    """Weights of vertices, of plants on the edges, and of random plants."""
    count = len(plant.vertices)
    corners = np.eye(count)
    yield from corners
    for i, j in product(range(count), repeat=2):
        if i < j:
            for t in np.linspace(0, 1, 21)[1:-1]:
                yield t * corners[i] + (1 - t) * corners[j]
    if count > 1:
        yield from np.random.default_rng(seed).dirichlet(np.full(count, 0.5), SAMPLES)


def loops(plant, design):
    """E^-1 (A + B K), E^-1 B_w and K of the controller's loop at each mixture."""
    c = design.exact_controller()
    A, B, C, D = (x.astype(float) for x in (c.A, c.B, c.C, c.D))
    rows = design.request.law_parts.rows.astype(float)
    for weights in mixtures(plant):
        M, Dm, S, Bm, F = (
            sum(x * getattr(v, name) for x, v in zip(weights, plant.vertices))
            for name in "MDSBF"
        )
        n, back = len(M), np.linalg.inv(M)
        plain = np.block([[np.zeros((n, n)), np.eye(n)], [-back @ S, -back @ Dm]])
        push, w = (np.vstack([0 * x, back @ x]) for x in (Bm, F))
        loop = np.block([[plain + push @ D @ rows, push @ C], [B @ rows, A]])
        noise = np.vstack([w, np.zeros((len(A), w.shape[1]))])
        yield loop, noise, np.hstack([D @ rows, C])


def true_decay(plant, design):
    """The least decay over the polytope, by eigenvalues of the controller's loop."""
    found = (np.linalg.eigvals(A).real.max() for A, _, _ in loops(plant, design))
    return float(-max(found))


def true_norm(plant, design, weight):
    """The largest gain from w to z and weight u over the polytope, on a grid."""
    best, n = 0.0, plant.n
    for A, B, K in loops(plant, design):
        C = np.vstack([np.eye(n, len(A)), weight * K])
        s = np.linalg.eigvals(A)
        grid = np.geomspace(np.abs(s).min() / 10, np.abs(s).max() * 2, 60)
        omega = np.concatenate([[0.0], grid, np.abs(s), np.abs(s.imag)])
        pencil = 1j * omega[:, None, None] * np.eye(len(A)) - A
        answers = C @ np.linalg.solve(pencil, B + 0j)
        best = max(best, np.linalg.norm(answers, 2, axis=(1, 2)).max())
    return float(best)


def norms(plant, law, decay):
    """The record of the least norm with three tenths of a decay, and its truth."""
    mass = np.mean([np.abs(np.diag(v.M)).mean() for v in plant.vertices])
    force = max(np.abs(v.B).max() for v in plant.vertices)
    weight = float(f"{0.1 * force / (mass * decay**2):.3g}")  # a tenth of the input
    felt = sos.Output(position=np.eye(plant.n)) & sos.Output(input=weight)
    begun = process_time()
    design = sos.design_pid(
        plant, law=law, minimize="gamma", backoff=0.001,
        region=sos.PoleRegion(sigma=float(f"{0.3 * decay:.3g}")),
        requirements=[sos.HInfinity(outputs=felt)],
    )  # fmt: skip
    seconds = round(process_time() - begun, 2)
    if design.status != "feasible":
        return dict(norm=design.status, norm_s=seconds)
    true = true_norm(plant, design, weight)
    return dict(
        gamma=design.gamma,
        true_norm=true,
        norm_proven=bool(design.certify().proven),
        norm_share=round(design.gamma / true, 5),
        norm_cells=max(part.cells for part in design.parts),
        norm_s=seconds,
    )


def measured(numbers=(), log=print):
    """Records of the plants: what was reached, proven and true."""
    records = []
    for number, (name, plant, law) in enumerate(PLANTS, 1):
        if numbers and number not in numbers:
            continue
        begun = process_time()
        design = sos.design_pid(plant, law=law, maximize="sigma", backoff=0.001)
        searched = process_time()
        proof = design.certify()
        record = dict(
            plant=name,
            vertices=len(plant.vertices),
            states=design.request.order,
            status=design.status,
            search_and_proof_s=round(searched - begun, 2),
        )
        if design.status == "feasible":
            true = true_decay(plant, design)
            asked = design.request.region.parts[0].bound
            record |= dict(
                gains={k: x.tolist() for k, x in design.gains.items()},
                cells=max(part.cells for part in design.parts),
                decay=asked,
                true=true,
                proven=bool(proof.proven),
                share=round(asked / true, 5),
            )
            if isinstance(law, sos.PIDLaw):
                record |= norms(plant, law, asked)
        log(json.dumps({k: x for k, x in record.items() if k != "gains"}))
        records.append(record)
    return records


if __name__ == "__main__":
    chosen = tuple(map(int, sys.argv[1:]))
    found = measured(chosen)
    if not chosen:
        store(RESULTS, {"machine": machine(), "records": found})
