"""How far a loop is from instability at the plant's input: opened where u = K x enters,
in all inputs at once, L(s) = -K (s E - A)^-1 B_u. An acceleration gain stays inside, as
does an observer, whose state is then part of x.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, repr=False)
class DiskMargin:
    """Gains and phases that the loop bears in all inputs at once.

    Parameters
    ----------
    radius : float
        alpha: every input may be multiplied by its own complex number
        (2 + a) / (2 - a) with |a| < alpha. Zero for an unstable loop.

    Examples
    --------
    >>> DiskMargin(2 / 3).gains
    (0.5, 2.0)
    >>> DiskMargin(2 / 3)
    <DiskMargin: radius 0.667; gains 0.5 to 2 times, or phases of 36.9 degrees>
    """

    radius: float

    @property
    def gains(self):
        """(low, high): real factors between them leave the loop stable."""
        if self.radius >= 2:
            return 0.0, np.inf
        low, high = (2 - self.radius) / 2, (2 + self.radius) / 2
        return round(low / high, 12), round(high / low, 12)

    @property
    def phase(self):
        """Radians by which the inputs may turn, either way."""
        return 2 * np.arctan(self.radius / 2)

    def __repr__(self):
        if self.radius == 0:
            return "<DiskMargin: none, a loop is unstable>"
        (low, high), turn = self.gains, np.degrees(self.phase)
        return (
            f"<DiskMargin: radius {self.radius:.3g}; gains {low:.3g} to {high:.3g} "
            f"times, or phases of {turn:.3g} degrees>"
        )


def sensitivity_peak(d, K):
    r"""The largest :math:`\|(I + L(j\omega))^{-1}\|`; infinite if unstable.

    Its inverse, the modulus margin, is the distance of Nyquist's curve
    from the critical point. ``d``: the plant; ``K``, (m, N): the gain of u = K x.

    >>> from sosbook import SecondOrderSystem
    >>> from sosbook.plants.descriptor import descriptors
    >>> d, = descriptors(SecondOrderSystem(M=1, D=0, S=0, B=1))
    >>> round(sensitivity_peak(d, np.array([[-1.0, -1.0]])), 3)
    1.155
    """
    return _peak(d, K, 1.0)


def disk_margin(d, K):
    """The `DiskMargin` of a loop, a lower bound with several inputs.

    ``d``, ``K``: as for `sensitivity_peak`. Its radius is the inverse of the peak of
    S - I / 2, S being the sensitivity. Source: Seiler, Packard and Gahinet, An
    introduction to disk margins (2020), for the skew 0.
    """
    peak = _peak(d, K, 0.5)
    return DiskMargin(0.0 if peak == np.inf else float(1 / peak))


def _peak(d, K, through):
    """The largest |K (jw - A_K)^-1 B + through I| over all frequencies."""
    from .linear import loop_matrix, peak_gain

    if not len(K):
        raise ValueError(
            "K has no row: no input is left where the loop could be opened; give the "
            "plant's input as the B of a DescriptorSystem to analyse_pid, or ask the "
            "ObserverDesign"
        )
    _, B, _ = d.state_space()
    return peak_gain(loop_matrix(d, K), B, K, through * np.eye(len(K)))
