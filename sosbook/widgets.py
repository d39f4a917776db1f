"""Live sliders for Jupyter: each move solves the LMIs again.

The pictures are SVG strings in one HTML widget: drawing them takes a
millisecond, so a move costs what the design costs.
"""

import asyncio
import html

import ipywidgets
import numpy as np

from .chart import Chart
from .descriptor import descriptors
from .design import analyse_pid, design_pid
from .plots import (
    BLUE,
    COLOURS,
    GREEN,
    GREY,
    INK,
    SKY,
    VERMILLION,
    ellipse_outline,
    largest_singular_value,
    region_outline,
    smallest_of_each,
    window_of,
)
from .regions import LMIRegion, PoleRegion
from .request import Saturation

__all__ = [
    "Explorer",
    "explore_design",
    "explore_hinf",
    "explore_region",
    "explore_saturation",
    "explore_segment",
]


class Explorer(ipywidgets.VBox):
    """Sliders over a picture.

    Parameters
    ----------
    sliders : dict of str to ipywidgets slider
    draw : callable
        Takes the sliders' values by name and yields HTML, once or more
        often: first what is quick, then what takes longer.

    Attributes
    ----------
    sliders : dict
        Set ``sliders["rho"].value`` to move one from code.
    picture : ipywidgets.HTML
        What is shown.
    """

    def __init__(self, sliders, draw):
        self.sliders = sliders
        self.picture = ipywidgets.HTML()
        self._draw = draw
        self._waiting = None
        for slider in sliders.values():
            slider.observe(self._move, "value")
        super().__init__([*sliders.values(), self.picture])
        self._move()

    def _move(self, change=None):
        if self._waiting is not None:
            self._waiting.cancel()
        values = {name: s.value for name, s in self.sliders.items()}
        pages = self._draw(**values)
        self._show(pages, 1)
        self._waiting = _when_idle(lambda: self._show(pages))

    def _show(self, pages, count=None):
        try:
            for _, page in zip(range(count or 9), pages):
                self.picture.value = page
        except ValueError as error:  # e.g. an empty region
            self.picture.value = _note(html.escape(str(error)))


def _when_idle(function, seconds=0.25):
    """Call when the sliders rest; at once where no event loop runs."""
    try:
        loop = asyncio.get_running_loop()
    except RuntimeError:
        return function()
    return loop.call_later(seconds, function)


def _slider(kind, name, value, low, high, step, form=".3g"):
    return kind(
        value=value, min=low, max=high, step=step, description=name,
        readout_format=form, continuous_update=True,
        style={"description_width": "11em"},
        layout=ipywidgets.Layout(width="min(36em, 95%)"),
    )


def _linear(name, value, low, high, form=".3g"):
    step = 10.0 ** np.floor(np.log10((high - low) / 60))
    return _slider(ipywidgets.FloatSlider, name, value, low, high, step, form)


def _log(name, value, below, above):
    middle = np.log10(value)
    return _slider(
        ipywidgets.FloatLogSlider, name, value,
        middle - np.log10(below), middle + np.log10(above), 0.02,
    )


def explore_design(plant, U=None, region=None, gamma=None,
                   saturation=None, coupling="pairs"):
    """Move the requirements; see poles, gains, response and margins.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        Of a polytope, the poles and the response of every vertex are drawn.
    U, region, gamma, saturation, coupling
        As in `design_pid`; ``region`` is a `PoleRegion`. Each
        requirement that is given gets its slider.

    Returns
    -------
    Explorer
    """
    sliders = {}
    if region is not None and region.sigma is not None:
        top = 3 * region.sigma or 1.0
        sliders["sigma"] = _linear(
            "decay rate sigma (1/s)", region.sigma, 0, top)
    if region is not None and region.theta is not None:
        sliders["theta"] = _linear(
            "half-angle theta (degrees)", np.degrees(region.theta), 2, 90)
    if region is not None and region.rho is not None:
        sliders["rho"] = _linear(
            "radius rho (rad/s)", region.rho, region.rho / 5,
            3 * region.rho)
    if gamma is not None:
        sliders["gamma"] = _log("norm bound gamma", gamma, 10, 10)
    if saturation is not None:
        sliders["u_max"] = _log(
            "input bound u_max", saturation.u_max, 10, 5)

    def draw(sigma=None, theta=None, rho=None, gamma=None, u_max=None):
        theta = None if theta is None else np.radians(theta)
        asked = {sigma, theta, rho} - {None}
        wanted = PoleRegion(sigma, theta, rho) if asked else None
        bound = u_max and Saturation(u_max, saturation.x0)
        design = design_pid(
            plant, U, wanted, gamma, bound, coupling=coupling)
        yield _design_page(design, wanted)
        if design.status != "feasible":
            yield _design_page(design, wanted, design.advice)

    return Explorer(sliders, draw)


