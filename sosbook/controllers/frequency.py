"""The frequency response of an open loop at several plants, and charts of it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .charts import POINTS, chart

FAR = 4  # from zero, as far as L is drawn
ONE = 1e-9  # a size or an angle that is zero but for roundings


@dataclass(frozen=True, eq=False)
class OpenLoop:
    """L of several plants: a loop with the return 1 + L, opened ``at`` a signal.

    Parameters
    ----------
    omega : (k,) array
        Frequencies in rad/s, up to that of every other tick.
    S : (plants, k) array of complex
        The sensitivities 1 / (1 + L).
    names : tuple of str
        Of the plants.
    at : str
        The signal.
    """

    omega: np.ndarray
    S: np.ndarray
    names: tuple
    at: str

    @cached_property
    def L(self):
        """(plants, k): 1 / S - 1."""
        return 1 / self.S - 1

    @cached_property
    def critical(self):
        """(plants, k): the numbers g with 1 + g L = 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return self.S / (self.S - 1)

    def distance(self, gain):
        """The least distance of a real ``gain`` from the critical ones."""
        return float(np.nanmin(abs(self.critical - gain)))

    def seen(self, name):
        """(value, which plant): the worst of a margin, by the ``name``: "low", "high",
        gains; "phase", in degrees; "disk", alpha; "delay", in s, as frequencies tell.
        """
        each = [getattr(self, f"_{name}")(k) for k in range(len(self.S))]
        best = int(np.argmax(each) if name == "low" else np.argmin(each))
        return each[best], best

    def _crossings(self, k, level):
        """(position, share) of where an array, of plant k, changes its sign."""
        at = np.flatnonzero(np.diff(np.sign(level)) != 0)
        return at, level[at] / (level[at] - level[at + 1])

    def _gains(self, k):
        g = self.critical[k]
        at, share = self._crossings(k, g.imag)
        found = g.real[at] + share * (g.real[at + 1] - g.real[at])
        ends = [g[j].real for j in (0, -1) if abs(g[j].imag) < 1e-3 * abs(g[j])]
        found = np.array([*found, *ends])
        return found[np.isfinite(found) & (found > ONE)]

    def _low(self, k):
        return max((x for x in self._gains(k) if x < 1), default=0.0)

    def _high(self, k):
        return min((x for x in self._gains(k) if x > 1), default=np.inf)

    def _turns(self, k):
        """(frequencies, angles): where |L| = 1, and how far L is from -1 there."""
        g = self.critical[k]
        at, share = self._crossings(k, np.log(abs(g)))
        step = np.angle(g[at + 1] / g[at])
        omega = self.omega[at] + share * np.diff(self.omega)[at]
        return omega, np.angle(g[at]) + share * step

    def _phase(self, k):
        _, angles = self._turns(k)
        return min(np.degrees(abs(angles)), default=180.0)

    def _delay(self, k):
        omega, angles = self._turns(k)
        return min((-angles % (2 * np.pi)) / omega, default=np.inf)

    def _disk(self, k):
        return float(1 / abs(self.S[k] - 0.5).max())

    def bode(self, measured=None):
        """Inline SVG: |L| in dB and its phase over the frequency, of the plants, and
        the band between them, which is seen and not proven; ``measured``: a
        `MeasuredResponse` of L, a curve more.
        """
        axis, charts = dict(across="frequency in rad/s", log=True, low=True), []
        for unit, of in (("dB", _decibels), ("degrees", _phase)):
            pairs = [(self.omega, y) for y in of(self.L)]
            if measured is not None:
                pairs.append((measured.omega, of(measured.H[None])[0]))
            charts.append(chart(pairs, self._words(unit), band=len(self.L), **axis))
        return "".join(charts)

    def nyquist(self, measured=None):
        """Inline SVG: L in the complex plane; what is far from zero is drawn nearer;
        ``measured``: see `bode`.
        """
        curves = []
        for L in [*self.L, *([] if measured is None else [measured.H])]:
            L = L / np.maximum(abs(L) / FAR, 1)
            way = np.cumsum(abs(np.diff(L, prepend=L[:1])))  # in even steps of it
            L = L[np.searchsorted(way, np.linspace(0, way[-1], POINTS))]
            curves.append((L.real, L.imag))
        dot = (np.array([-1.0, -1.0]), np.array([-0.1, 0.1]))
        words = f"{self._words('Im')}, to the size {FAR}; the mark is -1"
        return chart([*curves, dot], words, across="Re L", low=True)

    def nichols(self, measured=None):
        """Inline SVG: |L| in dB over its phase; ``measured``: see `bode`."""
        curves = [*zip(_phase(self.L), _decibels(self.L))]
        if measured is not None:
            curves += zip(_phase(measured.H[None]), _decibels(measured.H[None]))
        return chart(curves, self._words("dB"), across="phase in degrees", low=True)

    def _words(self, unit):
        """The words of a chart, which say that it proves nothing."""
        return f"{unit} of L at {self.at}, as seen"


def _decibels(L):
    return 20 * np.log10(np.maximum(abs(L), 1e-300))


def _phase(L):
    """In degrees, as curves without jumps, of (curves, k)."""
    angles = np.unwrap(np.angle(L), axis=1)
    first = np.round((angles[:, :1] + np.pi / 2) / (2 * np.pi))
    return np.degrees(angles - 2 * np.pi * first)
