"""The reader's own matrices in the page, against the package and a C compiler."""

import re
import subprocess
import warnings

import numpy as np
import pytest

import sosbook as sos
from sosbook.book.elements.answers import asked_of
from tests.compiler import find, refuse
from tests.elements import write_page
from tests.processes import process

READY = """() => { const e = document.querySelector("sos-plant");
  return e?.answer && e.answer.digest === e.digest; }"""
BOXES = {"x0": "u_max", "Q": "cost", "R": "cost"}  # fields that a box shows
DRIVE = {  # two inertias and a shaft between them
    "M": "0.0025 0; 0 0.004", "D": "0.02 -0.02; -0.02 0.02", "S": "9 -9; -9 9",
    "B": "1; 0", "F": "0; 1", "U": "0 1",
}  # fmt: skip
MASS = {"M": "2", "D": "1", "S": "3", "B": "1", "F": "", "U": ""}


@pytest.fixture
def sheet(tmp_path):
    return write_page(tmp_path / "plant.html", sos.atlas.own_plant().html)


@pytest.fixture
def tab(visit, sheet):
    tab = visit(sheet, width=390)
    tab.page.wait_for_function(READY)
    yield tab
    assert tab.errors == []
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def element(tab, words):
    return tab.page.evaluate(f"document.querySelector('sos-plant').{words}")


def design(tab):
    tab.page.get_by_role("button", name="Design for these matrices").click()
    tab.page.wait_for_function(READY)
    return element(tab, "answer")


def program(tab, kind):
    tab.page.get_by_role("button", name=kind, exact=True).click()
    return tab.page.locator("sos-plant pre").inner_text()


def type_in(tab, **texts):
    for name, text in texts.items():
        if box := BOXES.get(name):
            tab.page.locator(f"[data-wanted={box}]").check()
        tab.page.locator(f"[data-field={name}]").fill(text)


def locked(tab):
    """Whether what stands below the fields is hatched and out of reach."""
    inner = tab.page.locator("sos-plant .sos-inner")
    marked = inner.evaluate("e => [e.inert, e.matches('.sos-locked')]")
    assert marked[0] == marked[1]
    return marked[0]


def test_typed_matrices_are_designed_for(tab):
    type_in(
        tab,
        M="[[2, 0],\n [0, 1]]",
        D="1.2 -0.4; -0.4, 0.4",
        S="30 -20\n-20 20",
        B="1\n0",
        F="0\n1",
        U="0 1",
    )
    tab.page.get_by_label("bound what w does").check()
    tab.page.wait_for_function(READY)
    type_in(tab, x0="0.2 0.2 0 0 0", Q="1 1 0.5 0.5 2", R="0.3")
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


@pytest.mark.parametrize("example", range(4))
def test_every_example_has_a_design(tab, example):
    tab.page.locator("sos-plant select").select_option(str(example))
    answer = design(tab)
    assert answer["status"] == "feasible"
    assert all(re < 0 for poles in answer["poles"] for re, _ in poles)


