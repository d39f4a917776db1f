"""A walk from one vertex to the other, in the page."""

import numpy as np

from .mover import Mover, choice, slider

__all__ = ["segment"]

HINT = (
    "Both ends satisfy the inequality with one P. Walk from one to the other: where "
    "does the inequality stop telling, and where does stability end?"
)


class Segment(Mover):
    tag, script = "sos-segment", "segment"


def segment(cases):
    """The plants between two vertices, their poles and the LMI of stability.

    Parameters
    ----------
    cases : dict
        For each name ((first, second), P): two `Descriptor` vertices
        without control, and the matrix P that they share.

    Returns
    -------
    Mover
        The element.

    Examples
    --------
    >>> from sosbook.book import counterexamples
    >>> segment({"rotation": counterexamples.rotation()})
    Segment: plant, weight
    """
    plants = []
    for name, ((first, second), P) in cases.items():
        E, A = (
            [x.tolist() for x in pair]
            for pair in zip((first.E, first.A), (second.E, second.A), strict=True)
        )
        ways = [
            np.linalg.eigvals(
                np.linalg.solve(
                    (1 - a) * first.E + a * second.E, (1 - a) * first.A + a * second.A
                )
            )
            for a in np.linspace(0, 1, 41)
        ]
        poles = np.ravel(ways)
        plants.append(
            {
                "name": name,
                "E": E,
                "A": A,
                "P": np.asarray(P).tolist(),
                "window": [_window(poles.real), _window(poles.imag)],
            }
        )
    return Segment(
        "Walk from one vertex to the other",
        HINT,
        [
            choice("plant", "Polytope", cases),
            slider("weight", "Weight of the second vertex", "", (0, 1), 0.01, 0),
        ],
        plants=plants,
    )


def _window(values):
    """Round ends of an axis that holds most values, and zero."""
    low, high = min(np.quantile(values, 0.03), -1), max(np.quantile(values, 0.97), 1)
    room = 0.15 * (high - low)
    return [float(np.floor(low - room)), float(np.ceil(high + room))]
