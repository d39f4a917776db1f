"""The built book in a real browser, opened as a file and without a network."""

import re
from functools import cache
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from urllib.parse import unquote, urlsplit

import pytest

from sosbook.book import notebooks
from tests import layout
from tests.cases import campaign
from tests.tags import Tags, bare

ROOT = Path(__file__).resolve().parent.parent
CONTENTS = (ROOT / "_toc.yml").read_text("utf-8")
PAGES = re.findall(r"^.*\b(?:root|file): *(\S+)", CONTENTS, re.MULTILINE)
ALL_PAGES = [*PAGES, "search", "genindex"]
TURN = ALL_PAGES[1::5]  # of each part of the book some, of both schemes
SHARES = 4  # of the pages that have elements of all kinds
LIGHT, DARK = "rgb(255, 255, 255)", "rgb(18, 18, 18)"
#: Bytes, uncompressed: the first page, and any other.
FIRST, ANY = 1_500_000, 2_500_000
each_page = pytest.mark.parametrize("page", ALL_PAGES)

#: Every element of the page, those inside custom elements too.
ALL = """
const all = (root, found = []) => {
  for (const element of root.querySelectorAll("*")) {
    found.push(element);
    if (element.shadowRoot) all(element.shadowRoot, found);
  }
  return found;
};
"""

FAINT = (
    "() => {"
    + ALL
    + """
  document.getAnimations().forEach((change) => change.finish());
  const parse = (colour) => {
    const [r, g, b, a = 1] = colour.match(/[\\d.]+/g).map(Number);
    return [r, g, b, a];
  };
  const over = ([r, g, b, a], [R, G, B]) =>
    [r * a + R * (1 - a), g * a + G * (1 - a), b * a + B * (1 - a), 1];
  const parent = (element) => element.parentElement || element.getRootNode().host;
  const papers = new Map([[undefined, [255, 255, 255, 1]]]);
  const ground = (element) => {
    const colour = parse(getComputedStyle(element).backgroundColor);
    return colour[3] === 1 ? colour : over(colour, paper(parent(element)));
  };
  const paper = (element) => {
    if (!papers.has(element)) papers.set(element, ground(element));
    return papers.get(element);
  };
  const light = (colour) => {
    const [r, g, b] = colour.slice(0, 3).map((value) => {
      const part = value / 255;
      return part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05;
  };
  const contrast = (element) => {
    const back = paper(element);
    const ink = over(parse(getComputedStyle(element).color), back);
    const [x, y] = [light(ink), light(back)];
    return Math.max(x, y) / Math.min(x, y);
  };
  const silent = "svg, script, style, mjx-container, .headerlink, option, :disabled";
  const speaks = (element) =>
    [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
  const seen = all(document)
    .filter((element) => speaks(element) && !element.closest(silent))
    .filter((element) => element.checkVisibility({ opacityProperty: true }));
  if (!seen.length) return ["no text at all"];
  return seen
    .map((element) => [contrast(element), element.outerHTML.slice(0, 120)])
    .filter(([value]) => value < 4.5);
}"""
)


def assert_readable(tab, paper):
    """The page gets this background, and every text stands out from its own."""
    tab.page.evaluate(layout.FRAME)
    tab.page.wait_for_function(
        "(paper) => getComputedStyle(document.body).backgroundColor === paper",
        arg=paper,
    )
    assert tab.page.evaluate(FAINT) == []


def assert_fits_a_phone(tab):
    needed, there = tab.page.evaluate(
        "() => [document.scrollingElement.scrollWidth,"
        " document.documentElement.clientWidth]"
    )
    assert needed <= there == 390


def faults(tab, *names):
    """What the page's layout does wrong, by the names of `layout`."""
    asked = ", ".join(f"({getattr(layout, name).strip()})()" for name in names)
    answers = zip(names, tab.page.evaluate(f"() => [{asked}]"), strict=True)
    return {name: answer for name, answer in answers if answer}


