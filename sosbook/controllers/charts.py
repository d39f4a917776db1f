"""Charts of a report: curves over the time, with axes and limits that are named."""

from html import escape

import numpy as np

WIDTH, HEIGHT = 268.0, 150.0  # of the frame; a chart is as wide as a telephone
LEFT, TOP, RIGHT, LOW = 68.0, 26.0, 22.0, 44.0  # around it
POINTS = 400  # of a curve
STYLES = ("", "7 3", "2 3", "9 3 2 3")  # dashes, so that no colour is needed
COLOURS = ("#114", "#a40", "#075", "#808")  # of every four curves with these dashes
LETTER = 6.5  # as wide as one is, of a label
NEAR = 3.0  # times what curves span: a limit that is further away is only said
STYLE = ".sos-keys{list-style:none;padding:0}"


def dash(k):
    """How curve ``k`` is drawn: attributes of SVG, for pages without a style."""
    colour = COLOURS[k // len(STYLES) % len(COLOURS)]
    line = f'fill="none" stroke-width="1.4" stroke="{colour}"'
    return f'{line} stroke-dasharray="{STYLES[k % len(STYLES)]}"'


def key(names):
    """Which line is which, of the ``names`` of some curves, as HTML."""
    parts = [
        f'<li><svg role="img" aria-label="line {k + 1}" width="44" height="10">'
        f'<path d="M2 5H42" {dash(k)}/></svg> {escape(name)}</li>'
        for k, name in enumerate(names)
    ]
    return f'<ul class="sos-keys">{"".join(parts)}</ul>'


def chart(
    curves, label, limit=np.inf, across="time in s", log=False, low=False, band=0
):
    """An inline SVG of some ``curves`` (t, values) over the time, called ``label``; a
    finite ``limit`` is drawn on either side, or said where it is far from them.

    ``across``: another axis than the time, in words; ``log``: its logarithm is drawn;
    ``low``: it begins where the curves do, not at zero; ``band``: of so many curves at
    the same t what lies between the lowest and the highest is shaded.
    """
    picked = []
    for t, values in curves:
        pick = np.unique(np.linspace(0, len(t) - 1, POINTS).astype(int))
        picked.append((t[pick], values[pick]))
    low_end, start = low, 0.0
    if low:
        start = min(float(t.min()) for t, _ in picked)
    end = max(float(t.max()) for t, _ in picked) or 1.0
    low = min(float(values.min()) for _, values in picked)
    high = max(float(values.max()) for _, values in picked)
    lines = []
    if np.isfinite(limit):
        if limit <= NEAR * max(-low, high):
            low, high = min(low, -limit), max(high, limit)
            lines = [limit, -limit]
        label = f"{label}, limit {limit:.4g}"
    room = 0.05 * (high - low) or max(abs(high), 1.0)
    low, high = low - room, high + room

    def right(t):
        t, ends = (np.log(x) if log else x for x in (np.asarray(t), (start, end)))
        return LEFT + (t - ends[0]) / (ends[1] - ends[0]) * WIDTH

    def down(value):
        return TOP + (high - np.asarray(value)) / (high - low) * HEIGHT

    def points(t, values):
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(right(t), down(values)))

    parts = [
        f'<path class="sos-limit" stroke="#b00" stroke-dasharray="1 4" '
        f'd="M{LEFT} {down(y):.1f}H{LEFT + WIDTH}"/>'
        for y in lines
    ]
    if band:
        t, several = picked[0][0], [values for _, values in picked[:band]]
        ends = (
            points(t, np.min(several, axis=0)),
            points(t[::-1], np.max(several, axis=0)[::-1]),
        )
        parts.append(
            f'<polygon fill="#888" fill-opacity="0.2" points="{" ".join(ends)}"/>'
        )
    parts += [
        f'<polyline points="{points(*pair)}" {dash(k)}/>'
        for k, pair in enumerate(picked)
    ]
    anchors = ("start", "middle", "end") if low_end else ("middle",) * 3
    for s, anchor in zip((0.0, 0.5, 1.0), anchors):
        value = low + s * (high - low)
        t = start ** (1 - s) * end**s if log else start + s * (end - start)
        parts += [
            _text(LEFT - 4, down(value) + 4, f"{value:.3g}", "end"),
            _text(LEFT + s * WIDTH, TOP + HEIGHT + 18, f"{t:.3g}", anchor),
        ]
    parts += [
        _text(LEFT, TOP - 10, label, "start", WIDTH + RIGHT),
        _text(LEFT + WIDTH / 2, TOP + HEIGHT + 36, across, "middle"),
    ]
    words = escape(f"{label} over {across}, {len(curves)} corners", quote=True)
    wide, tall = LEFT + WIDTH + RIGHT, TOP + HEIGHT + LOW
    return (
        f'<svg role="img" aria-label="{words}" viewBox="0 0 {wide:g} {tall:g}" '
        f'width="{wide:g}" font-family="sans-serif" font-size="12"><rect fill="none" '
        f'stroke="#777" x="{LEFT}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}"/>'
        f"{''.join(parts)}</svg>"
    )


def _text(x, y, words, anchor, room=np.inf):
    """``words`` at a place, drawn closer where they are longer than their ``room``."""
    close = ""
    if len(words) * LETTER > room:
        close = f' textLength="{room:g}" lengthAdjust="spacingAndGlyphs"'
    words = escape(words)
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{close}>{words}</text>'
