"""A controller's program, compiled and run in place of `Replay`."""

import ctypes

import numpy as np

from ..plants.checks import count
from .compiler import FLAGS, loaded
from .numbers import FLOAT_TYPES
from .program import Code
from .replay import COUNTERS


class CompiledCode:
    """The program in C, with the methods of `Replay`.

    Parameters
    ----------
    controller : Controller
        What it is the program of.
    runs : int
        How many machines.
    precision : {"double", "single"}
        Of all arithmetic.
    flags : sequence of str
        Of the compiler.

    Raises
    ------
    ValueError
        If an argument is bad; it has its name.
    RuntimeError
        If there is no compiler, or it refuses.
    """

    def __init__(self, controller, runs=1, precision="double", flags=FLAGS):
        """Compile the C and lay out its state for ``runs`` machines."""
        self.code = Code(controller, "law", precision)
        self.runs = count("runs", runs, least=1)
        self.kind = np.dtype(FLOAT_TYPES[precision])
        library = loaded("law", self.code.texts, flags=flags)
        self._real = {8: ctypes.c_double, 4: ctypes.c_float}[self.kind.itemsize]
        sizes = [len(controller.A), len(controller.readings.signals)]
        sizes += [len(controller.set_points), len(controller.outputs)]
        fields = [
            (name, self._real * max(size, 1)) for name, size in zip("xyru", sizes)
        ]
        fields += [("lost", ctypes.c_int * sizes[1])]
        fields += [(name, ctypes.c_int) for name in (*COUNTERS, "fault")]
        self.state_type = type("State", (ctypes.Structure,), {"_fields_": fields})
        self._sizes, self.states = sizes, None
        self._start, self._step = library.law_start, library.law_step
        self._start.restype, self._step.restype = None, ctypes.c_int
        pointer = ctypes.POINTER(self._real)
        state = ctypes.POINTER(self.state_type)
        self._start.argtypes = [state, pointer]
        self._step.argtypes = [state, pointer, pointer, self._real, pointer]

    @property
    def fault(self):
        """(runs,) array of int, indices in `FAULTS`; None before the start."""
        if self.states is None:
            return None
        return np.array([state.fault for state in self.states])

    def start(self, y):
        """As `Replay.start`, with what is measured, y."""
        self.states = [self.state_type() for _ in range(self.runs)]
        for state, row in zip(self.states, self._rows(y, self._sizes[1])):
            self._start(state, row)

    def step(self, y, r=(), elapsed=None):
        """As `Replay.step`: y is measured, r the set points, ``elapsed`` the time."""
        if self.states is None:
            raise ValueError("the program isn't started: call start(y)")
        m = self._sizes[3]
        u = (self._real * m)()
        found = np.empty((m, self.runs), self.kind)
        elapsed = self.code.controller.T if elapsed is None else elapsed
        ys, rs = self._rows(y, self._sizes[1]), self._rows(r, self._sizes[2])
        for k, (state, seen, told) in enumerate(zip(self.states, ys, rs)):
            self._step(state, seen, told, elapsed, u)
            found[:, k] = u[:]
        return found

    def _rows(self, values, count):
        values = np.asarray(values, float).reshape(count, -1 if count else self.runs)
        values = np.broadcast_to(values, (count, self.runs)).T
        array = self._real * max(count, 1)
        return [array(*row.tolist()) for row in values]
