"""A reader's request in the form: it stays as typed, and all its texts ask the same."""

import json
import re
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import elements
from sosbook.book.elements.bench import EXAMPLES as PLANTS_TO_TYPE
from sosbook.book.elements.program import program_data
from sosbook.proofs.command import main, read_plant_file
from sosbook.requirements.shorthand import bounds, collected, parameter
from sosbook.requirements.vocabulary import PARAMETERS
from sosbook.synthesis.request import Request
from tests.cases import campaign, later
from tests.elements import write_page
from tests.test_bench import DRIVE, READY, design, element, program, told, type_in

EXAMPLES = [x["name"] for x in elements.bench().data["examples"]]
BOXES = ("law", "gamma", "cost", "u_max", "clock")
SCHEMA = Path(sos.__file__).parent / "proofs" / "plant.schema.json"


@pytest.fixture
def tab(visit, tmp_path):
    tab = visit(write_page(tmp_path / "plant.html", elements.bench().html))
    tab.page.wait_for_function(READY)
    yield tab
    assert tab.errors == []


#: The address, and the way back, know the setting.
KEPT = """() => { const e = document.querySelector("sos-bench");
  return e.kept === e.digest; }"""


def numbers(tab):
    """What stands in every field of the form and of its sentence, by its name."""
    return tab.page.evaluate("""() => Object.fromEntries([
      ...document.querySelectorAll("sos-bench .sos-num, sos-bench textarea")]
      .filter(e => e.checkVisibility())
      .map(e => [e.dataset.field ?? `${e.dataset.bound} said`, e.value]))""")


def tick(tab, box, on=True):
    tab.page.locator(f"[data-wanted={box}]").set_checked(on)


def put(tab, key, text):
    """Type a bound's number, that of the theorems."""
    unit = {"sigma": "/s", "theta": "°", "rho": " 1/s"}.get(key, "")
    tab.page.locator(f".sos-num[data-bound='{key}']").fill(text + unit)


@pytest.mark.parametrize("example", [0, *campaign(range(1, len(EXAMPLES)))])
def test_what_a_reader_typed_stays(tab, example):
    """Whatever is pressed; only what nobody touched follows the plant."""
    tab.page.locator("[data-key=example]").select_option(str(example))
    for box in ("u_max", "cost", "gamma", "clock"):
        tick(tab, box)
    bounds = element(tab, "named")
    typed = {key: f"{0.83 * x:.3g}" for key, x in bounds.items() if key != "rho"}
    for key, text in typed.items():
        put(tab, key, text)
    type_in(tab, T="0.003", r=numbers(tab)["r"] or " ".join(["1.5"] * rows(tab)))
    design(tab)
    before = numbers(tab)
    for press in [*BOXES[1:], "design", "prove", "c", "json", "reload", "undo"]:
        if press in BOXES:
            tick(tab, press, False)
            tab.page.wait_for_function(READY)
            without = numbers(tab)
            assert {k: before[k] for k in without} == without, press
            tick(tab, press)
        elif press == "design":
            tab.page.locator(".sos-design").click()
        elif press == "reload":
            tab.page.wait_for_function(KEPT)
            tab.page.reload()
        elif press == "undo":
            put(tab, "sigma", "0.123")
            tab.page.wait_for_function(KEPT)
            tab.page.locator("[data-do=undo]").click()
        else:
            tab.page.locator(f"[data-do={press}]").click()
        tab.page.wait_for_function(READY)
        assert numbers(tab) == before, press
    # another plant: a spring of ten times the stiffness
    stiff = before["S"].replace("\n", "\n ").split(" ")
    text = " ".join(f"{10 * float(x):g}" + "\n" * ("\n" in x) for x in stiff)
    type_in(tab, S=text)
    design(tab)
    after = numbers(tab)
    assert after["rho said"] != before["rho said"]  # which nobody typed
    for key in typed:
        assert after[f"{key} said"] == before[f"{key} said"], key


def rows(tab):
    return element(tab, "data.goal.length")


def test_what_cannot_stay_is_named(tab):
    put(tab, "sigma", "0.3")
    type_in(tab, S="1e9 -1e9; -1e9 1e9")  # however far from this plant's size
    design(tab)
    assert element(tab, "bounds.sigma") == 0.3
    tab.page.locator("[data-key=example]").select_option("1")
    tick(tab, "u_max")
    put(tab, "u_max", "7")
    tab.page.locator("[data-key=example]").select_option("2")
    note = tab.page.locator(".sos-note").inner_text()
    assert "uₘₐₓ = 7 went with the plant before" in note
    type_in(tab, x0="1 2 3 4")
    tab.page.locator(".sos-design").click()
    assert "x0 has 4 entries" in tab.page.locator(".sos-fault").inner_text()
    assert tab.page.locator("[data-field=x0]").input_value() == "1 2 3 4"


