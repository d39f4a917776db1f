"""Sliders whose every position is solved by the reader's own browser."""

import numpy as np

from ...plants.coupling import coupling_of
from ...requirements import HInfinity
from ...requirements.shorthand import parameter
from ...runtime.threads import one_thread
from ...synthesis.request import Request
from .page import PageElement, significant
from .program import page_loop, program_data, shown

LARGEST = 4  # degrees of freedom and vertices that a browser solves while one waits


class Explorer(PageElement):
    """A page element that solves LMIs where its sliders stand.

    Made by `design_explorer`; put it last in a cell.

    Parameters
    ----------
    data : dict
        What the page needs to know: title, sliders, the plant, what is fixed.
    """

    tag, script, sheets = "sos-explorer", "explorer", ("explorer",)
    notice = "Sliders that solve the LMIs in your browser"

    def __init__(self, data):
        self.data, self.title = data, data["title"]

    def __repr__(self):
        names = ", ".join(s["key"] for s in self.data["sliders"])
        return f"Explorer: {self.title} ({names})"


@one_thread
def design_explorer(
    plant,
    U=None,
    gamma=None,
    saturation=None,
    *,
    sigma=None,
    theta=None,
    rho=None,
    u_max=None,
    cost=None,
    cost_bound=None,
    K_A=None,
    coupling="pairs",
    mu=None,
    r=None,
    horizon=8.0,
    start=None,
    title="Move the requirements",
):
    """An `Explorer` of the requirements of Procedure 2.1.

    Each of sigma, theta, rho, gamma, u_max and cost_bound is left out (not asked), a
    number (asked, fixed) or a pair (a slider from the one to the other).

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant: at most four degrees of freedom and four vertices.
    U : (a, n) array_like, optional
        The rows of U z are integrated; without it the law is PD.
    gamma : float or pair, optional
        Bound of the H-infinity norm from w to z.
    saturation : Saturation, optional
        Its x0 also serves the slider u_max, which overrides its u_max.
    sigma, theta, rho, u_max : float or pair, optional
        theta in radians; shown in degrees.
    cost : QuadraticCost, optional
        The weights of the cost, and how the noise enters.
    cost_bound : float or pair, optional
        Bound of the cost; overrides that of ``cost``.
    K_A
        As in `design_pid`.
    coupling : {"pairs", "vertices"}
        As in `design_pid`; the page has no slack matrix.
    mu
        As in `design_pid`.
    r : (n,) array_like, optional
        Set point of the step response; ones if left out.
    horizon : float
        Seconds shown of the step response.
    start : dict, optional
        {"sigma": 0.7, …}: where the sliders stand at first; in the middle
        without it.
    title : str
        The heading of the element.

    Returns
    -------
    Explorer
        The element, without any design: the page finds them.

    Raises
    ------
    ValueError
        If nothing is a pair, a pair isn't rising, ``start`` lies outside, the plant
        is too large, u_max is given without a saturation, or a cost doesn't fit.

    Examples
    --------
    >>> import sosbook as sos
    >>> from sosbook.book import thesis
    >>> robot = thesis.example_1()
    >>> design_explorer(robot.plant, robot.U, sigma=(0.1, 2), rho=5.0)
    Explorer: Move the requirements (sigma)
    """
    wanted = coupling_of(coupling)
    if wanted.chooses or not wanted.one_P:
        raise ValueError(f'coupling must be "pairs" or "vertices", got {coupling!r}')
    hinf = HInfinity(1.0, mu)
    if plant.n > LARGEST or len(plant.vertices) > LARGEST:
        raise ValueError(
            f"the page solves up to {LARGEST} degrees of freedom and vertices: "
            "show a map of the designs, studies.maps.frontier in MapAtlas"
        )
    if saturation is not None and u_max is None:
        u_max = saturation.u_max
    if u_max is not None and saturation is None:
        raise ValueError("u_max needs saturation=Saturation(u_max, x0)")
    if cost is not None and cost_bound is None:
        cost_bound = cost.bound
    if (cost is None) != (cost_bound is None):
        raise ValueError("a cost needs both cost=QuadraticCost(Q, R) and a cost_bound")
    asked = dict(sigma=sigma, theta=theta, rho=rho, gamma=gamma)
    asked |= dict(cost=cost_bound, u_max=u_max)
    asked = {key: value for key, value in asked.items() if value is not None}
    start = dict(start or {})
    sliders = [
        _slider(key, value, start.pop(key, None))
        for key, value in asked.items()
        if np.ndim(value)
    ]
    if not sliders:
        raise ValueError("nothing to slide: give a pair for sigma, theta, rho, …")
    if start:
        raise ValueError(f"start names no slider: {sorted(start)}")
    fixed = {key: float(value) for key, value in asked.items() if not np.ndim(value)}
    tops = {s["key"]: s["max"] for s in sliders}
    far = tops.get("rho", fixed.get("rho")) or 4 * tops.get("sigma", 2.5)
    saturation, cost = (x and x.with_bound(1.0) for x in (saturation, cost))
    held = () if cost is None else (cost,)
    sizes = dict(saturation=saturation, requirements=held)
    request = Request(plant, U, K_A=K_A, coupling=coupling, **sizes)
    data = page_loop(request, r, horizon) | shown(fixed, (), far)
    data |= program_data(request) | {"mu": hinf.mu}
    return Explorer({"title": title, "sliders": sliders} | data)


def _slider(key, ends, value):
    """The data of a slider, in the unit that it shows."""
    which = parameter(key)
    if len(ends) != 2 or not 0 < ends[0] < ends[1] or which.fault(ends):
        raise ValueError(
            f"{key} must be a number, or a pair of positive numbers that rises"
            + (f": {which.fault(ends)}" if which.fault(ends) else "")
        )
    low, high = (significant(which.shown(x), 6) for x in ends)
    wide = high / low > 4 and key not in ("sigma", "theta")
    middle = significant(np.sqrt(low * high) if wide else (low + high) / 2, 2)
    value = significant(middle if value is None else which.shown(value), 6)
    if not low <= value <= high:
        raise ValueError(f"start: {key} lies outside of its slider")
    names = "label", "symbol", "unit", "degrees"
    words = {"key": key} | {name: getattr(which, name) for name in names}
    where = {"min": low, "max": high, "value": value}
    return words | where | {"looser": -which.harder, "log": bool(wide)}
