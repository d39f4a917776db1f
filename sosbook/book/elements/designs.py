"""Sliders that work in the rendered page: a grid of designs, really solved.

A page has no Python behind it, so the designs come with it: gains, poles and
margins of every point of a grid.  A slider snaps to a solved design; gains are
never interpolated, and where there is none the page says "infeasible".
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from ...plants.second_order import SecondOrderSystem
from ...requirements.shorthand import bounds as bounds_of
from ...requirements.shorthand import collected, contradictory, moved, parameter
from ...requirements.vocabulary import PARAMETERS, Parameter
from ...runtime.progress import each
from ...synthesis.pid import design_pid
from ...synthesis.request import Request
from .page import PageElement, significant
from .program import program_data
from .records import BLOCKS, record


@dataclass(frozen=True)
class Slider:
    """One requirement and the values it is solved for.

    Parameters
    ----------
    key : str
        Name of the parameter: "sigma", "theta", "rho", "gamma", "u_max", ...
    values : tuple of float
        Increasing, in the units of the design functions (theta in radians).
    which : Parameter, optional
        Needed for the parameter of a requirement of your own.

    Examples
    --------
    >>> Slider("theta", (0.5235987755982988,)).texts
    ['θ = 30°']
    """

    key: str
    values: tuple
    which: Parameter | None = None

    @property
    def parameter(self):
        """The parameter that the slider moves."""
        return self.which or parameter(self.key)

    @property
    def label(self):
        """The words beside the slider."""
        return self.parameter.label

    @property
    def texts(self):
        """Each value in words, for the page and for screen readers."""
        return [self.parameter.text(value) for value in self.values]

    @property
    def looser(self):
        """Direction, +1 or -1, in which the requirement asks for less."""
        return -self.parameter.harder

    def data(self):
        """What the page needs to know."""
        names = "key", "label", "texts", "values", "looser"
        data = {name: getattr(self, name) for name in names}
        return data | {"values": significant(self.values, 8)}


class Atlas(PageElement):
    """A page element with sliders over solved designs; put it last in a cell.

    Made by `design_atlas`.

    Parameters
    ----------
    title : str
        The heading of the element.
    sliders : sequence of Slider
        What can be moved, and to which values.
    designs : dict
        The record by a tuple of indices, one a slider: 0 (infeasible),
        1 (undecided) or what `record` returns.
    loop : dict
        The plant for the page: shape, vertices, r, horizon, window, fixed
        requirements, caption.
    start : tuple of int, optional
        Where the sliders stand at first; the middle if left out.
    """

    tag, script = "sos-atlas", "atlas"
    notice = "Sliders over solved designs"

    def __init__(self, title, sliders, designs, loop, start=None):
        self.title, self.sliders = title, tuple(sliders)
        self.designs, self.loop = dict(designs), dict(loop)
        sizes = [len(slider.values) for slider in self.sliders]
        self.start = tuple(start or [length // 2 for length in sizes])
        places = list(product(*map(range, sizes)))
        missing = [place for place in places if place not in self.designs]
        if missing:
            raise ValueError(
                f"designs lacks {len(missing)} places of the "
                f"grid, the first is {missing[0]}"
            )
        self.data = {
            "title": title,
            "sliders": [s.data() for s in self.sliders],
            "start": list(self.start),
            **self.loop,
            "designs": [self.designs[place] for place in places],
        }

    def __len__(self):
        return len(self.designs)

    def __repr__(self):
        held = sum(not isinstance(d, int) for d in self.designs.values())
        return (
            f"Atlas: {len(self)} requests solved, {held} feasible, "
            f"{len(self) - held} not"
        )


def design_atlas(
    plant,
    U=None,
    *,
    requirements=(),
    slide=None,
    K_A=None,
    coupling="pairs",
    mu=None,
    r=None,
    horizon=8.0,
    start=None,
    title="Move the requirements",
    progress=True,
    **bounds,
):
    """Solve Procedure 2.1 on a grid of requirements and return its `Atlas`.

    Each of sigma, theta, rho, gamma, u_max and of the parameters of ``requirements`` is
    left out (not asked, or fixed as its requirement has it), a number (fixed) or a
    sequence (a slider over these values).

    Where a request is proven infeasible, every request that asks for more is
    infeasible too and isn't solved again.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.
    U : (a, n) array_like, optional
        The rows of U z are integrated; without it the law is PD.
    requirements : sequence of Requirement, optional
        What is asked beside the bounds: an input bound, a cost, one of your own.
    slide : dict, optional
        More bounds, by names that can't be keywords.
    K_A, coupling, mu
        As in `design_pid`.
    r : (n,) array_like, optional
        Set point of the step response; ones if left out.
    horizon : float
        Seconds shown of the step response.
    start : dict, optional
        {"sigma": 0.7, …}: where the sliders stand at first; values of the
        grid.  A slider that isn't named stands in the middle.
    title : str
        The heading of the element.
    progress : bool
        Show a progress bar, unless the environment variable
        TQDM_DISABLE is set.
    **bounds : float or sequence of float
        By the parameters' names; theta in radians, shown in degrees.

    Raises
    ------
    ValueError
        If nothing is a sequence, a value isn't on the grid, or u_max is
        given without a `Saturation`.

    Notes
    -----
    Source: thesis, Procedure 2.1.
    """
    held, given = collected(requirements=requirements), bounds | (slide or {})
    keys = dict.fromkeys([*PARAMETERS, *given])  # in the book's order
    asked = {key: given[key] for key in keys if given.get(key) is not None}
    moved(held, {key: parameter(key, held).start for key in asked})  # refuses
    sliders = [
        Slider(key, tuple(sorted(map(float, values))), parameter(key, held))
        for key, values in asked.items()
        if np.ndim(values) == 1
    ]
    if not sliders:
        raise ValueError("nothing to slide: give a sequence for sigma, theta, rho, …")
    fixed = {key: float(x) for key, x in asked.items() if np.ndim(x) == 0}
    fixed |= {key: x for key, x in bounds_of(held).items() if key not in asked}

    def solve(values):
        at = moved(held, fixed | values)
        if contradictory(at):  # the region is empty
            return None
        return design_pid(plant, U, K_A=K_A, coupling=coupling, requirements=at, mu=mu)

    blocks = list(BLOCKS)
    designs, spread = _solve_grid(sliders, solve, progress, blocks)
    first = moved(held, fixed | {s.key: s.values[0] for s in sliders})
    request = Request(plant, U, K_A=K_A, coupling=coupling, requirements=first)
    tops = {s.key: s.values[-1] for s in sliders}
    far = (fixed | tops).get("rho") or 1.1 * (spread or 1.0)
    loop = page_loop(request, r, horizon) | shown(fixed, held, far)
    loop["fixed"] = {key: significant(value, 8) for key, value in fixed.items()}
    loop |= {"blocks": blocks} | program_data(request) | {"mu": mu}
    return Atlas(title, sliders, designs, loop, start_place(sliders, start))


def _solve_grid(sliders, solve, progress, blocks):
    """Every place of the grid, the least demanding first."""
    places = list(product(*(range(len(s.values)) for s in sliders)))
    tops = [len(s.values) - 1 for s in sliders]

    def demand(place):
        return tuple(
            at if s.looser < 0 else top - at for at, top, s in zip(place, tops, sliders)
        )

    places.sort(key=lambda place: (sum(demand(place)), place))
    designs, reach = {}, 0.0
    for place in each(places, "design", progress):
        looser = [
            place[:k] + (place[k] + s.looser,) + place[k + 1 :]
            for k, s in enumerate(sliders)
        ]
        if any(designs.get(easier) == 0 for easier in looser):
            designs[place] = 0
            continue
        values = {s.key: s.values[at] for s, at in zip(sliders, place)}
        design = solve(values)
        designs[place] = 0 if design is None else record(design, blocks)
        if design is not None and design.status == "feasible":
            reach = max(reach, np.abs(design.poles()).max())
    return designs, reach


def page_loop(request, r, horizon):
    """The plant of a request in the numbers that the page's step response needs.

    ``r``: its set point; ``horizon``: seconds that are shown.
    """
    plant = request.plant
    n, a = plant.n, request.order - 2 * plant.n
    r = np.ones(n) if r is None else np.asarray(r, float)
    if r.shape != (n,):
        raise ValueError(f"r must hold n = {n} numbers")
    vertices = []
    for d in request.vertices:
        A, B, _ = d.state_space()
        s = np.concatenate([np.zeros(2 * n), -d.A[2 * n :, :n] @ r])
        vertices.append({x: significant(X, 12) for x, X in zip("ABs", (A, B, s))})
    many = "" if isinstance(plant, SecondOrderSystem) else ", every vertex"
    goal = ", ".join(f"{x:.4g}" for x in r)
    return {
        "shape": [n, plant.m, a],
        "vertices": vertices,
        "r": significant(r, 12),
        "horizon": significant(horizon, 8),
        "caption": f"Step response from rest to the set point ({goal}){many}.",
    }


def shown(fixed, held, far):
    """What is ``fixed`` of the requirements ``held``, and a window out to ``far``."""
    which = {key: parameter(key, held) for key in fixed}
    return {
        "fixed": fixed,
        "shownFixed": {key: which[key].shown(value) for key, value in fixed.items()},
        "also": [which[key].text(value) for key, value in fixed.items()],
        "window": significant([-1.06 * far, 0.2 * far, far], 3),
    }


def start_place(sliders, start):
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
