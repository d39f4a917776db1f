"""Local minima of functions that aren't smooth: BFGS, then sampled gradients."""

import numpy as np

from ...runtime.time_limit import check_time

DECREASE, CURVATURE = 1e-4, 0.9  # of the weak Wolfe conditions, as Lewis and Overton
MOST_TRIALS = 30  # of a line search
FLAT = 1e-9  # relative decrease of a step that ends the search
SHORT = 1e-10  # of the largest gradient: the hull of gradients holds zero
WINDOW = 10  # steps, in which a descent has to win what is worth it
SHORTER = 8  # times a step along a hull is halved: from the samples' distance on


def descend(f, x, steps, enough=-np.inf, worth=0.0, H=None):
    """(x, f(x), H) after at most so many ``steps`` of BFGS from ``x``, (k,), with a
    weak Wolfe line search; ``f`` gives value, infinite where there is none, and
    gradient, which nobody asks where the value is above a second argument; and a
    value of ``enough`` ends it, as do steps that win less than is ``worth`` it.
    With ``H``, the inverse Hessian, it goes on later; None where it has ended.
    Source: A. S. Lewis and M. L. Overton, Nonsmooth optimization via quasi-Newton
    methods, Math. Program. 141, 2013: the weak conditions let a step end behind a
    kink, and the curvature that it finds there turns the next one along it.
    """
    value, slope = f(x)
    if not np.isfinite(value):
        return x, value, None
    first, past = H is None, [value]
    H = np.eye(len(x)) if first else H
    for _ in range(steps):
        check_time()
        if value <= enough:
            return x, value, None
        if len(past) > WINDOW and past[-WINDOW - 1] - value < worth:
            return x, value, None
        d = -H @ slope
        if slope @ d >= 0:
            H, d = np.eye(len(x)), -slope
        if first:
            d = d / max(1.0, np.linalg.norm(slope))
        if not slope @ d < 0:
            return x, value, None
        found = _line(f, x, value, slope, d)
        if found is None:
            if first:
                return x, value, None
            H, first = np.eye(len(x)), True  # what it knew of the curves is of no use
            continue
        s, (new, new_value, new_slope) = found[0] - x, found
        y = new_slope - slope
        if s @ y > 1e-14 * np.linalg.norm(s) * np.linalg.norm(y):
            if first:
                H, first = (s @ y) / (y @ y) * np.eye(len(x)), False
            V = np.eye(len(x)) - np.outer(s, y) / (s @ y)
            H = V @ H @ V.T + np.outer(s, s) / (s @ y)
        small = value - new_value < FLAT * (1 + abs(value))
        x, value, slope = new, new_value, new_slope
        past.append(value)
        if small and np.linalg.norm(s) < FLAT * (1 + np.linalg.norm(x)):
            return x, value, None
    return x, value, H


def _line(f, x, value, slope, d):
    """A point along d that meets the weak Wolfe conditions, with value and gradient."""
    low, high, t, kept, down = 0.0, np.inf, 1.0, None, slope @ d
    for _ in range(MOST_TRIALS):
        new = x + t * d
        most = value + DECREASE * t * down
        v, g = f(new, most)
        if not np.isfinite(v) or v > most:
            high = t
        elif g @ d < CURVATURE * down:
            low, kept = t, (new, v, g)
        else:
            return new, v, g
        t = 2 * low if high == np.inf else (low + high) / 2
        if high < np.inf and high - low < 1e-12 * max(1.0, high):
            break
    return kept


def refine(f, x, value, rng, rounds, worth=0.0):
    """(x, f(x)) after at most so many ``rounds`` of steps along the shortest vector in
    the hull of gradients at random points of ``rng`` nearby; ``f`` and ``x`` are as in
    `descend`, ``value`` that at x, and a step has to win what is ``worth`` it. Source:
    J. V. Burke, A. S. Lewis and M. L. Overton, A robust gradient sampling algorithm,
    SIAM J. Optim. 15, 2005.
    """
    from scipy.optimize import nnls

    radius, k = 1e-2 * (1 + np.linalg.norm(x)), len(x)
    for _ in range(rounds):
        check_time()
        points = [x, *(x + radius * rng.uniform(-1, 1, (min(2 * k, 24), k)))]
        found = [f(p) for p in points]
        G = np.array([g for v, g in found if np.isfinite(v)]).T
        scale = np.abs(G).max(initial=0) or 1.0
        sums = 1e3 * np.ones((1, G.shape[1]))  # weighs "of sum one" against the rest
        weights, _ = nnls(np.vstack([G / scale, sums]), np.r_[np.zeros(k), 1e3])
        d, moved = -G @ weights, False
        size = np.linalg.norm(d)
        if size > SHORT * scale:
            t = 4 * radius / size
            for _ in range(SHORTER):
                most = value - max(FLAT * abs(value), worth)
                v, _ = f(x + t * d, most)
                if np.isfinite(v) and v < most:
                    x, value, moved = x + t * d, v, True
                    break
                t /= 2
        if not moved:
            radius /= 5
            if radius < FLAT:
                break
    return x, value
