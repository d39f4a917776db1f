"""The pendulum's regulator in the page: R, the spread and the tilt."""

import numpy as np

from ....pendulum import V_MAX, Mip, polytope
from ....synthesis.lqr import design_lqr
from ..page import significant
from .mover import Mover, choice, slider

__all__ = ["regulator"]

LAWS = {"PD": None, "PID": [[0, 1]]}
RADIUS = 0.032  # m, of the wheels; as `Mip.from_ratios` has it
HORIZON = 1.5  # s
HINT = (
    "While the voltage is cheap, the regulator of the middle plant stands for every "
    "spread. Make it dear (R = 100) and raise the spread to the end. Who falls? Then "
    "choose Theorem 2.4."
)


class Regulator(Mover):
    """A page element that balances four pendulums; made by `regulator`."""

    tag, script = "sos-regulator", "regulator"


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

    Returns
    -------
    Regulator
        The element.

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
    designs = (
        "LQR of the middle plant",
        "LQR of vertex 1",
        "LQR of vertex 4",
        "Theorem 2.4, all plants",
    )
    controls = [
        *([choice("law", "Law", laws, asked["law"])] if len(laws) > 1 else []),
        choice("design", "Design", designs, asked["design"]),
        slider("R", "Weight R of the voltage", "", (-1, 3), 0.05, asked["R"], "log"),
        slider("spread", "Spread", " %", (0, max(spreads)), 1, asked["spread"]),
        slider("tilt", "Let go at", "°", (0, 60), 1, asked["tilt"]),
    ]
    letters = {x: getattr(mip, x) for x in ("a", "b", "c", "d", "e", "f", "I_w")}
    return Regulator(
        title,
        HINT,
        controls,
        mip=letters | {"radius": RADIUS},
        limit=V_MAX,
        horizon=HORIZON,
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
    return [significant(k, 5) for k in proof.K[0]], bound
