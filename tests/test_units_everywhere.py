"""No design function knows the units, the order of things or their names.

Units from 1e-9 to 1e9; vertices, coordinates and inputs in another order or twice.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.book.reproduction.gamma_bounds import gamma_lower_bounds
from sosbook.book.reproduction.region_of_attraction import region_of_attraction
from sosbook.delay import analyse_delay, largest
from sosbook.lmi import Unknown
from sosbook.requirements.base import Requirement
from sosbook.requirements.vocabulary import Parameter
from sosbook.sampled import certify_sampled, design_sampled_lqr
from sosbook.studies import maps
from sosbook.synthesis.request import Request
from sosbook.theorems.lqr import trace_bound
from tests.cases import close, falling_plant
from tests.energy_to_peak import EnergyToPeak, energy, output, slack_energy
from tests.random_plants import ODD, ODD_POWERS, Units, as_units

many = settings(max_examples=40, deadline=None)
powers = st.lists(st.integers(-9, 9), min_size=5, max_size=5)
seeds = st.integers(0, 10**6)
weekly = partial(pytest.param, marks=pytest.mark.campaign)


def in_order(plant, rng, a=0):
    """The same plant with its coordinates and inputs in another order."""
    P, Q = (np.eye(k)[rng.permutation(k)] for k in (plant.n, plant.m))
    return Units(1.0, P, P, Q, np.eye(a))


def listed_anew(plant):
    """The vertices in another order, one of them twice."""
    *some, last = plant.vertices
    return sos.Polytope([last, *some, last])


def changes(plant, powers, seed, a=0):
    """Other units, and another order of the coordinates."""
    yield as_units(plant, powers, a)
    yield in_order(plant, np.random.default_rng(seed), a)


def stable(seed, count=1, hold=0.5):
    """A plant that stands, with one or two degrees of freedom."""
    falls = falling_plant(seed, count)
    vertices = [
        sos.SecondOrderSystem(v.M, 4 * v.D, hold * -v.S, v.B, v.F)
        for v in falls.vertices
    ]
    return vertices[0] if count == 1 else sos.Polytope(vertices)


def weight(root, unit):
    """root root' in other units."""
    back = np.linalg.inv(unit).T @ root
    return back @ back.T


# ---- each property takes a seed and the powers of ten of five units
def designs(seed, powers, count=1):
    plant = falling_plant(seed, count)
    rng = np.random.default_rng([seed, 1])
    asked = dict(region=sos.PoleRegion(0.3, 1.3, 30.0))
    a = plant.m if rng.random() < 0.5 else 0
    if a:
        asked["U"] = np.eye(plant.n)[:a]
    x0 = np.append(rng.standard_normal(plant.n), np.zeros(plant.n + a))
    best = sos.design_pid(
        plant, **asked, minimize="u_max", saturation=sos.Saturation(None, x0)
    )
    least = best.request.saturation.u_max
    asked |= dict(saturation=sos.Saturation(1.5 * least, x0), gamma=3 * best.hinf())
    hard = asked | dict(saturation=sos.Saturation(0.5 * least, x0))
    here = sos.design_pid(plant, **asked)
    assert here.status == "feasible" and here.certify(9).proven
    for there in changes(plant, powers, seed, a):
        other = sos.design_pid(there.plant(plant), **there.requirements(asked))
        assert other.status == "feasible" and other.certify(9).proven
        assert close(there.Q @ other.K @ there.state, here.K)
        known = sos.analyse_pid(
            there.plant(plant), there.gain(here.K), **there.requirements(asked)
        )
        assert known.status == "feasible"
        never = sos.design_pid(there.plant(plant), **there.requirements(hard))
        assert never.status == sos.design_pid(plant, **hard).status != "feasible"


def designs_of_polytopes(seed, powers):
    designs(seed, powers, 2)
    plants = falling_plant(seed, 3)
    asked = dict(region=sos.PoleRegion(0.3, 1.3, 30.0), gamma=50.0)
    for more in ({}, {"coupling": ("slack", 0.2)}):
        here = sos.design_pid(plants, **asked, **more)
        again = sos.design_pid(listed_anew(plants), **asked, **more)
        assert again.status == here.status == "feasible"
        assert close(again.K, here.K)


