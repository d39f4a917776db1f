"""The theorems as texts: each is called once with symbols, and prints itself."""

from inspect import signature
from types import SimpleNamespace

from ..exact.rational import inverse
from ..language.traced import Traced
from ..runtime.later import later

__all__ = ["called_with", "text_of"]

SIZES = {"N": 4, "m": 2, "n": 3, "p": 2, "k": 2}  # any that tell them apart will do
SYMMETRIC = {
    "P", "P1", "P2", "EPE", "J", "S", "R", "R1", "R3", "Z", "Q1", "Q2", "Wq", "R11",
    "R22", "weight",
}  # fmt: skip
SHAPES = {  # of those that aren't N x N, by the letters of `SIZES`; "" is a number
    "Y": "mN", "X": "mN", "EY": "Nm", "C": "nN", "W": "Np", "noise": "Np", "B_w": "Np",
    "x0": "N1", "B": "Nm", "K_A": "mN", "J": "pp", "L": "Nk", "Wq": "kk",
    "alpha": "kk", "beta": "kk", "R11": "kk", "R12": "kk", "R22": "kk",
    "mu": "", "epsilon": "", "bound": "",
}  # fmt: skip
SQUARES = "gamma2", "u_max2"  # of numbers that the text names
EXCEPTIONS = {  # 2 is 2N, f is kN, o and i are what the order makes of N
    "free_pole_region": {"F": "ff", "G": "ff"},
    "h2_output": {"EPC": "Nn", "J": "nn"},
    "observer_decay": {"A": "22", "C": "nN", "Y": "nN", "Q_F": "2k", "R_F": "nn"},
    "regular_mass": {"beta": ""},
    "unseen": {"here": "Nk", "rate": "Nk", "push": "pk", "out": "nk"},
    "whole_control_bound": {
        "X": "NN", "K_A": "mn", "mass": "nn", "row": "nN", "push": "nm",
    },
    "delay_stabilization": {"alpha": ""},
    "lqr_decay": {"R": "mm"}, "slack_lqr_decay": {"R": "mm"},
    "legendre_functional": {"P": "oo"}, "legendre_decay": {"P": "oo"},
    "interval_functional": {"P": "ii"}, "interval_kernel": {"T": "oo"},
    "interval_decay": {"P": "ii", "T": "oo"},
}  # fmt: skip


def called_with(make, function, sizes=(), **given):
    """The blocks of a theorem for matrices that are made for it.

    ``make``: from a name, a shape, which is () for a number, and whether it is
    symmetric, to a matrix-like or a number; ``function``: a function of
    `sosbook.theorems`; ``sizes``: other numbers of rows and columns than those of the
    examples: "N", "m", ...; ``**given``: values that decide which case it is:
    ``order``, ``late``, ``mu`` of a delay, alpha and beta of a region; None for a
    matrix that is left out. Returns what must be positive definite.
    """
    sizes = SIZES | dict(sizes)
    order, N = given.get("order", 0), sizes["N"]
    sizes |= {"1": 1, "2": 2 * N, "f": sizes["k"] * N}
    sizes |= {"o": (1 + order) * N, "i": (1 + 2 * order) * N}
    shapes, made = SHAPES | EXCEPTIONS.get(function.__name__, {}), {}

    def one(name, number=False):
        if name not in made:
            letters = "" if number else shapes.get(name, "NN")
            shape = tuple(sizes[letter] for letter in letters)
            made[name] = make(name, shape, name in SYMMETRIC)
        return given.get(name, made[name])

    def vertex():
        parts = {name: one(name) for name in ("Theta", "EPE", "EVE", "EP", "EV", "EY")}
        C, Bw = one("C"), one("W")
        parts |= {"EPC": one("EP") @ C.T, "EVC": one("EV") @ C.T, "EVA": 0, "Dw": 0}
        return SimpleNamespace(**parts, Bw=Bw)

    def loop():
        parts = {name: one(name) for name in ("E", "A", "C", "P", "F", "G", "mu")}
        return SimpleNamespace(**parts, B=one("W"), D=0, rates=0)

    def times():
        names = "tau", "mu", "delta", "epsilon1", "epsilon2"
        make = later("delay.theorems", "Times")
        return make(*(one(name, number=True) for name in names))

    def functional():
        make = later("delay.theorems", "Functional")
        return make(*map(one, ("P", "Q", "S", "R1", "R2", "R3", "Z")))

    special = {
        "c": vertex,
        "loop": loop,
        "d": lambda: SimpleNamespace(E=one("E"), A=one("A"), Bu=one("B")),
        "v": functional,
        "t": times,
        "W": lambda: one("Wq"),
        "R_inv": lambda: inverse(one("R")),
    }
    arguments = {}
    for name, parameter in signature(function).parameters.items():
        if name in special:
            arguments[name] = special[name]()
        elif name in SQUARES:
            arguments[name] = one(name.removesuffix("2"), number=True) ** 2
        elif name in given or name == "mu" or parameter.default is parameter.empty:
            arguments[name] = given[name] if name in given else one(name)
    matrices = function(**arguments)
    return matrices if isinstance(matrices, tuple) else (matrices,)


def symbol(name, shape, symmetric):
    """A traced matrix; a number counts as one that isn't zero."""
    if shape:
        return Traced.matrix(name, *shape, symmetric=symmetric)
    return Traced.number(name, value=1)


def text_of(function, sizes=(), **given):
    """A theorem in the language of proof files, which `sosbook.language.traced` lists.

    ``function``, ``sizes``, ``**given``: as in `called_with`. Returns the definitions
    of its names, and the matrices that must be positive definite.

    >>> from sosbook.theorems import bounded_real
    >>> print(text_of(bounded_real))
    -[he(Theta), EP C', W; ., -gamma^2/mu, 0; ., 0, -mu] > 0
    """
    matrices = called_with(symbol, function, sizes, **given)
    lines = dict.fromkeys(line for g in matrices for line in g.definitions)
    return "\n".join([*lines, *(f"{g.text} > 0" for g in matrices)])
