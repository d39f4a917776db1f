"""Limit cycles of friction and backlash, by describing functions.

They are predictions and prove nothing. A describing function is the gain that a
nonlinearity gives a sine's first harmonic. With a force f = -N(a) q and the loop's
response G(jw) from f to q the first harmonics balance where 1 + N G = 0. The controller
samples the harmonic and holds what it answers.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..plants.gain import signals
from ..sampled.system import SampledSystem
from .simulation import Backlash, coordinates

GRID = 4000  # frequencies, evenly on a logarithmic scale
SLOWEST = 1e-4  # of Nyquist's frequency


@dataclass(frozen=True)
class Cycle:
    """A cycle that the first harmonics allow at a corner of the plant.

    Parameters
    ----------
    corner : int
        The vertex of the plant.
    frequency : float
        In Hz.
    amplitude : float
        Of the rubbing speed or of the twist over a gap.
    cause : str
        In words.
    """

    corner: int
    frequency: float
    amplitude: float
    cause: str

    def __str__(self):
        return (
            f"corner {self.corner + 1}: {self.cause}: a cycle at {self.frequency:.3g} "
            f"Hz of amplitude {self.amplitude:.3g} is predicted"
        )


def predicted_cycles(controller: Any, friction: Any = None, backlash: Any = None):
    """The limit cycles that friction and a gap make, predicted: none is a proof.

    Parameters
    ----------
    controller : Controller
        At all corners of its plant.
    friction : (n,) array_like, optional
        Coulomb's force on each coordinate.
    backlash : Backlash, optional
        Between two coordinates.

    Returns
    -------
    list of Cycle
        Of first harmonics; empty where none balance.

    Raises
    ------
    ValueError
        If ``backlash`` is no `Backlash`, or they don't fit the coordinates.
    """
    c = controller
    if backlash is not None and not isinstance(backlash, Backlash):
        raise ValueError(f"backlash must be a Backlash, got {backlash!r}")
    names = signals(c.plant)
    n = coordinates(c.vertices, friction, backlash)
    asked: list[tuple] = []
    if friction is not None:
        force = np.broadcast_to(np.asarray(friction, float), (n,))
        asked += [(_rubbing, k, force[k]) for k in range(n) if force[k] > 0]
    if backlash is not None:
        asked.append((_gap, backlash, None))
    found = []
    for corner, d in enumerate(c.vertices):
        for kind, what, size in asked:
            found += kind(c, corner, d, what, size, names)
    return found


def _rubbing(c, corner, d, k, force, names):
    """f = -F sign(q'): N = 4 F / (pi a), of any size, on the speed of coordinate k."""
    one = np.eye(len(d.E))
    entry, row = one[:, d.n + k], one[d.n + k]
    for omega, G in _real(c, d, entry, row):
        if G < 0:  # N = -1 / G
            amplitude = 4 * force * -G / np.pi
            cause = f"friction of {force:g} on {names[k]}"
            yield Cycle(corner, omega / 2 / np.pi, float(amplitude), cause)


def _gap(c, corner, d, backlash, _, names):
    """f = k sat(q): the part of a spring's force that a gap takes away; N = -k D(a)."""
    from scipy.optimize import brentq

    n, (entry, row) = d.n, np.zeros((2, len(d.E)))
    i, j = backlash.first, backlash.second
    entry[[n + i, n + j]], row[[i, j]] = (1, -1), (1, -1)
    stiff, half = d.A[n + i, j], backlash.gap / 2
    for omega, G in _real(c, d, entry, row):
        if stiff * G > 1:  # D = 1 / (k G), between 0 and 1
            share = 1 / (stiff * G)
            amplitude = brentq(lambda a, s=share: _sat(a) - s, 1, 1e9 / share) * half
            cause = f"a gap of {backlash.gap:g} between {names[i]} and {names[j]}"
            yield Cycle(corner, omega / 2 / np.pi, float(amplitude), cause)


def _sat(ratio):
    """The gain of a saturation at 1 for a sine of amplitude ``ratio``, 1 or more."""
    s = 1 / ratio
    return 2 / np.pi * (np.arcsin(s) + s * np.sqrt(1 - s * s))


def _real(c, d, entry, row):
    """(frequency, G) where the loop's response from a force to row x is real."""
    from scipy.optimize import brentq

    E, A, B = d.E, d.A, d.Bu
    delay, own = c.delay, SampledSystem(c.A, c.B, c.C, c.D, c.T)

    def response(omega):
        omega = np.atleast_1d(omega)
        s = 1j * omega
        pencil = s[:, None, None] * E - A
        free = np.linalg.solve(
            pencil, np.broadcast_to(entry[:, None], (len(s), len(E), 1))
        )
        push = np.linalg.solve(pencil, np.broadcast_to(B, (len(s), *B.shape)))
        hold = (1 - np.exp(-s * c.T)) / (s * c.T) * np.exp(-s * delay)
        law = own.at(np.exp(s * c.T)) @ c.readings.rows
        loop = np.eye(len(E)) - hold[:, None, None] * (push @ law)
        return np.linalg.solve(loop, free)[:, :, 0] @ row

    grid = np.geomspace(SLOWEST, 0.999, GRID) * np.pi / c.T
    values = response(grid)
    for k in np.flatnonzero(values.imag[:-1] * values.imag[1:] < 0):
        omega = brentq(lambda w: response(w)[0].imag, grid[k], grid[k + 1])
        yield float(omega), float(response(omega)[0].real)
