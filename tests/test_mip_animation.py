"""The robot in the rendered page: the true loop, and controls that work."""

import json
import re
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.book.elements.robot import STEPS_PER_TICK, animation
from sosbook.pendulum.firmware import Firmware
from sosbook.pendulum.law import SampledLaw
from sosbook.pendulum.model import Mip
from sosbook.pendulum.rig import COUNTS_PER_TURN, GYRO_STEP, Rig
from sosbook.pendulum.spread import vertices
from sosbook.plants import Gain
from tests import elements
from tests.cases import later
from tests.elements import first, say, two_of
from tests.gains import named

MIP = Mip.printed()
T = 0.01
STEP = T / STEPS_PER_TICK
LIMIT, TIP = Firmware.limit, Firmware.tip
LAWS = thesis.mip().gains | {"weak & <slow>": {4: named(thesis.mip().pd[5] / 5)}}
#: As without it, and one whose rotors turn with the body.
ROBOTS = {"printed": MIP} | {f"vertex {k}": v for k, v in enumerate(vertices(MIP), 1)}
ROBOTS["rotors"] = Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=True)
START = dict(law="PD", R=5, tilt=10, delay=5, noise=1)


@pytest.fixture(scope="module")
def element():
    return animation(LAWS, ROBOTS, start=START, title="Stand & <fall>")


@pytest.fixture(scope="module")
def sheet(element, tmp_path_factory):
    page = tmp_path_factory.mktemp("page") / "page.html"
    return elements.write_page(page, element.light)


# ------------------------------------------------------------------ in Python


def test_the_page_gets_the_very_gains_and_pendulums(element):
    data = json.loads(
        re.search(r'<script type="application/json">(.*?)</script>', element.html)[1]
    )
    assert data["title"] == "Stand & <fall>"
    for law in data["laws"]:
        for R, K in zip(law["R"], law["K"]):
            assert K == LAWS[law["name"]][R].K[0].tolist()
    assert ROBOTS["rotors"].J > 0 == MIP.J
    for stored, mip in zip(data["robots"], ROBOTS.values(), strict=True):
        assert [stored[x] for x in "abcdefJ"] == [getattr(mip, x) for x in "abcdefJ"]
        assert np.isclose(stored["radius"], 0.032)  # m, of `from_ratios`
    assert "http" not in element.html and len(element.light) < 12_000


@pytest.mark.parametrize(
    "wrong, words",
    [
        (dict(laws={}), "laws must be a dict"),
        (dict(laws={"PD": {}}), r"laws\['PD'\] must be a dict"),
        (dict(laws={"PD": {1: [1, 2, 3, 4]}}), r"laws\['PD'\]\[1\]: gain must be"),
        (
            dict(laws={"PD": {1: Gain([1, 2], ("z", "z'"))}}),
            r"laws\['PD'\]\[1\]: gain isn't of a balancing robot: it multiplies z, z'",
        ),
        (dict(laws={"PD": {-1: named([1, 2, 3, 4])}}), "R in laws"),
        (dict(robots={"flat": 3}), r"robots\['flat'\] must be a Mip"),
        (dict(T=0), "T"),
        (dict(start=dict(R=3)), r"R must be one of \[1.0, 2.0, 5.0\]"),
        (dict(start=dict(law="LQG")), "law must be one of"),
        (dict(start=dict(delay=4)), "delay = 4 must be a multiple of 2.5"),
        (dict(start=dict(tilt=90)), "tilt = 90 must be"),
        (dict(start=dict(mass=1)), r"names no control: \['mass'\]"),
    ],
)
def test_bad_input_is_explained(wrong, words):
    with pytest.raises(ValueError, match=words):
        animation(**dict(laws=LAWS) | wrong)


# ------------------------------------------- the same loop, with `Controller`


def uniform(seed):
    """The page's generator, mulberry32."""
    mask = 2**32 - 1
    while True:
        seed = seed + 0x6D2B79F5 & mask
        t = (seed ^ seed >> 15) * (1 | seed) & mask
        t ^= t + ((t ^ t >> 7) * (61 | t) & mask) & mask
        yield (t ^ t >> 14) / 2**32


