"""Formulas are set at build time: links land, copies have TeX, faults are warnings."""

import random
import re
import sys
from pathlib import Path

import pytest

from tests.cases import campaign
from tests.test_site import PAGES

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r'<a class="[^"]*reference[^"]*" href="([\w./]*\.html)#([^"]+)"')


@pytest.fixture(scope="module")
def mathematics():
    """The extension that sets formulas."""
    sys.path.insert(0, str(ROOT / "book" / "_ext"))
    try:
        import mathematics

        yield mathematics
        mathematics.setter().terminate()
        mathematics.setter.cache_clear()
    finally:
        sys.path.pop(0)


def test_what_is_no_tex_is_a_fault_and_the_next_formula_is_set(mathematics):
    fault = mathematics.formula(r"\nonsense", False)["fault"]
    assert fault == "Undefined control sequence \\nonsense"
    assert "brace" in mathematics.formula("x^{2", False)["fault"]
    assert "<mjx-container" in mathematics.formula("x^2", False)["html"]


@pytest.mark.browser
@pytest.mark.parametrize("count", [2, *campaign([40])])
def test_links_land_on_their_places(site, visit, count):
    pages = [site / f"{page}.html" for page in PAGES if page.startswith("book/")]
    links = {
        (page.parent / to).resolve().as_uri() + "#" + place
        for page in pages
        for to, place in LINK.findall(page.read_text("utf-8"))
    }
    assert len(links) > 400
    where = "() => document.getElementById(decodeURIComponent(location.hash.slice(1)))"
    wrong = {}
    for link in random.Random(40).sample(sorted(links), count):
        tab = visit(link)
        tab.page.wait_for_timeout(300)
        top, left = tab.page.evaluate(
            f"""() => [
              ({where})().getBoundingClientRect().top,
              document.scrollingElement.scrollHeight - innerHeight - scrollY,
            ]"""
        )
        if not -1 <= top <= 150 and left > 1:
            wrong[link] = top
    assert wrong == {}


@pytest.mark.browser
def test_a_copied_paragraph_has_its_formulas(site, visit):
    tab = visit(site / "book/04_lmi_regions.html")
    copied = tab.page.evaluate(
        """() => {
          const math = document.querySelector(".bd-article p mjx-container");
          const taken = new DataTransfer();
          getSelection().selectAllChildren(math.closest("p"));
          document.dispatchEvent(
            new ClipboardEvent("copy", {clipboardData: taken, bubbles: true}));
          return [taken.getData("text/plain"), math.dataset.tex];
        }"""
    )
    text, tex = copied
    assert f"${tex}$" in text and len(text) > len(tex) + 40
    assert tab.errors == []


@pytest.mark.browser
def test_formulas_are_there_without_scripts(site, browser):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((site / "book/16_delay_theorem.html").as_uri())
    assert page.locator(".bd-article mjx-container mjx-mi").count() > 500
    assert page.locator("script[src*=mathjax]").count() == 0
    assert r"\(" not in page.locator(".bd-article").inner_text()
    context.close()
