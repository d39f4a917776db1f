"""A proof is a file: saved, read again, and checked by a program of its own."""

import copy
import importlib
import json
import pickle
import pkgutil
import re
import shutil
import sys
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import sosbook as sos
from sosbook import proofs
from sosbook.book import thesis
from sosbook.book.reproduction.region_of_attraction import region_of_attraction
from sosbook.controllers.margins import Margins
from sosbook.controllers.windup import Reach
from sosbook.exact import proof_file, quick
from sosbook.exact.checker import families, in_one_file
from sosbook.exact.checker import text as texts
from sosbook.exact.checker import verdict as checker
from sosbook.exact.proof_file import KINDS, ProofFile
from sosbook.exact.rational import decimal, fraction, read_number
from sosbook.lmi import LMIProblem, he, symmetric
from sosbook.proofs.command import main
from sosbook.requirements.stability import Stability
from sosbook.sampled.proof import by_balls
from sosbook.synthesis.growing import refuse_by_growth
from sosbook.synthesis.proofs import DesignProof
from sosbook.synthesis.request import Request
from tests.asking import asked_by, asking
from tests.cases import by_turns, campaign
from tests.closed import analyse_loop
from tests.energy_to_peak import EnergyToPeak
from tests.hunt.tampering import true_claims
from tests.once import once
from tests.processes import alone, process
from tests.test_infeasible import mass
from tests.test_multipliers import loops

ONE = [[1.0]]


def spring(M=1.0, D=0.1, S=1.0, B=1.0, F=1.0):
    return sos.SecondOrderSystem(*([[x]] for x in (M, D, S, B, F)))


TWO = sos.Polytope([spring(1), spring(2)])  # one mass: the vertices suffice
SLOW = sos.PoleRegion(sigma=0.1)
DELAYED = sos.SecondOrderSystem(
    M=np.eye(2), D=[[1, -1], [-1, 1]], S=[[3, -2], [-2, 3]], B=[[1], [0]]
)
LOOP = sos.delay.DelayedLoop([[-2, 0], [0, -0.9]], [[-1, 0], [-1, -1]])


def twins(damping, coupling=0.0, stiffness=1.0):
    """Two equal masses that one input pushes alike: their difference stays."""
    S = [[stiffness, coupling], [coupling, stiffness]]
    return sos.SecondOrderSystem(
        np.eye(2), damping * np.eye(2), S, [[1], [1]], np.eye(2)
    )


ONE_OF_TWO = [[1.0, 0.0]]


def pushed(stiffness=1.0):
    """Two masses, a spring between them, an input at the first, w at the second."""
    S = [[2.0, -1.0], [-1.0, 1.0 + stiffness]]
    return sos.SecondOrderSystem(
        np.eye(2), 0.2 * np.eye(2), S, [[1.0], [0.0]], [[0.0], [1.0]]
    )


def driven(masses, stiffness=1.0):
    """Two masses, a spring between them, a force on each."""
    S = [[2.0, -1.0], [-1.0, 1.0 + stiffness]]
    return sos.SecondOrderSystem(
        np.diag(masses), 0.2 * np.eye(2), S, np.eye(2), np.eye(2)
    )


APART = sos.Polytope([driven([1.0, 1.5]), driven([1.5, 1.0])])  # they need their pair


def mass2(M):
    """Three masses, each with an input."""
    return sos.SecondOrderSystem(np.diag(M), np.eye(3), np.eye(3), np.eye(3))


def lyapunov(A):
    P = symmetric("P", len(A))
    return LMIProblem({"P": P, "decay": -he(A @ P)}).solve()


A2 = [[0, 1], [-1, -1]]


def singular():
    return sos.SecondOrderSystem(
        np.diag([1, 0]), np.eye(2), [[2, -1], [-1, 1]], [[0], [1]], np.eye(2)
    )


def robot():
    ex = thesis.example_1()
    return sos.design_pid(ex.plant, **ex.requirements).certify()


def every_region(coupling):
    make = sos.LMIRegion
    region = make.ellipse(-4, 3.9, 5) & make.strip(-8, -0.1) & make.disk(8, -2)
    region &= make.horizontal_strip(6) & make.sector(1.2, apex=0.3)
    region &= make([[-20.0]], [[1.0]], "mine") & make.half_plane(0.05)
    return sos.design_pid(APART, ONE_OF_TWO, region=region, coupling=coupling).certify()


def cost(noise, coupling):
    asked = sos.QuadraticCost(np.diag([1, 1, 1, 1, 0]), np.eye(2), noise, bound=500.0)
    return sos.design_pid(
        APART, ONE_OF_TWO, requirements=[asked], coupling=coupling
    ).certify()


def with_h2_norm(coupling):
    asked = [sos.H2(9.0, outputs=sos.Output(position=1, input=0.1), inputs=[0])]
    return sos.design_pid(
        APART, ONE_OF_TWO, requirements=asked, coupling=coupling
    ).certify()


def accelerated(coupling):
    K_A = sos.regularize(singular()).certify().K
    bound = sos.Saturation(30, [0.1, 0, 0, 0], acceleration=True)
    return sos.design_pid(
        singular(), K_A=K_A, saturation=bound, coupling=coupling
    ).certify()


