"""Which `need` of the checker refuses something: by its place in the source."""

import ast
import sys
from contextlib import contextmanager
from functools import cache
from importlib import import_module

import numpy as np

import sosbook as sos
from sosbook.exact.checker import CHECKER, MODULES, arithmetic, kernel, verdict
from sosbook.plants import descriptors
from tests.energy_to_peak import EnergyToPeak
from tests.hunt.tampering import put
from tests.test_near_box import REGION, levers
from tests.test_proof_files import TWO, proof_of, spring

HERE = {x: import_module(f"sosbook.exact.checker.{x}") for x in MODULES}


def near_a_box(made=lambda plants: plants):
    """A proof of corners that float's roundings keep from being a box."""
    of = levers(8, 0.3).vertices
    plants = sos.Polytope(
        sos.SecondOrderSystem(v.M, v.D, v.S, v.B, [[0.3], [0.1]]) for v in of
    )
    asked = dict(region=REGION, gamma=300.0, coupling="pairs")
    return sos.design_pid(made(plants), **asked).certify()


def of_samples(name):
    from tests.test_sampled_text import proof

    return lambda: proof(name)


MORE = {  # files that the tests of other things don't have
    **{
        f"sampled, {x}": of_samples(x)
        for x in (
            "one plant",
            "masses, a simplex",
            "a box",
            "a clock that varies",
            "a law and a norm",
            "a law that reads w",
        )
    },
    "near a box": near_a_box,
    "near a box, first order": lambda: near_a_box(
        lambda plants: sos.DescriptorSystem.of(descriptors(plants))
    ),
    "near a box, refused": lambda: (
        sos.design_pid(
            levers(8, 0.3),
            coupling="pairs",
            region=REGION,
            saturation=sos.Saturation(17.9, [1, 0, 0, 0]),
        ).infeasibility
    ),
    "an author's": lambda: sos.design_pid(
        TWO,
        requirements=[EnergyToPeak(5.0), sos.Saturation(60, [0.1, 0])],
        coupling="pairs",
    ).certify(),
    "reduced": lambda: sos.design_pid(
        sos.SecondOrderSystem(
            np.eye(3), 0.1 * np.eye(3), np.diag([1.0, 2, 9]), np.eye(3)
        ).reduce(modes=2)
    ).certify(),
    "mixed cost": lambda: sos.design_pid(
        spring(),
        requirements=[
            sos.QuadraticCost(np.eye(2), [[1.0]], bound=50.0, N=[[0.1], [0]])
        ],
    ).certify(),
}


@cache
def needs():
    """{(module, first line): (last line, source)} of each call of `need`."""
    found = {}
    for name in MODULES:
        for x in ast.walk(ast.parse((CHECKER / f"{name}.py").read_text("utf-8"))):
            if isinstance(x, ast.Call) and getattr(x.func, "id", "") == "need":
                found[name, x.lineno] = x.end_lineno, ast.unparse(x)
    return found


@contextmanager
def watched():
    """A list of the places of the needs that refuse, in order, as long as it's open."""
    places = []

    def need(condition, *words):
        if not condition:
            frame = sys._getframe(1)
            name = frame.f_globals["__name__"].rpartition(".")[2]
            places.extend(
                (module, first)
                for (module, first), (last, _) in needs().items()
                if module == name and first <= frame.f_lineno <= last
            )
            raise arithmetic.Refused(*words)

    held = [x for x in HERE.values() if hasattr(x, "need")]
    try:
        for module in held:
            module.need = need
        yield places
    finally:
        for module in held:
            module.need = honest


honest = arithmetic.need


def refusal(do, *given):
    """The place of the `need` that ends a call, or what else becomes of it."""
    with watched() as places:
        try:
            do(*given)
        except arithmetic.Refused:
            return places[-1] if places else "raised"
        except (verdict.Beyond, *kernel.MALFORMED) as fault:
            return type(fault).__name__
    return places[-1] if places else "accepted"


def decided(asked):
    """The kernel decides of the text that is written for what is asked."""
    text, _ = verdict.text_of(asked)
    kernel.check(text.file())


@cache
def base(name):
    """What a proof asks, with its kind."""
    proof = MORE[name]() if name in MORE else proof_of(name)
    data = {k: v for k, v in proof.data.items() if k not in ("claims", "blocks")}
    return {"kind": proof.kind, **data}


def changed(name, changes):
    """What a proof asks, with other values at some paths; null takes a key away."""
    asked = base(name)
    for path, value in changes:
        asked = put(asked, path, value)
    return asked
