"""Names of the requirements' bounds in tables, sliders, maps and messages."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Parameter:
    """A bound that can be moved: its name, its words, its direction.

    Parameters
    ----------
    key : str
        The keyword: "sigma", "gamma", ...
    words : str
        What messages call it: "decay rate sigma".
    label, symbol, unit : str
        What pages call it.
    harder : {1, -1}
        Which way the bound asks for more.
    power : {None, 1, 2}
        The blocks are affine in bound ** power, the *level*; None where
        they aren't affine in any, so that it can't be minimised.
    start : float
        Where a search begins if the bound isn't given.
    limits : tuple of float, optional
        The ends between which a search stays, in the unit shown.
    degrees : bool
        Whether pages show it in degrees; its value is in radians.
    needs : str
        What must be given before it can be moved.
    open : str
        How to ask for it without a number, to be minimised.
    """

    key: str
    words: str
    label: str
    symbol: str
    unit: str = ""
    harder: int = -1
    power: int | None = None
    start: float = 1.0
    limits: tuple | None = None
    degrees: bool = False
    needs: str = ""
    open: str = ""

    def shown(self, value):
        """A value in the unit of the page: angles in degrees."""
        return float(np.degrees(value)) if self.degrees else float(value)

    def value(self, shown):
        """A value from the number shown."""
        return float(np.radians(shown)) if self.degrees else shown

    def text(self, value):
        """A value in words, as "θ = 45°"."""
        return f"{self.symbol} = {self.shown(value):.4g}{self.unit}"

    def harder_than(self, a, b):
        """1 if a asks for more than b, -1 for less, 0 if they are equal."""
        if a == b:  # a proof holds for the very number, and for what asks for less
            return 0
        return 1 if (a > b) == (self.harder > 0) else -1

    def bound(self, level):
        """The bound of a level."""
        return float(np.sqrt(level) if self.power == 2 else level)

    def eased(self, bound, share):
        """A bound of three digits that asks for less, by a factor of ``share``."""
        wanted = bound * float(share) ** -self.harder
        size = 10.0 ** (np.floor(np.log10(wanted)) - 2)
        whole = np.floor(wanted / size) if self.harder > 0 else np.ceil(wanted / size)
        eased = float(f"{whole * size:.3g}")
        return min(eased, np.pi / 2) if self.degrees else eased

    def fault(self, values):
        """The fault of values of the parameter, in words; else empty."""
        if self.degrees and np.max(values) > np.pi / 2:
            return f"{self.key} is a half-angle in radians, at most pi/2"
        return ""


SIGMA = Parameter("sigma", "decay rate sigma", "Decay rate σ", "σ", " 1/s", harder=1)
THETA = Parameter(
    "theta",
    "sector angle theta",
    "Half-angle θ",
    "θ",
    "°",
    start=np.pi / 4,
    limits=(1.0, 90.0),
    degrees=True,
)
RHO = Parameter("rho", "disk radius rho", "Disk radius ρ", "ρ", " 1/s", start=10.0)
GAMMA = Parameter("gamma", "H-infinity bound gamma", "H∞ bound γ", "γ", power=2)
COST = Parameter(
    "cost",
    "bound of the cost",
    "Bound of the cost",
    "J",
    power=1,
    needs="requirements=[QuadraticCost(Q, R, bound=...)]",
    open="requirements=[QuadraticCost(Q, R)] without a bound",
)
H2_NORM = Parameter("h2", "H2 bound h2", "H₂ bound h₂", "h₂", power=2)
U_MAX = Parameter(
    "u_max",
    "input bound u_max",
    "Input bound u_max",
    "u_max",
    power=2,
    needs="saturation=Saturation(u_max, x0): the bound holds from x0 only",
    open="saturation=Saturation(None, x0): the bound holds from x0",
)
PARAMETERS = {p.key: p for p in (SIGMA, THETA, RHO, GAMMA, U_MAX, COST)}

KINDS = {  # whose class each kind is, by its module: it is found when a file names it
    "cost": "requirements.cost.QuadraticCost",
    "gamma": "requirements.hinf.HInfinity",
    "h2": "requirements.h2.H2",
    "input": "requirements.input_bound.Saturation",
    "region": "requirements.lmi_region.LMIRegion",
    "stability": "requirements.stability.Stability",
}

#: Of two requirements of a kind.
ONE_BY_ONE = (
    "a request takes one of them. Design for one, and ask the other of the gain: "
    "analyse_pid(plant, design.K, {}), with the same U or law"
)
