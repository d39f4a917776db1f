"""Loops in the page: circulation, integrals, a vanishing mass, an observer, a delay."""

import numpy as np

from ..page import matrices, significant
from .mover import Mover, choice, slider


def circulating(plant):
    """The symmetric and the skew part of the stiffness of a ``plant``."""
    S = np.asarray(plant.S)
    return (S + S.T) / 2, (S - S.T) / 2


def circulation(plant):
    """A robot whose circulatory force can be turned up and down.

    ``plant``: the robot with two coordinates. The skew part of its S is what the slider
    kappa multiplies.

    >>> from sosbook.book import thesis
    >>> circulation(thesis.example_1().plant)
    Circulation: kappa, damping
    """
    spring, turn = circulating(plant)
    return Mover(
        "circulation",
        "Energy: turn the circulation",
        "Find the κ at which the hand's path neither dies out nor grows. How much "
        "damping does the robot need at κ = 1.5?",
        [
            slider("kappa", "Circulation κ", "", (0, 2), 0.01, 1),
            slider("damping", "Damping", " × the robot's", (0.2, 2), 0.05, 1),
        ],
        answer={"kappa": 1.5, "damping": 1.55},
        **matrices(plant, "MD"),
        S=spring.tolist(),
        K=turn.tolist(),
        start=[0.2, 0.2],
    )


def integral(plant, K, U):
    """A PID loop with factors on both columns of K_I, in the page.

    The set point is 1 for both coordinates; from 10 s on a force pushes
    through F.

    ``plant``: a plant with two coordinates and its F; ``K``, (m, 6): [K_P K_D K_I],
    with two integrals; ``U``, (2, 2): the errors that are integrated.

    >>> from sosbook.book import thesis
    >>> example = thesis.example_1()
    >>> integral(example.plant, example.K, example.U)
    Integral: first, second, force
    """
    return Mover(
        "integral",
        "What the integral is for",
        "Set both factors to zero: what remains of the error, and what does the "
        "force do to it? Then make one of them negative, ever so little.",
        [
            slider("first", "Factor on the integral of e₁", "", (-0.2, 3), 0.05, 1),
            slider("second", "Factor on the integral of e₂", "", (-0.2, 3), 0.05, 1),
            slider("force", "Force from 10 s on", " N", (0, 40), 1, 20),
        ],
        answer={"first": 0, "second": 0},
        U=np.asarray(U, float).tolist(),
        K=np.asarray(K, float).tolist(),
        **matrices(plant, "MDSBF"),
    )


def mass(chain):
    """The chain of Example 3 with a last body that may weigh little.

    ``chain``: the plant of the thesis's Example 3.

    >>> from sosbook.book import thesis
    >>> mass(thesis.example_3().plant)
    Mass: m4, b4, lent
    """
    damper, spring, lent = chain.D[3, 3], chain.S[3, 3], (" kg", (0, 1))
    return Mover(
        "mass",
        "A mass that vanishes",
        "Let the last mass vanish with the damper, then without it. Which of the two "
        "velocities has a limit? Then lend the body some mass.",
        [
            slider("m4", "Mass m₄", " kg", (-5, 0), 0.05, 0.01, "log"),
            slider("b4", "Damper b₄", " Ns/m", (0, 40), 1, damper),
            slider("lent", "Mass lent by acceleration feedback", *lent, 0.01, 0),
        ],
        answer={"m4": 1e-5, "b4": 0},
        **matrices(chain, "DS"),
        k4={"damper": damper, "spring": spring},
    )


def kalman(plant, K, spread):
    """A Kalman filter of the mean plant, made and tried in the page.

    ``plant``: its vertices have three states, one input and two outputs: the pendulum
    without its wheels' angle; ``K``, (1, 3): the gain of u = K x^; ``spread``: the
    spread of the vertices, in per cent, for the reader.

    >>> from sosbook.book import thesis
    >>> from sosbook.pendulum import Mip
    >>> from sosbook.pendulum.spread import reduced
    >>> kalman(reduced(Mip.printed(), 0.4), thesis.mip().lqe[1][0], 40)
    Kalman: gyro, wheels, push, plant
    """
    vertices = plant.vertices
    noise = " rad/s/√Hz", (-3, 1)
    names = [f"vertex {k} of ±{spread:g} %" for k in range(1, len(vertices) + 1)]
    return Mover(
        "kalman",
        "An observer and its noises",
        "Make the gyro bad: what do error and voltage do? Then take another plant.",
        [
            slider("gyro", "Gyro's noise", " rad/s/√Hz", (-3, 0), 0.05, 0.1, "log"),
            slider("wheels", "Noise of the wheels' rate", *noise, 0.05, 0.316, "log"),
            slider("push", "Knocks, as a voltage", " V/√Hz", (-1, 1), 0.05, 2, "log"),
            choice("plant", "The plant is", ["the mean itself", *names]),
        ],
        answer={"gyro": 1},
        E=[d.E.tolist() for d in vertices],
        A=[d.A.tolist() for d in vertices],
        B=[d.Bu.tolist() for d in vertices],
        C=np.asarray(plant.C, float).tolist(),
        K=np.asarray(K, float).tolist(),
    )


def delayed(loops, longest, *, horizon, window, start=None, title="Late inputs"):
    """Loops x' = A x + A_d x(t - d(t)) whose delay can be moved.

    The page finds the characteristic roots for a constant delay h on
    Chebyshev nodes and polishes them by Newton's method, and it
    integrates the loop. The clinging delay grows with the time up to h,
    stays there for a second and starts again.

    ``loops``: (A, A_d) for each name; square matrices of up to 5 states; ``longest``:
    the longest delay, in s; ``horizon``: how long the loop is simulated, in s;
    ``window``: what the map of roots shows, in 1/s and rad/s;
    ``start``: the delay at first, in s; half of the longest without it; ``title``: the
    heading.

    >>> delayed({"integrator": ([[0]], [[-1]])}, 1.7, horizon=30,
    ...         window=((-4, 1), (-12, 12)))
    Delayed: h, gain, kind
    """
    stored = []
    for name, (A, A_d) in loops.items():
        shown = significant([A, A_d], 10)
        stored.append({"name": name, "A": shown[0], "Ad": shown[1]})
    step = 10.0 ** np.floor(np.log10(longest) - 2)
    kinds = ("constant", "clinging: it grows with the time, then starts again")
    return Mover(
        "delayed",
        title,
        "Let the delay grow until a pair of roots reaches the axis. Then stay a little "
        "below and choose the clinging delay.",
        [
            *([choice("loop", "Loop", loops)] if len(loops) > 1 else []),
            slider("h", "Delay h", " s", (0, longest), step, start or longest / 2),
            slider("gain", "Gain", " ×", (0.1, 2), 0.05, 1),
            choice("kind", "The delay is", kinds),
        ],
        answer={"h": 1.52, "kind": 1},
        loops=stored,
        horizon=float(horizon),
        steps=1200,
        rest=1.0,
        window=window,
    )
