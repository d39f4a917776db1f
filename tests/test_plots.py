"""Figures: alternative text, the same bytes twice, and true to their data."""

import re
import xml.etree.ElementTree as tree

import matplotlib

matplotlib.use("agg")

import matplotlib.pyplot as plt
import numpy as np
import pytest

import sosbook as sos
from sosbook.book import plots, thesis


@pytest.fixture(autouse=True)
def style():
    with plt.rc_context():
        plots.use_book_style()
        yield
    plt.close("all")


@pytest.fixture(scope="module")
def design():
    robot = thesis.example_1()
    return sos.design_pid(robot.plant, **robot.requirements)


@pytest.fixture
def ax():
    return plt.subplots()[1]


def response(design):
    t = np.linspace(0, 8, 401)
    wind = sos.Sine(5, 2, start=3, stop=6)
    return plots.response(design.simulate(t, r=[1, 0.5], w=wind), 150)


def others(design):
    everything, (a, b, c) = plt.subplots(1, 3)
    plots.margins(a, design.margins)
    plots.singular_values(b, design.closed_loop()[:2, :2], gamma=1.257)
    plots.ellipsoid(c, design.P, (0, 2), x0=design.request.saturation.x0)
    return everything


PICTURES = {  # one figure of each kind
    "poles": lambda design: plots.pole_map(design.poles(), design.request.region),
    "response": response,
    "others": others,
}


@pytest.mark.parametrize("alt", [None, "", "  ", 3])
def test_a_figure_without_alternative_text_is_refused(alt):
    with pytest.raises(ValueError, match="alt is missing"):
        plots.show(plt.figure(), alt=alt)


@pytest.mark.slow
def test_the_output_does_not_depend_on_the_reader_s_settings(design):
    expected = plots.show(plots.pole_map(design.poles()), alt="poles").html
    plt.rcParams["svg.fonttype"] = "none"
    plt.rcParams["svg.hashsalt"] = None
    assert plots.show(plots.pole_map(design.poles()), alt="poles").html == expected


@pytest.mark.slow
@pytest.mark.parametrize("kind", PICTURES)
def test_an_output_is_small_accessible_svg_without_a_date(design, kind):
    page = plots.show(PICTURES[kind](design), alt='A <b> & "c"', caption="1 < 2").html
    assert len(page) < 60_000
    figure = tree.fromstring(page)  # well formed
    svg = figure[0]
    assert figure.tag == "figure" and figure.get("class") == "sos-figure"
    assert svg.get("role") == "img"
    assert svg.get("aria-label") == 'A <b> & "c"'
    assert "width:100%" in svg.get("style")
    assert not svg.get("width") and svg.get("viewBox")
    assert figure[1].tag == "figcaption" and figure[1].text == "1 < 2"
    for word in ("<metadata", "<style", "<!--", "<?xml", "dc:date", "<text", "-0 "):
        assert word not in page
    assert "NaN" not in page and "nan" not in page
    ids = re.findall(r'\sid="([^"]+)"', page)
    wanted = re.findall(r'(?:href="#|url\(#)([^")]+)', page)
    assert ids and len(set(ids)) == len(ids)
    assert set(wanted) == set(ids)


def test_two_figures_of_a_page_share_no_id(design):
    drawn = (plots.show(plots.pole_map(design.poles()), alt=alt) for alt in "12")
    first, second = (set(re.findall(r'\sid="([^"]+)"', x.html)) for x in drawn)
    assert not first & second


def test_show_closes_the_figure():
    figure = plt.figure()
    plots.show(figure, alt="nothing")
    assert not plt.fignum_exists(figure.number)


def test_poles_are_drawn_where_they_are(ax, design):
    poles = design.poles()
    plots.poles(ax, {"open": [-1 + 1j], "closed": poles}, region=design.request.region)
    drawn = {line.get_label(): line for line in ax.lines}
    assert np.array_equal(drawn["closed"].get_xdata(), poles.real)
    assert np.array_equal(drawn["closed"].get_ydata(), poles.imag)
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert words == ["D-region", "open", "closed"]


