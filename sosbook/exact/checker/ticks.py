"""The matrices of a sampled loop: what stands between one tick and the next.

At the ticks a computer makes u(k) of the plant's state. The plant gets it a delay
later and holds it for the time T. Of the delay some ticks are whole; during what is
left, ``late``, the input before still acts. So the loop's state is s = [x; older
inputs; the law's own states; w], where the norm's disturbance w, if there is one, is
held from tick to tick, and

    [x; first; second] = act s,    x(k+1) = [I, 0] e^(second (T - late)) e^(first late)

of that, where ``first`` and ``second`` are the inputs that act one after the other, and
all other states of s(k+1) are ``later`` s.
"""

from fractions import Fraction

from .arithmetic import Mat, need
from .families import CONSTANT, every_plant, keys, listed, ranges
from .outputs import at_vertex
from .plants import along_one, determinant, one_sign, plant, suffice
from .requirements import claim
from .text import Text, number

LONGEST = 1000  # ticks that a delay may last
LAW = """u = [{gain}, O({g}, {rest}), {own}, {read}]
full = [[I({order}), O({order}, {q} + {k})]; u; [O({k}, {order} + {q}), I({k})]]
none = [O({k}, {N} + {W}), I({k})]
act = [[I({N}), O({N}, {W} + {k})]; [O({g}, {N}), {older}, O({g}, {k})]; none; \
[O({g}, {N}), {newer}, O({g}, {k})]; none] full
shift = [O({g} {past}, {N}), {kept}, O({g} {past}, {k})] full
first = [I({N}), O({N}, {m}), O({N}, {m}); O({m}, {N}), I({m}), O({m}, {m})]
second = [I({N}), O({N}, {m}), O({N}, {m}); O({m}, {N}), O({m}, {m}), I({m})]"""
SEEN = """seen = [1/gamma [{C}, O({h}, {g} {past}), {D}, {Z}, O({h}, {k} - {p})] full; \
O({k} - {h}, {n})]
w = [O({n} - {k}, {k}); I({k})]"""
SIDE = "side.{k}.{x}: {x}.{a} - {x}.{b} == {x}.{c} - {x}.{d}"
HELD = ", at the ticks, with a w that is held from tick to tick"
READ = " and is part of what K reads"


