"""From a log of a machine to its parameters, and to the plants that it allows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..plants.checks import finite, matrix
from ..plants.outputs import Output
from ..plants.uncertain import Uncertain
from .doubts import at_an_end, doubts_of, refuse_before, refuse_ends
from .fit import Fit, UnseenError, radius
from .records import Record
from .trial import Trial

__all__ = ["Identification", "identify"]

CONFIDENCE = 0.99  # of the family, without another being asked for


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Fit):
    """The parameters of a machine by a log: what `sosbook.identify` returns.

    Parameters
    ----------
    names : tuple of str
        The parameters.
    values : (p,) array
        Their values, in this order; ``found["J1"]`` is one of them.
    covariance : (p, p) array
        Their covariance: ``found.sd`` and ``found.interval("J1", 0.95)`` follow.
    residuals : (N, q) array
        Measured minus modelled, in the outputs' units.
    record : Record
        The log.
    builder : callable
        Makes the plant.
    outputs : Output or None
        What is measured.
    friction : tuple of str
        The parameters that are forces of friction, which the plant hasn't.
    doubts : tuple of str
        What speaks against the model or the log. The intervals are those of a model
        that is true, and hold none of it.
    """

    record: Record
    builder: Callable[..., Any]
    outputs: Output | None
    friction: tuple
    doubts: tuple

    def __repr__(self):
        lines = []
        for name, value, sd in zip(self.names, self.values, self.sd):
            half = radius(0.95) * sd
            lines.append(f"{name} = {value:.5g} +- {half:.2g}")
        rms = np.sqrt(np.mean(self.residuals**2, axis=0))
        left = ", ".join(f"{x:.2g}" for x in rms)
        lines.append(f"95 % each; the fit leaves {left} rms")
        return "\n".join([*lines, *(f"Doubt: {x}" for x in self.doubts)])

    @property
    def modelled(self) -> np.ndarray:
        """(N, q) array: what the plant with these values would have shown."""
        return self.record.y - self.residuals

    @property
    def plant(self) -> Any:
        """The plant with these values, without friction."""
        return self.builder(**self._own(dict(zip(self.names, self.values.tolist()))))

    def family(self, confidence: float = CONFIDENCE) -> Uncertain:
        """The plants that the log allows, ready for design.

        Parameters
        ----------
        confidence : float
            With at least this probability the box holds all true parameters at once,
            for normal errors to first order: each reaches so far that
            Sidak's inequality gives it, however errors are correlated.

        Returns
        -------
        Uncertain
            The builder's plants; the ends have five digits, outwards.

        Raises
        ------
        ValueError
            If the confidence isn't between 0 and 1, or the ranges reach a plant that
            can't be.
        """
        if not 0 < finite("confidence", confidence) < 1:
            raise ValueError(f"confidence must lie between 0 and 1, got {confidence!r}")
        own = self._own(dict(zip(self.names, self.sd)))
        reach = radius(confidence, len(own))
        return Uncertain(
            self.builder, **{k: _outwards(self[k], reach * sd) for k, sd in own.items()}
        )

    def _own(self, values):
        return {name: x for name, x in values.items() if name not in self.friction}


def _outwards(value, half):
    """The ends of an interval in decimals, five digits of its size, outwards."""
    unit = 10.0 ** (np.floor(np.log10(max(abs(value), half))) - 4)
    low, high = np.floor((value - half) / unit), np.ceil((value + half) / unit)
    return float(f"{low * unit:.12g}"), float(f"{high * unit:.12g}")


def identify(
    builder: Callable[..., Any],
    record: Record,
    start: dict[str, float],
    outputs: Output | None = None,
    friction: dict[str, Any] | None = None,
    rest: bool = True,
) -> Identification:
    r"""Fit the parameters of a machine to a log of it: a sweep, steps, any motion.

    The plant is simulated with the inputs of the log, held from sample to sample, and
    its parameters are those with which it comes nearest to what the sensors said (the
    output error), each sensor weighed by what its fit leaves. An offset of each sensor
    is fitted, too.

    Parameters
    ----------
    builder : callable
        From the parameters, by name, to a plant, as for `Uncertain`. Its mass must be
        regular.
    record : Record
        The log.
    start : dict
        A first guess of each parameter, by name: within a factor of two or three of
        the truth, and of its sign, which stays.
    outputs : Output, optional
        What the sensors measure, a row for each; all displacements, or the plant's own
        outputs, without it.
    friction : dict, optional
        Coulomb friction: by the name of its force, which has a guess in ``start``, too,
        the row of the speed against which it acts: ``{"rub": [1, 0]}`` acts on the
        first coordinate. Such a force isn't in the plant, nor in what is proven.
    rest : bool
        The machine is at rest when the log begins. If not, the state at the beginning
        is fitted; not with friction.

    Returns
    -------
    Identification
        Values with their intervals, the plant, the `family` that the log allows, and
        `doubts` about the log.

    Raises
    ------
    ValueError
        If the log can't tell a parameter, which is named; if it isn't this
        machine's, a sensor is at its end, or the times are of another unit; if
        arguments don't fit.

    Notes
    -----
    A family must be proven for more than a fit says: for what isn't modelled, too.
    Look at ``doubts`` and at the residuals before you believe intervals. A weekly test
    counts how often intervals of 95 % hold the true parameters of simulated machines:
    more than 85 in 100 of each parameter must, and with ``friction`` or ``rest=False``
    92 in 100 of a machine's; 88 of one that stands after a push, where a reading that
    rests on one step of its encoder counts as one number. Friction is simulated as a
    constant force against the speed, and nothing else of it is known. A closed loop is
    doubted where the sensors' noise is seen in u; where a reference hides it, nothing
    is said. Then loads on the machine are the fault to look for, since the controller
    answers them.

    Examples
    --------
    >>> import sosbook as sos
    >>> t = np.arange(400) * 0.01
    >>> push = np.sign(np.sin(t + t**2))
    >>> cart = lambda m, d: sos.SecondOrderSystem(m, d, 0, 1)
    >>> true = cart(2.0, 0.5).simulate(t, u=sos.Sine(1, 2.0)).z[0]
    >>> log = sos.Record(t, np.sin(2 * (t + 0.005)), (true / 1e-4).round() * 1e-4)
    >>> found = identify(cart, log, start={"m": 1, "d": 1})
    >>> round(found["m"], 2), round(found["d"], 2), found.family(0.9).degree
    (2.0, 0.5, {'m': 1, 'd': 1})
    """
    if not isinstance(record, Record):
        raise ValueError(
            "record must be a Record: Record(t, u, y) or Record.read(path)"
        )
    rubs = {k: matrix(k, np.atleast_2d(row)) for k, row in (friction or {}).items()}
    _check_start(start, rubs)
    if rubs and not rest:
        raise ValueError("with friction the log must begin at rest: cut it there")
    trial = Trial(builder, record, start, outputs, rubs, rest)
    refuse_before(record, trial.poles)
    held = at_an_end(record)
    if held.any():
        try:
            refuse_ends(trial.fitted(~held), record, held)
        except UnseenError:  # what is left says too little
            pass
    found = trial.fitted(np.ones(held.shape))
    slopes = trial.slopes(np.log(found.values / trial.guess))
    doubts = tuple(doubts_of(found, record, slopes, trial.guess))
    four = found.names, found.values, found.covariance, found.residuals
    return Identification(*four, record, builder, outputs, tuple(rubs), doubts)


def _check_start(start, rubs):
    """Refuse guesses that aren't numbers of a sign, and friction without a guess."""
    for name, guess in start.items():
        if not finite(f"start of {name}", guess):
            raise ValueError(f"start of {name} must not be zero: its sign stays")
    for name, rows in rubs.items():
        if name not in start or len(rows) > 1 or not rows.any():
            raise ValueError(f"friction {name} needs one row of a speed, and a start")
