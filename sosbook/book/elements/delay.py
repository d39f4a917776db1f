"""Designs under delay in the rendered page: a grid, really solved.

A page has no Python behind it, so it gets the gains, margins and roots of
every point of the grid. It computes the responses itself, for whatever way
the delay varies; gains are never interpolated.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from ...delay.profiles import RandomDelay
from ...delay.request import DelayRequest
from ...delay.solve import solve_delay
from ...runtime.progress import each
from ...synthesis.request import Request
from .page import PageElement, significant
from .program import page_loop, plant_data
from .records import DELAY_BLOCKS, DELAY_PARAMETERS, delay_record

#: Ways in which the delay varies within its interval.
DELAY_KINDS = ("constant", "sine", "sawtooth (sample and hold)", "switching", "random")
SINE_PERIOD, DWELL_TIME, SEED = 10, 2, 0  # period and dwell in units of tau
LINE_POINTS = 600  # of a drawn line; the page takes a multiple of it as steps


def unit_set_point(U):
    """The smallest r for which every integrated error asks for one: U r = 1.

    ``U``, (a, n): the rows of U z are integrated. Returns (n,): the set point of z.

    >>> unit_set_point([[0, 1]]).tolist()
    [0.0, 1.0]
    """
    U = np.asarray(U, float)
    return np.linalg.pinv(U) @ np.ones(len(U))


def output_name(U):
    """The integrated signal in words: "z1" where U picks one displacement.

    Examples
    --------
    >>> output_name([[0, 1]]), output_name([[1, 1]])
    ('z2', 'U z')
    """
    U = np.asarray(U, float)
    picks = len(U) == 1 and sorted(U[0])[::-1] == [1] + [0] * (U.shape[1] - 1)
    return f"z{U[0].argmax() + 1}" if picks else "U z"


@dataclass(frozen=True)
class Slider:
    """One number of a request under delay, and the values it is solved for.

    ``key``: its name in `DELAY_PARAMETERS`; ``values``: increasing, in SI units.

    >>> Slider("tau", (0.2, 0.4)).texts
    ['τ = 0.2 s', 'τ = 0.4 s']
    """

    key: str
    values: tuple

    @property
    def texts(self):
        """Each value in words, for the page and for screen readers."""
        return [DELAY_PARAMETERS[self.key].text(value) for value in self.values]

    def data(self):
        """The data of the page's element."""
        label = DELAY_PARAMETERS[self.key].label
        data = {"key": self.key, "label": label, "texts": self.texts}
        return data | {"values": significant(self.values, 8)}


class DelayAtlas(PageElement):
    """Sliders over solved designs under delay; made by `delay_atlas`.

    Parameters
    ----------
    title : str
        The heading of the element.
    sliders : sequence of Slider
        What can be moved, and to which values.
    designs : dict
        The record by a tuple of indices, one a slider: 0 (infeasible),
        1 (undecided) or what `delay_record` returns.
    loop : dict
        The plant for the page: shape, vertices, r, horizon, window, caption.
    start : tuple of int
        Where the sliders stand at first.
    """

    tag, script, sheets = "sos-delay", "delay", ("delay",)

    def __init__(self, title, sliders, designs, loop, start):
        self.title, self.sliders = title, tuple(sliders)
        self.designs, self.start = dict(designs), tuple(start)
        places = product(*(range(len(s.values)) for s in self.sliders))
        self.data = {
            "title": title,
            "sliders": [s.data() for s in self.sliders],
            "start": list(self.start),
            **loop,
            "designs": [self.designs[place] for place in places],
        }

    def __len__(self):
        return len(self.designs)

    def __repr__(self):
        held = sum(not isinstance(d, int) for d in self.designs.values())
        return (
            f"DelayAtlas: {len(self)} requests solved, {held} feasible, "
            f"{len(self) - held} not"
        )


