"""The book's search in a real browser, from the disk: ranked, with excerpts."""

#: Where each result leads to, and its excerpt.
FOUND = """all => all.map(result => [
  result.querySelector("a").getAttribute("href"),
  result.querySelector("p").innerText])"""
#: Where words lead to first, typed one after the other.
LEADS = """(field, all) => all.map(words => {
  field.value = words;
  field.dispatchEvent(new Event("input", {bubbles: true}));
  return document.querySelector("#search-results a")?.getAttribute("href"); })"""


def ask(visit, site, words, **more):
    tab = visit((site / "search.html").as_uri() + f"?q={words}", **more)
    tab.page.locator("#search-results p").first.wait_for(state="attached")
    found = tab.page.locator("#search-results li").evaluate_all(FOUND)
    return tab, [tuple(result) for result in found]


#: Places, with words that lead there first.
FIRST = {
    "04_lmi_regions": "pole placement, root locus",
    "05_h_infinity_norm": "Bode",
    "06_control_signal": "saturation",
    "08_zero_mass": "singular mass",
    "15_delay": "dead time, input delay",
    "18_least_cost": "Riccati",
    "19_observer": "LQG, Kalman, observer",
    "21_rig_to_model": "system identification, identification",
    "23_gains_to_samples": "sampeld, discretize, discretisation",
    "24_on_the_desk": "dead zone, friction, gear play",
    "26_logs_to_c_file": "backlash",
    "34_sensors": "derivative filter, output feedback, which sensors, drive",
    "34_sensors#decentralised-control": "decentralised",
    "37_outputs": "notch, mixed sensitivity",
    "39_law_to_program": "two-mass drive",
    "42_step_ramp_move": "overshoot, settling time, phase margin",
    "33_design_limits": "design limits",
    "glossary": "glossary",
    "glossary#term-gain-scheduling": "gain scheduling, scheduled gains",
    "glossary#term-lead-lag-compensator": "lead-lag",
    "glossary#term-quantisation": "quantization, quantisation",
    "glossary#term-decay-rate": "rise time",
    "glossary#term-fixed-mode": "unobservable",
    "glossary#term-windup": "anti-windup",
    "where_this_stands": "LPV",
    "thesis_references#t-2-18": "T 2.18, eq. (2.18)",
    "thesis_references#t-theorem-2-4": "Theorem 2.4",
    "api/synthesis#sosbook.design_pid": "design_pid, sos.design_pid",
}


def test_an_engineers_word_leads_to_its_place_first_and_nothing_is_said_of_others(
    site, visit
):
    """Typed one after the other: to load the page takes most of a search."""
    tab, _ = ask(visit, site, "pendulum")
    asked = {
        words: "#".join([f"book/{page}.html", *section])
        for place, several in FIRST.items()
        for page, *section in [place.split("#")]
        for words in several.split(", ")
    }
    field = tab.page.locator(".bd-search-container input")
    found = field.evaluate(LEADS, [*asked])
    leads = dict(zip(asked, found, strict=True))
    assert leads == asked
    field.fill("qqqxyz")
    assert tab.page.locator("#search-results li").count() == 0
    assert "Nothing" in tab.page.locator("#search-results p").first.inner_text()
    field.fill("<img src=x onerror=alert(1)>")
    assert tab.page.locator("#search-results img").count() == 0
    assert tab.errors == []


def test_results_have_excerpts_with_the_words_marked_on_a_phone_too(site, visit):
    tab, found = ask(visit, site, "ellipsoid", width=390, scheme="dark")
    assert len(found) >= 10
    assert sum("ellipsoid" in text.lower() for _, text in found) >= 8
    assert tab.page.locator("#search-results mark").count() >= 8
    width = tab.page.evaluate("document.scrollingElement.scrollWidth")
    assert width <= 390


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


def test_the_site_has_no_other_index(site):
    """Sphinx's own, which no page reads, took a twentieth of the build."""
    assert (site / "_static" / "search-index.js").exists()
    assert not (site / "searchindex.js").exists()
