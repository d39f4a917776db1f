"""A page about two logs: what was fitted, what is left over, and why
they were refused."""

from pathlib import Path

import numpy as np

from ..display.escape import page_text
from ..runtime.writing import write_file
from .gate import widened

__all__ = ["curve", "page", "write_page", "write_report"]

CURVE_WIDTH, CURVE_HEIGHT, CURVE_POINTS = 760, 150, 700
MARK = b'<meta name="generator" content="sosbook">'  # of a page that is ours
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="generator" content="sosbook">
<title>{title}</title><style>
body {{ font: 15px/1.5 sans-serif; max-width: 50em; margin: 1em auto; }}
td, th {{ padding: 0 1em 0 0; text-align: left; }}
.refused {{ color: #b00; }} svg {{ background: #f6f6f6; }}
</style></head><body>
<h1>{title}</h1>
{body}
</body></html>
"""


def page(seen):
    """The page of an `Inspection`, ``seen``, as HTML with its own pictures."""
    parts = [f"<p>{page_text(seen.robot.words)}</p>", "<h2>Findings</h2>"]
    parts.append(
        "<ul>"
        + "".join(
            f'<li class="{f.severity}"><b>{f.severity}</b>: {page_text(str(f))}</li>'
            for f in seen.findings
        )
        + "</ul>"
        if seen.findings
        else "<p>Nothing speaks against these logs.</p>"
    )
    identified = seen.identified
    if identified is None:
        parts += _raw("gyro (rad/s)", seen.body.t, seen.body.gyro)
        parts += _raw("encoder1 (counts)", seen.wheels.t, seen.wheels.encoder1)
    else:
        rows = "".join(
            f"<tr><td>{name.replace('_', '/')}</td><td>{value:.5g}</td>"
            f"<td>&plusmn; {1.96 * sd:.2g}</td></tr>"
            for (name, value), sd in zip(identified.ratios.items(), widened(identified))
        )
        parts.append(
            f"<h2>Ratios, at 95 %</h2><table>{rows}</table><p>e/f by the "
            "wheels over e/f by the body, one on one robot: "
            f"{identified.contradiction:.4f}</p>"
        )
        parts += _residuals(
            "log of the body: gyro", seen.body.t, identified.body.residuals
        )
        for k, fit in enumerate(identified.wheels, 1):
            parts += _residuals(
                f"log of the wheels: speed by encoder{k}",
                seen.wheels.t[1:],
                fit.residuals,
            )
    return PAGE.format(
        title=f"Identification of {page_text(seen.robot.name)}", body="\n".join(parts)
    )


def write_report(seen, folder):
    """Write the page of ``seen`` to identification.html in a folder.

    Returns its path.
    """
    return write_page(Path(folder) / "identification.html", page(seen))


def write_page(path, text):
    """Write a page, ``text``, to ``path``, over an earlier page but nothing else."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_file(path, text, over=lambda old: MARK in old)


def _raw(label, t, y):
    return [] if y is None else [f"<h2>{label}</h2>", curve(t, y, label)]


def _residuals(label, t, r):
    """Residuals over time, and their correlation."""
    centred = r - r.mean()
    power = float(centred @ centred) or 1.0
    lags = np.arange(1, min(100, len(r) // 2))
    related = np.array([centred[k:] @ centred[:-k] / power for k in lags])
    rms = float(np.sqrt(np.mean(r**2)))
    return [
        f"<h2>{label}: measured minus modelled</h2>",
        curve(t, r, f"residuals in rad/s, {rms:.3g} rms"),
        f"<p>Correlation with itself, 1 to {lags[-1]} samples later; noise "
        f"stays within &plusmn; {1.96 / len(r) ** 0.5:.2g}:</p>",
        curve(lags, related, "autocorrelation", 1.0),
    ]


def curve(x, y, label, top=None):
    """An SVG polyline of y over x; of each stretch the lowest and highest point.

    It bears a ``label``; ``top`` is the largest value that is shown, the
    largest of y without it.
    """
    count = max(len(y) // (CURVE_POINTS // 2), 1)
    ends = len(y) // count * count
    order = np.argsort(np.reshape(y[:ends], (-1, count)), axis=1)
    some = np.sort((order[:, [0, -1]] + np.arange(0, ends, count)[:, None]).ravel())
    x, y = np.asarray(x)[some], np.asarray(y)[some]
    top = top or float(abs(y).max()) or 1.0
    across = CURVE_WIDTH * (x - x[0]) / (x[-1] - x[0])
    down = CURVE_HEIGHT / 2 * (1 - y / top)
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down))
    return (
        f'<svg width="{CURVE_WIDTH}" height="{CURVE_HEIGHT}" role="img" aria-label="'
        f'{page_text(label)}"><polyline fill="none" stroke="#06c" points="'
        f'{points}"/><text x="4" y="14">{page_text(label)}; &plusmn; {top:.3g}, '
        f"{x[0]:.4g} to {x[-1]:.4g}</text></svg>"
    )
