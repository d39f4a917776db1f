"""A law's own controller at the ticks: its memory, its loop, its program."""

import functools
import re
from html.parser import HTMLParser
from shutil import which

import control
import numpy as np
import pytest
from pypdf import PdfReader
from scipy.linalg import expm
from scipy.signal import cont2discrete, dlsim

import sosbook as sos
from sosbook.controllers import Code, CompiledCode, code_fault
from sosbook.controllers.compiler import FLAGS
from sosbook.controllers.facts import bounded
from sosbook.controllers.report import CHROMIUMS, report_texts
from sosbook.runtime.digests import digest
from tests.axis import UNITS, T, drive
from tests.cases import by_hand, campaign
from tests.test_controllers_code import same

FILTER = 0.005
PID = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=FILTER)


@functools.cache
def arm():
    """A two-mass drive with the motor's encoder alone, for every load."""
    plant = sos.Uncertain(drive, J2=(0.003, 0.006))
    return sos.design_pid(plant, law=PID, region=sos.PoleRegion(sigma=4))


@functools.cache
def axis(**more):
    return arm().controller(T=T, delay=T, units=UNITS, counts=4096, **more)


def rough(seed=0):
    """Two inputs, an unsymmetric plant by .3 and 9.81, sensors of mixtures."""
    rng = np.random.default_rng(seed)
    plant = sos.SecondOrderSystem(
        0.3 * np.eye(2), 9.81 * np.array([[1, 0.2], [0, 1]]), [[1, 0.3], [0, 2]],
        [[1, 0.3], [0.2, 1]], [[1], [0.3]],
    )  # fmt: skip
    law = sos.DynamicLaw(
        2, [[1, -0.5], [0.1, 0.3]], [[0, 1]], strictly_proper=False
    )  # fmt: skip
    gains = {
        "A_c": [[-3, 1], [0.3, -9.81]],
        "B_c": rng.normal(size=(2, 3)).round(2),
        "C_c": rng.normal(size=(2, 2)).round(2),
        "D_c": -abs(rng.normal(size=(2, 3)).round(2)),
    }
    return sos.analyse_pid(plant, gains, law=law, region=sos.PoleRegion(0.01))


def cart(law, gains, **region):
    plant = sos.SecondOrderSystem([[0.3]], [[0]], [[0]], [[1]])
    return sos.analyse_pid(plant, gains, law=law, region=sos.PoleRegion(0.1, **region))


def held():
    """The cart by a PD law of its place."""
    return cart(sos.PIDLaw([[1]], filter=0.1), {"K_P": [[-3]], "K_D": [[-2]]})


def test_an_arm_with_one_encoder_is_proven_for_every_load_and_a_clock_that_jitters():
    c = axis()
    assert [str(s) for s in c.readings.signals] == ["motor (rad)"]
    assert c.order == 2 and c.states == ("filtered motor", "integral of motor")
    assert (c.gain.K == arm().certify().K).all()
    proof = c.certify()
    assert proof.proven
    assert "every constant plant with J2 in [0.003, 0.006]" in str(proof)
    assert proof.verify()
    late = c.certify(T=(0.9e-3, 1.1e-3), delay=(0.5e-3, 1e-3))
    assert late.proven and "[0.0009, 0.0011] s" in str(late)


def test_the_memory_is_that_of_scipy_for_readings_in_straight_lines():
    for design, span in ((rough(), 0.03), (arm(), T)):
        law = design.loop.to_ss()
        A, B, C, D = law.A, law.B, law.C, law.D
        a = sum(s.name.startswith("integral") for s in design.loop.signals)
        A, B, C = A[a:, a:], B[a:], C[:, a:]  # integrals are sums
        c = design.controller(T=span)
        Phi, G, H, J, _ = cont2discrete((A, B, C, D), span, "foh")
        l = len(A)
        mine = c.A[:l, :l], c.B[:l], c.C[:, :l], c.D
        z = np.exp(1j * np.array([1e-3, 0.1, 1, 3]))
        for w in z:
            one, other = (
                c @ np.linalg.solve(w * np.eye(l) - a, b) + d
                for a, b, c, d in (mine, (Phi, G, H, J))
            )
            assert np.allclose(one, other, rtol=1e-9)


