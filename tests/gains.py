"""Gains of the pendulum from bare numbers."""

import numpy as np

from sosbook.pendulum import PD_SIGNALS, PID_SIGNALS, Gain


def named(K):
    """[K_P K_D] or [K_P K_D K_I] as a `Gain` of the pendulum's signals."""
    K = np.atleast_2d(K)
    return Gain(K, PD_SIGNALS if K.shape[1] == 4 else PID_SIGNALS)
