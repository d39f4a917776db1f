"""What a notebook shows of a result: complete, readable, escaped."""

import html.parser
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.display.card import card
from sosbook.display.escape import json_text, page_text
from sosbook.display.pole_map import pole_map
from sosbook.requirements.stability import Stability
from tests.elements import assert_readable, still
from tests.processes import process
from tests.test_results import CART, MAKE, PAIR, REFUSED

HOSTILE = [
    "</script><img src=x onerror=alert(1)>",
    "<b>bold</b>",
    "a\"b' onmouseover='x",
    "a\nb",
    "a`b${c}",
    "a&b",
    "../up",
    "",
    " ",
]
ROBOT = thesis.example_1()


class Reader(html.parser.HTMLParser):
    """Tags, their attributes and the text of a card."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.open, self.text = [], [], ""
        self.feed(page)
        assert self.open == [], "a tag stays open"

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not self.open or self.open[-1] != "style":
            self.text += data + " "


def tags(reader, name, kind=None):
    found = [a for tag, a in reader.tags if tag == name]
    return found if kind is None else [a for a in found if a.get("class") == kind]


@pytest.mark.parametrize("name", MAKE)
@pytest.mark.parametrize("plant", [CART, PAIR], ids=["plant", "polytope"])
def test_every_result_shows_itself(name, plant):
    if name == "SampledLQR" and plant is PAIR:
        pytest.skip("a sampled LQR is of one plant")
    found = MAKE[name](plant)
    page = Reader(found._repr_html_())
    assert "feasible" in page.text and name in page.text
    poles = np.ravel(found.poles())
    assert len(tags(page, "path", "sos-pole")) == len(poles)
    (picture,) = [a for a in tags(page, "svg") if "role" in a]
    assert picture["aria-label"].startswith(f"{len(poles)} poles")
    for x in np.ravel(found.K):
        assert f"{x:.4g}" in page.text
    least = min(found.margins, key=found.margins.get)
    assert least in page.text and f"{found.margins[least]:.2g}" in page.text
    assert "certify()" in page.text
    assert not {t for t, _ in page.tags} & {"script", "img", "link", "iframe"}
    assert not re.search(r"https?:|url\(|@import", found._repr_html_())


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_says_what_to_do(name):
    found = REFUSED[name]()
    page = Reader(found._repr_html_())
    assert found.status in page.text and found.advice in page.text
    assert tags(page, "svg") == []


def test_the_picture_shows_the_poles_where_they_are():
    """Crosses, read back through the ticks, are the poles."""
    poles = np.array([-3 + 2j, -3 - 2j, -1, 0.5])
    region = sos.PoleRegion(sigma=0.5, theta=1, rho=5)
    page = pole_map([poles], region)
    crosses = np.array(
        [
            [float(x) + 4 for x in m.groups()]
            for m in re.finditer(r'sos-pole" d="M([-\d.]+) ([-\d.]+)l', page)
        ]
    )
    ticks = re.findall(r'<text x="([\d.]+)" y="([\d.]+)" [^>]*>(-?[\d.]+)</text>', page)
    below = [(float(x), float(v)) for x, y, v in ticks if float(y) > 250]
    beside = [(float(y) - 4, float(v)) for x, y, v in ticks if float(x) < 46]
    across = np.polyfit(*zip(*below), 1)
    up = np.polyfit(*zip(*beside), 1)
    found = np.polyval(across, crosses[:, 0]) + 1j * np.polyval(up, crosses[:, 1])
    assert found == pytest.approx(poles, abs=0.05)
    assert "some lie outside the shaded region" in page
    corners = re.search(r'sos-region" points="([^"]+)"', page)[1].split()
    x, y = np.transpose([[float(c) for c in p.split(",")] for p in corners])
    outline = np.polyval(across, x) + 1j * np.polyval(up, y)
    assert np.abs(outline).max() == pytest.approx(5, abs=0.1)
    assert outline.real.max() == pytest.approx(-0.5, abs=0.1)


def test_large_things_are_summed_up():
    K = np.arange(40.0).reshape(1, 40)
    margins = {f"block {k}": k + 1.0 for k in range(30)}
    page = Reader(card("Design", "feasible", gains=[("K_P", K)], margins=margins))
    assert "1 × 40, largest entry 39" in page.text
    assert "the least of 30" in page.text and "block 5" in page.text
    assert "block 6" not in page.text


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_are_refused_or_escaped(name):
    with pytest.raises(ValueError, match="letters, digits, spaces and hyphens"):
        sos.LMIRegion([[1]], [[1]], name)

    class Own(Stability):
        pass

    own = Own()
    object.__setattr__(own, "name", name)
    with pytest.raises(ValueError, match="letters, digits, spaces and hyphens"):
        sos.design_pid(CART, requirements=[own])
    page = Reader(
        card(name, name, [[-1]], None, [(name, [[1.0]])], {name: 1.0}, [name], name)
    )
    known = {"div", "style", "p", "span", "svg", "rect", "path", "text", "table"}
    known |= {"caption", "tr", "td", "th", "b"}
    assert {tag for tag, _ in page.tags} <= known
    attributes = {key for _, a in page.tags for key in a}
    assert not any(key.startswith("on") for key in attributes)
    if name.strip():
        assert name in page.text


@pytest.mark.parametrize("name", HOSTILE)
def test_one_place_makes_text_safe(name):
    assert not set("<>\"'") & set(page_text(name))
    assert "<" not in json_text({name: [name]})


def test_nothing_but_that_place_escapes():
    """Nobody else writes entities or JSON into a page."""
    package = Path(sos.__file__).parent
    for file in package.rglob("*.py"):
        text = file.read_text("utf8")
        if file.name == "escape.py":
            continue
        assert "html.escape" not in text and "u003c" not in text, file


def test_names_with_all_that_is_allowed_are_shown():
    region = sos.LMIRegion([[2.0]], [[1.0]], "left of minus-1 now")
    design = sos.design_pid(ROBOT.plant, region=region)
    assert "left of minus-1 now" in Reader(design._repr_html_()).text


@pytest.mark.slow
def test_a_card_needs_neither_matplotlib_nor_control():
    code = """