def test_the_rate_of_a_ramp_is_that_of_the_filter_at_every_tick():
    c, K = axis(), arm().certify().K[0]
    t = np.arange(400) * T
    sums = T * np.concatenate([[0], np.cumsum(t)[:-1]])
    _, u, _ = dlsim((c.A, c.B, c.C, c.D, T), t)
    exactly = K[0] * t + K[1] * (1 - np.exp(-t / FILTER)) + K[2] * sums
    assert np.allclose(u[:, 0], exactly, atol=1e-9)


def test_the_loop_has_the_poles_of_python_control():
    """Without a delay; the hold and the joining are theirs."""
    design = rough()
    c = design.controller(T=0.03)
    plant = design.request.plant
    A, B = by_hand(plant)
    rows = [[1, -0.5, 0, 0], [0.1, 0.3, 0, 0], [0, 0, 0, 1]]
    held = control.sample_system(control.ss(A, B, rows, np.zeros((3, 2))), 0.03)
    law = c.to_ss()[:, :3]
    theirs = control.feedback(held, law, sign=1).poles()
    mine = np.linalg.eigvals(c.loops[0].F)
    assert np.allclose(np.sort_complex(theirs), np.sort_complex(mine), atol=1e-9)
    assert c.certify(delay=0.05, time_limit=60).proven


def test_a_run_is_that_of_the_law_written_by_hand():
    """PID by its own recursion, the drive by expm: no line of the package."""
    c, K = axis(), arm().certify().K[0]
    c = arm().controller(T=T, delay=T)
    for J2, plant in zip((0.003, 0.006), c.vertices):
        M = np.diag([0.0025, J2])
        S, D = (k * np.array([[1, -1], [-1, 1]]) for k in (1.9, 0.004))
        zero, one = np.zeros((2, 2)), np.eye(2)
        A = np.block([[zero, one], [-np.linalg.solve(M, S), -np.linalg.solve(M, D)]])
        whole = np.zeros((5, 5))
        whole[:4] = np.hstack([A, [[0], [0], [1 / 0.0025], [0]]])
        step = expm(whole * T)
        x, held, lag, total, xs = np.zeros(4), 0.0, 0.0, 0.0, []
        keep = np.exp(-T / FILTER)
        for _ in range(1500):
            y = x[0]
            u = K[0] * (y - 1) + K[1] * (1 - keep) / T * (y - lag) + K[2] * total
            lag = keep * lag + (1 - keep) * y
            total += T * (y - 1)
            xs.append(x)
            x, held = step[:4, :4] @ x + step[:4, 4] * held, u  # a tick late
        run = c.simulate(1.5, r=1.0, plants=[plant])
        assert abs(run.x[0] - xs).max() < 1e-8 and not run.fault.any()
    assert abs(run.x[0, -1, :2] - 1).max() < 0.05


def test_what_is_fast_enough_is_the_law_in_continuous_time():
    design = held()
    A = np.asarray(design.closed_loop().A)
    x0 = np.array([1.0, 0, 1.0])  # the filter knows where it is
    for span, far in ((0.01, 0.02), (0.001, 0.002)):
        run = design.controller(T=span).simulate(4, x0=x0[:2])
        true = np.array([expm(A * t) @ x0 for t in run.t[::100]])
        assert abs(run.x[0, ::100, 0] - true[:, 0]).max() < far