def with_input_in_the_output(coupling):
    loop = sos.DescriptorSystem(
        [np.eye(2), np.diag([1, 1.5])],
        [[0, 1], [-1, -0.3]],
        [[0], [1]],
        [[0], [1]],
        [[1, 0], [0, 0]],
        [[0], [0.3]],
    )
    return sos.design_pid(loop, gamma=3.0, coupling=coupling).certify()


def late(**asked):
    asked = dict(tau=0.4, mu=0.2, delta=0.1) | asked
    return sos.design_delay_pid(DELAYED, U=[[1, 0]], **asked).certify()


def moving(m, v):
    """A parameter squared: Bernstein's middle coefficient is no plant."""
    return sos.SecondOrderSystem([[m]], [[0.2 + 0.1 * v]], [[1 + v**2]], ONE, ONE)


def parallelogram():
    """Loops that are a box of two parameters, whose vertices stand in no order."""
    parts = [[*x, x[1] + x[2] - x[0]] for x in loops(29, vertices=3, spread=2.2)[:2]]
    return sos.DescriptorSystem(*([x[k].round(3) for k in (3, 1, 0, 2)] for x in parts))


def known(plant, K, U=None, cells=1, **asked):
    """The proof of a known gain by so many cells or more."""
    design = sos.analyse_pid(plant, K, U, coupling="multipliers", **asked)
    assert max(part.cells for part in design.parts) >= cells
    return design.certify()


def measured(law, gains, **asked):
    """The proof of a law for two carts, of which the first's position is measured."""
    carts = [driven([m, 1.0]) for m in (1, 1.2)]
    return sos.analyse_pid(sos.Polytope(carts), gains, law=law, **asked).certify()


TRIANGLE = loops(6, vertices=3, spread=1.6)
GENTLE = [[-1, -0.5]]
CORNERS = [[0.3, 0.1, 0, 0], [0.3, -0.1, 0, 0]]
TRACKS = sos.SecondOrderSystem(
    np.eye(2), 0.1 * np.eye(2), [[1, -0.5], [-0.5, 1]], np.eye(2)
)


def ticks(a=(0.5, 1.2)):
    """A family of plants of discrete time."""

    def builder(a):
        A, B = [[a, 0.9], [-0.3, 1.1]], [[0.2], [1]]
        return sos.DescriptorSystem(
            [[1, 0.1], [0, a + 0.5]], A, B, B, C=[[1, 0]], D_u=[[0.1]], dt=0.05
        )

    return sos.Uncertain(builder, a=a)


