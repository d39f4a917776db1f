"""Designs as a page stores them: one record for each kind of element.

Everything is rounded, so that the page's data are the same on any machine.
"""

import numpy as np

from ...requirements.hinf import HInfinity
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion
from ...requirements.stability import Stability
from ...requirements.vocabulary import Parameter
from .page import significant

NOT_FEASIBLE = {"infeasible": 0, "undecided": 1}  # the record of no design
#: Titles of the blocks that every page knows; others join a page's own list.
_OWNERS = (*PoleRegion(1, 1, 2).parts, HInfinity(1), Saturation(1, [1]), Stability())
BLOCKS = ("P > 0", *(x for r in _OWNERS for x in r.titles.values()), "scale")
#: What a request under delay can move; "ratio" is mu / tau.
DELAY_PARAMETERS = {
    p.key: p
    for p in (
        Parameter("tau", "delay tau", "Nominal delay τ", "τ", " s"),
        Parameter("mu", "variation mu", "Variation of the delay μ", "μ", " s", 1),
        Parameter("ratio", "variation mu / tau", "Variation μ/τ", "μ/τ", harder=1),
        Parameter("delta", "decay rate delta", "Decay rate δ", "δ", " 1/s", harder=1),
        Parameter("alpha", "scalar alpha", "Scalar α", "α", " s"),
    )
}
#: Titles of the blocks of a design under delay.
DELAY_BLOCKS = {
    "functional": "V is positive",
    "R": "the kernel R of V",
    "Z": "the kernel Z of V",
    "decay": "V decays",
}


def delay_record(design):
    """A design as a page stores it: rounded, and nothing like -0.

    ``design``: the design, or the lack of one. Returns int or list: 0 if infeasible, 1
    if undecided, else [K row by row (4 digits), [block, smallest margin (2 digits)],
    [true slowest rate, delay where it occurs (3 digits)], [for the shortest, nominal
    and longest delay the rightmost roots with Im >= 0, as re, im, re, im, ... (3
    digits)]].
    """
    if design.status != "feasible":
        return NOT_FEASIBLE[design.status]
    tau, mu = design.request.tau, design.request.mu
    worst, margin = tightest(design)
    return [
        significant(np.ravel(design.K), 4),
        [list(DELAY_BLOCKS).index(worst), significant(margin, 2)],
        significant(design.slowest_decay(), 3),
        [_upper_half(design.roots(d), 3) for d in (tau - mu, tau, tau + mu)],
    ]


def map_record(design, blocks):
    """A certified design as a feasibility map stores it.

    ``design``: a certified design; ``blocks``: the page's titles of blocks; new ones
    join it. Returns dict: K row by row (4 digits), and the index of the tightest block.
    """
    worst, _ = tightest(design)
    return {
        "K": significant(np.ravel(design.K), 4),
        "block": block_index(worst, design.request, blocks),
    }


def tightest(design):
    """The key of the block with the smallest margin, and that margin."""
    worst = min(design.margins, key=design.margins.get)
    return worst, design.margins[worst]


def block_index(name, request, blocks=None):
    """Index of a block's words in the page's list; new ones join it."""
    blocks = list(BLOCKS) if blocks is None else blocks
    owners = [r for r in request.demands if r.key == name.requirement]
    title = owners[0].titles.get(name.block, str(name)) if owners else BLOCKS[0]
    if title not in blocks:
        blocks.append(title)
    return blocks.index(title)


def _upper_half(poles, digits):
    """Poles with Im >= 0 as re, im, re, im, ..."""
    poles = np.ravel(poles)
    poles = poles[poles.imag >= 0]
    return significant(np.stack([poles.real, poles.imag], axis=1).ravel(), digits)