def _design_page(design, region, advice=""):
    plant = design.request.plant
    feasible = design.status == "feasible"
    open_loop = np.concatenate([v.poles() for v in plant.vertices])
    poles = np.ravel(design.poles()) if feasible else np.array([])
    window = window_of([poles if feasible else open_loop], region)
    chart = Chart(
        window[:2], (-window[2], window[2]), "Re s (1/s)", "Im s (rad/s)",
        "Poles in the complex plane", square=True,
    )
    if region is not None:
        outline = region_outline(region, window)
        colour = GREEN if feasible else VERMILLION
        chart.polygon(outline.real, outline.imag, colour, not feasible)
    chart.marks(open_loop.real, open_loop.imag, GREY, "circle")
    chart.marks(np.real(poles), np.imag(poles), BLUE, "cross")
    words = f"<strong>{design.status}</strong>. {html.escape(advice)}"
    if not feasible:
        return _note(words) + _page(chart.svg())
    words += f"Poles: {_poles(poles)}. Crosses: closed loop; circles: plant."
    return _note(words, BLUE) + _page(
        chart.svg(), _step_chart(design, poles), _gains(design),
        _margins(design.margins),
    )


def _poles(poles):
    upper = poles[poles.imag >= 0]
    return ", ".join(
        f"{s.real:.3g} ± {s.imag:.3g}j" if s.imag else f"{s.real:.3g}"
        for s in upper
    )


def _step_chart(design, poles):
    end = float(f"{min(10 / -poles.real.max(), 60):.1g}")
    t = np.linspace(0, end, 161)
    answer = design.simulate(t, r=np.ones(design.request.plant.n))
    answers = answer if isinstance(answer, list) else [answer]
    z = np.stack([answer.z for answer in answers])
    low, high = min(z.min(), 0.0), max(z.max(), 1.0)
    room = 0.06 * (high - low)
    chart = Chart(
        (0, end), (low - room, high + room), "t (s)", "z",
        "Response to a unit set point",
    )
    chart.line([0, end], [1, 1], GREY, dashed=True)
    for k in range(z.shape[1]):
        for j, vertex in enumerate(z):
            chart.line(t, vertex[k], COLOURS[k % len(COLOURS)], k % 2,
                       name="" if j else f"z{k + 1}")
    return chart.svg()


def _gains(design):
    names = ("K_P", "K_D", "K_I")
    parts = [getattr(design, name) for name in names]
    rows = "".join(
        "<tr>" + "".join(
            f"<td style='padding:0 .6em;text-align:right'>{k:.4g}</td>"
            for part in parts for k in part[i]
        ) + "</tr>"
        for i in range(len(parts[0]))
    )
    heads = "".join(
        f"<th scope='colgroup' colspan='{part.shape[1]}'>{name}</th>"
        for name, part in zip(names, parts) if part.shape[1]
    )
    return f"<table class='gains'><tr>{heads}</tr>{rows}</table>"


def _margins(margins):
    rows = []
    for name, value in smallest_of_each(margins).items():
        width = 100 * np.clip(1 + np.log10(max(value, 1e-9)) / 4, 0.02, 1)
        bar = (f"<div style='background:{BLUE};height:.7em;"
               f"width:{width:.0f}%'></div>")
        rows.append(
            f"<tr><th scope='row' style='text-align:left;font-weight:"
            f"normal'>{html.escape(name)}</th><td>{value:.2g}</td>"
            f"<td style='width:9em'>{bar}</td></tr>"
        )
    head = "<caption>Margins (log scale)</caption>"
    return f"<table class='margins'>{head}{''.join(rows)}</table>"