AT_TICKS = dict(
    region=sos.LMIRegion.disk(0.97),
    gamma=30.0,
    requirements=[sos.H2(30.0), sos.QuadraticCost(np.eye(2), ONE, "F", 99.0)],
)
# What the stand-alone checker decides, and what it must pass on.
PROOFS = {
    "ticks, pairs": lambda: sos.design_pid(ticks(), **AT_TICKS).certify(),
    "ticks, slack": lambda: sos.design_pid(
        ticks(), coupling="slack", **AT_TICKS
    ).certify(),
    "ticks, known gain": lambda: known(ticks(), [[-0.6, -1.6]], **AT_TICKS),
    "ticks, states": lambda: sos.design_pid(
        ticks(), requirements=[sos.QuadraticCost(np.eye(2), ONE, bound=99.0)]
    ).certify(),
    "scheduled": lambda: sos.design_pid(
        sos.Uncertain(lambda m: spring(m, 0, 0), m=(1, 9)),
        law=sos.Scheduled("m"),
        region=sos.PoleRegion(sigma=1, rho=4),
    ).certify(),
    "sampled": lambda: sos.certify_sampled(TWO, [[-1, -1.5]], T=0.2, delay=0.1),
    "known gain": lambda: known(
        sos.Uncertain(moving, m=(0.5, 2), v=(-1, 3)),
        GENTLE,
        cells=3,
        region=sos.LMIRegion.disk(8, -1) & sos.LMIRegion.sector(1.53),
        gamma=2.0,
        saturation=sos.Saturation(4, [1, 0]),
        requirements=[sos.QuadraticCost(C=[[1, 0]], R=ONE, noise="F", bound=30.0)],
    ),
    "known gain, in a box": lambda: known(
        parallelogram(),
        np.zeros((0, 4)),
        cells=2,
        region=sos.LMIRegion.half_plane(0.222),
    ),
    "known gain, in a simplex": lambda: known(
        sos.DescriptorSystem(*TRIANGLE[:2]),
        np.zeros((0, 4)),
        cells=2,
        region=sos.LMIRegion.half_plane(0.851),
    ),
    "known law": lambda: measured(
        sos.PIDLaw([[1, 0]], integrate=True, filter=0.3, noise=[[0, 0.1]]),
        dict(K_P=[[0.1], [0]], K_D=[[-0.6], [0.1]], K_I=[[-0.1], [0]]),
        gamma=12.0,
        region=sos.PoleRegion(0.02, 1.55, 20),
        saturation=sos.Saturation(9, [0.1, 0, 0, 0, 0, 0]),
        requirements=[sos.QuadraticCost(np.eye(6), np.eye(2), "states", bound=1e4)],
    ),
    "known gain, outputs": lambda: known(
        sos.Uncertain(moving, m=(0.5, 2), v=(1, 2)),
        GENTLE,
        requirements=[
            sos.HInfinity(
                6.0,
                outputs=sos.Output(acceleration=1, name="felt")
                & sos.Output(input=0.1, disturbance=0.2),
                name="ride",
            ),
            sos.HInfinity(3.0, inputs=[0]),
            sos.H2(3.0, outputs=sos.Output(position=1, input=0.1)),
        ],
    ),
    "known gain, outputs that differ": lambda: known(
        sos.DescriptorSystem(
            [np.eye(2), np.diag([1, 1.5])],
            A2,
            [[0], [1]],
            [[0], [1]],
            C=[[[1, 0]], [[1, 0.2]]],
            D_u=[[[0.1]], [[0.2]]],
            D_w=[[[0.3]], [[0]]],
        ),
        [[-0.1, -0.2]],
        gamma=5.0,
        requirements=[
            sos.QuadraticCost(np.eye(2), ONE, "F", bound=50.0, N=[[0.1], [0]])
        ],
    ),
    "known law, outputs": lambda: measured(
        sos.PIDLaw([[1, 0]], integrate=True, filter=0.3, noise=[[0, 0.1]]),
        dict(K_P=[[0.1], [0]], K_D=[[-0.6], [0.1]], K_I=[[-0.1], [0]]),
        requirements=[
            sos.HInfinity(
                60.0,
                outputs=sos.Output(acceleration=1)
                & sos.Output(disturbance=0.2, input=1),
            ),
            sos.HInfinity(60.0, inputs=[0], name="one"),
            sos.H2(90.0, outputs=sos.Output(acceleration=[[0, 1]]), inputs=[0]),
        ],
    ),
    "known dynamic law": lambda: measured(
        sos.DynamicLaw(1, [[1, 0]], strictly_proper=True, noise=[[0, 0.1]]),
        [[0, -0.5], [0, 0], [0.2, -1]],
        region=sos.PoleRegion(0.02),
        requirements=[sos.QuadraticCost(np.eye(5), np.eye(2), "F", bound=1e4)],
    ),
    "example 1": robot,
    "regions": lambda: every_region("pairs"),
    "regions, slack": lambda: every_region("slack"),
    "vertices": lambda: sos.design_pid(
        APART, ONE_OF_TWO, coupling="vertices"
    ).certify(),
    "vertices that suffice": lambda: sos.design_pid(
        TWO, ONE, coupling="vertices"
    ).certify(),
    "stability": lambda: sos.design_pid(spring()).certify(),
    "H-infinity": lambda: sos.design_pid(TWO, ONE, gamma=2.0).certify(),
    "H-infinity, pairs": lambda: sos.design_pid(APART, ONE_OF_TWO, gamma=2.0).certify(),
    "H-infinity, slack": lambda: sos.design_pid(
        TWO, ONE, gamma=2.0, coupling="slack"
    ).certify(),
    "input": lambda: sos.design_pid(
        TWO, region=SLOW, saturation=sos.Saturation(10, [1, 0])
    ).certify(),
    "input, slack": lambda: sos.design_pid(
        TWO, region=SLOW, saturation=sos.Saturation(10, [1, 0]), coupling="slack"
    ).certify(),
    "each input, a box": lambda: sos.design_pid(
        TRACKS, region=SLOW, saturation=sos.Saturation([9, 8], CORNERS)
    ).certify(),
    "each input of a law": lambda: measured(
        sos.PIDLaw([[1, 0]], filter=0.3),
        dict(K_P=[[-0.5], [0]], K_D=[[-0.6], [0.1]]),
        saturation=sos.Saturation([9, 8], CORNERS),
    ),
    "all at once": lambda: sos.design_pid(
        TWO,
        ONE,
        region=sos.PoleRegion(0.05, 1.4, 50),
        gamma=3.0,
        saturation=sos.Saturation(200, [0.1, 0, 0]),
        requirements=[sos.QuadraticCost(np.eye(3), ONE, "F", bound=500.0)],
    ).certify(),
    "cost of noise on the states": lambda: cost("states", "pairs"),
    "cost of noise on F": lambda: cost("F", "pairs"),
    "cost of noise on the states, slack": lambda: cost("states", "slack"),
    "cost of noise on F, slack": lambda: cost("F", "slack"),
    "H2": lambda: with_h2_norm("pairs"),
    "H2, slack": lambda: with_h2_norm("slack"),
    "least cost": lambda: sos.design_lqr(TWO, np.eye(3), ONE, ONE).certify(),
    "acceleration": lambda: accelerated("pairs"),
    "acceleration, slack": lambda: accelerated("slack"),
    "input in the output": lambda: with_input_in_the_output("pairs"),
    "input in the output, slack": lambda: with_input_in_the_output("slack"),
    "closed loop": lambda: analyse_loop(
        np.eye(2), [[[0, 1], [-2, -3]], [[0, 1], [-3, -2]]]
    ).certify(),
    "a range": lambda: sos.design_pid(
        sos.Uncertain(lambda k: spring(S=k * k, D=0.1 * k), k=(1, 1.2)), gamma=3.0
    ).certify(),
    "regular mass": lambda: sos.regularize(singular()).certify(),
    "delay": lambda: late(alpha=0.8),
    "constant delay": lambda: late(mu=0.0, alpha=0.8),
    "delay, shift": lambda: late(method="shift"),
    "delay, analysis": lambda: sos.analyse_delay(
        DELAYED, [[-0.1, -0.1, -0.2, -0.1]], tau=0.4, mu=0.1
    ).certify(),
    "delayed loop": lambda: sos.analyse_delay(LOOP, tau=1.0, delta=0.01).certify(),
    "legendre": lambda: sos.analyse_delay(LOOP, tau=6.16, method="legendre").certify(),
    "legendre, varying": lambda: sos.analyse_delay(
        LOOP, tau=1.0, mu=0.2, delta=0.01, method="legendre", order=3
    ).certify(),
    "interval": lambda: sos.analyse_delay(
        LOOP, tau=1.0, mu=0.2, delta=0.01, method="interval"
    ).certify(),
    "interval of order 0": lambda: sos.analyse_delay(
        LOOP, tau=1.0, mu=0.2, method="interval", order=0
    ).certify(),
    "interval from zero": lambda: sos.analyse_delay(
        DELAYED, [[-0.1, -0.1, -0.2, -0.1]], tau=0.1, mu=0.1, method="interval"
    ).certify(),
    "interval of one point": lambda: sos.analyse_delay(
        LOOP, tau=1.0, method="interval"
    ).certify(),
    "observer": lambda: sos.design_observer(
        spring(S=-1.0),
        sos.design_lqr(spring(S=-1.0), np.eye(2), ONE).K,
        Q_F=[[0], [1], [0], [0]],
        R_F=[[0.1]],
    ).certify(),
    "an LMI of one's own": lambda: lyapunov([[0, 1], [-2, -3]]).prove(("stable",)),
    "region of attraction": lambda: (
        region_of_attraction(
            spring(S=-1), [[-3, -2]], row=[1, 0], bound=1, start=[1, 0]
        ).proof
    ),
}


