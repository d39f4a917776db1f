"""Proof files that were changed, what two readers say of them, and what is true.

Each change is a proof in its own right, or none: floats then find the poles of the
changed loop where the claims say.
"""

import copy
import json
import re
from fractions import Fraction

import numpy as np
from mpmath import mp
from scipy.linalg import block_diag, eigvals

import sosbook as sos
from sosbook.exact.checker import verdict as checker
from sosbook.exact.checker.families import given_vertices
from sosbook.exact.proof_file import ProofFile
from sosbook.exact.rational import decimal
from sosbook.requirements.base import Requirement
from sosbook.synthesis.request_as_data import read_request
from tests.hunt import clocks, laws
from tests.least_input import least_input
from tests.least_norm import least_norm


def vertices_in(whole):
    """The matrices of each vertex of what is asked, in decimals of floats."""
    return (
        [
            {
                k: [[repr(float(Fraction(e))) for e in row] for row in rows]
                for k, rows in v.items()
            }
            for v in given_vertices(whole["plant"])
        ]
        if "parameters" in whole["plant"]
        else whole["plant"]["vertices"]
    )


def leaves(value, path=()):
    """(path, leaf) of everything in nested lists and dicts."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key), inner
        if isinstance(inner, (dict, list)):
            yield from leaves(inner, (*path, key))


def of_other_rank(rows):
    """Matrices with numbers that floats don't square, or that lack rank."""
    if isinstance(rows, list) and rows and all(isinstance(r, list) for r in rows):
        for tiny in ("5e-324", "1e-200"):
            yield [[tiny if x == "0" else x for x in row] for row in rows]
        yield from ([["0" for _ in row] for row in rows], rows[:1] * len(rows))


def changes(value):
    """What becomes of a value: other signs, digits, types, shapes."""
    if isinstance(value, str):
        yield from ("NaN", "Infinity", "", None, [value], {"x": value}, True, 0)
        if re.fullmatch(r"-?\d[\d.]*(e[-+]?\d+)?(/\d+)?", value):
            yield value[1:] if value[0] == "-" else "-" + value
            first = next(k for k, c in enumerate(value) if c.isdigit())
            digit = str((int(value[first]) + 3) % 10)
            yield value[:first] + digit + value[first + 1 :]
            yield from (value + "0", "0" + value, value + "e5", "1e400", value + "/0")
            yield float(value) if "/" not in value else 1.5
            if "/" not in value and np.isfinite(float(value)):
                yield decimal(np.nextafter(float(value), np.inf))  # the last bit
        else:
            yield from (value + " x", "poles")
    elif isinstance(value, list):
        yield from of_other_rank(value)
        yield from (value[:-1], value + value[-1:], value[::-1], [], None, {}, "1")
    elif isinstance(value, dict):
        yield from ([], None, "1", {**value, "extra": "1"})
        for key in value:
            yield {k: v for k, v in value.items() if k != key}
    elif isinstance(value, bool):
        yield from (not value, int(value), None, "true")
    elif isinstance(value, int):
        yield from (value + 1, -value - 1, str(value), True, None, 10**6)
    else:
        yield from ("1", [], {}, 0, True)


def put(whole, path, value):
    found = inner = copy.copy(whole)
    for key in path[:-1]:
        inner[key] = inner = copy.copy(inner[key])
    inner[path[-1]] = value
    return found


