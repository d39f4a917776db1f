"""A page of the book as passages of prose, and as what may witness them."""

import ast
import html
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import nbformat

from . import markup, numerals

ROOT = Path(__file__).resolve().parents[2]
BOOK = ROOT / "book"

_FORMAL = re.compile(r"^(:{3,})\{prf:\w+\}.*?^\1\s*$", re.DOTALL | re.MULTILINE)
_BREAK = re.compile(r"^(?:#{1,4} |:{3,}\{exercise(?:-start)?\})", re.MULTILINE)


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
        before = self.source[max(0, number.start - width) : number.start]
        return " ".join(
            f"{before}»{number.written}«{self.source[end : end + width]}".split()
        )


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
        before = text[: number.start][-14:]
        after = text[number.start + len(number.written) :][:14]
        return not re.search(r"factor (?:of )?$", before) and (
            not re.match(r"\s(?:s|m)\b", after)
        )
    return True


def _markdown(name, index, text, section):
    """The passages of a markdown cell; the section's number at its end."""
    prose, math = markup.split(text)
    outside = markup.FENCE.sub(markup.blank, text)
    heads = {match.start() for match in _BREAK.finditer(outside)}
    formal = [match.span() for match in _FORMAL.finditer(text)]
    cuts = sorted({0, len(text), *heads, *(end for span in formal for end in span)})
    passages = []
    for start, end in zip(cuts, cuts[1:]):
        section += start in heads
        inside = any(a <= start and end <= b for a, b in formal)
        passages.append(
            Passage(
                name,
                index,
                1 + text.count("\n", 0, start),
                section,
                "formal" if inside else "prose",
                text[start:end],
                prose[start:end],
                math[start:end],
            )
        )
    return passages, section


def _strings(tree):
    """String constants of a program; the parts of an f-string singly."""
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    ]


def _descriptions(tree):
    """The alternative texts and captions of a program."""
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg in {"alt", "caption"}:
            skip = {
                id(part)
                for value in ast.walk(node.value)
                if isinstance(value, ast.FormattedValue)
                for part in ast.walk(value)
            }
            text = "□".join(
                part.value for part in _strings(node.value) if id(part) not in skip
            )
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
    """The numbers of each example in `sosbook.book.thesis`, by its name."""
    return {
        node.name: tuple(numerals.literals(ast.unparse(node)))
        for file in sorted((ROOT / "sosbook" / "book" / "thesis").glob("*.py"))
        for node in ast.parse(file.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
    }


def _thesis_of(text):
    """Witnesses from the thesis's examples that a page works with."""
    text = text.casefold()
    for name, numbers in thesis().items():
        spoken = name.replace("_", " ")
        if name in text or spoken in text or name.startswith("_"):
            for number in numbers:
                yield Witness(number, -1, -1, "thesis")


def read(path):
    """The `Page` of a notebook or a markdown file."""
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
            for match in markup.FENCE.finditer(cell.source):
                where = [
                    p.section
                    for p in more
                    if p.line <= 1 + cell.source.count("\n", 0, match.start())
                ]
                witnesses += [
                    Witness(n, where[-1] if where else section, index, "code")
                    for n in _program_numbers(match[2])
                ]
        elif cell.cell_type == "code":
            for kind, line, text in _descriptions(parse(cell.source)):
                prose, math = markup.split(text)
                passages.append(
                    Passage(path.stem, index, line, section, kind, text, prose, math)
                )
            witnesses += [
                Witness(n, section, index, "code")
                for n in numerals.literals(cell.source)
            ]
            for output in cell.get("outputs", []):
                words = shown(output)
                for fragment in fragments:
                    words = re.sub(
                        r"\s+".join(map(re.escape, fragment.split())), " ", words
                    )
                witnesses += [
                    Witness(n, section, index, "output")
                    for n in numerals.printed(words)
                ]
    witnesses += _thesis_of("\n".join(c.source for c in cells))
    return Page(path.stem, tuple(passages), tuple(witnesses))


def _program_numbers(source):
    """Literals of a fenced program, of whatever language."""
    found = tuple(numerals.literals(source))
    return found or tuple(numerals.printed(source))


def all_pages():
    """The files of the book whose prose is checked."""
    return [
        *sorted(BOOK.glob("*.ipynb")),
        *sorted(BOOK.glob("*.md")),
        ROOT / "README.md",
    ]
