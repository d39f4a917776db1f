"""From which tilts a robot stands up again."""

import numpy as np

from ..plants.checks import positive
from .simulator import listed, simulate

__all__ = ["largest_tilt", "recovered"]


def recovered(robots, controller, tilts, t_end=3.0, **options):
    """Which robots stand up again from which tilts.

    Parameters
    ----------
    robots : Mip or sequence of Mip
        The pendulums.
    controller : Firmware
        What drives them.
    tilts : (m,) array_like
        The tilts at the start, in rad.
    t_end : float
        How long each run lasts, in s.
    **options
        As for `simulate`.

    Returns
    -------
    (len(robots), m) array of bool
        `Run.settled`.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> from sosbook.pendulum import Firmware, Mip, SampledLaw
    >>> law = SampledLaw.of_gain(thesis.mip().gains["PD"][5], 0.01)
    >>> recovered(Mip.printed(), Firmware(law), [0.1, 1.2])
    array([[ True, False]])
    """
    robots, tilts = listed(robots), np.ravel(tilts)
    every = [robot for robot in robots for _ in tilts]
    run = simulate(every, controller, np.tile(tilts, len(robots)), t_end, **options)
    return run.settled.reshape(len(robots), len(tilts))


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