# ------------------------------------------------------------- one request, three texts

#: Random wishes of the form: the request in the file's words, and its three texts.
TEXTS = """([texts, wanted, places]) => {
  const {form, outputs, program} = sosModules;
  const all = Object.fromEntries(form.FIELDS.map(([name]) => [name, ""]));
  const rows = Object.entries(texts).map(([name, text]) => [name, form.compact(text)]);
  const found = form.requestOf({...all, ...Object.fromEntries(rows)}, wanted);
  const data = form.dataOf(found, wanted), named = {};
  data.bounds.forEach(({key, value}, k) => {
    named[key] = Number((value * (0.2 + 0.9 * places[k])).toPrecision(3)); });
  const asked = program.asks(data, named), {U, vertices: [{M, B}]} = data.request;
  const {position: seen = M, filter, integrate: sums = U} = data.law ?? {};
  const N = seen.length * (filter || !data.law ? 2 : 1) + sums.length;
  const K = B[0].map((_, i) => Array(N).fill(0.5 + i));
  const points = data.goal.map(() => seen.map(() => 1));
  const code = outputs.program(asked, {K, U, points}, "Said.");
  return [outputs.file(asked), program.design(data, named), code]; }"""


def wish(seed):
    """Texts, boxes and places of the sliders; of a drive or four masses."""
    rng = np.random.default_rng([seed, 9])
    names = ["A drive whose load is known by a range", EXAMPLES[3], EXAMPLES[2]]
    texts = dict(PLANTS_TO_TYPE[names[seed % 3]])
    wanted = {box: bool(rng.random() < 0.5) for box in BOXES}
    n, m = (len(texts[x].split("\n")[0].split()) for x in "MB")
    a = len(texts["U"].split("\n"))
    count = 2 * n + a
    texts |= {
        "x0": " ".join(f"{x:.3g}" for x in rng.normal(size=count)),
        "Q": " ".join(["0.3"] * count),
        "R": " ".join(["9.81"] * m),
        "T": f"{10 ** rng.uniform(-4, -1):.3g}",
        "delay": rng.choice(["", "0.0007"]),
        "outputs": rng.choice(["", f"position = {' '.join(['1'] * n)}\ninput = 0.01"]),
        "position": texts["U"],
        "filter": rng.choice(["", "0.02"]),
        "structure": rng.choice(["", "diagonal"]) if a == 1 else "",
    }
    if wanted["law"]:
        held = a + (a if texts["filter"] else 0)
        texts["x0"] += " 0.25" * (held - a)
        texts["Q"] += " 0.3" * (held - a)
    elif rng.random() < 0.5:
        texts["measured"] = " ".join(f"z{j + 1}" for j in range(n))
    return texts, wanted, rng.uniform(0.1, 0.9, 6).tolist()


def caught(python):
    """What a page's Python asks of the package: keywords and the program's."""
    seen = {}

    def design_pid(plant, **asked):
        seen.update(plant=plant, asked=asked)
        made = SimpleNamespace(status="feasible", K=None, controller=controller)
        made.report = lambda *_, **__: None
        return made

    def controller(*measured, **clock):
        names = {"measured": measured[0]} if measured else {}
        seen["controller"] = names | clock
        made = SimpleNamespace(certify=lambda **_: "")
        made.limit = lambda u_max: seen["controller"].update(u_max=u_max) or made
        return made

    names = {"design_pid": design_pid, "print": lambda *_, **__: None}
    exec(python.replace("sos.design_pid", "design_pid"), names)
    return seen


def in_c(code):
    """What a page's C says that was asked, and what its numbers are."""
    asked = json.loads(re.search(r"   Asked: (.*)", code)[1])
    limit = re.search(r"#define LIMIT (\S+)", code)
    step = re.search(r"dt seconds, dt = ([\d.e-]+)\.", code)
    return asked, limit and float(limit[1]), step and float(step[1])


