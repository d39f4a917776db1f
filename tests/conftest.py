"""Fixtures of the browser tests.

``site``     the built pages: ``SOSBOOK_SITE=_build/html``, awaited until the file
             ``SOSBOOK_BUILT`` holds a 0; without them the book is built once.
``browser``  a headless Chromium (playwright), one for each process; it comes last,
             for its event loop would disturb notebooks and clusters.
``kernel``   a page of it with the solver of the rendered book.
``tab``      the page ``sheet`` of a module; it leaves no error behind.
``visit``    opens a Path or an address without a network: ``visit(page, width=390,
             height=844, scheme="dark")`` has the attributes of `Tab`. Pixels and
             shifts of the layout are there if it is ``painted``.
"""

import importlib.util
import json
import os
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import pytest

import tests.once
from tasks import JUPYTER_BOOK
from tests import browser as chromium
from tests import compiler, layout
from tests.processes import process

collect_ignore = ["rehearsal", "typed.py"]  # programs of other tests
ROOT = Path(__file__).resolve().parent.parent
#: Tests of what the book says and shows, and of the tools that compare it.
BOOK = (
    "test_notebooks",
    "test_prose",
    "test_solutions",
    "test_values",
    "test_rehearsal",
)
#: A test that asks for one of these fixtures is of this kind.
KINDS = {
    "browser": {"site", "browser", "visit"},
    "compiler": {"gcc", "a_compiler"},
    "slow": {"rows", "cluster"},
}
LONG = (  # a minute or more each, of tests that may be few: none comes last
    *("test_site", "test_live", "test_hunt", "test_structured_search"),
    *("test_any_order", "test_at_once", "test_bad_numbers", "test_rows_of_the_plant"),
    *("36_any_controller", "34_sensors", "37_outputs", "32_true_proven_impossible"),
)
CELL, PAGE = 700, 1000  # seconds: nbval's 600 for a cell; a build may be awaited
WEEKLY = 1800  # of a test that waits for the campaign: some draw sixty logs


def pytest_addoption(parser):
    parser.addoption(
        "--campaign", action="store_true", help="run the long campaigns, too"
    )


def pytest_configure(config):
    if config.getoption("--campaign", False):
        from tests.cases import CAMPAIGN

        os.environ[CAMPAIGN] = "1"


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session):
    """Of several processes the first collects alone, beside the build of the book: to
    compile all tests takes as long as to collect them, and the others read it then.
    """
    mark = collected(session.config)
    if mark and not mark.name.startswith("gw0"):
        first, end = mark.with_name(f"gw0{mark.suffix}"), time.monotonic() + 120
        while not first.exists() and time.monotonic() < end:
            time.sleep(0.1)


def pytest_collection_finish(session):
    if mark := collected(session.config):
        mark.touch()


@pytest.hookimpl(wrapper=True)
def pytest_collect_file():
    """Docstrings of tests have no examples; to look for some takes its time."""
    return [x for x in (yield) if type(x).__name__ != "DoctestModule"]


def collected(config):
    """The file that says that this worker has collected; None where no build runs."""
    mine, outcome = getattr(config, "workerinput", {}), os.environ.get("SOSBOOK_BUILT")
    if mine and outcome:
        return Path(outcome).with_name(f"{mine['workerid']}.{mine['testrunuid']}")


