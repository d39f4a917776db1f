"""What robots did: tilt, wheels and voltage over time."""

import numpy as np

from ...runtime.libraries import library
from .style import COLOURS, DASHES, GREY, VERMILLION, legend_above

plt = library("matplotlib.pyplot")


__all__ = ["robot_run"]

PANELS = {
    "theta": ("tilt θ (degrees)", lambda run: np.degrees(run.x[0])),
    "phi": ("wheels φ (rad)", lambda run: run.x[1]),
    "rate": ("wheels φ′ (rad/s)", lambda run: run.x[3]),
    "V": ("voltage V (V)", lambda run: run.V),
    "error": ("error of θ (degrees)", lambda run: np.degrees(run.estimate - run.x[0])),
}


def robot_run(run, names=None, panels=("theta", "V"), figsize=None):
    """Time histories of the robots of a run, one panel a quantity.

    Parameters
    ----------
    run : sosbook.pendulum.simulator.Run
        The simulated run.
    names : sequence of str, optional
        Names of the robots, for the legend; numbers without it, and no legend
        for a single robot.
    panels : sequence of {"theta", "phi", "rate", "V", "error"}
        "error" is the estimated tilt less the true one. The voltage
        is a staircase, between its limits.
    figsize : (float, float), optional
        In inches.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.

    Raises
    ------
    ValueError
        If a panel isn't known, or names aren't one for each robot.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> from sosbook.pendulum import Firmware, Mip, SampledLaw
    >>> from sosbook.pendulum.simulator import simulate
    >>> law = SampledLaw.of_gain(thesis.mip().gains["PD"][5], 0.01)
    >>> run = simulate(Mip.printed(), Firmware(law), 0.1, t_end=0.2)
    >>> figure = robot_run(run, panels=["theta", "phi", "V"])
    >>> [ax.get_ylabel() for ax in figure.axes]
    ['tilt θ (degrees)', 'wheels φ (rad)', 'voltage V (V)']
    >>> plt.close(figure)
    """
    runs = run.V.shape[0]
    names = [f"{k + 1}" for k in range(runs)] if names is None else names
    if len(names) != runs:
        raise ValueError(f"names has {len(names)} entries, needs {runs}")
    panels = tuple(panels)
    for panel in panels:
        if panel not in PANELS:
            raise ValueError(f"panels has {panel!r}; choose from {', '.join(PANELS)}")
    figure, axes = plt.subplots(
        1,
        len(panels),
        squeeze=False,
        sharex=True,
        figsize=figsize or ((4.6, 2.5) if len(panels) == 1 else (6.8, 2.5)),
    )
    for ax, panel in zip(axes.flat, panels):
        label, values = PANELS[panel]
        volts = panel == "V"
        ax.axhline(0, color=GREY, linewidth=0.7, linestyle="-")
        for k, row in enumerate(values(run)):
            ax.plot(
                run.t,
                row,
                color=COLOURS[k % 6],
                linestyle=DASHES[k % 6],
                label=names[k],
                drawstyle="steps-post" if volts else "default",
            )
        if volts:
            for limit in (-run.limit, run.limit):
                ax.axhline(
                    limit, color=VERMILLION, linewidth=1.2, linestyle=(0, (1, 1))
                )
        ax.margins(x=0)
        ax.set_ylabel(label)
        ax.set_xlabel("time t (s)")
    if runs > 1:
        legend_above(axes[0, 0], 6)
    return figure
