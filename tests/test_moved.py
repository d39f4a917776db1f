"""Old addresses of pages lead to where the pages went."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cases import later

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "book" / "_ext"))
moved = pytest.importorskip("moved")
ONCE_A_WEEK = (
    ("05_hinf", "05_h_infinity_norm"),
    ("13_flexible_arm#equation-eq-13-arm", "14_flexible_arm#equation-eq-14-arm"),
    (
        "09_when_vertices_are_not_enough#thm-09-pairs",
        "09_between_two_plants#thm-09-pairs",
    ),
    (
        "09_when_vertices_are_not_enough#what-it-costs",
        "10_a_p_for_each_plant#what-it-costs",
    ),
    ("22_sharper_certificates#sources", "sharper_certificates#sources"),
)


def test_every_old_page_leads_to_pages_that_are_there():
    pages = {path.stem for path in (ROOT / "book").glob("*.ipynb")}
    for old, news in moved.table().items():
        assert old not in pages and set(news) <= pages, old


def test_no_page_that_was_once_published_is_forgotten():
    """By git: every notebook that a commit of the book took away."""
    asked = "git", "log", "--diff-filter=D", "--no-renames", "--name-only", "--format="
    try:
        found = subprocess.run(
            [*asked, "--", "book/*.ipynb"], cwd=ROOT, capture_output=True, check=True
        ).stdout.decode()
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("not a clone")
    once = set(re.findall(r"^book/(\w+)\.ipynb$", found, re.MULTILINE))
    now = {path.stem for path in (ROOT / "book").glob("*.ipynb")}
    assert {x for x in once - now if re.match(r"\d\d_", x)} <= set(moved.table())


@pytest.mark.parametrize(
    "old, new",
    [
        (
            "09_when_vertices_are_not_enough#thm-09-slack",
            "10_a_p_for_each_plant#thm-10-slack",
        ),
        ("28_discretisation#ex-28-clock", "second_looks#ex-23-clock"),
        *later(*ONCE_A_WEEK),
    ],
)
def test_an_old_address_opens_the_new_page_at_its_place(site, browser, old, new):
    page = browser.new_page()
    stem, _, place = old.partition("#")
    address = (site / "book" / f"{stem}.html").as_uri()
    page.goto(address + (f"#{place}" if place else ""))
    stem, _, place = new.partition("#")
    page.wait_for_url(re.compile(re.escape(f"/{stem}.html")))
    assert page.url.endswith(f"{stem}.html" + (f"#{place}" if place else ""))
    assert not place or page.locator(f"[id='{place}']").count() == 1
    page.close()
