"""Numbers as they are written: in prose, in outputs, in programs."""

import ast
import math
import re
from dataclasses import dataclass
from functools import cached_property

_POWER = r"(?:\s?(?:\\cdot|\\times|×|·)\s?10(?:\^\{?[-−]?\d+\}?|[⁻⁰¹²³⁴-⁹]+))"
_GROUP = r"(?:\\,|\{,\}|[\u2009\u202f\u00a0 ])\d{3}"
_DIGITS = rf"(?:\d{{1,3}}(?:{_GROUP})+(?!\d)|\d+)"
NUMBER = re.compile(
    rf"(?<![\w.\\^])(?:10\^\{{?(?P<ten>[-−]?\d+)\}}?"
    rf"|(?P<digits>{_DIGITS}(?:\.\d+)?|\.\d+)"
    rf"(?P<power>[eE][-+−]?\d+|{_POWER})?)(?P<suffix>[A-Za-z]*)"
)
#: In outputs a space separates numbers, and so does a comma.
PRINTED = re.compile(
    r"(?<![\w.])(?P<digits>\d+(?:\.\d*)?|\.\d+)(?P<power>[eE][-+−]?\d+)?"
    r"(?P<suffix>[A-Za-z]*)"
)
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")

PREFIXES = {
    "G": 1e9,
    "M": 1e6,
    "k": 1e3,
    "d": 1e-1,
    "c": 1e-2,
    "m": 1e-3,
    "µ": 1e-6,
    "μ": 1e-6,
    "n": 1e-9,
}
#: Units, as alternatives of a pattern; µ and its kin stand before some of them.
_SYMBOLS = "s|m|g|kg|N|Nm|V|A|W|Hz|rad|J|B|Ω|F|H|°"
_WORDS = (
    "per|cent|percent|times|fold|degrees|degree|decades|decade|digits|digit|decimals"
    "|steps|step|iterations|iteration|seconds|second|milliseconds|microseconds"
    "|minutes|minute|hours|hour|metres|metre|millimetres|centimetres|millimetre"
    "|centimetre|kilograms|kilogram|newtons|newton|volts|volt|samples|ticks|tick"
    "|turns|turn|bytes|bits|lines|products|variables|unknowns|orders|proofs"
    "|multiplications"
)
#: After a number in words; "four unknowns" says what there is, "four degrees"
#: what came out.
_MEASURED = re.compile(
    "%|°|Hz|rad|kg|mm|ms|N|V|per cent|percent|times|fold|degrees|decades|steps"
    "|iterations|seconds|milliseconds|microseconds|minutes|hours|metres|millimetres"
    "|centimetres|kilograms|newtons|volts"
)
_PERCENT = frozenset({"%", r"\%", "per cent", "percent"})
_WORD_PREFIXES = {"milli": 1e-3, "centi": 1e-2, "micro": 1e-6, "kilo": 1e3}
_UNIT = re.compile(
    r"(?:[\s~$^-]|\\[,;: ]|\\(?:mathrm|text|rm)\{?\s?){0,4}(?P<unit>"
    r"%|\\%|°|\\circ|per cent\b|percent\b|"
    rf"[GMkdcmµμn]?(?:{_SYMBOLS})(?![\w'])|(?:{_WORDS})\b)"
)
_ONES = (
    "zero|one|two|three|four|five|six|seven|eight|nine|ten|eleven|twelve|thirteen"
    "|fourteen|fifteen|sixteen|seventeen|eighteen|nineteen"
)
_TENS = "twenty|thirty|forty|fifty|sixty|seventy|eighty|ninety"
CARDINALS = {word: value for value, word in enumerate(_ONES.split("|"))}
CARDINALS |= {word: 10 * value for value, word in enumerate(_TENS.split("|"), 2)}
CARDINALS |= {"dozen": 12, "hundred": 100, "thousand": 1000, "million": 1e6}
WORD = re.compile(
    rf"\b(?:(?P<tens>{_TENS})-)?"
    rf"(?P<word>{'|'.join(CARDINALS)})\b(?!-)",
    re.IGNORECASE,
)
#: Calls and keywords whose numbers nobody writes about.
_LOOKS = re.compile(
    "alpha|annotate|bbox_to_anchor|capsize|figsize|figure|fontsize|gridspec_kw"
    "|height_ratios|legend|lw|linewidth|markersize|ms|ncol|ncols|nrows|rotation|round"
    "|set_size_inches|size|subplots|subplots_adjust|text|width_ratios|xlim|xytext"
    "|ylim|zorder"
)
_HEDGE = re.compile(
    r"(?i)(?:\b(?:about|around|nearly|almost|roughly|some|over|under|above|"
    r"below|than|to|approximately|beyond|near|within|by|close to)"
    r"|[~≈]|\\approx|\\sim)[\s$(-]*$"
)


@dataclass(frozen=True)
class Number:
    """A number as it stands in a text: its value without sign, ``step``, one unit of
    the last of its significant ``digits``, the ``unit`` that follows (%, mm, or
    empty), and whether it is ``exact``, a program's literal.
    """

    written: str
    start: int
    value: float
    step: float
    digits: int
    unit: str = ""
    exact: bool = False

    @cached_property
    def scaled(self):
        """The values it may be printed as: itself, and without prefix."""
        scale = _scale(self.unit)
        return (self.value,) if scale == 1 else (self.value, self.value * scale)

    @property
    def percent(self):
        """Whether it is a share in per cent."""
        return self.unit in _PERCENT

    @property
    def whole(self):
        """Whether it is written as an integer."""
        return re.fullmatch(r"\d+|[A-Za-z-]+", self.written) is not None

    def agrees(self, other):
        """Whether another number, rounded as this one, is it; exact ones are quoted."""
        mine, room = self.scaled, 0.5 * self.step / (self.value or 1)
        if other.exact:
            if self.unit in {"times", "fold"}:
                return False  # a ratio is a result
            if self.digits < 3:
                room = 0
            if self.percent:
                mine = mine[1:]
        return any(
            abs(value - theirs) <= (room * (1 + 1e-6) + 1e-12) * (value or 1)
            for value in mine
            for theirs in other.scaled
        )


