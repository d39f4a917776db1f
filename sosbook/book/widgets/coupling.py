"""Move the spread of the vertices: three couplings side by side."""

import numpy as np

from ...analysis.linear import poles
from ...plants.descriptor import COUPLINGS, descriptors
from ...plants.second_order import Polytope
from ...studies.polytopes import sample_plants, scale_polytope
from ..plots import BLUE, GREY, VERMILLION, window_of
from .charts import plane
from .explorer import Explorer, Follower, linear, note, page

__all__ = ["explore_coupling"]

KEPT = "feasible, and kept at every sampled plant"


def explore_coupling(plants, region=None, count=11, slack=None, **asked):
    """Widen a polytope; see what each coupling finds, and the truth.

    Parameters
    ----------
    plants : Polytope
        Its vertices move along the rays from their mean. The slider
        counts the largest relative change of a mass.
    region : Region, optional
        What is asked of the poles.
    count : int
        Steps between two vertices at which the poles are drawn.
    slack : float, optional
        The scalar of the slack matrix; without it every move is a line search.
    **asked
        Further keywords of `design_pid`.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    full = _mass_spread(plants)
    if full == 0:
        raise ValueError("plants has the same mass at all vertices")
    top = min(99.0, 125 * full)
    sliders = {"spread": linear("mass spread (± percent)", 100 * full, 0, top, ".0f")}

    follow = {name: Follower() for name in COUPLINGS}

    def draw(spread):
        polytope = scale_polytope(plants, spread / 100 / full)
        charts, verdicts = {}, []
        for order in (("vertices", "pairs"), ("slack",)):
            for name in order:
                design = follow[name](
                    polytope,
                    region=region,
                    coupling=name,
                    slack=slack if name == "slack" else None,
                    **asked,
                )
                charts[name], verdict = _one(name, design, region, count)
                verdicts.append(f"{name}: {verdict}")
            colour = VERMILLION if "<strong>" in str(verdicts) else BLUE
            yield note("; ".join(verdicts) + ".", colour) + page(*charts.values())

    return Explorer(sliders, draw)


def _mass_spread(plants):
    mean = plants.mean.M.diagonal()
    return max(np.abs(v.M.diagonal() / mean - 1).max() for v in plants.vertices)


def _one(name, design, region, count):
    """A chart of all poles, and the verdict in words."""
    plants = sample_plants(design.request.plant, count)
    if design.K is None:
        drawn = np.concatenate([v.poles() for v in plants])
        verdict, colour, mark = design.status, GREY, "circle"
    else:
        drawn = _closed_loop(plants, design)
        verdict, mark = _verdict(drawn, region), "cross"
        colour = BLUE if verdict == KEPT else VERMILLION
    window = window_of([drawn], region)
    chart = plane(window, f"Poles of all plants, coupling {name}", region, axis=True)
    chart.marks(drawn.real, drawn.imag, colour, mark)
    chart.names.append((name, colour))
    return chart.svg(), verdict


def _closed_loop(plants, design):
    request = design.request
    loops = descriptors(Polytope(plants), request.U, request.K_A)
    return np.concatenate([poles(d, design.K) for d in loops])


def _verdict(drawn, region):
    if drawn.real.max() >= 0:
        return "<strong>feasible, and UNSTABLE inside</strong>"
    if region is not None and not region.contains(drawn):
        return "<strong>feasible, and a pole has LEFT the region</strong>"
    return KEPT
