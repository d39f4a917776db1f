"""What a yes, a known gain, a no and a proof take: CPU seconds of a call, in turns."""

import numpy as np

import sosbook as sos
from sosbook.book import thesis
from sosbook.studies import maps

from .clock import cpu
from .records import record, summary


def answers(count=15):
    """Records of all questions, each asked ``count`` times.

    Their ratios hold on other machines.
    """
    for k in (1, 2, 3):
        yield from timed(f"example {k}", *example(k), count)
    for ranges in (3, 6):
        plant, rows = family(ranges)
        few = count if ranges == 3 else -(-count // 5)
        yield from timed(f"{2**ranges} plants", plant, rows, few)
    yield from timed("two carts", *carts(), count)
    yield from timed("late input", *late(), count)
    yield from timed("at the ticks", *at_ticks(), count)


def timed(case, plant, rows, count):
    """A record for each of the ``rows``: name to call, and what its answer must be."""
    times, good = {name: [] for name in rows}, {}
    for k in range(-1, count):  # one to warm up
        for name, (call, right) in rows.items():
            begin = cpu()
            found = call()
            times[name] += [cpu() - begin] * (k >= 0)
            good[name] = bool(right(found))
    for name, some in times.items():
        yield record(
            family="answers",
            case=f"{case}, answers",
            n=plant.vertices[0].n,
            vertices=len(plant.vertices),
            competitor=f"sosbook, {name}",
            clock="CPU seconds of one call",
            status="right" if good[name] else "wrong",
            **(summary(some) if good[name] else {}),
        )


def yes(design):
    return design.status == "feasible"


def no(design):
    return design.infeasibility is not None and design.infeasibility.proven


def example(k):
    """A tenth of the printed gamma is refused; the border of the rate has both sides,
    with their proofs.
    """
    given = getattr(thesis, f"example_{k}")()
    plant, asked = given.plant, given.requirements
    impossible = asked | dict(gamma=sos.HInfinity(given.gamma / 10, mu=1.0))
    design = sos.design_pid(plant, **asked)

    def refuse():
        return sos.design_pid(plant, **impossible)

    rows = {
        "a design": (lambda: sos.design_pid(plant, **asked).K, np.size),
        "a known gain": (lambda: sos.analyse_pid(plant, design.K, **asked).K, np.size),
        "refusal": (refuse, no),
        "refusal with advice": (lambda: refuse().advice, bool),
        "exact proof of a design": (design.certify, lambda c: c.proven),
    }
    if k == 1:
        border = lambda: maps.edge("sigma", plant, **asked)  # noqa: E731
        rows["border with both sides"] = (border, lambda edge: edge.proven)
    return plant, rows


def family(ranges):
    """Two masses of which some numbers have a range of 10 % each, to both sides. Of the
    two refusals the first needs the whole family, and a P for each plant is looked
    for; the other asks for gammas that no plant has.
    """
    names = "abcdef"[:ranges]

    def build(a=0, b=0, c=0, d=0, e=0, f=0):
        D, S = [[0.3 + c, -0.1], [-0.1, 0.4 + d]], [[2 + e, -1], [-1, 2 + f]]
        return sos.SecondOrderSystem(
            np.diag([1 + a, 2 + b]), D, S, [[1], [0]], [[0], [1]]
        )

    box = {name: (-0.1, 0.1) for name in names}
    plant = sos.Uncertain(lambda **some: build(**some), **box)
    asked = dict(region=sos.PoleRegion(sigma=0.2, rho=30))
    narrow = sos.PoleRegion(sigma=3, rho=3.2)
    known = sos.design_pid(plant, **asked).K
    return plant, {
        "a design": (lambda: sos.design_pid(plant, **asked), yes),
        "a known gain": (lambda: sos.analyse_pid(plant, known, **asked), yes),
        "refusal": (lambda: sos.design_pid(plant, **asked, gamma=0.01), no),
        "refusal, near": (lambda: sos.design_pid(plant, region=narrow), no),
    }


def carts():
    """Two carts between springs and their motor; what its gain can't move, and masses
    of two signs, as of a wrong sign in a file.
    """

    def of(*masses, motor=1.0):
        S = np.array([[9.81, 0], [-2, 4]])
        several = [
            sos.SecondOrderSystem(
                np.diag([1, m]), np.diag([0.02, 0.1]), S, [[motor], [1]]
            )
            for m in masses
        ]
        return sos.Polytope(several)

    asked = dict(region=sos.PoleRegion(sigma=0.1))
    return of(0.3, 0.4), {
        "a design": (lambda: sos.design_pid(of(0.3, 0.4), **asked), yes),
        "refusal by a mode": (
            lambda: sos.design_pid(of(0.3, 0.4, motor=0.0), **asked),
            no,
        ),
        "refusal by a mass": (lambda: sos.design_pid(of(0.3, -0.4), **asked), no),
    }


def late():
    """A pendulum that hangs upwards, whose input is late."""
    plant = sos.SecondOrderSystem([[1]], [[0.1]], [[-1]], [[1]])

    def design(tau):
        return sos.design_delay_pid(plant, tau=tau, alpha=0.4)

    return plant, {
        "a design": (lambda: design(0.2), yes),
        "refusal": (lambda: design(1.5), no),
        "exact proof of a design": (design(0.2).certify, lambda c: c.proven),
    }


def at_ticks():
    """Eight plants, a gain and a period."""
    plant, _ = family(3)
    K = sos.design_pid(plant, region=sos.PoleRegion(sigma=0.2, rho=30)).K
    return plant, {
        "proof": (lambda: sos.certify_sampled(plant, K, 0.02), lambda c: c.proven)
    }
