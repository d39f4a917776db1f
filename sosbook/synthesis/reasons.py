"""Why there is no design, in words, where no proof was found."""

import numpy as np

MOST_MODES_NAMED = 4  # in a reason
NO_COMMON_P = "There is no common P in this form of the rows."
MOST_STATES = 20  # up to which it pays to prove how far multipliers reach
LEAST_RADIUS = 10.0  # of the gains in natural units; a shorter one isn't worth a word


def _proven_reach(first):
    """No point is shorter than this; exact, 0 if unknown."""
    if first.multipliers is None or first.problem.request.order > MOST_STATES:
        return 0.0
    return first.problem.excluded_radius(first.multipliers)


def _rounded_down(x):
    """To one digit, never more than x."""
    if np.isinf(x):
        return "any"
    power = int(np.floor(np.log10(x)))
    return f"{int(x / 10.0**power)}e{power}"


def why_refused(first):
    """What phase one has seen, ``first``, without a point nor a proof: a sentence."""
    request = first.problem.request
    unknowns = "P" if request.gain is not None else "P, Y"
    if request.coupling == "slack":
        unknowns = unknowns.replace("P", "P_i, V", 1)
    reach = _proven_reach(first)
    if reach > LEAST_RADIUS:
        return (
            f"Exact multipliers exclude all {unknowns} shorter than "
            f"{_rounded_down(reach)} in the solver's coordinates; no exact proof was "
            "found that there is none at all."
        )
    if first.verdict == "infeasible":
        radius = first.excluded_radius
        size = "however large" if np.isinf(radius) else f"up to {radius:.0e}"
        return (
            f"No {unknowns} {size} in the solver's coordinates, by multipliers "
            "in floating point; no exact proof was found."
        )
    return f"The numerics found neither {unknowns} nor multipliers that exclude them."


def listed(modes):
    """The ``modes`` in words, the slowest first; of two conjugates one."""
    noise = 1e-9 * np.abs(modes).max()
    upper = sorted((s for s in modes if s.imag > -noise), key=abs)
    texts = [
        f"{s.real:.4g}±{s.imag:.4g}j" if s.imag > noise else f"{s.real + 0.0:.4g}"
        for s in np.where(np.abs(np.real(upper)) > noise, upper, 1j * np.imag(upper))
    ]
    texts = list(dict.fromkeys(texts))
    if len(texts) > MOST_MODES_NAMED:
        texts[MOST_MODES_NAMED:] = [f"{len(texts) - MOST_MODES_NAMED} more places"]
    return ", ".join(texts)