@pytest.mark.parametrize("count", [20, pytest.param(600, marks=pytest.mark.campaign)])
def test_json_python_and_c_ask_the_same(tab, tmp_path, count):
    file, seen = tmp_path / "plant.json", set()
    for seed in range(count):
        text, python, code = tab.page.evaluate(TEXTS, [*wish(seed)])
        file.write_text(text, "utf-8")
        plant, asked, computer = read_plant_file(file)
        there, data = caught(python), json.loads(text)
        assert repr(there["asked"]) == repr({k: asked[k] for k in there["asked"]}), seed
        assert there["asked"].keys() == asked.keys()
        for mine, theirs in zip(there["plant"].vertices, plant.vertices, strict=True):
            for name in "MDSBF":
                assert getattr(mine, name).tolist() == getattr(theirs, name).tolist()
        assert there.get("controller") == computer
        inner = {k: x for k, x in data.items() if isinstance(x, dict) and k != "plant"}
        seen |= {*data, *(f"{k}.{name}" for k, x in inner.items() for name in x)}
        said, limit, step = in_c(code)
        assert said == {k: x for k, x in data.items() if k != "plant"}, seed
        bound = asked.get("saturation")
        assert limit == (bound and pytest.approx(bound.u_max, rel=1e-8))
        if computer is not None:
            assert computer.get("u_max") == (bound and bound.u_max)
            assert step == computer["T"]
            if "measured" in computer:
                assert f"for {', '.join(computer['measured'])} alone" in code
    schema = json.loads(SCHEMA.read_text("utf-8"))["properties"]
    assert {x.split(".")[0] for x in seen} <= {*schema}
    for name in (
        "law.filter",
        "law.structure",
        "controller.measured",
        "hinf.outputs",
        "controller.delay",
        "controller.u_max",
        "saturation.x0",
        "cost.bound",
    ):
        assert name in seen, name  # else nothing was compared  # fmt: skip


def test_a_key_that_a_writer_does_not_know_is_an_error(tab):
    """None of the file's keys is left out in silence."""
    schema = json.loads(SCHEMA.read_text("utf-8"))["properties"]
    strange = {"h2", "maximize", "minimize", "search"}
    for name in {*schema} - {"$schema"}:
        words = tab.page.evaluate(
            """name => ["PYTHON", "IN_C"].map(kind => {
          const {program, outputs} = sosModules;
          const writers = {...program, ...outputs}[kind];
          try { program.written({[name]: {outputs: []}}, writers); return ""; }
          catch (fault) { return fault.message; } })""",
            name,
        )
        for said in words:
            assert said == (f"no writer knows {name}" if name in strange else "")


@pytest.mark.parametrize("example", [1, *campaign([0, 2])])
def test_python_without_a_design_says_why(tab, tmp_path, monkeypatch, capsys, example):
    monkeypatch.chdir(tmp_path)
    tab.page.locator("[data-key=example]").select_option(str(example))
    for box in ("u_max", "clock"):
        tick(tab, box)
    put(tab, "u_max", f"{element(tab, 'bounds.u_max') / 3e4}")
    tab.page.wait_for_function(READY)
    assert element(tab, "answer.status") in ("infeasible", "undecided")
    names = {}
    exec(program(tab, "As Python"), names)
    assert names["design"].status in ("infeasible", "undecided")
    assert names["design"].reason in capsys.readouterr().out


@pytest.mark.usefixtures("without_bounds")
def test_the_limit_of_the_file_s_program_is_the_request_s(tab, tmp_path, capsys):
    file = tmp_path / "plant.json"
    type_in(tab, M="0.005", D="0.02", S="0", B="1", F="1", U="1")
    for box in ("u_max", "clock"):
        tick(tab, box)
    design(tab)
    put(tab, "u_max", "2")
    put(tab, "sigma", "3.333")
    tab.page.wait_for_function(READY)
    file.write_text(program(tab, "As JSON"), "utf-8")
    assert main(["design", str(file), "--out", str(tmp_path / "out")]) == 0
    assert "warning" not in capsys.readouterr().err
    gains = (tmp_path / "out" / "axis" / "axis_gains.h").read_text("utf-8")
    assert "AXIS_LIMIT {0x1p+1}" in gains
    data = json.loads(file.read_text("utf-8"))
    del data["controller"]["u_max"]
    file.write_text(json.dumps(data), "utf-8")
    assert main(["design", str(file), "--out", str(tmp_path / "none")]) == 0
    said = capsys.readouterr().err
    assert 'no limit: write "u_max": 2 under controller' in said


