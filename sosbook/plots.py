"""Figures of the book: accessible inline SVG, the same bytes on every run.

Small functions draw into Axes; `show` turns a Figure into an output with an
alternative text and a caption.  Colours are Okabe and Ito's, which stay apart
for colour-blind readers; marks and dashes differ too.
"""

import html
import io
import re
from itertools import count

import matplotlib.pyplot as plt
import numpy as np

BLUE, VERMILLION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
PURPLE, SKY, GREY, INK = "#CC79A7", "#56B4E9", "#767676", "#1f2328"
COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
MARKERS = ("x", "o", "+", "s", "d", "^")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))

STYLE = {
    "svg.fonttype": "path",
    "svg.hashsalt": "sosbook",
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "mathtext.fontset": "dejavusans",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlesize": 9.0,
    "axes.prop_cycle": plt.cycler(color=COLOURS, linestyle=DASHES),
    "grid.color": "#e3e5e8",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.figsize": (6.8, 3.2),
    "figure.facecolor": "white",
    "axes.facecolor": "white",
    "figure.constrained_layout.use": True,
}


def use_book_style():
    """Set matplotlib's defaults to the book's: call it once, in the first cell.

    Text becomes paths of matplotlib's own font, so a figure does not depend
    on the fonts of the machine, and ids follow from a fixed salt.

    Examples
    --------
    >>> use_book_style()
    >>> plt.rcParams["svg.fonttype"]
    'path'
    """
    plt.rcParams.update(STYLE)


# ---------------------------------------------------------------- the output

class Figure:
    """An inline SVG with its alternative text and caption, as an output.

    Attributes
    ----------
    svg, alt, caption, html : str
    """

    def __init__(self, svg, alt, caption=""):
        self.svg, self.alt, self.caption = svg, alt, caption
        below = f"<figcaption>{html.escape(caption, quote=False)}</figcaption>"
        self.html = ('<figure class="sos-figure" style="margin:0.5em 0">'
                     f"{svg}{below if caption else ''}</figure>")

    def _repr_html_(self):
        return self.html

    def __repr__(self):
        return f"Figure: {self.alt}"


def show(figure, alt=None, caption=""):
    """Turn a matplotlib figure into an accessible output; put it last in a cell.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        It is closed, so that it isn't drawn a second time.
    alt : str
        What the picture shows, for readers who can't see it.  Mandatory.
    caption : str, optional
        What the reader should take from it.

    Returns
    -------
    Figure
        Displayed as ``<figure><svg role="img" …></svg><figcaption>…``.

    Raises
    ------
    ValueError
        If `alt` is missing or empty.

    Examples
    --------
    >>> figure, ax = plt.subplots()
    >>> show(figure, alt="Empty axes", caption="Nothing yet.")
    Figure: Empty axes
    """
    if not isinstance(alt, str) or not alt.strip():
        raise ValueError("alt is missing: say in a sentence what the figure "
                         "shows, show(figure, alt='...')")
    buffer = io.StringIO()
    with plt.rc_context({key: STYLE[key] for key in
                         ("svg.fonttype", "svg.hashsalt")}):
        figure.savefig(buffer, format="svg", metadata={
            "Date": None, "Creator": None, "Format": None, "Type": None})
    plt.close(figure)
    return Figure(_inline(buffer.getvalue(), alt.strip(), caption),
                  alt.strip(), caption)


def _inline(text, alt, caption):
    """Matplotlib's SVG file made small, responsive and safe to put in a page."""
    width, height = map(float, re.search(
        r'viewBox="0 0 ([\d.]+) ([\d.]+)"', text).groups())
    body = text[text.index(">", text.index("<svg")) + 1:]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.S)
    body = re.sub(r"<!--.*?-->", "", body, flags=re.S)
    # This rule would reach the whole page; the root's attributes do instead.
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", body, flags=re.S)
    body = re.sub(r'(<path[^>]*? d=")([^"]*)"',
                  lambda found: found[1] + _short(found[2]) + '"', body,
                  flags=re.S)
    body = re.sub(r'(\s(?:x|y|width|height)=")(-?[\d.]+)"',
                  lambda found: f'{found[1]}{_number(float(found[2]))}"', body)
    body = re.sub(r"translate\(([^)]*)\)", lambda found: (
        f"translate({_short(found[1])})"), body)
    body = re.sub(r'style="([^"]*)"', lambda found: (
        'style="' + re.sub(r"([:;]) ", r"\1", found[1]) + '"'), body)
    body = _rename(body, _stem(alt + caption))
    body = re.sub(r"\n\s*", "\n", body).replace(">\n<", "><").strip()
    return (f'<svg xmlns="http://www.w3.org/2000/svg" '
            f'xmlns:xlink="http://www.w3.org/1999/xlink" '
            'stroke-linejoin="round" stroke-linecap="butt" '
            f'role="img" aria-label="{html.escape(alt)}" '
            f'viewBox="0 0 {_number(width)} {_number(height)}" '
            f'style="display:block;width:100%;max-width:{width * 4 / 3:.0f}px;'
            f'height:auto;background:#fff;border-radius:6px">{body}')


