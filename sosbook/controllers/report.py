"""One page of a controller: what an engineer hands to somebody else."""

import os
from html import escape
from pathlib import Path
from shutil import which
from subprocess import run

import numpy as np

from ..display.pole_map import pole_map
from ..plants.gain import signals
from ..runtime.writing import write_texts
from .charts import STYLE as OF_CHARTS
from .charts import chart, key
from .facts import ALONE, ended, span, step_run, stepped
from .signals import signals_of
from .trial import kept, loads_of

FOR_MARGINS = 10.0  # seconds, at each input
CHROMIUMS = ("chromium-headless-shell", "chromium", "google-chrome", "chrome")
STYLE = (
    "body{font:15px/1.45 sans-serif;max-width:52rem;margin:2rem auto;padding:0 1rem;"
    "overflow-wrap:anywhere}"
    "table{border-collapse:collapse}td,th{border:1px solid #999;padding:.2rem .5rem;"
    "text-align:left}pre{background:#f4f4f4;padding:.6rem;overflow:auto}"
    "svg{max-width:100%;height:auto}.sos-frame{fill:none;stroke:#777}"
    ".sos-axis{stroke:#bbb;fill:none}.sos-region{fill:#cde7d8}"
    f".sos-pole{{stroke:#111;stroke-width:1.5;fill:none}}{OF_CHARTS}"
    "@media print{h2{break-after:avoid}svg,tr,li{break-inside:avoid}"
    "pre{white-space:pre-wrap}}"
)


def write_report(
    design, controller, folder, name="axis", replace=False, pdf=False, step=None
):
    """Write the page, the proofs and the program of a controller into a folder.

    ``design``: what was asked and found; ``controller``: made of it; ``folder``: made
    if it doesn't exist; ``name``: of the program; ``replace``: files that are there
    with another text are replaced; ``pdf``: the page is printed, too; ``step``: see
    `Controller.to_c`. Returns Path: of index.html.
    """
    chromium = next(filter(None, map(which, CHROMIUMS)), None) if pdf else None
    if pdf and chromium is None:
        raise FileNotFoundError(
            "pdf=True needs a Chromium on the PATH and there is none: install one, or "
            "print index.html from any browser"
        )
    page = Path(folder) / "index.html"
    write_texts(folder, report_texts(design, controller, name, step), replace)
    if pdf:
        goal, address = page.with_suffix(".pdf").resolve(), page.resolve().as_uri()
        root = ["--no-sandbox"] * (getattr(os, "geteuid", lambda: 1)() == 0)
        words = [*root, "--no-pdf-header-footer", f"--print-to-pdf={goal}", address]
        done = run([chromium, "--headless", *words], capture_output=True, check=False)
        if done.returncode:
            said = done.stderr.decode("utf-8", "replace").strip()[-500:]
            raise OSError(f"{chromium} didn't print {page}: {said}")
    return page


def report_texts(design, controller, name="axis", step=None):
    """The texts of `write_report` by file: page, proofs and program of a ``design`` and
    its ``controller``, with the program's ``name`` and the ``step`` that is shown.
    """
    code = controller.to_c(name, step=step)
    files = {f"{name}/{file}": text for file, text in code.texts.items()}
    return {"index.html": _page(design, controller, code)} | files


