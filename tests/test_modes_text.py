"""Refusals by some modes of a plant: what the checker's text says of them is true."""

import json
from dataclasses import replace
from fractions import Fraction

import mpmath as mp
import numpy as np
import pytest

import sosbook as sos
from sosbook.delay import DelayRequest, refusal, solve_delay
from sosbook.delay.modes import ModesRefusal, slow_modes
from sosbook.delay.proofs import in_frame
from sosbook.exact.checker import kernel, verdict
from sosbook.exact.checker.arithmetic import Mat, Refused, read, total, trace, zeros
from sosbook.exact.checker.language import Reader, parse
from sosbook.exact.checker.modes import MARGIN
from sosbook.exact.rational import decimal, decimals
from tests.cases import campaign, later
from tests.forged import base, changed, decided

NAME = "a slow mode behind a delay"


def plant_of(seed, kind="second order"):
    """Lightly damped, not symmetric, or damped alone, in some units; two inputs, too.

    And the rate that its slowest motion hasn't.
    """
    rng = np.random.default_rng(seed)
    n, unit = 2 + seed % 3, (1, 0.3, 9.81)[seed % 3]
    X = rng.normal(size=(n, n))
    M = np.eye(n) + 0.2 * X @ X.T / n
    S = unit * np.diag(rng.uniform(1, 40, n))
    S = S + (seed % 4 == 1) * 0.2 * rng.normal(size=(n, n))
    D = 0.005 * S if seed % 2 else 0.03 * np.eye(n)
    B = unit * rng.normal(size=(n, 1 + seed % 2))
    plant = sos.SecondOrderSystem(M, D, S, B)
    w = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, S)).real.min())
    if kind == "descriptor":
        E = np.eye(2 * n) + 0.1 * rng.normal(size=(2 * n, 2 * n))
        one = np.eye(n)
        A = np.block([[0 * one, one], [-np.linalg.solve(M, np.hstack([S, D]))]])
        Bu = np.vstack([0 * B, np.linalg.solve(M, B)])
        plant = sos.DescriptorSystem(E, E @ A, E @ Bu)
    return plant, w


