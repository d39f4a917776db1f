"""Rows that the examples of section 3.1 have in common."""

from ...analysis.linear import hinf_norm, peak_input, poles
from ...plants.descriptor import descriptors
from ...synthesis.pid import analyse_pid, design_pid
from .table import claim, compare, format_gain, format_poles, matched, proven, solution

__all__ = ["gains_row", "pole_row", "promises", "steady_row"]


def pole_row(row, item, place, printed, found, tolerance, note=""):
    """The row of an item: printed and found poles, within a tolerance in rad/s.

    The place is a table of the thesis. A note follows the largest difference.
    """
    computed = matched(printed, found)
    verdict, gap = compare(printed, computed, tolerance)
    return row(
        item,
        place,
        format_poles(printed),
        format_poles(computed),
        verdict,
        f"largest difference {gap:.0e} rad/s{note}",
    )


def gains_row(row, place, K, own, tolerance, proof, digits, note="", decimals=4):
    """The row of a place: the printed gain K beside that of our own design.

    They may differ by a tolerance. The printed one's proof is found already;
    ours is looked for here, with so many digits. A note comes before the reason
    of the verdict; the gains are shown with so many decimals.
    """
    verdict, reason = solution(K, own.K, tolerance, proof, proven(own, digits))
    ours, printed = format_gain(own.K, decimals), format_gain(K, decimals)
    return row("K_P, K_D, K_I", place, printed, ours, verdict, note + reason)


def promises(
    row, place, figure, ex, digits=4, norm_note="", gains_note="", peak_note=""
):
    """Rows of what an example of one plant promises.

    Parameters
    ----------
    row : callable
        Makes a `Row` of the example's chapter from the other fields.
    place, figure : str
        Where the thesis has the example, and the figure of its poles.
    ex : sosbook.book.thesis.Example
        The example with its printed numbers.
    digits : int
        Decimals of the norm.
    norm_note, gains_note, peak_note : str
        What is added to the norm's reason, and comes before the others.
    """
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    limit = ex.saturation.u_max
    inside = min(x.min() for x in ex.region.distances(poles(d, ex.K)).values())
    yield row(
        "all closed-loop poles lie in the D-region",
        figure,
        "inside",
        f"{inside:.3f} rad/s from the boundary",
        claim(inside > 0),
        "for the printed gains",
    )
    proof = proven(analyse_pid(ex.plant, ex.K, **ex.requirements), 7)
    yield row(
        "the printed gains satisfy (2.15), (2.18)-(2.21)",
        place,
        "designed to",
        "proven" if proof else "no proof found",
        claim(proof),
        "a common P, checked in exact rational arithmetic",
    )
    own = design_pid(ex.plant, **ex.requirements)
    yield gains_row(row, place, ex.K, own, 1e-4, proof, 7, gains_note)
    norm = hinf_norm(d, ex.K)
    yield row(
        f"H-infinity norm from w to z below {ex.gamma:.4f}",
        place,
        f"< {ex.gamma}",
        f"{norm:.{digits}f}",
        claim(norm < ex.gamma),
        f"{ex.gamma / norm:.0f} times below the bound{norm_note}",
    )
    largest = peak_input(d, ex.K, ex.saturation.x0)
    yield row(
        f"|K x(t)| at most {limit:g} from x(0)",
        place,
        f"<= {limit:g}",
        f"{largest:.1f}",
        claim(largest <= limit),
        f"{peak_note}with r = 0, w = 0",
    )


def steady_row(row, figure, ex, error, why, unit=""):
    """The row of a figure: the largest error at the end of ``ex``, and why.

    The error has a unit, which follows its number.
    """
    return row(
        "the error goes to zero in steady state",
        figure,
        "0",
        f"{error:.0e}{unit} at t = {ex.t_end:g} s",
        claim(error < 1e-3),
        why,
    )
