"""Sliders over a function: the cells of the book, and what is refused."""

import ast

import ipywidgets
import numpy as np
import pytest

import sosbook as sos
from sosbook.book import notebooks, thesis, widgets
from sosbook.book.notebooks import BOOK
from sosbook.pendulum import Mip, polytope

I4 = np.eye(4)
ROBOT, WING = thesis.example_1(), thesis.delay_example_1(published=True)
REGION = sos.PoleRegion(1.0, np.radians(60), 8)
ALL = ROBOT.requirements | {"region": REGION}
MOVED = {"sigma": 1.0, "theta": 60, "rho": 8}
#: For each chapter: what its cell needs, where the sliders go, the package's answer.
CELLS = {
    "04_lmi_regions": (
        [], MOVED, lambda: sos.design_pid(ROBOT.plant, ROBOT.U, region=REGION),
    ),
    "07_grasping_robot": (
        ["U = np.eye(2)\nwanted"], MOVED, lambda: sos.design_pid(ROBOT.plant, **ALL),
    ),
    "21_delay_examples": (
        [], {"tau": 0.15, "mu": 0.05, "delta": 0.2},
        lambda: sos.design_delay_pid(
            WING.plant, **WING.requirements | dict(tau=0.15, mu=0.05, delta=0.2)),
    ),
    "23_lqr": (
        [], {"R": 20.0, "spread": 30},
        lambda: sos.design_lqr(polytope(Mip.printed(), 0.3), I4, [[20.0]]),
    ),
    "27_pendulum_control": (
        ["t = np.arange(0, 1.5"], {"R": 20.0, "tilt": 20},
        lambda: sos.design_lqr(polytope(Mip.printed()), I4, [[20.0]]),
    ),
}  # fmt: skip
BAD = {
    "04_lmi_regions": ({"rho": 1, "sigma": 3}, "rho = 1.0 must exceed sigma = 3.0"),
    "21_delay_examples": ({"tau": 0.1, "mu": 0.3}, "mu = 0.3 exceeds tau = 0.1"),
}


@pytest.fixture(scope="module")
def cell():
    """The widget of a chapter's cell, in a namespace of what it needs."""
    if not BOOK.exists():
        pytest.skip("the package without its book")

    def shown(chapter):
        sources = [
            c.source
            for c in notebooks.read(BOOK / f"{chapter}.ipynb").cells
            if c.cell_type == "code"
        ]
        starts, names = CELLS[chapter][0], {}
        needed = [s for s in sources if s.startswith(tuple(starts))] if starts else []
        (kit,) = (s for s in sources if "widgets.sliders(" in s)
        for source in (sources[0], *needed):
            exec(source, names)
        *program, last = ast.parse(kit).body
        exec(compile(ast.Module(program, []), chapter, "exec"), names)
        return eval(compile(ast.Expression(last.value), chapter, "eval"), names)

    return shown


@pytest.mark.parametrize("chapter", CELLS)
def test_a_cell_of_the_book_shows_the_package_s_gains(cell, chapter):
    widget, (_, places, package) = cell(chapter), CELLS[chapter]
    for key, value in places.items():
        widget.sliders[key].value = value
    design = package()
    assert widget.result.status == design.status == "feasible"
    assert np.allclose(widget.result.K, design.K, rtol=1e-9)
    assert all(f"<td>{k + 0.0:.4g}</td>" in widget.html for k in design.K.ravel())


@pytest.mark.parametrize("chapter", BAD)
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