class Sensors:
    """Noise and rounding of the page's gyro and encoders."""

    def __init__(self, noise):
        self.noise, self.random = noise * Rig.noise, uniform(2023)
        self.phase = next(self.random)

    def wheels(self, z):
        step = 2 * np.pi / COUNTS_PER_TURN
        return step * np.floor((z[1] - z[0]) / step + self.phase)

    def gyro(self, dz):
        u, v = next(self.random), next(self.random)
        gauss = np.sqrt(-2 * np.log(1 - u)) * np.cos(2 * np.pi * v)
        return GYRO_STEP * np.floor((dz[0] + self.noise * gauss) / GYRO_STEP + 0.5)


class Ideal:
    """Sensors that say the truth."""

    def wheels(self, z):
        return z[1] - z[0]

    def gyro(self, dz):
        return dz[0]


def rate(x, V, mip):
    return np.append(x[2:], mip.acceleration(x[:2], x[2:], V))


def runge_kutta(x, V, h, mip):
    a = rate(x, V, mip)
    b = rate(x + h / 2 * a, V, mip)
    c = rate(x + h / 2 * b, V, mip)
    d = rate(x + h * c, V, mip)
    return x + h / 6 * (a + 2 * b + 2 * c + d)


def simulate(gain, tilt, delay, seconds, sensors, mip=MIP):
    """theta, phi, theta', phi', V at the ticks, and the fault."""
    law = SampledLaw.of_gain(gain, T)
    controller = Firmware(law, stall=10**9).controller()
    x, late = np.array([np.radians(tilt), 0, 0, 0]), round(delay / STEP)
    controller.start(x[0], sensors.wheels(x[:2]))
    asked, rows = [], []
    for k in range(round(seconds / T)):
        V = controller.step(sensors.gyro(x[2:]), sensors.wheels(x[:2]))[0]
        asked.append(V)
        rows.append([*x, V])
        for n in range(k * STEPS_PER_TICK, (k + 1) * STEPS_PER_TICK):
            from_tick = (n - late) // STEPS_PER_TICK
            x = runge_kutta(x, asked[from_tick] if from_tick >= 0 else 0.0, STEP, mip)
    return np.array(rows).T, controller.fault[0]


# -------------------------------------------------------------- in the browser


first, say = (partial(f, tag="sos-robot") for f in (first, say))


def held(tab, code, given=None):
    return elements.held(tab, "sos-robot", code, given)


def ran(tab, **setting):
    """A run in the page as `simulate` returns it, and its verdict."""
    run = held(tab, "return a.run(given);", setting)
    rows = [run[k] for k in ("theta", "phi", "dtheta", "dphi", "V")]
    return np.array(rows), run["verdict"]


@pytest.fixture(scope="module")
def engine(browser, sheet):
    """A page whose controls no test moves."""
    page = browser.new_page()
    page.goto(sheet.as_uri())
    yield SimpleNamespace(page=page)
    page.close()


@pytest.mark.parametrize(
    "law, R, tilt, delay, robot",
    [
        ("PD", 5, 40, 30, "rotors"),
        ("PID", 1, 10, 7.5, "printed"),
        *later(
            ("PD", 5, 10, 0, "printed"),
            ("PID", 5, 30, 10, "printed"),
            ("PID", 2, 10, 5, "rotors"),
        ),
        ("weak & <slow>", 4, 20, 2.5, "rotors"),
    ],
)
def test_the_page_runs_the_loop_of_python(engine, law, R, tilt, delay, robot):
    """Controller and `Mip.acceleration` against the script: to 1e-9."""
    page, verdict = ran(
        engine, law=law, R=R, tilt=tilt, delay=delay, robot=robot, ideal=True, seconds=2
    )
    mip = ROBOTS[robot]
    true, fault = simulate(LAWS[law][R], tilt, delay / 1e3, 2, Ideal(), mip=mip)
    assert (fault != 0) == (verdict["fell"] is not None)
    there = np.abs(true[0]) < 1.4  # then it lies on the ground
    end = len(there) if there.all() else there.argmin()
    assert np.abs(page - true)[:, :end].max() < 1e-9
    assert np.abs(true[4]).max() > 1.0


