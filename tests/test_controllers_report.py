"""The page that an engineer hands on."""

import re
from html.parser import HTMLParser
from shutil import which

import pytest
from pypdf import PdfReader

from sosbook.controllers.report import CHROMIUMS
from sosbook.runtime.digests import digest
from tests.axis import axis, design

pytestmark = pytest.mark.slow
VOID = {"meta"}


class Nested(HTMLParser):
    """Raises where an element isn't closed by its own tag."""

    def __init__(self):
        super().__init__()
        self.open = []

    def handle_starttag(self, tag, attrs):
        self.open += [tag] * (tag not in VOID)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_stands_alone_and_says_what_is_known(tmp_path):
    c = axis().set_point(ramp=6).limit(2.0)
    path = design().report(tmp_path, controller=c, name="arm")
    page = path.read_text("utf-8")
    parser = Nested()
    parser.feed(page)
    assert parser.open == []
    assert not re.search(r"(src|href)=", page) and "<script" not in page
    for title in ("What was asked", "The plant", "The gain", "proven and true"):
        assert title in page
    assert "<li>its poles lie in the half-plane Re s &lt; -5</li>" in page
    # two corners: motor, load and torque of a step and of a load, with dashes
    charts = re.findall(r"<svg role=.img. aria-label=.([^\"]*)", page)
    assert sum("over time" in label for label in charts) == 6
    assert page.count("<polyline") == 12
    assert f"{c.gain.K[0, 0]:.6g}" in page and "arm_step(" in page
    proof = (tmp_path / "arm" / "proof_arm_sampled.json").read_bytes()
    assert digest(proof) in page
    with pytest.raises(FileExistsError):
        design().report(tmp_path, controller=axis().limit(1.5), name="arm")


def test_a_chromium_prints_the_page(tmp_path, monkeypatch):
    c = axis().limit(2.0)
    with monkeypatch.context() as m:
        m.setenv("PATH", "")
        with pytest.raises(FileNotFoundError, match="pdf=True needs a Chromium"):
            design().report(tmp_path / "none", controller=c, pdf=True)
    assert not (tmp_path / "none").exists()
    if not any(map(which, CHROMIUMS)):
        pytest.skip("there is no Chromium on the PATH")
    path = design().report(tmp_path, controller=c, pdf=True)
    pages = PdfReader(path.with_suffix(".pdf")).pages
    text = "".join(page.extract_text() for page in pages)
    assert "What was asked" in text and "axis_step(" in text
