"""A page of the book as passages of prose, and as what may witness them."""

import ast
import html
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import nbformat

from . import numerals

ROOT = Path(__file__).resolve().parents[2]
BOOK = ROOT / "book"

FENCE = re.compile(r"^(`{3,}|~{3,})[^\n]*\n(.*?)^\1\s*$", re.DOTALL | re.MULTILINE)
_BREAK = re.compile(r"^(?:#{1,4} |:{3,}\{exercise(?:-start)?\})", re.MULTILINE)
_REFERENCE = re.compile(
    r"""(?ix)
    \b(?:thesis(?:'s)?|theorems?|lemmas?|tables?|figs?\.?|figures?|chapters?
       |sections?|sect\.|equations?|eqs?\.|examples?|ex\.|procedures?
       |problems?|corollar(?:y|ies)|appendi(?:x|ces)|definitions?|steps?
       |algorithms?|propositions?|parts?|rows?|columns?|cells?|lines?|cases?
       |remarks?|vertex|vertices|pages?|pp?\.|volume|Python|version|C|IEEE|ISO)
       (?:[\s~]|\u00a0)+\(?(?:[A-Z]\.)?\d+(?:\.\d+)*\)?
       (?:(?:,\s|\s?(?:and|to|or|-|–)\s?|,\s?and\s)\(?(?:[A-Z]\.)?\d+(?:\.\d+)*\)?)*(?![\d%.]*[\d%])
    | \(\d+(?:\.\d+)+\)(?:[-–]\(\d+(?:\.\d+)+\))?
    | \((?:[A-Z]\.)?\d+\.\d+(?:,\s\d+\.\d+)*\)
    | \(\d\)
    | \b\d\.\d\.\d\b
    | ^\|\s(?:[\dA-Z]\.\d(?:\.\d)?(?:,\s|\s(?=[A-Za-z])))+  # a table of contents
    | \b[A-Z]\.\d+(?:\.\d+)*
    | \b(?:19|20)\d\d\b(?!\s?(?:N|kg|Hz|V|m|s|rad|steps|samples|counts)\b)
    | \b\d+(?:st|nd|rd|th)\b
    | ^\s*\d+\.\s        # a numbered list
    """, re.MULTILINE)


@dataclass(frozen=True)
class Passage:
    """A piece of prose: its source, and the same with all else blanked."""

    page: str
    cell: int
    line: int
    section: int
    kind: str
    source: str
    prose: str
    math: str

    def numbers(self):
        """The typed numbers that may drift."""
        for kind, text in (("prose", self.prose), ("math", self.math)):
            for number in numerals.typed(text):
                if not _harmless(number, kind, text):
                    yield number
        if self.kind != "formal":
            yield from numerals.spelled(self.prose)

    def line_of(self, position):
        """The line of the cell on which a position lies."""
        return self.line + self.source.count("\n", 0, position)

    def around(self, number, width=60):
        """The words around a number, on one line, the number marked."""
        end = number.start + len(number.written)
        before = self.source[max(0, number.start - width):number.start]
        return " ".join(
            f"{before}»{number.written}«{self.source[end:end + width]}".split())


@dataclass(frozen=True)
class Witness:
    """A number that the page computes or sets."""

    number: numerals.Number
    section: int
    cell: int
    kind: str  # output, code, thesis


@dataclass(frozen=True)
class Page:
    """What a page says, and what it shows."""

    name: str
    passages: tuple
    witnesses: tuple


def _harmless(number, kind, text):
    """Small counts and the structure of a formula can't drift."""
    if not number.whole or number.value > 12 or number.unit:
        return False
    if kind == "prose":
        before = text[:number.start][-14:]
        after = text[number.start + len(number.written):][:14]
        return not re.search(r"factor (?:of )?$", before) and (
            not re.match(r"\s(?:s|m)\b", after))
    return True


def blank(match):
    return re.sub(r"[^\n]", " ", match[0])


def _keep_first(match):
    """Blank a match but for its first group."""
    start, end = match.start(1) - match.start(), match.end(1) - match.start()
    whole = match[0]
    hide = re.compile(r"[^\n]")
    return hide.sub(" ", whole[:start]) + whole[start:end] + hide.sub(
        " ", whole[end:])


