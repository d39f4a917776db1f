"""Which y of a plant the bound of a norm is about, and from which w."""

from types import SimpleNamespace

from .arithmetic import need

SIGNALS = dict(position="z", velocity="z'", acceleration="z''", integral="x3",
               state="x", rate="x'", input="u", disturbance="w")  # fmt: skip
FIRST_ORDER = {"state", "rate", "input", "disturbance", "name"}


def ends(r):
    """From where to where, in words; nothing without outputs and inputs."""
    words = ""
    if "inputs" in r:
        words += " from " + ", ".join(f"w[{i}]" for i in r["inputs"])
    if "outputs" in r:
        words += " to " + "; ".join(map(in_words, r["outputs"]))
    return words


def in_words(part):
    def text(x):
        if isinstance(x, str):
            return x
        return "[" + ", ".join("[" + ", ".join(row) + "]" for row in x) + "]"

    total = " + ".join(f"{text(part[k])} {s}" for k, s in SIGNALS.items() if k in part)
    return f"{part['name']} = {total}" if "name" in part else total


class Channel:
    """The texts of y = C x + H x' + D u + Z w, w = S w', of the k-th requirement.

    The names in ``self.names`` are "" of what there isn't, and end with .i where plants
    differ. With a common P the equation of the plant gives x'.
    """

    def __init__(self, design, r, k, rates=True):
        """Write the outputs' rows and the inputs' columns of requirement k."""
        self.d, self.k, t = design, k, design.t
        self.names = names_of(t, design.d["plant"])
        self.rows = None
        if "outputs" in r:
            self._rows(t, r["outputs"])
        self.S = ""
        if "inputs" in r:
            some, p = r["inputs"], design.p
            good = len(set(some)) == len(some) > 0 and all(0 <= i < p for i in some)
            need(good, "inputs must be numbers of disturbances")
            columns = ", ".join(f"pick({i + 1}, {p}, 1)'" for i in some)
            t.write(f"some.{k} = [{columns}]")
            self.S = f" some.{k}"
        if self.names["H"] and not (rates and design.slack):
            self._solved(t)
        if not rates:
            self._nothing_through(t)

    def _rows(self, t, parts):
        """The rows on each signal become data, and the matrices are made of them."""
        d, k, second = self.d, self.k, self.d.d["plant"]["kind"] == "second order"
        a, n = d.integrals, (d.plain - len(d.d["U"])) // 2
        wide = dict(position=n, velocity=n, acceleration=n, integral=a, state=d.N,
                    rate=d.N, input=d.m, disturbance=d.p)  # fmt: skip
        need(parts, "outputs: there is no row")
        rows, used, count = {x: [] for x in "CHDZ"}, {"C"}, 0
        for place, part in enumerate(parts, 1):
            given = [x for x in SIGNALS if x in part]
            known = {*part} <= {*given, "name"} and (second or {*part} <= FIRST_ORDER)
            need(given and known, "outputs: rows on what this plant hasn't")
            high = {
                wide[x] if isinstance(part[x], str) else len(part[x]) for x in given
            }
            need(len(high) == 1 and min(high), "outputs: rows of two counts")
            (q,), text = high, {}
            count += q
            for x in given:
                text[x] = f"y.{k}.{place}.{x}"
                if isinstance(part[x], str):
                    t.put_number(text[x], part, x)
                    text[x] += f" I({q})"
                else:
                    t.put(text[x], part, x)
                    need(len(part[x][0]) == wide[x] > 0, "outputs: another width")

            def joined(*cells, q=q, text=text):
                some = [text.get(x, f"O({q}, {w})") for x, w in cells if w]
                there = any(x in text for x, _ in cells)
                return "[" + ", ".join(some) + "]" if there else ""

            whole = {
                "C": (d.N, joined(("position", n), ("velocity", n), ("integral", a),
                                  ("", d.N - 2 * n - a)), text.get("state")),
                "H": (d.N, joined(("", n), ("acceleration", n), ("", d.N - 2 * n)),
                      text.get("rate")),
                "D": (d.m, text.get("input")),
                "Z": (d.p, text.get("disturbance")),
            }  # fmt: skip
            for x, (width, *some) in whole.items():
                total = " + ".join(filter(None, some))
                used |= {x} if total else set()
                rows[x].append(total or f"O({q}, {width})")
        self.rows = count
        for x, several in rows.items():
            self.names[x] = f"{x}y.{k}" if x in used else ""
            one = several[0] if len(several) == 1 else "[" + "; ".join(several) + "]"
            if x in used:
                t.write(f"{x}y.{k} = {one}")

    def _solved(self, t):
        """x' is put in: E.i x' = A.i x + Bu.i u + Bw.i w."""
        lines = []
        for x, of in (("C", "A"), ("D", "Bu"), ("Z", "Bw")):
            before = self.names[x] and self.names[x] + " + "
            self.names[x] = f"{x}o.{self.k}.i"
            lines.append(f"{x}o.{self.k}.i = {before}{self.names['H']} inv(E.i) {of}.i")
        many = any(i != j for i, j in self.d.pairs)
        if many or (
            self.d.slack and len(self.d.few) > 1
        ):  # a mean of E has its inverse
            same = f"{self.names['H']} inv(E.i) == {at(1, self.names['H'])} inv(E.1)"
            lines.append(f"solved.{self.k}.i: {same}")
        t.write(*lines, loop="i in vertices")
        self.names["H"] = ""

    def _nothing_through(self, t):
        """No w passes to y at once, or its H2 norm is infinite."""
        Z = self.names["Z"]
        at = ".i" if Z[-2:] == ".i" else ""
        if Z:
            line = f"none.{self.k}{at}: {Z}{self.S} == 0 ({Z}{self.S})"
            t.write(line, loop="i in vertices" if at else None)

    @property
    def height(self):
        """The number of rows of y."""
        plant, N, a = self.d.d["plant"], self.d.N, len(self.d.d["U"])
        if self.rows is not None:
            return self.rows
        if plant["kind"] != "descriptor":
            return (N - a) // 2
        return len(self.d.vertices[0].get("C", plant.get("C")))

    def y(self, u):
        """E P C' + E Y' D' of a pair of vertices, or its like with a slack matrix."""
        d, C, D = self.d, self.names["C"], self.names["D"]
        if d.slack or ".i" not in (C[-2:], D[-2:]):
            return f"{u}EP {C}'" + (f" + {u}EY {D}'" if D else "")
        left, X, Y = (d.frame[x] for x in ("left", "X", "Y"))
        one = f"{X} {C}'" + (f" + {Y}' {D}'" if D else "")
        other = f"{X} {at('j', C)}'" + (f" + {Y}' {at('j', D)}'" if D else "")
        return f"{u}{left}(E.i ({other}) + E.j ({one}))/2"

    def rates(self, u):
        """E0 V H', with a slack matrix."""
        return f"{u}EP {self.names['H']}'" if self.names["H"] else "0"

    def through(self, s):
        """Z of a vertex or of a pair of them."""
        Z, S = self.names["Z"], self.S
        if not Z:
            return "0"
        if self.d.slack or Z[-2:] != ".i":
            return f"{s}{Z}{S}"
        return f"{s}({Z} + {at('j', Z)}){S}/2"


def names_of(t, plant):
    """C, H, D and Z of a plant by itself."""
    if plant["kind"] != "descriptor":
        return dict(C="C", H="", D="", Z="")
    return {x: f"{x}.i" if f"{x}.1" in t.data else x * (x in t.data) for x in "CHDZ"}


def at_vertex(t, d, sizes, r, k):
    """C, D, Z and S at the vertex k of what r bounds, x' put in, and its height.

    ``sizes`` are those that `plants.plant` returns.
    """
    vertices, N, m, p = sizes
    whole = SimpleNamespace(t=t, d=d, vertices=vertices, N=N, m=m, p=p, plain=N,
                            integrals=len(d["U"]), slack=False, pairs=())  # fmt: skip
    channel = Channel(whole, r, 1)
    names = (channel.names[x].replace(".i", f".{k}") for x in "CDZ")
    return *names, channel.S, channel.height


def at(vertex, name):
    """A name at another vertex than i."""
    return f"{name[:-2]}.{vertex}" if name[-2:] == ".i" else name
