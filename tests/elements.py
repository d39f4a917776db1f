"""What every element with sliders owes its readers, checked in a browser."""

import pytest

# the system's colours, the page's own theme, and whether it is dark then
schemes = pytest.mark.parametrize(
    "scheme, theme, dark",
    [
        ("light", None, False),
        ("dark", None, True),
        ("light", "dark", True),
        ("dark", "light", False),
    ],
)


def write_page(path, *pieces):
    """Write a page with elements and what stands between them; the path is returned."""
    path.write_text(
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        '<link rel="icon" href="data:,"><title>t</title></head><body>'
        + "".join(pieces),
        "utf8",
    )
    return path


def two_of(element, folder):
    """Write a page with an element twice, as a chapter may have two of a kind."""
    return write_page(folder / "page.html", element.html, "<p>and</p>", element.html)


def first(tab, tag):
    """The first element of a kind."""
    return tab.page.locator(tag).first


def say(tab, tag):
    """What it says."""
    return first(tab, tag).locator(".sos-readout").inner_text()


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


def brightness(tab, selector, kind):
    """Relative luminance of a colour, as WCAG 2 defines it."""
    return tab.page.evaluate(
        """([selector, kind]) => {
      const style = getComputedStyle(document.querySelector(selector));
      const [r, g, b] = style[kind].match(/[\\d.]+/g).map(x => {
        const c = x / 255;
        return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
      });
      return 0.2126 * r + 0.7152 * g + 0.0722 * b; }""",
        [selector, kind],
    )


#: (selector inside an element, kind of ink, selector of its ground), where there are.
INKS = (
    ("", "color", ""),
    ("svg text", "fill", ""),
    ("figcaption", "color", ""),
    (".sos-readout p", "color", ".sos-readout"),
    (".sos-status", "color", ".sos-readout"),
    (".sos-button", "color", ".sos-readout"),
    (".sos-mark", "color", ""),
    (".sos-tyre", "stroke", ""),
    ("select", "color", "select"),
)


def assert_readable(tab, element, dark):
    """Ink and paper differ by 4.5 or more, and the paper is right."""
    paper = brightness(tab, element, "backgroundColor")
    assert paper < 0.05 if dark else paper > 0.8, element
    for inside, kind, ground in INKS:
        selector = f"{element} {inside}".strip()
        if not tab.page.locator(selector).count():
            continue
        low, high = sorted(
            [
                brightness(tab, selector, kind),
                brightness(tab, f"{element} {ground}".strip(), "backgroundColor"),
            ]
        )
        assert (high + 0.05) / (low + 0.05) > 4.5, selector


def assert_buttons(tab, visit, tag, label):
    """Reset, a link that leads back, and a program; returns what it leaves behind.

    The slider with this label is moved first.
    """
    element = tab.page.locator(tag).first
    readout, slider = (
        element.locator(".sos-readout"),
        element.get_by_role("slider", name=label),
    )
    begin = readout.inner_text()
    last = slider.input_value() == slider.get_attribute("max")
    slider.press("ArrowLeft" if last else "ArrowRight")
    moved = readout.inner_text()
    assert moved != begin
    element.get_by_role("button", name="Link to this").click()
    again = visit(tab.page.url)
    assert again.page.locator(tag).first.locator(".sos-readout").inner_text() == moved
    assert again.errors == []
    element.get_by_role("button", name="As Python").click()
    names = {}
    exec(element.locator("pre").inner_text(), names)
    element.get_by_role("button", name="Reset").click()
    assert readout.inner_text() == begin and element.locator("pre").count() == 0
    return names


def green(tab, tag):
    """For each slider of the first element the stretches of its band, in parts."""
    return tab.page.evaluate(
        """tag => [...document.querySelector(tag).querySelectorAll(".sos-band")].map(
          band => [...band.style.background.matchAll(
            /(region|line)\\) (-?[\\d.]+)% ([\\d.]+)%/g)].map(
            ([, colour, from, to]) => [colour === "region", from / 100, to / 100]))""",
        tag,
    )


def points(slider, *parts):
    """Points of the window on a slider that is brought into it, at parts of its length.

    What is done there by mouse or finger reaches whatever stands on top.
    """
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    y = box["y"] + box["height"] / 2
    return [(box["x"] + part * box["width"], y) for part in parts]
