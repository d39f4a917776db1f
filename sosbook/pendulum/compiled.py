"""The generated C program, compiled and run in place of `Controller`."""

import ctypes

import numpy as np

from ..controllers.compiler import FLAGS, compiler, loaded
from ..controllers.numbers import FLOAT_TYPES
from .export import Program
from .firmware import COUNTERS, NUMBERS

__all__ = ["FLAGS", "Compiled", "compiler"]


class Compiled:
    """A `Firmware` in C at work on robots side by side.

    It has the methods of `Controller` and can take its place.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    precision : {"double", "single"}
    folder : path_like, optional
        Where balance.h, balance.c and the compiled library go. Without it a
        temporary folder.
    flags : sequence of str
        The compiler's flags.
    runs : int
        How many robots stand side by side.

    Raises
    ------
    ValueError
        As for `Program`.
    FileExistsError
        If the folder has other files of these names.
    RuntimeError
        If there is no compiler, or it refuses.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Firmware, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> controller = Compiled(Firmware(law))  # doctest: +SKIP
    >>> controller.start(tilt=0.1)            # doctest: +SKIP
    >>> controller.step(gyro=0.0, wheels=0.0).round(3)  # doctest: +SKIP
    array([2.])
    """

    def __init__(self, firmware, precision="double", folder=None, flags=FLAGS, runs=1):
        program = Program(firmware, precision=precision)
        self.firmware, self.runs = firmware, runs
        self.kind = np.dtype(FLOAT_TYPES[precision])
        self.states = None
        self._load(loaded("balance", program.law, folder, flags))

    def _load(self, library):
        real = {8: ctypes.c_double, 4: ctypes.c_float}[self.kind.itemsize]
        order = self.firmware.law.order
        fields = [(name, real) for name in NUMBERS]
        fields += [("x", real * max(order, 1))]
        fields += [(name, ctypes.c_int) for name in (*COUNTERS, "fault")]
        self.state_type = type("State", (ctypes.Structure,), {"_fields_": fields})
        pointer = ctypes.POINTER(self.state_type)
        self._start, self._step = library.balance_start, library.balance_step
        self._start.argtypes = [pointer, *3 * [real]]
        self._step.argtypes = [pointer, *5 * [real]]
        self._start.restype, self._step.restype = None, real

    @property
    def fault(self):
        """(runs,) array of int, indices in `FAULTS`; None before start."""
        return self._read("fault", int)

    @property
    def theta(self):
        """(runs,) array, the estimate in rad; None before the start."""
        return self._read("theta", self.kind)

    def start(self, tilt, wheels=0.0, bias=0.0):
        """Forget everything, as `Controller.start`, and take tilt, wheels and bias."""
        self.states = [self.state_type() for _ in range(self.runs)]
        for state, *values in zip(self.states, *self._each(tilt, wheels, bias)):
            self._start(state, *values)

    def step(self, gyro, wheels, tilt=np.nan, target=0.0, rate=0.0):
        """One tick, as `Controller.step`: gyro, wheels, tilt, target and its rate."""
        if self.states is None:
            raise ValueError("the controller isn't started: call start(tilt)")
        V = [
            self._step(state, *values)
            for state, *values in zip(
                self.states, *self._each(gyro, wheels, tilt, target, rate)
            )
        ]
        return np.array(V, self.kind)

    def _each(self, *values):
        return [
            np.broadcast_to(np.asarray(value, float), self.runs).tolist()
            for value in values
        ]

    def _read(self, name, kind):
        if self.states is None:
            return None
        return np.array([getattr(s, name) for s in self.states], kind)
