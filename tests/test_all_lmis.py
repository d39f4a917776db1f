"""The page "All LMIs": its formulas say what the functions say, its links lead on."""

import ast
import inspect
import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook import theorems
from sosbook.theorems.text import SIZES, called_with

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "book" / "_ext"))
import all_lmis  # noqa: E402

ROWS = all_lmis.rows()
SHOWN = [(name, row.get("given", {})) for row in ROWS for name in row["functions"]]


class Formula:
    """A formula in TeX, read as numbers by a program that knows nothing of trees."""

    TOKEN = re.compile(
        r"\s*(\\begin\{bmatrix\}|\\end\{bmatrix\}|\\operatorname\{\w+\}|\^\{-?\\?\w+\}|\\\\"
        r"|\\otimes|\d+|(?:\\(?:mathrm|dot)\{\w+\}|\\?[A-Za-z]+)(?:_(?:\{\\?\w+\}|\w))?|.)"
    )

    def __init__(self, tex, values):
        self.tokens, self.values = self.TOKEN.findall(tex.strip()), values

    def next(self, *wanted):
        if not wanted or (self.tokens and self.tokens[0] in wanted):
            return self.tokens.pop(0)

    def sum(self):
        value = -self.term() if self.next("-") else self.term()
        while sign := self.next("+", "-"):
            value = added(value, self.term() if sign == "+" else -self.term())
        return value

    def term(self):
        value = self.product()
        if self.next(r"\otimes"):
            right = self.product()
            k = SIZES["k"] if np.ndim(value) == 0 else 0
            value = np.kron(value * np.eye(k) if k else value, right)
        return value

    def product(self):
        value = self.factor()
        ends = ("+", "-", ")", "&", r"\\", r"\otimes", r"\end{bmatrix}")
        while self.tokens and self.tokens[0] not in ends:
            over = self.next("/")
            value = times(value, 1 / self.factor() if over else self.factor())
        return value

    def factor(self):
        token = self.next()
        if token == "(" or token.startswith(r"\operatorname"):
            closed = token == "(" or self.next("(")
            value = self.sum()
            assert closed and self.next(")")
            if token != "(":
                value = np.trace(value) if "tr" in token else value + value.T
        elif token == r"\begin{bmatrix}":
            value = self.matrix()
        elif token.isdigit():
            value = float(token)
        else:
            value = 1.0 if token == "I" else self.values[token]
        powers = {r"^{\top}": lambda x: x.T, "^{2}": lambda x: x * x}
        powers |= {"^{-1}": np.linalg.inv, r"^{-\top}": lambda x: np.linalg.inv(x).T}
        while self.tokens and self.tokens[0] in powers:
            value = powers[self.next()](value)
        return value

    def matrix(self):
        rows = [[]]
        while True:
            star = self.next(r"\star")
            rows[-1].append(None if star else self.sum())
            token = self.next("&", r"\\", r"\end{bmatrix}")
            if token == r"\end{bmatrix}":
                break
            rows += [[]] * 0 if token == "&" else [[]]
        return joined(rows)


def times(x, y):
    return x * y if np.ndim(x) == 0 or np.ndim(y) == 0 else x @ y


def added(x, y):
    """A number in a sum of matrices is that multiple of the identity."""
    if np.ndim(x) == np.ndim(y):
        return x + y
    return x + y * np.eye(len(x)) if np.ndim(x) else added(y, x)


def joined(rows):
    """A block matrix; a number in it stands for that multiple of the identity."""
    r, c = range(len(rows)), range(len(rows[0]))
    rows = [[rows[j][i].T if rows[i][j] is None else rows[i][j] for j in c] for i in r]
    tall = [next((len(x) for x in row if np.ndim(x)), 0) for row in rows]
    wide = [next((x.shape[1] for x in col if np.ndim(x)), 0) for col in zip(*rows)]
    default = SIZES["N"] if any(tall) else 1  # of zeros whose size is told elsewhere
    for i in r:  # a number that isn't zero is square
        for j in c:
            if np.ndim(rows[i][j]) == 0 and rows[i][j]:
                tall[i] = wide[j] = tall[i] or wide[j] or 1
    tall, wide = ([x or default for x in sizes] for sizes in (tall, wide))
    return np.block([
        [x if np.ndim(x) else x * np.eye(tall[i], wide[j]) for j, x in enumerate(row)]
        for i, row in enumerate(rows)
    ])  # fmt: skip


