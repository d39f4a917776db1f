"""Watch the solver take its steps."""

import numpy as np

from ...runtime.libraries import library
from ...solver.centre import Blocks, centre, phase_one
from ...synthesis.problem import Request
from ...synthesis.scaling import Frame
from ..elements.chart import Chart
from ..plots import BLUE, GREEN, ORANGE
from .explorer import Explorer, page

ipywidgets = library("ipywidgets")


__all__ = ["explore_steps"]


def explore_steps(build, sizes):
    """Choose a size: phase one and the walk to the centre, step by step.

    Each step is drawn when the solver has taken it.

    Parameters
    ----------
    build : callable
        A function of a size that gives a plant and a dict of requirements, as
        keywords of `design_pid`, for which there is a design.
    sizes : sequence of int
        The sizes to choose from, two or more.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    return _Steps(build, sizes)


class _Steps(Explorer):
    """The explorer that changes its picture with each step."""

    def __init__(self, build, sizes):
        self.build = build
        super().__init__(
            {
                "masses": ipywidgets.SelectionSlider(
                    options=list(sizes),
                    value=sizes[len(sizes) // 2],
                    description="masses",
                    continuous_update=False,
                    layout=ipywidgets.Layout(width="min(40em, 95%)"),
                )
            },
            self.draw,
        )

    def draw(self, masses):
        plant, requirements = self.build(masses)
        request = Request(plant, **requirements)
        named, unknowns = request.in_unknowns(Frame.of(request))
        blocks = Blocks.of(named.values(), unknowns)
        raised, walked = [], []

        def show(end=""):
            return _page(blocks.variables, raised, walked, end)

        def drawn(steps):
            def watch(step):
                steps.append(step)
                self.picture.value = show()

            return watch

        yield show()
        phase = phase_one(blocks, watch=drawn(raised))
        if phase.x is None:
            yield show(f"{phase.verdict}: no centre to walk to")
            return
        centre(blocks, phase.x, watch=drawn(walked))
        yield show("at the centre")


def _page(variables, raised, walked, end):
    last = max(10, len(raised) + len(walked))
    fall = Chart(
        (0, last),
        (-9, 3),
        "step",
        "gap, decrement",
        "The gap of phase one, then the decrement",
        log=True,
    )
    first = np.arange(1, len(raised) + 1)
    second = len(raised) + np.arange(1, len(walked) + 1)
    for x, steps, key, colour in (
        (first, raised, "gap", BLUE),
        (second, walked, "decrement", GREEN),
    ):
        y = np.log10(np.clip([s[key] for s in steps], 1e-9, 1e3))
        fall.line(x, y, colour, name=key)
        fall.marks(x, y, colour, "circle")
    products = [sum(s["iterations"]) for s in raised + walked]
    work = Chart(
        (0, last),
        (0, max(20, *products, 1)),
        "step",
        "products of conjugate gradients",
        "Products of conjugate gradients in each step",
    )
    for step, count in enumerate(products, 1):
        x = step + np.array([-0.3, 0.3, 0.3, -0.3])
        work.polygon(x, count * np.array([0, 0, 1, 1]), ORANGE)
    way = (
        "conjugate gradients"
        if any(products)
        else "a dense matrix, no conjugate gradients"
    )
    message = (
        f"<strong>{variables}</strong> variables. Phase one: "
        f"<strong>{len(raised)}</strong> steps, then "
        f"<strong>{len(walked)}</strong> of Newton's to the centre"
        + (f", with {way}" if walked else "")
        + f". {end}"
    )
    return page(fall.svg(), work.svg(), f"<p>{message}</p>")