def tampered(whole, most=400):
    """Changed contents; an even choice where there are too many."""
    everything = []
    for path, value in leaves(whole):
        if path[0] != "about":
            same = json.dumps(value, sort_keys=True)
            everything += [
                (path, change)
                for change in changes(value)
                if json.dumps(change, sort_keys=True) != same
            ]
    step = max(1, len(everything) // most)
    for path, change in everything[::step]:
        yield path, put(whole, path, change)


def verdicts(whole):
    """(what the package says, what the checker says)."""
    text = json.dumps(whole)
    kind = whole.get("kind")
    cls = ProofFile.owner(kind) if isinstance(kind, str) else None
    package = cls is not None and cls(text).verify()
    try:
        alone = bool(checker.check(text))
    except (checker.Refused, checker.Beyond):
        alone = False
    except checker.MALFORMED:
        alone = False
    return package, alone


def true_claims(whole):
    """Whether the changed file's claims hold, by eigenvalues in floats."""
    if whole["kind"] == "design":
        request = read_request(whole)
        K = np.array(whole["K"], float).reshape(request.plant.m, request.order)
        for d in request.vertices:
            for r in request.demands:
                if r.kept(r.truth([d], K, request.K_A)) < -1e-9:
                    return False
        return True
    if whole["kind"] == "delay":
        return not any(late_roots(whole))
    if whole["kind"] == "regularization":
        plants = [[np.array(v[x], float) for x in "MB"] for v in vertices_in(whole)]
        K_A, beta = np.array(whole["K"], float), float(whole["beta"])
        return all(
            np.linalg.eigvalsh(M - B @ K_A + (M - B @ K_A).T)[0] / 2 > beta**2
            for M, B in plants
        )
    if whole["kind"] == "sampled":
        return clocks.falls(whole)
    refuses = whole["kind"] in ("fixed mode", "growing", "unreached response")
    if refuses and (whole["K"] is not None or whole["plant"]["kind"] == "descriptor"):
        return laws.true_refusal(whole)
    if whole["kind"] == "fixed mode":
        return true_mode(whole)
    if whole["kind"] == "small input":
        request = read_request(whole)
        # the others can't help it, whatever they are: one may have no mass
        least = least_input(request, [request.vertices[whole["vertex"]]])
        return None if least is None else least > 0.999 * request.saturation.u_max
    if whole["kind"] == "unreached response" and "bound" in whole:
        plant = vertices_in(whole)[whole["vertex"]]
        parts = [np.array(plant[x], float) for x in "MDSBF"]
        return least_norm(*parts) > 0.999 * float(whole["bound"])
    if whole["kind"] == "singular mass":
        i, j = whole["between"]
        name = "E" if whole["plant"]["kind"] == "descriptor" else "M"
        E, F = (np.array(vertices_in(whole)[k][name], float) for k in (i, j))
        t = np.linspace(0, 1, 10001)
        signs = np.sign(np.linalg.det(E + t[:, None, None] * (F - E)).round(12))
        return len(set(signs)) > 1 or 0 in signs
    if whole["kind"] == "lmi":
        return all(x > -1e-12 for x in least_eigenvalues(whole))
    if whole["kind"] == "observer":
        return observed(whole)
    if whole["kind"] in ("known gain", "energy"):
        return true_poles(whole)
    if whole["kind"] == "sum of poles":
        return all(x > -1e-12 for x in means_of_poles(whole))
    return None  # no oracle here


def late_roots(whole):
    """Roots of loops with the file's delay that decay too slowly, to 60 digits.

    Floats find where to look; where gains are large they also see roots that aren't
    there. So each is looked for in the exact characteristic equation.
    """
    tau, delta = mp.mpf(whole["tau"]), float(whole["delta"])
    for A, A_d in late_loops(whole):
        floats = [np.array(x.tolist(), float) for x in (A, A_d)]
        near = sos.delay.spectrum.characteristic_roots(*floats, float(tau))
        for s in near[near.real >= -delta]:

            def equation(s, A=A, A_d=A_d):
                return mp.det(s * mp.eye(A.rows) - A - A_d * mp.exp(-s * tau))

            with mp.workdps(60):
                try:
                    root = mp.findroot(equation, mp.mpc(s), tol=1e-40, maxsteps=100)
                except (ValueError, ZeroDivisionError):
                    continue
            if float(root.real) >= -delta:
                yield root


def late_loops(whole):
    """A and A_d of x'(t) = A x(t) + A_d x(t - tau), of each vertex, to 60 digits."""
    plant = whole["plant"]
    with mp.workdps(60):
        if plant["kind"] == "loop":
            return [[digits(plant[x]) for x in ("A", "A_d")]]
        K, U, loops = digits(whole["K"]), whole["U"], []
        for v in vertices_in(whole):
            M, D, S, B = (digits(v[x]) for x in "MDSB")
            n, a = M.rows, len(U)
            A, A_d = (mp.zeros(2 * n + a, 2 * n + a) for _ in range(2))
            A[:n, n : 2 * n] = mp.eye(n)
            A[n : 2 * n, :n] = -(M**-1) * S
            A[n : 2 * n, n : 2 * n] = -(M**-1) * D
            A_d[n : 2 * n, :] = M**-1 * B * K
            if a:
                A[2 * n :, :n] = digits(U)
            loops.append([A, A_d])
        return loops


def digits(rows):
    return mp.matrix([[mp.mpf(x) for x in row] for row in rows])


def true_mode(whole):
    """The row rank of [A - s E, B] at the mode, and where it lies."""
    parts = [
        [np.array(vertices_in(whole)[k][x], float) for x in "MDSB"]
        for k in whole["place"]
    ]
    M, D, S, B = (sum(x) / 2 for x in zip(*parts))
    n, s = len(M), complex(*(float(Fraction(x)) for x in whole["point"]))
    if whole["K"] is not None:
        K = np.array(whole["K"], float)
        S, D, B = S - B @ K[:, :n], D - B @ K[:, n:], 0 * B
    pencil = np.hstack([s * s * M + s * D + S, B])
    asked = whole["requirement"]
    region = sos.LMIRegion.half_plane(0.0) if asked is None else None
    if asked is not None:
        region = Requirement.read(asked)
    (distance,) = region.distances([s]).values()
    return np.linalg.svd(pencil)[1][-1] < 1e-7 and distance[0] < 1e-7


def least_eigenvalues(whole):
    """Of the blocks of an LMI at its point, in floats."""
    values = {k: np.array(v, float) for k, v in whole["unknowns"].items()}
    for _, constant, terms in whole["expressions"]:
        total = in_floats(constant)
        for name, transposed, left, right in terms:
            x = values[name].T if transposed else values[name]
            total = total + in_floats(left) @ x @ in_floats(right)
        yield np.linalg.eigvalsh(total)[0]


def in_floats(rows):
    return np.array([[float(Fraction(e)) for e in row] for row in rows])


def law_loop(whole, vertex, K):
    """E and A of E x' = A x, a plant under u = K y and a law's states, in floats."""
    if "E" in vertex:
        E, A, pushed = (in_floats(vertex[x]) for x in "EAB")
    else:
        M, D, S, B = (in_floats(vertex[x]) for x in "MDSB")
        one, none = np.eye(len(M)), np.zeros((len(M), len(M)))
        E, A = block_diag(one, M), np.block([[none, one], [-S, -D]])
        pushed = np.vstack([0 * B, B])
    law, (N, m) = whole.get("law"), pushed.shape
    if law is None:
        U = in_floats(whole["U"]).reshape(-1, N // 2) @ np.eye(N // 2, N)
        A = block_diag(A, np.zeros((len(U), len(U))))
        A[N:, :N] = U
        pushed = np.vstack([pushed, np.zeros((len(U), m))])
        return block_diag(E, np.eye(len(U))), A + pushed @ K
    c, f = len(law["E"]), len(K) - m  # the last f of the law's rates are free
    seen = in_floats(law["rows"])
    square = {x: in_floats(law[x]).reshape(c, c) for x in "EA"}
    of_y, of_xi = (in_floats(law[x]) for x in ("of_sensors", "of_states"))
    A = np.block([
        [A, np.zeros((N, c))],
        [in_floats(law["B"]).reshape(c, len(seen)) @ seen, square["A"]],
    ])  # fmt: skip
    free = np.vstack([np.zeros((c - f, f)), np.eye(f)])
    y = np.hstack([of_y @ seen, of_xi.reshape(len(of_y), c)])
    return block_diag(E, square["E"]), A + block_diag(pushed, free) @ K @ y


def true_poles(whole):
    """Whether the poles of a known gain lie where they are asked, at the vertices."""
    if "parameters" in whole["plant"]:
        return None  # Bernstein's vertices needn't be plants
    loops = [law_loop(whole, v, in_floats(whole["K"])) for v in vertices_in(whole)]
    poles = np.hstack([eigvals(A, E) for E, A in loops])
    poles = poles[abs(poles) < 1e10]  # of a singular mass some are infinite
    regions = [sos.LMIRegion.half_plane(0.0)] + [
        Requirement.read(r) for r in whole["requirements"] if r["kind"] == "region"
    ]
    sizes = 1 + abs(poles)
    inside = [d / sizes for r in regions for d in r.distances(poles).values()]
    return bool(np.min(inside) > -1e-7)


def means_of_poles(whole):
    """How far right of its place the poles' mean is, for its size, with K and -K."""
    vertex, asked = vertices_in(whole)[whole["vertex"]], whole["requirement"]
    gains = np.array([in_floats(G) for G in whole["gains"]])
    sigma = 0.0 if asked is None else float(asked["sigma"])
    for weights in np.random.default_rng(0).standard_normal((3, len(gains))):
        for K in np.tensordot([weights, -weights], gains, 1):
            E, A = law_loop(whole, vertex, K)
            A = np.linalg.solve(E, A)
            yield (np.trace(A) / len(A) + sigma) / (1 + abs(A).max())


def observed(whole):
    """Whether plant and observer are stable together, at each vertex."""
    K, L, C = (np.array(whole[x], float) for x in "KLC")
    E, A, B = (np.array(whole["model"][x], float) for x in ("E", "A", "Bu"))
    for v in vertices_in(whole):
        M, D, S, Bv = (np.array(v[x], float) for x in "MDSB")
        one = np.eye(len(M))
        plant = np.block([[0 * one, one], [np.linalg.solve(M, -np.hstack([S, D]))]])
        push = np.vstack([0 * Bv, np.linalg.solve(M, Bv)])
        follow = np.linalg.solve(E, A + B @ K) + L @ C
        loop = np.block([[plant, push @ K], [-L @ C, follow]])
        if np.linalg.eigvals(loop).real.max() > 1e-9:
            return False
    return True
