"""The sliders in a running JupyterLab, in a real browser."""

import json
import os
import socket
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import jupyterlab_widgets
import nbformat
import numpy as np
import pytest
from nbformat.sign import NotebookNotary

import sosbook as sos
from sosbook.book import thesis
from sosbook.book.elements.page import whole
from sosbook.book.notebooks import BOOK
from tests.cases import by_turns
from tests.elements import middle, step, still
from tests.test_page_elements import FIRST, TAGS

pytestmark = pytest.mark.live
TOKEN = "sosbook"
PROGRAM = """\
import numpy as np
import sosbook as sos
from sosbook.book import thesis, widgets
robot = thesis.example_1()
def redesign(sigma, theta, rho):
    region = sos.PoleRegion(sigma, theta, rho)
    return sos.design_pid(robot.plant, robot.U, region=region)
widgets.sliders(
    redesign, sigma=(0, 0.7, 3), rho=(1, 5, 10), theta=np.radians([5, 45, 90]))"""
EXPLORER = """\
import numpy as np
import sosbook as sos
from sosbook.book import elements, thesis, widgets
robot = thesis.example_1()
explorer = elements.design_explorer(
    robot.plant, robot.U, gamma=1.257, saturation=robot.saturation,
    region=sos.PoleRegion(0.7, np.pi / 4, 5))
explorer"""
SHELF = """\
from pathlib import Path
from IPython.display import HTML, display
for path in sorted(Path("shelf").glob("*.html")):
    display(HTML(path.read_text("utf8")))"""
CHAPTER = "04_lmi_regions.ipynb"
FIFTH = 5  # of the kinds the gate tries each fifth
#: Markup that a reader of a chapter never sees.
MARKS = ":::", "{eq}", "{prf", "{numref}", "]("
PICTURE = ".jp-OutputArea-output .sos-result"


@pytest.fixture(scope="module")
def lab(tmp_path_factory, pytestconfig):
    """Address of a notebook in JupyterLab."""
    folder = tmp_path_factory.mktemp("lab")
    kernel = {"name": "python3", "display_name": "Python", "language": "python"}
    cells = PROGRAM, EXPLORER, "widgets.live(explorer)", SHELF
    notebooks = {"live": cells, "stranger": ["1"]}
    for name, cells in notebooks.items():
        made = [nbformat.v4.new_code_cell(c) for c in cells]
        if name == "stranger":
            shown = {"text/html": whole(FIRST["sos-delay"])}
            made[0].outputs = [
                nbformat.v4.new_output("execute_result", shown, execution_count=1)
            ]
        nbformat.write(
            nbformat.v4.new_notebook(cells=made, metadata={"kernelspec": kernel}),
            folder / f"{name}.ipynb",
        )
    (folder / "shelf").mkdir()
    for tag in TAGS if pytestconfig.getoption("--campaign") else TAGS[::FIFTH]:
        (folder / "shelf" / f"{tag}.html").write_text(whole(FIRST[tag]), "utf8")
    if (chapter := BOOK / CHAPTER).exists():
        notebook = nbformat.read(chapter, as_version=4)
        notebook.cells = beginning(notebook.cells)
        nbformat.write(notebook, folder / CHAPTER)
        (folder / "data").mkdir()
        NotebookNotary(data_dir=str(folder / "data")).sign(notebook)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    root = Path(__file__).resolve().parent.parent
    environment = dict(
        os.environ,
        PYTHONPATH=str(root),
        JUPYTER_PATH=_widgets_home(),
        JUPYTER_CONFIG_DIR=str(folder / "config"),
        JUPYTER_DATA_DIR=str(folder / "data"),
    )
    server = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "jupyterlab",
            "--no-browser",
            "--allow-root",
            "--ip=127.0.0.1",
            f"--port={port}",
            f"--IdentityProvider.token={TOKEN}",
            f"--notebook-dir={folder}",
        ],
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        _wait(f"http://127.0.0.1:{port}/api/status?token={TOKEN}", server)
        yield f"http://127.0.0.1:{port}/lab/tree/live.ipynb?token={TOKEN}"
    finally:
        server.terminate()
        try:
            server.wait(timeout=20)  # for its kernels to end
        except subprocess.TimeoutExpired:
            server.kill()