def growing(plant, requirement, gain=((0.0, 0.0),)):
    """The refusal of a small loop by what refuses large ones."""
    request = Request(plant, gain=np.array(gain), requirements=[requirement])
    return SimpleNamespace(
        infeasibility=refuse_by_growth(request, (0, 0), [requirement])
    )


EXCLUDED = {
    "ticks, a fixed mode": lambda: sos.design_pid(
        sos.DescriptorSystem(np.eye(2), [[0.5, 1], [0, 1.2]], [[1], [0]], dt=0.1)
    ),
    "ticks, too small a norm": lambda: sos.design_pid(ticks(), gamma=0.1),
    "too little force": lambda: sos.design_pid(
        mass(D=[[-1.0]], S=ONE), saturation=sos.Saturation(0.5, [1, 0])
    ),
    "fast with little force": lambda: sos.design_pid(
        mass(), region=sos.PoleRegion(3), saturation=sos.Saturation(1, [1, 0])
    ),
    "little force for two": lambda: sos.design_pid(
        sos.Polytope([mass(S=[[-1.0]]), mass(M=[[2.0]], S=[[-1.0]])]),
        saturation=sos.Saturation(0.5, [1, 0]),
    ),
    "little force, slack": lambda: sos.design_pid(
        mass(),
        region=sos.PoleRegion(3),
        saturation=sos.Saturation(0.5, [1, 0]),
        coupling=("slack", 0.3),
    ),
    "little force for a fast fall": lambda: sos.design_pid(
        mass(D=[[0.1]], S=[[-2.0]]), saturation=sos.Saturation(1.8, [1, 0])
    ),
    "little force for a slow pair": lambda: sos.design_pid(
        sos.SecondOrderSystem(
            np.eye(2), np.diag([0.1, 6]), [[4, 1], [1, 8]], [[1], [1]]
        ),
        region=sos.PoleRegion(sigma=1, rho=9),
        saturation=sos.Saturation(0.3, [1, 0, 0, 0]),
    ),
    "a mode at rest": lambda: sos.design_pid(
        twins(0.01), region=sos.PoleRegion(sigma=1)
    ),
    "a mode on the imaginary axis": lambda: sos.design_pid(twins(0, -0.3)),
    "a mode on a circle": lambda: sos.design_pid(
        twins(1, stiffness=4), region=sos.PoleRegion(rho=2)
    ),
    "a mode beside a sector": lambda: sos.design_pid(
        twins(0.3), region=sos.PoleRegion(theta=0.5)
    ),
    "a mode beside an ellipse": lambda: sos.design_pid(
        twins(0.3, stiffness=4), region=sos.LMIRegion.ellipse(-4, 3.9, 1)
    ),
    "a mode between two plants": lambda: sos.design_pid(
        sos.Polytope([spring(D=0.0), spring(D=0.0, B=-1.0)])
    ),
    "a pole of a given loop": lambda: sos.analyse_pid(spring(M=3.0), [[-1, 2]]),
    "a form that grows": lambda: growing(spring(D=-0.3), Stability()),
    "two forms that grow": lambda: growing(
        spring(D=0.3), sos.LMIRegion.sector(0.5), gain=[[0.1, -0.2]]
    ),
    "a pole of a closed loop": lambda: analyse_loop(np.eye(2), [[0, 1], [1, 0]]),
    "an unstable mode, for H-infinity": lambda: sos.design_pid(twins(-0.1), gamma=3.0),
    "a mode that no sensor sees": lambda: sos.design_pid(
        twins(0.01), law=sos.PIDLaw([[1, 1]]), region=sos.PoleRegion(sigma=1)
    ),
    "a state of a law": lambda: sos.design_pid(
        sos.SecondOrderSystem(np.eye(2), np.eye(2), np.eye(2), [[1], [0.3]]),
        law=sos.PIDLaw(np.eye(2), filter=0.1, integrate=True),
    ),
    "sum of poles": lambda: sos.design_pid(
        TWO, law=sos.PIDLaw(position=[[1]]), region=sos.PoleRegion(5)
    ),
    "sum of poles at zero": lambda: sos.design_pid(
        spring(D=0.0), law=sos.PIDLaw(position=[[1]]), gamma=9.0
    ),
    "no controller of any order": lambda: sos.design_pid(
        pushed(),
        law=sos.DynamicLaw(1, [[1, 0]], noise=[[0.5]]),
        gamma=0.7,
        search=sos.Search(starts=1),
    ),
    "a response out of reach": lambda: sos.design_pid(pushed(), gamma=0.4),
    "a response out of reach, at a vertex": lambda: sos.design_pid(
        sos.Polytope([pushed(), pushed(2.0)]), ONE_OF_TWO, gamma=0.2
    ),
    "an output's response out of reach, at a vertex": lambda: sos.design_pid(
        sos.Polytope([pushed(), pushed(2.0)]),
        requirements=[sos.HInfinity(0.1, outputs=sos.Output(acceleration=np.eye(2)))],
    ),
    "a given loop's response": lambda: sos.analyse_pid(
        pushed(), [[-1.0, -1.0, 0.0, 0.0]], gamma=0.4
    ),
    "a singular mass": lambda: sos.design_pid(
        sos.DescriptorSystem([np.eye(2), np.diag([1, -1])], A2, [[0], [1]])
    ),
    "a singular mass halfway": lambda: sos.design_pid(
        sos.Polytope([mass2([1, 2, 3]), mass2([1, -2, -3])])
    ),
    "an LMI of one's own, empty": lambda: lyapunov([[0, 1], [-2, 3]]),
    "a loop that is late": lambda: sos.analyse_delay(
        sos.delay.DelayedLoop([[0.5]], [[-1]]), tau=1.5
    ),
    "states that are late": lambda: sos.analyse_delay(LOOP, tau=6.3),
    "states that are late, legendre": lambda: sos.analyse_delay(
        LOOP, tau=6.3, method="legendre"
    ),
    "equations that aren't late": lambda: sos.analyse_delay(
        spring(), [[-0.1, 0.0]], tau=3.0, delta=0.5
    ),
    "no observer": lambda: sos.design_observer(
        sos.Polytope([spring(1, 4, 5), spring(1, -3, 3, 0)]),
        [[-1, -1]],
        Q_F=np.eye(4),
        R_F=ONE,
    ),
    "a slow mode behind a delay": lambda: sos.design_delay_pid(
        thesis.delay_example_1(published=True).plant,
        tau=0.2,
        mu=0.1,
        delta=0.6,
        alpha=0.6,
    ),
    "no mass without input": lambda: sos.regularize(
        sos.SecondOrderSystem([[1.0, 5], [5, 0]], *[np.eye(2)] * 2, [[0], [1]]), 2
    ),
}
BEYOND = {
    "by balls": lambda: by_balls(TWO, [[-1, -1.5]], T=0.2, delay=0.1),
    "an author's bound and little force": lambda: (
        sos.design_pid(
            spring(),
            requirements=[EnergyToPeak(1e-3)],
            saturation=sos.Saturation(0.5, [1, 0]),
        ).infeasibility
    ),
}


