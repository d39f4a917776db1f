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


def assert_readable(tab, element, theme, dark, *more):
    """Ink and paper differ by 4.5 or more, and the paper is right.

    ``more`` has (selector inside, kind of ink, selector of its ground).
    """
    if theme:
        tab.page.evaluate("t => document.documentElement.dataset.theme = t", theme)
    paper = brightness(tab, element, "backgroundColor")
    assert paper < 0.05 if dark else paper > 0.8
    tinted = ".sos-readout"
    for inside, kind, ground in [
        ("", "color", ""),
        ("svg text", "fill", ""),
        ("figcaption", "color", ""),
        (".sos-readout p", "color", tinted),
        (".sos-status", "color", tinted),
        *more,
    ]:
        selector = f"{element} {inside}".strip()
        low, high = sorted(
            [
                brightness(tab, selector, kind),
                brightness(tab, f"{element} {ground}".strip(), "backgroundColor"),
            ]
        )
        assert (high + 0.05) / (low + 0.05) > 4.5, selector
    assert tab.errors == []


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


def assert_fits_a_phone(tab, element, labels):
    """No sideways scroll, and controls that a thumb can hit."""
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    for label in labels:
        box = tab.page.locator(element).first.get_by_label(label).bounding_box()
        assert box["width"] > 250 and box["height"] >= 24
    assert tab.errors == []