def beginning(cells):
    """A chapter's cells up to where a figure and each kind of markup was seen."""
    firsts = (
        next((k for k, cell in enumerate(cells) if kind in str(cell)), 0)
        for kind in (*MARKS, "sos-figure")
    )
    return cells[: max(firsts) + 1]


def _widgets_home():
    """The folder that has the widgets' part of Lab, wherever they are installed."""
    parents = Path(jupyterlab_widgets.__file__).parents
    homes = [p / "share" / "jupyter" for p in parents]
    manager = Path("labextensions", "@jupyter-widgets", "jupyterlab-manager")
    found = [str(home) for home in homes if (home / manager).is_dir()]
    assert found, f"jupyterlab_widgets has no extension of Lab above {parents[0]}"
    return found[0]


def _wait(address, server):
    for _ in range(240):
        assert server.poll() is None, "JupyterLab ended"
        try:
            with urllib.request.urlopen(address, timeout=5) as answer:
                json.load(answer)
                return
        except OSError:
            time.sleep(0.25)
    pytest.fail("JupyterLab didn't answer within a minute")


@pytest.fixture(scope="module")
def page(lab, browser):
    """The notebook, of which all cells have begun: sliders, a page's explorer, the same
    once more with the package behind it, and elements of the book.
    """
    context = browser.new_context(viewport={"width": 1400, "height": 1000})
    page, errors = context.new_page(), []
    page.on("pageerror", lambda e: errors.append(str(e)))
    page.set_default_timeout(60_000)
    page.goto(lab)
    page.locator(".jp-CodeCell").first.wait_for()
    page.get_by_text("Python 3 (ipykernel) | Idle").wait_for()
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()
    yield page
    assert errors == []
    context.close()


def _beside(page, name):
    """Another notebook of the folder, opened where the first one is."""
    page.locator(".jp-DirListing-item", has_text=name).dblclick()
    return page.locator(".jp-NotebookPanel:not(.lm-mod-hidden)")


def _handle(page, label):
    row = page.locator(".widget-slider", has_text=label)
    return row.locator(".noUi-handle")


def _shows(page, *region):
    """Wait until the picture holds every gain of the package's design."""
    robot = thesis.example_1()
    design = sos.design_pid(robot.plant, robot.U, region=sos.PoleRegion(*region))
    page.wait_for_function(
        """([where, gains]) => { const cells = [...document.querySelectorAll(
          where + " .sos-matrix td")].map(cell => cell.textContent);
          return gains.every(gain => cells.includes(gain)); }""",
        arg=[PICTURE, [f"{k + 0.0:.4g}" for k in design.K.ravel()]],
    )


def test_keys_and_the_mouse_move_a_design_and_what_is_impossible_is_said(page):
    _shows(page, 0.7, np.pi / 4, 5)
    sigma, rho = _handle(page, "Decay rate σ (1/s)"), _handle(page, "Disk radius ρ")
    rho.press("End")
    _shows(page, 0.7, np.pi / 4, 10)
    x, y = middle(sigma)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 900, y, steps=4)
    page.mouse.up()
    _shows(page, 0, np.pi / 4, 10)
    rho.press("Home")
    sigma.press("End")
    page.get_by_text(
        "the region is empty: rho = 1.0 must exceed sigma = 3.0"
    ).wait_for()


#: The two explorers come before the shelf.
BOTH = "[...document.querySelectorAll('sos-wish')].slice(0, 2)"
SAID = """k => {
  const {answer, digest} = document.querySelectorAll("sos-wish")[k] ?? {};
  return answer?.digest === digest && answer; }"""
BOUNDS = "sigma", "theta", "rho", "gamma"


def _ask(page, values):
    """What page and package say where the sliders of both stand."""
    page.wait_for_function(f"{BOTH}.filter(e => e.answer).length === 2")
    page.evaluate(
        f"values => {BOTH}.forEach(e => e.set(values))", dict(zip(BOUNDS, values))
    )
    return [page.wait_for_function(SAID, arg=k).json_value() for k in (0, 1)]


