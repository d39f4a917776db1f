"""The book's search in a real browser, from the disk: ranked, with excerpts."""

import pytest


def ask(visit, site, words, **more):
    tab = visit((site / "search.html").as_uri() + f"?q={words}", **more)
    tab.page.locator("#search-results p").first.wait_for(state="attached")
    found = tab.page.locator("#search-results li")
    return tab, [
        (
            found.nth(k).locator("a").get_attribute("href"),
            found.nth(k).locator("p").inner_text(),
        )
        for k in range(found.count())
    ]


@pytest.mark.parametrize(
    "words, page",
    [
        ("saturation", "book/06_saturation.html"),
        ("singular mass", "book/08_singular_mass.html"),
        ("observer", "book/24_observer.html"),
        ("identification", "book/26_identification.html"),
        ("input delay", "book/19_input_delay.html"),
        ("glossary", "book/glossary.html"),
    ],
)
def test_the_chapter_about_a_word_is_among_the_first(site, visit, words, page):
    tab, found = ask(visit, site, words)
    assert page in [address.split("#")[0] for address, _ in found[:5]]
    assert tab.errors == []


@pytest.mark.parametrize(
    "words, place",
    [
        ("phase margin", "book/19_input_delay.html"),
        ("Bode", "book/05_hinf.html"),
        ("derivative filter", "book/36_sensors.html book/api/laws.html"),
        ("output feedback", "book/36_sensors.html"),
        ("which sensors", "book/36_sensors.html"),
        ("decentralised", "book/36_sensors.html#decentralised-control"),
        ("overshoot", "book/13_flexible_arm.html"),
        ("anti-windup", "book/glossary.html#term-windup"),
        ("dead time", "book/19_input_delay.html"),
        ("pole placement", "book/04_lmi_regions.html"),
        ("settling time", "book/glossary.html#term-decay-rate"),
        ("unobservable", "book/glossary.html#term-fixed-mode book/41_limits.html"),
        ("design limits", "book/41_limits.html"),
        ("Riccati", "book/23_lqr.html"),
        ("sampeld", "book/28_discretisation.html"),
        ("T 2.18", "book/thesis_references.html#t-2-18"),
        ("eq. (2.18)", "book/thesis_references.html#t-2-18"),
        ("Theorem 2.4", "book/thesis_references.html#t-theorem-2-4"),
    ],
)
def test_an_engineers_word_leads_to_its_place(site, visit, words, place):
    _, found = ask(visit, site, words)
    assert found[0][0] in place.split()


def test_a_function_is_first_under_its_own_name(site, visit):
    for words in ("design_pid", "sos.design_pid"):
        _, found = ask(visit, site, words)
        assert found[0][0] == "book/api/synthesis.html#sosbook.design_pid"


def test_results_have_excerpts_with_the_words_marked_on_a_phone_too(site, visit):
    tab, found = ask(visit, site, "ellipsoid", width=390, scheme="dark")
    assert len(found) >= 10
    assert sum("ellipsoid" in text.lower() for _, text in found) >= 8
    assert tab.page.locator("#search-results mark").count() >= 8
    width = tab.page.evaluate("document.scrollingElement.scrollWidth")
    assert width <= 390


def test_typing_searches_again_and_nothing_is_said_where_nothing_is(site, visit):
    tab, _ = ask(visit, site, "pendulum")
    field = tab.page.locator(".bd-search-container input")
    field.fill("qqqxyz")
    assert tab.page.locator("#search-results li").count() == 0
    assert "Nothing" in tab.page.locator("#search-results p").first.inner_text()
    field.fill("<img src=x onerror=alert(1)>")
    assert tab.page.locator("#search-results img").count() == 0
    assert tab.errors == []


def test_every_result_leads_somewhere(site, visit):
    tab, _ = ask(visit, site, "")
    pages, rows = tab.page.evaluate("[SOS_SEARCH.pages, SOS_SEARCH.rows]")
    assert len(pages) > 40 and len(rows) > 700
    texts = {address: (site / address).read_text("utf-8") for address, _ in pages}
    lost = [
        (pages[page][0], place)
        for page, place, *_ in rows
        if place and f'id="{place}"' not in texts[pages[page][0]]
    ]
    assert lost == []
