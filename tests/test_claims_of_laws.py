"""A claim says the law as it is: what K multiplies, and every state there is."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import verdict
from sosbook.exact.checker.families import listed
from sosbook.runtime.names import claimed
from tests.cases import crossed


def tower(k):
    M, D, S = np.eye(2), [[2, -1], [-1, 1]], [[9 + k, -k], [-k, k]]
    return sos.SecondOrderSystem(M, D, S, [[-1], [1]], coordinates=["floor", "top"])


PLANT, STATES = sos.Uncertain(tower, k=(3, 3.1)), "floor, top, floor', top'"
SENSED = sos.Output(position=[[1, -1]], name="strut")
SENSED &= sos.Output(acceleration=[[0, 1]], name="acc")
LAWS = {  # the law, its gains, its signals, its memory, the states of late sensors
    "full state": (sos.FullState(), [[0, 0.1, 0, 0]], "", "", ""),
    "filter": (
        sos.PIDLaw(position=[[1, -0.3]], filter=0.05, integrate=True),
        {"K_P": [[0.1]], "K_D": [[0.05]], "K_I": [[0.1]]},
        "{0}, rate of {0}, integral of {0}".format("floor - 0.3 top"),
        "integral of {0}, filtered {0}".format("floor - 0.3 top"),
        "",
    ),
    "late sensor": (
        sos.PIDLaw(sensors=SENSED, lag=0.01), [[0.1, 0.05]], "strut, acc", "", "acc"
    ),
    "dynamic": (
        sos.DynamicLaw(1, position=[[1, 0]]),
        {"A_c": [[-1]], "B_c": [[0.1]], "C_c": [[0.1]]},
        "floor, xc1", "xc1", "",
    ),
    "dynamic, late sensor": (
        sos.DynamicLaw(1, sensors=SENSED, lag=0.01),
        {"A_c": [[-1]], "B_c": [[0.1, 0.1]], "C_c": [[0.1]]},
        "strut, acc, xc1", "xc1", "acc",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name, late", crossed(LAWS, [False, True]))
def test_a_claim_names_the_law_and_every_state(name, late):
    law, K, signals, memory, sensors = LAWS[name]
    loop = sos.Loop(PLANT, law, K)
    loop = loop.late(0.01) if late else loop
    proof = loop.prove()
    states = ", ".join(filter(None, [STATES, sensors, memory]))
    if late:
        said = ", under u = K x(t - d)" + f" with x = [{states}]" * bool(signals)
    elif not signals:
        said = ", under u = K x"
    else:
        left = "[u, xc1']" if memory == "xc1" else "u"
        said = f", under {left} = K y with y = [{signals}]"
        said += f" and the memory [{memory}]" * bool(memory)
        said += f", of the states [{STATES}, {sensors}]" * bool(sensors)
    assert f"{said}, is" in proof.claims[0], proof.claims
    assert [*verdict.check(proof.text)] == [*proof.claims] and proof.verify()


def test_a_name_that_is_no_word_is_one_in_a_claim():
    """And in the proof that a user saves: a sentence isn't one."""
    names = ["a, b", "is. It", "phi]", "\n", "x", "", "y" * 200, "\u00fc\u0308"]
    names += [f"{'z' * k} - 0.5 z2 or so." for k in range(85, 99)] + ["a", "a#1", "a"]
    found = claimed(names)
    assert listed(found, len(names)) and found[4] == "x"
    cart = sos.SecondOrderSystem(1, 1, 1, 1, coordinates=["top, it is. Or"])
    law = sos.PIDLaw(position=[[1]], filter=0.1)
    proof = sos.Loop(cart, law, {"K_P": [[0.1]], "K_D": [[0]]}).prove()
    assert proof.proven and "y = [top_ it is_ Or, rate of" in proof.claims[0]
