"""Sliders that work in the rendered page: a grid of designs, really solved.

A page has no Python behind it, so the designs come with it: gains, poles and
margins of every point of a grid.  A slider snaps to a solved design; gains are
never interpolated, and where there is none the page says "infeasible".
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from ...plants.second_order import SecondOrderSystem
from ...requirements.shorthand import bounds, collected, contradictory, moved, parameter
from ...requirements.vocabulary import Parameter
from ...runtime.progress import each
from ...synthesis.pid import design_pid
from ...synthesis.request import Request
from .page import PageElement, significant
from .program import program_data
from .records import BLOCKS, record

__all__ = ["Atlas", "Slider", "design_atlas"]


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
        return {
            "key": self.key,
            "label": self.label,
            "texts": self.texts,
            "values": [significant(v, 8) for v in self.values],
            "looser": self.looser,
        }


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
    gamma=None,
    saturation=None,
    *,
    sigma=None,
    theta=None,
    rho=None,
    u_max=None,
    K_A=None,
    coupling="pairs",
    r=None,
    horizon=None,
    start=None,
    title="Move the requirements",
    progress=True,
    requirements=(),
    slide=None,
    mu=None,
):
    """Solve Procedure 2.1 on a grid of requirements and return its `Atlas`.

    Each of sigma, theta, rho, gamma and u_max is left out (not asked), a
    number (asked, fixed) or a sequence (a slider over these values).

    Where a request is proven infeasible, every request that asks for more is
    infeasible too and isn't solved again.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.
    U : (a, n) array_like, optional
        The rows of U z are integrated; without it the law is PD.
    gamma : float or sequence, optional
        Bound of the H-infinity norm from w to z.
    saturation : Saturation, optional
        Its x0 also serves the slider u_max, which overrides its u_max.
    sigma, theta, rho, u_max : float or sequence, optional
        theta in radians; shown in degrees.
    K_A, coupling
        As in `design_pid`.
    r : (n,) array_like, optional
        Set point of the step response; ones if left out.
    horizon : float, optional
        Seconds shown of the step response; 8 if left out.
    start : dict, optional
        {"sigma": 0.7, …}: where the sliders stand at first; values of the
        grid.  A slider that isn't named stands in the middle.
    title : str
        The heading of the element.
    progress : bool
        Show a progress bar, unless the environment variable
        TQDM_DISABLE is set.
    requirements : sequence of Requirement, optional
        More of what is asked: regions, a cost, one of your own.
    slide : dict, optional
        A number or a sequence, as for sigma, by the parameters of those.
    mu : float, optional
        As in `design_pid`.

    Returns
    -------
    Atlas
        The element, with every design of the grid.

    Raises
    ------
    ValueError
        If nothing is a sequence, a value isn't on the grid, or u_max is
        given without a saturation.

    Notes
    -----
    Source: thesis, Procedure 2.1.
    """
    asked = {"sigma": sigma, "theta": theta, "rho": rho, "gamma": gamma, "u_max": u_max}
    asked |= slide or {}
    held = (
        collected(requirements=requirements)
        if saturation is None
        else (collected(saturation=saturation, requirements=requirements))
    )
    moved(
        held,
        {
            key: parameter(key, held).start
            for key, values in asked.items()
            if values is not None
        },
    )  # refuses
    sliders = [
        Slider(key, tuple(sorted(map(float, values))), parameter(key, held))
        for key, values in asked.items()
        if np.ndim(values) == 1
    ]
    if not sliders:
        raise ValueError(
            "nothing to slide: give a sequence for sigma, theta, rho, gamma or u_max"
        )
    fixed = {
        key: float(value)
        for key, value in asked.items()
        if value is not None and np.ndim(value) == 0
    }
    fixed |= {
        key: value for key, value in bounds(held).items() if asked.get(key) is None
    }

    def solve(values):
        at = moved(held, fixed | values)
        if contradictory(at):  # the region is empty
            return None
        return design_pid(plant, U, K_A=K_A, coupling=coupling, requirements=at, mu=mu)

    blocks = list(BLOCKS)
    designs, spread = _solve_grid(sliders, solve, progress, blocks)
    loop = page_loop(plant, U, K_A, r, horizon or 8.0)
    loop["fixed"] = {k: significant(v, 8) for k, v in fixed.items()}
    loop["shownFixed"] = {k: parameter(k, held).shown(v) for k, v in fixed.items()}
    loop["also"] = [parameter(key, held).text(value) for key, value in fixed.items()]
    loop["window"] = _window(sliders, fixed, spread)
    loop["blocks"] = blocks
    first = moved(held, fixed | {s.key: s.values[0] for s in sliders})
    request = Request(plant, U, K_A=K_A, coupling=coupling, requirements=first)
    loop |= program_data(request) | {"mu": mu}
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
        if design is None:
            designs[place] = 0
            continue
        designs[place] = record(design, blocks)
        if design.status == "feasible":
            reach = max(reach, np.abs(design.poles()).max())
    return designs, reach


def page_loop(plant, U, K_A, r, horizon):
    """The plant in the numbers that the page's step response needs."""
    request = Request(plant, U, K_A=K_A)
    n, a = plant.n, request.order - 2 * plant.n
    r = np.ones(n) if r is None else np.asarray(r, float)
    if r.shape != (n,):
        raise ValueError(f"r must hold n = {n} numbers")
    vertices = []
    for d in request.vertices:
        A, B, _ = d.state_space()
        s = np.concatenate([np.zeros(2 * n), -d.A[2 * n :, :n] @ r])
        vertices.append({"A": _table(A), "B": _table(B), "s": _row(s)})
    many = "" if isinstance(plant, SecondOrderSystem) else ", every vertex"
    goal = ", ".join(f"{x:.4g}" for x in r)
    return {
        "shape": [n, plant.m, a],
        "vertices": vertices,
        "r": _row(r),
        "horizon": significant(horizon, 8),
        "caption": f"Step response from rest to the set point ({goal}){many}.",
    }


def _window(sliders, fixed, reach):
    """[left, right, height] that holds every region and every pole."""
    values = {s.key: s.values for s in sliders}
    rho = max(values.get("rho", ()), default=fixed.get("rho"))
    far = rho if rho is not None else 1.1 * (reach or 1.0)
    return [significant(-1.06 * far, 3), significant(0.2 * far, 3), significant(far, 3)]


def start_place(sliders, start):
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


def _row(values):
    return [significant(x, 12) for x in values]


def _table(matrix):
    return [_row(row) for row in matrix]