#: What readers may type, over DRIVE or MASS: (fields, words of the page's own, if the
#: package never sees what was written). What is refused, warned of and designed for is
#: the package's, and so are the words.
TABLE = [
    (DRIVE, ""),
    (MASS, ""),
    (DRIVE | {"U": "1 -1"}, ""),
    (DRIVE | {"U": "1 0; 0 1"}, ""),
    (DRIVE | {"B": "1 0; 0 1", "U": "1 0; 2 0"}, ""),
    (DRIVE | {"U": "0 0"}, ""),
    (DRIVE | {"U": "1 0; 0 1; 1 1"}, ""),
    (DRIVE | {"U": "1 0 0"}, ""),
    (DRIVE | {"U": "1; 0"}, ""),
    (DRIVE | {"M": "0.0025 0; 0 -0.004"}, ""),
    (DRIVE | {"M": "0.0025 0.001; 0 0.004"}, ""),
    (DRIVE | {"M": "0.0025 0.004; 0.004 0.0025"}, ""),
    (DRIVE | {"M": "0.0025 0; 0 0"}, ""),
    (DRIVE | {"M": "0 0; 0 0"}, ""),
    (DRIVE | {"M": "1 1; 1 1", "B": "1; 1"}, ""),
    (DRIVE | {"M": "0.0025 0 0 0.004"}, ""),
    (DRIVE | {"M": "1 0; 0 1; 0 0"}, ""),
    (DRIVE | {"D": "1"}, ""),
    (DRIVE | {"D": "1 0 0 1"}, ""),
    (DRIVE | {"S": "1 0 0; 0 1 0"}, ""),
    (DRIVE | {"B": "1"}, ""),
    (DRIVE | {"B": ""}, ""),
    (DRIVE | {"F": "1 2 3"}, ""),
    (DRIVE | {"F": ""}, ""),
    (DRIVE | {"F": "", "wanted": "gamma"}, ""),
    (MASS | {"B": "0"}, ""),
    (MASS | {"B": "0", "U": "1"}, ""),
    (MASS | {"S": "0", "D": "0"}, ""),
    (MASS | {"S": "0", "D": "0", "B": "0", "U": "1"}, ""),
    (MASS | {"M": "-1"}, ""),
    (MASS | {"M": "0"}, ""),
    (MASS | {"M": "0", "B": "0"}, ""),
    (MASS | {"M": "1e300"}, ""),
    (MASS | {"D": "1e-300"}, ""),
    (MASS | {"M": "1e400"}, ""),
    (MASS | {"M": "1e99", "D": "1e-99", "S": "1e99"}, ""),
    (DRIVE | {"D": "1e8 0; 0 1e-8", "B": "1 0; 0 1", "U": ""}, ""),
    (DRIVE | {"M": "1 0; 0 1e-300"}, "choose other units"),
    (MASS | {"x0": "1 2 3", "wanted": "u_max"}, ""),
    (MASS | {"x0": "", "wanted": "u_max"}, ""),
    (MASS | {"x0": "1; 0", "wanted": "u_max"}, ""),
    (MASS | {"Q": "1", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "1 -1", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "1 2; 0 1", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "2 1; 1 2", "R": "0", "wanted": "cost"}, ""),
    (MASS | {"Q": "1 1 1; 1 1 1", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "0 1; 1 0", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "1 0; 0 -1", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "0.3333 0.6667; 0.6667 1.3336", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": f"{1 / 3} {2 / 3}; {2 / 3} {4 / 3}", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": f"0.09 {0.3 * 0.7}; 0.21 0.49", "R": "1", "wanted": "cost"}, ""),
    (MASS | {"Q": "2 1; 1 2", "R": "1 1", "wanted": "cost"}, ""),
    (MASS | {"Q": "2 1; 1 2", "R": "3", "wanted": "cost"}, ""),
    (DRIVE | {"M": "0,0025 0; 0 0,004"}, '"0,0025" may be one number or several'),
    (MASS | {"M": "1,5"}, '"1,5" may be one number or several'),
    (MASS | {"M": "0x10"}, '"0x10" is no number'),
    (MASS | {"M": "1_0"}, '"1_0" is no number'),
    (MASS | {"M": "Infinity"}, '"Infinity" is no number'),
    (MASS | {"M": "NaN"}, '"NaN" is no number'),
    (MASS | {"M": "<img onerror=alert(1)>"}, '"<img" is no number'),
    (DRIVE | {"D": "1 2; 3"}, "row 2 has 1 numbers, the first has 2"),
]
CURE = "; sosbook.plants.condense solves for"
FILL = """([texts, wanted]) => {
  const e = document.querySelector("sos-plant");
  for (const box of e.view.querySelectorAll("[data-wanted]"))
    box.checked = wanted === box.dataset.wanted;
  for (const area of e.view.querySelectorAll("textarea"))
    area.value = texts[area.dataset.field] ?? area.value;
  e.view.querySelector("textarea").dispatchEvent(new Event("input", {bubbles: true}));
  e.view.querySelector(".sos-design").click();
  return e.view.querySelector(".sos-fault").textContent; }"""


def package(texts):
    """What the package says to the same: its refusal or "", and its warnings."""

    def rows(name):
        text = texts.get(name, "").replace(",", " ")
        table = [[float(x) for x in row.split()] for row in text.split(";") if row]
        return table or None

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            plant = sos.SecondOrderSystem(*map(rows, "MDSBF"))
            asked, wanted = {}, texts.get("wanted")
            if wanted == "gamma":
                asked["gamma"] = 1.0
            if wanted == "u_max":
                asked["saturation"] = sos.Saturation(9, np.ravel(rows("x0") or []))
            if wanted == "cost":
                Q, R = (np.array(rows(name)) for name in "QR")
                Q, R = (np.diag(X[0]) if len(X) == 1 else X for X in (Q, R))
                asked["cost"] = sos.QuadraticCost(Q, R, bound=9)
            sos.design_pid(plant, rows("U"), **asked, time_limit=9)
        except ValueError as fault:
            return str(fault), []
    return "", [str(w.message) for w in said if w.category is sos.MassWarning]


