"""The pendulum in the page: its fall, its identification, its laws, their program."""

import numpy as np

from ....pendulum import V_MAX, Mip, polytope, vertices
from ....pendulum.law import pendulum_gain
from ....synthesis.lqr import design_lqr
from ..page import significant
from .mover import Mover, choice, slider

#: What a scale and a ruler say of the robot; as `Mip.from_ratios` has it.
MEASURED = {"M_b": 0.272, "l": 0.040, "r": 0.032, "M_w": 0.027, "g": 9.8}
LAWS = {"PD": None, "PID": [[0, 1]]}  # U of each
ROTORS = {"J = 0": False, "on the body": True}
DESIGNS = (
    "LQR of the middle plant",
    "LQR of vertex 1",
    "LQR of vertex 4",
    "Theorem 2.4, all plants",
)


def fall():
    """The pendulum falls in the page, and so does its linear model.

    The page integrates `Mip.acceleration` by Runge and Kutta's method
    with steps of 5 ms, and the linear model exactly. A voltage acts
    from the start for as long as the pulse lasts.

    Notes
    -----
    Source: thesis (4.13) and (4.15), mended.

    Examples
    --------
    >>> fall()
    Fall: angle, volts, pulse, rotors
    """
    robots = [
        Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=rotors)
        for rotors in ROTORS.values()
    ]
    return Mover(
        "fall",
        "Let it fall",
        "Let it go at 5° and at 45°. In which of the two does the linear model run "
        "ahead of the truth? Then throw it back from 10° with a short pulse.",
        [
            slider("angle", "Let go at θ", "°", (0, 90), 1, 10),
            slider("volts", "Voltage of the pulse", " V", (-V_MAX, V_MAX), 0.1, 0),
            slider("pulse", "Length of the pulse", " s", (0, 0.8), 0.01, 0.1),
            choice("rotors", "Inertia of the rotors", ROTORS),
        ],
        answer={"angle": 45},
        robots=[_letters(robot, "J") for robot in robots],
    )


def chirp(ratios):
    """The body's experiment, recorded and fitted in the page.

    The page simulates the pendulum with the wheels held under a chirp of
    ten seconds, adds noise to the gyro, and fits e/c, f/c and d/c by
    output error, with the pendulum's sine and without.

    ``ratios``: the true ratios "e_c", "f_c" and "d_c", in SI units.

    >>> chirp({"e_c": 30.5, "f_c": 7.1, "d_c": 110.6})
    Chirp: amplitude, noise
    """
    return Mover(
        "chirp",
        "Shake it, fit it",
        "Raise the voltage until the body swings by 45°, without any noise. Whose "
        "d/c is wrong now? Then try a weak shake with a bad gyro.",
        [
            slider("amplitude", "Voltage of the chirp", " V", (0.1, 4), 0.05, 0.5),
            slider("noise", "Noise of the gyro", "°/s", (0, 20), 0.5, 0.5),
        ],
        answer={"amplitude": 1.8, "noise": 0},
        truth=[float(ratios[key]) for key in ("e_c", "f_c", "d_c")],
        low=0.5,  # Hz, of the sweep
        high=3.5,
    )


def regulator(
    R=(0.1, 1, 10, 100),
    spreads=(10, 30, 50, 70),
    *,
    laws=("PD", "PID"),
    start=None,
    title="Least cost: move R and the spread",
):
    """The pendulum's regulators, with sliders, in the page.

    The page solves the Riccati equation of one plant for every R, with
    Q = I. The gains of Theorem 2.4 are solved here, for a grid; where
    the slider stands between two spreads, the larger one's gain is
    taken, whose proof holds for the smaller. Poles, costs and the fall
    of the nonlinear pendulums are computed in the page.

    Parameters
    ----------
    R, spreads : sequence of float
        The grid: weights of the voltage, and spreads in per cent.
    laws : sequence of {"PD", "PID"}
        The laws to choose from, PD first; the PID integrates phi.
    start : dict, optional
        Where the sliders stand at first, such as {"law": 1, "R": 5}.
    title : str
        The heading of the element.

    Raises
    ------
    ValueError
        If a request has no proven design.

    Notes
    -----
    Source: thesis Theorem 2.4, Tables 4.1 and 4.2, (4.13).
    """
    asked = {"law": 0, "design": 0, "R": 1, "spread": 10, "tilt": 10}
    asked |= start or {}
    for law in laws:
        if law not in LAWS:
            raise ValueError(f"laws must be of {', '.join(LAWS)}, got {law!r}")
    mip = Mip.printed()
    robust = [_grid(mip, U, R, spreads) for U in map(LAWS.get, laws)]
    controls = [
        *([choice("law", "Law", laws, asked["law"])] if len(laws) > 1 else []),
        choice("design", "Design", DESIGNS, asked["design"]),
        slider("R", "Weight R of the voltage", "", (-1, 3), 0.05, asked["R"], "log"),
        slider("spread", "Spread", " %", (0, max(spreads)), 1, asked["spread"]),
        slider("tilt", "Let go at", "°", (0, 60), 1, asked["tilt"]),
    ]
    return Mover(
        "regulator",
        title,
        "While the voltage is cheap, the regulator of the middle plant stands for "
        "every spread. Make it dear (R = 100) and raise the spread to the end. Who "
        "falls? Then choose Theorem 2.4.",
        controls,
        answer={"design": 0, "R": 100, "spread": 70},
        mip=_letters(mip, "I_w") | {"radius": MEASURED["r"]},
        limit=V_MAX,
        horizon=1.5,
        robust=robust,
    )


