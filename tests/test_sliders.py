"""Sliders over a function: the cells of the book, and what is refused."""

import ast
import re
from dataclasses import replace
from types import SimpleNamespace

import ipywidgets
import numpy as np
import pytest
from scipy.linalg import eig, expm
from scipy.special import lambertw

import sosbook as sos
from sosbook.book import notebooks, thesis, widgets
from sosbook.book.notebooks import BOOK
from sosbook.pendulum import Mip, SampledLaw, polytope, vertices
from sosbook.plants import condense
from tests.cases import by_turns

I4 = np.eye(4)
ROBOT, WING = thesis.example_1(), thesis.delay_example_1(published=True)
REGION = sos.PoleRegion(1.0, np.radians(60), 8)
ALL = ROBOT.requirements | {"region": REGION}
MOVED = {"sigma": 1.0, "theta": 60, "rho": 8}
DELAYED = thesis.delay_example_2()


def heavier(mass):
    """The two masses of chapter 16 with another first one."""
    p = DELAYED.plant
    return sos.SecondOrderSystem(np.diag([mass, 1.0]), p.D, p.S, p.B)


#: For each chapter: what its cell needs, where the sliders go, the package's answer.
CELLS = {
    "04_lmi_regions": (
        [], MOVED, lambda: sos.design_pid(ROBOT.plant, ROBOT.U, region=REGION),
    ),
    "07_grasping_robot": (
        ["U = np.eye(2)\nwanted"], MOVED, lambda: sos.design_pid(ROBOT.plant, **ALL),
    ),
    "17_wing_and_two_masses": (
        [], {"tau": 0.15, "mu": 0.05, "delta": 0.2},
        lambda: sos.design_delay_pid(
            WING.plant, **WING.requirements | dict(tau=0.15, mu=0.05, delta=0.2)),
    ),
    "16_delay_theorem": (
        ["example = ", "def chain(mass", "from sosbook.book import widgets"],
        {"low": 1.0, "delay": 0.5},
        lambda: sos.design_delay_pid(
            sos.Polytope([heavier(1.0), heavier(1.2)]), DELAYED.U,
            tau=0.5, mu=0.2, delta=0.05, alpha=1.6),
    ),
    "18_least_cost": (
        [], {"R": 20.0, "spread": 30},
        lambda: sos.design_lqr(polytope(Mip.printed(), 0.3), I4, [[20.0]]),
    ),
    "28_feasibility_maps": (
        ["from dataclasses import replace\n\nfrom sosbook.book"],
        {"mass": 1.5, "gamma": 3.0, "u_max": 300.0},
        lambda: sos.design_pid(
            sos.SecondOrderSystem(1.5 * ROBOT.plant.M, *(
                getattr(ROBOT.plant, x) for x in "DSBF")),
            **ROBOT.requirements | dict(
                gamma=sos.HInfinity(3.0, mu=1.0),
                saturation=sos.Saturation(300, ROBOT.saturation.x0))),
    ),
    "22_printed_gains": (
        ["t = np.arange(0, 1.5"], {"R": 20.0, "tilt": 20},
        lambda: sos.design_lqr(polytope(Mip.printed()), I4, [[20.0]]),
    ),
}  # fmt: skip
BAD = {
    "04_lmi_regions": ({"rho": 1, "sigma": 3}, "rho = 1.0 must exceed sigma = 3.0"),
    "17_wing_and_two_masses": ({"tau": 0.1, "mu": 0.3}, "mu = 0.3 exceeds tau = 0.1"),
}


@pytest.fixture(scope="module")
def cell():
    """The widget of a chapter's cell, in a namespace of what it needs."""
    if not BOOK.exists():
        pytest.skip("the package without its book")

    def shown(chapter, starts=None, given=()):
        sources = [
            c.source
            for c in notebooks.read(BOOK / f"{chapter}.ipynb").cells
            if c.cell_type == "code"
        ]
        starts = CELLS[chapter][0] if starts is None else starts
        names = {name: make() for name, make in dict(given).items()}
        needed = [s for s in sources if s.startswith(tuple(starts))] if starts else []
        (kit,) = (s for s in sources if "widgets.sliders(" in s)
        for source in (sources[0], *needed):
            exec(source, names)
        *program, last = ast.parse(kit).body
        exec(compile(ast.Module(program, []), chapter, "exec"), names)
        return eval(compile(ast.Expression(last.value), chapter, "eval"), names)

    return shown


