"""What every element with sliders owes its readers, checked in a browser."""

from sosbook.book.elements.page import whole as with_scripts

#: The system's colours, the page's own theme, and whether it is dark then.
SCHEMES = (
    ("light", None, False),
    ("dark", None, True),
    ("light", "dark", True),
    ("dark", "light", False),
)


def write_page(path, *pieces):
    """Write a page with elements and what stands between them; the path is returned.

    Their scripts come once, after all of them, unless they are among the pieces.
    """
    body = "".join(pieces)
    if "data-script=" in body and 'class="sos-shared"' not in body:
        body = with_scripts(body)
    path.write_text(
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        '<link rel="icon" href="data:,"><title>t</title></head><body>' + body,
        "utf8",
    )
    return path


def two_of(element, folder):
    """Write a page with an element twice, as a chapter may have two of a kind."""
    return write_page(folder / "page.html", element.light, "<p>and</p>", element.light)


def first(tab, tag):
    """The first element of a kind."""
    return tab.page.locator(tag).first


def said(element):
    """What an element says: the verdict of its sentence, and what more there is."""
    parts = ".sos-say em", ".sos-readout"
    return " ".join(element.locator(part).inner_text() for part in parts)


def whole(element):
    """The same with its sentence."""
    return element.get_attribute("aria-label") + said(element)


def say(tab, tag):
    """What the first of a kind says."""
    return said(first(tab, tag))


def held(tab, tag, code, given=None):
    """What a script finds in it: `a` in the code."""
    return tab.page.evaluate(
        f"given => {{ const a = document.querySelector({tag!r}); {code} }}", given
    )


def assert_quiet(tab):
    """Neither an error nor a request beyond the page itself and its workers."""
    assert tab.errors == []
    assert [
        u for u in tab.requests if not u.startswith(("file:", "data:", "blob:"))
    ] == []


#: Relative luminance of colours, as WCAG 2 defines it; null for what isn't there.
LUMINANCE = """all => all.map(([selector, kind]) => {
  const node = document.querySelector(selector);
  if (!node) return null;
  const [r, g, b] = getComputedStyle(node)[kind].match(/[\\d.]+/g).map(x => {
    const c = x / 255;
    return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b; })"""

#: (selector inside an element, kind of ink, selector of its ground, how far they
#: differ at least), where there are.
INKS = (
    ("", "color", "", 4.5),
    ("svg text", "fill", "", 4.5),
    ("figcaption", "color", "", 4.5),
    (".sos-readout p", "color", ".sos-readout", 4.5),
    (".sos-status", "color", ".sos-readout", 4.5),
    (".sos-button", "color", ".sos-readout", 4.5),
    (".sos-mark", "color", "", 4.5),
    (".sos-tyre", "stroke", "", 4.5),
    ("select", "color", "select", 4.5),
)


def assert_readable(tab, elements, inks=INKS):
    """In all schemes inks stand out from papers, and these are right; how many do."""
    asked = [
        (f"{element} {inside}".strip(), kind, f"{element} {ground}".strip(), least)
        for element in elements
        for inside, kind, ground, least in inks
    ]
    colours = [pair for ink, kind, paper, _ in asked
               for pair in ((ink, kind), (paper, "backgroundColor"))]  # fmt: skip
    for scheme, theme, dark in SCHEMES:
        tab.page.emulate_media(color_scheme=scheme)
        tab.page.evaluate(
            """theme => { delete document.documentElement.dataset.theme;
            if (theme) document.documentElement.dataset.theme = theme; }""",
            theme,
        )
        seen = tab.page.evaluate(LUMINANCE, colours)
        found = list(zip(asked, seen[::2], seen[1::2], strict=True))
        for (selector, _, ground, least), ink, paper in found:
            if ground in elements:
                assert paper < 0.05 if dark else paper > 0.8, ground
            if ink is not None:
                low, high = sorted([ink, paper])
                assert (high + 0.05) / (low + 0.05) > least, (selector, scheme, theme)
    assert tab.errors == []
    return sum(ink is not None for _, ink, _ in found)


def assert_buttons(tab, visit, tag, label):
    """Reset, a link that leads back, and a program's names, after a number moved."""
    element = first(tab, tag)
    begin = whole(element)
    step(element.get_by_role("spinbutton", name=label))
    moved = whole(element)
    assert moved != begin
    element.get_by_role("button", name="Link to this").click()
    again = visit(tab.page.url)
    assert whole(first(again, tag)) == moved
    assert again.errors == []
    element.get_by_role("button", name="As Python").click()
    names = {}
    exec(element.locator("pre").inner_text(), names)
    element.get_by_role("button", name="Reset").click()
    assert whole(element) == begin and element.locator("pre").count() == 0
    return names


def step(number):
    """Move a number of a sentence by a step, up where it can."""
    before = number.input_value()
    number.press("ArrowUp")
    if number.input_value() == before:
        number.press("ArrowDown")


def green(tab, tag, key):
    """The stretches of a number's way under the ruler: [whether green, from, to]."""
    element = first(tab, tag)
    element.scroll_into_view_if_needed()
    element.locator(f".sos-num[data-slot='{key}']").focus()
    tab.page.wait_for_function(
        "([t, k]) => { const e = document.querySelector(t);"
        "return e.surveyed && e.taken === k; }",
        arg=[tag, key],
    )
    return element.locator(".sos-band").evaluate(
        """band => [...band.style.background.matchAll(
            /(region|line)\\) (-?[\\d.]+)% ([\\d.]+)%/g)].map(
            ([, colour, from, to]) => [colour === "region", from / 100, to / 100])"""
    )


#: A part's box, after it came in sight; null where it is hidden.
BOX = """e => {
  e.scrollIntoViewIfNeeded();
  const {x, y, width, height} = e.getBoundingClientRect();
  return width || height ? {x, y, width, height} : null; }"""


def still(part):
    """The box of a part in sight, once two looks find it at the same place.

    An element that redraws takes its handles away: they have no box for a moment, or
    one that is left by the time the mouse comes.
    """
    box, before = part.evaluate(BOX), None
    for _ in range(100):
        if box is not None and box == before:
            return box
        part.page.wait_for_timeout(20)
        box, before = part.evaluate(BOX), box
    raise AssertionError(f"{part} doesn't stand still: {before}, then {box}")


def middle(part):
    """The point in the middle of a part that stands still."""
    box = still(part)
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def points(slider, *parts):
    """Points of the window on a slider, at parts of its length, whatever is on top."""
    box = still(slider)
    y = box["y"] + box["height"] / 2
    return [(box["x"] + part * box["width"], y) for part in parts]