@pytest.mark.parametrize(
    "law, R, delay, noise, word",
    [("PD", 5, 10, 5, "stands"), ("PD", 1, 10, 1, "chatters")],
)
def test_noise_and_counts_are_those_of_python(engine, law, R, delay, noise, word):
    page, verdict = ran(
        engine, law=law, R=R, tilt=10, delay=delay, noise=noise, seconds=4
    )
    true, _ = simulate(LAWS[law][R], 10, delay / 1e3, 4, Sensors(noise))
    assert np.abs(page - true)[:, :50].max() < 1e-9
    V = true[4, -100:]
    assert (np.sqrt(np.mean(V**2)) > 1) == (word == "chatters")
    assert verdict["word"] == word
    assert abs(verdict["full"] - np.mean(np.abs(V) >= LIMIT)) < 0.2
    assert abs(verdict["turns"] - np.sum(V[1:] * V[:-1] < 0)) < 20


def test_the_gyro_is_as_noisy_as_it_says(engine):
    seen = held(
        engine,
        """
      const robot = a.robot({...a.place, noise: 5});
      robot.state = [0, 0, 1, 0];
      return Array.from({length: 4000}, () => robot.rate());""",
    )
    assert abs(np.mean(seen) - 1) < 4 * 5 * Rig.noise / np.sqrt(4000)
    assert abs(np.std(seen) / (5 * Rig.noise) - 1) < 0.05


@pytest.mark.parametrize("robot", ["printed", "rotors"])
def test_a_push_is_a_momentum_at_the_top(engine, robot):
    page, _ = ran(engine, tilt=10, pushes=[0], seconds=T, robot=robot, ideal=True)
    theta, _, *jump = page[:4, 0]
    mip = ROBOTS[robot]
    both = mip.b * np.cos(theta) - mip.J
    mass = np.array([[mip.c, both], [both, mip.a]])
    assert np.allclose(mass @ jump, 0.06 * np.array([0.1 * np.cos(theta), 0.032]))


def test_it_stands_a_push_but_not_three_at_once(engine):
    calm, once, thrice = (
        ran(engine, tilt=0, pushes=p) for p in ([], [1], [1, 1.02, 1.04])
    )
    words = [verdict["word"] for _, verdict in (calm, once, thrice)]
    assert words == ["stands", "stands", "falls"]
    assert np.abs(once[0][0]).max() > np.abs(calm[0][0]).max() + 0.2
    assert thrice[1]["fell"] > 1.0


def test_a_fall_ends_on_the_ground(tab):
    """The corner that is 100 mm up and 17 mm out touches it."""
    page, verdict = ran(tab, law="weak & <slow>", R=4, tilt=20)
    assert verdict["word"] == "falls"
    k = round(verdict["fell"] / T)
    assert page[0, k - 1] < TIP + 0.01 and page[0, k] > TIP - 0.01
    assert np.all(page[4, k:] == 0) and np.any(page[4, :k])
    lying = page[0, -1]
    height = 0.032 + 0.1 * np.cos(lying) - 0.017 * np.sin(lying)
    assert abs(height) < 1e-9 and np.all(page[2:4, -1] == 0)
    first(tab).get_by_label("Law").select_option("weak & <slow>")
    assert say(tab).startswith("It falls: after")
    assert "under the weak & <slow> for R = 4 starts at 10°" in sentence(tab)
    assert "the tilt passes 49° and the motors go off" in say(tab)


def test_the_picture_shows_the_run(tab):
    """What plays is what was announced, drawn as it is."""
    body, wheel, theta, phi = held(
        tab,
        """
      a.seek(0.5);
      const turn = name => Number(a.querySelector(name).getAttribute(
        "transform").match(/rotate\\((.*)\\)/)[1]);
      const run = a.run();
      return [turn(".sos-body"), turn(".sos-wheel"), run.theta[50], run.phi[50]];""",
    )
    assert np.allclose([body, wheel], np.degrees([theta, phi]), atol=0.01)
    live = first(tab).locator(".sos-live").inner_text()
    assert live.startswith("t = 0.50 s, θ = ")
    assert f"x = {3.2 * phi:.1f} cm".replace("-", "−") in live


