"""Tables and data of the book's own outputs: which changes count."""

import json
import random
import re

import pytest

from tests.each import each
from tests.test_values import PAGES, moved
from tests.values import pages

DATA = [(name, page) for name, page in PAGES if "application/json" in page]


def test_a_changed_cell_of_a_table_is_found_in_its_place():
    page = "<table><tr><td>0.75</td><td>1.5</td></tr></table>"
    assert pages.differences(page, page.replace("1.5", "1.8")) == [
        "table > tr > td 2: line 1, number 1: stored 1.5, now 1.8 (tolerance 0.1)"
    ]


def test_names_and_addresses_are_compared_to_the_letter():
    for attribute in ('href="#sec-1.2"', 'src="data:image/png;base64,1.2"'):
        page = f"<p><a {attribute}>1.2</a></p>"
        assert pages.differences(page, page.replace("1.2<", "1.3<")) == []
        assert pages.differences(page, page.replace('1.2"', '1.3"'))
    bar = "<i style='width:1.2em'></i>"
    assert pages.differences(bar, bar.replace("1.2", "1.3")) == []
    assert pages.differences(bar, bar.replace("1.2", "1.4"))


def data_of(page):
    return re.search(r'application/json">(.*?)</script>', page, re.S)[1]


FLOAT = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")


def outside_strings(text, change):
    """JSON text with `change` made to it wherever it is not in a string."""
    parts = re.split(r'("(?:[^"\\]|\\.)*")', text)
    return "".join(part if part[:1] == '"' else change(part) for part in parts)


@each("name, page", DATA)
def test_data_of_live_pages(name, page):
    text = data_of(page)
    choose = random.Random(1)

    def shifted(part):
        return FLOAT.sub(lambda n: moved(n[0], choose.choice((-1, 1))), part)

    near = page.replace(text, outside_strings(text, shifted))
    assert near != page
    assert pages.differences(page, near) == []

    numbers = []
    outside_strings(text, lambda part: numbers.extend(FLOAT.findall(part)) or part)
    number = choose.choice(numbers)
    once = iter((moved(number, 2),))

    def changed_once(part):
        """The first such number outside of strings, moved."""
        here = rf"(?<![\d.-]){re.escape(number)}(?![\d.e])"
        return re.sub(here, lambda match: next(once, match[0]), part)

    far = page.replace(text, outside_strings(text, changed_once))
    assert any(number in fault for fault in pages.differences(page, far)), number

    first = re.search(r'"(\w+)":', text)[1]
    renamed = page.replace(text, text.replace(f'"{first}":', '"other":', 1))
    assert any("keys" in fault for fault in pages.differences(page, renamed))


@pytest.mark.parametrize(
    "old, new",
    [
        ({"a": [1.5, 2.0]}, {"a": [1.5]}),
        ({"a": [1, 0]}, {"a": [0, 1]}),
        ({"a": None}, {"a": 0}),
        ({"a": "feasible"}, {"a": "infeasible"}),
        ({"a": True}, {"a": False}),
        ({"a": 1.25}, {"a": 1.27}),
        ({"a": 12}, {"a": "12"}),
        ({"a": float("nan")}, {"a": 0.0}),
        (
            {"a": "data:image/png;base64,iVB1.25"},
            {"a": "data:image/png;base64,iVB1.26"},
        ),
    ],
)
def test_changed_data_is_found(old, new):
    text = '<script type="application/json">{}</script>'
    assert pages.differences(*(text.format(json.dumps(v)) for v in (old, new)))
