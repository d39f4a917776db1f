"""Choose the integrators while a parameter moves a zero through s = 0."""

import numpy as np

from ...display.escape import page_text
from ...runtime.libraries import library
from ...synthesis.integrators import admissible_U
from ..elements.chart import Chart
from ..plots import BLUE, COLOURS, VERMILLION
from .charts import set_point_chart
from .explorer import Explorer, Follower, gains_table, linear, note, page

ipywidgets = library("ipywidgets")


__all__ = ["explore_integrators"]


def explore_integrators(family, value, low, high, region=None, name="parameter"):
    """Choose the channels and move a parameter of the plant.

    Parameters
    ----------
    family : callable
        Makes a SecondOrderSystem of a number.
    value, low, high : float
        Where the slider starts, and its range.
    region : PoleRegion, optional
        What each design is asked for.
    name : str
        The parameter's name, with its unit.

    Returns
    -------
    Explorer
        ``sliders["channels"]`` is a drop-down list, ``sliders["value"]``
        the parameter.
    """
    grid = np.linspace(low, high, 41)
    every = [_distances(family(x)) for x in grid]
    choices = {_name(channels): channels for channels in every[0]}
    curves = {
        channels: np.array([distances[channels] for distances in every])
        for channels in choices.values()
    }
    sliders = {
        "channels": ipywidgets.Dropdown(
            options=choices,
            description="integrate",
            style={"description_width": "11em"},
        ),
        "value": linear(name, value, low, high),
    }

    follow = {channels: Follower() for channels in choices.values()}

    def draw(channels, value):
        plant = family(value)
        U = np.eye(plant.n)[list(channels)]
        (choice,) = admissible_U(plant, [U])
        chart = Chart(
            (low, high),
            (0, 1.05 * max(map(np.max, curves.values()))),
            name,
            "distance",
            "Distance from inadmissible",
        )
        for k, (one, curve) in enumerate(curves.items()):
            chart.line(
                grid, curve, COLOURS[k % len(COLOURS)], one != channels, _name(one)
            )
        chart.marks([value], [choice.distance], VERMILLION, "circle")
        try:
            design = follow[channels](plant, U, region=region)
        except ValueError as error:
            message = f"<strong>inadmissible</strong>. {page_text(str(error))}"
            yield note(message) + page(chart.svg())
            return
        message = (
            f"<strong>admissible</strong>, distance "
            f"{choice.distance:.3g}; the design is {design.status}."
        )
        if design.status != "feasible":
            yield note(message) + page(chart.svg())
            return
        yield note(message, BLUE) + page(
            chart.svg(), _answer(design, channels), gains_table(design)
        )

    return Explorer(sliders, draw)


def _distances(plant):
    return {
        c.channels: c.distance
        for c in sorted(admissible_U(plant), key=lambda c: c.channels)
    }


def _name(channels):
    return ", ".join(f"z{k + 1}" for k in channels)


def _answer(design, channels):
    """All displacements, from rest to one in the channels."""
    plant = design.request.plant
    U = np.eye(plant.n)[list(channels)]
    R = np.block([[-plant.S, plant.B], [U, np.zeros((len(U), plant.m))]])
    goal = np.r_[np.zeros(plant.n), np.ones(len(U))]
    r = np.linalg.lstsq(R, goal, rcond=None)[0][: plant.n]
    end = float(f"{min(10 / -design.poles().real.max(), 60):.1g}")
    t = np.linspace(0, end, 161)
    z = design.simulate(t, r=r).z
    chart = set_point_chart(end, z)
    for k, row in enumerate(z):
        chart.line(t, row, COLOURS[k % len(COLOURS)], k not in channels, f"z{k + 1}")
    return chart.svg()