def assert_opens(tab, page, height):
    """Chapters and first pages show their picture on the first screen."""
    top = tab.page.evaluate(layout.OPENING)
    if re.match(r"book/(\d\d_|intro|own_plant)", page):
        assert top is not None and top < height - 100, top


#: How far the page's parts moved by themselves: 0.1 is what readers notice.
SHIFT = """() => new Promise((done) => new PerformanceObserver((list) =>
  done(list.getEntries().reduce((sum, {value}) => sum + value, 0))
).observe({type: "layout-shift", buffered: true}) || setTimeout(done, 50, 0))"""


#: Width and height of a window, and what shows above its lower edge: a desk's has a
#: bar to scroll.
DESK, PHONE = (1265, 900, 800), (390, 900, 844)
#: Chapters with one and with two sections for readers of the thesis.
FOLDED = "02_descriptor_form", "12_car_seat"
ON_A_PHONE = "CUT_FIGURES", "SMALL_LETTERS", "LOOSE_READOUTS", "PROGRAM_UNITS"


def looks_of(page):
    """A desk in the light and a phone in the dark, or the other way round, by turns."""
    looks = [(DESK, "light", LIGHT), (PHONE, "dark", DARK)]
    return looks[::-1] if ALL_PAGES.index(page) % 2 else looks


def assert_looks(tab, page, looks):
    """A page that was opened is quiet, light and still, and right in each look."""
    assert tab.page.evaluate(SHIFT) < 0.05
    assert tab.errors == []
    assert [url for url in tab.requests if not url.startswith("file:")] == []
    assert_light(loaded(tab), page)
    assert faults(tab, "THIN_CAPTIONS", "REPEATED_IDS") == {}
    for look, ((width, height, shown), scheme, paper) in enumerate(looks):
        if look:
            turn(tab, width, height, scheme)
        assert_readable(tab, paper)
        assert_opens(tab, page, shown)
        assert faults(tab, "CUT_FORMULAS", "BAD_ICONS", "WIDE_BOXES") == {}
        if width == PHONE[0]:
            assert_fits_a_phone(tab)
            assert faults(tab, *ON_A_PHONE) == {}
        assert_boxes_speak(tab)


@pytest.mark.parametrize("page", TURN)
def test_page_is_quiet_readable_and_fits_a_phone(site, visit, page):
    """On a phone, which has the least room, in the light and in the dark by turns. A
    fifth of each kind of pages; all, on a desk, too, once a week. Of every page
    `test_names_headings_and_references_are_there` asks what its file tells, and
    `test_every_element_of_the_book_starts_and_fits_a_phone` opens the elements of all.
    """
    _, scheme, paper = looks_of(page)[0]
    width, height, _ = PHONE
    tab = visit(site / f"{page}.html", width, height, scheme, painted=True)
    assert_looks(tab, page, [(PHONE, scheme, paper)])


@pytest.mark.parametrize("share", range(SHARES))
def test_each_kind_of_element_is_right_on_a_desk_and_a_phone(
    site, visit, axe, share, pytestconfig
):
    """And axe has no objection: on pages that have all kinds between them, once a week
    on all. Of every page `test_names_headings_and_references_are_there` asks what axe
    says of single texts and numbers.
    """
    whole = pytestconfig.getoption("--campaign")
    tab = None
    for page in (ALL_PAGES if whole else judged(site))[share::SHARES]:
        print(page)  # shown if it fails
        looks = looks_of(page)
        (width, height, _), scheme, _ = looks[0]
        path = site / f"{page}.html"
        if tab:
            tab.left().opened(path.as_uri(), width, height, scheme)
        else:
            tab = visit(path, width, height, scheme, painted=True)
        assert_looks(tab, page, looks)
        assert_accessible(tab, axe)