def pytest_collection_modifyitems(config, items):
    """Mark kinds, set timeouts; notebooks and long files first, browsers last."""
    if not config.getoption("--campaign", False):
        long = [x for x in items if x.get_closest_marker("campaign")]
        items[:] = [x for x in items if not x.get_closest_marker("campaign")]
        config.hook.pytest_deselected(items=long)
    count = Counter(item.path for item in items)
    windows = set()
    for item in items:
        asked = set(getattr(item, "fixturenames", ()))
        if "browser" in asked:
            windows.add(item.path)
        for kind, fixtures in KINDS.items():
            if asked & fixtures:
                item.add_marker(getattr(pytest.mark, kind))
        if item.path.stem.startswith(BOOK):
            item.add_marker(pytest.mark.book)
        if item.path.suffix == ".ipynb":
            item.add_marker(pytest.mark.timeout(CELL))
        elif "site" in asked:
            item.add_marker(pytest.mark.timeout(PAGE))
        elif item.get_closest_marker("campaign"):
            item.add_marker(pytest.mark.timeout(WEEKLY))
    items.sort(
        key=lambda item: (
            item.path in windows,
            item.path.suffix != ".ipynb",
            item.path.stem not in LONG,
            -count[item.path],
        )
    )


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder of the built book."""
    if folder := os.environ.get("SOSBOOK_SITE"):
        if outcome := os.environ.get("SOSBOOK_BUILT"):
            wait_for(Path(outcome))
        path = (ROOT / folder).resolve()
        assert (path / "book").is_dir(), f"no built book in {path}"
        return path
    folder = tmp_path_factory.mktemp("site")
    done = process(
        sys.executable,
        *JUPYTER_BOOK,
        "build",
        ROOT,
        "-W",
        "-n",
        "--keep-going",
        "--path-output",
        folder,
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
    return folder / "_build" / "html"


@pytest.fixture(scope="session")
def gcc():
    """A C compiler's command; skipped without one, failed in CI."""
    command = compiler.find()
    if command is None:
        compiler.refuse()
    return command


@pytest.fixture(scope="session", autouse=True)
def one_folder(tmp_path_factory):
    """Where the workers of a run find what one of them has made."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    tests.once.FOLDER = folder
    yield
    tests.once.FOLDER = None


def of_the_reproduction(name, kind):
    """Rows or errata: as they are stored, which their page computes in the gate
    (``test_claims`` compares them); the campaign computes them here, too.
    """
    from sosbook.book import reproduction
    from tests.cases import CAMPAIGN

    if os.environ.get(CAMPAIGN):
        return tests.once.once(name, getattr(reproduction, name))
    stored = json.loads((ROOT / "book" / "reproduction.json").read_text("utf-8"))
    return tuple(getattr(reproduction, kind)(**entry) for entry in stored[name])


@pytest.fixture(scope="session")
def rows():
    """The rows of the reproduction."""
    return of_the_reproduction("rows", "Row")


@pytest.fixture(scope="session")
def errata():
    """The corrections of the thesis."""
    return of_the_reproduction("errata", "Erratum")


def wait_for(outcome, seconds=600):
    """Return when a build has succeeded; fail if it did not or takes too long."""
    end = time.monotonic() + seconds
    while not outcome.exists():
        assert time.monotonic() < end, "the book was not built in time"
        time.sleep(0.5)
    status = outcome.read_text("utf-8")
    assert status == "0", "the book does not build; see _build/book.log"


@pytest.fixture(scope="session")
def browser():
    """A headless Chromium; skipped where there is none, failed in CI."""
    playwright = pytest.importorskip("playwright.sync_api")
    path = chromium.find()
    if path is None:
        refuse = pytest.fail if os.environ.get("CI") else pytest.skip
        refuse(chromium.MISSING)
    with playwright.sync_playwright() as engine:
        window = engine.chromium.launch(**chromium.options(path))
        yield window
        window.close()


@pytest.fixture(scope="module")
def kernel(browser):
    """An empty page with the solver of the rendered book in it."""
    from sosbook.book.elements.scripts import script

    page = browser.new_page()
    page.add_script_tag(content=script("kernel"))
    yield page
    page.close()


@dataclass
class Tab:
    """An open page and what happened on it."""

    page: object
    errors: list = field(default_factory=list)
    requests: list = field(default_factory=list)
    leaving: bool = False

    def __post_init__(self):
        self.page.on("request", lambda r: self.heard(r.url))
        self.page.on("requestfailed", lambda r: self.failed(r.url))
        self.page.on("pageerror", lambda e: self.errors.append(str(e)))
        self.page.on(
            "console", lambda m: m.type == "error" and self.errors.append(m.text)
        )
        self.page.on("framenavigated", self.arrived)

    def heard(self, url):
        """What is asked for, but what the page holds itself: its workers' texts."""
        if not url.startswith("blob:"):
            self.requests.append(url)

    def failed(self, url):
        """What was asked for in vain. A worker that is stopped, as where a page ends,
        before its text is read isn't: a text that isn't there any more is an exception.
        """
        if not url.startswith("blob:"):
            self.errors.append(f"failed: {url}")

    def arrived(self, frame):
        """The page of another test has gone, and what it said with it."""
        if self.leaving:
            self.leaving, self.errors, self.requests = False, [], [frame.url]

    def opened(self, address, width, height, scheme):
        """A page in the place of another test's, which nothing is left of but code that
        the browser has compiled. A tab that is emptied in between takes .05 s longer.
        """
        if self.page.viewport_size != {"width": width, "height": height}:
            self.page.set_viewport_size({"width": width, "height": height})
        self.page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        if self.page.url.split("#")[0] == address.split("#")[0]:
            self.page.goto("about:blank")  # else it would be the same page
        self.leaving = True
        self.page.goto(address, wait_until="load")
        return self.typeset()

    def typeset(self):
        """Wait until the page and the fonts of its formulas are there."""
        self.page.wait_for_load_state()
        self.page.evaluate("() => document.fonts.ready.then(() => null)")
        return self

    def left(self):
        """The tab without what a page keeps, and without windows that it opened."""
        self.page.evaluate("() => { localStorage.clear(); sessionStorage.clear() }")
        for other in self.page.context.pages:
            if other is not self.page:
                other.close()
        return self