def test_the_form_has_the_checks_of_the_package_and_its_words(tab):
    words = {k: v for k, v in [("Q", "1 1 1 1 1"), ("R", "1"), ("x0", "")]}
    for texts, own in TABLE:
        fault = tab.page.evaluate(FILL, [words | texts, texts.get("wanted", "")])
        assert locked(tab) == bool(fault), texts
        assert "undefined" not in fault and "null" not in fault
        if own:
            assert own in fault, texts
            continue
        refusal, warned = package(texts)
        told = refusal.split(CURE)[0]  # the page has no `condense` to send readers to
        assert (told in fault) if refusal else not fault, (texts, fault, refusal)
        if refusal:
            continue
        note = tab.page.locator(".sos-note").inner_text()
        assert note == "".join(warned), texts
        tab.page.wait_for_function(READY, timeout=60_000)
        answer = element(tab, "answer")
        asked = asked_of(element(tab, "request()"))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            status = sos.design_pid(**asked).status
        # of a mode that no input moves the page has no proof: it says "undecided"
        known = texts["B"] == "0" and status == "infeasible"
        assert answer["status"] == ("undecided" if known else status), texts


def test_until_fields_and_answer_belong_together_all_is_locked(tab):
    page = tab.page
    assert not locked(tab)
    before = page.locator("[data-field=M]").input_value()
    type_in(tab, M="3 0; 0 4")  # and nothing is pressed
    assert locked(tab) and "belongs to the matrices before" in element(
        tab, "querySelector('.sos-note').textContent"
    )
    for button in page.locator("sos-plant .sos-inner button").all():
        assert button.evaluate("e => Boolean(e.closest('[inert]'))")
        tab.page.mouse.click(*middle(button))
    assert element(tab, "querySelector('.sos-more').innerHTML") == ""
    type_in(tab, M=before)
    assert not locked(tab)
    type_in(tab, M="3 0; 0 four")  # a fault
    page.get_by_role("button", name="Design for these matrices").click()
    assert locked(tab)
    assert '"four" is no number' in page.get_by_role("alert").inner_text()
    type_in(tab, M="3 0; 0 4")
    assert locked(tab)
    answer = design(tab)
    assert not locked(tab) and answer["status"] == "feasible"
    assert page.get_by_role("alert").inner_text() == ""
    names = {}
    exec(program(tab, "As Python"), names)
    assert names["plant"].M.tolist() == [[3, 0], [0, 4]]


def middle(part):
    part.scroll_into_view_if_needed()
    box = part.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_fields_that_nobody_asks_for_do_not_block(tab):
    """Nor are they shown: x(0) of the example, and the weights of a cost."""
    for name in BOXES:
        assert not tab.page.locator(f"[data-field={name}]").is_visible()
    type_in(tab, **MASS)
    assert design(tab)["status"] == "feasible"
    tab.page.get_by_label("bound the cost").check()
    tab.page.wait_for_function(READY)
    assert tab.page.locator("[data-field=Q]").input_value() == "1 1"
    assert not locked(tab)


def told(tab):
    """What the element shows, without the time it took."""
    return element(tab, "querySelector('.sos-readout').innerText").split("Solved")[0]


@pytest.mark.parametrize("wanted", [[], ["gamma", "cost", "u_max"]])
def test_a_link_leads_to_the_typed_plant_and_its_answer(tab, visit, wanted):
    type_in(tab, **DRIVE | {"M": "0.0025, 0\n0, 0.004"})
    for key in wanted:
        tab.page.locator(f"[data-wanted={key}]").check()
    if "u_max" in wanted:
        type_in(tab, x0="0.1 0 0 0 0")
    answer = design(tab)
    slider = tab.page.get_by_label("Half-angle")
    for _ in range(3):
        slider.press("ArrowLeft")
    tab.page.wait_for_function(READY)
    K, said = np.array(element(tab, "answer")["K"]), told(tab)
    assert answer["status"] == "feasible" and answer["K"] != K.tolist()
    tab.page.get_by_role("button", name="Link to this").click()
    more = "querySelector('.sos-more').innerText"
    assert "now leads to this setting" in element(tab, more)
    again = visit(tab.page.url, width=390)
    for _ in range(2):  # once more, by a reload
        again.page.wait_for_function(READY)
        assert np.abs(np.array(element(again, "answer")["K"]) / K - 1).max() < 1e-5
        assert told(again) == said and not locked(again)
        assert element(again, more) == "" and element(again, "matrices.M") == (
            "0.0025, 0;0, 0.004"
        )
        names = {}
        exec(program(again, "As Python"), names)
        assert names["plant"].M.tolist() == [[0.0025, 0], [0, 0.004]]
        assert again.errors == []
        again.page.reload()


