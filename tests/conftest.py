"""Fixtures of the browser tests.

``site``     Path of the built pages. ``SOSBOOK_SITE=_build/html`` reuses a
             build; without it the book is built once in a scratch folder.
``browser``  a headless Chromium (playwright), one for each test module.
``visit``    opens a page with the network cut and everything recorded::

    def test_slider(site, visit):
        tab = visit(site / "book" / "04_lmi_regions.html", width=390)
        tab.page.locator("input[type=range]").first.fill("3")
        assert tab.errors == []

``visit`` takes a Path or an address, ``width`` and ``height`` in pixels, and
``scheme`` "light" or "dark". ``tab.page`` is playwright's page, ``tab.errors``
its console errors, warnings of scripts and failed requests, ``tab.requests``
every address it asked for.

The browser lives as long as its module and no longer: playwright's event loop
would disturb the notebooks which the same process runs next.
"""

import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests import browser as chromium

collect_ignore = ["rehearsal"]  # its sitecustomize.py is no test
ROOT = Path(__file__).resolve().parent.parent
BUILD = ["jupyter-book", "build", str(ROOT), "-W", "-n", "--keep-going"]


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder of the built book."""
    if folder := os.environ.get("SOSBOOK_SITE"):
        path = (ROOT / folder).resolve()
        assert (path / "book").is_dir(), f"no built book in {path}"
        return path
    folder = tmp_path_factory.mktemp("site")
    tool = str(Path(sys.executable).with_name(BUILD[0]))
    command = [tool, *BUILD[1:], "--path-output", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
    return folder / "_build" / "html"


@pytest.fixture(scope="module")
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


@dataclass
class Tab:
    """An open page and what happened on it."""

    page: object
    errors: list = field(default_factory=list)
    requests: list = field(default_factory=list)

    def typeset(self):
        """Wait until the page is loaded and MathJax has nothing left to do."""
        self.page.wait_for_load_state()
        self.page.evaluate("() => window.MathJax?.startup?.promise")
        return self


@pytest.fixture
def visit(browser):
    """Open pages without a network; see the top of this file."""
    contexts = []

    def visit(address, width=1280, height=900, scheme="light"):
        if isinstance(address, Path):
            address = address.resolve().as_uri()
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme=scheme,
            reduced_motion="reduce",
        )
        contexts.append(context)
        if address.startswith("file:"):
            context.route(re.compile("^(https?|wss?):"), lambda r: r.abort())
        page = context.new_page()
        tab = Tab(page)
        page.on("request", lambda r: tab.requests.append(r.url))
        page.on("requestfailed", lambda r: tab.errors.append(f"failed: {r.url}"))
        page.on("pageerror", lambda e: tab.errors.append(str(e)))
        page.on(
            "console",
            lambda m: m.type == "error" and tab.errors.append(m.text),
        )
        page.goto(address, wait_until="load")
        return tab.typeset()

    yield visit
    for context in contexts:
        context.close()