def _math(text):
    """Structure of formulas blanked: indices, exponents, commands."""
    text = re.sub(r"\\(?:label|tag|begin|end|hspace)\{[^}]*\}", blank, text)
    text = re.sub(r"\\[dt]?frac\s?\d\s?\d", blank, text)
    text = re.sub(r"\\text\{[^}]*\}|\\operatorname\{[^}]*\}", lambda m: re.sub(
        r"\d", " ", m[0]), text)
    text = re.sub(r"_(?:\{[^{}]*(?:\{[^{}]*\})?[^{}]*\}|\w|\\\w+)", blank, text)
    return re.sub(r"(?<!10)\^(?:\{[^{}]*(?:\{[^{}]*\})?[^{}]*\}|\w|\\(?!circ)\w+)",
                  blank, text)


def _split(text):
    """Blank what isn't prose; return prose and formulas, of equal length."""
    text = FENCE.sub(blank, text)
    text = re.sub(r"<!--.*?-->", blank, text, flags=re.DOTALL)
    text = re.sub(r"^\([\w-]+\)=\s*$", blank, text, flags=re.MULTILINE)
    text = re.sub(r"^:[\w-]+:.*$", blank, text, flags=re.MULTILINE)
    text = re.sub(r"^:{3,}\{[^}]*\}[ \t]*(?:ex-\S+|(.*))$",
                  lambda m: _keep_first(m) if m[1] else blank(m),
                  text, flags=re.MULTILINE)
    text = re.sub(r"\{[\w:-]+\}`[^`]*`", blank, text)
    text = re.sub(r"\]\([^)\s]*\)|<https?://[^>]*>|https?://\S+", blank, text)
    text = re.sub(r"</?[a-z][^>\n]*>", blank, text)
    math = re.compile(r"\$\$.*?\$\$(?:[ ]*\([\w-]+\))?|(?<!\\)\$[^$]*?(?<!\\)\$", re.DOTALL)
    formulas = list(re.sub(r"[^\n]", " ", text))
    for match in math.finditer(text):
        formulas[match.start():match.end()] = match[0]
        tail = text[match.end():match.end() + 14]  # its unit may follow
        unit = re.match(r"[\s~]?(?:%|°|[a-zA-Zµμ]+)", tail)
        if unit:
            formulas[match.end():match.end() + unit.end()] = unit[0]
    formulas = "".join(formulas)
    formulas = re.sub(r"\$\$[ ]*\([\w-]+\)", blank, formulas)
    prose = math.sub(blank, text)
    prose = re.sub(r"`[^`\n]*`", _code, prose)
    return _REFERENCE.sub(blank, prose), _math(formulas)


def _code(match):
    """Inline code: identifiers and indices go, numbers stay."""
    return re.sub(r"[A-Za-z_]\w*|\[[^\]]*\]|^`|`$", blank, match[0])


def _formal_spans(text):
    return [m.span() for m in re.finditer(
        r"^(:{3,})\{prf:\w+\}.*?^\1\s*$", text, re.DOTALL | re.MULTILINE)]


def _markdown(name, index, text, section):
    """The passages of a markdown cell; the section's number at its end."""
    prose, math = _split(text)
    cuts = [0, *(m.start() for m in _BREAK.finditer(FENCE.sub(blank, text))),
            len(text)]
    passages = []
    formal = _formal_spans(text)
    for start, end in zip(cuts, cuts[1:]):
        if start == end:
            continue
        if start and start in cuts or _BREAK.match(text):
            section += bool(start) or bool(_BREAK.match(text))
        edges = sorted({start, end, *(e for span in formal for e in span
                                      if start < e < end)})
        for a, b in zip(edges, edges[1:]):
            inside = any(s <= a and b <= e for s, e in formal)
            passages.append(Passage(
                name, index, 1 + text.count("\n", 0, a), section,
                "formal" if inside else "prose",
                text[a:b], prose[a:b], math[a:b]))
    return passages, section


def _strings(tree):
    """String constants of a program; the parts of an f-string singly."""
    return [node for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str)]