def turn(tab, width, height, scheme):
    """A window of this size and, as the theme's button makes them, of these colours.
    The page is out of sight for a moment, or all would be styled for each of the two.
    """
    code = """scheme => {
      const still = new CSSStyleSheet();
      still.replaceSync("* {transition: none !important}");
      document.adoptedStyleSheets.push(still);
      document.body.style.contentVisibility = "hidden";
      document.documentElement.dataset.theme = scheme; }"""
    tab.page.evaluate(code, scheme)
    tab.page.set_viewport_size({"width": width, "height": height})
    tab.page.evaluate("() => { document.body.style.contentVisibility = '' }")


def loaded(tab):
    """The files that the browser asked for; fonts and what scripts load, too."""
    return {Path(unquote(urlsplit(url).path)) for url in tab.requests}


def assert_light(files, page):
    """Not more than a reader of this page should load."""
    weight = sum(file.stat().st_size for file in files)
    assert weight <= (FIRST if page == "book/intro" else ANY)


def assert_accessible(tab, axe):
    """Axe has no objection."""
    tab.page.evaluate(layout.BARE)
    tab.page.add_script_tag(url=axe)
    assert tab.page.evaluate(layout.AXE) == []


def assert_boxes_speak(tab):
    """The page's script has marked every box that scrolls, at this width."""
    tab.page.evaluate(layout.FRAME)
    tab.page.wait_for_function(f"() => ({layout.SILENT_BOXES})().length === 0")


@pytest.mark.parametrize(
    "page",
    [
        "book/intro",
        *campaign(["book/16_delay_theorem", "book/25_program", "book/reproduction"]),
    ],
)
def test_a_phone_in_the_dark_may_open_the_page_itself(site, visit, page):
    tab = visit(site / f"{page}.html", 390, scheme="dark", painted=True)
    assert tab.errors == []
    assert_fits_a_phone(tab)
    assert_readable(tab, DARK)
    tab.page.set_viewport_size({"width": 1280, "height": 900})
    assert_readable(tab, DARK)


def light(path, folder):
    """A copy of a page with its scripts, but without formulas and strokes."""
    copy = folder / path.name
    base = f'<head><base href="{path.as_uri()}">'
    copy.write_text(bare(path.read_text("utf-8")).replace("<head>", base, 1), "utf-8")
    return copy.as_uri()


def test_sections_for_readers_of_the_thesis_are_folded_until_asked_for(
    site, visit, tmp_path
):
    short, long = (light(site / "book" / f"{x}.html", tmp_path) for x in FOLDED)
    tab = visit(short)
    sections = tab.page.locator("details.sos-thesis")
    inside = sections.locator("p").nth(1)
    assert not inside.is_visible()
    sections.locator("summary").first.click()
    assert inside.is_visible()
    sections.get_by_role("checkbox").check()
    tab.page.goto(long)
    opened = [x.get_attribute("open") for x in sections.all()]
    assert len(opened) == 2 and None not in opened
    sections.first.get_by_role("checkbox").uncheck()
    tab.page.goto(short)
    assert [x.get_attribute("open") for x in sections.all()] == [None]
    place = sections.locator("[id]").first.get_attribute("id")
    tab.page.goto(f"{short}#{place}")
    tab.page.reload()
    assert sections.get_attribute("open") is not None
    assert tab.errors == []


@cache
def tags_of(path):
    """`Tags` of a page, read once."""
    return Tags(path.read_text("utf-8"))


@cache
def judged(site):
    """A few pages that have elements of all kinds between them: each next has the most
    new ones for its length, and what it has isn't opened twice if another does.
    """
    paths = {page: site / f"{page}.html" for page in ALL_PAGES}
    kinds = {page: tags_of(path).kinds for page, path in paths.items()}
    costs = {p: x.stat().st_size * (1 + (p in TURN)) for p, x in paths.items()}
    left, found = set().union(*kinds.values()), []
    while left:
        found.append(max(kinds, key=lambda page: len(kinds[page] & left) / costs[page]))
        left -= kinds[found[-1]]
    for page in [*found]:
        others = [kinds[x] for x in found if x != page]
        if kinds[page] <= set().union(*others):
            found.remove(page)
    return found