@pytest.fixture(scope="module")
def sheets(browser):
    """Tabs that a test has left: those that aren't painted, those that are."""
    left = {False: [], True: []}
    yield left
    for tab in sum(left.values(), []):
        tab.page.context.close()


@pytest.fixture
def visit(browser, sheets):
    """Open pages without a network; see the top of this file."""
    open_tabs = []

    def visit(address, width=1280, height=900, scheme="light", painted=False):
        if isinstance(address, Path):
            address = address.resolve().as_uri()
        left = sheets[painted]
        tab = left.pop() if left else Tab(new_sheet(browser, painted))
        open_tabs.append((painted, tab))
        return tab.opened(address, width, height, scheme)

    yield visit
    for painted, tab in open_tabs:
        sheets[painted].append(tab.left())


def new_sheet(browser, painted):
    """An empty tab of its own storage; what it opens has the widest usual type."""
    context = browser.new_context(reduced_motion="reduce")
    context.add_init_script(layout.WIDE_TYPE)
    if not painted:
        context.add_init_script(layout.UNPAINTED)
    return context.new_page()


#: Stricter than axe, which accepts a link in a text for its colour alone, too; to
#: measure the colours around every link takes half of its time. A sixth of the rest
#: goes into texts of all nodes that it has looked at.
UNDERLINED = """;
axe.configure({
  noHtml: true,
  rules: [{id: "link-in-text-block", any: ["link-in-text-block-style"]}]});
"""


@pytest.fixture
def tab(visit, sheet):
    from tests.elements import assert_quiet

    tab = visit(sheet)
    yield tab
    assert_quiet(tab)


@pytest.fixture(scope="module")
def robot():
    """The printed Example 1."""
    from sosbook.book import thesis

    return thesis.example_1()


@pytest.fixture
def without_bounds(monkeypatch):
    """Reports lack the table of bounds, which takes most of their time."""
    from sosbook.synthesis.bounds import Bounds
    from sosbook.synthesis.design import Design

    monkeypatch.setattr(Design, "bounds", lambda self: Bounds([]))


@pytest.fixture
def ax():
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots()
    yield ax
    plt.close(figure)


@pytest.fixture(scope="session")
def axe(tmp_path_factory):
    """Address of the script of axe-core, which knows the rules of accessible pages."""
    found = importlib.util.find_spec("axe_playwright_python")
    if found is None:
        refuse = pytest.fail if os.environ.get("CI") else pytest.skip
        refuse("axe-core is missing: pip install axe-playwright-python")
    text = (Path(found.origin).parent / "axe.min.js").read_text("utf-8")
    script = tmp_path_factory.mktemp("axe") / "axe.js"
    script.write_text(text + UNDERLINED, "utf-8")
    return script.as_uri()
