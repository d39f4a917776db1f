"""A result on one card: verdict, poles, gains, margins, what to do next."""

from importlib.resources import files

import numpy as np

from .escape import page_text
from .pole_map import pole_map

STATUS_MARKS = {"feasible": "✓", "infeasible": "✗", "undecided": "?"}
MOST_COLUMNS = 12  # of a matrix that is shown in full
MOST_ROWS = 8  # of a matrix that is shown in full
MOST_MARGINS = 6  # that are shown, the smallest first


def card(
    name,
    status,
    rows=(),
    region=None,
    gains=(),
    margins=None,
    sentences=(),
    axis="poles, rad/s",
):
    """HTML of a result, which needs no other file, script or library: ``name``, verdict
    ``status``, ``gains`` (name and matrix each), ``margins`` by block, and
    ``sentences`` at the end. ``rows``, poles of each vertex in rad/s, make a picture
    over the ``region`` that was asked, with ``axis`` below it. All that comes from
    outside is escaped.
    """
    state = status if status in STATUS_MARKS else "undecided"
    parts = [pole_map(rows, region, axis)] if len(rows) else []
    numbers = [_matrix(label, K) for label, K in gains if np.size(K)]
    numbers += [_margins(margins)] if margins else []
    if numbers:
        parts.append(f'<div class="sos-numbers">{"".join(numbers)}</div>')
    title = page_text(f"{name}: {status}")
    style = " ".join((files(__package__) / "card.css").read_text("utf8").split())
    return (
        f'<div class="sos-result" role="group" aria-label="{title}">'
        f"<style>{style}</style>"
        f'<p class="sos-verdict"><span class="sos-{state}">{STATUS_MARKS[state]} '
        f"{page_text(status)}</span> {page_text(name)}</p>"
        + (f'<div class="sos-parts">{"".join(parts)}</div>' if parts else "")
        + "".join(f"<p>{page_text(text)}</p>" for text in sentences if text)
        + "</div>"
    )


def _number(x):
    return f"{float(x) + 0.0:.4g}"


def _matrix(label, K):
    rows, columns = np.shape(K)
    label = page_text(label)
    if rows > MOST_ROWS or columns > MOST_COLUMNS:
        summary = f"{rows} × {columns}, largest entry {_number(np.abs(K).max())}"
        return f"<p><b>{label}</b> {summary}</p>"
    body = "".join(
        "<tr>" + "".join(f"<td>{_number(x)}</td>" for x in row) + "</tr>" for row in K
    )
    return f'<table class="sos-matrix"><caption>{label}</caption>{body}</table>'


def _margins(margins):
    least = sorted(margins, key=margins.get)[:MOST_MARGINS]
    body = "".join(
        f'<tr><th scope="row">{page_text(name)}</th><td>{margins[name]:.2g}</td></tr>'
        for name in least
    )
    more = len(margins) - len(least)
    caption = "Margins" + (f" (the least of {len(margins)})" if more else "")
    return f"<table><caption>{caption}</caption>{body}</table>"