def explore_region(A=None):
    """Move the parts of a D-region over the poles of a matrix.

    Parameters
    ----------
    A : (k, k) array_like, optional
        Default: poles at -1, -2 and -1.5 +- 2j.

    Returns
    -------
    Explorer
    """
    if A is None:
        A = np.zeros((4, 4))
        A[0, 0], A[1, 1] = -1, -2
        A[2:, 2:] = [[-1.5, 2], [-2, -1.5]]
    poles = np.linalg.eigvals(np.asarray(A, float))
    sliders = {
        "sigma": _linear("half-plane sigma (1/s)", 0.5, 0, 3),
        "theta": _linear("sector theta (degrees)", 60, 5, 90),
        "rho": _linear("disk radius rho (rad/s)", 4, 0.5, 8),
        "centre": _linear("disk centre (1/s)", 0, -6, 1),
    }

    def draw(sigma, theta, rho, centre):
        region = (LMIRegion.half_plane(sigma)
                  & LMIRegion.sector(np.radians(theta))
                  & LMIRegion.disk(rho, centre))
        window = (-9.0, 2.0, 6.0)
        chart = Chart(window[:2], (-6, 6), "Re s (1/s)", "Im s (rad/s)",
                       "Poles and the region", square=True)
        outline = region_outline(region, window)
        chart.polygon(outline.real, outline.imag, GREEN)
        chart.marks(poles.real, poles.imag, BLUE, "cross")
        rows = "".join(
            f"<li>{name}: {d.min():+.2f} rad/s "
            f"{'inside' if d.min() > 0 else 'OUTSIDE'}</li>"
            for name, d in region.distances(poles).items()
        )
        words = "inside" if region.contains(poles) else "not all inside"
        yield _page(chart.svg(), f"<div><strong>The poles are {words}."
                                 f"</strong><ul>{rows}</ul></div>")

    return Explorer(sliders, draw)


def explore_hinf(plant, K, U=None, gamma=None):
    """Move gamma: does one P prove the bound, and where is the norm?

    Parameters
    ----------
    plant : SecondOrderSystem
        With ``F``.
    K : (m, N) array_like
        The gain that is analysed.
    U : (a, n) array_like, optional
    gamma : float, optional
        Where the slider starts; twice the norm without it.

    Returns
    -------
    Explorer
    """
    design = analyse_pid(plant, K, U)
    norm = design.hinf()
    loop = design.closed_loop()
    p, n = plant.p, plant.n
    size = np.abs(loop.poles())
    grid = np.geomspace(size.min() / 30, size.max() * 30, 200)
    curve = largest_singular_value(
        loop.A, loop.B[:, :p], loop.C[:n], loop.D[:n, :p], grid)
    sliders = {"gamma": _log("bound gamma", gamma or 2 * norm, 10, 10)}

    def draw(gamma):
        found = analyse_pid(plant, K, U, gamma=gamma)
        chart = Chart(
            np.log10(grid[[0, -1]]), np.log10([norm / 1e3, norm * 30]),
            "frequency (rad/s)", "largest singular value",
            "Gain from w to z over the frequency", log=True,
        )
        feasible = found.status == "feasible"
        colour = GREEN if feasible else VERMILLION
        edge = np.log10(grid[[0, -1]])
        chart.line(np.log10(grid), np.log10(curve), BLUE, name="gain")
        chart.line(edge, np.log10([gamma] * 2), colour, True, "gamma")
        words = (
            f"The LMI is <strong>{found.status}</strong> at gamma = "
            f"{gamma:.4g}. The norm is {norm:.4g}."
        )
        margin = _margins(found.margins) if feasible else ""
        yield _page(chart.svg(), f"<div><p>{words}</p>{margin}</div>")

    return Explorer(sliders, draw)


