"""The page "All LMIs of this book": its blocks are those that the theorems print.

The fence ``{lmis}`` on the page becomes a section for each row of ``all_lmis.toml``.
A formula is made from the tree of a traced theorem, of which the text in a proof
file is made, too (`sosbook.language.trees.shown`).
"""

import re
import tomllib
from importlib import import_module
from pathlib import Path

from sosbook.language import trees
from sosbook.theorems.text import called_with, symbol

HERE = Path(__file__).resolve().parent
FENCE = ":::{lmis}\n:::"
GLYPHS = 34  # of a line that a phone shows whole
LETTERS = {
    "EP": "E P", "EV": "E V", "EY": "E Y^{\\top}", "EPE": "E P E^{\\top}",
    "EVE": "E V E^{\\top}", "EPC": "E P C^{\\top}", "W": "B_w", "noise": "B_w",
    "Ad": "A_d", "B": "B_u", "u_max": "u_{\\max}", "xd": "x_d", "Wq": "W",
}  # fmt: skip
OWN = {"unseen": {"here": "x", "rate": "\\dot{x}", "push": "w", "out": "z"}}
OWN["unseen"]["bound"] = "\\gamma"
GREEK = "Theta|alpha|beta|gamma|delta|epsilon|mu|tau"


def letter(name, own):
    """The TeX of a name; ``own``: what a function calls otherwise."""
    if name in own or name in LETTERS:
        return own.get(name, LETTERS.get(name))
    head, under, digits = re.fullmatch(r"([A-Za-z]+)(?:_(\w+)|(\d*))", name).groups()
    index = under or digits or ""
    if re.fullmatch(GREEK, head):
        head = "\\varepsilon" if head == "epsilon" else f"\\{head}"
    elif len(head) > 1:
        head = rf"\mathrm{{{head}}}"
    index = rf"\{index}" if re.fullmatch(GREEK, index) else index
    return f"{head}_{{{index}}}" if index else head


def tex(x, own=None, level=0):
    """The TeX of a tree where a sum (0), a term (1), a product (2) or a factor (3) may
    stand."""
    own, op = own or {}, x[0]

    def inner(y, level=0):
        return tex(y, own, level)

    if op in ("name", "number"):
        return letter(x[1], own) if op == "name" else x[1]
    if op in ("mirror", "I", "O"):
        return {"mirror": "\\star", "I": "I", "O": "0"}[op]
    if op == "block":
        plain = all(trees.is_number(y) for row in x[1] for y in row)
        show = tex if plain else entry
        rows = r" \\ ".join(" & ".join(show(y, own) for y in row) for row in x[1])
        return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"
    if op == "T":
        whole = inner(x[1], 3)
        return rf"({whole})^{{\top}}" if " " in whole else rf"{whole}^{{\top}}"
    if op == "pick":
        return f"e_{{{inner(x[1])}}}"
    if op == "inv":
        plain, sign = (x[1][1], r"-\top") if x[1][0] == "T" else (x[1], "-1")
        return f"{inner(plain, 3)}^{{{sign}}}"
    if op == "pow":
        return f"{inner(x[1], 3)}^{{{x[2]}}}"
    if op in ("he", "tr"):
        return rf"\operatorname{{{op}}}({inner(x[1])})"
    if op == "add":
        minus = x[2][0] == "neg"
        right = inner(x[2][1] if minus else x[2], 1)
        text = f"{inner(x[1])} {'-' if minus else '+'} {right}"
    elif op == "mul":
        left = inner(x[1], 3 if x[1][0] == "div" else 2)
        text = f"{left} {inner(x[2], 2 if x[2][0] == 'mul' else 3)}"
    else:  # whatever is new ends here in an error
        text = {
            "neg": lambda y: "-" + inner(y, 1),
            "kron": lambda y, z: rf"{inner(y, 3)} \otimes {inner(z, 3)}",
            "div": lambda y, z: f"{inner(y, 2)} / {inner(z, 3)}",
        }[op](*x[1:])
    own_level = {"neg": 0, "add": 0, "kron": 1}.get(op, 2)
    return text if own_level >= level else f"({text})"


def entry(x, own):
    """The TeX of a block's entry, in which a number f stands for f I."""
    plain = x[1] if x[0] == "neg" else x
    if x == trees.ZERO or not trees.is_number(plain):
        return tex(x, own)
    sign = "-" * (x[0] == "neg")
    factor = "" if plain == trees.ONE else tex(plain, own, 3 - (plain[0] == "mul"))
    return f"{sign}{factor} I".replace("- I", "-I").strip()


