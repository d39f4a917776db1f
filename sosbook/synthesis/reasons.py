"""Why there is no design, in words, where no proof was found."""

import numpy as np

from ..plants.as_data import vertex_place

MOST_MODES_NAMED = 4  # in a reason
NO_COMMON_P = "There is no common P in this form of the rows."
MOST_STATES = 20  # up to which it pays to prove how far multipliers reach
FLOATS_TELL = 1e-9  # of the fastest pole: so far outside a pole is
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
    """The sentence on phase one's result ``first``, without a point or a proof."""
    request = first.problem.request
    unknowns = "P" if request.gain is not None else "P, Y"
    unknowns = unknowns.replace("P", request.coupling.unknown_words, 1)
    reach = _proven_reach(first)
    sized = " With a disk (rho) P and Y have a largest size, and it may be decided."
    sized = sized if request.gain is None and request.step is None else ""
    if reach > LEAST_RADIUS:
        return (
            f"Exact multipliers exclude all {unknowns} shorter than "
            f"{_rounded_down(reach)} in the solver's coordinates; no exact proof was "
            f"found that there is none at all.{sized}"
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


MOST_LOOKED_AT = 600  # states; of more the poles take longer than a word is worth


def pole_named(request):
    """`pole_seen` of a ``request``, where nothing is proven of it."""
    seen = pole_seen(request)
    return seen and f"{seen[:-1]}: no exact proof of it was found."


def pole_seen(request):
    """A sentence about the pole under a given gain that breaks a ``request`` the most
    in floats; empty where none does, or the gain is sought.
    """
    K, worst = request.gain, (0.0, "")
    if K is None or request.order > MOST_LOOKED_AT:
        return ""
    for k, d in enumerate(request.vertices):
        try:
            A, B, _ = d.state_space()
            poles = np.linalg.eigvals(A + B @ K)
        except np.linalg.LinAlgError:
            continue
        for r in request.of_poles:
            alpha, beta = (np.array(x, float) for x in r.pole_matrices())
            at = poles[:, None, None]
            form = alpha + at * beta + at.conj() * beta.T
            beyond = np.linalg.eigvalsh(form)[:, -1]
            beyond = beyond / (np.abs(alpha).max() + np.abs(poles).max())
            if beyond.max() > max(worst[0], FLOATS_TELL):
                s = poles[beyond.argmax()]
                s = complex(s.real, abs(s.imag))
                place = f"{listed(np.array([s]))} rad/s"
                place = place if request.step is None else request.claims.place(s)
                of = vertex_place(request.plant, k)
                where = f" of {of}" if of else ""
                words = f"In floats a pole{where} at {place} breaks "
                worst = beyond.max(), f"{words}{r.words or r.name}."
    return worst[1]
