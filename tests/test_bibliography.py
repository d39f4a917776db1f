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
