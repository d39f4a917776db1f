"""Limits of a step of a set point, as a search is asked for them."""

from dataclasses import dataclass

from ..plants.checks import positive

ASKED = "overshoot", "settling_time", "effort"


def share_of_step(check, overshoot):
    """An ``overshoot`` after its ``check``; a ValueError if it is above one."""
    if check("overshoot", overshoot) > 1:
        raise ValueError(
            f"overshoot is a share of the step, 0.05 for 5 %; got {overshoot!r}"
        )
    return overshoot


@dataclass(frozen=True)
class StepLimits:
    """Limits of every plant after a step of a set point from rest, at the ticks.

    Parameters
    ----------
    overshoot : float, optional
        At most, as a share of the step.
    settling_time : float, optional
        In s, after which the output stays in the ``band``.
    effort : float, optional
        The largest size of each u.
    size : float
        Of the step.
    set_point : int
        Which one.
    output : str, optional
        Of what: see `OutputBounds.step_response`, by which it is proven.
    band : float
        What counts as settled, as a share of the step.

    Raises
    ------
    ValueError
        If a number isn't positive, or none is asked.

    Examples
    --------
    >>> print(StepLimits(overshoot=0.05, effort=2).words)
    after a step of 1 its overshoot is at most 5 % and u is at most 2
    """

    overshoot: float | None = None
    settling_time: float | None = None
    effort: float | None = None
    size: float = 1.0
    set_point: int = 0
    output: str | None = None
    band: float = 0.02

    def __post_init__(self):
        """Check the numbers."""
        asked = [x for x in ASKED if getattr(self, x) is not None]
        if not asked:
            raise ValueError(f"StepLimits: give one of {', '.join(ASKED)}")
        for name in (*asked, "size", "band"):
            positive(name, getattr(self, name))
        if self.overshoot is not None:
            share_of_step(positive, self.overshoot)

    @property
    def words(self) -> str:
        """The limits in words."""
        parts = []
        if self.overshoot is not None:
            parts.append(f"its overshoot is at most {100 * self.overshoot:g} %")
        if self.settling_time is not None:
            parts.append(
                f"it stays within {100 * self.band:g} % after {self.settling_time:g} s"
            )
        if self.effort is not None:
            parts.append(f"u is at most {self.effort:g}")
        return f"after a step of {self.size:g} {' and '.join(parts)}"

    def missing(self, bounds):
        """Words for the limits that some ``bounds``, a `StepBounds`, don't prove."""
        pairs = [("effort", x) for x in bounds.effort]
        pairs.append(("overshoot", bounds.overshoot))
        pairs.append(("settling_time", bounds.settling_time))
        return [
            f"{name.replace('_', ' ')}: {bound}"
            for name, bound in pairs
            if (most := getattr(self, name)) is not None
            and (bound.proven is None or bound.proven > most)
        ]
