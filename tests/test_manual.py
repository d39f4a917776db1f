"""The package's manual: every public name has an entry, and code leads there."""

import importlib
import inspect
import re
import sys
from pathlib import Path

import pytest
from sphinx.util.inventory import InventoryFile

import sosbook

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "book" / "_ext"))
import manual as sheets  # noqa: E402
import manual_names as names  # noqa: E402


def public(module):
    """A module's public objects that aren't modules."""
    there = importlib.import_module(module)
    things = ((name, getattr(there, name)) for name in getattr(there, "__all__", ()))
    return {f"{module}.{name}" for name, x in things if not inspect.ismodule(x)}


@pytest.mark.parametrize(
    "module",
    ["sosbook"]
    + [
        f"sosbook.{room}"
        for room in sosbook._ROOMS
        if hasattr(importlib.import_module(f"sosbook.{room}"), "__all__")
    ],
)
def test_every_public_name_of_a_room_has_an_entry(module):
    assert public(module) <= names.names().keys()


def test_an_object_has_one_entry_under_its_shortest_name():
    homes = [names._key(e.thing, e.name) for e in names.entries().values()]
    assert len(homes) == len(set(homes)) > 150
    entry, rest = names.lookup("sosbook.plants.second_order.Polytope.at")
    assert (entry.name, rest) == ("sosbook.Polytope", "at")
    inner = names.lookup("sosbook.studies.maps.edges.edge")[0]
    assert inner.name == "sosbook.studies.maps.edge"
    assert names.lookup("sosbook.no_such_name") is None


def test_words_of_docstrings_are_resolved_where_they_stand():
    assert names.resolve("design_pid", "sosbook") == "sosbook.design_pid"
    inside = names.resolve("infeasibility", "sosbook.Design")
    assert inside == "sosbook.Design.infeasibility"
    assert names.exists("mean_descriptor")
    assert not names.exists("a_word_that_names_nothing")


def test_names_of_a_program_are_found_through_its_imports():
    program = (
        "import sosbook as sos\nfrom sosbook.lmi import block as matrix\n"
        "%time x = 1\nsos.studies.maps.edge('rho')\nmatrix([])\nother.design_pid()\n"
    )
    names_there = {"sosbook.studies.maps.edge", "sosbook.lmi.block"}
    assert set(sheets.used(program)) >= names_there
    assert not any("design_pid" in name for name in sheets.used(program))
    assert sheets.used("not python at all(") == []


def test_the_inventory_has_the_manual(site):
    with (site / "objects.inv").open("rb") as file:
        inventory = InventoryFile.load(file, "", lambda base, uri: uri)
    kinds = {k: set(v) for k, v in inventory.items() if k.startswith("py:")}
    every = set().union(*kinds.values())
    assert {e.name for e in names.entries().values()} <= every
    assert "sosbook.Design.certify" in kinds["py:method"]
    project, *_ = inventory["py:class"]["sosbook.Design"]
    assert project == "sosbook"


def test_code_in_a_chapter_leads_to_the_manual_and_back(site):
    chapter = (site / "book" / "05_h_infinity_norm.html").read_text("utf-8")
    links = re.findall(r'class="sos-code" href="([^"#]+)#([\w.]+)"', chapter)
    assert ("api/theorems.html", "sosbook.theorems.bounded_real") in links
    assert "In the package:" in chapter
    for page, anchor in set(links):
        manual = (site / "book" / page).read_text("utf-8")
        assert f'id="{anchor}"' in manual
    entry = (site / "book" / "api" / "theorems.html").read_text("utf-8")
    start = entry.index('id="sosbook.theorems.bounded_real"')
    assert "05_h_infinity_norm.html" in entry[start : start + 6000]


def test_the_manual_names_no_folder_of_the_machine(site):
    for path in (site / "book" / "api").glob("*.html"):
        assert str(ROOT) not in path.read_text("utf-8")


def test_a_request_lives_as_its_page_says():
    """Each function of the table is called, the first of a step in their order."""
    page = (ROOT / "book" / "api" / "life_of_a_request.md").read_text("utf-8")
    rows = [line for line in page.splitlines() if re.match(r"\| \d+ \|", line)]
    steps = [re.findall(r"`(\S+\.py)` `(\S+)`", row) for row in rows]
    first, here = {}, Path(sosbook.__file__).parent

    def seen(frame, event, _):
        code = frame.f_code
        file = Path(code.co_filename)
        if event == "call" and here in file.parents:
            name = file.relative_to(here).as_posix(), code.co_qualname
            first.setdefault(name, len(first))

    masses = [sosbook.SecondOrderSystem([[m]], [[1]], [[1]], [[1]]) for m in (1, 2)]
    sys.setprofile(seen)
    try:
        design = sosbook.design_pid(
            sosbook.Polytope(masses),
            region=sosbook.PoleRegion(1),
            saturation=sosbook.Saturation(9, [1, 0]),
        )
        assert design.certify().proven
    finally:
        sys.setprofile(None)
    assert not {name for step in steps for name in step} - first.keys()
    order = [first[step[0]] for step in steps]
    assert [row[:4].strip("| ") for row in rows] == [f"{k}" for k in range(1, 11)]
    assert order == sorted(order)
    for name in re.findall(r"`((?:sosbook|tests|proofs|solver|exact)/\S+\.py)`", page):
        assert (ROOT / name).exists() or (here / name).exists(), name