def test_set_points_are_those_of_the_errors():
    """P and I see y - r, the rate y; other laws see y - r; at rest y = r."""
    c = held().controller(T=0.01)
    assert c.D_r == 3 and not c.B_r.any()  # the rate asks nothing
    assert 3 <= c.bounds.step().proven < 3.3  # the exact rest is found
    own = sos.DynamicLaw(1, [[1]], strictly_proper=False)
    gains = {"A_c": [[-30]], "B_c": [[30]], "C_c": [[30]], "D_c": [[-31.3]]}
    d = cart(own, gains).controller(T=0.01, delay=0.003)
    assert (
        (d.B_r == -d.B).all() and (d.D_r == -d.D).all() and d.bounds.step().proven > 27
    )
    for one in (c, d, axis()):
        rest, asked = one.static(r=[0.3])
        n = rest.shape[1] // 2
        assert np.allclose(rest[:, :n], 0.3) and np.allclose(asked, 0)
    speeds = sos.PIDLaw(velocity=[[1]])
    plant = sos.SecondOrderSystem([[0.3]], [[1]], [[1]], [[1]])
    c = sos.analyse_pid(plant, {"K_D": [[-1]]}, law=speeds).controller(T=0.01)
    assert c.set_points == () and c.certify().proven


def test_limits_hold_the_integral_back():
    c = axis().set_point(ramp=6).limit(2.0)
    assert (c.W[:-1] == 0).all() and c.W[-1] < 0
    step = 4.0  # with a torque that is much too small
    free, held = (
        axis().limit(0.3, anti_windup=x).simulate(4, r=step) for x in (False, True)
    )
    over = [run.x[:, :, 0].max() - step for run in (free, held)]
    assert abs(held.u).max() <= 0.3 and 0 < over[1] < 0.6 * over[0]


def test_a_memory_that_integrates_by_itself_is_held_back():
    """PID as one of the second order, against the laws' own integral."""
    law = sos.DynamicLaw(2, [[1]], strictly_proper=False)
    gains = {"A_c": [[0, 0], [0, -20]], "B_c": [[1], [20]], "C_c": [[-2, 20]]}
    design = cart(law, gains | {"D_c": [[-23.1]]})
    assert design.status == "feasible"
    c = design.controller(T=0.01)
    assert c.certify().proven and not c.W.any()
    runs = []
    for anti_windup in (False, True):
        one = c.limit(
            0.9, anti_windup=anti_windup, tracking_time=0.3 * anti_windup or None
        )
        runs.append(one.watch(stall=90).simulate(40, r=2.0))
        free = abs(np.linalg.eigvals(one.A - one.W @ one.C)).max()
        assert free <= (np.exp(-0.01 / 0.3) + 1e-6 if anti_windup else 1 + 1e-9)
    loose, held = (run.x[0, :, 0] for run in runs)
    assert loose.max() > 2.05 and held.max() - 2 < 0.6 * (loose.max() - 2)
    assert abs(held[-1] - 2) < 0.01
    assert (
        not cart(
            sos.DynamicLaw(1, [[1]], strictly_proper=False),
            {"A_c": [[-30]], "B_c": [[30]], "C_c": [[30]], "D_c": [[-31.3]]},
        )
        .controller(T=0.01)
        .limit(0.5)
        .W.any()
    )  # it forgets by itself


@pytest.mark.parametrize("precision", ["single", *campaign(["double"])])
def test_c_is_python_bit_for_bit(gcc, precision):
    limited = axis().set_point(ramp=6).limit(2.0, slew=200).watch(lost=0.05)
    assert same(limited, precision, FLAGS) == 0
    same(rough().controller(T=0.03, delay=0.05).watch(lost=3), precision, FLAGS)


def each_part_says_who_holds_its_proof(page):
    told = "no file holds|file sha256|no proof has them|in floats|at all corners"
    for part in re.split("<h[23]>", page)[1:]:
        claims = re.search("<(li|p|pre)>.*(at most|proven)", part, re.DOTALL)
        assert not claims or re.search(told, part), part[:400]