@cache
def refused(name):
    """The answer of that name, which excludes what was asked."""
    return EXCLUDED[name]()


@cache
def proof_of(name):
    """The proof of that name, made once for all files of tests."""
    if name in EXCLUDED:
        return once(name, lambda: refused(name).infeasibility)
    return once(name, (PROOFS | BEYOND)[name])


@pytest.mark.parametrize("name", [*PROOFS, *EXCLUDED])
def test_the_checker_agrees(name):
    proof = proof_of(name)
    assert proof.proven and proof.verify() and bool(proof)
    assert json.loads(proof.text)["version"] == 2
    assert checker.check(proof.text) == list(proof.claims)
    assert asking(asked_by(proof)) == json.loads(proof.text)
    if proof.kind != "lmi":  # what these blocks mean is their author's word
        assert true_claims(asked_by(proof)) is not False


@pytest.mark.parametrize("name", [*by_turns(PROOFS | EXCLUDED, 0), *BEYOND])
def test_the_quick_answer_is_the_package_s(name, tmp_path, capsys, monkeypatch):
    """The same words and exit code, or none: then the package is asked."""
    monkeypatch.setattr(quick, "SECONDS", 60.0)  # for a slow machine
    file = tmp_path / "proof.json"
    proof_of(name).save(file)
    quickly = quick.verify(file), capsys.readouterr().out
    if quickly[0] is None:
        assert name in BEYOND and not quickly[1]
        assert main(["verify", str(file)]) == 0
        assert "this package alone decides it" in capsys.readouterr().out
    else:
        assert quickly == (main(["verify", str(file)]), capsys.readouterr().out)
    file.write_text(proof_of(name).text.replace("1", "2"), "utf-8")
    assert quick.verify(file) is None and not capsys.readouterr().out