def _number(value, digits=2):
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def _short(path):
    """Path data with two decimals: a hundredth of a point can't be seen."""
    path = re.sub(r"-?\d+\.\d+(e-?\d+)?",
                  lambda found: _number(float(found[0])), path)
    path = re.sub(r"\s+", " ", path).strip()
    return re.sub(r" ?([A-Za-z]) ?", r"\1", path)


def _stem(text):
    """A short id that follows from the words, so it is the same everywhere."""
    value = 0
    for letter in text.encode():
        value = (value * 131 + letter) % 16777213
    return f"f{value:06x}"


def _rename(body, stem):
    """Keep the ids that something refers to, renamed so pages have no doubles."""
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', body))
    numbers = count()
    names = {}
    for name in re.findall(r'\sid="([^"]+)"', body):
        if name in used and name not in names:
            names[name] = f"{stem}-{next(numbers)}"
    body = re.sub(r'\sid="([^"]+)"', lambda found: (
        f' id="{names[found[1]]}"' if found[1] in names else ""), body)
    return re.sub(r'(href="#|url\(#)([^")]+)', lambda found: (
        found[1] + names.get(found[2], found[2])), body)


# --------------------------------------------------------------- the D-region

def region_outline(region, window=(-10.0, 2.0, 6.0), rays=360):
    """Corners of a polygon that traces a D-region within a window.

    A region f(z) = alpha + beta z + beta' conj(z) < 0 is convex and symmetric
    about the real axis.  From an interior point c the boundary along a
    direction d is where f(c) + t (f(c + d) - f(c)) becomes singular: one
    eigenvalue problem a ray, no search.

    Parameters
    ----------
    region : PoleRegion, LMIRegion or a sequence of LMIRegion
    window : (left, right, height)
        The part of the plane to trace, |Im s| <= height.
    rays : int
        Directions; the polygon has as many corners.

    Returns
    -------
    ndarray of complex, or an empty one if the region misses the window
    """
    left, right, height = window
    parts = region_parts(region)
    pairs = [(np.asarray(part.alpha, float), np.asarray(part.beta, float))
             for part in parts]
    one = np.ones((1, 1))
    pairs += [(left * one, -one / 2), (-right * one, one / 2),
              (np.diag([-height, -height]) + 0.0,
               np.array([[0, 1], [-1, 0]]) / 2)]

    def values(points):
        worst = []
        for alpha, beta in pairs:
            f = (alpha + beta * points[:, None, None]
                 + beta.T * points[:, None, None].conj())
            worst.append(np.linalg.eigvalsh(f)[:, -1]
                         / (np.linalg.norm(alpha) + np.linalg.norm(beta)))
        return np.max(worst, axis=0)

    a, b = left, right
    for _ in range(6):                           # convex along the real axis
        grid = np.linspace(a, b, 41)
        worst = values(grid + 0j)
        k = int(np.argmin(worst))
        a, b = grid[max(k - 1, 0)], grid[min(k + 1, 40)]
    if worst[k] >= -1e-9:
        return np.empty(0, complex)
    centre = grid[k]
    directions = np.exp(2j * np.pi * (np.arange(rays) + 0.5) / rays)
    reach = np.full(rays, np.inf)
    for alpha, beta in pairs:
        at_centre = alpha + centre * (beta + beta.T)
        root = np.linalg.inv(np.linalg.cholesky(-at_centre))
        slope = (beta * directions[:, None, None]
                 + beta.T * directions[:, None, None].conj())
        top = np.linalg.eigvalsh(root @ slope @ root.T)[:, -1]
        reach = np.minimum(reach, np.where(top > 1e-12, 1 / np.maximum(
            top, 1e-12), np.inf))
    return centre + reach * directions