FELT = (
    sos.Output(acceleration=1, name="felt")
    & sos.Output(input=0.1)
    & sos.Output(position=[[0.3]])
)
SWAY = sos.Output(velocity=[[9.81]])
#: Requirements of which a bound is less than all.
MORE = {
    "outputs": (sos.HInfinity(30.0, outputs=FELT), "gamma"),
    "inputs": (sos.HInfinity(30.0, inputs=[0]), "gamma"),
    "a name": (sos.HInfinity(30.0, outputs=SWAY, name="sway"), "sway"),
    "H2": (sos.H2(30.0, outputs=SWAY), "h2"),
    "acceleration": (sos.Saturation(50.0, [0.3, 0], acceleration=True), "u_max"),
    "N": (
        sos.QuadraticCost(
            np.eye(2), [[1.0]], N=[[0.3], [0.1]], noise="F", bound=1000.0
        ),
        "cost",
    ),
}


def test_the_page_s_python_asks_all_of_a_requirement(tab):
    plant = sos.SecondOrderSystem([[2]], [[0.3]], [[9.81]], [[1]], [[1]])
    for kind, (asked, key) in MORE.items():
        held = collected(requirements=[asked], region=sos.PoleRegion(0.1))
        request = Request(plant, requirements=held)
        told = {key: parameter(key, held).shown(x) for key, x in bounds(held).items()}
        given, names = [program_data(request), told], {}
        code = tab.page.evaluate("given => sosModules.program.design(...given)", given)
        exec(code, names)
        mine = {r.name: r for r in names["design"].request.requirements}[asked.name]
        assert asdict_of(mine) == asdict_of(asked), (kind, key)
        assert names["design"].status == "feasible", kind


def asdict_of(r):
    """The fields of a requirement in words that can be compared."""
    given = {f.name: getattr(r, f.name) for f in fields(r) if f.init}
    return {name: repr(np.asarray(x).tolist()) for name, x in given.items()} | {
        "outputs": repr(given.get("outputs"))
    }


# ------------------------------------------------------------- one state of rest

PLANTS = [
    DRIVE,
    {"M": "2", "D": "0.3", "S": "9.81", "B": "0.5", "F": "1", "U": "1"},
    {"M": "1 0.2; 0.2 0.7", "D": "0.3 0.1; 0 0.2", "S": "5 -2; -1 3", "B": "1 0; 0 1",
     "F": "1; 0", "U": "1 0.5"},
    {"M": "1 0 0; 0 2 0; 0 0 0.3", "D": "0.01 0 0; 0 0.01 0; 0 0 0.01",
     "S": "9.81 -9.81 0; -9.81 14 -4.19; 0 -4.19 4.19", "B": "1; 0; 0", "F": "0; 0; 1",
     "U": "0 0 1"},
]  # fmt: skip


def matrix(text):
    return np.array([[float(x) for x in row.split()] for row in text.split(";")])


