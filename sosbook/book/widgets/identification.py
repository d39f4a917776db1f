"""Record logs of a simulated robot again and again, and identify it."""

from functools import lru_cache

import numpy as np

from ...pendulum.identify import fit_body, fit_wheel
from ...pendulum.rig import Rig
from ...runtime.libraries import library
from ..elements.chart import Chart
from ..plots import BLUE, GREEN, GREY, VERMILLION
from .explorer import Explorer, linear, note, page

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_identification"]

SWEEP_SECONDS = 30  # the way up, of each sweep
NAMES = {"e_c": "e/c", "f_c": "f/c", "d_c": "d/c", "e_a": "e/a", "f_a": "f/a"}


def explore_identification():
    """Move amplitude, noise, friction; see estimates and the truth.

    Each move records the two experiments anew, with the sensors of
    `Rig`, and fits the way up of each sweep. The linear fit and the
    wheels come first, then the pendulum with its sine.

    Returns
    -------
    Explorer
        ``sliders["encoder"]`` says how the counts are differenced.

    Notes
    -----
    Source: thesis section 4.2. No fit knows of the friction.
    """
    sliders = {
        "amplitude": linear("amplitude (V)", 1.85, 0.25, 3.0),
        "noise": linear("noise of the gyro (deg/s)", 0.1, 0, 10),
        "friction": linear("Coulomb friction (V)", 0.0, 0, 0.3),
        "encoder": ToggleButtons(
            options=["modelled", "plain"], description="differencing"
        ),
    }
    return Explorer(sliders, _draw)


def _draw(amplitude, noise, friction, encoder):
    rig = Rig(amplitude=amplitude, noise=np.deg2rad(noise), friction=friction)
    body = _head(rig.body())
    fits = [
        ("linear", VERMILLION, "x", fit_body(body, "linear")),
        ("wheels", GREEN, "x", fit_wheel(_wheels(amplitude, friction), 1, encoder)),
    ]
    yield _page(rig, body, fits, "The pendulum is being fitted ...", GREY)
    fits.insert(1, ("pendulum", BLUE, "circle", fit_body(body)))
    every = [(fit, x) for *_, fit in fits for x in NAMES if x in fit.names]
    missed = [x for fit, x in every if not _inside(fit, x, rig.ratios)]
    message = (
        f"<strong>{len(missed)} of {len(every)}</strong> intervals miss the truth."
    )
    yield _page(rig, body, fits, message, VERMILLION if missed else BLUE)


@lru_cache(maxsize=8)
def _wheels(amplitude, friction):
    return _head(Rig(amplitude=amplitude, friction=friction).wheels())


def _head(log):
    return log.part(slice(round(SWEEP_SECONDS / log.T)))


def _inside(fit, name, truth):
    low, high = fit.interval(name)
    return low < truth[name] < high


def _page(rig, body, fits, message, colour):
    return note(message, colour) + page(
        _errors(rig, fits), _residuals(body, fits), _table(rig, fits)
    )


def _errors(rig, fits):
    """Percent off the truth, over the five ratios."""
    places = {x: k for k, x in enumerate(NAMES, 1)}
    off = [
        [
            (places[x], 100 * (fit[x] / rig.ratios[x] - 1))
            for x in places
            if x in fit.names
        ]
        for *_, fit in fits
    ]
    top = 1.15 * max(6, *(abs(y) for some in off for _, y in some))
    chart = Chart(
        (0.5, 5.5),
        (-top, top),
        "1 e/c, 2 f/c, 3 d/c, 4 e/a, 5 f/a",
        "off the truth (%)",
        "Errors of the estimates, and a 4 % band",
    )
    chart.polygon([0.5, 5.5, 5.5, 0.5], [-4, -4, 4, 4], GREY)
    for (name, colour, shape, _), some in zip(fits, off):
        chart.marks(*zip(*some), colour, shape)
        chart.names.append((name, colour))
    return chart.svg()


def _residuals(body, fits, seconds=4.0):
    """What the body's fits leave of the log's first seconds."""
    n = round(seconds / body.T)
    residuals = [
        (name, colour, np.rad2deg(fit.residuals[:n]))
        for name, colour, _, fit in fits
        if name != "wheels"
    ]
    top = 1.1 * max(1.0, *(abs(r).max() for *_, r in residuals))
    chart = Chart(
        (0, seconds),
        (-top, top),
        "time (s)",
        "measured - model (deg/s)",
        "Residuals of the body",
    )
    for name, colour, r in residuals:
        chart.line(body.t[:n], r, colour, name=name)
    return chart.svg()


def _table(rig, fits):
    rows = []
    for method, colour, _, fit in fits:
        for x, name in NAMES.items():
            if x not in fit.names:
                continue
            low, high = fit.interval(x)
            verdict = "holds" if _inside(fit, x, rig.ratios) else "misses"
            cells = (
                f"{fit[x]:.5g} ± {(high - low) / 2:.2g}",
                f"{rig.ratios[x]:.5g}",
                verdict,
            )
            rows.append(
                f"<tr><th scope='row' style='color:{colour}'>{method} "
                f"{name}</th>"
                + "".join(f"<td style='padding:0 .6em'>{c}</td>" for c in cells)
                + "</tr>"
            )
    heads = "".join(
        f"<th scope='col'>{h}</th>" for h in ("", "estimate, 95 %", "truth", "interval")
    )
    return (
        f"<table class='estimates'><caption>Estimates</caption>"
        f"<tr>{heads}</tr>{''.join(rows)}</table>"
    )