def delayed_designs(seed, powers, method="functional"):
    plant = stable(seed, 2)
    asked = dict(tau=0.2, mu=0.1, delta=0.05, method=method)
    if method == "functional":
        asked["alpha"] = 0.4
    hard = asked | dict(delta=50.0)
    here = sos.design_delay_pid(plant, **asked)
    assert here.status == "feasible" and here.certify().proven
    for there in changes(plant, powers, seed):
        other = sos.design_delay_pid(there.plant(plant), **later(there, asked))
        assert other.status == "feasible" and other.certify().proven
        assert close(there.Q @ other.K @ there.state, here.K, 1e-2)
    never = sos.design_delay_pid(there.plant(plant), **later(there, hard))
    assert never.status == sos.design_delay_pid(plant, **hard).status != "feasible"
    again = sos.design_delay_pid(listed_anew(plant), **asked)
    assert again.status == "feasible" and close(again.K, here.K, 1e-2)


def delayed_designs_by_a_shift(seed, powers):
    delayed_designs(seed, powers, "shift")


def later(there, asked):
    """Delays and rates in other units of time."""
    scale = dict.fromkeys(("tau", "mu", "alpha"), there.w0) | {"delta": 1 / there.w0}
    return {k: v * scale[k] if k in scale else v for k, v in asked.items()}


def delayed_loops(seed, powers):
    plant = one_coordinate(stable(seed))
    there = as_units(plant, powers, 0)
    K = sos.design_lqr(plant, np.eye(2), [[10]]).K
    for method in ("functional", "shift", "legendre", "interval"):
        verdicts = set()
        for delta in (0.02, 20.0):
            asked = dict(tau=0.1, mu=0.05, delta=delta, method=method)
            here = analyse_delay(plant, K, **asked)
            other = analyse_delay(
                there.plant(plant), there.gain(K), **later(there, asked)
            )
            assert here.status == other.status
            verdicts.add(here.status)
        assert len(verdicts) == 2


def one_coordinate(plant):
    """The first coordinate of a plant, with the first input."""
    M, D, S, B, F = (getattr(plant, name)[:1, :1] for name in "MDSBF")
    return sos.SecondOrderSystem(M, D, S, B, F)


def largest_delays(seed, powers):
    plant = one_coordinate(stable(seed))
    there = as_units(plant, powers, 0)
    K = sos.design_lqr(plant, np.eye(2), [[10]]).K
    asked = dict(method="interval", digits=2, refuse=False)
    here = largest("mu", sos.Loop(plant, K), tau=0.3, mu=0.1, **asked)
    loop = sos.Loop(there.plant(plant), there.gain(K))
    other = largest("mu", loop, tau=0.3 * there.w0, **asked)
    assert other.value == pytest.approx(here.value * there.w0)


def observers(seed, powers):
    plant = falling_plant(seed, 2)
    n, N = plant.n, 2 * plant.n
    K = sos.design_lqr(plant, np.eye(N), np.eye(plant.m)).K
    C = np.eye(N)[:n]
    Q_F = np.vstack([np.eye(N), np.zeros((N, N))])
    R_F = 0.1 * np.eye(n)

    def designed(plant, there):
        state, z = there.state, there.T
        slower = np.sqrt(there.w0)  # noise has an intensity
        return sos.design_observer(
            plant,
            there.gain(K),
            np.kron(np.eye(2), state) @ Q_F / slower,
            z @ R_F * slower,
            C=z @ C @ np.linalg.inv(state),
        )

    plain = Units.plain(n, plant.m, 0)
    here = designed(plant, plain)
    assert here.status == "feasible" and here.certify().proven
    for there in changes(plant, powers, seed):
        other = designed(there.plant(plant), there)
        back = np.linalg.solve(there.state, other.L) @ there.T
        back = back * there.w0  # L is a rate
        assert other.status == "feasible" and close(back, here.L, 2e-2)
        assert other.certify().proven
    again = designed(listed_anew(plant), plain)
    assert again.status == "feasible" and close(again.L, here.L, 2e-2)


