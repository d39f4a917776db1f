"""How a robot stands up again, and from which tilts."""

import numpy as np

from ..plants.checks import positive
from .fleet import Fleet
from .model import V_MAX
from .simulator import listed, simulate

__all__ = ["largest_tilt", "recover"]


def largest_tilt(
    robots, controller, t_end=3.0, high=np.pi / 3, points=8, rounds=3, **options
):
    """The tilt up to which each robot stands up again.

    Parameters
    ----------
    robots : Mip or sequence of Mip
        The pendulums.
    controller : Firmware
        What drives them.
    t_end : float
        How long each run lasts, in s.
    high : float
        No robot is let go beyond this tilt, in rad.
    points : int
        Tilts tried side by side; the first that fails bounds the next
        round, which splits what is left.
    rounds : int
        How often the interval of tilts is split.
    **options
        As for `simulate`.

    Returns
    -------
    (len(robots),) array
        The tilt in rad, to high / points^rounds: the last tilt tried from
        which it stands up, and it does from all smaller ones tried.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> from sosbook.pendulum import Firmware, Mip, SampledLaw
    >>> law = SampledLaw.of_gain(thesis.mip().gains["PD"][5], 0.01)
    >>> tilt = largest_tilt(Mip.printed(), Firmware(law), rounds=2)
    >>> bool(np.all((0.8 < tilt) & (tilt <= Firmware(law).tip)))
    True
    """
    robots = listed(robots)
    every = [robot for robot in robots for _ in range(points)]
    low, width = np.zeros(len(robots)), positive("high", high)
    for _ in range(rounds):
        width = width / points
        tilts = low[:, None] + width * np.arange(1, points + 1)
        run = simulate(every, controller, tilts.ravel(), t_end, **options)
        good = run.settled.reshape(tilts.shape)
        low = low + width * np.cumprod(good, axis=1).sum(axis=1)
    return np.minimum(low, high)


def recover(robots, K, angle, t, limit=V_MAX):
    """Let nonlinear pendulums go at an angle, under V = K x.

    ``robots``: the pendulums; ``K``, (1, 4) or (1, 5): [K_P K_D] or [K_P K_D K_I], with
    x3' = phi; ``angle``: theta at the start, in rad; the rest is zero; ``t``, (k,):
    equally spaced times from 0, in s; each is a Runge-Kutta step; ``limit``: the
    motors' largest voltage, in V. Returns x: the states [theta; phi; theta'; phi'; x3];
    V: the voltages, after the limit.
    """
    fleet = Fleet(robots)
    K = np.asarray(K, float)
    x = np.zeros((K.shape[1], len(robots)))
    x[0], T = angle, t[1] - t[0]

    def volts(x):
        return np.clip((K @ x)[0], -limit, limit)

    def rate(x):
        fall = fleet.acceleration(x, volts(x))
        return np.concatenate([x[2:4], fall, x[1:2]])[: len(x)]

    states = [x]
    for _ in t[1:]:
        k1 = rate(x)
        k2 = rate(x + T / 2 * k1)
        k3 = rate(x + T / 2 * k2)
        k4 = rate(x + T * k3)
        x = x + T / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(x)
    states = np.moveaxis(states, 0, 2)
    return states, np.clip(np.einsum("i,ijk->jk", K[0], states), -limit, limit)
