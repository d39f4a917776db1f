"""<name>_gains.h: a program's numbers, as definitions of C and nothing else."""

import numpy as np

from .numbers import NONE, literal
from .template import comment


class Gains:
    """The text of a <name>_gains.h, definition by definition, in this ``precision``;
    ``name`` is the program's; ``about``, ``columns``: what is known of it.
    """

    def __init__(self, name, precision, about, columns=()):
        self.prefix, self.precision = name.upper(), precision
        self._lines = [
            f"/* {name}_gains.h: the numbers of {name}.c, and what is known",
            " *",
            comment(about, " * "),
        ]
        for title, facts in columns:
            self._lines += [" *", f" * {title.upper()}"]
            self._lines += [comment([f"- {fact}"], " *   ") for fact in facts]
        guard = f"{self.prefix}_GAINS_H"
        self._lines += [" */", f"#ifndef {guard}", f"#define {guard}", ""]

    @property
    def text(self):
        """All of it."""
        return "\n".join([*self._lines, "", "#endif", ""])

    def define(self, label, value, said=""):
        """A ``label`` with a value as it is, and what is ``said`` of it."""
        text = f"#define {self.prefix}_{label} {value}"
        self._lines.append(f"{text} /* {said} */" if said else text)

    def number(self, label, value, unit):
        """A ``label`` with a value in a ``unit``."""
        self.define(label, literal(value, self.precision), f"{value:.9g} {unit}")

    def vector(self, label, values, said):
        """A ``label`` with a row of values, of which this is ``said``."""
        values = values if len(values) else np.zeros(1)
        words = ", ".join("none" if x >= NONE else f"{x:.9g}" for x in values)
        self._lines.append(f"/* {said}: {words} */")
        self.define(label, f"{{{self._row(values)}}}")

    def matrix(self, label, value, said, rows=()):
        """A ``label`` with a matrix value, what is ``said`` of it, and of its ``rows``;
        where it is empty a zero, for C has no array of nothing.
        """
        full = np.zeros([max(n, 1) for n in value.shape])
        full[: value.shape[0], : value.shape[1]] = value
        self._lines.append(f"/* {said} */")
        self.define(label, "{ \\")
        for k, row in enumerate(full):
            what = f"{rows[k]}: " if len(rows) else ""
            words = what + ", ".join(f"{x:.12g}" for x in row)
            self._lines.append(f"    {{{self._row(row)}}}, /* {words} */ \\")
        self._lines.append("}")

    def _row(self, values):
        return ", ".join(literal(x, self.precision) for x in values)