REGIONS = {
    "thesis": sos.PoleRegion(sigma=0.7, theta=np.pi / 4, rho=5),
    "half-plane": sos.PoleRegion(sigma=1),
    "disk off centre": sos.LMIRegion.disk(2, centre=-3),
    "ellipse": sos.LMIRegion.ellipse(-3, 2, 1),
    "strips": (sos.LMIRegion.strip(-4, -1) & sos.LMIRegion.horizontal_strip(2)),
    "unusual": sos.LMIRegion(
        [[-1, 0.3], [0.3, -2]], [[0.2, 1], [-0.4, 0.5]], "unusual"
    ),
}


@pytest.mark.parametrize("name", REGIONS)
def test_the_outline_is_the_boundary(name):
    region, window = REGIONS[name], (-8.0, 2.0, 5.0)
    outline = plots.region_outline(region, window)
    assert len(outline) > 100
    distance = np.min(list(region.distances(outline).values()), axis=0)
    left, right, height = window
    edge = np.minimum.reduce(
        [outline.real - left, right - outline.real, height - np.abs(outline.imag)]
    )
    assert np.abs(np.minimum(distance, edge)).max() < 1e-6
    middle = outline.mean()
    assert region.contains(middle + 0.99 * (outline - middle))


def test_a_region_outside_the_window_has_no_outline():
    assert not plots.region_outline(sos.LMIRegion.half_plane(20), (-5, 1, 3)).size


def test_a_response_shows_each_channel_and_the_limit(design):
    t = np.linspace(0, 8, 401)
    answer = design.simulate(t, r=[1, 0.5])
    axes = plots.response(answer, u_max=150).axes
    panels = {ax.get_ylabel().split()[0]: ax for ax in axes}
    first, second = panels["position"].lines
    assert first.get_ydata()[-1] == answer.z[0, -1]
    assert second.get_ydata()[-1] == answer.z[1, -1]
    words = [text.get_text() for text in panels["input"].get_legend().get_texts()]
    assert words == ["u₁", "u₂", "‖u‖", "u_max"]
    norm = panels["input"].lines[2].get_ydata()
    assert np.isclose(norm[0], np.linalg.norm(answer.u[:, 0]))


def test_margins_show_the_smallest_of_a_polytope_and_violations(ax):
    plots.margins(ax, {"P": 0.5, "disk 1": 0.2, "disk 1,2": -0.1})
    names = [label.get_text() for label in ax.get_yticklabels()]
    assert names == ["P > 0", "disk ρ"]
    words = [text.get_text() for text in ax.texts]
    assert words == ["5.0e-01", "violated by 1.0e-01"]
    assert ax.get_xscale() == "log"


def test_the_singular_value_curve_peaks_at_the_norm(ax, design):
    plots.singular_values(ax, design.closed_loop()[:2, :2], gamma=1.257)
    curve, bound = ax.lines
    assert np.isclose(curve.get_ydata().max(), design.hinf(), rtol=1e-2)
    assert set(bound.get_ydata()) == {1.257}


def test_the_ellipse_is_the_shadow_of_the_ellipsoid(design):
    i, j = 0, 3
    outline = plots.ellipse_outline(design.P, (i, j))
    for corner in outline.T[::10]:
        # smallest x' P^-1 x over all x with this shadow is 1
        block = design.P[np.ix_((i, j), (i, j))]
        assert np.isclose(corner @ np.linalg.solve(block, corner), 1)
    assert np.isclose(np.abs(outline[0]).max(), np.sqrt(design.P[i, i]), rtol=1e-3)


def test_signals_come_one_row_a_channel(ax):
    t = np.linspace(0, 1, 5)
    plots.signal(ax, t, np.array([t, 2 * t]))
    assert [line.get_ydata()[-1] for line in ax.lines] == [1, 2]
    with pytest.raises(ValueError, match="one row a channel"):
        plots.signal(ax, t, np.array([t, 2 * t]).T)