def test_a_verdict_is_kept_with_its_text():
    """Of 65 proofs that are asked in turn each was examined again."""
    proof = copy.copy(proof_of(next(iter(PROOFS))))
    first = proof.examined
    proof_file._remembered.cache_clear()
    assert first.proven and proof.examined is first
    object.__setattr__(proof, "text", "{}")
    assert not proof.proven


def test_each_kind_is_a_text_or_says_that_it_is_an_enclosure():
    """Its readers: the checker and the package, or the package alone."""
    two, one = (
        {proof_of(name).kind for name in names}
        for names in ([*PROOFS, *EXCLUDED], BEYOND)
    )
    assert KINDS.keys() == two and one <= two
    for name in [*PROOFS, *EXCLUDED, *BEYOND]:
        alone = "by an enclosure of one program:" in str(proof_of(name))
        assert alone == (name in BEYOND) == bool(proof_of(name).examined.alone)
    no_file = Reach(1.0, 0.5, 1, "rad"), Margins("u", "ab", "c", "d", None, None)
    assert all("proven by one program" in str(x) for x in no_file)


def held_against(plant, proof, folder):
    """Both programs hold a proof against the reader's own file of the plant."""
    parts = [{k: getattr(v, k).tolist() for k in "MDSBF"} for v in plant.vertices]
    mine, file = folder / "plant.json", folder / "proof.json"
    proof.save(file)
    for plants, code in ((parts, 0), ([*parts, parts[0]], 1)):
        mine.write_text(json.dumps({"vertices": plants}), "utf-8")
        for verify in checker.main, lambda asked: main(["verify", *asked]):
            assert verify([str(file), "--plant", str(mine)]) == code


@pytest.mark.parametrize("name", EXCLUDED)
def test_a_refusal_names_the_plant_that_was_asked(name, tmp_path):
    answer = refused(name)
    plant = getattr(getattr(answer, "request", answer), "plant", None)
    if one := re.match(r"At vertex (\d+) alone", getattr(answer, "reason", "")):
        plant = plant.vertices[int(one[1]) - 1]
    if isinstance(plant, (sos.SecondOrderSystem, sos.Polytope)):
        held_against(plant, answer.infeasibility, tmp_path)


@pytest.mark.parametrize("name", [*by_turns(PROOFS | EXCLUDED, 1), *BEYOND])
def test_a_file_is_read_as_what_it_was(name, tmp_path):
    proof = proof_of(name)
    proof.save(tmp_path / "proof.json")
    again = proofs.load(tmp_path / "proof.json")
    assert again == proof and type(again) is type(proof)
    assert again.verify() and again.claims == proof.claims
    assert type(proof).load(tmp_path / "proof.json") == proof


def test_a_text_that_is_refused_proves_nothing(monkeypatch):
    proof = robot()
    assert proof.proven

    def refuse(asked):
        raise checker.Refused("for a test")

    monkeypatch.setattr(checker, "text_of", refuse)
    plain = DesignProof.of(proof.data)
    assert not plain.proven and "for a test" in plain.failed[0]
    assert not proof.verify()


def test_every_kind_of_proof_is_tried():
    """A new kind of file needs an example here, and so a verdict of the checker."""
    tried = {type(proof_of(name)) for name in [*PROOFS, *EXCLUDED, *BEYOND]}
    assert tried == {ProofFile.owner(kind) for kind in proofs.kinds()}
    assert tried <= {getattr(proofs, name) for name in proofs.__all__}


# What says "proven" and is no file: the files that it speaks of.
SPEAKERS = {
    "Bound": "a number: the bound that its part proves",
    "Bounded": "a number in balls, which the report of a controller repeats",
    "Examined": "the verdict on a file",
    "Found": "the cells of a search, for the file that decides whether they prove it",
    "Margin": "a number of a disk of gains that balls leave stable",
    "Cut": "a disk of gains that balls leave stable, or not",
    "Edge": "its design.certify() and its refusal's infeasibility",
    "Residual": "a share of a vibration that balls bound, and its words say so",
    "Largest": "its design.certify(), and its infeasibility beyond",
    "Deployment": "those that are written beside the program",
    "Stopped": "never proven: the time was over",
    "Unproven": "never proven: there is no design",
    "Verdict": "what proofs and files say alike",
}


def test_whatever_says_proven_is_a_file():
    """A class with a verdict of its own needs `save`, `load` and `verify`."""
    seen = set()
    for module in pkgutil.walk_packages(sos.__path__, "sosbook."):
        if ".book" not in module.name and not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    for name, module in list(sys.modules.items()):
        if not name.startswith("sosbook") or ".book" in name:
            continue
        for cls in vars(module).values():
            if not isinstance(cls, type) or not cls.__module__.startswith("sosbook"):
                continue
            says = hasattr(cls, "proven") or "proven" in getattr(
                cls, "__annotations__", {}
            )
            if says and not cls.__name__.startswith("_"):
                filed = issubclass(cls, ProofFile)
                assert filed or cls.__name__ in SPEAKERS, cls
                seen.add(cls.__name__)
    assert SPEAKERS.keys() <= seen