def regulators(seed, powers, **more):
    plant = falling_plant(seed, 2)
    N, m = 2 * plant.n, plant.m
    root = np.random.default_rng(seed).standard_normal((N, N)) + np.eye(N)

    def regulator(plant, there):
        R = there.Q.T @ there.Q
        return sos.design_lqr(plant, weight(root, there.state), R, noise="F", **more)

    plain = Units.plain(plant.n, m, 0)
    here = regulator(plant, plain)
    assert here.status == "feasible" and here.certify().proven
    for there in changes(plant, powers, seed):
        other = regulator(there.plant(plant), there)
        assert other.status == "feasible" and other.certify().proven
        assert close(there.Q @ other.K @ there.state, here.K, 1e-2)
    again = regulator(listed_anew(plant), plain)
    assert again.status == "feasible" and close(again.K, here.K, 1e-2)


def regulators_with_slack(seed, powers):
    regulators(seed, powers, coupling="slack")


def sampled_loops(seed, powers):
    plant, T, late = falling_plant(seed, 2), 0.02, 0.03
    K = sos.design_lqr(plant, np.eye(2 * plant.n), np.eye(plant.m)).K
    for there in changes(plant, powers, seed):
        for gain, proven in ((K, True), (-K, False)):
            for more in ({}, {"rate": 0.9999}):
                here = certify_sampled(plant, gain, T, late, digits=12, **more)
                other = certify_sampled(
                    there.plant(plant),
                    there.gain(gain),
                    T * there.w0,
                    late * there.w0,
                    digits=12,
                    **more,
                )
                assert here.proven == other.proven == proven
    assert certify_sampled(listed_anew(plant), K, T, late).proven