import sys
for name in ("matplotlib", "control", "IPython", "ipywidgets"):
    sys.modules[name] = None
import sosbook as sos
plant = sos.SecondOrderSystem(M=1, D=0, S=1, B=1)
page = sos.design_pid(plant, region=sos.PoleRegion(sigma=0.5))._repr_html_()
print(page[:26], "sos-pole" in page)
"""
    done = process(sys.executable, "-c", code, check=True)
    assert done.stdout == '<div class="sos-result" ro True\n'


def test_the_same_design_is_the_same_card():
    cards = {
        sos.design_pid(CART, region=sos.PoleRegion(sigma=0.5))._repr_html_()
        for _ in range(2)
    }
    assert len(cards) == 1 and "id=" not in cards.pop()


@pytest.fixture(scope="module")
def sheet(tmp_path_factory):
    """A page with a feasible and an infeasible design, and no other style."""
    cards = [
        sos.design_pid(ROBOT.plant, ROBOT.U, region=ROBOT.region),
        REFUSED["Design"](),
        sos.design_pid(ROBOT.plant, region=sos.LMIRegion.disk(5, name="a" * 60)),
    ]
    path = tmp_path_factory.mktemp("cards") / "index.html"
    path.write_text(
        '<!doctype html><html><head><meta charset="utf-8"><meta name="viewport" '
        'content="width=device-width"></head><body>'
        + "".join(design._repr_html_() for design in cards),
        "utf8",
    )
    return path


def test_cards_are_readable_in_light_and_dark(visit, sheet):
    inks = (
        ("", "color", "", 4.5),
        ("svg text", "fill", "", 4.5),
        (".sos-feasible", "color", "", 4.5),
        (".sos-infeasible", "color", "", 4.5),
        ("td", "color", "", 4.5),
        (".sos-pole", "stroke", "", 3),
    )
    assert assert_readable(visit(sheet), [".sos-result"], inks) == len(inks)


def test_cards_fit_a_phone(visit, sheet):
    tab = visit(sheet, width=360, height=800)
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    boxes = tab.page.locator(".sos-result svg[role=img]")
    assert boxes.count() == 2
    assert all(still(boxes.nth(k))["width"] > 150 for k in range(2))