@pytest.mark.parametrize(
    "address, fault, more",
    [
        ("M=1&D=1&S=1&B=1&F=&U=&sigma=0.3&theta=50&rho=5", "", ""),
        ("M=1&D=1&S=1&B=1&F=&U=&sigma=9e9&theta=50&rho=5", "", "sigma = 9e9"),
        ("M=1&D=1&S=1&B=1&F=&U=&sigma=0x1&theta=50&rho=5", "", "sigma = 0x1"),
        ("M=1&D=1&S=1&B=1&F=&U=&wings=2", "", "wings = 2"),
        ("M=1;2&D=1&S=1&B=1", "M has 1 columns, needs 2", ""),
        ("M=1&D=1", "S is missing", ""),
        ("M=<b>&D=1", '"<b>" is no number', ""),
        ("sigma=1.2&theta=45&rho=5", "", ""),
        ("sigma=1e400", "", "sigma = 1e400"),
        ("sigma=", "", "sigma = ."),
    ],
)
def test_an_address_is_read_like_any_other_input(visit, sheet, address, fault, more):
    tab = visit(f"{sheet.as_uri()}#sos-plant-1:{address}")
    if not fault:
        tab.page.wait_for_function(READY)
    said = element(tab, "querySelector('.sos-fault').textContent")
    assert (fault in said and locked(tab)) if fault else said == ""
    said = element(tab, "querySelector('.sos-more').textContent")
    if not fault:
        asks = f"The address asks for what isn't here: {more}"
        assert said.startswith(asks) if more else said == ""
    assert tab.errors == []


def test_an_answer_for_another_plant_is_never_drawn(tab):
    """Events of one task: sliders move while the plant changes under them."""
    for seed in range(8):
        tab.page.evaluate(
            """seed => {
          const e = document.querySelector("sos-plant"), fire = (part, kind, Kind) =>
            part.dispatchEvent(new (Kind ?? Event)(kind, {bubbles: true}));
          const select = e.view.querySelector("select");
          const held = [...e.view.querySelectorAll("input[type=range]")];
          fire(held[0], "pointerdown", PointerEvent);
          e.find("map").querySelector("[data-handle]")?.dispatchEvent(
            new PointerEvent("pointerdown", {bubbles: true}));
          for (let k = 0; k < 12; k++) {
            const input = held[(k + seed) % held.length];
            input.value = 17 * ((7 * k + seed) % 12);
            fire(input, "input");
            if (k % 3 === seed % 3) {
              select.value = (k + seed) % 4;
              fire(select, "change");
              fire(held[1], "pointercancel", PointerEvent);
              fire(window, "pointermove", PointerEvent);
            }
            if (k === 5) e.press("prove");
            if (k === 8) e.press("c");
          }
          fire(window, "pointerup", PointerEvent);
        }""",
            seed,
        )
        tab.page.wait_for_function(READY)
        assert "NaN" not in element(tab, "innerHTML.replace(/<script.*?script>/gs, '')")
        assert element(tab, "answer.K[0].length") == element(
            tab, "data.vertices[0].A.length"
        )
        assert tab.errors == []


def test_what_the_solver_fails_on_is_said_in_a_sentence(visit, sheet):
    tab = visit(sheet)
    tab.page.wait_for_function(READY)
    tab.page.evaluate(
        """() => { const e = document.querySelector("sos-plant");
      e.data.request = {...e.data.request, vertices: [{}]};   // which no form lets by
      e.solve(); }"""
    )
    tab.page.wait_for_function(
        "document.querySelector('sos-plant').answer.status === 'undecided'"
    )
    said = tab.page.locator("sos-plant .sos-readout").inner_text()
    assert "choose other units" in said
    assert not re.search("undefined|null|Cannot|is not|Error", said)
    assert tab.errors and all("TypeError" in x for x in tab.errors)  # the details


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
    said = process(built, check=True)
    x3, true = 0.0, []
    for _ in range(3):
        true += list(K @ [0.2, -0.6, 0.5, 0.1, x3])
        x3 += 0.01 * -0.6
    assert np.allclose([float(x) for x in said.stdout.split()], true, rtol=1e-7)
