"""Requirements on a loop: blocks, and beside them the words that they prove.

Theorems 2.1, 2.2, 2.4 and Lemma 2.2, with pairs or a slack matrix.
"""

import json
import re
from fractions import Fraction

from .arithmetic import Mat, definite, inverse, need
from .families import keys
from .language import Parser
from .outputs import Channel, ends
from .regions import FORMS, of_z, region
from .text import mat, sane

SLACK_CROSS = "EPE - EVE + epsilon Theta', "
AT_TICKS = "(alpha.z.{0} + beta.{0} + beta.{0}')/dt"  # z = 1 + dt s
REGION = "-(kron({a}, EPE) + he(kron({b}, Theta))) > 0"
REGION_SLACK = """-[kron({a}, EPE) + he(kron({b}, Theta)), \
kron({b}, EPE - EVE) + epsilon kron(I({k}), Theta'); ., \
-epsilon he(kron(I({k}), EVE))] > 0"""
DISK_SLACK = """-[({q}^2 - {rho}^2) EPE - {q} he(Theta), \
-{q} EPE + {q} EVE + Theta'; ., EPE - he(EVE)] > 0"""
HINF = """-[he(Theta), {y}, {w}{c}; ., -{s}gamma{k}^2/mu{k}, {z}{o}; \
., {h}, -{s}mu{k}{v}{last}] > 0"""
SQUARE = "; ., ., ., -EPE/dt"  # of the change in a tick, by Schur's complement
HINF_SLACK = """-[he(Theta), EPE - EVE + epsilon Theta', {y}, {w}; \
., {tick}-epsilon he(EVE), {a}, epsilon {w}; \
., ., -{s}gamma{k}^2/mu{k}, {z}; ., ., ., -{s}mu{k}] > 0"""
LQR = """-[he(Theta), EP {u}L, {y}{c}; ., -{s}Wq, 0{o}; \
., 0, -{s}inv(R){r2}{o}{last}] > 0"""
LQR_SLACK = """-[he(Theta), EPE - EVE + epsilon Theta', EP {u}L, {y}; \
., {tick}-epsilon he(EVE), 0, 0; ., ., -{s}Wq, 0; ., ., ., -{s}inv(R){r2}] > 0"""

STABILITY = {"kind": "stability", "name": "stability", "form": "half-plane",
             "sigma": "0", "alpha": [["0"]], "beta": [["1"]]}  # fmt: skip
INSIDE = {"kind": "stability", "name": "stability", "form": "disk", "rho": "1",
          "centre": "0", "alpha": [["-1", "0"], ["0", "-1"]],
          "beta": [["0", "1"], ["0", "0"]]}  # fmt: skip
NAMES = {
    "gamma": "gamma",
    "h2": "h2",
    "cost": "cost",
    "input": "saturation",
}  # regions have any
SEVERAL = ("gamma", "h2", "input")  # of which a request may have more than one, by name
SIZED = ("gamma", "h2", "cost", "input")  # whose blocks aren't homogeneous in P
NUMBERS = {"gamma": "gamma mu", "h2": "h2", "input": "u_max", "cost": "bound"}


def poles(d, r):
    """Theorem 2.2 for the region alpha + beta s + beta' s* < 0."""
    label, block, a, b, k = "stability", "stability", "[0]", "[1]", 1
    if r is INSIDE:
        numbers_of(d.t, d.asked, "stability", INSIDE | {"kind": "region"}, d.ticks)
        a, b = "alpha.stability", "beta.stability"
    elif r is not STABILITY:
        name, block, k = d.ids[id(r)], "", len(r["alpha"])
        label, a, b = f"region.{name}", f"alpha.{name}", f"beta.{name}"
    if not d.slack:
        yield "pair", block, f"{label}.i.j: " + REGION.format(a=a, b=b)
    elif is_disk(r):  # |s - q| < rho
        q, rho = (f"(0 - at({a}, 1, {j}))" for j in (2, 1))
        d.t.write(f"sign.{label}: {rho} > 0")
        yield "pair", block, f"{label}.i: " + DISK_SLACK.format(q=q, rho=rho)
    else:
        yield "pair", block, f"{label}.i: " + REGION_SLACK.format(a=a, b=b, k=k)