@pytest.mark.parametrize("chapter", by_turns(CELLS, 1))
def test_a_cell_of_the_book_shows_the_package_s_gains(cell, chapter):
    widget, (_, places, package) = cell(chapter), CELLS[chapter]
    for key, value in places.items():
        widget.sliders[key].value = value
    design = package()
    assert widget.result.status == design.status == "feasible"
    assert np.allclose(widget.result.K, design.K, rtol=1e-9)
    assert all(f"<td>{k + 0.0:.4g}</td>" in widget.html for k in design.K.ravel())


def companion(M, D, S):
    """x' = A x of M z'' + D z' + S z = 0."""
    n = len(M)
    left = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), M]])
    right = np.block([[np.zeros((n, n)), np.eye(n)], [-np.array(S), -np.array(D)]])
    return np.linalg.solve(left, right)


def turned(circulation, damping):
    """The largest real part of Example 1's poles."""
    r = ROBOT.plant
    S = (r.S + r.S.T) / 2 + circulation * (r.S - r.S.T) / 2
    return np.linalg.eigvals(companion(r.M, damping * r.D, S)).real.max()


def steady(stiffness):
    """The steady error without an integral: (S - B K_P) e = -S r."""
    r = ROBOT.plant
    S = stiffness * r.S
    return -np.linalg.solve(S - r.B @ ROBOT.K_P, S @ [1, 1])


def late(a, k, h):
    """The rightmost root of x' = a x - k x(t - h), by Lambert's W."""
    return a + (lambertw(-k * h * np.exp(-a * h)) / h).real


def held(T):
    """The largest spectral radius of the PD gain R = 1 on five robots, held for T."""
    middle, radii = Mip.printed(), []
    for robot in (middle, *vertices(middle)):
        p = robot.plant()
        A = companion(p.M, p.D, p.S)
        B = np.vstack([np.zeros((2, 1)), np.linalg.solve(p.M, p.B)])
        both = expm(T * np.block([[A, B], [np.zeros((1, 5))]]))
        loop = both[:4, :4] + both[:4, 4:] @ thesis.mip().gains["PD"][1].K
        radii.append(abs(np.linalg.eigvals(loop)).max())
    return max(radii)


def fallen(load, brake):
    """The pendulum's poles with d and f times a factor each."""
    mip = Mip.printed()
    p = replace(mip, d=load * mip.d, f=brake * mip.f).plant()
    return np.sort(np.linalg.eigvals(companion(p.M, p.D, p.S)).real)


def robust(R):
    """The gain of the robust PID of this weight."""
    return sos.design_lqr(polytope(Mip.printed()), np.eye(5), [[R]], [[0, 1]]).gain


def loud(R):
    """How many volts a radian of tilt asks."""
    return robust(R).K[0, 0]


def chain():
    """What chapter 26's cell needs of its chain, by the printed pendulum."""
    law = SampledLaw.of_gain(robust(20), 0.01)
    return SimpleNamespace(
        mip=Mip.printed(), law=law, robot=SimpleNamespace(blend=0.005)
    )


def holds_while_scaled(widget):
    """Whether the voltage may be scaled as the distance of Nyquist's curve says."""
    volts = widget.sliders["volts"]
    peak = numbers(widget.text)[1]
    for share, stable in ((1.01 / (1 + 1 / peak), 1), (0.99 / (1 - 1 / peak), 1)):
        volts.value = 7.4 * share
        assert (numbers(widget.text)[0] < 1) == stable
    volts.value = 18
    return numbers(widget.text)[0] > 1


def bent(amplitude):
    """By how many percent a sine at resonance of this voltage bends d/c, at most."""
    e, f, d = 30.52, 7.133, 110.6
    return 100 * (amplitude * e / f) ** 2 / (d - f**2 / 4) / 8