class Ticks:
    """A text in the making, ``t``, with the matrices of a sampled loop.

    ``N``, ``m``, ``n``: how many states of the plant, held inputs (u and w), and states
    of the loop there are; ``T`` and ``late``: the ends of both times, whose names in
    the text are in ``times``; ``corners``: names of the plants between which all others
    lie, means of them, or a box with as many ``axes``.
    """

    def __init__(self, d):
        t, self.d = Text(d), d
        self.t = t
        vertices, self.N, self.g, self.p = sizes = plant(t, d)
        self.many, given = len(vertices), t.values()
        self._clock()
        self.h = self.k = 0
        if d["norm"] is not None:
            self._channel(d["norm"], sizes)
        self.m = self.g + self.k
        self._law(d["K"])
        self._plants(given)

    def _clock(self):
        """The ends of T, and of what a delay leaves beyond its whole ticks."""
        t, d = self.t, self.d
        for x in ("T", "delay"):
            for k, end in enumerate(("lo", "hi")):
                t.put_number(f"{x}.{end}", d[x], k)
        (lo, hi), late = self.T, self.late = [list(map(number, d[x]))
                                              for x in ("T", "delay")]  # fmt: skip
        odd = "T is positive, a delay isn't negative, and lasts no more than 1000 ticks"
        need(0 < lo <= hi and 0 <= late[0] <= late[1] <= LONGEST * lo, odd)
        self.varies = lo < hi or late[0] < late[1]
        whole = int(late[0] // lo) if lo == hi else 0
        self.late = [x - whole * lo for x in late]
        longer = "a delay that varies must lie within one interval"
        need(self.late[0] <= lo and self.late[1] <= hi, longer)
        t.write(*(f"late.{x} = delay.{x} - {whole} T.lo" for x in ("lo", "hi")))
        self.whole, self.shared = whole, self.late[1] > 0
        self.past = whole + self.shared  # older inputs in the loop's state
        self.times = {("T", hi): "hi", ("late", self.late[1]): "hi"}
        self.times |= {("T", lo): "lo", ("late", self.late[0]): "lo"}

    def _channel(self, r, sizes):
        """w and z / gamma, as many: zeros join the fewer ones."""
        t = self.t
        own = [x for x in ("outputs", "inputs") if x in r]
        need(r["kind"] == "gamma" and self.p, "a norm is that of H-infinity, from w")
        keys(r, " ".join(["kind name gamma mu", *own]))
        need(number(self.d["rate"]) == 1, "a norm is proven with a rate of one")
        t.put_number("gamma", r, "gamma")
        t.write("sign.gamma: gamma > 0")
        jumps = any({"acceleration", "rate"} & {*part} for part in r.get("outputs", ()))
        need(not jumps and not {"H", "H.1"} & {*t.data}, "an acceleration jumps")
        C, D, Z, self.S, self.h = at_vertex(t, self.d, sizes, r, 1)
        for name in (C, D, Z):
            if name[-2:] == ".1" and f"{name[:-2]}.1" in t.data:
                alike = f"alike.{name[:-2]}.i: {name[:-2]}.i == {name}"
                t.write(alike, loop="i in vertices")
        self.p = len(r["inputs"]) if self.S else self.p
        self.k = max(self.p, self.h)
        zero = "O({h}, {p})"
        Z = f"{Z}{self.S}" if Z else zero
        self.seen = dict(C=C, D=D or f"O({self.h}, {self.g})", Z=Z)

    def _law(self, K):
        """The maps from s to what acts, and to what the loop keeps."""
        t, N, g, k, past = self.t, self.N, self.g, self.k, self.past
        order, q, read = N + g * past, 0, f"O({g}, {k})"
        if isinstance(K, dict):
            q, read = self._program(K, order)
            gain, own, width = "law.D", "law.C", N
        else:
            t.put("gain", self.d, "K")
            gain, own, width = "gain", f"O({g}, 0)", len(K[0]) if K else 0
            need(len(K) == g and width in (N, order), "K has another size")
        W, parts = g * (past + 1), past + 1

        def age(j):  # u(k - j), of [older inputs; u(k)]
            where = f"pick({j or parts}, {parts}, {g})"
            return where if j <= past else f"O({g}, {W})"

        kept = "; ".join(map(age, range(past))) if past else f"O(0, {W})"
        form = dict(gain=gain, own=own, rest=order - width, read=read, order=order, q=q,
                    k=k, N=N, g=g, W=W, m=self.m, past=past, older=age(self.whole + 1),
                    newer=age(self.whole), kept=f"[{kept}]")  # fmt: skip
        t.write(*LAW.format(**form).split("\n"))
        self.n = order + q + k
        later = ["shift"] + ["keep"] * bool(q)
        if k:
            form |= {x: y.format(h=self.h, p=self.p) for x, y in self.seen.items()}
            seen = SEEN.format(**form, h=self.h, p=self.p, n=self.n)
            t.write(*seen.split("\n"))
            later.append("seen")
        t.write(f"later = [{'; '.join(later)}]")

    def _program(self, K, order):
        """A law's own matrices: how many states it has, and how it reads w."""
        t, N, g, k = self.t, self.N, self.g, self.k
        more = [x for x in ("inputs", "outputs", "B_w", "D_w") if x in K]
        keys(K, " ".join(["A B C D dt", *more]))
        q, dt = len(K["A"]), K["dt"]
        lo, hi = self.T
        timed = dt not in (None, True) and lo <= number(dt) <= hi
        need(timed or dt is True or (dt is None and not q), "K has another clock")
        shapes = dict(A=(q, q), B=(q, N), C=(g, q), D=(g, N))
        for x, size in shapes.items():
            t.put(f"law.{x}", K, x, size)
        reads = "D_w" in K
        need(reads == ("B_w" in K), "B_w and D_w say together how K reads w")
        if reads:
            for x in ("B_w", "D_w"):
                t.put(f"law.{x}", K, x, (len(K[x[0]]), len(K["D_w"][0])))
        wide = f"O({q}, {k})"
        read = f"O({g}, {k})"
        if reads and k:
            rest = k - self.p
            wide = f"[law.B_w{self.S}, O({q}, {rest})]"
            read = f"[law.D_w{self.S}, O({g}, {rest})]"
        if q:
            t.write(f"keep = [law.B, O({q}, {order - N}), law.A, {wide}]")
        return q, read

    def _plants(self, given):
        """E and [A B] of the corners; where a mean keeps E^-1 [A B] one, E is one.

        The values of all parts are ``given``.
        """
        t, N, order = self.t, self.N, self.d["corners"]
        parts = ["A", "Bu", *["Bw"] * bool(self.k)]
        self.axes = 0
        if order is not None:
            self.axes = self._box(order, ["E", *parts])
        self.corners = [str(i + 1) for i in order or range(self.many)]
        E = [given[f"E.{i}"] for i in self.corners]
        points = [tuple(e for x in ("E", *parts) for e in columns(given[f"{x}.{i}"]))
                  for i in self.corners]  # fmt: skip
        mean = separable(E, points, self.axes) if self.axes else suffice(E, points)
        both = "[A.i, Bu.i]"
        if self.k:
            both = f"[A.i, Bu.i, Bw.i{self.S}, O({N}, {self.k - self.p})]"
        lines = "e.i = E.i", f"x.i = {both}"
        if mean:
            lines = f"e.i = I({N})", f"x.i = near(inv(E.i) {both})"
        t.write(*lines, loop="i in vertices")

    def _box(self, order, parts):
        """The axes of a box whose corners are the vertices, in some order.

        The first half of the corners has one value on the first axis, and so on. Plants
        with parameters are such boxes; others are, where each corner that two axes move
        is where both of them lead.
        """
        axes = len(order).bit_length() - 1
        good = sorted(order) == list(range(self.many)) and len(order) == 1 << axes > 2
        need(good, "the corners of a box are the vertices")
        if "parameters" in self.d["plant"]:
            _, pieces, degrees, _ = ranges(self.d["plant"])
            plain = set(pieces) == set(degrees) == {1} and order == sorted(order)
            need(plain, "these ranges have other corners")
            return axes
        for k in range(len(order)):
            low = k & -k
            if k != low:
                a, b, c, d = (order[x] + 1 for x in (k, k - low, low, 0))
                self.t.write(
                    *(SIDE.format(k=k, x=x, a=a, b=b, c=c, d=d) for x in parts)
                )
        return axes


def said(d, many):
    """The claims of a proof with data ``d``, of a plant with so ``many`` vertices."""
    centre, rate = (float(number(d[x])) for x in ("centre", "rate"))
    clock, varies = words(*([float(number(e)) for e in d[x]] for x in ("T", "delay")))
    more = [x for x in (called(d), clock) if x]
    which = every_plant(d["plant"], many, CONSTANT)
    loop = ", ".join([f"the sampled loop of {which}", *more]) + "," * bool(more)
    if centre:
        disk = f"|z - {centre!r}| < {rate!r}".replace("- -", "+ ")
        claims = [f"all eigenvalues of {loop} are in {disk}"]
    else:
        slow = f": every motion decays at least as {rate!r}^k" * (rate != 1)
        claims = [f"{loop} is stable{varies}{newest(d) * bool(varies)}{slow}"]
    if d["norm"] is not None:
        reads = isinstance(d["K"], dict) and "D_w" in d["K"]
        claims.append(claim(d["norm"]) + HELD + READ * reads)
    return claims


def newest(d):
    """The words for what a plant holds, where a delay varies over several ticks."""
    (T, longest), (early, late) = (map(number, d[x]) for x in ("T", "delay"))
    several = T == longest and late > (early // T + 1) * T
    return ", the newest command that has arrived being held" * several


def words(T, delay):
    """The times that don't vary, in words, and what is said of those that do."""
    fixed, ranges_ = [], []
    for name, one, (low, high) in (("sampling intervals", "a tick every {!r} s", T),
                                   ("delays", "a delay of {!r} s", delay)):  # fmt: skip
        if low < high:
            ranges_.append(f"{name} in [{low!r}, {high!r}] s")
        else:
            fixed.append(one.format(low) if low else "no delay")
    many = f" for every sequence of {' and '.join(ranges_)}" if ranges_ else ""
    many += ", none longer than its interval" * (len(ranges_) == 2)
    return "with " + " and ".join(fixed) if fixed else "", many


def called(d):
    """The words for the names of a law's signals, or for their order without any.

    The plant's z may have other names than z1, z2, ..: all other names follow from
    these, so that none can be another's.
    """
    K = d["K"]
    if not isinstance(K, dict):
        return ""
    made, read, n = signals(d)
    if not K.keys() & {"inputs", "outputs"}:
        return f"where K makes {', '.join(made)} of {', '.join(read)}, in this order"
    own = [K.get(x) for x in ("outputs", "inputs")]
    z = (own[1] or [])[:n]
    good = own == [*signals(d, z)][:2]
    need(good, f"K.inputs and K.outputs aren't {', '.join(read)} and {', '.join(made)}")
    return "" if own[1] == read else f"with z = {listed(z, n)}"


def signals(d, z=()):
    """Names of what a law makes and of what it reads: the plant's inputs and states.

    ``z``: what its coordinates are called, if not z1, z2, ..; of these there are so
    many as the third thing says.
    """
    plant, inputs = d["plant"], range(1, len(d["K"]["D"]) + 1)
    made = [f"u{k}" for k in inputs] if len(inputs) > 1 else ["u"]
    v = plant if "vertices" not in plant else plant["vertices"][0]
    if "M" not in v:
        x = [f"x{k + 1}" for k in range(len(v["E"]))]
        return made, plant.get("states", x), 0
    z = [*z] or [f"z{k + 1}" for k in range(len(v["M"]))]
    read = z + [f"{x}'" for x in z] + [integral(row, z) for row in d["U"]]
    return made, read, len(v["M"])


def integral(row, z):
    """The integral of a row of U times z, in words."""
    there = [(float(number(e)), x) for e, x in zip(row, z) if number(e)]
    some = [x if e == 1 else f"{e:g} {x}" for e, x in there]
    return f"integral of {' + '.join(some)}"


def separable(E, points, axes):
    """True if E^-1 [A B] of a box is affine in a parameter of its own for each axis.

    Along an axis that leaves E it is affine. Where all changes along it are multiples
    of one column it moves on a segment, at t r / (1 - t + t r) of its length, with
    det E r times as large at its end: one function of t if all edges have the same r.
    The entries of [E A B] by columns are ``points``.
    """
    if not one_sign(E):
        return False
    N, dets = E[0].r, [determinant(x) for x in E]
    for axis in range(axes):
        step = 1 << axes - 1 - axis
        edges = [(k, k | step) for k in range(len(E)) if not k & step]
        changes = [[y - x for x, y in zip(points[a], points[b])] for a, b in edges]
        if not any(any(c[: N * N]) for c in changes):
            continue
        if len({dets[b] / dets[a] for a, b in edges}) > 1 or not along_one(N, changes):
            return False
    return True


def columns(x: Mat):
    """The entries of x by columns."""
    return [Fraction(e, x.d) for u in x.T.a for e in u]