def is_disk(r):
    """True if the matrices of a region are those of a disk."""
    (a, *_), *_ = alpha = r["alpha"]
    return r["beta"] == [["0", "1"], ["0", "0"]] and a == alpha[1][1]


def gamma(d, r):
    """Theorem 2.1, the bounded real lemma."""
    more = [x for x in ("outputs", "inputs") if x in r]
    keys(r, " ".join(["kind name gamma mu", *more]))
    need(d.p, "the plant has no disturbance")
    (s, u, over), k = d.size(r), tag(r, d.asked)
    c = Channel(d, r, d.ids[id(r)])
    z, label = c.through(s), f"hinf{k}"
    form = dict(s=s, y=c.y(u), w=f"{s}W{c.S}{over}", a=c.rates(u), z=z, k=k)
    form["h"] = "0" if z == "0" else "."
    form |= square(d, f", ({form['w']})'")
    if d.slack:
        yield "pair", "hinf", f"{label}.i: " + HINF_SLACK.format(**form)
    else:
        yield "pair", "hinf", f"{label}.i.j: " + HINF.format(**form)


def noise(d, r):
    """The H2 norm: P lies above the Gramian of what w reaches, J above that of y."""
    more = [x for x in ("outputs", "inputs") if x in r]
    keys(r, " ".join(["kind name h2", *more]))
    need(d.p, "the plant has no disturbance")
    t, (s, u, over), k = d.t, d.size(r), tag(r, d.asked)
    c = Channel(d, r, d.ids[id(r)], rates=False)
    y, w, one = c.y(u), f"{s}W{c.S}{over}", s.strip() or "1"
    t.point(f"J_h2{k}", f"J {r['name']}", f"symmetric {c.height}")
    J = f"J_h2{k}" if d.refuted or not s else f"{s}J_h2{k}"  # there it stands for s J
    i, cross = (".i", SLACK_CROSS) if d.slack else (".i.j", "")
    tick = square(d, f", ({w})'")
    last = f" ., {tick['tick']}-epsilon he(EVE), epsilon {w};" if d.slack else ""
    one += "/dt" * d.ticks
    yield "once", "trace", f"h2{k}.trace: {s}h2{k}^2 - tr({J}) > 0"
    dots = "., ., " if d.slack else "., "
    line = f"-[he(Theta), {cross}{w}{tick['c']};{last} {dots}-{one}{tick['v']}"
    line += (SQUARE.replace("., ., .", "., .") if tick["c"] else "") + "] > 0"
    yield "pair", "noise", f"h2{k}.noise{i}: {line}"
    yield "pair", "output", f"h2{k}.output{i}: [{J}, ({y})'; ., EPE] > 0"


def peak(d, r):
    """Lemma 2.2: each x0 lies in the ellipsoid x' P^-1 x < 1, and |K x| <= u_max there.

    So does what lies between them and their negatives: an ellipsoid is convex and even.
    """
    t, (s, u, over), k = d.t, d.size(r), tag(r, d.asked)
    points, some = start(t, r, d.N, d.m, k)
    back, to = ("back ", " back'") if "back" in t.data else ("", "")
    X, i, one = d.frame["X"], ".i" if d.slack else "", s.strip() or "1"
    where = "pair" if d.slack else "once"
    inner = f"{back}(he({d.frame['V']}) - {X}.i){to}" if d.slack else f"{back}{X}{to}"
    for block, label, x0 in points:
        line = f"{label}{i}: [{one}, {s}{x0}{to}{over}; ., {inner}] > 0"
        yield where, block, line
    lower = f"{s}u_max{k}^2" + (f"/({u}scale)^2" if back else "")
    if not r["acceleration"] or d.d["K_A"] is None:
        Y = f"({some} Y)" if some else "Y"
        yield where, "u_max", f"u_max{k}{i}: [P{i}, {Y}'; ., {lower}] > 0"
        return
    need(d.certain, "M - B K_A is uncertain")
    rest = ", O(n, rows(U))" if "U" in t.data else ""  # z'' = inertia^-1 (A x + B K x)
    P, T = "V'" if d.slack else "P", "T " if back else ""
    force = f"K_A inv(M.i - B.i K_A) ([-S.i, -D.i{rest}] {T}{P}{'/scale' * bool(back)}"
    force += " + B.i Y) + Y"
    force = f"{some} ({force})" if some else force
    where = "pair" if d.slack else "all"
    yield where, "u_max", f"u_max{k}.i: [P{i}, ({force})'; ., {lower}] > 0"


