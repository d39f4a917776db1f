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
from .facts import span

WIDTH, HEIGHT, LEFT, LOW = 560.0, 190.0, 62.0, 34.0  # of a chart and its margins
POINTS = 400  # of a curve
CHROMIUMS = ("chromium-headless-shell", "chromium", "google-chrome", "chrome")
STYLES = ("", "7 3", "2 3", "9 3 2 3")  # dashes, so that no colour is needed
STYLE = (
    "body{font:15px/1.45 sans-serif;max-width:52rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse}td,th{border:1px solid #999;padding:.2rem .5rem;"
    "text-align:left}pre{background:#f4f4f4;padding:.6rem;overflow:auto}"
    "svg{max-width:100%;height:auto}.sos-frame,.sos-frame-chart{fill:none;stroke:#777}"
    ".sos-axis{stroke:#bbb;fill:none}.sos-region{fill:#cde7d8}"
    ".sos-pole{stroke:#111;stroke-width:1.5;fill:none}polyline{fill:none;stroke:#114}"
    "text{font:12px sans-serif}"
    "@media print{h2{break-after:avoid}svg,tr,li{break-inside:avoid}"
    "pre{white-space:pre-wrap}}"
)


def write_report(design, controller, folder, name="axis", replace=False, pdf=False):
    """Write the page, the proofs and the program of a controller into a folder.

    ``design``: what was asked and found; ``controller``: made of it; ``folder``: made
    if it doesn't exist; ``name``: of the program; ``replace``: files that are there
    with another text are replaced; ``pdf``: the page is printed, too. Returns Path: of
    index.html.
    """
    chromium = next(filter(None, map(which, CHROMIUMS)), None) if pdf else None
    if pdf and chromium is None:
        raise FileNotFoundError(
            "pdf=True needs a Chromium on the PATH and there is none: install one, or "
            "print index.html from any browser"
        )
    page = Path(folder) / "index.html"
    write_texts(folder, report_texts(design, controller, name), replace)
    if pdf:
        goal, address = page.with_suffix(".pdf").resolve(), page.resolve().as_uri()
        root = ["--no-sandbox"] * (getattr(os, "geteuid", lambda: 1)() == 0)
        words = [*root, "--no-pdf-header-footer", f"--print-to-pdf={goal}", address]
        done = run([chromium, "--headless", *words], capture_output=True, check=False)
        if done.returncode:
            said = done.stderr.decode("utf-8", "replace").strip()[-500:]
            raise OSError(f"{chromium} didn't print {page}: {said}")
    return page


def report_texts(design, controller, name="axis"):
    """The texts of `write_report` by file: page, proofs and program of a ``design`` and
    its ``controller``, with the program's ``name``.
    """
    code = controller.to_c(name)
    files = {f"{name}/{file}": text for file, text in code.texts.items()}
    return {"index.html": _page(design, controller, code)} | files


def _page(design, c, code):
    seconds = span(c)
    asked = [r.statement for r in design.request.requirements]
    bounds, peak = (), ""
    if getattr(design, "at_ticks", False):
        asked = [design.words]
    else:
        title = "<h2>Asked, proven and true, in continuous time</h2>"
        bounds = title, design.bounds()._repr_html_()
        peak = f"{design.sensitivity_peak():.3f}; "
    parts = [
        f"<h1>{escape(code.name)}: a controller and what is known of it</h1>",
        f"<p>{escape(repr(c)[1:-1])}.</p>",
        "<h2>What was asked</h2><ul>",
        *(f"<li>{escape(words)}</li>" for words in asked),
        "</ul><h2>The plant</h2>",
        *(_plant(d, k) for k, d in enumerate(c.vertices, 1)),
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
        pole_map(np.atleast_2d(design.poles()), design._region()),
        "<h2>What is proven, bounded and simulated of the program</h2>",
    ]
    for title, lines in code.facts:
        items = "".join(f"<li>{escape(line)}</li>" for line in lines)
        parts.append(f"<h3>{escape(title.capitalize())}</h3><ul>{items}</ul>")
    for j, signal in enumerate(c.set_points):
        r = np.eye(len(c.set_points))[j]
        run = c.simulate(seconds, r=r)
        parts += _charts(c, run, f"A step of 1 of {signal}")
    load = np.eye(c.vertices[0].Bw.shape[1])
    for j, w in enumerate(load):
        run = c.simulate(seconds, w=w * _load(c, w))
        size = _load(c, w)
        parts += _charts(c, run, f"A load of {size:.3g} in disturbance {j + 1}")
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


def _load(c, w):
    """A load that asks a tenth of the limit at rest, or one."""
    need = abs(c.static(w=w)[1]).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (0.1 * c.limits.u_max / need)[need > 1e-12]
    size = share.min(initial=np.inf)
    return float(f"{size:.2g}") if np.isfinite(size) else 1.0


def _plant(d, k):
    rows = "\n".join(
        f"{name} = {np.array2string(np.asarray(m), precision=6)}"
        for name, m in (("E", d.E), ("A", d.A), ("B", d.Bu))
    )
    return f"<p>Corner {k}, E x' = A x + B u:</p><pre>{escape(rows)}</pre>"


def _table(head, rows):
    top = "".join(f"<th>{escape(x)}</th>" for x in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(x)}</td>" for x in row) + "</tr>" for row in rows
    )
    return f"<table><tr>{top}</tr>{body}</table>"


def _charts(c, run, title):
    names = signals(c.plant)[: c.vertices[0].n or None]
    yield f"<h3>{escape(title)}, at all corners (simulated)</h3>"
    for k, name in enumerate(names):
        yield _chart(run.t, run.x[:, :, k], f"{name} {c.units.get(name, '')}")
    for k, signal in enumerate(c.outputs):
        yield _chart(run.t, run.u[:, :, k], str(signal))


def _chart(t, curves, label):
    """An inline SVG of some curves over the time."""
    pick = np.unique(np.linspace(0, len(t) - 1, POINTS).astype(int))
    t, curves = t[pick], curves[:, pick]
    low, high = float(curves.min()), float(curves.max())
    room = 0.05 * (high - low) or 1.0
    low, high = low - room, high + room
    x = LEFT + t / t[-1] * WIDTH
    lines = []
    for k, row in enumerate(curves):
        y = 8 + (high - row) / (high - low) * HEIGHT
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y))
        dash = STYLES[k % len(STYLES)]
        lines.append(f'<polyline points="{points}" stroke-dasharray="{dash}"/>')
    ticks = "".join(
        f'<text x="{LEFT - 4}" y="{8 + HEIGHT * (1 - s) + 4}" text-anchor="end">'
        f"{low + s * (high - low):.3g}</text>"
        for s in (0.0, 0.5, 1.0)
    )
    ticks += "".join(
        f'<text x="{LEFT + s * WIDTH}" y="{HEIGHT + 22}" text-anchor="middle">'
        f"{s * t[-1]:.3g}</text>"
        for s in (0.0, 0.5, 1.0)
    )
    words = f"{label.strip()} over time in s, {len(curves)} corners"
    return (
        f'<svg role="img" aria-label="{escape(words)}" width="{LEFT + WIDTH + 12}" '
        f'height="{HEIGHT + LOW + 20}"><rect class="sos-frame-chart" x="{LEFT}" y="8" '
        f'width="{WIDTH}" height="{HEIGHT}"/>{"".join(lines)}{ticks}'
        f'<text x="{LEFT}" y="{HEIGHT + LOW + 10}">{escape(words)}</text></svg>'
    )