def value_of(formulas, values):
    """The matrices of a function's formulas, each after the definitions before it."""
    for formula in formulas:
        whole = formula.removeprefix("& ")
        if whole.endswith(r"\succ 0"):
            plain = whole.removesuffix(r"\succ 0").replace(r"\\ &\quad", "")
            yield Formula(plain, values).sum()
            continue
        for line in re.split(r"(?:^|\\\\|, \\quad)\s*(?=\S+ &?= )", whole):
            if line.strip():
                name, _, right = re.sub("&=", "=", line).partition("=")
                right = right.replace(r"\\ &\quad", "").strip()
                values[name.strip()] = Formula(right, values).sum()


def parts(count, size):
    """e_1, e_2, ... of a vector with ``count`` parts."""
    whole = np.eye(count * size)
    return {f"e_{{{k + 1}}}": whole[k * size : (k + 1) * size] for k in range(count)}


@pytest.mark.parametrize("name, given", SHOWN)
def test_a_formula_says_what_its_function_says(name, given):
    function, rng, values = getattr(theorems, name), np.random.default_rng(3), {}
    own, of = all_lmis.OWN.get(name, {}), inspect.signature(function).parameters
    given = {k: v for k, v in given.items() if k in of}

    def make(letter, shape, symmetric):
        x = rng.uniform(0.5, 1.5, shape)
        x = x + x.T if symmetric and shape else x
        values[all_lmis.letter(letter, own)] = x
        return x

    wanted = called_with(make, function, **given)
    products = {"EPC": ("EP", "C"), "EVC": ("EV", "C")}
    for whole, (left, right) in products.items():
        x, y = (values.get(all_lmis.letter(part, own)) for part in (left, right))
        if x is not None and y is not None:
            values[all_lmis.letter(whole, own)] = x @ y.T
    values |= {"x_{0}": np.reshape(values.get("x_{0}", 0), (-1, 1))}
    count = len(wanted[0]) // SIZES["N"]
    values |= parts(count, SIZES["N"])
    formulas = all_lmis.formulas(function, given)
    spelt = {
        tex: f"X_{{{k}}}" for k, tex in enumerate(sorted(values, key=len)) if " " in tex
    }
    for tex in sorted(spelt, key=len, reverse=True):
        formulas = [x.replace(tex, spelt[tex]) for x in formulas]
    found = list(value_of(formulas, values | {spelt[t]: values[t] for t in spelt}))
    assert len(found) == len(wanted)
    for ours, theirs in zip(found, wanted):
        assert_allclose(ours, theirs, atol=1e-9)


def test_each_function_has_one_row():
    every = [x for x in theorems.__all__ if inspect.isfunction(getattr(theorems, x))]
    assert sorted(name for name, _ in SHOWN) == sorted(every)


def test_no_formula_is_wider_than_a_phone():
    for name, given in SHOWN:
        known = inspect.signature(getattr(theorems, name)).parameters
        used = {k: v for k, v in given.items() if k in known}
        for formula in all_lmis.formulas(getattr(theorems, name), used):
            for line in re.split(r" \\\\ (?=\S+ &=|&)", formula):
                width = all_lmis.glyphs(re.sub(r"\\begin.*?\\end", "", line))
                assert width <= 1.2 * all_lmis.GLYPHS, (name, line)


def test_each_row_leads_to_its_theorem_and_to_its_cell():
    texts, cells = "", {}
    for path in (ROOT / "book").glob("*.ipynb"):
        every = json.loads(path.read_text("utf8"))["cells"]
        for cell, after in zip(every, [*every[1:], {"source": ""}]):
            source = "".join(cell["source"])
            texts += source + "\n"
            for label in re.findall(r"^\(([a-z0-9-]+)\)=", source, re.M):
                cells[label] = "".join(after["source"])
    for row in ROWS:
        assert f":label: {row['proven']}\n" in texts, row
        written = cells[row["open"]] if "open" in row else "symmetric("
        assert "symmetric(" in written or "matrix(" in written, row


def test_each_call_is_one():
    """Its names are there, and take these arguments."""
    space = {"sos": sos}
    for row in ROWS:
        for node in ast.walk(ast.parse(row["call"])):
            if not isinstance(node, ast.Call) or "sos" not in ast.unparse(node.func):
                continue
            if ast.unparse(node.func).endswith(").bounds"):
                assert callable(sos.Design.bounds)
                continue
            called = eval(ast.unparse(node.func), space)
            keys = {k.arg: 0 for k in node.keywords}
            inspect.signature(called).bind(*node.args, **keys)