def sampled_designs(seed, powers):
    plant, T, late = falling_plant(seed), 0.02, 0.03
    N, m = 2 * plant.n, plant.m
    root = np.random.default_rng(seed).standard_normal((N, N)) + np.eye(N)
    here = design_sampled_lqr(plant, root @ root.T, np.eye(m), T, late)
    for there in changes(plant, powers, seed):
        other = design_sampled_lqr(
            there.plant(plant),
            weight(root, there.state),
            there.Q.T @ there.Q,
            T * there.w0,
            late * there.w0,
        )
        K = there.Q @ other.K
        assert close(K[:, :N] @ there.state, here.K[:, :N], 1e-6)
        past = np.kron(np.eye(K.shape[1] // m - N // m), np.linalg.inv(there.Q))
        assert close(K[:, N:] @ past, here.K[:, N:], 1e-6)
        assert other.radius == pytest.approx(here.radius, rel=1e-6)
        assert other.certify().proven == here.certify().proven is True


def regular_masses(seed, powers):
    plant = falling_plant(seed, 2)
    n = plant.n
    light = sos.Polytope(
        [
            sos.SecondOrderSystem(
                v.M * np.diag([1.0, *[0.0] * (n - 1)]), v.D, v.S, np.eye(n)
            )
            for v in plant.vertices
        ]
    )
    for choose in ("centre", "least norm"):
        here = sos.regularize(light, beta=0.1, choose=choose)
        assert here.status == "feasible" and here.certify().proven
        there = as_units(light, powers, 0)
        mass = there.R[0, 0] / there.T[0, 0] * there.w0**2
        other = sos.regularize(
            there.plant(light), beta=0.1 * np.sqrt(mass), choose=choose
        )
        back = there.Q @ other.K_A @ there.T / there.w0**2
        assert other.status == "feasible" and other.certify().proven
        size = max(1.0, np.abs(here.K_A).max())
        assert np.abs(back - here.K_A).max() <= 1e-4 * size
        again = sos.regularize(listed_anew(light), beta=0.1, choose=choose)
        assert np.abs(again.K_A - here.K_A).max() <= 1e-4 * size


def integrators(seed, powers):
    plant = falling_plant(seed, 2)
    here = sos.admissible_U(plant)
    for other in (as_units(plant, powers, 0).plant(plant), listed_anew(plant)):
        found = sos.admissible_U(other)
        assert [(c.U != 0).tolist() for c in found] == [
            (c.U != 0).tolist() for c in here
        ]
        assert [c.admissible for c in found] == [c.admissible for c in here]
        assert [c.certified for c in found] == [c.certified for c in here]


def regions_of_attraction(seed, powers):
    plant = falling_plant(seed, 2)
    N = 2 * plant.n
    K = sos.design_lqr(plant, np.eye(N), np.eye(plant.m)).K
    row, start = np.eye(N)[0], np.ones(N)
    here = region_of_attraction(plant, K, row=row, bound=1.5, start=start)
    assert here.status == "feasible" and here.proven
    for there in changes(plant, powers, seed):
        state = there.state
        other = region_of_attraction(
            there.plant(plant),
            there.gain(K),
            row=row @ np.linalg.inv(state),
            bound=1.5,
            start=state @ start,
        )
        assert other.status == "feasible" and other.proven
        assert other.reach == pytest.approx(here.reach, rel=1e-3)
    again = region_of_attraction(listed_anew(plant), K, row=row, bound=1.5, start=start)
    assert again.reach == pytest.approx(here.reach, rel=1e-3)


def edges(seed, powers):
    plant = falling_plant(seed)
    there = as_units(plant, powers, 0)
    asked = dict(region=sos.PoleRegion(0.37, 1.3, 31.0), gamma=10.0)
    other = there.requirements(asked)
    for name, unit in (("rho", 1 / there.w0), ("sigma", 1 / there.w0)):
        here = maps.edge(name, plant, digits=1, **asked)
        away = maps.edge(name, there.plant(plant), digits=1, **other)
        assert here.proven == away.proven
        sides = np.array([(e.feasible, e.infeasible) for e in (here, away)])
        sides[0] *= unit
        if all(float(p).is_integer() for p in powers):  # the same round numbers
            assert sides[1] == pytest.approx(sides[0])
        near, far = np.sort(sides).T  # both hold the edge
        assert near.max() <= far.min()


def lower_bounds(seed, powers):
    plant = falling_plant(seed, 2)
    N = 2 * plant.n
    K = sos.design_lqr(plant, np.eye(N), np.eye(plant.m)).K
    x0 = np.random.default_rng(seed).standard_normal(N)
    asked = dict(saturation=sos.Saturation(5.0, x0), gamma=1.0)
    here = gamma_lower_bounds(plant, K, saturation=asked["saturation"])
    for there in changes(plant, powers, seed):
        other = there.requirements(asked)
        away = gamma_lower_bounds(
            there.plant(plant), there.gain(K), saturation=other["saturation"]
        )
        assert away.norm == pytest.approx(here.norm * other["gamma"], rel=1e-6)
        assert away.gamma(1e9) / other["gamma"] == pytest.approx(
            here.gamma(1e9), rel=1e-6
        )


@dataclass(frozen=True, eq=False)
class ImpulseEnergy(Requirement):
    """The square of the H2 norm: a requirement without a hint of its units."""

    h2: float | None = None

    kind = name = promise = "impulses"
    parameter = Parameter("h2", "H2 bound h2", "H2 norm", "h2", power=2)
    implies_stability = needs_disturbance = affine_in_quotient = True

    def unknowns(self, request):
        return (Unknown("impulses", len(request.vertices[0].C), symmetric=True),)

    def once(self, loop):
        yield "trace", (), trace_bound(loop.own["impulses"], loop.level(self))

    def pair(self, loop, c):
        yield "noise", energy(c)
        yield "output", output(c.EPC, c.EPE, loop.own["impulses"])

    def slack(self, loop, c, i):
        yield "noise", slack_energy(c, loop.epsilon)
        yield "output", output(c.EVC, c.EPE, loop.own["impulses"])

    def claim(self):
        return f"its H2 norm is below {self.h2!r}"

    def truth(self, loops, K, K_A=None):
        return np.nan


def requirements_of_others(seed, powers, slack=None):
    """The least bound, and a refusal below it; it is a length, for w keeps energy."""
    plant = falling_plant(seed, 2)
    x0 = np.random.default_rng(seed).standard_normal(2 * plant.n)
    best = sos.design_pid(
        plant, minimize="u_max", saturation=sos.Saturation(None, x0)
    ).request.saturation
    limit = dict(saturation=sos.Saturation(3 * best.u_max, x0))
    plain = Units.plain(plant.n, plant.m, 0)

    def design(there, requirement, **more):
        if slack is not None:
            more |= dict(coupling=("slack", slack * there.w0))
        return sos.design_pid(
            there.plant(plant),
            **there.requirements(limit),
            requirements=[requirement],
            **more,
        )

    for kind, key in ((EnergyToPeak, "peak"), (ImpulseEnergy, "h2")):
        here = design(plain, kind(), minimize=key)
        assert here.status == "feasible" and not here.reason
        least = here.request.owner(key).bound
        for there in changes(plant, powers, seed):
            unit = np.linalg.norm(there.T, 2)
            other = design(there, kind(), minimize=key)
            assert other.status == "feasible" and not other.reason
            bound = other.request.owner(key).bound / unit
            assert bound == pytest.approx(least, rel=1.1e-2)
            assert other.certify().proven
            for factor, status in ((1.1, "feasible"), (0.9, "infeasible")):
                found = design(there, kind(factor * least * unit))
                assert found.status == status


def requirements_of_others_with_slack(seed, powers):
    requirements_of_others(seed, powers, 0.2)


PROPERTIES = (
    designs_of_polytopes,
    delayed_designs,
    delayed_designs_by_a_shift,
    delayed_loops,
    largest_delays,
    observers,
    regulators,
    regulators_with_slack,
    sampled_loops,
    sampled_designs,
    regular_masses,
    integrators,
    regions_of_attraction,
    edges,
    lower_bounds,
    requirements_of_others,
    requirements_of_others_with_slack,
)
LONG = (  # not in the gate
    regulators_with_slack,
    requirements_of_others,
    designs_of_polytopes,
    delayed_designs_by_a_shift,  # delayed_loops has the shift, delayed_designs gains
)


@pytest.mark.slow
@pytest.mark.parametrize("law", [law for law in PROPERTIES if law not in LONG])
def test_one_example(law):
    law(11, ODD_POWERS)


@pytest.mark.campaign
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("law", PROPERTIES)
@many
@example(11, ODD_POWERS)
@given(seeds, powers)
def test_many_examples(law, seed, powers):
    law(seed, powers)


@pytest.mark.parametrize(
    ("law", "seed", "powers"),
    [
        (regulators, 4, [-6, 3, 5, -5, -4]),  # a weight that took the units' part
        (regulators, 784, [8, 7, 8, 9, 6]),  # an equation that lost its digits
        (regulators, 784, [0] * 5),  # many gains of least cost
        (observers, 39, [0, -5, 0, 0, 0]),
        (observers, 7, [0] * 5),  # many observers of least cost
        (observers, 22, [0, -8, -5, 7, 3]),  # a rate and a row without a unit
        (sampled_designs, 0, [0, 5, 0, 9, 0]),  # a discrete equation, too
        (sampled_designs, 0, [0, 5, 0, -6, 0]),
    ],
)
def test_what_units_once_turned(law, seed, powers):
    law(seed, powers)


REGIONS = {  # of rates a hundred times and a tenth of w
    "strip": lambda w: sos.LMIRegion.strip(-100 * w, -0.1 * w),
    "horizontal strip": lambda w: sos.LMIRegion.horizontal_strip(10 * w),
    "ellipse": lambda w: sos.LMIRegion.ellipse(-3 * w, 2 * w, w),
    "half-plane to the right": lambda w: sos.LMIRegion.half_plane(-w),
    "parabola": lambda w: sos.LMIRegion(
        [[0, 0], [0, -w]], [[0.5, 0.5], [-0.5, 0]], "parabola"
    ),
}


@pytest.mark.parametrize("w", [1e-6, 1e-3, 1e3, 1e6, *ODD])
@pytest.mark.parametrize("name", REGIONS)
def test_masses_that_are_free_have_their_rate_from_the_region(name, w):
    """Neither spring nor damper has one; rad/s are no better than rad/h."""

    def request(w):
        mass = sos.SecondOrderSystem(2 / w**2, 0, 0, 1, 1)
        return Request(mass, region=REGIONS[name](w))

    assert request(w).typical_rate == pytest.approx(w * request(1.0).typical_rate)
    assert request(w).typical_rate != 1.0


@pytest.mark.parametrize("w", [1e-3, 1e3, *ODD, *map(weekly, (1e-2, 1.0, 1e2))])
def test_a_free_mass_is_judged_alike_in_any_unit_of_time(w):
    mass = sos.SecondOrderSystem(0.8 / w**2, 0, 0, [[0.4, 0.5]], [[-0.91, 1.32]])
    asked = dict(gamma=5.14, region=sos.LMIRegion.horizontal_strip(2.6 * w))
    limit = sos.Saturation(1.6, [0.03, 0.07 * w, -0.1 / w])
    design = sos.design_pid(mass, [[1]], **asked, saturation=limit)
    assert design.status == "feasible" and design.certify().proven
