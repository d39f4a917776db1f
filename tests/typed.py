"""What a type checker knows of a user's program; read by mypy, never run."""

from typing import Any, assert_type

import numpy as np

import sosbook as sos
from sosbook.exact.proof import Unproven
from sosbook.exact.refusal import Refusal
from sosbook.synthesis.proofs import DesignProof

# Lists, numbers and arrays are taken for matrices.
cart = sos.SecondOrderSystem(2, 0.1, 3, 1)
plant = sos.SecondOrderSystem(
    M=[[2, 0], [0, 1]], D=np.eye(2), S=[[6, -2], [-2, 4]], B=np.eye(2), F=np.eye(2)
)
assert_type(plant.n, int)
assert_type(plant.poles(), np.ndarray)
plants = sos.Polytope([plant, plant])
assert_type(plants.at([0.5, 0.5]), sos.SecondOrderSystem)
loop = sos.DescriptorSystem(np.eye(2), [[0, 1], [-2, -3]])
sos.SecondOrderSystem(M="heavy", D=1, S=1)  # type: ignore[call-arg]

# Requirements
region = sos.PoleRegion(sigma=0.5, theta_deg=45, rho=8)
assert_type(region.contains([-1, -2 + 1j]), bool)
strip = sos.LMIRegion.strip(-5, -1)
assert_type(strip, sos.LMIRegion)
bound = sos.Saturation(40, [0.1, 0.1, 0, 0, 0, 0])
cost = sos.QuadraticCost(np.eye(6), np.eye(2), noise="states")
sos.QuadraticCost(np.eye(6), np.eye(2), noise="input")  # type: ignore[arg-type]

# A design
design = sos.design_pid(
    plant, U=np.eye(2), region=region & strip, gamma=0.5, saturation=bound
)
assert_type(design, sos.Design)
assert_type(design.K, np.ndarray | None)
assert_type(design.K_P, np.ndarray)
assert_type(design.poles(), np.ndarray)
assert_type(design.hinf(samples=10), float)
assert_type(design.certify(time_limit=9.0), DesignProof | Unproven)
proven_gain: np.ndarray = design.certify().K
assert_type(design.certify().proven, bool)
assert_type(design.infeasibility, Refusal | None)
assert_type(design.advice, str)
response = design.simulate(np.linspace(0, 9, 91), r=[1, 0], w=sos.Sine(1, 2))
assert_type(response, sos.Response | list[sos.Response])
sos.design_pid(plants, coupling="slack", minimize="gamma", requirements=[cost])
sos.design_pid(
    plant,
    search=sos.Search(start=design),
    requirements=[strip],
    minimize={"gamma": 1.0},
)
sos.design_pid(plant, coupling="triples")  # type: ignore[arg-type]
sos.design_pid(plant, gama=0.5)  # type: ignore[call-arg]

# The others
assert_type(sos.analyse_pid(plant, [[-1, 0, -1, 0], [0, -1, 0, -1]]), sos.Design)
assert_type(sos.analyse_pid(sos.DescriptorSystem(1, [[-1]]), gamma=2), sos.Design)
assert_type(sos.design_lqr(plants, np.eye(4), np.eye(2)), sos.Design)
light = sos.regularize(plant, beta=0.1, choose="least norm")
assert_type(light, sos.Regularization)
assert_type(sos.design_pid(light), sos.Design)
assert_type(sos.admissible_U(plants), tuple[sos.IntegratorChoice, ...])
observer = sos.design_observer(cart, [[-1, -1]], np.eye(4), [[1]])
assert_type(observer, sos.ObserverDesign)
late = sos.design_delay_pid(plant, U=np.eye(2), tau=0.04, mu=0.02, delta=0.2)
assert_type(late, sos.DelayDesign)
assert_type(late.slowest_decay(), tuple[float, float])
clocked = sos.design_sampled_lqr(plant, np.eye(4), np.eye(2), T=0.02)
assert_type(clocked.radius, float)
assert_type(clocked.certify().proven, bool)


def spring(z: np.ndarray, dz: np.ndarray) -> np.ndarray:
    return z**3 + 0 * dz


run: Any = sos.simulate_nonlinear(cart, spring, [[-1, -1]], [0, 1, 2])
