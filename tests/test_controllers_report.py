"""The page that an engineer hands on."""

import re
from html.parser import HTMLParser

import pytest

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
    # two corners: motor, load and torque of a step and of a load, with dashes
    charts = re.findall(r"<svg role=.img. aria-label=.([^\"]*)", page)
    assert sum("over time" in label for label in charts) == 6
    assert page.count("<polyline") == 12
    assert f"{c.gain.K[0, 0]:.6g}" in page and "arm_step(" in page
    proof = (tmp_path / "arm" / "proof_arm_sampled.json").read_bytes()
    assert digest(proof) in page
    with pytest.raises(FileExistsError):
        design().report(tmp_path, controller=axis().limit(1.5), name="arm")