def _descriptions(tree):
    """The alternative texts and captions of a program."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg in {"alt", "caption"}:
            skip = {id(part) for value in ast.walk(node.value)
                    if isinstance(value, ast.FormattedValue)
                    for part in ast.walk(value)}
            text = "□".join(part.value for part in _strings(node.value)
                            if id(part) not in skip)
            yield node.arg, node.value.lineno, text


def shown(output):
    """What a reader reads of an output."""
    if output.output_type == "stream":
        return output.text
    data = output.get("data", {})
    texts = [data.get("text/plain", ""), data.get("text/latex", "")]
    page = data.get("text/html", "")
    if not re.match(r"\s*<sos-", page):
        page = re.sub(r"<(style|script)\b.*?</\1>", " ", page, flags=re.DOTALL)
        texts.append(html.unescape(re.sub(r"<[^>]*>", "  ", page)))
    return "\n".join(texts)


def _typed_fragments(trees):
    """Literal text with numbers in it: shown, but not computed."""
    found = set()
    for tree in trees:
        for node in _strings(tree):
            text = " ".join(node.value.split())
            if re.search(r"[^\W\d_]{2}", text) and any(numerals.printed(text)):
                found.add(text)
    return sorted(found, key=len, reverse=True)


def parse(source):
    try:
        return ast.parse(source)
    except SyntaxError:
        return ast.parse("")


@cache
def thesis():
    """The numbers of each example in `sosbook.thesis`, by its name."""
    source = (ROOT / "sosbook" / "thesis.py").read_text(encoding="utf-8")
    tree = ast.parse(source)
    return {node.name: tuple(numerals.literals(ast.unparse(node)))
            for node in tree.body if isinstance(node, ast.FunctionDef)}


def _thesis_of(text):
    """Witnesses from the thesis's examples that a page works with."""
    text = text.casefold()
    for name, numbers in thesis().items():
        spoken = name.replace("_", " ")
        if name in text or spoken in text or name.startswith("_"):
            for number in numbers:
                yield Witness(number, -1, -1, "thesis")


def read(path):
    """Read a notebook or a markdown page.

    Returns
    -------
    Page
    """
    path = Path(path).resolve()
    if path.suffix == ".md":
        cells = [nbformat.v4.new_markdown_cell(path.read_text(encoding="utf-8"))]
    else:
        cells = nbformat.read(path, as_version=4).cells
    programs = [parse(c.source) for c in cells if c.cell_type == "code"]
    fragments = _typed_fragments(programs)
    passages, witnesses, section = [], [], 0
    for index, cell in enumerate(cells):
        if cell.cell_type == "markdown":
            more, section = _markdown(path.stem, index, cell.source, section)
            passages += more
            for match in FENCE.finditer(cell.source):
                where = [p.section for p in more
                         if p.line <= 1 + cell.source.count("\n", 0, match.start())]
                witnesses += [Witness(n, where[-1] if where else section, index, "code")
                              for n in _program_numbers(match[2])]
        elif cell.cell_type == "code":
            for kind, line, text in _descriptions(parse(cell.source)):
                prose, math = _split(text)
                passages.append(Passage(path.stem, index, line, section,
                                        kind, text, prose, math))
            witnesses += [Witness(n, section, index, "code")
                          for n in numerals.literals(cell.source)]
            for output in cell.get("outputs", []):
                words = shown(output)
                for fragment in fragments:
                    words = re.sub(r"\s+".join(map(re.escape, fragment.split())),
                                   " ", words)
                witnesses += [Witness(n, section, index, "output")
                              for n in numerals.printed(words)]
    witnesses += _thesis_of("\n".join(c.source for c in cells))
    return Page(path.stem, tuple(passages), tuple(witnesses))


def _program_numbers(source):
    """Literals of a fenced program, of whatever language."""
    found = tuple(numerals.literals(source))
    return found or tuple(numerals.printed(source))


def all_pages():
    """The files of the book whose prose is checked."""
    return [*sorted(BOOK.glob("*.ipynb")), *sorted(BOOK.glob("*.md")),
            ROOT / "README.md"]