def rightmost(flange, friction, sigma):
    """The rightmost pole of chapter 38's shaft, by the pencil of all its angles."""
    stiff = 200 * (2 * np.eye(21) - np.eye(21, k=1) - np.eye(21, k=-1))
    stiff[0, 0] = stiff[20, 20] = 200
    mass, D = np.zeros(21), np.zeros((21, 21))
    at = [3, 7, 10, 13, 17]
    mass[at], D[at, at] = flange, friction
    mass[[0, 20]] = 0.01, 0.02
    D[0, 0], D[20, 20], D[0, 20], D[20, 0] = 0.03, 0.01, -0.01, -0.01
    part = condense(np.diag(mass), D, stiff, np.eye(21)[:, :1]).reduce(rows=[0, 6])
    start = sos.Saturation(300, [0.1, 0.1, 0, 0])
    region = sos.PoleRegion(sigma=sigma, rho=400)
    K = sos.design_pid(part, region=region, saturation=start).K[0]
    D[0, [0, 20]] -= K[2:]
    stiff[0, [0, 20]] -= K[:2]
    one, none = np.eye(21), np.zeros((21, 21))
    A, E = np.block([[none, one], [-stiff, -D]]), np.diag([1] * 21 + [*mass])
    poles = eig(A, E, right=False, homogeneous_eigvals=True)
    real = abs(poles[1]) > 1e-12 * abs(poles[0])
    return (poles[0][real] / poles[1][real]).real.max()


def numbers(text):
    return [float(x) for x in re.findall(r"[-+]?[0-9]+[.][0-9]*", text)]


def observed(widget):
    """Whether each vertex is stable behind the observer of the mean, by eigenvalues."""
    d, C = widget.result, np.eye(3)[1:]
    every = d.plant.vertices
    E, A, B = (np.mean([getattr(v, x) for v in every], 0) for x in ("E", "A", "Bu"))
    copy = np.linalg.solve(E, A + B @ d.K) + d.L @ C
    loops = (
        np.block([[np.linalg.solve(v.E, v.A), np.linalg.solve(v.E, v.Bu) @ d.K],
                  [-d.L @ C, copy]]) for v in every
    )  # fmt: skip
    return max(np.linalg.eigvals(loop).real.max() for loop in loops) < 0


