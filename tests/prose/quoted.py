"""Phrases in quotation marks: the thesis's own words, or plainly not its."""

import ast
import re
import tomllib
from dataclasses import dataclass
from functools import cache

import nbformat

from tests.prose.quotations import QUOTATIONS

from . import check, markup, pages

PHRASES = check.GIVEN / "phrases.toml"
_QUOTED = re.compile(
    r"\"([^\"\n]*(?:\n[^\"\n]+)*)\"|“([^”]*)”|(?<!\w)‘([^’]*)’"
    r"|(?<![\w'])'([^'\n]{3,}?)'(?![\w'])"
)
_REPRODUCTION = pages.ROOT / "sosbook" / "book" / "reproduction"
_ROWS = sorted([*_REPRODUCTION.glob("*.py"), *_REPRODUCTION.glob("*.toml")])


@dataclass(frozen=True)
class Phrase:
    """A quoted phrase of two words or more, and where it stands."""

    words: str
    page: str
    place: str

    def __str__(self):
        return f'{self.page}, {self.place}: "{self.words}"'


def plain(text):
    """Words and digits only, formulas included, in lower case."""
    text = re.sub(r"[$`*\\]|\{[\w:-]+\}", "", text)
    return " ".join(re.sub(r"[^\w.=+/-]+", " ", text.casefold()).split()).strip(".")


def _phrases(text, page, place):
    for match in _QUOTED.finditer(text):
        words = " ".join(next(filter(None, match.groups()), "").split())
        if len(re.sub(r"\$[^$]*\$", "", words).split()) > 1:
            line = 1 + text.count("\n", 0, match.start())
            yield Phrase(words, page, f"{place}, line {line}")


@cache
def phrases(path):
    """The quoted phrases of a page, of a module's strings or of a table's."""
    if path.suffix == ".py":
        tree = ast.parse(path.read_text(encoding="utf-8"))
        return tuple(
            phrase
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
            for phrase in _phrases(node.value, path.stem, f"line {node.lineno}")
        )
    if path.suffix == ".toml":
        return tuple(
            phrase
            for entries in tomllib.loads(path.read_text(encoding="utf-8")).values()
            for entry in entries
            for text in filter(lambda value: isinstance(value, str), entry.values())
            for phrase in _phrases(text, path.stem, entry["place"])
        )
    if path.suffix == ".md":
        text = markup.FENCE.sub("", path.read_text(encoding="utf-8"))
        return tuple(_phrases(re.sub(r"`[^`]*`", "", text), path.stem, "text"))
    found = []
    for index, cell in enumerate(nbformat.read(path, as_version=4).cells):
        if cell.cell_type == "markdown":
            text = re.sub(r"`[^`\n]*`", "", markup.FENCE.sub(markup.blank, cell.source))
            texts = [text]
        elif cell.cell_type == "code":
            texts = [
                node.value
                for node in ast.walk(pages.parse(cell.source))
                if isinstance(node, ast.Constant) and isinstance(node.value, str)
            ]
        else:
            texts = []
        for text in texts:
            found += _phrases(text, path.stem, f"cell {index}")
    return tuple(found)


@cache
def other_phrases():
    """Phrases that nobody else said, or that others did: {phrase: what}."""
    return tomllib.loads(PHRASES.read_text(encoding="utf-8"))


@cache
def _program_words():
    """What the package says, apart from its reports about the thesis."""
    files = [
        p
        for p in sorted((pages.ROOT / "sosbook").rglob("*"))
        if p.suffix in {".py", ".js", ".html"}
        and p not in _ROWS
        and p.parent.name != "thesis"
    ]
    return plain(" ".join(p.read_text(encoding="utf-8") for p in files))


def is_quotation(phrase):
    """Whether the thesis says a phrase in these words, but for [additions]."""
    own = re.sub(r"\[[^]]*\]", "", phrase)
    words = f" {plain(own)} "
    return any(words in f" {plain(quotation)} " for quotation in QUOTATIONS)


def unknown(path):
    """The quoted phrases that are neither the thesis's nor accounted for."""
    others = {plain(phrase) for phrase in other_phrases()}
    for phrase in phrases(path):
        words = plain(phrase.words)
        if is_quotation(phrase.words) or words in others:
            continue
        if path.suffix not in {".py", ".toml"} and f" {words} " in _program_words():
            continue
        yield phrase


def unused():
    """Entries that no page quotes any more."""
    said = {plain(p.words) for path in sources() for p in phrases(path)}
    return [phrase for phrase in other_phrases() if plain(phrase) not in said]


def sources():
    """Pages, and the modules whose strings become tables."""
    return [*pages.all_pages(), *_ROWS]