#: A formula as MathJax writes it, what of it listeners get, and mistakes in it.
FORMULA, TOLD = "<mjx-container", "<mjx-assistive-mml"
MISTAKES = "<mjx-merror", "data-mjx-error"
#: One size whatever the reader's font.
SIZE = re.compile(r'<mjx-container [^>]*style="font-size: 120%;')


@each_page
def test_names_headings_and_references_are_there(site, page):
    """What axe would say of a page whose elements are of kinds that it has judged; that
    all formulas are typeset, in the size of all fonts; and the weight of what it names.
    """
    path = site / f"{page}.html"
    text, tags = path.read_text("utf-8"), tags_of(path)
    assert tags.faults() == []
    assert all(FORMULA in x for x in re.split(r'class="math\b', text)[1:])
    assert text.count(FORMULA) == text.count(TOLD) == len(SIZE.findall(text))
    assert not any(x in text for x in MISTAKES)
    named = {(path.parent / unquote(urlsplit(x).path)).resolve() for x in tags.loads}
    assert_light({path, *(x for x in named if x.suffix != ".html")}, page)


#: Whether a page gets what it asks for.
GETS = """url => fetch(url, {mode: "no-cors"}).then(() => true, () => false)"""


def test_a_page_reaches_no_network_and_what_it_asks_for_is_noticed(visit, tmp_path):
    """Not even another address of this machine, where someone answers."""
    (tmp_path / "page.html").write_text("<title>t</title>", "utf-8")
    tab = visit(tmp_path / "page.html")
    with ThreadingHTTPServer(("", 0), SimpleHTTPRequestHandler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        asked = f"http://127.0.0.2:{server.server_port}/a", "https://example.org/a.js"
        got = [tab.page.evaluate(GETS, url) for url in asked]
        server.shutdown()
    assert got == [False, False]
    assert tab.requests[1:] == [*asked]
    assert [x for x in tab.errors if x.startswith("failed: ")] == [
        f"failed: {url}" for url in asked
    ]


@pytest.mark.parametrize("missing", ["worker", "file"])
def test_what_a_page_asks_for_in_vain_is_heard(missing, visit, tmp_path):
    """A worker's text that is gone is no request that fails, but an exception."""
    script = {
        "worker": """const u = URL.createObjectURL(new Blob(["1"]));
            URL.revokeObjectURL(u); new Worker(u);""",
        "file": "document.body.append(new Image()); document.images[0].src = 'no.png';",
    }
    page = tmp_path / "page.html"
    page.write_text(
        f"<!doctype html><title>t</title><body><script>{script[missing]}</script>",
        "utf-8",
    )
    tab = visit(page)
    tab.page.wait_for_timeout(100)
    said = {"worker": "'Worker'", "file": "failed: file:"}[missing]
    assert any(said in error for error in tab.errors), tab.errors


def test_a_tab_has_nothing_of_the_page_before(visit, tmp_path):
    """Nor of the same page at another place, which is loaded anew."""
    loud, calm = tmp_path / "loud.html", tmp_path / "calm.html"
    loud.write_text(
        """<title>t</title><script>
        globalThis.heard = (globalThis.heard ?? "") + location.hash + localStorage.a;
        localStorage.a = 1;
        setInterval(() => console.error("loud"), 1);</script>""",
        "utf-8",
    )
    calm.write_text("<title>t</title>", "utf-8")
    tab = visit(loud)
    tab.page.wait_for_timeout(20)
    assert set(tab.errors) == {"loud"}
    again = f"{loud.as_uri()}#x"
    assert tab.left().opened(again, 390, 844, "dark") is tab
    assert tab.page.evaluate("heard") == "#xundefined"
    tab.left().opened(calm.as_uri(), 1280, 900, "light")
    assert (tab.errors, tab.requests) == ([], [calm.as_uri()])


@pytest.mark.parametrize(
    "text, fault",
    [
        ("<h1>a<a href='#b'>#</a></h1><p id=b><h2>c</h2>", ""),
        ("<h1>a</h1><h2>b</h2><h2>c</h2><h3>d</h3><h2>e</h2>", ""),
        ("<h1>a</h1><a href='x'><img src=b alt='c'></a>", ""),
        ("<h1>a</h1><button aria-label='b'></button><button title='c'><i></i>", ""),
        ("<h1>a</h1><h3>b</h3>", "h3 after h1"),
        ("<h2>a</h2>", "0 h1"),
        ("<h1>a</h1><h1>b</h1>", "2 h1"),
        ("<h1>a</h1><h2> </h2>", "h2 without a name"),
        ("<h1>a</h1><a href='x'><img src=b></a><p>c", "a without a name"),
        ("<h1>a</h1><button title='b'></button><button><i></i></button>", "button wi"),
        ("<h1>a</h1><p id=b><p id=b>", "id b twice"),
        ("<h1>a</h1><label for=b>c</label>", "nothing has the id b"),
        ("<h1>a</h1><p id=c><p aria-labelledby='c b'>", "nothing has the id b"),
    ],
)
def test_what_a_page_s_tags_lack_is_named(text, fault):
    found = Tags(f"<main>{text}</main>").faults()
    assert len(found) == bool(fault) and all(fault in x for x in found)


def test_axe_judges_each_kind_of_element(site):
    """On fewer than half of the pages; a fault of a new kind comes to one of them."""
    assert 5 < len(judged(site)) < len(PAGES) / 2


@each_page
def test_links_lead_somewhere(site, page):
    path = site / f"{page}.html"
    found = tags_of(path)
    assert [url for url in found.loads if urlsplit(url).netloc] == []
    broken = []
    for address in found.links + found.loads:
        parts = urlsplit(address)
        if parts.scheme or parts.netloc:
            continue
        target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
        if not target.is_file():
            broken.append(address)
        elif target.suffix == ".html" and parts.fragment:
            if unquote(parts.fragment) not in tags_of(target).anchors:
                broken.append(address)
    assert broken == []


@each_page
def test_icons_need_no_script(site, page):
    assert "fontawesome" not in (site / f"{page}.html").read_text("utf-8")
    assert not list((site / "_static" / "scripts").glob("fontawesome*"))


def test_first_page_leads_to_the_introduction(site):
    text = (site / "index.html").read_text("utf-8")
    assert re.search(r'http-equiv="Refresh"[^>]*url=book/intro.html"', text)


def test_each_notebook_can_be_downloaded_as_it_is_in_the_book(site):
    for notebook in (ROOT / "book").glob("*.ipynb"):
        copy = site / "_sources" / "book" / notebook.name
        assert copy.read_bytes() == notebook.read_bytes()
        assert f"_sources/book/{notebook.name}" in (
            site / "book" / f"{notebook.stem}.html"
        ).read_text("utf-8")


def test_no_slider_is_dead_in_the_pages(site):
    """A widget needs a kernel, so its output must not be in a page."""
    for page in PAGES:
        text = (site / f"{page}.html").read_text("utf-8")
        assert "widget-view+json" not in text
        assert "jupyter-widgets" not in text


def test_the_page_of_theorems_lists_every_statement(site):
    listed = tags_of(site / "book" / "theorems.html").links
    kinds = "theorem|lemma|proposition|corollary|definition|algorithm"
    form = rf"\{{prf:(?:{kinds})\}}[^\n]*\n(?::\w+:.*\n)*?:label: (\S+)"
    count = 0
    for notebook in sorted((ROOT / "book").glob("*.ipynb")):
        for cell in notebooks.read(notebook).cells:
            for label in re.findall(form, cell.source):
                assert f"{notebook.stem}.html#{label}" in listed
                count += 1
    assert count > 90
