"""A wish whose numbers move: each is solved by the reader's own browser."""

from ...plants.coupling import coupling_of
from ...requirements.shorthand import bounds, parameter
from ...runtime.threads import one_thread
from ...synthesis.request import Request
from .page import PageElement, significant
from .program import page_loop, program_data

LARGEST = 4  # degrees of freedom and vertices that a browser solves while one waits
KEYS = "sigma", "theta", "rho", "gamma", "cost", "u_max"  # of bounds that a page knows


class Explorer(PageElement):
    """A page element that solves the LMIs of a sentence whose numbers move.

    Made by `design_explorer`; put it last in a cell.

    Parameters
    ----------
    data : dict
        What the page needs to know: title, plant, bounds and which of them move.
    """

    tag, script, sheets = "sos-wish", "wish", ("wish",)

    def __init__(self, data):
        self.data, self.title = data, data["title"]

    def __repr__(self):
        names = ", ".join(x["key"] for x in self.data["bounds"] if x["moves"])
        return f"Explorer: {self.title} ({names})"


@one_thread
def design_explorer(
    plant,
    U=None,
    *,
    move=None,
    symbols=False,
    words=None,
    r=None,
    horizon=8.0,
    title="Move the requirements",
    **asked,
):
    """An `Explorer` of what is asked: one sentence, whose numbers are its controls.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant: at most four degrees of freedom and four vertices.
    U : (a, n) array_like, optional
        The rows of U z are integrated; without it the law is PD.
    move : str, optional
        The bounds whose numbers move, such as "sigma rho": of sigma, theta, rho, gamma,
        cost and u_max. All that are asked without it.
    symbols : bool
        Say σ, θ, ρ and γ, not an engineer's times.
    words : dict, optional
        What things are called, as in `read_wish`.
    r : (n,) array_like, optional
        Set point of the step response; ones if left out.
    horizon : float
        Seconds shown of the step response.
    title : str
        The heading of the element.
    **asked
        What `design_pid` takes: region, gamma, saturation, requirements, K_A and
        coupling. The page has no slack matrix.

    Returns
    -------
    Explorer
        The element, without any design: the page finds them.

    Raises
    ------
    ValueError
        If nothing moves, ``move`` names what isn't asked, the plant is too large, or
        something is asked that no page solves.

    Examples
    --------
    >>> import sosbook as sos
    >>> from sosbook.book import thesis
    >>> robot = thesis.example_1()
    >>> region = sos.PoleRegion(sigma=0.7, rho=5.0)
    >>> design_explorer(robot.plant, robot.U, region=region, move="sigma")
    Explorer: Move the requirements (sigma)
    """
    wanted = coupling_of(asked.get("coupling", "pairs"))
    if wanted.chooses or not wanted.one_P:
        raise ValueError(
            f'coupling must be "pairs" or "vertices", got {asked["coupling"]!r}'
        )
    if plant.n > LARGEST or len(plant.vertices) > LARGEST:
        raise ValueError(
            f"the page solves up to {LARGEST} degrees of freedom and vertices: "
            "show a map of the designs, studies.maps.frontier in MapAtlas"
        )
    request = Request(plant, U, **asked)
    held = request.requirements
    data = program_data(request)
    strange = [x["text"] for x in data.pop("own")]
    if strange or not request.law.whole:
        raise ValueError(
            f"no page solves {', '.join(strange) or 'a law'}: leave it out"
        )
    found = bounds(held)
    names = list(found) if move is None else move.split()
    if not names:
        raise ValueError(
            "nothing moves: ask for a region, gamma, a saturation or a cost"
        )
    if unasked := [name for name in names if name not in found]:
        raise ValueError(
            f"move names {', '.join(unasked)}, and asked are {', '.join(found)}"
        )
    shown = {
        key: parameter(key, held).shown(found[key]) for key in KEYS if key in found
    }
    far = found.get("rho") or 4 * found.get("sigma", 2.5)
    data |= page_loop(request, r, horizon) | {
        "title": title,
        "bounds": [
            {"key": key, "value": significant(x, 12), "moves": key in names}
            for key, x in shown.items()
        ],
        "window": significant([-1.06 * far, 0.2 * far, far], 3),
    }
    return Explorer(
        data | {"symbols": symbols} | ({} if words is None else {"words": dict(words)})
    )
