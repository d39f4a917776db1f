"""A controller as a program in C99, whole files of the folder templates, which include
the written ones: <name>_gains.h and, for the bench, <name>_plants.h.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..plants.schedule import Schedule
from ..runtime.writing import write_texts
from .facts import span
from .gains import Gains
from .numbers import checked_words, literal, program_numbers
from .schedule import schedule_text
from .signals import identifiers
from .template import comment, written_by
from .written import CONTROLLER, around_texts, law_texts, record

SINGLE = "1: float, 0: double"
MATRICES = {
    "A": "memory to memory",
    "B": "({y}) to memory",
    "BR": "set points to memory",
    "W": "what the limits add, v - u, to memory",
    "C": "memory to outputs",
    "D": "({y}) to outputs",
    "DR": "set points to outputs",
    "GUESS": "memory to what will be measured",
    "START": "({y}) to the memory at the start",
}
INTO_MEMORY = "A", "B", "BR", "W", "START"
VECTORS = {
    "LIMIT": "largest output",
    "SLEW": "largest change of an output in a tick",
    "RAMP": "largest change of a set point in a tick",
    "RANGE": "a reading beyond it isn't believed",
    "JUMP": "a reading that moved more in a tick isn't believed",
    "REACH": "a set point beyond it isn't taken",
    "TRUSTED": "an answer beyond it is broken",
}
BENCH_SPAN = 20.0  # times the slowest time constant, at most MOST_BENCH_TICKS
MOST_BENCH_TICKS = 200_000
MOST_TICK_US = 2**31 - 1  # half of what 32 bits count: clocks wrap around
ROUNDED = 0.01  # of T, that its whole microseconds may differ
REST_SHARE = 0.02  # of the step: what moves less is at rest


@dataclass(frozen=True)
class Code:
    """The program of a `Controller`, file by file.

    Parameters
    ----------
    controller : Controller
        What it is the program of.
    name : str
        Of the files, and in front of each identifier of C.
    precision : {"double", "single"}
        Of all arithmetic.
    facts : tuple of (str, list of str)
        What the header says, in columns: what is proven, bounded, simulated.
    proofs : tuple of (str, str)
        Proof files that go with it: the ends of their names, and their texts.
    trials : tuple of Trial
        The steps that ``facts`` tell of, one for each set point.

    Raises
    ------
    ValueError
        If C can't have the name, a number doesn't fit the precision, or T isn't nearly
        a number of microseconds.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]])
    >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
    >>> code = Code(design.controller(T=0.01), "cart")
    >>> sorted(code.texts)[:4]
    ['CMakeLists.txt', 'cart.c', 'cart.h', 'cart_bench.c']
    >>> print(code.texts["cart.c"].splitlines()[0])
    /* cart.c: see cart.h
    """

    controller: Any
    name: str = "axis"
    precision: str = "double"
    facts: tuple = ()
    proofs: tuple = ()
    trials: tuple = ()

    def __post_init__(self):
        """Check the name, the precision and the size of the program."""
        checked_words(self.name, self.precision)
        identifiers([s.name for s in self.controller.readings.signals])  # raises
        T = self.controller.T
        ticks = round(1e6 * T)
        if not (ticks <= MOST_TICK_US and abs(1e-6 * ticks - T) <= ROUNDED * T):
            raise ValueError(
                f"T = {T:g} s can't be the clock of a board, which counts whole "
                f"microseconds up to {MOST_TICK_US}: take a T that is nearly so many"
            )

    @cached_property
    def texts(self) -> dict:
        """The text of each file by its name."""
        name, c = self.name, self.controller
        law = law_texts(CONTROLLER, name)
        texts = {f"{name}{end}": text for end, text in law.items()}
        texts |= around_texts(name)
        texts[f"{name}_gains.h"] = self.gains
        texts[f"{name}_plants.h"] = _plants(c, self.precision, self.trials)
        texts |= {f"proof_{name}{end}.json": text for end, text in self.proofs}
        parts: tuple[str, ...] = (".h", ".c", "_tick.h", "_gains.h")
        if c.limits.profile is not None:
            texts[f"{name}_move.h"] = c.limits.profile.to_c(name, self.precision)
            parts += ("_move.h",)
        family = c.plant.family
        if family is not None and family.schedule:
            mean = Schedule(family.schedule, family.box), len(c.outputs)
            texts[f"{name}_schedule.h"] = schedule_text(*mean, name, self.precision)
            parts += ("_schedule.h",)
        for part in parts:
            texts[f"{name}_sketch/{name}{part}"] = texts[f"{name}{part}"]
        return texts | {f"program_{name}.json": record(texts, name)}

    @cached_property
    def gains(self) -> str:
        """The text of <name>_gains.h: all numbers, and what is known of them."""
        c, values = self.controller, program_numbers(self.controller)
        written = Gains(self.name, self.precision, [written_by()], self.facts)
        written.define("SINGLE", int(self.precision == "single"), SINGLE)
        written.define("STATES", len(c.A), "numbers that it remembers")
        written.define("MEASURED", len(c.readings.signals))
        written.define("SET_POINTS", len(c.set_points))
        written.define("OUTPUTS", len(c.outputs))
        us = f"{round(1e6 * c.T)}UL"
        written.define("TICK_US", us, f"{c.T:g} s between samples")
        said = f"{c.delay:g} s from a sample to the actuator:"
        written.define("DELAY_TICKS", c.timing.whole_samples, said)
        us = f"{round(1e6 * float(c.timing.remainder))}UL"
        written.define("DELAY_REST_US", us, "whole ticks, and what is left")
        kinds = ("IN", c.readings.signals), ("SET", c.set_points), ("OUT", c.outputs)
        for kind, signals in kinds:
            words = identifiers([s.name for s in signals])
            for k, (word, signal) in enumerate(zip(words, signals)):
                written.define(f"{kind}_{word}", k, str(signal))
        for label in ("TICK", "SLACK"):
            written.number(label, values[label], "s")
        for label, said in (
            ("MOST_LOST", f"ticks: {c.faults.lost:g} s without a sample"),
            ("MOST_LATE", f"ticks: {c.faults.late:g} s of ticks early or late"),
            ("MOST_FULL", f"ticks: {c.faults.stall:g} s at the limit"),
            ("MOST_SILENT", f"ticks: {c.faults.silence:g} s without a set point, or 0"),
            ("PREDICTS", "1: a lost sample is predicted; 0: the last one stays"),
            ("SLEWS", "1: the outputs' change is limited"),
            ("RAMPS", "1: set points are followed along a ramp"),
        ):
            written.define(label, values[label], said)
        followed = [-1 if k is None else k for k in c.followed] or [-1]
        said = "where a set point starts: at this reading"
        written.define("FOLLOWED", "{" + ", ".join(map(str, followed)) + "}", said)
        for label, said in VECTORS.items():
            written.vector(label, values[label], said)
        states = list(c.states) or ["nothing"]
        y = ", ".join(map(str, c.readings.signals))
        for label, said in MATRICES.items():
            rows = states if label in INTO_MEMORY else ()
            written.matrix(label, values[label], said.format(y=y), rows)
        said = "for a checker: what is measured of the plant's state"
        written.matrix(
            "ROWS", c.readings.rows, said, list(map(str, c.readings.signals))
        )
        return written.text

    def write(self, folder: Any, replace: bool = False) -> list:
        """Write all files into a folder: all or none, over nothing foreign.

        Parameters
        ----------
        folder : str or Path
            Made if it doesn't exist.
        replace : bool
            Files that are there with another text are replaced.
        """
        return write_texts(folder, self.texts, replace)


def _plants(c, precision, trials):
    """The text of <name>_plants.h: every corner of the plant, from tick to tick, and
    the steps of ``trials``; of 1 without them.
    """
    held = [c.timing.held(d) for d in c.vertices]
    older = held[0][0].shape[0] - c.readings.rows.shape[1]
    rows = np.hstack([c.readings.rows, np.zeros((len(c.readings.rows), older))])
    sizes = np.array([trial.size for trial in trials] or np.ones(len(c.set_points)))
    ticks = round(span(c, BENCH_SPAN, MOST_BENCH_TICKS, sizes) / c.T)
    rest = max([REST_SHARE * min(sizes, default=1.0), *(2 * c.readings.steps)])
    r = sizes if sizes.size else np.zeros(1)

    def braces(value):
        if np.ndim(value) == 0:
            return literal(float(value), precision)
        inner = ", ".join(map(braces, value))
        return "{" + inner + "}"

    lines = [
        "/* The plants of the bench: their state from tick to tick, [z; z'; older u].",
        " *",
        comment([written_by()], " * "),
        " */",
        f"#define BENCH_CORNERS {len(held)}",
        f"#define BENCH_STATES {len(held[0][0])}",
        f"#define BENCH_TICKS {ticks}L /* {ticks * c.T:.3g} s */",
        f"#define BENCH_REST {literal(rest, precision)}",
        f"#define BENCH_SET_POINTS {braces(r)}",
        f"#define BENCH_STEPS {braces(c.readings.steps)}",
        f"#define BENCH_H {braces(rows)}",
    ]
    for label, k in (("F", 0), ("G", 1)):
        corners = ", \\\n    ".join(braces(pair[k]) for pair in held)
        lines.append(f"#define BENCH_{label} {{ \\\n    {corners} \\\n}}")
    return "\n".join(lines) + "\n"
