"""The text of a plant."""

from fractions import Fraction

from . import payment
from .arithmetic import need
from .families import given_vertices, keys
from .text import decimal_text, ratio

SECOND = """E.i = [I(n), 0{z}; 0, {M}{z}{last}]
A.i = [0, I(n){U0}; -S.i, -D.i{z}{U}]
Bu.i = [O(n, cols(B.i)); B.i{push}]
Bw.i = [O(n, cols(F.i)); F.i{gust}]"""
OUTPUTS = {"C": "C", "D_u": "D", "D_w": "Z", "C_a": "H"}
OTHER = "E.i = Ed.i", "A.i = Ad.i", "Bu.i = Bd.i", "Bw.i = Wd.i"
CHANGE = "E.i = dt Ed.i", "A.i = Ad.i - Ed.i", *OTHER[2:]  # (next x - x)/dt for x'


def plant(t, d, ticks=False):
    """The lines of E x' = A x + B u + W w, y = C x + D u; (vertices, N, m, p)."""
    kind, vertices = d["plant"]["kind"], given_vertices(d["plant"])
    known = ticks and kind == "descriptor"
    need(known or "dt" not in d["plant"], "a plant of ticks isn't known here")
    family = "parameters" in d["plant"] or "box" in d
    if "box" in d:
        vertices = payment.corners(d["box"], kind, len(vertices))
    entry, t.vertices = ratio if family else decimal_text, vertices
    t.sets["vertices"] = [[str(i + 1)] for i in range(len(vertices))]
    if kind == "second order":
        names = dict(zip("MDSBF", "MDSBF"))
        n, U = len(vertices[0]["M"]), len(d["U"])
        N = 2 * n + U
    else:
        none = [v.get("C_a") is None for v in vertices]
        need("dt" not in d["plant"] or all(none), "there is no x' at ticks")
        need(d["U"] == [] and d.get("K_A") is None, "this plant has no U, no K_A")
        names, N = dict(E="Ed", A="Ad", B="Bd", B_w="Wd"), len(vertices[0]["E"])
    sizes, beside = set(), kind == "descriptor" and "C" in vertices[0]
    for i, v in enumerate(vertices, 1):
        none = dict.fromkeys(OUTPUTS) if beside else {}
        keys(none | v, " ".join([*names, *none]), " of a vertex of the plant")
        for key, name in names.items():
            t.put(f"{name}.{i}", v, key, entry=entry)
        square, (B, W) = list(names)[:-2], (v[x] for x in list(names)[-2:])
        shapes = [(len(v[x]), len(v[x][0])) for x in square]
        sizes.add((*shapes, len(B), len(B[0]), len(W), len(W[0])))
    need(len(sizes) == 1, "the vertices of the plant differ in size")
    (*shapes, rows, m, high, p) = sizes.pop()
    good = {*shapes} == {(rows, rows)} and high == rows
    need(good, "a matrix of the plant has a wrong shape")
    if kind == "descriptor":
        outputs_of(t, d["plant"], vertices, dict(C=N, D_u=m, D_w=p, C_a=N), entry)
        ticks = "dt" in d["plant"]
        if ticks:
            t.put_number("dt", d["plant"], "dt")
            t.write("sign.dt: dt > 0")
        t.write(*(CHANGE if ticks else OTHER), loop="i in vertices")
        return vertices, N, m, p
    if U:
        t.put("U", d, "U", (U, n))
    M = "M.i"
    if d.get("K_A") is not None:
        t.put("K_A", d, "K_A", (m, n))
        M = "M.i - B.i K_A"
    more = dict(z=", 0", last="; 0, 0, I(rows(U))", U0=", O(n, rows(U))",
                U="; U, O(rows(U), n), 0", push="; O(rows(U), cols(B.i))",
                gust="; O(rows(U), cols(F.i))")  # fmt: skip
    more = {k: v if U else "" for k, v in more.items()}
    t.write("n = rows(M.1)", f"C = [I(n), O(n, {'n + rows(U)' if U else 'n'})]")
    t.write(*SECOND.format(M=M, **more).split("\n"), loop="i in vertices")
    return vertices, N, m, p


def vertex_of(t, k):
    """The number of one of the vertices, from 1; a file counts from 0."""
    need(0 <= k < len(t.vertices), "a vertex must be one of the plant's, from 0")
    return k + 1


def coordinates(t, c, N):
    """x = T xi, u = scale v, and rows times ``left`` become data."""
    keys(c, "left T back scale sizes")
    for name in ("left", "T", "back"):
        t.put(name, c, name, (N, N))
        t.write(f"{name}.regular: inv({name}) {name} == I({N})")
    t.put_number("scale", c, "scale")
    t.write("sign.scale: scale > 0")