def _page(design, c, code):
    """The body of the report in HTML."""
    bounds, peak = (), ""
    if hasattr(design, "bounds"):
        when = "at the plant's ticks" if c.timing.steps else "in continuous time"
        title = f"<h2>Asked, proven and true, {when}</h2>"
        bounds = title, design.bounds()._repr_html_()
        peak = "" if c.timing.steps else f"{design.sensitivity_peak():.3f}; "
    parts = [
        f"<h1>{escape(code.name)}: a controller and what is known of it</h1>",
        f"<p>{escape(repr(c)[1:-1])}.</p>",
        "<h2>What was asked</h2><ul>",
        *(f"<li>{escape(words)}</li>" for words in design.statements()),
        "</ul><h2>The plant</h2>",
        *(_plant(c, *x) for x in zip(c.vertices, _corners(c))),
        "<h2>The gain</h2>",
        _table(
            ["output", *c.gain.signals],
            [
                [s.name, *(f"{x:.6g}" for x in row)]
                for s, row in zip(c.outputs, c.gain.K)
            ],
        ),
        *bounds,
        f"<p>Sensitivity at the input, at most: {peak}sampled, with memory and delay: "
        f"{c.sensitivity_peak():.3f}; at the corners, in floats.</p>",
        pole_map(
            np.atleast_2d(design.poles()), design._region(), label=design.pole_axis
        ),
        *_margins(c),
        "<h2>What is proven, bounded and simulated of the program</h2>",
    ]
    for title, lines in code.facts:
        items = "".join(f"<li>{escape(line)}</li>" for line in lines)
        parts.append(f"<h3>{escape(title.capitalize())}</h3><ul>{items}</ul>")
    if c.set_points or c.vertices[0].Bw.size:
        parts += ["<p>The lines of the charts below:</p>", key(_corners(c))]
    for j, (signal, trial) in enumerate(zip(c.set_points, code.trials)):
        run = step_run(c, j, trial.size, False)
        parts += _charts(c, run, "A" + stepped(trial, signal)[1:], j, trial.size)
    for j, load in enumerate(loads_of(c)):
        w = load.size * np.eye(c.vertices[0].Bw.shape[1])[j]
        title = f"A load of {load.size:.3g} in disturbance {j + 1} ({load.why})"
        parts += _charts(c, c.simulate(span(c), w=w), title)
    gains = code.gains[: code.gains.index("#ifndef")]
    files = "".join(f"<li>{escape(file)}</li>" for file in code.texts)
    parts += [
        f"<h2>Files</h2><ul>{files}</ul>",
        "<p><code>python -m sosbook verify</code> checks the proof files.</p>",
        f"<h2>Head of the program's numbers</h2><pre>{escape(gains)}</pre>",
        f"<h2>The program</h2><pre>{escape(code.texts[f'{code.name}.c'])}</pre>",
    ]
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>'
        f"{escape(code.name)}</title><style>{STYLE}</style>{''.join(parts)}</html>\n"
    )


def _margins(c):
    """The loop opened at each input, if it is stable: its margins and charts."""
    if c.radius < 1:
        yield f"<h2>Margins of the sampled loop</h2><p>{ALONE.capitalize()}.</p>"
        for k, _ in enumerate(c.outputs):
            yield c.margins(k, FOR_MARGINS, sharp=False)._repr_html_()


def _plant(c, d, name):
    change = f"(next x - x)/({c.T:g} s)" if c.timing.steps else "x'"
    rows = "\n".join(
        f"{name} = {np.array2string(np.asarray(m), precision=6)}"
        for name, m in (("E", d.E), ("A", d.A), ("B", d.Bu))
    )
    title = f"C{name[1:]}. E {change} = A x + B u:"
    return f"<p>{escape(title)}</p><pre>{escape(rows)}</pre>"


def _table(head, rows):
    top = "".join(f"<th>{escape(x)}</th>" for x in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(x)}</td>" for x in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{top}</tr>{body}</table>"


def _corners(c):
    """The name of each corner: the values of its parameters, where they are."""
    family = getattr(c.plant, "family", c.plant)
    names = [f"corner {k}" for k in range(1, len(c.vertices) + 1)]
    if getattr(family, "multi_affine", False) and family.count == len(names):
        for k, point in enumerate(family.box.corners()):
            at = zip(family.box.names, point)
            names[k] += ": " + ", ".join(f"{x} = {float(v):.6g}" for x, v in at)
    return names


def _charts(c, run, title, j=None, size=1.0):
    """The charts of a ``run`` of c, at a step of set point j of a ``size``, if any."""
    shown, how = kept(c, run, j, size), ended(c, run, j, size)
    runs = [slice(0, count) for count in shown]
    yield f"<h3>{escape(title)}</h3><p>Simulated at all corners: {how}.</p>"
    names = signals(c.plant)[: c.vertices[0].n or None]
    for k, signal in enumerate(signals_of(names, c.units)):
        curves = [(run.t[part], x[part, k]) for part, x in zip(runs, run.x)]
        yield chart(curves, str(signal))
    for k, signal in enumerate(c.outputs):
        curves = [(run.t[part], u[part, k]) for part, u in zip(runs, run.u)]
        yield chart(curves, str(signal), c.limits.u_max[k])
