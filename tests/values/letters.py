"""The names of letters that a figure draws as paths, for messages."""

from functools import cache

__all__ = ["letter"]

LETTERS = [
    chr(code)
    for block in ((33, 127), (0xB0, 0xB8), (0x391, 0x3CA))
    for code in range(*block)
    if chr(code).isprintable()
] + [*"−°²³·×′∞≤≥"]


def letter(outline):
    """The letter with this path data in the figures' font; "?" for another.

    Examples
    --------
    >>> letter("M0 0L1 0")
    '?'
    """
    return alphabet().get(outline, "?")


@cache
def alphabet():
    """Letters by their path data, from a figure that shows all of them."""
    import matplotlib.pyplot as plt
    from sosbook.plots import show

    from .shapes import drawn
    from .trees import parse

    figure = plt.figure()
    for name in LETTERS:
        figure.text(0, 0, name, parse_math=False)
    svg = parse(show(figure, alt="All letters").svg).children[0]
    glyphs = [shape for shape in drawn(svg) if shape.kind == "glyph"]
    return dict(zip((glyph.outline for glyph in glyphs), LETTERS, strict=True))