def outputs_of(t, plant, vertices, widths, entry):
    """C, D, Z and H of a plant without z: one for all where they are C and D."""
    several = [(v.get("C"), v.get("D_u")) for v in vertices]
    alike = all(x == several[0] for x in several)
    alike = alike and not any(v.get(k) for v in vertices for k in ("D_w", "C_a"))
    if "C" in plant and alike:
        v = vertices[0] if "C" in vertices[0] else plant  # of ranges, or of a box
        t.put("C", v, "C", (None, widths["C"]), entry)
        if v.get("D_u") is not None:
            t.put("D", v, "D_u", (len(v["C"]), widths["D_u"]), entry)
        return
    for key, name in OUTPUTS.items():
        there = [v.get(key) is not None for v in vertices]
        need(all(there) or not any(there), f"{key}: an output that one vertex hasn't")
        for i, v in enumerate(vertices, 1):
            if there[0]:
                t.put(f"{name}.{i}", v, key, (len(v["C"]), widths[key]), entry)
    need("C.1" in t.data, "there is no output")


def distinct(vertices, names=None):
    """Indices of the vertices without those that repeat an earlier one."""
    data = [v if names is None else [v[x] for x in names] for v in vertices]
    return [i for i, v in enumerate(data) if v not in data[:i]]


def suffice(E, points):
    """True if E^-1 [A B W] between the vertices is a mean of the vertices' ones.

    Up to a congruence the blocks of a design are affine in it, so that no pair of
    two vertices is needed then. With E + t u v' for E the inverse moves on a
    segment, and so does the quotient where A, B and W move along u, too; det E is
    affine in t. So it is enough that det E has one sign at all vertices and that
    their columns differ by multiples of one u; or that they are a box, all sums of
    some vertices with one E and any of some changes, each along a u of its own.
    ``points`` are the entries of [E A B W] by columns.
    """
    N = E[0].r
    points = dict(zip(points, E))
    first, *others = sorted(points)

    def change(point):
        return tuple(a - b for a, b in zip(point, first))

    box = {p for p in points if p[: N * N] == first[: N * N]}
    if len(box) == len(points):
        return True
    if not along_one(N, map(change, others)):
        for point in others:
            if point not in box:
                if not along_one(N, [change(point)]):
                    return False
                box |= {tuple(map(sum, zip(p, change(point)))) for p in box}
                if not box <= set(points):
                    return False
    return one_sign(points.values())


def corners_suffice(E, points):
    """The same where vertices are the corners of ranges, and plants have values there.

    The plants are affine in each parameter. Along one that moves E by multiples of a
    column, and A, B and W too, det E is affine and the quotient moves on a segment;
    along one that leaves E the quotient is affine. So that of any plant is a mean of
    two with this parameter at its ends, and then of corners. The column may depend on
    the other parameters: two rows of a change have minors of degree two in each,
    which are zero if they are at both ends and halfway. The last one changes first.
    """
    N, axes = E[0].r, len(E).bit_length() - 1
    for axis in range(axes):
        before = [k for k in range(len(E)) if not k >> axis & 1]
        pairs = [(points[k], points[k + (1 << axis)]) for k in before]
        changes = [[b - a for a, b in zip(*pair)] for pair in pairs]
        if not any(any(c[: N * N]) for c in changes):
            continue
        for _ in range(axes - 1):  # the first of the others becomes the last of them
            half = len(changes) // 2
            ends = list(zip(changes[:half], changes[half:]))
            middles = [[(x + y) / 2 for x, y in zip(*both)] for both in ends]
            changes = [c for (a, b), m in zip(ends, middles) for c in (a, m, b)]
        if not all(along_one(N, [c]) for c in changes if any(c)):
            return False
    return one_sign(E)


def along_one(N, changes):
    """True if all columns, of N entries, of some changes are multiples of one u."""
    columns = [c[k : k + N] for c in changes for k in range(0, len(c), N)]
    u = next(filter(any, columns))
    k = next(k for k in range(N) if u[k])
    return all(c[r] * u[k] == u[r] * c[k] for c in columns for r in range(N))


def one_sign(several):
    dets = [determinant(E) for E in several]
    return all(d > 0 for d in dets) or all(d < 0 for d in dets)


def determinant(x):
    rows, product = [list(u) for u in x.a], Fraction(1, x.d**x.r)
    for k in range(len(rows)):
        top = next((r for r in range(k, len(rows)) if rows[r][k]), None)
        if top is None:
            return Fraction(0)
        rows[k], rows[top] = rows[top], rows[k]
        product *= rows[k][k] * (1 if top == k else -1)
        for r in range(k + 1, len(rows)):
            f = Fraction(rows[r][k]) / rows[k][k]
            rows[r] = [a - f * b for a, b in zip(rows[r], rows[k])]
    return product
