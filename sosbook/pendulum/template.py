"""Templates of programs, which run as they stand; a robot's get its numbers.

A template is a program with an example's numbers. What a robot's program has
instead is looked up by its name: in ``#define NAME 0``, ``static const int NAME =
0;`` or ``NAME = 0`` the value is replaced.
"""

import re

from ..controllers.template import noted, read, replaced

__all__ = ["fill"]


def fill(template, note, values, name="balance"):
    """The program of a ``template`` for a robot.

    ``template``: the name of a file in the folder templates; ``note``: lines that say
    where the program comes from; ``values``: from the names in it to the texts of their
    values; ``name``: what stands for "balance" in the names of files and of functions.
    """
    text = read("sosbook.pendulum", template)
    for label, value in values.items():
        defines = rf"^(#define {label} |(?:static .*\b)?{label}(?:\[\w*\])* = )"
        text = replaced(rf"{defines}[^;\n]*?(?=;|  ?/\*|  #|$)", text, str(value))
    text = re.sub(r"\bbalance(?=_|\.(?:c|h|py|ino)\b)|(?<=_)balance\b", name, text)
    text = re.sub(r"\bBALANCE(?=_)", name.upper(), text)
    return noted(text, note)
