"""The tables show every row, escaped, with heads that name their cells."""

import re
from pathlib import Path

from sosbook.book import reproduction, tables


def page(table):
    return table._repr_html_()


def test_every_reproduction_row_is_in_the_table(rows):
    text = page(tables.reproduction(rows))
    assert text.count("<tr>") == len(rows) + 1
    for row in rows:
        assert f'href="{row.chapter}.html"' in text
        assert row.verdict in text


def test_every_erratum_is_in_the_table(errata):
    text = page(tables.errata(errata))
    assert text.count("<tr>") == len(errata) + 1
    counts = re.findall(r"<td>(\d+)</td>", page(tables.kinds(errata)))
    assert sum(map(int, counts)) == len(errata) and "0" not in counts


def test_what_is_right_is_in_its_table():
    checked = reproduction.checked()
    text = page(tables.checked(checked))
    assert text.count("<tr>") == len(checked) + 1
    assert "(2.15), (2.17)" in text


def test_text_is_escaped():
    row = reproduction.Row("01_x", "a < b", "<script>", "&", "<b>", "misprint", "<i>")
    text = page(tables.reproduction([row]))
    assert "<script>" not in text and "<b>" not in text
    assert "a &lt; b" in text


def test_columns_and_rows_have_heads_and_a_caption(rows):
    text = page(tables.verdicts(rows))
    assert text.count('scope="col"') == 4
    assert text.count('scope="row"') == len(reproduction.VERDICTS)
    assert "<caption>" in text


def test_the_counts_add_up(rows):
    text = page(tables.verdicts(rows))
    counts = [int(n) for n in re.findall(r"<td>(\d+)</td>", text)]
    assert sum(counts[1::2]) == len(rows)
    assert sum(counts[::2]) == len({row.about for row in rows})


def test_every_row_stands_in_a_table_of_the_books_page(rows):
    book = Path(__file__).resolve().parent.parent / "book"
    source = (book / "reproduction.ipynb").read_text("utf8")
    for chapter in {row.chapter for row in rows}:
        assert f'table(\\"{chapter}\\"' in source, chapter
