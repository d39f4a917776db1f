"""Plants with the sensors that people have: python -m benchmarks.sensors [number ...].

Each plant has a law. The fastest decay is searched and proven; then, where the plant
has a disturbance, the least H-infinity norm with a tenth of the input in the output
and with three tenths of that decay. What is proven is held against the truth: the
worst of vertices, edges and random plants, by numpy's eigenvalues alone. CPU seconds,
into sensors.json, with which a change of the search is compared; with numbers only
these plants are run, and nothing is stored.
"""

import json
import sys
from itertools import product
from pathlib import Path
from time import process_time

import numpy as np

import sosbook as sos

from . import sensed_plants as known
from .records import store
from .run import machine

RESULTS = Path(__file__).with_name("sensors.json")
SAMPLES = 400  # random plants between the vertices


def family(parts, **ranges):
    """The polytope of the corners of some ranges; one plant without any."""
    plants = []
    for values in product(*ranges.values()):
        made = parts(**dict(zip(ranges, values)))
        plants.append(sos.SecondOrderSystem(*(np.array(x, float) + 0.0 for x in made)))
    return sos.Polytope(plants) if ranges else plants[0]


def _plants():
    """(name, plant, law) of each."""
    PID, both, stroke, drifts = sos.PIDLaw, np.eye(2), [[1, -1]], known.DRIFTS
    one, first, far = known.pick(3, 0), known.FIRST, known.SECOND
    k3 = family(known.three_masses, k=(0.8, 1.25))
    mk = dict(m=(0.5, 1.5), k=(0.8, 1.6))
    yield "three masses, z1 and z1', PID", k3, PID(one, one, integrate=True)
    yield "three masses, z1, PID", k3, PID(one, integrate=True, filter=0.05)
    yield "two masses, mass, PD", family(known.pair, m=(0.5, 1.5)), PID(first, first)
    carts = family(known.carts, **mk)
    law = PID(both, both, integrate=True, structure="diagonal")
    yield "carts, mass and spring, decentralised PID", carts, law
    law = PID(both, integrate=True, filter=0.1, structure="diagonal")
    yield "carts, positions, decentralised PID", carts, law
    car = family(known.car, m=(250, 350))
    yield "quarter car, stroke, PD", car, PID(stroke, stroke)
    cart = family(known.pendulum_on_cart, m=(0.1, 0.3))
    yield "cart and pendulum, positions, PD", cart, PID(both, filter=0.01)
    arm = family(known.joint, J=(1, 2), k=(8, 12))
    yield "flexible joint, motor, PID", arm, PID(first, integrate=True, filter=0.02)
    law = PID(both, integrate=True, filter=0.02, structure=[["a", 0], [0, "a"]])
    rotor = family(known.bearings, speed=(0, 8))
    yield "rotor, equal gains, positions, PID", rotor, law
    house = family(known.building, a=(0.85, 1.15), b=(0.8, 1.2))
    law = PID(drifts, drifts, structure="diagonal")
    yield "building, drifts and rates, PD", house, law
    damped = family(known.two, m=(0.7, 1.4), k=(0.7, 1.4), d=(0.02, 0.1))
    law = PID(first, first, integrate=True)
    yield "two masses, m, k and d, PID", damped, law
    five = family(known.five_masses, m=(0.6, 1.6), k=(0.8, 1.3))
    law = PID(known.OUTER, known.OUTER, structure="diagonal")
    yield "five masses, decentralised PD", five, law
    body = family(known.hover, m=(1, 2))
    yield "hovering body, positions, full PD", body, PID(np.eye(3), filter=0.05)
    pair = family(known.free_masses, k=(0.5, 2))
    yield "two masses, the far one, order 3", pair, sos.DynamicLaw(3, far)
    pair = family(known.free_masses)
    yield "two masses, k = 1, order 2", pair, sos.DynamicLaw(2, far)


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
    c = design.loop.to_ss()
    A, B, C, D = c.A, c.B, c.C, c.D
    rows = design.request.applied.parts.rows.astype(float)
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
        plant, law=law, minimize="gamma", search=sos.Search(backoff=0.001),
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
        design = sos.design_pid(
            plant, law=law, maximize="sigma", search=sos.Search(backoff=0.001)
        )
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
