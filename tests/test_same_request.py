"""The same request in other words, of every function that takes a region."""

import inspect
from functools import cache

import numpy as np
import pytest

import sosbook as sos
from tests.cases import close, falling_plant
from tests.closed import analyse_loop

SIGMA, THETA, RHO = 0.3, 1.2, 40.0
make = sos.LMIRegion


def renamed():
    parts = sos.PoleRegion(SIGMA, THETA, RHO).parts
    names = ("zz top", "stability", "a-1")
    return sos.LMIRegion.__and__(*[p.named(n) for p, n in zip(parts[:2], names)]) & (
        parts[2].named(names[2])
    )


def turned():
    """Each part after a congruence: T (alpha + beta s + beta' s*) T' < 0."""
    rng, region = np.random.default_rng(5), None
    for k, part in enumerate(sos.PoleRegion(SIGMA, THETA, RHO).parts):
        T = rng.standard_normal(part.alpha.shape) + 2 * np.eye(len(part.alpha))
        alpha = T @ part.alpha @ T.T
        one = make((alpha + alpha.T) / 2, T @ part.beta @ T.T, f"turned {k}")
        region = one if region is None else region & one
    return region


WAYS = {
    "parts, in another order": lambda: (
        make.disk(RHO) & make.sector(THETA) & make.half_plane(SIGMA)
    ),
    "other names": renamed,
    "scaled": lambda: (
        make([[6 * SIGMA]], [[3.0]], "line")
        & make(*(0.25 * x for x in _matrices(make.sector(THETA))), "wedge")
        & make(*(7 * x for x in _matrices(make.disk(RHO))), "circle")
    ),
    "turned": turned,
    "degrees": lambda: sos.PoleRegion(
        SIGMA, rho=RHO, theta_deg=float(np.degrees(THETA))
    ),
    "one part twice": lambda: (
        sos.PoleRegion(SIGMA, THETA, RHO)
        & make.half_plane(SIGMA, name="again")
        & make([[2 * SIGMA]], [[1.0]], "and again")
    ),
}


def _matrices(part):
    return part.alpha, part.beta


def one(count=1):
    return falling_plant(3, count)


def designed(region, **more):
    return sos.design_pid(one(), region=region, **more)


def analysed(region):
    return sos.analyse_pid(one(), design().K, region=region)


def loop(region):
    d = design().request.vertices[0]
    return analyse_loop(d.E, d.A + d.Bu @ design().K, region=region)


def regulated(region):
    plant = one()
    return sos.design_lqr(plant, np.eye(2 * plant.n), np.eye(plant.m), region=region)


def with_input(region, share):
    plant = one()
    return designed(
        region, saturation=sos.Saturation(share * least(), np.eye(2 * plant.n)[0])
    )


@cache
def design():
    return designed(sos.PoleRegion(SIGMA, THETA, RHO))


@cache
def least():
    """The least bound of the input, from a unit of the first position."""
    free = sos.Saturation(None, np.eye(2 * one().n)[0])
    found = designed(design().request.region, saturation=free, minimize="u_max")
    return found.request.saturation.u_max


ASKED = {
    "design_pid": designed,
    "design_pid, pairs": lambda r: sos.design_pid(one(2), region=r),
    "design_pid, slack": lambda r: sos.design_pid(one(2), region=r, coupling="slack"),
    "design_pid, too little force": lambda r: with_input(r, 0.5),
    "design_pid, enough force": lambda r: with_input(r, 1.5),
    "design_pid, too fast": lambda r: designed(r & make.half_plane(90.0, name="far")),
    "analyse_pid": analysed,
    "analyse_pid, a loop": loop,
    "design_lqr": regulated,
}


@cache
def in_plain_words(name):
    return ASKED[name](sos.PoleRegion(SIGMA, THETA, RHO))


TURNS = [
    pytest.param(name, way, marks=[pytest.mark.campaign] * ((j + k) % 3 > 0))
    for j, name in enumerate(ASKED)
    for k, way in enumerate(WAYS)
]


@pytest.mark.parametrize("name, way", TURNS)
def test_the_same_answer(name, way):
    here = in_plain_words(name)
    away = ASKED[name](WAYS[way]())
    assert away.status == here.status
    assert away.status == ("infeasible" if "too" in name else "feasible")
    if away.status == "feasible":
        assert away.certify().proven
        # the slack scalar multiplies what a turned region's blocks are made of
        if here.K.size and not ("slack" in name and way in ("scaled", "turned")):
            assert close(away.K, here.K, 1e-3)
    else:
        assert away.infeasibility.proven


@pytest.mark.parametrize("centre", [0.0, -3.0])
def test_a_disk_is_one_however_it_is_written(centre):
    """Its rate chooses the coordinates, and these the gain of a cone."""
    disk, rng = make.disk(2.0, centre), np.random.default_rng(2)
    for _ in range(10):
        T = rng.standard_normal((2, 2))
        alpha = T @ disk.alpha @ T.T
        turned = make((alpha + alpha.T) / 2, T @ disk.beta @ T.T, "turned")
        assert turned.rate() == pytest.approx(disk.rate())
        far = make.half_plane(2.1 - centre)
        assert turned.contradicts(far) and disk.contradicts(far)
    for other in (make.sector(1.0), make.ellipse(-4, 3, 2), make.strip(-3, -1)):
        assert (other.rate() or (2,))[0] == 2  # a rough one at most
        assert not other.contradicts(make.half_plane(50.0))


def test_no_other_function_takes_names():
    """What designs or analyses and takes no region has no names to ask for."""
    taking = set()
    for name in sos.__all__:
        function = getattr(sos, name)
        if name.startswith(("design_", "analyse_", "regularize", "admissible")):
            given = inspect.signature(function).parameters
            if {"region", "requirements"} & given.keys():
                taking.add(name)
    taking.remove("design_observer")  # whose region is of the error alone
    taking.remove("design_sampled")  # whose requirements are of z, or of a step
    assert taking == {"design_pid", "analyse_pid", "design_lqr"}
    assert taking == {name.split(",")[0] for name in ASKED}
