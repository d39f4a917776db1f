"""Trees of what theorems say, and their text; see `sosbook.language.traced`."""

from fractions import Fraction

__all__ = ["MIRROR", "ONE", "ZERO"]

ZERO, ONE, MIRROR = ("number", "0"), ("number", "1"), ("mirror",)


def tell_sizes(table, heights, widths):
    """Write I(n) and O(n, m) where no other block tells a size but 1."""
    tall, wide = [False] * len(heights), [False] * len(widths)

    def spread():
        for _ in range(len(heights) + len(widths)):
            for i, row in enumerate(table):
                for j, x in enumerate(row):
                    if not is_number(x):
                        tall[i] = wide[j] = True
                    elif x != ZERO:
                        tall[i] = wide[j] = tall[i] or wide[j]

    spread()
    for i, row in enumerate(table):
        for j, x in enumerate(row):
            if (not tall[i] and heights[i] != 1) or (not wide[j] and widths[j] != 1):
                one = ("I", size(heights[i]))
                row[j] = ("O", size(heights[i]), size(widths[j]))
                if x != ZERO:
                    row[j] = one if x == ONE else product(x, one)
                spread()


def fitted(tree):
    """An entry of a block matrix, where f I is f and zeros are 0."""
    if tree[0] == "neg":
        return ("neg", fitted(tree[1]))
    if tree[0] in ("I", "O"):
        return ONE if tree[0] == "I" else ZERO
    return tree[1] if tree[0] == "mul" and tree[2][0] == "I" else tree


def number(f):
    f = Fraction(f)
    if f < 0:
        return ("neg", number(-f))
    if f.denominator == 1:
        return ("number", str(f))
    places = next((k for k in range(1, 40) if 10**k % f.denominator == 0), None)
    if places is None:
        return ("div", number(f.numerator), number(f.denominator))
    digits = str(f * 10**places).rjust(places + 1, "0")
    return ("number", f"{digits[:-places]}.{digits[-places:]}")


def size(n):
    return getattr(n, "tree", None) or number(int(n))


def product(x, y):
    """The tree of a product; signs and numbers go to its front."""
    if x[0] == "neg":
        return negative(product(x[1], y))
    if y[0] == "neg":
        return negative(product(x, y[1]))
    if x == y and is_number(x):
        return ("pow", x, "2")
    if y[0] == "mul" and is_number(y[1]) and not is_number(x):
        return product(y[1], product(x, y[2]))
    return ("mul", x, y)


def scaled(f, x):
    """The tree of a number f times a tree."""
    return x if f == 1 else product(number(f), x)


def add(x, y):
    """The tree of a sum, its terms in a row."""
    return add(add(x, y[1]), y[2]) if y[0] == "add" else ("add", x, y)


def negative(x):
    return x[1] if x[0] == "neg" else ("neg", x)


def flipped(x):
    """The tree of the transpose."""
    op = x[0]
    if op in ("number", "he", "I", "pow", "tr", "at", "rows", "cols"):
        return x
    if op == "name":
        return x if x[2] else ("T", x)
    if op == "T":
        return x[1]
    if op in ("neg", "add", "kron", "inv"):
        return (op, *map(flipped, x[1:]))
    if op == "div":
        return ("div", flipped(x[1]), x[2])
    if op == "O":
        return ("O", x[2], x[1])
    if op == "mul":
        if is_number(x[1]):
            return ("mul", x[1], flipped(x[2]))
        return ("mul", flipped(x[2]), flipped(x[1]))
    if op == "block":
        if any(MIRROR in row for row in x[1]):
            return x
        return ("block", tuple(tuple(map(flipped, column)) for column in zip(*x[1])))
    return ("T", x)


def is_number(x):
    if x[0] in ("number", "tr", "at", "pow", "rows", "cols"):
        return True
    if x[0] == "name":
        return x[3]
    return x[0] in ("div", "mul", "add", "neg") and all(map(is_number, x[1:]))


def collect(x, found):
    """Definitions of the names of a tree, by name, those of others first."""
    if x[0] != "name":
        for part in x:
            if isinstance(part, tuple):
                collect(part, found)
    elif x[4] is not None and x[1] not in found:
        collect(x[4], found)
        found[x[1]] = x[4]


def shown(x, level=0):
    """The text of a tree where a sum (0), a product (1) or a factor (2) may stand."""
    op = x[0]
    if op in ("number", "name"):
        return x[1]
    if op == "mirror":
        return "."
    if op == "block":
        return "[" + "; ".join(", ".join(map(shown, row)) for row in x[1]) + "]"
    if op == "T":
        return shown(x[1], 2) + "'"
    if op == "pow":
        return f"{shown(x[1], 2)}^{x[2]}"
    if op not in ("neg", "add", "mul", "div"):
        return f"{op}({', '.join(map(shown, x[1:]))})"
    own = 0 if op in ("neg", "add") else 1
    if op == "neg":
        text = "-" + shown(x[1], 1)
    elif op == "add":
        minus = x[2][0] == "neg"
        right = shown(x[2][1] if minus else x[2], 1)
        text = f"{shown(x[1])} {'-' if minus else '+'} {right}"
    elif op == "mul":
        bare = 1 if x[2][0] == "mul" else 2
        text = f"{shown(x[1], 1)} {shown(x[2], bare)}"
    else:
        text = f"{shown(x[1], 1)}/{shown(x[2], 2)}"
    return text if own >= level else f"({text})"


def scaled_constants(x, s, unknowns):
    """The tree of s G(X / s), where ``x`` is that of G(X), ``s`` of s: constants of G
    times s, in all but its ``unknowns``.
    """
    if x[0] == "neg":
        return negative(scaled_constants(x[1], s, unknowns))
    if not _speaks_of(x, unknowns):
        if x in (ZERO, MIRROR) or x[0] == "O":
            return x
        return s if x == ONE else product(s, x)
    if x[0] == "name":
        return x

    def inner(y):
        return scaled_constants(y, s, unknowns)

    if x[0] == "block":
        return ("block", tuple(tuple(map(inner, row)) for row in x[1]))
    if x[0] in ("mul", "kron"):  # one of the factors is certain
        left = inner(x[1]) if _speaks_of(x[1], unknowns) else x[1]
        return (x[0], left, inner(x[2]) if left is x[1] else x[2])
    if x[0] == "div":
        return ("div", inner(x[1]), x[2])
    return (x[0], *map(inner, x[1:]))


def _speaks_of(x, names):
    if x[0] == "name":
        return x[1] in names
    return any(_speaks_of(part, names) for part in x if isinstance(part, tuple))
