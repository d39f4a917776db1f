"""Round numbers along an axis."""

import numpy as np


def round_ticks(low, high, most=5):
    """Round numbers from ``low`` to ``high``, about ``most`` of them.

    >>> round_ticks(-1.3, 0.3).round(1) + 0.0
    array([-1. , -0.5,  0. ])
    """
    step = 10.0 ** np.floor(np.log10((high - low) / 3))
    for factor in (1, 2, 5, 10):
        if (high - low) / (factor * step) <= most + 0.5:
            break
    step *= factor
    return step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