def _scale(unit):
    if unit in _PERCENT:
        return 0.01
    if unit in {"°", r"\circ", "degrees", "degree"}:
        return math.pi / 180
    for word, value in _WORD_PREFIXES.items():
        if unit.startswith(word):
            return value
    if len(unit) < 2 or re.fullmatch(f"{_SYMBOLS}|{_WORDS}", unit):
        return 1
    return PREFIXES.get(unit[0], 1)


def _read(match, text, hedged=False):
    groups = match.groupdict()
    if groups.get("ten"):
        value = 10.0 ** int(groups["ten"].replace("−", "-"))
        digits, step = 1, value
    else:
        plain = re.sub(r"\\,|\{,\}|\s", "", groups["digits"])
        power = 0
        if groups["power"]:
            raw = groups["power"].translate(_SUPERSCRIPTS).replace("−", "-")
            power = int(re.search(r"(?:10\^?\{?|[eE])([-+]?\d+)\}?$", raw)[1])
        value = float(f"{plain}e{power}")
        decimals = len(plain.partition(".")[2])
        step = 10.0 ** (power - decimals)
        counted = plain.replace(".", "").lstrip("0")
        if "." not in plain:
            ending = len(counted) - len(counted.rstrip("0"))
            counted = counted.rstrip("0")
            if hedged:
                step *= 10.0**ending
        digits = len(counted) or 1
    return value, step, digits


def printed(text):
    """The numbers of an output."""
    for match in PRINTED.finditer(text.replace("−", "-")):
        suffix = match["suffix"]
        if (
            suffix
            and suffix not in {"j", "x", "e"}
            and not re.fullmatch(rf"[GMkdcmµμn]?(?:{_SYMBOLS})", suffix)
        ):
            continue
        unit = suffix or _unit_after(text, match.end())
        yield Number(match[0], match.start(), *_read(match, text), unit)


def typed(text):
    """The numbers of prose, in digits."""
    for match in NUMBER.finditer(text):
        end = match.end("suffix") - len(match["suffix"])
        unit = _unit_after(text, end)
        if match["suffix"] and not unit.startswith(match["suffix"]):
            continue
        hedged = _HEDGE.search(text[max(0, match.start() - 20) : match.start()])
        yield Number(
            text[match.start() : end],
            match.start(),
            *_read(match, text, bool(hedged)),
            unit,
        )


def spelled(text):
    """The numbers of prose in words, if a unit follows or they are large."""
    for match in WORD.finditer(text):
        value = CARDINALS[match["word"].lower()]
        if match["tens"]:
            value += CARDINALS[match["tens"].lower()]
        unit = _unit_after(text, match.end())
        factor = re.search(r"(?i)factor (?:of )?(?:about )?$", text[: match.start()])
        if not _MEASURED.fullmatch(unit):
            unit = ""
        if value < 2 or (value < 13 and not unit and not factor):
            continue
        if match["word"].lower() in {"hundred", "thousand", "million", "dozen"}:
            continue
        yield Number(
            match[0], match.start(), value, max(1, value // 10), 1, unit or "times"
        )


def _unit_after(text, end):
    match = _UNIT.match(text, end)
    return match["unit"] if match else ""


def literals(source):
    """The numbers that a program sets, evaluated; angles in degrees as well."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return
    for node in _parameters(tree):
        value = _constant(node)
        if value is None or isinstance(value, bool) or not math.isfinite(value):
            continue
        where = getattr(node, "lineno", 0)
        exact = isinstance(getattr(node, "operand", node), ast.Constant)
        yield Number(f"{value:g}", where, abs(value), 0.0, 9, exact=exact)
        if "pi" in {getattr(n, "attr", "") for n in ast.walk(node)}:
            yield Number(f"{value:g}", where, math.degrees(abs(value)), 0.0, 9)


def _parameters(node):
    """All nodes but the indices and the looks of a drawing."""
    yield node
    skipped = ()
    if isinstance(node, ast.Subscript):
        skipped = (node.slice,)
    elif isinstance(node, ast.Call):
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        if _LOOKS.fullmatch(name):
            return
        skipped = [k for k in node.keywords if _LOOKS.fullmatch(k.arg or "")]
    for child in ast.iter_child_nodes(node):
        if not any(child is skip for skip in skipped):
            yield from _parameters(child)


def _constant(node):
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return node.value
    if isinstance(node, ast.Constant) and isinstance(node.value, complex):
        return node.value.imag
    if isinstance(node, ast.Attribute) and node.attr == "pi":
        return math.pi
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = _constant(node.operand)
        return None if value is None else -value
    if isinstance(node, ast.BinOp):
        left, right = _constant(node.left), _constant(node.right)
        action = {
            ast.Add: lambda a, b: a + b,
            ast.Sub: lambda a, b: a - b,
            ast.Mult: lambda a, b: a * b,
            ast.Div: lambda a, b: a / b,
            ast.Pow: lambda a, b: float(a) ** b,
        }.get(type(node.op))
        if None in (left, right) or action is None or isinstance(left, str):
            return None
        try:
            return action(left, right)
        except (ZeroDivisionError, OverflowError):
            return None
    return None