@pytest.mark.parametrize("name", BEYOND)
def test_the_checker_says_what_it_cannot_do(name):
    with pytest.raises(checker.Beyond):
        checker.check(proof_of(name).text)
    assert proof_of(name).proven and proof_of(name).verify()


def run(*arguments):
    return alone(proofs.CHECKER, *arguments, timeout=60)


def test_the_checker_needs_nothing_but_python(tmp_path):
    """In isolation, without site-packages, and from its exit code."""
    file = tmp_path / "proof.json"
    proof = proof_of("example 1")
    proof.save(file)
    done = run(file)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[1:] == [f"- {c}" for c in proof.claims]
    one = tmp_path / "check_proof.py"
    one.write_text(in_one_file(), "utf-8")
    again = alone(one, file)
    assert again.stdout == done.stdout and again.returncode == 0
    file.write_text(proof.text.replace("1.257", "0.3"), "utf-8")
    done = run(file)
    assert done.returncode == 1 and done.stdout.startswith("refused")
    proof_of("by balls").save(file)
    done = run(file)
    assert done.returncode == 3 and "balls decide alone" in done.stdout
    assert run().returncode == run(tmp_path / "none.json").returncode == 2


AWAY = {  # a file of the checker, and a proof that needs it
    "any_order": "no controller of any order",
    "delays": "delay",
    "fixed_mode": "a mode at rest",
    "growing": "a form that grows",
    "mass": "a singular mass",
    "modes": "a slow mode behind a delay",
    "observer": "observer",
    "own": "an LMI of one's own",
    "sampled": "sampled",
    "small_input": "little force for a fast fall",
    "unreached": "a response out of reach",
}


@pytest.mark.parametrize("module", ["*", *campaign(AWAY)])
def test_a_checker_without_a_kind_says_so_and_decides_the_others(module, tmp_path):
    folder, away = tmp_path / "checker", [*AWAY] if module == "*" else [module]
    gone = shutil.ignore_patterns("__pycache__", *(f"{x}.py" for x in away))
    shutil.copytree(proofs.CHECKER, folder, ignore=gone)
    programs, files = [folder], (tmp_path / "one.json", tmp_path / "beyond.json")
    proof_of("example 1").save(files[0])
    proof_of(AWAY[away[-1]]).save(files[1])
    if module == "*":
        make = "import checker; print(checker.in_one_file(), end='')"
        programs.append(tmp_path / "check_proof.py")
        text = process(sys.executable, "-c", make, cwd=tmp_path).stdout
        programs[-1].write_text(text, "utf-8")
    for program in programs:
        assert alone(program, files[0]).returncode == 0
        done = alone(program, files[1])
        assert done.returncode == 3 and f"{away[-1]}.py, which writes" in done.stdout


def test_the_checker_shares_nothing_with_the_package():
    """It imports the standard library only, and no room of the package."""
    for path in proofs.CHECKER.glob("*.py"):
        lines = path.read_text("utf-8").splitlines()
        imports = {x.split()[1] for x in lines if x.startswith(("import ", "from "))}
        own = {f".{x.stem}" for x in proofs.CHECKER.glob("*.py")} | {"."}
        kernel = "arithmetic", "language", "kernel"  # these know no control
        if path.stem in kernel:
            own = {f".{x}" for x in kernel[: kernel.index(path.stem)]}
        assert imports <= sys.stdlib_module_names | own, path
        later = (x for x in lines[50:] if x.strip().startswith(("import ", "from ")))
        assert not any(later)


# -------------------------------------------------- nothing stored is believed
def test_a_certificate_cannot_be_made_by_hand():
    proof = proof_of("example 1")
    with pytest.raises(TypeError):
        DesignProof(True, ("everything",), {}, (), proof.K, proof.P)
    with pytest.raises(TypeError):
        replace(proof, K=-proof.K)
    with pytest.raises(FrozenInstanceError):
        proof.text = "{}"
    with pytest.raises(AttributeError):
        object.__setattr__(proof, "proven", True)
    assert not DesignProof("").proven and not DesignProof("{}").proven
    assert not DesignProof(proof_of("delay").text).proven  # of another kind
    forged = DesignProof(proof.text.replace('"K"', '"k"'))
    vars(forged)["proven"] = True
    assert not forged.proven and not forged.verify() and not forged
    assert DesignProof("").failed[0].startswith("not a well-formed proof")


def test_a_proof_is_built_from_the_plant_and_not_from_caches():
    design = sos.design_pid(APART, ONE_OF_TWO)
    blocks = set(design.certify().blocks)
    assert "stability 1,2" in blocks
    for pairs in ([], [(0, 0)] * 3):
        object.__setattr__(design.request, "pairs", pairs)
        assert set(design.certify().blocks) == blocks
    wrong = sos.Polytope([driven([1.0, 1.5], -50), driven([1.5, 1.0], -50)])
    others = sos.design_pid(wrong, ONE_OF_TWO).request.vertices
    object.__setattr__(design.request, "vertices", others)
    proof = design.certify()
    assert proof.data["plant"]["vertices"][0]["S"] == [["2", "-1"], ["-1", "2"]]
    assert set(proof.blocks) == blocks and proof.proven