def start(t, r, N, m, k):
    """The states from which a bound of u holds, (block, label, row) of each x0',
    and the name of the rows that pick its inputs; the names end with ``k``.
    """
    keys(r, "kind name u_max x0 acceleration" + " u" * ("u" in r))
    need(r["x0"], "x0 has no state")
    x0, some = f"x0{k}", ""
    if "u" in r:
        good = len({*r["u"]}) == len(r["u"]) > 0 and all(0 <= i < m for i in r["u"])
        need(good, "u aren't inputs")
        some = "; ".join(f"pick({i + 1}, {m}, 1)" for i in r["u"])
        t.write(f"some{k} = [{some}]")
        some = f"some{k}"
    if not isinstance(r["x0"][0], list):
        t.data[x0] = [[e] for e in r["x0"]]
        mat(t.data[x0], N, 1, name="x0")
        t.places[id(r), "x0"] = "|" + x0
        return [("x0", x0, f"{x0}'")], some
    count = len(r["x0"])
    mat(r["x0"], count, N, name="x0")
    t.put(x0, r, "x0")
    several = range(1, count + 1)
    return [(f"x0 {j}", f"{x0}.of.{j}", f"pick({j}, {count}, 1) {x0}")
            for j in several], some  # fmt: skip


def cost(d, r):
    """Theorem 2.4: tr J bounds the cost of x'Qx + u'Ru."""
    t, (s, u, over) = d.t, d.size(r)
    states = weights(t, r, d)
    if "C" in r:  # Q = C'C
        t.write("L = Cq'", "Wq = I(rows(Cq))")
    else:
        Q, whole = mat(r["Q"], d.N, d.N, name="Q"), "Q"
        if "N" in r:  # 2 x'N u: a square of u + R^-1 N'x, and the rest
            N, R = (mat(r[x], k, d.m, name=x) for x, k in (("N", d.N), ("R", d.m)))
            need(definite(R), "R must be positive definite")
            Q = Q + (N @ inverse(R) @ N.T).times(Fraction(-1))
            whole = "Q - Nq inv(R) Nq'"
        t.data["L"], t.data["Wq"] = factors(Q)
        t.write("Wq: Wq > 0", f"Q: L inv(Wq) L' == {whole}")
    t.point("J", "J", f"symmetric {d.N if states else d.p}")
    J = "J" if d.refuted or not s else f"{s}J"  # there it stands for s J
    X, i, framed = d.frame["X"], ".i" if d.slack else "", "back" in t.data
    back, to = ("back ", " back'") if framed else ("", "")
    yield "once", "trace", f"trace: {s}bound{per_tick(d, states)} - tr({J}) > 0"
    if states:
        inner = f"(he({d.frame['V']}) - {X}.i)" if d.slack else X
        noise = f"{s}back'{over}" if framed else s.strip() or "1"
        line = f"cost{i}: [{J}, {noise}; ., {back}{inner}{to}] > 0"
        yield "pair" if d.slack else "once", "cost", line
    else:
        inner, i = ("he(EVE) - EPE", ".i") if d.slack else ("EPE", ".i.j")
        yield "pair", "cost", f"cost{i}: [{J}, {s}W'{over}; ., {inner}] > 0"
    more = {"y": "EY/scale" if framed else "EY"}
    more["r2"] = f"/({u}scale)^2" if framed else ""
    if "N" in r:
        more["y"] += " + EP Nq inv(R)" + "/scale" * framed
    more |= square(d)
    form, i = (LQR_SLACK, ".i") if d.slack else (LQR, ".i.j")
    yield "pair", "lqr", f"lqr{i}: " + form.format(s=s, u=u, **more)


