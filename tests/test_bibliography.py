"""The bibliography's source: marks, and fields that identify a work."""

import re
from pathlib import Path

import pytest

FILE = Path(__file__).resolve().parent.parent / "book/references.bib"
pytestmark = pytest.mark.skipif(
    not FILE.exists(), reason="the package without its book"
)


def entries():
    """(kind, key, fields) of each entry."""
    text = FILE.read_text("utf8")
    for kind, key, body in re.findall(
        r"^@(\w+)\{([^,]+),\n(.*?)^\}", text, flags=re.M | re.S
    ):
        yield kind, key, dict(re.findall(r"^ +(\w+) *= *\{(.*)\},?$", body, re.M))


def test_each_entry_says_whether_it_was_checked():
    found = list(entries())
    assert len(found) == FILE.read_text("utf8").count("\n@")
    for _, key, fields in found:
        assert fields.get("checked", "").strip(), (
            f"{key}: say what it was compared with, checked = {{...}}, or {{no}}"
        )


def test_each_entry_can_be_found():
    for kind, key, fields in entries():
        assert {"title", "year"} <= set(fields), key
        if kind == "article":
            assert {"author", "journal", "volume"} <= set(fields), key


def test_no_doi_stands_twice():
    dois = [fields["doi"].lower() for *_, fields in entries() if "doi" in fields]
    assert len(dois) > 25 and len(set(dois)) == len(dois)


def test_the_page_names_the_entries_that_nothing_was_compared_with():
    page = " ".join(FILE.with_name("bibliography.md").read_text("utf8").split())
    marks = {key: fields["checked"] for _, key, fields in entries()}
    unchecked = {key for key, mark in marks.items() if mark == "no"}
    partly = {
        key
        for key, mark in marks.items()
        if re.search(r"\bonly\b|\bbut\b|\bwhich has\b", mark)
    }
    first, rest = page.split("Three more", 1)

    def named(text):
        return set(re.findall(r"\{cite:t\}`(\w+)`", text))

    assert named(first) == unchecked
    assert named(rest) == partly and len(partly) == 3
    assert f"For {len(unchecked)} of the {len(marks)} entries" in page
    assert f"these {len(unchecked | partly)} up" in page


def test_each_entry_is_cited_on_another_page_than_its_own():
    pages = [*FILE.parent.glob("*.ipynb"), *FILE.parent.glob("*.md")]
    pages.remove(FILE.with_name("bibliography.md"))
    lists = (
        keys
        for page in pages
        for keys in re.findall(r"\{cite(?::\w+)?\}`([^`]+)`", page.read_text("utf8"))
    )
    cited = {key.strip() for keys in lists for key in keys.split(",")}
    known = {key for _, key, _ in entries()}
    assert known - cited == set()
    assert cited - known == set()


def test_the_authors_papers_stand_where_their_theorems_do():
    """Both are known from the thesis alone, and the pages say so."""
    for key, pages in {
        "gontijo2023jvc": ("04_*", "05_*", "08_*", "errata"),
        "gontijo2022cba": ("16_*", "17_*", "errata"),
    }.items():
        for name in pages:
            (page,) = FILE.parent.glob(f"{name}.ipynb")
            text = page.read_text("utf8")
            before, after = re.split(rf"\b{key}\b", text)
            sentence = before.rpartition(".")[2], *after.split(".")[:2]
            assert "n't seen" in ".".join(sentence), name
