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
    """An HTML table that scrolls inside itself on a narrow screen.

    Parameters
    ----------
    caption : str
        What the table holds.
    heads : sequence of str
        Column heads.
    rows : sequence of sequences of str
        HTML of the cells; the first one heads its row.

    Examples
    --------
    >>> Table("Squares", ["n", "n * n"], [["2", "4"]])
    Table: Squares, 1 row
    """

    def __init__(self, caption, heads, rows):
        self.caption, self.heads, self.rows = caption, heads, list(rows)

    def __repr__(self):
        count = len(self.rows)
        return f"Table: {self.caption}, {count} row{'s' * (count != 1)}"

    def _repr_html_(self):
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
    return Table(
        caption,
        ["What and where", "Printed", "Ours", "Verdict", "Why"],
        [
            [
                f"{_link(r.chapter, r.item)}<br>{_text(r.place)}",
                *map(_text, (r.printed, r.ours)),
                _verdict(r.verdict),
                _text(r.why),
            ]
            for r in rows
        ],
    )


def errata(errata, caption="Corrections to the printed text"):
    """A `Table` with a caption of errata, which are `Erratum` objects."""
    return Table(
        caption,
        ["Where", "Kind", "Printed", "Correct", "Evidence"],
        [
            [
                _link(e.chapter, e.place),
                *map(_text, (e.kind, e.printed, e.correct, e.evidence)),
            ]
            for e in errata
        ],
    )


def checked(checked, caption="Checked and found right"):
    """A `Table` of `sosbook.reproduction.checked` with a caption."""
    return Table(
        caption,
        ["Where", "What", "How"],
        [[_link(c.chapter, c.place), _text(c.what), _text(c.how)] for c in checked],
    )


def assumptions(figures, caption="What each figure is redrawn with"):
    """A `Table` with a caption of figures: `sosbook.reproduction.assumptions`."""
    heads = ["Start", "Disturbance", "Set point", "Delay", "Else"]
    parts = ("start", "channels", "reference", "delay", "rest")
    return Table(
        caption,
        ["Figures", *heads],
        [
            [_link(f["chapter"], f["place"]), *(_text(f[part]) for part in parts)]
            for f in figures
        ],
    )


def ledger(entries, caption="The best that is known of the printed gains"):
    """A `Table` with a caption of entries: `sosbook.book.ledger.entries`."""
    return Table(
        caption,
        ["What", "Printed", "Proven", "Not true", "By"],
        [
            [
                _link(e.chapter, e.what),
                "" if e.printed is None else f"{e.printed:.4g}{_text(e.unit)}",
                *(f"{value:.3g}{_text(e.unit)}" for value in (e.proven, e.false)),
                _text(e.method),
            ]
            for e in entries
        ],
    )


def readings(readings, caption="Readings that would decide"):
    """A `Table` with a caption of readings: `sosbook.reproduction.readings`."""
    return Table(
        caption,
        ["Where", "Look for", "What it decides"],
        [
            [_link(r["chapter"], r["place"]), _text(r["read"]), _text(r["then"])]
            for r in readings
        ],
    )


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
    return Table(
        "Verdicts and how often they are given",
        ["Verdict", "Claims", "Rows", "Meaning"],
        [
            [_verdict(v), str(claims[v]), str(count[v]), _text(meaning)]
            for v, meaning in VERDICTS.items()
        ],
    )


def _text(words):
    return page_text(words, quote=False)


def _link(chapter, words):
    return f'<a href="{chapter}.html">{_text(words)}</a>'


def _verdict(verdict):
    kind = verdict.replace(" ", "-")
    return f'<span class="sos-{kind}">{MARKS[verdict]} {verdict}</span>'