# ----------------------------------------------------------------- controls


def test_the_law_keeps_the_nearest_weight(visit, element, tmp_path):
    """And another robot on the page is left alone."""
    tab = visit(two_of(element, tmp_path))
    weight = first(tab).get_by_label("Weight R of the design")
    law = first(tab).get_by_label("Law")
    other = tab.page.locator("sos-robot").nth(1).locator(".sos-readout")
    before = other.inner_text()
    law.select_option("PID")
    assert "PID for R = 5" in sentence(tab) and "KI =" in say(tab)
    law.select_option("weak & <slow>")
    assert "for R = 4 " in sentence(tab)
    assert weight.locator("option").all_inner_texts() == ["4"]
    law.select_option("PD")
    assert "PD for R = 5" in sentence(tab) and "KI =" not in say(tab)
    text = say(tab)
    first(tab).get_by_label("Robot").select_option("vertex 3")
    assert held(tab, "return a.result.robot.mip.e;") == vertices(MIP)[2].e
    assert say(tab) != text and other.inner_text() == before


def sentence(tab):
    return first(tab).get_attribute("aria-label")


def clock(tab):
    return held(tab, "return a.time;")


def test_nothing_moves_unasked_where_less_motion_is_wanted(tab):
    play = first(tab).get_by_role("button", name="Play")
    tab.page.evaluate("new Promise(requestAnimationFrame)")
    assert clock(tab) == 0
    assert first(tab).locator(".sos-line").count() == 2  # what will come
    play.focus()
    play.press("Enter")
    tab.page.wait_for_function("document.querySelector('sos-robot').time > 0.2")
    first(tab).get_by_role("button", name="Pause").press("Space")
    stopped = clock(tab)
    tab.page.evaluate("new Promise(requestAnimationFrame)")
    assert clock(tab) == stopped > 0.2
    first(tab).get_by_role("button", name="Push").click()
    assert "Pushed once" in say(tab) and clock(tab) == stopped
    first(tab).get_by_role("button", name="Reset").click()
    assert clock(tab) == 0 and "Pushed" not in say(tab)


def test_a_push_changes_what_comes_and_not_what_was(tab):
    """The motion goes on: what was seen before the push is seen again."""
    before, after, word = held(
        tab,
        """
      a.seek(0.5);
      const before = a.result.robot.log.theta.slice(0, 50);
      for (const t of [0.5, 0.52, 0.54]) { a.seek(t); a.press("push"); }
      return [before, a.result.robot.log.theta, a.result.verdict.word];""",
    )
    assert after[:50] == before and word == "falls"
    assert max(map(abs, after)) > 1


def test_it_plays_by_itself_otherwise(tab):
    tab.page.emulate_media(reduced_motion="no-preference")
    tab.page.reload()
    tab.page.wait_for_function("document.querySelector('sos-robot').time > 0.6")
    first(tab).get_by_role("spinbutton", name="Initial tilt").fill("20")
    assert first(tab).get_by_role("button", name="Pause").is_visible()
    assert clock(tab) < 0.6  # it begins anew, and has played on a little


def test_time_runs_true_or_slow_and_begins_anew(tab):
    """Driven by hand: frames of 40 ms, drawn up to the same time."""
    times = held(
        tab,
        """
      let call = null;
      window.requestAnimationFrame = f => (call = f, 1);
      const after = (slow, from, frames) => {
        a.find("slow").firstChild.checked = slow;
        a.reset();
        a.time = from;
        a.play(true);
        for (let k = 0; k <= frames; k++) call(40 * k);
        return a.time;
      };
      return [after(false, 0, 10), after(true, 0, 10), after(false, 29.9, 20)];""",
    )
    assert np.allclose(times[:2], [0.4, 0.1]) and times[2] < 0.3