def refused(seed, kind="second order", **changes):
    """The refusal of the slow modes' LMIs alone, and its request."""
    plant, w = plant_of(seed, kind)
    U = np.eye(plant.n)[:1] if kind == "second order" else None
    tau = 0.6 / w
    asked = dict(tau=tau, mu=seed % 2 * tau / 2, delta=0.6 * w, alpha=3 * tau)
    asked["method"] = ("functional", "shift")[seed // 2 % 2]
    request = DelayRequest(plant, U, **asked | changes)
    return refusal._by_modes(request)


def values_of(asked):
    """What the names of a file's text stand for; of the unknowns zeros."""
    file, *_ = verdict.written(asked)
    data = {k: read(v) for k, v in file["data"].items()}
    x, plain = {}, Reader(data)
    for name, spec in file["unknowns"].items():
        x[name] = zeros(*kernel.shape_of(spec, plain)[:2])
    reader = Reader(data, x, file["sets"])
    for _ in reader.statements(parse("\n".join(file["text"]))):
        pass
    return {k: v.v for k, v in reader.env.items()}


def mpm(x):
    if isinstance(x, Mat):
        rows = [[mp.mpf(e) / x.d for e in row] for row in x.a]
        return mp.matrix(rows) if rows else mp.matrix(0, 0)
    return mp.mpf(x.numerator) / x.denominator


def norm2(x):
    return mp.sqrt(max(mp.eigsy(x.T * x, eigvals_only=True)))


CASES = [(0, "second order"), (1, "second order"), (2, "descriptor"), (3, "descriptor"),
         *later(*((k, "second order") for k in range(4, 10)))]  # fmt: skip


@pytest.mark.parametrize("seed, kind", CASES)
@pytest.mark.parametrize("coarse", [0, 1e-5, *campaign([1e-9])])
def test_the_part_is_where_its_numbers_say(seed, kind, coarse):
    """Modes to 60 digits, also where rows, columns and inputs are coarse ones."""
    proof = refused(seed, kind)
    data, rng = proof.data, np.random.default_rng(seed)
    for name in ("rows", "columns", "push"):
        rows = np.array(data[name], float)
        rows = rows * (1 + coarse * rng.uniform(-1, 1, rows.shape))
        data[name] = [[decimal(e) for e in row] for row in rows]
    try:
        text = verdict.text_of({"kind": proof.kind, **data})[0]
        text.lines = text.lines[: text.lines.index("kappa = alpha/tau")]
        env = text.values()
    except Refused:
        assert coarse
        return
    k, v = len(data["push"]), data["vertex"] + 1
    with mp.workdps(60):
        E, A, B, R, D, push = (
            mpm(env[x])
            for x in (f"E.{v}", f"A.{v}", f"Bu.{v}", "span", "spectrum", "push")
        )
        whole = E**-1 * A
        found, left = mp.eig(whole, left=True, right=False)
        near = mp.eig(D[:k, :k], left=False, right=False)
        chosen = [min(range(len(found)), key=lambda j: abs(found[j] - s)) for s in near]
        assert len({*chosen}) == k
        W = mp.matrix([[left[j, i] for i in range(len(A))] for j in chosen])
        W = W * (R * E) ** -1  # rows of [1, H], up to a factor
        W = W[:, :k] ** -1 * W
        assert max(abs(mp.im(e)) for e in W) < 1e-40
        W = (W * R).apply(mp.re)
        L = (W * A) * mp.matrix([*(W * E).tolist()]).T * (W * E * (W * E).T) ** -1
        assert norm2(W * A - L * W * E) < 1e-40
        off = norm2(L - D[:k, :k]), norm2(W * B - push)
        bounds = mpm(env["far.A"]), mpm(env["far.B"])
        assert all(x <= bound for x, bound in zip(off, bounds))
        assert coarse == 0 or all(x > 1e-6 * y for x, y in zip(off, bounds))
        if k < len(A):
            others = mp.eig(D[k:, k:], left=False, right=False)
            assert mpm(env["gap"]) < min(abs(a - b) for a in near for b in others)


def spill_of(request, far):
    """`spill` of the text of a ``request`` whose plant has these distances, by loop."""
    (tau, m, e2), found = (request.tau, request.mu / request.tau, 0), {}
    e2 = float(request.times().epsilon2)
    frame, late = request.frame, "e2 + 1" if request.mu else "e2"
    lines = MARGIN.format(k=request.states, late=late, Z="").split("\n")
    lines = "\n".join(lines[: [x[:5] for x in lines].index("room.")])
    numbers = dict(zip(("far.A", "far.B"), far)) | {"tau": tau, "m": m, "e2": e2}
    numbers |= {"scale": frame.scale, "kappa": request.alpha / tau, "factor.f": 1.0}
    for tag, d in request.loops(np.asarray):
        data = {k: decimals(v) for k, v in dict(A=d.A, E=d.E, B=d.Bu).items()}
        factor = dict(request.factors())[tag]
        data |= {k: decimal(v) for k, v in (numbers | {"factor.f": factor}).items()}
        reader = Reader(
            {k: read(v) for k, v in (data | {"left": decimals(frame.left)}).items()}
        )
        assert all(x.v > 0 for *_, x, _ in reader.statements(parse(lines)))
        found["decay" + tag] = float(reader.env["spill"].v)
    return found


@pytest.mark.parametrize("seed", [0, 1, 2, 3, *campaign(range(4, 12))])
def test_no_plant_near_the_numbers_needs_more_room(seed):
    """A point of the LMIs keeps a decay in `spill` times a trace, where it moves."""
    rng, far = np.random.default_rng(seed), (1e-6, 1e-7)
    k, m = 2 + seed % 3, 1 + seed % 2
    A, B = rng.normal(size=(k, k)), rng.normal(size=(k, m))
    A -= np.eye(k) * (np.linalg.eigvals(A).real.max() + 0.3)
    request = DelayRequest(
        sos.DescriptorSystem(np.eye(k), A, B), None, 0.2, seed // 2 % 2 * 0.1, 0.05,
        0.4, ("functional", "shift")[seed % 2],
    )  # fmt: skip
    made, most = solve_delay(request), 0.0
    assert made.status == "feasible"
    request, spill = made.request, spill_of(made.request, far)

    def blocks(A, B):
        plant = sos.DescriptorSystem(np.eye(k), A, B)
        near = in_frame(request.at(plant=plant), request.frame)
        expressions, unknowns = near.in_unknowns()
        x = {u: made.values[u.name] for u in unknowns}
        return {name: g.value(x) for name, g in expressions.items()}

    here = blocks(A, B)
    common = sum(np.trace(b) for name, b in here.items() if name not in spill)
    for k_ in range(40):
        step, pull = (rng.normal(size=x.shape) for x in (A, B))
        if k_ % 2:  # the worst ones have rank one
            step, pull = (np.outer(x[:, 0], x[0]) for x in (step, pull))
        step, pull = (
            far_ * x / np.linalg.norm(x, 2) for far_, x in zip(far, (step, pull))
        )
        there = blocks(A + step, B + pull)
        for name, bound in spill.items():
            off = np.linalg.norm(there[name] - here[name], 2)
            most = max(most, off / bound / (common + np.trace(here[name])))
        assert all((there[x] == here[x]).all() for x in here.keys() - spill.keys())
    assert 1e-6 < most < 1


def numbers(asked):
    """Each number of what a file asks, with its place, and whether it is a fraction."""
    waiting = [((key,), x) for key, x in asked.items()]
    while waiting:
        path, x = waiting.pop()
        if isinstance(x, (list, dict)):
            inner = x.items() if isinstance(x, dict) else enumerate(x)
            waiting += [((*path, k), y) for k, y in inner]
        elif isinstance(x, str) and x[-1:].isdigit():
            yield path, x


@pytest.mark.slow
def test_each_number_of_a_file_counts():
    """With another one it is refused, but for coordinates, which are anybody's."""
    asked, accepted = base(NAME), set()
    decided(asked)
    every = [x for x in numbers(asked) if x[0][0] != "exponentials"]
    rng = np.random.default_rng(0)
    some = [x for x in every if x[0][0] != "multipliers"]
    rest = [x for x in every if x[0][0] == "multipliers"]
    some += [rest[k] for k in rng.choice(len(rest), 10, replace=False)]
    for path, x in some:
        top, _, under = x.partition("/")
        other = f"{int(top) + 1}/{under}" if under else decimal(1.3 * float(x) + 0.01)
        try:
            decided(changed(NAME, [[list(path), other]]))
        except (Refused, verdict.Beyond, *kernel.MALFORMED):
            continue
        accepted.add(path[0])
    assert accepted == {"columns", "coordinates"}


@pytest.mark.parametrize(
    "name, words, change",
    [
        ("gap", "apart", lambda x: decimal(1.05 * float(x))),
        ("gap", "sign.gap", lambda x: "-" + x),
        ("gap", "small.h", lambda x: "1e-16"),
        ("room", "room.2.one", lambda x: "1e-14"),
        ("room", "isn't positive|a way out", lambda x: decimal(3 * float(x))),
        ("columns", "regular", lambda x: [[decimal(3 * float(e)) for e in u]
                                         for u in x]),
        ("coordinates", "regular|singular", lambda c: c | {"left": [["0"] * 2] * 2}),
    ],
)  # fmt: skip
def test_what_the_text_states_is_needed(name, words, change):
    asked = base(NAME)
    with pytest.raises(Refused, match=words):
        decided(asked | {name: change(asked[name])})


def with_room(asked, room):
    """The same file with another room, and the multipliers that it asks for."""
    Z = {x: read(z) for x, z in asked["multipliers"]}
    decays = [x for x in Z if x.startswith("decay")]
    for sign, much in ((1, Fraction(asked["room"])), (-1, Fraction(room))):
        price = {x: trace(Z[x]) * much for x in decays}
        if sign < 0:
            price = {x: y / (1 + Z[x].r * much) for x, y in price.items()}
        whole = sum(price.values())
        Z = {x: total(z, sign * price.get(x, whole)) for x, z in Z.items()}
    rows = {x: [[str(Fraction(e, z.d)) for e in u] for u in z.a] for x, z in Z.items()}
    return asked | {"room": room, "multipliers": [[x, z] for x, z in rows.items()]}


def several(asked):
    """The file of a polytope whose second vertex has the modes."""
    (v,) = asked["plant"]["vertices"]
    heavy = v | {"M": [[decimal(2 * float(e)) for e in row] for row in v["M"]]}
    plant = asked["plant"] | {"vertices": [heavy, v]}
    return asked | {"plant": plant, "vertex": 1}


EDGES = [
    *((0, "second order"), (1, "second order"), (2, "descriptor"), (3, "second order")),
    *later((6, "second order"), (7, "descriptor")),
]


@pytest.mark.parametrize("seed, kind", EDGES)
@pytest.mark.parametrize("coarse", [1e-11, *campaign([0])])
def test_the_room_is_what_the_text_asks_for_to_the_last_bit(seed, kind, coarse):
    """And the gap is the distance: one bit to the other side is refused."""
    proof = refused(seed, kind)
    asked, rng = {"kind": proof.kind, **proof.data}, np.random.default_rng(seed)
    if kind == "second order":
        asked = several(asked)
    rows = np.array(asked["rows"], float)
    rows = rows * (1 + coarse * rng.uniform(-1, 1, rows.shape))
    asked |= {"rows": decimals(rows)}
    k = len(asked["push"])
    s = [complex(*map(float, x)) for x in asked["spectrum"]]
    own = s[: np.cumsum([1 + (x.imag != 0) for x in s]).tolist().index(k) + 1]
    gaps = [abs(a - b) for a in own for b in s[len(own) :]]
    if gaps:
        near = min(gaps)
        asked |= {"gap": decimal(near * (1 - 1e-12))}
        decided(asked)
        with pytest.raises(Refused, match="apart"):
            decided(asked | {"gap": decimal(near * (1 + 1e-12))})
    env = values_of(asked)
    spill = env["spill"]  # of the last loop, whose factor is the largest
    room = spill / (1 - env["block"].r * spill)
    below, above = np.nextafter(float(room), 0), np.nextafter(float(room), 1)
    whole = verdict.written(with_room(asked, decimal(above)))[0]
    assert len(verdict.check(json.dumps(whole))) == 1
    with pytest.raises(Refused, match="room"):
        decided(with_room(asked, decimal(below)))


def test_a_factor_of_the_input_is_no_negative_one():
    """It would make the price of the input's numbers negative."""
    asked = {"kind": ModesRefusal.kind, **refused(3).data}
    decided(asked)
    with pytest.raises(Refused, match="forward.2.shortest"):
        decided(asked | {"exponentials": ["-1", asked["exponentials"][1]]})


def test_two_integrators_have_one_part():
    """Zero twice: balls didn't tell the two modes apart, and gave up."""
    plant, w = plant_of(1)
    plant = replace(plant, B=np.eye(plant.n))
    request = DelayRequest(plant, np.eye(plant.n)[:2], 0.3 / w, 0.0, 2.5 * w, 1.0)
    modes = next(slow_modes(request.vertices[0], 2.5 * w))
    assert [L.tolist() for L, *_ in modes.part[1:]] == [[[0.0]]] * 2
    found = refusal._by_modes(request)
    assert found is not None and found.proven and "0, 0 alone" in found.part
    assert isinstance(found, ModesRefusal)


def test_dependent_modes_are_no_part():
    """A double integrator of one mass has one vector for two modes."""
    plant = sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]])
    (d,) = DelayRequest(plant, None, 0.2).vertices
    assert not list(slow_modes(d, 1.0))
