"""LMIs that can be drawn in the page: a set and its centre, a segment, a proof."""

import numpy as np
from scipy.optimize import brentq

from ....plants.descriptor import descriptors
from ....plants.second_order import SecondOrderSystem
from ..page import matrices
from .boxes import bilinear, ends_of
from .loops import circulating
from .mover import Mover, choice, slider


def centre(A, *, start=(1.5, -0.6), sigma=0.3, title="The set and its centre"):
    """The feasible set of P = [p q; q 1] for a decay rate, in the page.

    The page walks from the reader's point to the analytic centre by
    Newton's method, the decrement beside each step.

    ``A``, (2, 2): the matrix of x' = A x; ``start``, (float, float): p and q at first;
    ``sigma``: the decay rate at first, in 1/s; ``title``: the heading.

    >>> centre([[0, 1], [-2, -3]])
    Centre: sigma, p, q
    """
    p, q = start
    return Mover(
        "centre",
        title,
        "Move your point until both bars are above zero. Then ask for a faster decay "
        "σ: the set shrinks around its centre and vanishes at the true rate.",
        [
            slider("sigma", "Decay rate σ", " s⁻¹", (0, 1.2), 0.01, sigma),
            slider("p", "p of your point", "", (0, 4), 0.02, p),
            slider("q", "q of your point", "", (-1.8, 0.5), 0.02, q),
        ],
        answer={"sigma": 0.95, "p": 0.66, "q": -0.74},
        A=np.asarray(A, float).tolist(),
    )


def segment(cases):
    """The plants between two vertices, their poles and the LMI of stability.

    ``cases``: for each name ((first, second), P): two `Descriptor` vertices without
    control, and the matrix P that they share.

    >>> from sosbook.book import counterexamples
    >>> segment({"rotation": counterexamples.rotation()})
    Segment: plant, weight
    """
    plants = []
    way = np.linspace(0, 1, 41)[:, None, None]
    for name, (ends, P) in cases.items():
        given = {x: [getattr(d, x).tolist() for d in ends] for x in "EA"}
        E, A = ((1 - way) * first + way * second for first, second in given.values())
        poles = np.linalg.eigvals(np.linalg.solve(E, A)).ravel()
        window = [_window(poles.real), _window(poles.imag)]
        given |= {"P": np.asarray(P).tolist(), "window": window}
        plants.append({"name": name} | given)
    return Mover(
        "segment",
        "Walk from one vertex to the other",
        "Both ends satisfy the inequality with one P. Walk from one to the other: "
        "where does the inequality stop telling, and where does stability end?",
        [
            choice("plant", "Polytope", cases),
            slider("weight", "Weight of the second vertex", "", (0, 1), 0.01, 0),
        ],
        answer={"weight": 0.02},
        plants=plants,
    )


def ranges(plants, gains, box, sigma):
    """A turntable with its payload in ranges: proven cells, or a broken plant.

    ``plants``: parameters m in kg and q = r² in cm², no powers: the largest box that
    the page can show; ``gains``: for each name a gain (1, 4) that can be chosen;
    ``box``: the ranges at first, m and q by name; ``sigma``: the decay claimed at
    first, in 1/s. Raises ValueError if the plants aren't of this kind, see `bilinear`.
    """
    ends, corners = ends_of(plants, "mq"), descriptors(plants.polytope())
    (m, q), (loads, squares) = (box[name] for name in "mq"), zip(*ends)
    loops = [
        bilinear([d.E for d in corners], [d.A + d.Bu @ K for d in corners], ends)
        for K in gains.values()
    ]
    return Mover(
        "ranges",
        "What may stand on the table?",
        "Drag a corner of the box until a table in it breaks the claim. Then ask for "
        "less decay.",
        [
            choice("gain", "Gain", gains),
            slider("sigma", "Claimed decay σ", " s⁻¹", (0, 8), 0.1, sigma),
            slider("m0", "Smallest payload", " kg", loads, 0.05, m[0]),
            slider("m1", "Largest payload", " kg", loads, 0.05, m[1]),
            slider("q0", "Nearest place, r²", " cm²", squares, 1, q[0]),
            slider("q1", "Farthest place, r²", " cm²", squares, 1, q[1]),
        ],
        answer={"m1": loads[1]},
        ranges=[loads, squares],
        E=loops[0][0],
        gains=[A for _, A in loops],
    )


