"""Pages load and do less: sheets without dead rules, boxes that aren't asked again."""

import importlib.util
import sys
from pathlib import Path

import pytest

from tests.cases import campaign
from tests.conftest import Tab, new_sheet

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "book" / "_ext"))
lighter = pytest.importorskip("lighter")

SHEET = """@charset "UTF-8"; /* .gone {} */
a, .seen > *:not(.gone) { content: "}" ; mask: url(data:x;y) }
.gone, .seen.gone { top: 0 }
.gone, .seen:is(.gone, .other)::before { top: 1px }
.seen[class=".gone"] { top: 2px }
.made-of-two { top: 3px }
@media print { .gone { top: 4px } }
@media (x) { .gone { top: 5px } .seen { content: "\\"{" } }
@font-face { src: url("x.woff;") }
@keyframes turn { from { top: 6px } 50.5% { top: 7px } }"""


def test_rules_of_classes_that_nobody_has_are_left_out():
    pages = '<p class="seen"><script>{"a": "<p class=\\"other\\">"}</script>', ""
    words = lighter.words_of(pages, ['add("made-" + kind)'])
    assert {"seen", "other", "made-"} <= words
    kept = lighter.used(SHEET, words)
    assert [k for k in range(8) if f"{k}px" in kept or f": {k} " in kept] == [
        *(1, 2, 3, 6, 7)
    ]
    assert kept.count("{") - kept.count('"{') == kept.count("}") - kept.count('"}')
    assert "@font-face" in kept and "@charset" in kept and "print" not in kept
    same = lighter.used(SHEET, words | {"gone"})
    assert same.split() == lighter.COMMENT.sub("", SHEET).split()


def test_the_sheet_of_formulas_has_the_letters_that_are_used():
    import mathematics

    sheet = mathematics.asked("")["css"]
    mathematics.setter().terminate()
    mathematics.setter.cache_clear()
    kept = lighter.used(sheet, {"mjx-c1D440", "mjx-c7B", "TEX-I", "mjx-c"})
    assert ".mjx-c1D440.TEX-I::before" in kept and 'content: "{"' in kept
    assert ".mjx-c1D441" not in kept and "@font-face" in kept


#: Rules of a whole sheet that the page's lighter one lacks, and that an element has.
LOST = """([whole, light]) => {
  const rules = (text) => {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync(text);
    const all = (list) => [...list].flatMap((rule) =>
      rule.selectorText ? [rule.selectorText] : all(rule.cssRules || []));
    return all(sheet.cssRules);
  };
  const kept = new Set(rules(light));
  const gone = rules(whole).filter((selector) => !kept.has(selector));
  const bare = (selector) => selector
    .replace(/::?(before|after|[a-z-]*placeholder)/g, "")
    .replace(/:(hover|focus[a-z-]*|active|target|visited)/g, "");
  return [gone.length, gone.filter((selector) => {
    try {
      return document.querySelector(bare(selector));
    } catch { return false; }  // a pseudo-element of another browser
  })];
}"""
THEME = "theme/pydata_sphinx_theme/static/styles/pydata-sphinx-theme.css"


@pytest.fixture(scope="module")
def chapter(browser, site):
    """A chapter, opened once: what a test leaves there is no matter to another."""
    page = new_sheet(browser, painted=False)
    page.goto((site / "book/08_zero_mass.html").as_uri())
    yield Tab(page).typeset()
    page.context.close()


def test_no_element_has_a_rule_that_was_left_out(site, chapter):
    assert_no_rule_is_lost(site, chapter)


@pytest.mark.parametrize(
    "page",
    [
        "search",
        *campaign(["book/intro", "book/own_plant", "book/api/loops", "genindex"]),
    ],
)
def test_no_element_of_another_page_has_a_rule_that_was_left_out(site, visit, page):
    assert_no_rule_is_lost(site, visit(site / f"{page}.html"))


def assert_no_rule_is_lost(site, tab):
    theme = Path(importlib.util.find_spec("pydata_sphinx_theme").origin).parent / THEME
    light = site / "_static" / "styles" / theme.name
    texts = [path.read_text("utf-8") for path in (theme, light)]
    count, lost = tab.page.evaluate(LOST, texts)
    assert count > 2000 and lost == []
    assert light.stat().st_size < 0.4 * theme.stat().st_size


#: How often the page asks a box of code how wide its content is.
COUNT = """
const {get} = Object.getOwnPropertyDescriptor(Element.prototype, "scrollWidth");
globalThis.asked = 0;
Object.defineProperty(Element.prototype, "scrollWidth", {get() {
  globalThis.asked += this.localName === "pre";
  return get.call(this);
}});
"""


def test_boxes_are_not_asked_again_when_something_else_changes(chapter):
    chapter.page.evaluate(COUNT)
    chapter.page.evaluate(
        """() => {
      document.querySelector(".bd-article h1").append(document.createElement("i"));
      dispatchEvent(new Event("resize"));
    }"""
    )
    chapter.page.wait_for_timeout(500)  # the theme's script waits for 0.3 s
    assert chapter.page.evaluate("asked") == 0


#: Where the mark is while the reader goes through the page: contents, or the text.
MARKS = """async () => {
  const frame = () => new Promise(requestAnimationFrame), marks = new Set();
  for (let y = 0; y < document.body.scrollHeight; y += 250) {
    scrollTo(0, y);
    await frame();
    await frame();
    document.querySelectorAll("a.active[href^='#']").forEach((link) =>
      marks.add(link.closest("#pst-page-toc-nav") ? link.hash : "text"));
  }
  const open = [...document.querySelectorAll("#pst-page-toc-nav a")].filter((link) =>
    !document.querySelector(`details:not([open]) ${link.hash}`));
  return [[...marks], open.map((link) => link.hash)];
}"""


def test_the_contents_beside_the_page_follow_the_reader(chapter):
    """What the text refers to doesn't take the mark from its section, and no section
    is asked that is folded.
    """
    marks, sections = chapter.page.evaluate(MARKS)
    assert set(marks) <= set(sections)
    assert len(marks) > 0.7 * len(sections) > 7
