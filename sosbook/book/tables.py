"""The book's tables as accessible HTML: reproduction rows and errata."""

from collections import Counter

from ..display.escape import page_text
from .reproduction import KINDS, VERDICTS

__all__ = [
    "Table",
    "assumptions",
    "checked",
    "errata",
    "kinds",
    "ledger",
    "readings",
    "reproduction",
    "verdicts",
]

MARKS = {
    "reproduced": "✓",
    "property holds": "✓",
    "another solution": "≈",
    "misprint": "✎",
    "claim refuted": "✗",
    "not reproducible": "?",
}


class Table:
    """An HTML table with a ``caption`` and column ``heads``, whose ``rows`` are HTML of
    the cells, the first one heading its row; it scrolls inside itself on a narrow
    screen.

    >>> Table("Squares", ["n", "n * n"], [["2", "4"]])
    Table: Squares, 1 row
    """

    def __init__(self, caption, heads, rows):
        self.caption, self.heads, self.rows = caption, heads, list(rows)

    def __repr__(self):
        count = len(self.rows)
        return f"Table: {self.caption}, {count} row{'s' * (count != 1)}"

    def _repr_html_(self):
        """The table in HTML."""
        heads = "".join(f'<th scope="col">{h}</th>' for h in self.heads)
        body = "".join(
            f'<tr><th scope="row">{row[0]}</th>'
            + "".join(f"<td>{cell}</td>" for cell in row[1:])
            + "</tr>"
            for row in self.rows
        )
        caption = page_text(self.caption)
        return (
            f'<div class="sos-table" role="region" tabindex="0" '
            f'aria-label="{caption}"><table><caption>{caption}</caption>'
            f"<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"
            "</div>"
        )


def reproduction(rows, caption="Printed numbers and claims"):
    """A `Table` with a caption of rows, which are `Row` objects."""
    heads = ["What and where", "Printed", "Ours", "Verdict", "Why"]
    cells = []
    for r in rows:
        where = f"{_link(r.chapter, r.item)}<br>{_text(r.place)}"
        numbers = map(_text, (r.printed, r.ours))
        cells.append([where, *numbers, _verdict(r.verdict), _text(r.why)])
    return Table(caption, heads, cells)


def errata(errata, caption="Corrections to the printed text"):
    """A `Table` with a caption of errata, which are `Erratum` objects."""
    heads = ["Where", "Kind", "Printed", "Correct", "Evidence"]
    texts = [(e.kind, e.printed, e.correct, e.evidence) for e in errata]
    links = [_link(e.chapter, e.place) for e in errata]
    return Table(caption, heads, [[x, *map(_text, t)] for x, t in zip(links, texts)])


def checked(checked, caption="Checked and found right"):
    """A `Table` of `sosbook.book.reproduction.checked` with a caption."""
    cells = [[_link(c.chapter, c.place), *map(_text, (c.what, c.how))] for c in checked]
    return Table(caption, ["Where", "What", "How"], cells)


def assumptions(figures, caption="What each figure is redrawn with"):
    """A `Table` with a caption of figures: `sosbook.book.reproduction.assumptions`."""
    heads = ["Figures", "Start", "Disturbance", "Set point", "Delay", "Else"]
    parts = ("start", "channels", "reference", "delay", "rest")
    cells = [
        [_link(f["chapter"], f["place"]), *(_text(f[x]) for x in parts)]
        for f in figures
    ]
    return Table(caption, heads, cells)


def ledger(entries, caption="The best that is known of the printed gains"):
    """A `Table` with a caption of entries: `sosbook.book.ledger.entries`."""
    cells = []
    for e in entries:
        printed = "" if e.printed is None else f"{e.printed:.4g}{_text(e.unit)}"
        known = (f"{value:.3g}{_text(e.unit)}" for value in (e.proven, e.false))
        cells.append([_link(e.chapter, e.what), printed, *known, _text(e.method)])
    return Table(caption, ["What", "Printed", "Proven", "Not true", "By"], cells)


def readings(readings, caption="Readings that would decide"):
    """A `Table` with a caption of readings: `sosbook.book.reproduction.readings`."""
    heads, parts = ["Where", "Look for", "What it decides"], ("read", "then")
    places = [_link(r["chapter"], r["place"]) for r in readings]
    texts = [[_text(r[part]) for part in parts] for r in readings]
    return Table(caption, heads, [[x, *t] for x, t in zip(places, texts)])


def kinds(errata):
    """A `Table` that explains the kinds of errata and counts them."""
    count = Counter(e.kind for e in errata)
    return Table(
        "Kinds of corrections",
        ["Kind", "Entries", "Meaning"],
        [[_text(k), str(count[k]), _text(meaning)] for k, meaning in KINDS.items()],
    )


def verdicts(rows):
    """A `Table` that explains the verdicts and counts claims and rows."""
    count = Counter(r.verdict for r in rows)
    claims = Counter(verdict for _, verdict in {(r.about, r.verdict) for r in rows})
    heads = ["Verdict", "Claims", "Rows", "Meaning"]
    cells = [
        [_verdict(v), str(claims[v]), str(count[v]), _text(meaning)]
        for v, meaning in VERDICTS.items()
    ]
    return Table("Verdicts and how often they are given", heads, cells)


def _text(words):
    return page_text(words, quote=False)


def _link(chapter, words):
    return f'<a href="{chapter}.html">{_text(words)}</a>'


def _verdict(verdict):
    kind = verdict.replace(" ", "-")
    return f'<span class="sos-{kind}">{MARKS[verdict]} {verdict}</span>'