def region_parts(region):
    """The LMI regions whose intersection `region` is; an empty tuple for None."""
    if region is None:
        return ()
    if hasattr(region, "parts"):
        return tuple(region.parts)
    return tuple(region) if isinstance(region, (list, tuple)) else (region,)


def window_of(poles, region=None):
    """A window (left, right, height) that shows the poles and the region.

    Examples
    --------
    >>> window_of([-1 + 1j, -1 - 1j])
    (-1.3, 0.325, 1.3)
    """
    points = np.concatenate([np.ravel(np.asarray(p, complex)) for p in poles]
                            ) if len(poles) else np.array([-1 + 1j])
    points = points[np.isfinite(points)]
    far = max(np.max(np.abs(points.real)), np.max(np.abs(points.imag)), 1e-9)
    rho = getattr(region, "rho", None)
    far = 1.08 * max(far, rho) if rho else 1.3 * far
    right = max(0.25 * far, 1.3 * np.max(points.real))
    return (float(round(-far, 6)), float(round(right, 6)), float(round(far, 6)))


def shade_region(ax, region, window, colour=GREEN, label="D-region"):
    """Shade a D-region within a window (left, right, height)."""
    outline = region_outline(region, window)
    if outline.size:
        ax.fill(outline.real, outline.imag, facecolor=colour, alpha=0.18,
                edgecolor="none", zorder=1)
        ax.plot([], [], color=colour, alpha=0.4, linewidth=7, linestyle="-",
                label=label)
    return ax


def poles(ax, poles, region=None, window=None, label="closed loop"):
    """Poles in the complex plane, over the shaded D-region.

    Parameters
    ----------
    ax : matplotlib Axes
    poles : array of complex, any shape, or a dict {label: array}
        (N, order) for a polytope; a dict compares several loops.
    region : PoleRegion, LMIRegion or a sequence of LMIRegion, optional
    window : (left, right, height), optional
        The part of the plane shown; chosen to fit everything if left out.
    label : str
        Name in the legend when `poles` is no dict.

    Returns
    -------
    matplotlib Axes
    """
    sets = dict(poles) if isinstance(poles, dict) else {label: poles}
    window = window or window_of(list(sets.values()), region)
    left, right, height = window
    if region is not None:
        shade_region(ax, region, window)
    ax.axhline(0, color=GREY, linewidth=0.7, linestyle="-", zorder=1.5)
    ax.axvline(0, color=GREY, linewidth=0.7, linestyle="-", zorder=1.5)
    order = (1, 0) if len(sets) == 2 else range(len(sets))
    for (name, values), k in zip(sets.items(), order):
        values = np.ravel(np.asarray(values, complex))
        marker, colour = MARKERS[k % 6], COLOURS[k % 6]
        hollow = {} if marker in "x+" else {"markerfacecolor": "none"}
        ax.plot(values.real, values.imag, linestyle="none", marker=marker,
                color=colour, markersize=6, markeredgewidth=1.4, label=name,
                zorder=3, **hollow)
    ax.set_xlim(left, right)
    ax.set_ylim(-height, height)
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel("Re s (1/s)")
    ax.set_ylabel("Im s (rad/s)")
    _legend_above(ax, len(sets) + (region is not None))
    return ax


def pole_map(poles_, region=None, window=None, label="closed loop",
             figsize=(4.6, 4.4)):
    """A figure of its own for `poles`; takes what `poles` takes."""
    figure, ax = plt.subplots(figsize=figsize)
    poles(ax, poles_, region=region, window=window, label=label)
    return figure


# ----------------------------------------------------------- signals, margins