@pytest.mark.slow
@pytest.mark.usefixtures("without_bounds")
def test_report_and_header_say_what_is_proven_of_which_law(tmp_path, monkeypatch):
    monkeypatch.setattr("sosbook.controllers.report.FOR_MARGINS", 1e-3)
    c = axis().limit(2.0)
    path = arm().report(tmp_path, controller=c)
    page = path.read_text("utf-8")
    assert "integral of motor" in page and page.count("over time in s") >= 6
    each_part_says_who_holds_its_proof(page)
    gains = (tmp_path / "axis" / "axis_gains.h").read_text("utf-8")
    text = " ".join(gains.split("#ifndef")[0].replace("*", "").split())
    assert float(re.search(r"steps up to (\S+) rad from rest settle", text)[1]) > 0.2
    assert "u depends on motor alone: PID with a filter of 0.005 s" in text
    assert "in continuous time: every constant plant with J2 in [0.003, 0.006]" in text
    assert "rate of motor" in text and "NOT PROVEN" not in text
    assert code_fault(c.certify().data, gains) == ""
    (_, proven), *_ = rough().controller(T=0.03).to_c().facts
    assert "(z1 - 0.5 z2)" in proven[-1]


@pytest.mark.usefixtures("without_bounds")
def test_a_header_and_its_page_show_one_simulation(monkeypatch):
    """Of a step, where no sample is lost; it was made twice."""
    monkeypatch.setattr("sosbook.controllers.report.FOR_MARGINS", 1e-3)
    c, asked = held().controller(T=0.01), []
    simulate = type(c).simulate

    def noted(c, *words, **more):
        asked.append(str((words, more)))
        return simulate(c, *words, **more)

    monkeypatch.setattr(type(c), "simulate", noted)
    texts = report_texts(held(), c)
    assert len({*asked}) == len(asked) > 0
    assert "over time in s" in texts["index.html"]


def test_what_the_law_has_decided_is_named():
    design = arm()
    with pytest.raises(ValueError, match="measured: the design's law measures motor"):
        design.controller(["load"], T=T)
    assert design.controller("motor", T=T).order == 2
    with pytest.raises(ValueError, match="memory is for a gain of the whole state"):
        design.controller(T=T, memory="observer")
    with pytest.raises(ValueError, match="filter_time is for"):
        design.controller(T=T, filter_time=0.1)
    with pytest.raises(ValueError, match="longer than the law's filter of 0.005 s"):
        design.controller(T=0.0051)
    assert design.controller(T=FILTER).T == FILTER
    slow = sos.PIDLaw(position=[[1, 0]], filter=0.4)
    gains = {"K_P": [[-0.2]], "K_D": [[-0.1]]}
    plant = sos.Uncertain(drive, J2=(0.003, 0.006))
    proof = sos.analyse_pid(plant, gains, law=slow).controller(T=0.3).certify()
    assert not proof.proven and "spectral radius" in str(proof)


def test_a_gain_has_the_names_of_the_laws_signals():
    names = ("motor", "rate of motor", "integral of motor")
    assert arm().gain.signals == names


@pytest.mark.parametrize(
    "ask",
    [
        lambda c: c.set_point(),
        lambda c: c.set_point(ramp=1),
        lambda c: c.simulate(0.1, r=[1]),
        lambda c: c.static(r=[1]),
        lambda c: c.bounds.step(),
        lambda c: c.bounds.ramp(),
    ],
)
def test_rates_alone_have_no_set_point(ask):
    plant = sos.SecondOrderSystem(0.3, 0.5, 9.81, 1, F=1, coordinates=["place"])
    law = sos.PIDLaw(velocity=[[1]])
    c = sos.analyse_pid(plant, {"K_D": [[-2.9]]}, law=law).controller(T=0.01)
    with pytest.raises(ValueError, match="no set point: .* measure a position"):
        ask(c)
    x0 = [0.2, 0.0]
    runs = [c.simulate(0.1, x0=x0, program=p) for p in (None, CompiledCode(c))]
    assert runs[0].u.shape == (1, 10, 1) and abs(runs[0].u).max() > 0
    assert (runs[0].u == runs[1].u).all()
    assert "no file holds" in bounded(c, ())[0]


