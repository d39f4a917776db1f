"""Move beta: which mass does acceleration feedback make?"""

import numpy as np

from ...display.escape import page_text
from ...runtime.libraries import library
from ...synthesis.regularization import regularize
from ..elements.chart import Chart
from ..plots import BLUE, GREEN, GREY, window_of
from .charts import plane
from .explorer import Explorer, log, note, page

ipywidgets = library("ipywidgets")


__all__ = ["explore_regularization"]


def explore_regularization(plant, beta=0.1):
    """Move beta; see the mass M - B K_A, its poles and K_A.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant; of a polytope, every vertex is drawn.
    beta : float
        Where the slider starts.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    sliders = {
        "beta": log("beta", beta, 100, 100),
        "choose": ipywidgets.ToggleButtons(
            options=["centre", "least norm"],
            description="choose",
            style={"description_width": "11em"},
        ),
    }
    before = np.concatenate([v.poles() for v in plant.vertices])

    def draw(beta, choose):
        regular = regularize(plant, beta, choose=choose)
        if regular.status != "feasible":
            yield note(f"<strong>{regular.status}</strong>.")
            yield note(
                f"<strong>{regular.status}</strong>. {page_text(regular.advice)}"
            )
            return
        loops = regular.regular.vertices
        poles = np.concatenate([v.poles() for v in loops])
        message = (
            f"<strong>feasible</strong>. Asked for: above beta² = "
            f"{beta**2:.3g}; reached: {regular.bound:.3g}. Fastest pole of "
            f"the plant with K_A: {np.abs(poles).max():.4g} rad/s. "
            "Circles: without K_A, crosses: with it."
        )
        yield note(message, BLUE) + page(
            _mass_chart(plant.vertices, loops, beta),
            _pole_chart(before, poles),
            _gain_table(regular.K_A),
        )

    return Explorer(sliders, draw)


def _mass_chart(without, loops, beta):
    """Eigenvalues of the symmetric part of the mass."""
    n = without[0].n
    place = np.arange(1, n + 1)
    levels = [
        [np.linalg.eigvalsh((v.M + v.M.T) / 2) for v in plants]
        for plants in (without, loops)
    ]
    low, high = min(0, np.min(levels)), max(np.max(levels), beta**2)
    room = 0.06 * (high - low)
    chart = Chart(
        (0.5, n + 0.5),
        (low - room, high + room),
        "eigenvalue number",
        "mass",
        "Eigenvalues of the symmetric part of the mass",
    )
    chart.line([0.5, n + 0.5], [beta**2] * 2, GREEN, True, "beta²")
    for plants, colour, shape in zip(levels, (GREY, BLUE), ("circle", "cross")):
        for values in plants:
            chart.marks(place, values, colour, shape)
    return chart.svg()


def _pole_chart(before, poles):
    """Poles without and with K_A; what is far out is left out."""
    far = 30 * np.median(np.abs(np.concatenate([before, poles])))
    near = poles[np.abs(poles) <= far]
    before = before[np.abs(before) <= far]
    window = window_of([before, near])
    chart = plane(window, "Poles of the plant without and with K_A", axis=True)
    chart.marks(before.real, before.imag, GREY, "circle")
    chart.marks(near.real, near.imag, BLUE, "cross")
    return chart.svg()


def _gain_table(K_A):
    rows = "".join(
        "<tr>"
        + "".join(
            f"<td style='padding:0 .6em;text-align:right'>{k:.4g}</td>" for k in row
        )
        + "</tr>"
        for row in K_A
    )
    return f"<table class='gains'><caption>K_A</caption>{rows}</table>"