@pytest.mark.parametrize(
    "again",
    [
        lambda x: x,
        copy.copy,
        copy.deepcopy,
        lambda x: pickle.loads(pickle.dumps(x)),
        replace,
    ],
)
def test_arrays_stay_read_only(again):
    design = again(
        sos.design_pid(
            TWO, ONE, requirements=[sos.QuadraticCost(np.eye(3), ONE, bound=500.0)]
        )
    )
    request = design.request
    for x in (
        design.K,
        design.P,
        design.own["J"],
        design.frame.T,
        request.U,
        request.vertices[0].A,
        request.plant.vertices[0].M,
        request.requirements[0].Q,
    ):
        with pytest.raises(ValueError, match="read-only"):
            x *= 0
    proof = again(design.certify())
    assert proof.verify()
    with pytest.raises(ValueError, match="read-only"):
        proof.K[0] = 0


# ------------------------------------------------------------ exact comparison
def test_inertias_are_compared_exactly():
    """1 - 1/3 and 2 - 4/3 are the same float, but not the same number."""
    third = 1 / 3
    assert 1 - third == 2 - 4 * third
    one = np.eye(2)
    plants = sos.Polytope([sos.SecondOrderSystem(k * one, one, one, b * one)
                           for k, b in ((1, 1), (2, 4))])  # fmt: skip
    design = sos.design_pid(plants, K_A=third * one)
    assert "stability 1,2" in design.certify().blocks
    bound = sos.Saturation(10, [1, 0, 0, 0], acceleration=True)
    with pytest.raises(ValueError, match="the same M - B K_A"):
        sos.design_pid(plants, K_A=third * one, saturation=bound)


# -------------------------------------------------------------------- digits
def test_certify_finds_its_digits():
    tight = sos.LMIRegion.disk(1e-3, -30.1234)  # no gain of few digits will do
    design = sos.design_pid(spring(), region=tight)
    assert not design.certify(6).proven
    proof = design.certify()
    assert proof.proven and proof.digits in (8, 10, 12, 17)
    assert str(proof).startswith(f"proven with {proof.digits} digits:")
    assert sos.design_pid(spring()).certify().digits <= 6


def test_a_given_gain_is_proven_as_it_is():
    K = np.array([[-1 / 3, -2 / 7]])
    assert np.array_equal(sos.analyse_pid(spring(), K).certify().K, K)
    assert sos.analyse_pid(spring(), K).certify(3).K.tolist() == [[-0.333, -0.286]]
    loop = sos.analyse_delay(DELAYED, [[-1 / 9, -0.1, -0.2, -0.1]], tau=0.1)
    assert loop.certify().K[0, 0] == -1 / 9


def test_a_gain_of_least_cost_is_rounded():
    """It was computed, not given."""
    assert sos.design_lqr(TWO, np.eye(3), ONE, ONE).certify().digits <= 6


@pytest.mark.parametrize(
    "certify",
    [
        sos.design_pid(spring()).certify,
        sos.regularize(singular()).certify,
        sos.design_sampled_lqr(spring(), np.eye(2), ONE, T=0.1).certify,
    ],
)
@pytest.mark.parametrize("digits", [0, -1, 2.5, "6"])
def test_digits_are_checked(certify, digits):
    with pytest.raises(ValueError, match="digits must be 1 or more"):
        certify(digits=digits)


# ------------------------------------------------------------- text of numbers
@pytest.mark.parametrize("x", [0.1, 1 / 3, -2.5e-300, 1e22, 0.0, 123456.0, 1e16])
def test_decimals_are_read_as_what_was_written(x):
    assert read_number(decimal(x)) == x
    assert texts.number(decimal(x)) == Fraction(repr(x))


@pytest.mark.parametrize(
    "text",
    ["1.0", "-0", "nan", "inf", "1e400", "0x1", " 1", "1_0", "1/3", "", 1.0, None],
)
def test_other_spellings_of_numbers_are_refused(text):
    with pytest.raises(ValueError):
        read_number(text)


@pytest.mark.parametrize("text", ["2/4", "1/0", "1/-2", "1.5", "a", None])
def test_other_spellings_of_fractions_are_refused(text):
    with pytest.raises(ValueError):
        fraction(text)


def test_decimal_expansions():
    for x in ("0.375", "12", "-0.02", "0.1", "1200"):
        assert families.decimal(Fraction(x)) == x


def test_no_proof_file_is_said(tmp_path):
    file = tmp_path / "x.json"
    for text, why in (
        ("", "is no proof file"),
        ("[]", "is no proof file"),
        ('{"format": "sosbook proof", "version": 1}', "version must be 2"),
    ):
        file.write_text(text, "utf-8")
        with pytest.raises(ValueError, match=why):
            proofs.load(file)
    text = json.loads(sos.design_pid(spring()).certify().text)
    file.write_text(json.dumps(text), "utf-8")
    assert proofs.load(file).verify()  # its layout doesn't matter
    with pytest.raises(ValueError, match=r"kind 'design': use"):
        proofs.DelayProof.load(file)
