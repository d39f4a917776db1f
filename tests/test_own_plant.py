"""The reader's own matrices in the page, against the package and a C compiler."""

import re
import subprocess

import numpy as np
import pytest

import sosbook as sos
from tests.compiler import find, refuse

READY = """() => { const e = document.querySelector("sos-plant");
  return e?.answer && e.answer.values.length === e.values.length
    && e.answer.values.every((v, k) => v === e.values[k]); }"""


@pytest.fixture
def tab(visit, tmp_path):
    page = tmp_path / "plant.html"
    page.write_text(
        '<!doctype html><html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        f'<link rel="icon" href="data:,"><title>t</title>{sos.atlas.own_plant().html}',
        "utf8",
    )
    tab = visit(page, width=390)
    tab.page.wait_for_function(READY)
    yield tab
    assert tab.errors == []
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def design(tab):
    tab.page.get_by_role("button", name="Design for these matrices").click()
    tab.page.wait_for_function(READY)
    return tab.page.evaluate("document.querySelector('sos-plant').answer")


def program(tab, kind):
    tab.page.get_by_role("button", name=kind, exact=True).click()
    return tab.page.locator("sos-plant pre").inner_text()


def type_in(tab, **texts):
    for name, text in texts.items():
        tab.page.locator(f"[data-field={name}]").fill(text)


def test_typed_matrices_are_designed_for(tab):
    type_in(
        tab,
        M="[[2, 0],\n [0, 1]]",
        D="1.2 -0.4; -0.4, 0.4",
        S="30 -20\n-20 20",
        B="1\n0",
        F="0\n1",
        U="0 1",
        x0="0.2 0.2 0 0 0",
        Q="1 1 0.5 0.5 2",
        R="0.3",
    )
    tab.page.get_by_label("bound what w does").check()
    tab.page.wait_for_function(READY)
    tab.page.get_by_label("bound the input").check()
    tab.page.wait_for_function(READY)
    tab.page.get_by_label("bound the cost").check()
    tab.page.wait_for_function(READY)
    answer, names = design(tab), {}
    assert answer["status"] == "feasible"
    exec(program(tab, "As Python"), names)
    plant, K = names["plant"], names["design"].K
    assert plant.S.tolist() == [[30, -20], [-20, 20]]
    assert names["design"].request.saturation.x0.tolist() == [0.2, 0.2, 0, 0, 0]
    cost = names["design"].request.cost
    assert cost.Q.diagonal().tolist() == [1, 1, 0.5, 0.5, 2] and cost.noise == "F"
    assert answer["cost"] == pytest.approx(names["design"].noise_cost(), rel=1e-6)
    assert np.abs(np.array(answer["K"]) - K).max() < 1e-6 * np.abs(K).max()


@pytest.mark.parametrize(
    "texts, words",
    [
        ({"Q": "1 1"}, "Q needs 6 numbers"),
        ({"R": "1 0; 0 -1"}, "R must be positive definite"),
        ({"R": "1 0.5; 0 1"}, "R must be symmetric"),
        ({"Q": "1 1 1 -1 1 1"}, "Q must have no negative eigenvalue"),
    ],
)
def test_weights_that_do_not_fit_are_named(tab, texts, words):
    type_in(tab, **texts)
    assert design(tab)["status"] == "feasible"  # nobody asks for them
    tab.page.get_by_label("bound the cost").check()
    assert words in tab.page.locator("[role=alert]").inner_text()


@pytest.mark.parametrize("example", range(4))
def test_every_example_has_a_design(tab, example):
    tab.page.locator("sos-plant select").select_option(str(example))
    answer = design(tab)
    assert answer["status"] == "feasible"
    assert all(re < 0 for poles in answer["poles"] for re, _ in poles)


@pytest.mark.parametrize(
    "texts, words",
    [
        ({"M": "1 2\n3"}, "M: row 2 has 1 numbers"),
        ({"M": "1 x\n3 4"}, "no number"),
        ({"M": "1 0\n0 0"}, "M is singular"),
        ({"D": "1"}, "D must have 2 rows"),
        ({"U": "1 0 0"}, "U must have 2 columns"),
        ({"x0": "1 2"}, "x(0) needs 6 numbers"),
        ({"M": ""}, "M must have 1 to 4 rows"),
    ],
)
def test_what_does_not_fit_is_named(tab, texts, words):
    type_in(tab, **texts)
    tab.page.get_by_role("button", name="Design for these matrices").click()
    assert words in tab.page.locator("[role=alert]").inner_text()


def test_the_c_program_is_the_control_law(tab, tmp_path):
    if (command := find()) is None:
        refuse()
    tab.page.locator("sos-plant select").select_option("1")
    K = np.array(design(tab)["K"])
    code = program(tab, "As C")
    assert re.search(r"#define INTEGRATORS 1\b", code)
    source = tmp_path / "law.c"
    source.write_text(
        "#include <stdio.h>\n"
        + code
        + """
int main(void)
{
    const double z[] = {0.3, -0.2}, v[] = {0.5, 0.1}, r[] = {0.1, 0.4};
    double u[1];
    for (int k = 0; k < 3; k++) {
        control(z, v, r, 0.01, u);
        printf("%.12g\\n", u[0]);
    }
    return 0;
}
""",
        "utf8",
    )
    built = tmp_path / "law"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-o", str(built), str(source)]
    words = [command] if isinstance(command, str) else [*command]
    subprocess.run([*words, *flags], check=True, timeout=60)
    said = subprocess.run(
        [str(built)], capture_output=True, text=True, check=True, encoding="utf-8"
    )
    x3, true = 0.0, []
    for _ in range(3):
        true += list(K @ [0.2, -0.6, 0.5, 0.1, x3])
        x3 += 0.01 * -0.6
    assert np.allclose([float(x) for x in said.stdout.split()], true, rtol=1e-7)