def response(response, u_max=None, disturbance=None, panels=None,
             names=None, figsize=None):
    """Time histories of a simulated loop, one panel a quantity.

    Parameters
    ----------
    response : Response
        What `Design.simulate` returns: t in s, and z, dz, e, u by row.
    u_max : float, optional
        Drawn as a limit in the panel of u; the norm of u is drawn beside it.
    disturbance : (start, stop), optional
        A window in seconds, shaded in every panel.
    panels : sequence of "z", "dz", "e", "u", optional
        All four if left out; z, z' and e in their plant's units.
    names : dict, optional
        Axis labels in place of the standard ones, {"z": "z (rad)"}.

    Returns
    -------
    matplotlib.figure.Figure
    """
    labels = {"z": "position z", "dz": "velocity z′ (1/s)",
              "e": "error e = z − r", "u": "input u"} | dict(names or {})
    panels = tuple(panels or ("z", "dz", "e", "u"))
    columns = 1 if len(panels) == 1 else 2
    rows = -(-len(panels) // columns)
    figure, axes = plt.subplots(
        rows, columns, squeeze=False, sharex=True,
        figsize=figsize or (6.8 if columns == 2 else 4.6, 0.4 + 2.1 * rows))
    for ax, key in zip(axes.flat, panels):
        signal(ax, response.t, getattr(response, key),
               name="z′" if key == "dz" else key, disturbance=disturbance)
        if ax is not axes[0, 0] and disturbance is not None:
            ax.patches[0].set_label("_")           # named once is enough
        if key == "u" and u_max is not None:
            input_limit(ax, response.t, response.u, u_max)
        ax.set_ylabel(labels[key])
        _legend_above(ax, 5)
    for ax in axes.flat[len(panels):]:
        ax.set_visible(False)
    for ax in axes[-1]:
        ax.set_xlabel("time t (s)")
    return figure


def signal(ax, t, values, name="z", disturbance=None, points=400):
    """Rows of a signal over time; `disturbance` shades a window of it."""
    t, values = np.asarray(t), _rows(t, values)
    step = max(1, len(t) // points)
    keep = np.unique(np.r_[np.arange(0, len(t), step), len(t) - 1])
    if disturbance is not None:
        ax.axvspan(*disturbance, color=ORANGE, alpha=0.15, linewidth=0,
                   label="disturbance")
    for k, row in enumerate(values):
        mark = _subscript(k + 1) if len(values) > 1 else ""
        ax.plot(t[keep], row[keep], color=COLOURS[k % 6],
                linestyle=DASHES[k % 6],
                label=name.rstrip("′") + mark + "′" * name.endswith("′"))
    ax.margins(x=0)
    return ax


def input_limit(ax, t, u, u_max):
    """The norm of u and the limit u_max that Lemma 2.2 speaks of."""
    norm = np.linalg.norm(_rows(t, u), axis=0)
    step = max(1, len(t) // 400)
    ax.plot(np.asarray(t)[::step], norm[::step], color=GREY, linestyle="-",
            linewidth=1, label="‖u‖")
    ax.axhline(u_max, color=VERMILLION, linestyle=(0, (1, 1)), linewidth=1.4,
               label="u_max")
    return ax


def _rows(t, values):
    """A signal as (channels, times), the layout of `Response`."""
    values = np.atleast_2d(values)
    if values.shape[1] != len(t):
        raise ValueError(
            f"values has shape {values.shape}, needs one row a channel and "
            f"one column for each of the {len(t)} times")
    return values


def margins(ax, margins, labels=None):
    """Bars on a logarithmic scale: how far each requirement is from failing.

    A requirement that is violated is hatched and says so; its bar has the
    size of the violation.

    Parameters
    ----------
    ax : matplotlib Axes
    margins : dict
        {"half-plane": 0.12, …}: smallest eigenvalue of each block, scaled.
        Of the blocks of a polytope, "half-plane 1", "half-plane 1,2", …,
        the smallest is drawn.
    labels : dict, optional
        Other words for the keys.
    """
    names = {"P": "P > 0", "half-plane": "half-plane σ", "sector": "sector θ",
             "disk": "disk ρ", "hinf": "H∞ bound γ", "x0": "x(0) in ellipsoid",
             "u_max": "‖u‖ ≤ u_max"} | dict(labels or {})
    margins = smallest_of_each(margins)
    keys = list(margins)
    sizes = np.array([abs(float(margins[key])) for key in keys])
    held = [float(margins[key]) > 0 for key in keys]
    floor = 10.0 ** np.floor(np.log10(max(np.min(
        sizes, where=sizes > 0, initial=1.0), 1e-16)) - 0.5)
    top = max(floor, np.max(sizes, initial=0.0)) * 30
    places = np.arange(len(keys))[::-1]
    for place, size, good in zip(places, np.maximum(sizes, floor), held):
        ax.barh(place, size - floor, left=floor, height=0.62,
                color=BLUE if good else "white", linewidth=1,
                edgecolor=BLUE if good else VERMILLION,
                hatch=None if good else "////")
        ax.text(size * 1.15, place, f"{size:.1e}" if good else
                f"violated by {size:.1e}", va="center", fontsize=8)
    ax.set_xscale("log")
    ax.set_xlim(floor, top)
    ax.set_yticks(places, [names.get(key, key) for key in keys])
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("smallest scaled eigenvalue")
    return ax


def smallest_of_each(margins):
    """The smallest margin of each requirement over vertices and pairs.

    Examples
    --------
    >>> smallest_of_each({"P": 0.3, "disk 1": 0.2, "disk 1,2": 0.1})
    {'P': 0.3, 'disk': 0.1}
    """
    least = {}
    for name, value in margins.items():
        name = re.sub(r" [\d,]+$", "", name)
        least[name] = min(float(value), least.get(name, np.inf))
    return least


def singular_values(ax, systems, gamma=None, frequency=None):
    """Largest singular value of the disturbance-to-position map over frequency.

    Parameters
    ----------
    ax : matplotlib Axes
    systems : StateSpace, or a tuple of them for a polytope
        As `Design.closed_loop` returns them, reduced to the channel of
        interest: ``loop[:n, :p]``.
    gamma : float, optional
        The bound asked for, drawn as a line.
    frequency : array, optional
        In rad/s; chosen from the poles if left out.
    """
    systems = systems if isinstance(systems, (list, tuple)) else (systems,)
    if frequency is None:
        size = np.abs(np.concatenate([system.poles() for system in systems]))
        frequency = np.geomspace(max(size.min(), 1e-3) / 20, size.max() * 10,
                                 120)
    for k, system in enumerate(systems):
        values = largest_singular_value(
            system.A, system.B, system.C, system.D, frequency)
        ax.plot(frequency, values, color=COLOURS[k % 6],
                linestyle=DASHES[k % 6],
                label="σ_max" if len(systems) == 1 else f"vertex {k + 1}")
    if gamma is not None:
        ax.axhline(gamma, color=VERMILLION, linestyle=(0, (1, 1)),
                   label="bound γ")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("frequency ω (rad/s)")
    ax.set_ylabel("largest singular value")
    _legend_above(ax, 4)
    return ax


def largest_singular_value(A, B, C, D, frequency):
    """max singular value of C (jωI - A)⁻¹ B + D at each frequency in rad/s.

    Examples
    --------
    >>> largest_singular_value([[-1]], [[1]], [[2]], [[0]], [0.0])
    array([2.])
    """
    A, B, C, D = (np.atleast_2d(np.asarray(X, float)) for X in (A, B, C, D))
    points = 1j * np.asarray(frequency, float)[:, None, None]
    gain = C @ np.linalg.solve(points * np.eye(len(A)) - A,
                               np.broadcast_to(B, (len(points), *B.shape))) + D
    return np.linalg.svd(gain, compute_uv=False)[:, 0]


def ellipsoid(ax, P, plane=(0, 1), x0=None, x=None, names=None):
    """Shadow of the ellipsoid x' P⁻¹ x <= 1 on two coordinates (Lemma 2.2).

    Parameters
    ----------
    ax : matplotlib Axes
    P : (order, order) array
    plane : (int, int)
        The two coordinates of x.
    x0 : array, optional
        The start, drawn as a dot.
    x : (T, order) array, optional
        A trajectory to draw.
    names : (str, str), optional
    """
    i, j = plane
    outline = ellipse_outline(P, plane)
    ax.fill(*outline, facecolor=SKY, alpha=0.25, edgecolor=BLUE, linewidth=1,
            label="x' P⁻¹ x ≤ 1")
    if x is not None:
        x = np.asarray(x)
        ax.plot(x[:, i], x[:, j], color=INK, linestyle="-", linewidth=1.1,
                label="x(t)")
    if x0 is not None:
        ax.plot(x0[i], x0[j], marker="o", linestyle="none", color=VERMILLION,
                label="x(0)")
    ax.set_xlabel((names or (f"x{_subscript(i + 1)}",) * 2)[0])
    ax.set_ylabel((names or ("", f"x{_subscript(j + 1)}"))[1])
    _legend_above(ax, 3)
    return ax


def ellipse_outline(P, plane=(0, 1), corners=120):
    """Outline (2, corners) of the shadow of x' P⁻¹ x <= 1 on two coordinates.

    Examples
    --------
    >>> ellipse_outline([[4, 0], [0, 9]], corners=2).round(6) + 0.0
    array([[ 2., -2.],
           [ 0.,  0.]])
    """
    block = np.asarray(P, float)[np.ix_(plane, plane)]
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.linalg.cholesky(block) @ np.array([np.cos(angle), np.sin(angle)])


def _subscript(number):
    return str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


def _legend_above(ax, columns):
    """A legend over the axes, where it hides nothing."""
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2,
                  ncols=columns, handlelength=1.8, columnspacing=0.9,
                  handletextpad=0.5)
