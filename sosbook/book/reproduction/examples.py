"""Rows that the examples of section 3.1 have in common."""

from ...analysis.linear import hinf_norm, peak_input, poles
from ...plants.descriptor import descriptors
from ...synthesis.pid import analyse_pid, design_pid
from .table import evaluate, proven


def promises(number, ex, digits=4, note=""):
    """Rows of what an example of one plant promises.

    Parameters
    ----------
    number : int
        The example's.
    ex : sosbook.book.thesis.Example
        The example with its printed numbers.
    digits : int
        Decimals of the norm.
    note : str
        What is added to the norm's reason.
    """
    (d,) = descriptors(ex.plant, ex.U, ex.K_A)
    limit, start = ex.saturation.u_max, ex.saturation.x0
    inside = min(x.min() for x in ex.region.distances(poles(d, ex.K)).values())
    yield evaluate(f"example-{number}-region", inside > 0, inside=inside)
    proof = proven(analyse_pid(ex.plant, ex.K, **ex.requirements), 7)
    yield evaluate(f"example-{number}-LMIs", proof)
    own = design_pid(ex.plant, **ex.requirements)
    yield evaluate(f"example-{number}-gains", ex.K, own.K, proof, proven(own, 7))
    norm = hinf_norm(d, ex.K)
    yield evaluate(
        f"example-{number}-norm",
        norm < ex.gamma,
        gamma=ex.gamma,
        ours=f"{norm:.{digits}f}",
        times=ex.gamma / norm,
        note=note,
    )
    largest = peak_input(d, ex.K, start)
    yield evaluate(f"example-{number}-peak", largest <= limit, limit=limit, u=largest)
