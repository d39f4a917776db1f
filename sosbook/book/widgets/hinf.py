"""Move an H-infinity bound."""

import numpy as np

from ...synthesis.pid import analyse_pid
from ..elements.chart import Chart
from ..plots import BLUE, GREEN, VERMILLION, largest_singular_value
from .explorer import Explorer, log, margins_table, page

__all__ = ["explore_hinf"]


def explore_hinf(plant, K, U=None, gamma=None):
    """Move gamma and see whether one P proves the bound, and the norm itself.

    Parameters
    ----------
    plant : SecondOrderSystem
        The plant, with its ``F``.
    K : (m, N) array_like
        The gain that is analysed.
    U : (a, n) array_like, optional
        The rows of U z are integrated; without it the law is PD.
    gamma : float, optional
        Where the slider starts; twice the norm without it.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    design = analyse_pid(plant, K, U)
    norm = design.hinf()
    loop = design.closed_loop()
    p, n = plant.p, plant.n
    moduli = np.abs(loop.poles())
    grid = np.geomspace(moduli.min() / 30, moduli.max() * 30, 200)
    curve = largest_singular_value(
        loop.A, loop.B[:, :p], loop.C[:n], loop.D[:n, :p], grid
    )
    sliders = {"gamma": log("bound gamma", gamma or 2 * norm, 10, 10)}

    def draw(gamma):
        analysed = analyse_pid(plant, K, U, gamma=gamma)
        chart = Chart(
            np.log10(grid[[0, -1]]),
            np.log10([norm / 1e3, norm * 30]),
            "frequency (rad/s)",
            "largest singular value",
            "Gain from w to z over the frequency",
            log=True,
        )
        feasible = analysed.status == "feasible"
        colour = GREEN if feasible else VERMILLION
        edge = np.log10(grid[[0, -1]])
        chart.line(np.log10(grid), np.log10(curve), BLUE, name="gain")
        chart.line(edge, np.log10([gamma] * 2), colour, True, "gamma")
        message = (
            f"The LMI is <strong>{analysed.status}</strong> at gamma = "
            f"{gamma:.4g}. The norm is {norm:.4g}."
        )
        margin = margins_table(analysed.margins) if feasible else ""
        yield page(chart.svg(), f"<div><p>{message}</p>{margin}</div>")

    return Explorer(sliders, draw)