def square(d, w=""):
    """The parts that a block has more at ticks: the square of the change, w in it."""
    pairs = d.ticks and not d.slack
    return {"tick": "dt EPE" * d.ticks, "c": ", Theta'" * pairs, "o": ", 0" * pairs,
            "v": w * pairs, "last": SQUARE * pairs}  # fmt: skip


def per_tick(d, states):
    """The factor from a bound of the cost in a tick to what x' P x falls by."""
    return (" dt" if states else "/dt") * d.ticks


def weights(t, r, d):
    """The weights of a cost become data; whether the noise is on the states."""
    good = r["noise"] == "states" or (r["noise"] == "F" and d.p)
    need(good, 'noise must be "states", or "F" with F')
    mine = {"C": "Cq"} if "C" in r else {"Q": "Q", **({"N": "Nq"} if "N" in r else {})}
    sizes = dict(C=(None, d.N), Q=(d.N, d.N), N=(d.N, d.m))
    keys(r, " ".join(["kind name R noise bound", *mine]))
    t.put("R", r, "R", (d.m, d.m))
    for key, name in mine.items():
        t.put(name, r, key, sizes[key])
    t.write("R: R > 0")
    return r["noise"] == "states"


def own(d, r):
    """Blocks of somebody's theorem: what they mean is the author's word."""
    k = d.ids[id(r)]
    for where, block, text in r["theorem"]["blocks"]:
        need(where in ("once", "pair"), "a block is written once, or for each pair")
        tokens = Parser(text)
        tokens.expression()
        good = tokens.k == len(tokens.t) and not re.search(r"[\n#]", text)
        need(good, f"a block of an author is one matrix, not {text!r:.60}")
        label = f"own.{k}." + re.sub(
            r"\W", "_", sane(block or r["name"]), flags=re.ASCII
        )
        at = "" if where == "once" else ".i" if d.slack else ".i.j"
        yield where, block, f"{label}{at}: {text} > 0"


def stability(d):
    """That a plant of a file is stable."""
    return INSIDE if "dt" in d["plant"] else STABILITY


def stated(stable, d, signal="K x"):
    """The claims, `stable` first, and by name the requirements that prove them."""
    asked, ticks = d["requirements"], "dt" in d["plant"]
    names = [(r["kind"], sane(r["name"])) for r in asked]
    named = [NAMES.get(kind, name) == name for kind, name in names
             if kind not in SEVERAL]  # fmt: skip
    need(all(named), "a requirement has another name than its kind")
    need(len(set(names)) == len(names), "a requirement comes twice")
    sure = (r for r in asked if implies_stability(r, ticks))
    owners = [next(sure, stability(d))]
    owners += [next(o for o in asked if repeats(r, o)) for r in asked]
    words = [stable, *(claim(r, signal, ticks) for r in asked)]
    return words, {key_of(r): r for r in owners}


def numbers_of(t, asked, k, r, ticks):
    """The numbers of the k-th requirement become data; words need their signs."""
    if r["kind"] == "region":
        t.put(f"alpha{'.z' * ticks}.{k}", r, "alpha")
        t.put(f"beta.{k}", r, "beta")
        if ticks:
            t.write(f"alpha.{k} = {AT_TICKS.format(k)}")
        for name in FORMS[r["form"]].split():
            t.put_number(f"{name}.{k}", r, name)
        return
    for name in NUMBERS[r["kind"]].split():
        if r[name] is not None:
            full = name + tag(r, asked)
            t.put_number(full, r, name)
            t.write(f"sign.{full}: {full} > 0")
    if r["kind"] == "gamma" and r["mu"] is None:
        t.write(f"mu{tag(r, asked)} = 1")