PLANT, PENDULUM = "from sosbook.book import widgets", "from sosbook.pendulum import Mip"
#: For each chapter: what its cell needs, moves, and what must then be said, by
#: eigenvalues, Lambert's W, a matrix exponential or the theorem's own condition.
TRUE = {
    "01_second_order_systems": (
        ["robot = sos", "S_sym", PLANT], [
            (dict(circulation=c, damping=d), lambda w, c=c, d=d: np.isclose(
                numbers(w.text)[0], turned(c, d), atol=1e-3))
            for c, d in ((1, 1), (2, 1), (2, 4))],
    ),
    "02_descriptor_form": (
        [PLANT], [
            (dict(integral=i, stiffness=s), lambda w, i=i, s=s: np.allclose(
                numbers(w.text), steady(s) if i == 0 else 0, atol=1e-3))
            for i, s in ((0, 2), (1, 2), (0, 0.5))],
    ),
    "03_lmis": (
        [PLANT], [
            (dict(stiffness=s, damping=d), lambda w, s=s, d=d: (
                w.text.startswith("feasible") == (min(s, d) > 0)))
            for s, d in ((1, 1), (-0.5, 1), (1, -0.5))],
    ),
    "08_zero_mass": (  # the third body weighs 1 kg, and nothing pushes it
        [PLANT], [
            (dict(m4=m, beta=b), lambda w, b=b: (
                "K_A" in w.html if b < 1 else "K_A" not in w.html))
            for m, b in ((0, 0.9), (0.5, 0.2), (0, 1.1))],
    ),
    "09_between_two_plants": (
        ["driven = ", PLANT], [
            (dict(spread=s, rho=10), lambda w, says=says: (
                f"pairs: {says}" in w.text))
            for s, says in ((1, "infeasible"), (0.4, "feasible"))],
    ),
    "29_how_far_to_trust": (
        [PLANT], [
            (dict(mass=1, sigma=s, digits=d), lambda w, yes=yes: (
                w.text.endswith(str(yes))))
            for s, d, yes in ((0.7, 2, True), (3.4, 2, False), (3.4, 12, True))],
    ),
    "15_delay": (
        [PLANT], [
            (dict(a=a, k=k, h=h), lambda w, a=a, k=k, h=h: np.isclose(
                numbers(w.text)[0], late(a, k, h), atol=1e-3))
            for a, k, h in ((0, 1, 1.5), (0, 1, 1.6), (0.5, 1, 0.3))],
    ),
    "19_observer": (
        ["C = np.array", "push = 2", "from sosbook.book import widgets"], [
            (dict(spread=0.04, gyro=0.03), observed),
            (dict(encoder=2.0), observed),
            (dict(spread=0.2), lambda w: w.result.L is None)],
    ),
    "20_pendulum": (
        [PENDULUM, "from dataclasses import replace", PLANT], [
            (dict(load=x, brake=f), lambda w, x=x, f=f: np.allclose(
                numbers(w.text), fallen(x, f), atol=6e-3))
            for x, f in ((1, 1), (2.5, 0.5))],
    ),
    "21_rig_to_model": (
        ["truth = ", PLANT], [
            (dict(amplitude=a, friction=0), lambda w, a=a: (
                0.6 < -numbers(w.text)[0] / bent(a) < 1
                and abs(numbers(w.text)[1]) < 0.01)) for a in (0.25, 0.6)],
    ),
    "24_on_the_desk": (  # the voltage is largest at the first tick
        ["def design(R)", "def hold", "import ipywidgets"], [
            (dict(R=R, tilt=t), lambda w, R=R, t=t: (
                np.isclose(numbers(w.text)[0], np.radians(t) * loud(R), atol=0.1)
                and numbers(w.text)[1] < 1)) for R, t in ((20, 8), (100, 5))],
    ),
    "10_a_p_for_each_plant": (  # a common P ends by the circle criterion
        [PLANT], [
            (dict(spread=s, damping=d), lambda w, s=s, d=d: w.text.split("\n") == [
                f"pairs: {'in' * int(np.sqrt(1 + s) - np.sqrt(1 - s) > d)}feasible",
                "slack: feasible"])
            for s, d in ((0.19, 0.2), (0.21, 0.2), (0.45, 0.5), (0.55, 0.5))],
    ),
    "25_program": (  # the voltage is largest at the first tick, or at its limit
        ["T, mip = ", PLANT], [
            (dict(limit=u, tilt=t), lambda w, u=u, t=t, end=end: (
                w.text.startswith(end) and np.isclose(
                    numbers(w.text)[0], min(u, np.radians(t) * loud(20)), atol=0.01)))
            for u, t, end in (
                (7.4, 10, "stands"), (3, 20, "stands"), (3, 40, "falls"))],
    ),
    "26_logs_to_c_file": (
        ["from sosbook.book import widgets\n\nlaw"], [({}, holds_while_scaled)],
        {"chain": chain},
    ),
    "30_inside_the_solver": (
        [PLANT], [
            (dict(damping=d, sigma=x * d), lambda w, x=x: (
                w.text.startswith("feasible") == (x < 0.5)))
            for d, x in ((0.4, 0.2), (0.4, 0.49), (0.4, 0.51), (1.5, 0.6))],
    ),
    "36_any_controller": (  # a worse encoder never helps, a second one never hurts
        ["(d,) = desc", "def sensor", "X, Y, g", "def least", "best = "], [
            (dict(motor=m, load=n), lambda w, bound=bound: (
                w.result and bound(*map(float, re.findall(r"[0-9.]+", w.text)))))
            for m, n, bound in (
                (0.01, 0.1, lambda a, b, c: c <= a < b),
                (0.1, 0.01, lambda a, b, c: c <= b < a),
                (0.001, 0.001, lambda a, b, c: c <= min(a, b)))],
    ),
    "38_model_from_somewhere_else": (
        ["NODES, FLANGES", "def design"], [
            (dict(zip(("flange", "friction", "sigma"), x)), lambda w, x=x: np.isclose(
                numbers(w.text)[0], rightmost(*x), atol=1e-3))
            for x in ((2e-4, 1e-4, 20), (2e-4, 1e-4, 40), (1e-3, 1e-4, 20))],
    ),
    "23_gains_to_samples": (
        ["from dataclasses import replace\n\nfrom sosbook.book"], [
            (dict(T=T, ticks=0, coupling=1), lambda w, T=T: np.isclose(
                numbers(w.text)[0], held(T), atol=1e-3)) for T in (0.01, 0.04)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("chapter", by_turns(TRUE, 1))
def test_a_moved_cell_says_what_is_true_there(cell, chapter):
    starts, moves, *given = TRUE[chapter]
    widget = cell(chapter, starts, *given)
    for places, holds in moves:
        for key, value in places.items():
            widget.sliders[key].value = value
        assert holds(widget), (places, widget.text)


@pytest.mark.parametrize("chapter", by_turns(BAD, 0))
def test_what_cannot_be_asked_is_said_where_the_picture_was(cell, chapter):
    widget, (places, words) = cell(chapter), BAD[chapter]
    for key, value in places.items():
        widget.sliders[key].value = value
    assert words in widget.text and widget.result is None
    for key, slider in cell(chapter).sliders.items():
        widget.sliders[key].value = slider.value
    assert widget.result.status == "feasible"


def moved(**ranges):
    return widgets.sliders(lambda sigma, theta: f"{sigma:g}, {theta:.3f}", **ranges)


def test_names_units_and_scales():
    widget = moved(sigma=(0.01, 0.1, 1), theta=np.radians([15, 45, 90]))
    sigma, theta = widget.sliders.values()
    assert sigma.description == "Decay rate σ (1/s)" and theta.description.endswith(
        "°)"
    )
    assert isinstance(sigma, ipywidgets.FloatLogSlider)
    assert np.isclose([sigma.min, sigma.max], [-2, 0]).all() and theta.max == 90
    theta.value = 60
    assert widget.values == {"sigma": 0.1, "theta": np.radians(60)}
    assert widget.text == "0.1, 1.047"


def test_any_widget_with_a_value_will_do():
    angle = ipywidgets.Dropdown(options=[1.0, 2.0])
    widget = moved(sigma=(0, 1, 2), theta=angle)
    angle.value = 2.0
    assert widget.text == "1, 2.000"


def test_where_no_kernel_runs_there_is_html_and_text():
    def both(x):
        print("a < b")
        return sos.design_pid(ROBOT.plant, region=sos.PoleRegion(x))

    bundle = widgets.sliders(both, x=(0.1, 0.5, 1))._repr_mimebundle_()
    assert bundle["text/html"].startswith('<div class="sos-moved"><pre>a &lt; b</pre>')
    assert 'class="sos-result"' in bundle["text/html"]
    assert bundle["text/plain"].startswith("a < b\n<Design: feasible")
    assert notebooks.WIDGET in bundle


def test_a_function_that_fails_at_a_move_is_named_and_at_the_start_raises():
    def inverse(x):
        return f"{1 / x:g}"

    widget = widgets.sliders(inverse, x=(0, 1, 2))
    widget.sliders["x"].value = 0
    assert widget.text == "ZeroDivisionError: float division by zero"
    widget.sliders["x"].value = 2
    assert widget.text == "0.5"
    with pytest.raises(ZeroDivisionError):
        widgets.sliders(inverse, x=(0, 0, 2))


@pytest.mark.parametrize(
    "ranges, words",
    [
        ({"sigma": (0, 1, 2)}, "missing a required argument: 'theta'"),
        ({"rho": (0, 1, 2)}, "a range for each argument"),
        ({"sigma": (0, 1), "theta": (0, 1, 1.5)}, "sigma must be .low, start, high"),
        ({"sigma": (0, 3, 2), "theta": (0, 1, 1.5)}, "sigma must be"),
        ({"sigma": (0, 0, 0), "theta": (0, 1, 1.5)}, "sigma must be"),
        ({"sigma": 1.0, "theta": (0, 1, 1.5)}, "sigma must be"),
        ({"sigma": (0, 1, np.inf), "theta": (0, 1, 1.5)}, "sigma must be"),
        ({"sigma": (0, 1, 2), "theta": (15, 45, 90)}, "theta is a half-angle in rad"),
    ],
)
def test_bad_ranges_are_named(ranges, words):
    with pytest.raises(ValueError, match=words):
        moved(**ranges)