def _grid(mip, U, R, spreads):
    """Proven gains of Theorem 2.4 and their bounds, R by spread."""
    gains, bounds = [], []
    for weight in R:
        row = [_robust(polytope(mip, s / 100), U, weight) for s in spreads]
        gains.append([gain for gain, _ in row])
        bounds.append([bound for _, bound in row])
    return {"R": list(R), "spread": list(spreads), "K": gains, "bound": bounds}


def _robust(plants, U, R):
    design = design_lqr(plants, np.eye(5 if U else 4), [[R]], U)
    proof = design.certify() if design.K is not None else None
    if not proof:
        raise ValueError(f"R = {R} has no proven design: {design.status}")
    bound = significant(design.request.cost.bound, 4)
    return significant(proof.K[0], 5), bound


def clock(gains):
    """Sampled loops of the pendulum whose clock can be moved.

    The page solves the hold exactly, from tick to tick, with the delay;
    the integral of a PID is the sum of T phi.

    ``gains``: for each name a `Gain` that `SampledLaw.of_gain` takes.

    >>> from sosbook.book import thesis
    >>> clock({"PD, R = 5": thesis.mip().gains["PD"][5]})
    Clock: law, sensing, T, delay
    """
    laws = [{"name": x, "K": pendulum_gain(k)[0].tolist()} for x, k in gains.items()]
    middle = Mip.printed()
    robots = (middle, *vertices(middle, 0.04))
    return Mover(
        "clock",
        "From gains to samples: move the clock",
        "Let the clock slow down until a pole leaves the circle. At 10 ms with "
        "differenced wheels and no delay the loop chatters: what does half a tick of "
        "delay do?",
        [
            choice("law", "Law", gains),
            choice("sensing", "Wheels' rate", ("exact", "differenced counts")),
            slider("T", "Time between ticks", " ms", (1, 40), 0.5, 10),
            slider("delay", "Delay", " % of a tick", (0, 100), 5, 0),
        ],
        answer={"T": 10, "sensing": 1, "delay": 50},
        laws=laws,
        robots=[_letters(robot) for robot in robots],
    )


def digits(K):
    """A gain as the C program writes it, and what a tick makes of it.

    ``K``, (1, 5): the gain of V = K [theta, phi, theta', phi', integral of phi].

    >>> digits([[17.0, 0.6, 1.6, 0.8, 0.3]])
    Digits: entry, precision, tilt, rate
    """
    return Mover(
        "digits",
        "The numbers of the program",
        "Switch to single precision: which bits go, and by how much does the voltage "
        "of this tick change? Compare with the encoder's step, which is far coarser.",
        [
            choice("entry", "Gain of", ("θ", "φ", "θ′", "φ′", "∫φ")),
            choice("precision", "Precision", ["double", "single"]),
            slider("tilt", "Tilt θ", "°", (-20, 20), 0.5, 3),
            slider("rate", "Rate θ′", " rad/s", (-2, 2), 0.05, 0.1),
        ],
        answer={"precision": 1},
        K=np.ravel(np.asarray(K, float)).tolist(),
    )


def chain(ratios):
    """From four measured ratios to the loop that the program closes.

    The page computes the pendulum's letters, the regulator of the middle
    plant with the integral (Riccati), the poles at the vertices and the
    sampled loop at 100 Hz with its delay.

    ``ratios``: "e_c", "f_c", "d_c" and "e_a", as an identification gives them.

    >>> chain({"e_c": 30.52, "f_c": 7.133, "d_c": 110.6, "e_a": 208.8})
    Chain: e_c, f_c, d_c, e_a, R, spread, late
    """
    units = {"e_c": " V⁻¹s⁻²", "f_c": " s⁻¹", "d_c": " s⁻²", "e_a": " V⁻¹s⁻²"}
    moved = []
    for key, unit in units.items():
        value = float(f"{ratios[key]:.4g}")
        step = value / 100
        ends = (50 * step, 150 * step)
        moved.append(slider(key, key.replace("_", "/"), unit, ends, step, value))
    return Mover(
        "chain",
        "From ratios to a program",
        "Say that the motors are weaker (e/c), and follow the change down to the "
        "loop. Then make the voltage cheap, and late.",
        [
            *moved,
            slider("R", "Weight R of the voltage", "", (-1, 3), 0.05, 20, "log"),
            slider("spread", "Spread of the vertices", " %", (0, 60), 1, 4),
            slider("late", "Delay", " % of a tick", (0, 100), 5, 50),
        ],
        answer={"R": 0.1, "late": 100},
        **MEASURED,
    )


def _letters(mip, *more):
    """The letters of a pendulum's equations, and perhaps more of it."""
    return {x: getattr(mip, x) for x in (*"abcdef", *more)}