@pytest.mark.parametrize("texts", [*campaign(PLANTS[:2]), *PLANTS[2:]])
def test_start_picture_table_and_c_have_one_state_of_rest(tab, texts):
    """The smallest z and u with S z = B u and U z = r; no gain has a say in it."""
    tick(tab, "u_max")
    type_in(tab, **texts)
    design(tab)
    S, B, U = (matrix(texts[name]) for name in "SBU")
    unit = np.abs(S).max() / np.abs(B).max()
    X = np.block([[S, -unit * B], [U, np.zeros((len(U), B.shape[1]))]])
    y = np.r_[np.zeros(len(S)), np.ones(len(U))]
    true = np.linalg.lstsq(X, y, rcond=None)[0]
    z, u = true[: len(S)], true[len(S) :]
    assert np.allclose(X @ true, y)
    assert np.allclose(element(tab, "data.r"), z, rtol=1e-8, atol=1e-9)
    assert np.allclose(element(tab, "data.x0")[: len(S)], -z, rtol=1e-8, atol=1e-9)
    R = re.search(r"R\[SENSORS\]\[GOALS\] = \{\n(.*?)\n\};", program(tab, "As C"), re.S)
    mine = [float(x) for x in re.findall(r"[-\d.e]+", R[1])]
    assert np.allclose(mine, z, rtol=1e-8, atol=1e-9)
    if not np.any(np.abs(u) > 1e-9):  # then the step is the motion from x(0)
        peak = element(tab, "answer.peak")
        assert element(tab, "truth.input") == pytest.approx(peak, rel=0.02)
    for fast in ("8", "30"):  # another gain, the same state
        put(tab, "rho", fast)
        tab.page.wait_for_function(READY)
        assert np.allclose(element(tab, "data.r"), z, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("filtered", ["", "0.002"])
def test_a_law_s_memory_rests_on_what_is_measured(tab, filtered):
    """The filter has followed the sensors; a derivative at the start has no kick."""
    for box in ("law", "u_max"):
        tick(tab, box)
    given = DRIVE | {"position": "2 0; 1 -1", "filter": filtered, "U": "1 0"}
    type_in(tab, **given)
    tab.page.locator(".sos-design").click()
    x0 = element(tab, "data.x0")
    z, memory = np.array(x0[:2]), x0[5:]
    assert z.tolist() == [-1, -1] and x0[2:5] == [0, 0, 0]
    held = matrix(given["position"]) @ z if filtered else []
    assert np.allclose(memory, held)
    type_in(tab, x0="0.3 -0.2 1 0")  # the plant's state is enough
    tab.page.locator(".sos-design").click()
    more = [0.6, 0.5] if filtered else []
    assert np.allclose(element(tab, "data.x0"), [0.3, -0.2, 1, 0, 0, *more])
    type_in(tab, x0="0.3 -0.2 1")
    tab.page.locator(".sos-design").click()
    fault = tab.page.locator(".sos-fault").inner_text()
    assert "x0 has 3 entries, needs 2n = 4" in fault


# ------------------------------------------------------------- what is said of refusals

SUMS = [
    (DRIVE | {"position": "1 0", "U": "1 0"}, ""),
    (DRIVE | {"position": "1 0", "U": "1 0", "D": "0.004 -0.004; -0.004 0.004"}, "0.5"),
    (DRIVE | {"position": "1 0; 0 1", "M": "0.0025 0; 0 J2",
              "ranges": "J2 = 0.003 .. 0.006"}, ""),
    ({"M": "1 0.2; 0.2 0.7", "D": "0.3 0.1; 0 0.2", "S": "5 -2; -1 3", "B": "0; 1",
      "F": "1; 0", "U": "1 0", "position": "1 0"}, "1.7"),
]  # fmt: skip


@pytest.mark.parametrize("texts, filtered", [*later(*SUMS[:3]), SUMS[3]])
def test_the_sum_of_the_poles_refuses_a_law(tab, tmp_path, texts, filtered):
    """As the package does; with the filter that is advised the sum is small enough."""
    for box in ("law", "u_max"):
        tick(tab, box)
    type_in(tab, **{"ranges": "", "velocity": "", "filter": filtered} | texts)
    tab.page.locator(".sos-design").click()
    vertices = element(tab, "data.request.vertices")
    p, a = len(matrix(texts["position"])), len(matrix(texts["U"]))
    order = 2 * len(vertices[0]["M"]) + a + (p if filtered else 0)
    damping = min(np.trace(np.linalg.solve(v["M"], v["D"])) for v in vertices)
    sums = damping + (p / float(filtered) if filtered else 0)
    put(tab, "sigma", f"{1.01 * sums / order:.6g}")
    assert element(tab, "answer.status") == "infeasible"
    said = told(tab)
    assert "No gain of these sensors moves the sum of the poles" in said
    limit = float(re.search(r"a real part of −(\S+) s", said)[1])
    assert limit == pytest.approx(sums / order, rel=6e-3)
    tab.page.locator("[data-do=prove]").click()
    assert "press As JSON" in tab.page.locator(".sos-more").inner_text()
    file = tmp_path / "plant.json"
    data = json.loads(program(tab, "As JSON"))
    del data["saturation"]
    file.write_text(json.dumps(data), "utf-8")
    plant, asked, _ = read_plant_file(file)
    theirs = sos.design_pid(plant, **asked)
    assert theirs.status == "infeasible" and theirs.infeasibility.proven
    short = float(re.search(r"a filter time below (\S+) s", said)[1])
    new = order if filtered else order + p
    assert damping + p / short > new * 1.01 * sums / order
    type_in(tab, filter=f"{short}")
    assert design(tab)["status"] != "infeasible"
    put(tab, "sigma", f"{0.99 * limit}")
    assert "sum of the poles" not in told(tab)


def test_the_page_s_bounds_have_the_package_s_words(tab):
    bounds = tab.page.evaluate("sosModules.wishes.BOUNDS")
    for key, mine in bounds.items():
        which = PARAMETERS[key]
        names = ("symbol", "unit")
        assert [mine[x] for x in names] == [getattr(which, x) for x in names]
        assert mine["looser"] == -which.harder