def explore_saturation(plant, U, region, saturation, gamma=None):
    """Move u_max and the size of x(0): ellipsoid and |K x(t)|.

    Parameters
    ----------
    plant, U, region, gamma
        As in `design_pid`.
    saturation : Saturation
        Where the sliders start.

    Returns
    -------
    Explorer
    """
    sliders = {
        "u_max": _log("input bound u_max", saturation.u_max, 5, 5),
        "scale": _linear("x(0), times", 1.0, 0.1, 3.0),
    }

    def draw(u_max, scale):
        bound = Saturation(u_max, scale * saturation.x0)
        design = design_pid(plant, U, region, gamma, bound)
        if design.status != "feasible":
            words = f"<strong>{design.status}</strong>."
            yield _note(words)
            yield _note(f"{words} {html.escape(design.advice)}")
            return
        n = plant.n
        slowest = -design.poles().real.max()
        t = np.linspace(0, float(f"{6 / slowest:.1g}"), 201)
        answer = design.simulate(t, x0=bound.x0)
        outline = ellipse_outline(design.P, (0, n))
        reach = 1.1 * np.abs(outline).max(axis=1)
        shadow = Chart(
            (-reach[0], reach[0]), (-reach[1], reach[1]), "z1", "z1'",
            "Shadow of the ellipsoid, and x(t)",
        )
        shadow.polygon(*outline, SKY)
        shadow.line(answer.x[0], answer.x[n], INK)
        shadow.marks(bound.x0[:1], bound.x0[n:n + 1], VERMILLION, "circle")
        effort = np.linalg.norm(answer.u, axis=0)
        chart = Chart((0, t[-1]), (0, 1.1 * u_max), "t (s)", "|K x|",
                       "Norm of the input, and its bound")
        chart.line(t, effort, BLUE, name="|K x(t)|")
        chart.line([0, t[-1]], [u_max] * 2, VERMILLION, True, "u_max")
        yield _page(shadow.svg(), chart.svg(), _gains(design))

    return Explorer(sliders, draw)


def explore_segment(plants, P):
    """Move between two uncontrolled vertices that share a P.

    Parameters
    ----------
    plants : Polytope
        Of two vertices.
    P : (2n, 2n) array
        Satisfies the stability LMI at both.

    Returns
    -------
    Explorer
    """
    if plants.N != 2:
        raise ValueError(f"plants has {plants.N} vertices, needs two")
    weights = np.linspace(0, 1, 41)
    every = np.concatenate(
        [plants.at([1 - a, a]).poles() for a in weights])
    window = window_of([every])
    sliders = {
        "weight": _linear("weight of the second vertex", 0.0, 0, 1)}

    def draw(weight):
        plant = plants.at([1 - weight, weight])
        poles = plant.poles()
        (d,) = descriptors(plant)
        lyapunov = d.A @ P @ d.E.T
        top = np.linalg.eigvalsh(lyapunov + lyapunov.T)[-1]
        chart = Chart(
            window[:2], (-window[2], window[2]), "Re s (1/s)",
            "Im s (rad/s)", "Poles between the vertices", square=True)
        chart.line([0, 0], [-window[2], window[2]], GREY, True)
        chart.marks(every.real, every.imag, GREY, "circle")
        chart.marks(poles.real, poles.imag, BLUE, "cross")
        words = "stable" if poles.real.max() < 0 else "UNSTABLE"
        yield _page(chart.svg(), (
            f"<div><p>The plant is <strong>{words}</strong>: largest real "
            f"part {poles.real.max():+.2f}.</p><p>Largest eigenvalue of "
            f"the stability LMI with this P: {top:+.2f}.</p></div>"))

    return Explorer(sliders, draw)


def _note(words, colour=VERMILLION):
    return (f"<p role='status' style='margin:0;padding:.4em 1em;"
            f"border-left:5px solid {colour};background:#f6f8fa;"
            f"color:{INK}'>{words}</p>")


def _page(*parts):
    cells = "".join(f"<div>{part}</div>" for part in parts if part)
    return ("<div style='display:flex;flex-wrap:wrap;gap:1em;background:white;"
            f"color:{INK};padding:.5em'>{cells}</div>")