def test_a_program_whose_sensor_mixes_coordinates_is_held_to_its_proof():
    M, D, S = np.diag([0.3, 2]), 0.3 * np.eye(2), [[9.81, -1], [-1, 2]]
    plant = sos.SecondOrderSystem(M, D, S, [[1], [0]], F=[[0], [1]])
    law = sos.PIDLaw(position=[[1, -0.5]], filter=0.05)
    gains = {"K_P": [[-0.3]], "K_D": [[-0.7]]}
    c = sos.analyse_pid(plant, gains, law=law).controller(T=0.01)
    code = c.to_c("axis")
    proof = c.certify().data
    text = code.texts["axis_gains.h"]
    assert "defines no ROWS" in code_fault(proof, text.replace("AXIS_ROWS", "AXIS_X"))
    assert code_fault(proof, text) == ""
    at = text.index("0x", text.index("#define AXIS_D "))
    forged = text[:at] + re.sub(r"0x\S+p[+-]\d+", "0x1.8p+3", text[at:], count=1)
    assert "ROWS isn't the proof's" in code_fault(proof, forged)
    single = Code(c, "axis", "single").texts["axis_gains.h"]
    assert "in double precision" in code_fault(proof, single)


# The page that an engineer hands on

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


def carts():
    """Carts of 0.3 to 0.5 kg, one after the other in a wind, held by their place."""

    def cart(m):
        return sos.SecondOrderSystem(m, 0, 0, 1, F=1, coordinates=["place"])

    law, gains = sos.PIDLaw([[1]], filter=0.1), {"K_P": [[-3]], "K_D": [[-2]]}
    family, region = sos.Uncertain(cart, m=(0.3, 0.5)), sos.PoleRegion(0.1)
    return sos.analyse_pid(family, gains, law=law, region=region)


def test_the_page_stands_alone_and_says_what_is_known(tmp_path):
    design = carts()
    c = design.controller(T=0.01).set_point(ramp=6).limit(9.81)
    path = design.report(tmp_path, controller=c, name="arm")
    page = path.read_text("utf-8")
    parser = Nested()
    parser.feed(page)
    assert parser.open == []
    assert not re.search(r"(src|href)=", page) and "<script" not in page
    for title in ("What was asked", "The plant", "The gain", "proven and true"):
        assert title in page
    assert "<li>its poles lie in the half-plane Re s &lt; -0.1</li>" in page
    # two corners: place and force of a step and of a load, with dashes
    charts = re.findall(r"<svg role=.img..*?</svg>", page, re.DOTALL)
    motions = [chart for chart in charts if "over time" in chart]
    assert len(motions) == 4 and sum(x.count("<polyline") for x in motions) == 8
    for words in ("Margins of the sampled", "gain, times: from", "over frequency in"):
        assert words in page
    each_part_says_who_holds_its_proof(page)
    assert f"{c.gain.K[0, 0]:.6g}" in page and "arm_step(" in page
    proof = (tmp_path / "arm" / "proof_arm_sampled.json").read_bytes()
    assert digest(proof) in page
    with pytest.raises(FileExistsError):
        held().report(tmp_path, T=0.01, name="arm")


@pytest.mark.slow
@pytest.mark.usefixtures("without_bounds")
def test_a_chromium_prints_the_page(tmp_path, monkeypatch):
    c = held().controller(T=0.01)
    with monkeypatch.context() as m:
        m.setenv("PATH", "")
        with pytest.raises(FileNotFoundError, match="pdf=True needs a Chromium"):
            held().report(tmp_path / "none", controller=c, pdf=True)
    assert not (tmp_path / "none").exists()
    if not any(map(which, CHROMIUMS)):
        pytest.skip("there is no Chromium on the PATH")
    path = held().report(tmp_path, controller=c, pdf=True)
    pages = PdfReader(path.with_suffix(".pdf")).pages
    text = "".join(page.extract_text() for page in pages)
    assert "What was asked" in text and "axis_step(" in text
