"""Move between two vertices."""

import numpy as np

from ...plants.descriptor import descriptors
from ..plots import BLUE, GREY, window_of
from .charts import plane
from .explorer import Explorer, linear, page

__all__ = ["explore_segment"]


def explore_segment(plants, P):
    """Move between two uncontrolled vertices that share a P.

    Parameters
    ----------
    plants : Polytope
        A polytope of two vertices.
    P : (2n, 2n) array
        Satisfies the stability LMI at both.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    if plants.N != 2:
        raise ValueError(f"plants has {plants.N} vertices, needs two")
    weights = np.linspace(0, 1, 41)
    every = np.concatenate([plants.at([1 - a, a]).poles() for a in weights])
    window = window_of([every])
    sliders = {"weight": linear("weight of the second vertex", 0.0, 0, 1)}

    def draw(weight):
        plant = plants.at([1 - weight, weight])
        poles = plant.poles()
        (d,) = descriptors(plant)
        lyapunov = d.A @ P @ d.E.T
        top = np.linalg.eigvalsh(lyapunov + lyapunov.T)[-1]
        chart = plane(window, "Poles between the vertices", axis=True)
        chart.marks(every.real, every.imag, GREY, "circle")
        chart.marks(poles.real, poles.imag, BLUE, "cross")
        verdict = "stable" if poles.real.max() < 0 else "UNSTABLE"
        yield page(
            chart.svg(),
            (
                f"<div><p>The plant is <strong>{verdict}</strong>: largest real "
                f"part {poles.real.max():+.2f}.</p><p>Largest eigenvalue of "
                f"the stability LMI with this P: {top:+.2f}.</p></div>"
            ),
        )

    return Explorer(sliders, draw)
