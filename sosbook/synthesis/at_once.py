"""The direct effect of a disturbance on the output: a smaller gamma is excluded.

With y = C x + D_u u + D_w w and u = K x the H-infinity norm is at least the largest
singular value of D_w: at infinite frequency x stands still, and u with it. Any linear
controller that measures x does no better. In the block of the bounded real lemma the
rows of y and w hold no unknown: a square of these alone is a multiplier.
"""

from dataclasses import replace

import numpy as np

from ..exact.definite import exact
from ..exact.rational import round_digits
from .proofs import exclude_design
from .scaling import Frame

DIGITS = 12  # of a direction
SHOWN = 4  # of a bound that is excluded
BELOW = 1 - 1e-4  # of a size, for such a bound


def loudest(through, moved):
    """c, z, and the square of |z| / |``moved`` c|, in rationals: z = ``through`` c, and
    near the largest ratio; None where there is none.
    """
    d, w = through.astype(float), moved.astype(float)
    if not d.size or not np.isfinite(d).all():
        return None
    c = np.linalg.pinv(w) @ np.linalg.svd(d @ np.linalg.pinv(w))[2][0]
    c = exact(round_digits(c / (abs(c).max() or 1.0), DIGITS))
    z, w = through @ c, moved @ c
    return (c, z, (z @ z) / (w @ w)) if (w != 0).any() and (z != 0).any() else None


def refuse_at_once(request):
    """The refusal of a bound of the H-infinity norm of a ``request`` without a law, at
    a vertex where w is too loud in y at once; or None.
    """
    if not request.law.whole or request.gain is not None:
        return None
    for r in request.requirements:
        if r.bounds_response() is None or not r.of_package:
            continue
        r = r.untied()
        one = replace(request, requirements=[r], coupling="pairs")
        for k in one.distinct:
            found = _at_vertex(one, r, k)
            if found is not None and found.proven:
                return found
    return None


def excluded_at_once(request, r):
    """The largest gamma of ``r`` in a ``request`` that is excluded so, to four digits,
    and the refusal; None and None where w isn't in y at once.
    """
    if r.bounds_response() is None or not r.of_package or not request.plant.m:
        return None, None
    ends = [r.seen(d).explicit().Dw for d in request.vertices]
    sizes = [np.linalg.norm(x, 2) for x in ends if x is not None and x.size]
    gamma = float(round_digits(BELOW * max(sizes, default=0.0), SHOWN))
    if not gamma:
        return None, None
    asked = [r.with_bound(gamma)]
    asked = replace(request, gain=None, coupling="pairs", requirements=asked)
    proof = refuse_at_once(asked)
    return (None, None) if proof is None else (gamma, proof)


def _at_vertex(request, r, k):
    (d,) = request.vertices_in(exact, [k])
    D = r.seen(d).explicit().Dw
    if D is None:
        return None
    found = loudest(D, exact(np.eye(D.shape[1])))
    if found is None or found[2] < exact(r.bound) ** 2:
        return None
    w, z, ratio = found
    v = np.hstack([exact(np.zeros(request.order)), z, ratio * w])[:, None]
    frame = Frame.at(request, np.eye(request.order), 1.0, sizes={})
    return exclude_design(request, frame, (r.key, (k,)), v @ v.T)