def landscape(loop, B, C, gains, others, says):
    """The largest real part of x' = (A + B K C) x over K = [x y], with descents.

    ``loop``: from numbers, by name, to the matrix A, which is affine in each of them;
    ``B``, ``C``, (N, 1) and (2, N): of one input and two measured numbers; ``gains``:
    for each gain its label, its ends, its step and where it is at first; ``others``:
    the same for each number of the loop: they move the landscape; ``says``: a sentence
    with their names, x, y and many in braces, where their values stand.

    >>> landscape(lambda k: [[0, 1], [-k, 0]], [[0], [1]], np.eye(2),
    ...           [("K_P", (-4, 4), 0.1, 1), ("K_D", (-4, 4), 0.1, 1)],
    ...           {"k": ("spring", (0, 2), 0.1, 1)},
    ...           "With a spring of {k}, descents start at {x} and {y} {many}.")
    Landscape: x, y, k, many
    """
    none = dict.fromkeys(others, 0)
    A, B, C = (np.asarray(x, float) for x in (loop(**none), B, C))
    parts = {key: np.asarray(loop(**none | {key: 1}), float) - A for key in others}
    numbers = dict(zip("xy", gains)) | others
    many = choice("many", "Descents", ("alone", "and 16 other places"))
    return Mover(
        "landscape",
        "Where does the descent end?",
        "Drag the handle to either side of the map and look where the line ends. Then "
        "look at 16 starts at once, and at what the other numbers do to the islands.",
        [
            *(
                slider(key, label, "", ends, step, start)
                for key, (label, ends, step, start) in numbers.items()
            ),
            many,
        ],
        answer={"many": 1},
        says=says,
        labels=[gains[0][0], gains[1][0]],
        ends=[list(gains[0][1]), list(gains[1][1])],
        A=A.tolist(),
        ways=[(B @ row[None]).tolist() for row in C],
        others=[{"key": key, "part": part.tolist()} for key, part in parts.items()],
    )


def _window(values):
    """Round ends of an axis that holds most values, and zero."""
    low, high = min(np.quantile(values, 0.03), -1), max(np.quantile(values, 0.97), 1)
    room = 0.15 * (high - low)
    return [float(np.floor(low - room)), float(np.ceil(high + room))]


def trust(plant):
    """A Lyapunov inequality near the edge, on four rungs of the ladder.

    P solves the Lyapunov equation of the plant with kappa times its
    circulation, or where that is unstable, of the last stable one. The
    page rounds P to some digits, looks at the blocks with a
    solver's tolerance and in floats, and proves them in exact integers.

    ``plant``: two coordinates; its entries are read as decimals.

    >>> from sosbook.book import thesis
    >>> trust(thesis.example_1().plant)
    Trust: kappa, tolerance, digits
    """
    spring, turn = circulating(plant)

    def rightmost(kappa):
        moved = SecondOrderSystem(plant.M, plant.D, spring + kappa * turn, plant.B)
        return moved.poles().real.max()

    edge = brentq(rightmost, 0, 2, xtol=1e-6)
    return Mover(
        "trust",
        "Status against proof",
        "Turn the circulation κ past 0.98, where the plant loses stability: which "
        "rung still says yes? Then tighten the tolerance, and round P to fewer "
        "digits.",
        [
            slider("kappa", "Circulation κ", "", (0.9, 1.05), 0.001, 0.96),
            slider("tolerance", "Tolerance: power of ten", "", (-9, -1), 1, -2),
            slider("digits", "Digits of P", "", (1, 12), 1, 6),
        ],
        answer={"kappa": 0.985},
        **matrices(plant, "MD"),
        S=spring.tolist(),
        K=turn.tolist(),
        held=round(edge, 3) - 0.001,
    )
