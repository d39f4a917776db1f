"""How long after its time limit a request ends: python -m benchmarks.limits.

``--sizes 100 300`` chooses the numbers of masses, ``--seconds 1 5`` the limits. Each
line has the request, its size, the limit, the seconds that passed, and the answer.
"""

import os

from sosbook.runtime.progress import WITHOUT_BARS
from sosbook.runtime.threads import ONE_THREAD

os.environ.update(ONE_THREAD | WITHOUT_BARS)  # before numpy is imported

import argparse
from time import monotonic

import numpy as np

import sosbook as sos

__all__ = ["REQUESTS", "main", "plant"]


def plant(n, dense=False):
    """A chain of n masses, or the same in coordinates in which nothing is zero."""
    turn = np.eye(n)
    if dense:
        turn = np.linalg.qr(np.random.default_rng(0).standard_normal((n, n)))[0]
    S = turn @ (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)) @ turn.T
    M = turn @ np.diag(np.linspace(1, 2, n)) @ turn.T
    M, S = (M + M.T) / 2, (S + S.T) / 2
    force = np.eye(n)[:, :: max(1, n // 3)]
    return sos.SecondOrderSystem(M, 0.1 * S, S, force, np.eye(n)[:, :1])


REQUESTS = {
    "poles": lambda p, s: sos.design_pid(p, region=sos.PoleRegion(1e-4), time_limit=s),
    "norm": lambda p, s: sos.design_pid(p, gamma=1.0, time_limit=s),
    "least norm": lambda p, s: sos.design_pid(p, minimize="gamma", time_limit=s),
    "given gain": lambda p, s: sos.analyse_pid(
        p, np.zeros((p.m, 2 * p.n)), time_limit=s
    ),
    "least cost": lambda p, s: sos.design_lqr(
        p, np.eye(2 * p.n), np.eye(p.m), time_limit=s
    ),
    "observer": lambda p, s: sos.design_observer(
        p,
        np.zeros((p.m, 2 * p.n)),
        np.eye(4 * p.n)[:, :3],
        np.eye(2),
        C=np.eye(2 * p.n)[:2],
        time_limit=s,
    ),
    "delay": lambda p, s: sos.design_delay_pid(p, tau=0.1, delta=0.01, time_limit=s),
}


def main(words=None):
    """Print how much longer than its limit each request takes."""
    parser = argparse.ArgumentParser(
        "python -m benchmarks.limits",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--sizes", nargs="+", type=int, default=[100, 300])
    parser.add_argument("--seconds", nargs="+", type=float, default=[1.0, 5.0])
    asked = parser.parse_args(words)
    REQUESTS["poles"](plant(2), 9.0)  # what is imported at first isn't the request's
    for n in asked.sizes:
        for dense in (False, True):
            system = plant(n, dense)
            for name, ask in REQUESTS.items():
                for limit in asked.seconds:
                    begun = monotonic()
                    answer = ask(system, limit)
                    passed = monotonic() - begun
                    kind = "dense" if dense else "chain"
                    print(
                        f"{name:<11} {n:>5} {kind} {limit:>6g} s {passed:>7.2f} s  "
                        f"{answer.status}",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