@pytest.mark.parametrize(
    "values, status",
    [
        ([0.7, 45, 5, 1.257], "feasible"),
        ([0.3, 60, 8, 2], "feasible"),
        ([2.3, 45, 5, 1.257], "infeasible"),
    ],
)
def test_the_same_explorer_by_page_and_package(page, values, status):
    here, there = _ask(page, values)
    assert "by" not in here and there["by"] == "the package"
    assert here["status"] == there["status"] == status
    texts = page.locator("sos-wish .sos-readout").all_inner_texts()[:2]
    if status == "feasible":
        apart = np.abs(np.subtract(here["K"], there["K"])).max()
        assert apart < 1e-6 * np.abs(here["K"]).max()
        assert "Solved in your browser" in texts[0]
        assert "Solved by the package" in texts[1]
        told = [text.split("Solved")[0].partition("\n")[2] for text in texts]
        assert told[0] == told[1] and "In truth" in told[0]  # a proof comes when it can
    else:
        assert here["reason"] == there["reason"] != ""


def test_page_and_package_look_alike(page):
    """All but the names of their parts, the times, and where they stand."""
    _ask(page, [0.7, 45, 5, 1.257])
    shown = page.evaluate(
        BOTH
        + """.map(e => {
      const {width, height} = e.getBoundingClientRect(), style = getComputedStyle(e);
      const parts = [...e.querySelectorAll("label, figcaption, button, svg text")];
      const drawn = [...e.querySelectorAll("svg *")].map(
        x => x.localName + "." + (x.getAttribute("class") ?? ""));
      return [Math.round(width), style.color, style.backgroundColor, style.font,
        parts.map(p => p.textContent), drawn]; })"""
    )
    here, there = shown
    assert here[0] == pytest.approx(there[0], abs=20)  # Lab's own margins
    assert here[1:] == there[1:]
    assert len(here[4]) > 20 and len(here[5]) > 40


def test_the_package_s_explorer_moves_by_key_and_proves(page):
    element = page.locator("sos-wish").nth(1)
    _ask(page, [0.7, 45, 5, 1.257])
    before = element.locator(".sos-readout").inner_text()
    element.get_by_role("spinbutton", name="decay rate σ").press("ArrowUp")
    page.wait_for_function(
        "old => document.querySelectorAll('sos-wish .sos-readout')[1]"
        ".innerText !== old",
        arg=before,
    )
    assert "Solved by the package" in element.locator(".sos-readout").inner_text()
    element.get_by_role("button", name="Prove it exactly").click()
    element.get_by_text("Proven", exact=True).wait_for()


@pytest.mark.parametrize("tag", by_turns(TAGS, 0, of=FIFTH))
def test_every_kind_of_element_works_in_the_notebook(page, tag):
    element = page.locator(tag).first
    element.wait_for()
    element.scroll_into_view_if_needed()
    page.wait_for_function(
        "tag => document.querySelector(tag + ' .sos-say em')?.innerText.trim()", arg=tag
    )
    before = element.get_attribute("aria-label")
    number = element.locator(".sos-num").first
    number.scroll_into_view_if_needed()
    step(number)
    page.wait_for_function(
        "([tag, old]) => document.querySelector(tag).ariaLabel !== old",
        arg=[tag, before],
    )


def test_an_untrusted_notebook_says_how_to_get_the_sliders(page):
    stranger = _beside(page, "stranger.ipynb")
    stranger.locator(".jp-OutputArea-output").get_by_text("run its cell").wait_for()
    assert stranger.locator(".jp-OutputArea-output input").count() == 0


RENDERED = """marks => {
  const cells = [...document.querySelectorAll(".jp-MarkdownCell")];
  const text = cells.map(cell => cell.innerText).join("");
  return text.includes("Before:") && !marks.some(mark => text.includes(mark)); }"""


@pytest.mark.skipif(not BOOK.exists(), reason="the package without its book")
def test_a_trusted_chapter_shows_its_figures_and_no_raw_markup(page):
    figure = _beside(page, CHAPTER).locator("figure.sos-figure svg").first
    figure.wait_for()
    assert still(figure)["width"] > 300
    page.wait_for_function(RENDERED, arg=[*MARKS])
