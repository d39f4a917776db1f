"""A search in one number finds what a closed form says, and asks seldom."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from sosbook.bisection import highest, lowest

DIPS = {  # a function, its ends and where it is least between them
    "smooth": (lambda x: np.cosh(x - 0.3) + x / 7, (-2, 9), 0.3 - np.arcsinh(1 / 7)),
    "a wave": (np.cos, (0.3, 5), np.pi),
    "a corner": (lambda x: abs(x - 9.81), (3, 900), 9.81),
    "flat": (lambda x: (x - 2) ** 6, (0, 3), 2),
    "an end": (lambda x: 5 - x, (-1e3, 1e-3), 1e-3),
    "the other end": (np.exp, (0, 40), 0),
}


@pytest.mark.parametrize("function, ends, true", DIPS.values(), ids=DIPS)
def test_the_least_value_is_that_of_calculus(function, ends, true):
    asked = []
    x, value = lowest(lambda x: asked.append(x) or function(x), *ends, 1e-9)
    assert abs(function(true) - value) <= 1e-7 * max(1, abs(value))
    assert value == function(x) == min(map(function, asked))
    assert ends[0] <= min(asked) and max(asked) <= ends[1] and len(asked) <= 90
    known = minimize_scalar(function, bounds=ends, options={"xatol": 1e-9})
    assert x == pytest.approx(known.x, rel=1e-12)


@pytest.mark.parametrize("peak", [-3.0, 0.0, 0.3, 9.81, 40.0, np.inf])
@pytest.mark.parametrize("count", [1, 2, 5, 29, 57, 300])
def test_the_largest_of_a_concave_function_is_that_of_all_points(count, peak):
    def function(x):
        asked.extend(x)
        return x if peak == np.inf else -abs(x - peak) * (1 + abs(x - peak))

    for points in (np.linspace(0.1, 31, count), 1 / np.geomspace(0.03, 9, count)):
        asked = []
        values, (x, value) = function(points), highest(function, points)
        assert value == values.max() and x == points[values.argmax()]
        assert len(asked) - count <= count / 16 + 20
        assert len({*asked[count:]}) == len(asked) - count