def delay_atlas(
    example,
    taus,
    ratios,
    deltas,
    alphas=None,
    *,
    horizon=None,
    start=None,
    title="Move the delay and the decay rate",
    progress=True,
):
    """Solve Procedure 2.2, corrected, on a grid; return its `DelayAtlas`.

    Parameters
    ----------
    example : thesis.DelayExample
        Its plant and U; its alpha and t_end where these are left out.
    taus : sequence of float
        Nominal delays, in seconds.
    ratios : sequence of float
        mu / tau, from 0 to 1.
    deltas : sequence of float
        Decay rates, in 1/s.
    alphas : sequence of float, optional
        The scalars, in seconds. Without it the example's alpha for every
        point.
    horizon : float, optional
        Seconds shown of the responses.
    start : dict, optional
        {"tau": 0.4, "ratio": 0.5, …}: where the sliders stand at first;
        values of the grid. One that isn't named stands in the middle.
    title : str
        The heading of the element.
    progress : bool
        Show a progress bar, unless the environment variable
        TQDM_DISABLE is set.

    Returns
    -------
    DelayAtlas
        The element, with every design of the grid.

    Raises
    ------
    ValueError
        If a ratio isn't in [0, 1], a sequence is empty, a start value
        isn't on the grid, or the horizon is too long for the page.

    Notes
    -----
    Source: thesis, Procedure 2.2 and Theorem 2.3 with its errata.
    """
    asked = {"tau": taus, "ratio": ratios, "delta": deltas, "alpha": alphas}
    sliders = [
        Slider(key, tuple(sorted(map(float, values))))
        for key, values in asked.items()
        if values is not None
    ]
    for slider in sliders:
        if not slider.values:
            raise ValueError(f"{slider.key}s is empty: give one value or more")
    if not 0 <= min(ratios) <= max(ratios) <= 1:
        raise ValueError(
            "ratios are mu / tau: take them from [0, 1], for "
            "the delay tau - mu must not be negative"
        )
    place = _start_place(sliders, start)
    r = unit_set_point(example.U)
    loop = page_loop(Request(example.plant, example.U), r, horizon or example.t_end)
    steps = _steps(example.plant, loop["horizon"])
    designs = {}
    places = list(product(*(range(len(s.values)) for s in sliders)))
    for at in each(places, "design", progress):
        values = {s.key: s.values[k] for s, k in zip(sliders, at)}
        designs[at] = delay_record(solve_delay(request_of(example, **values)))
    count = int(loop["horizon"] / (DWELL_TIME * min(taus))) + 2
    loop |= {
        "also": [f"α = {example.alpha:.4g} s"] if alphas is None else [],
        "alpha": example.alpha,
        "request": plant_data(example.plant, example.U),
        "output": output_name(example.U),
        "caption": "Response from rest to a unit set point in "
        f"{output_name(example.U)}.",
        "blocks": list(DELAY_BLOCKS.values()),
        "kinds": DELAY_KINDS,
        "U": significant(example.U, 12),
        "varying": [
            SINE_PERIOD,
            DWELL_TIME,
            significant(RandomDelay(0.0, 1.0, 1.0, SEED)(np.arange(count)), 4),
        ],
        "window": _window(designs.values(), max(deltas)),
        "points": LINE_POINTS,
        "steps": steps,
    }
    return DelayAtlas(title, sliders, designs, loop, place)


def request_of(example, tau, ratio, delta, alpha=None):
    """The `DelayRequest` of a point of the grid."""
    alpha = example.alpha if alpha is None else alpha
    return DelayRequest(example.plant, example.U, tau, ratio * tau, delta, alpha)


def _start_place(sliders, start):
    """Where the sliders stand at first: indices of the values of ``start``."""
    start = dict(start or {})
    place = []
    for slider in sliders:
        wanted = start.pop(slider.key, None)
        if wanted is None:
            place.append(len(slider.values) // 2)
            continue
        near = int(np.argmin(np.abs(np.array(slider.values) - wanted)))
        if not np.isclose(slider.values[near], wanted):
            raise ValueError(
                f"start: {slider.key} = {wanted} is not a value of its slider"
            )
        place.append(near)
    if start:
        raise ValueError(f"start names no slider: {sorted(start)}")
    return tuple(place)


def _steps(plant, horizon):
    """Steps of the page's Runge-Kutta method: a quarter of the fastest rate."""
    turns = horizon * max(abs(plant.poles())) / 0.25
    steps = LINE_POINTS * max(4, int(np.ceil(turns / LINE_POINTS)))
    if steps > 20 * LINE_POINTS:
        raise ValueError(
            f"horizon = {horizon:.4g} s takes {steps} steps in the page: "
            "give a shorter one"
        )
    return steps


def _window(records, delta):
    """[left, right, height] that holds the rightmost roots of them all."""
    held = [roots for x in records if not isinstance(x, int) for roots in x[3]]
    first = [np.reshape(roots, (-1, 2))[:3] for roots in held]
    rightmost = np.concatenate([np.empty((0, 2)), *first])
    left = min(rightmost[:, 0].min(initial=-1.0), -2 * delta)
    height = rightmost[:, 1].max(initial=1.0)
    return significant([1.1 * left, -0.15 * left, 1.15 * height], 2)
