"""A request as data of a page: its plant, its requirements, and their Python."""

from dataclasses import fields

import numpy as np

from ...plants.outputs import Output
from ...plants.second_order import SecondOrderSystem
from .page import significant

DIGITS = 15  # of the plant's matrices: all that a decimal keeps
PLACE = "{}"  # of the bound, in the words of a requirement
REGION = "sigma", "theta", "rho"
#: What the page says of a requirement beside its bound, by its parameter.
SAID = dict.fromkeys(REGION, ()) | {
    "gamma": ("mu",),
    "u_max": ("x0",),
    "cost": ("Q", "R", "noise", "C"),
}


def program_data(request):
    """The argument of the page's ``sosProgram.design``, without the bounds.

    ``request``: its bounds are left to the page, which knows them by their names.
    Returns the plant as "request", "x0", "mu" and "cost" (None where they aren't
    asked), and as "own" the requirements that the page doesn't know, in Python's words.
    """
    cost, saturation = request.cost, request.saturation
    return {
        "request": plant_data(request.plant, request.U, request.K_A)
        | {"coupling": request.coupling.word},
        "x0": None if saturation is None else significant(saturation.x0, DIGITS),
        "mu": request.mu,
        "cost": cost
        and {"Q": cost.Q.tolist(), "R": cost.R.tolist(), "noise": cost.noise},
        "own": [_own(r) for r in request.requirements if not _known(r)],
    }


def plant_data(plant, U, K_A=None):
    """The matrices of a plant or polytope as JSON has them.

    ``plant``: its vertices' M, D, S, B, and F where it has one; ``U``, ``K_A``: as in
    `design_pid`. Returns dict: "vertices", "U" and "K_A", lists of rows with fifteen
    digits.
    """
    return {
        "vertices": [_matrices(v) for v in plant.vertices],
        "U": [] if U is None else significant(U, DIGITS),
        "K_A": None if K_A is None else significant(K_A, DIGITS),
    }


def page_loop(request, r, horizon):
    """The plant of a request in the numbers that the page's step response needs.

    ``r``: its set point; ``horizon``: seconds that are shown.
    """
    plant = request.plant
    n, a = plant.n, request.order - 2 * plant.n
    r = np.ones(n) if r is None else np.asarray(r, float)
    if r.shape != (n,):
        raise ValueError(f"r must hold n = {n} numbers")
    vertices = []
    for d in request.vertices:
        A, B, _ = d.state_space()
        s = np.concatenate([np.zeros(2 * n), -d.A[2 * n :, :n] @ r])
        vertices.append({x: significant(X, 12) for x, X in zip("ABs", (A, B, s))})
    many = "" if isinstance(plant, SecondOrderSystem) else ", every vertex"
    goal = ", ".join(f"{x:.4g}" for x in r)
    return {
        "shape": [n, plant.m, a],
        "vertices": vertices,
        "r": significant(r, 12),
        "horizon": significant(horizon, 8),
        "caption": f"Step response from rest to the set point ({goal}){many}.",
    }


def _known(r):
    """True if the page's own words say all of a requirement ``r``."""
    key = r.parameter and r.parameter.key
    if key not in SAID or not type(r).__module__.startswith("sosbook.requirements"):
        return False
    told = {_field(r), *SAID[key]}
    others = [f for f in fields(r) if f.init and f.name not in told]
    values = [(getattr(r, f.name), f.default) for f in others]
    return key in REGION or all(
        x is None or (np.ndim(x) == 0 and x == usual) for x, usual in values
    )


def _field(r):
    """The name of the bound among the fields of a requirement, where it has one."""
    which = r.parameter and getattr(r, "plain", r.parameter)
    return which and (which.key if hasattr(r, which.key) else "bound")


def _own(r):
    """A requirement as Python writes it, with `PLACE` where its bound stands."""
    cls, key, bound = type(r), r.parameter and r.parameter.key, _field(r)
    words = ", ".join(
        f"{f.name}={PLACE if f.name == bound else _literal(value)}"
        for f in fields(r)
        if f.init and ((value := getattr(r, f.name)) is not None or f.name == bound)
    )
    ours = cls.__module__.startswith("sosbook.")
    note = (
        f"# {cls.__name__} is a class of your own: define or import it first."
        if cls.__module__ == "__main__"
        else f"from {cls.__module__} import {cls.__name__}"
    )
    name = f"sos.{cls.__name__}" if ours else cls.__name__
    return {"key": key, "text": f"{name}({words})", "note": "" if ours else note}


def _literal(value):
    if isinstance(value, Output):
        return " & ".join(f"sos.Output({_named(part)})" for part in value.parts)
    return repr(value.tolist() if isinstance(value, np.ndarray) else value)


def _named(part):
    given = {f.name: getattr(part, f.name) for f in fields(part)}
    return ", ".join(
        f"{name}={_literal(x)}" for name, x in given.items() if np.size(x) and str(x)
    )


def _matrices(v):
    names = "MDSBF" if v.p else "MDSB"
    return {name: significant(getattr(v, name), DIGITS) for name in names}