def glyphs(text):
    """About how many letters wide a formula is; a sign between two has some room."""
    text = re.sub(r"\\(begin|end)\{\w+\}|\\(operatorname|mathrm|dot)", "", text)
    text = re.sub(r" (\\otimes|[-+=]|\\quad) ", "xxx", text)
    return len(re.sub(r"[\s{}^_&]", "", re.sub(r"\\[a-zA-Z]+", "x", text)))


def short(x, own):
    """A tree whose wide matrix has names in place of its longest entries, and these."""
    sign, block = (x[:1], x[1]) if x[0] == "neg" else ((), x)
    if block[0] != "block":
        return x, {}
    named, table = {}, [list(row) for row in block[1]]
    sizes = [[glyphs(entry(y, own)) for y in row] for row in table]
    places = [(i, j) for i, row in enumerate(table) for j in range(len(row))]
    while 2 + sum(max(column) + 2 for column in zip(*sizes)) > GLYPHS:
        i, j = max(places, key=lambda place: sizes[place[0]][place[1]])
        name = f"g_{i + 1}{j + 1}"
        named[name], table[i][j] = table[i][j], ("name", name, False, False, None)
        sizes[i][j] = glyphs(entry(table[i][j], own))
    block = ("block", tuple(map(tuple, table)))
    return (*sign, block) if sign else block, dict(sorted(named.items()))


def terms(x):
    """The terms of a sum with their signs."""
    if x[0] == "add":
        return [*terms(x[1]), *terms(x[2])]
    if x[0] == "neg":
        return [("+" if sign == "-" else "-", part) for sign, part in terms(x[1])]
    return [("+", x)]


def lines(left, x, own, end=""):
    """The lines of ``left x end``, a sum broken where a line is full."""
    negative = x[0] == "neg" and x[1][0] == "add"
    parts = terms(x[1] if negative else x)
    found = [left + " -(" * negative]
    for k, (sign, part) in enumerate(parts):
        piece = f"{sign} " * (k > 0 or sign == "-") + tex(part, own, 1)
        piece += ")" * (negative and k == len(parts) - 1)
        if k and glyphs(found[-1]) + glyphs(piece) > GLYPHS:
            found.append(r"&\quad")
        found[-1] += f" {piece}"
    found[-1] += end
    return found


def definitions(sums, own):
    """The lines of definitions, several of the short ones in one."""
    found = []
    for name, x in sums.items():
        one = lines(f"{letter(name, own)} &=", x, own)
        both = f"{found[-1]}, \\quad {one[0].replace('&', '')}" if found else ""
        few = x[0] == "pick" and 0 < glyphs(both) < GLYPHS
        found = [*found[:-1], both] if few else [*found, *one]
    return found


def formulas(function, given):
    """The formulas of a theorem: definitions, and each block, greater than zero."""
    own = OWN.get(function.__name__, {})
    blocks, defined, found = called_with(symbol, function, **given), {}, []
    for block in blocks:
        trees.collect(block.tree, defined)
    sums = dict(sorted(defined.items(), key=lambda item: item[1][0] != "pick"))
    for block in blocks:
        tree, named = short(block.tree, own)
        if sums | named:
            found.append(definitions(sums | named, own))
        found.append(lines("&", tree, own, r" \succ 0"))
        sums = {}
    return [r" \\ ".join(x) if x[1:] else x[0].replace("&", "", 1) for x in found]


def rows():
    """The rows of the page, as `all_lmis.toml` has them."""
    return tomllib.loads((HERE.parent / "all_lmis.toml").read_text("utf-8"))["row"]


def section(row):
    """A row as a section of the page."""
    theorems = import_module("sosbook.theorems")
    proven = f"{{prf:ref}}`{row['proven']}`"
    parts = [proven + (f" ({row['thesis']})" if "thesis" in row else "")]
    if "open" in row:
        parts.append(f"[solved in the open](#{row['open']})")
    found = [f"## {row['question']}", ", ".join(parts) + ".", f"`{row['call']}`"]
    for name in row["functions"]:
        function = getattr(theorems, name)
        known = function.__code__.co_varnames[: function.__code__.co_argcount]
        used = {k: v for k, v in row.get("given", {}).items() if k in known}
        found.append(f"{{py:obj}}`{name} <sosbook.theorems.{name}>`")
        found += [f"$$\n{x}\n$$" for x in formulas(function, used)]
    return "\n\n".join(found)


def source_read(app, docname, source):
    """Write the fence out."""
    source[0] = source[0].replace(FENCE, "\n\n".join(map(section, rows())))


def setup(app):
    """Tell Sphinx."""
    app.connect("source-read", source_read)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