def key_of(r):
    return r["kind"], r["name"]


def size_of(r, asked):
    """The name of a requirement's size in a text."""
    if r["kind"] in BLOCKS:
        return "s_" + r["kind"] + tag(r, asked)
    return f"own.{1 + next(k for k, q in enumerate(asked) if q is r)}.size"


def tag(r, asked):
    """The ending that distinguishes a requirement's names from others of its kind."""
    plain = r["name"] == NAMES.get(r["kind"], r["name"])
    return "" if plain else f".{1 + next(k for k, q in enumerate(asked) if q is r)}"


def factors(rest):
    """L and W with Q = L W^-1 L' and W diagonal."""
    columns, sizes, N = [], [], rest.r
    need(definite(rest, semi=True), "Q must be positive semidefinite")
    for k in range(N):
        pivot = rest.at(k, k)
        if pivot:
            column = Mat(N, 1, [[u[k]] for u in rest.a], rest.d).times(1 / pivot)
            columns.append([column.at(i, 0) for i in range(N)])
            sizes.append(1 / pivot)
            rest = rest + (column @ column.T).times(-pivot)
    n = len(sizes)
    L = [[str(c[i]) for c in columns] for i in range(N)] if n else {"zeros": [N, 0]}
    W = [[str(e) if i == j else "0" for j in range(n)] for i, e in enumerate(sizes)]
    return L, W or {"zeros": [0, 0]}


def size_name(r):
    """The name of a requirement's size among the unknowns."""
    return " ".join(["size for", *dict.fromkeys((r["kind"], r["name"]))])


def repeats(r, other):
    """True if both are the same, or one region by matrices of whatever size."""
    if r is other or not r["kind"] == other["kind"] == "region":
        return r is other
    (a, b, _), (c, d, _) = region(r), region(other)
    one, two = (next((abs(e) for row in x for e in row if e), 1) for x in (b, d))
    return [[[two * e for e in u] for u in x] for x in (a, b)] == [
        [[one * e for e in u] for u in x] for x in (c, d)]  # fmt: skip


def implies_stability(r, ticks=False):
    if r["kind"] != "region":
        return r["kind"] in ("gamma", "h2", "cost")
    alpha, beta, _ = region(r)
    if ticks:
        disk = r["form"] == "disk"
        return disk and Fraction(r["rho"]) + abs(Fraction(r["centre"])) <= 1
    return len(beta) == 1 and beta[0][0] > 0 <= alpha[0][0]


def claim(r, signal="K x", ticks=False):
    """The words that the blocks of a requirement prove."""
    if r["kind"] == "region":
        return of_z(region(r)[2]) if ticks else region(r)[2]
    if r["kind"] not in BLOCKS:
        return f"{r['name']}, by its author's theorem: {json.dumps(r['claim'])}"
    if r["kind"] in ("gamma", "h2"):
        whose = "its" if r["name"] == r["kind"] else f"{r['name']}: its"
        norm = {"gamma": "H-infinity", "h2": "H2"}[r["kind"]]
        return f"{whose} {norm} norm{ends(r)} is below {r[r['kind']]}"
    if r["kind"] == "input":
        signal += " + K_A z''" if r["acceleration"] else "(t)"
        if "u" in r:
            some = ", ".join(f"u{i + 1}" for i in r["u"])
            signal = some + (signal[1:] if signal[:1] == "u" else f" of {signal}")
        named, x0 = "" if r["name"] == NAMES["input"] else f"{r['name']}: ", "x0"
        if r["x0"] and isinstance(r["x0"][0], list):
            x0 = f"each x0 between {len(r['x0'])} states and their negatives"
        return f"{named}|{signal}| <= {r['u_max']} from {x0} (with r = 0, w = 0)"
    return f"its quadratic cost is below {r['bound']} times the largest noise intensity"


BLOCKS = {"region": poles, "gamma": gamma, "h2": noise, "input": peak, "cost": cost,
          "stability": poles}  # fmt: skip
