"""A `Firmware` as C99 that needs nothing else.

The programs do what `Controller` does, operation by operation. Their
text depends on the firmware and on the package's version alone.
"""

import re

from . import spelling
from .firmware import Firmware
from .template import fill, replaced, written_by

__all__ = [
    "c_header",
    "c_source",
    "check",
    "law_file",
    "main_file",
    "provenance",
    "serial_main",
    "with_numbers",
]

C_TYPES = {"double": "double", "single": "float"}
#: What a law's file in single precision has for what the template has.
SINGLE = {r"\bdouble\b": "float", "DBL_MANT_DIG != 53": "FLT_MANT_DIG != 24"}
SINGLE |= {"DBL_MAX": "FLT_MAX"}
TAKEN_NAMES = {"float", "math", "rc", "robotcontrol", "stdint", "stdio"}
MOST_TICKS = 32766  # the least that C promises of an int, 32767, less one


def c_header(firmware, name="balance", precision="double"):
    """The header of the C program.

    Parameters
    ----------
    firmware : Firmware
        The law, its limits and its faults.
    name : str
        The name of the files, which also stands in front of every identifier.
    precision : {"double", "single"}
        The precision of all arithmetic.

    Returns
    -------
    str
        The text of <name>.h.

    Raises
    ------
    ValueError
        If ``name`` can't begin a C identifier, or the firmware's
        numbers don't fit.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> print(c_header(Firmware(law)).splitlines()[0])
    /* balance.h: a control law for a mobile inverted pendulum
    """
    check(firmware, name, precision)
    T, tip = f"{firmware.law.T:.9g}", f"{firmware.tip:.9g}"
    values = {"BALANCE_ORDER": firmware.law.order}
    text = law_file("balance.h", firmware, name, precision, values)
    text = replaced(r"(^ \*        )0\.01(?= s\. Compile)", text, T)
    return replaced(r"(beyond )0\.85(?= rad: there)", text, tip)


def c_source(firmware, name="balance", precision="double"):
    """The C program, for a compiler with IEEE numbers; C99, no library.

    Parameters
    ----------
    firmware, name, precision
        As for `c_header`.

    Returns
    -------
    str
        The text of <name>.c, which stands beside <name>.h.

    Raises
    ------
    ValueError
        As for `c_header`, and if the law doesn't use what it measures.

    Notes
    -----
    Compile with -ffp-contract=off: fused operations round once where
    the law's arithmetic rounds twice. Constants are hexadecimal, so
    that no digit is lost; zero coefficients are left out.

    MISRA C:2012, as far as cppcheck's addon looks: of the required rules two are
    not met, 14.4 (``if (!seen)`` asks an int) and 15.6 (a single statement stands
    without braces). Of the advisory ones it doesn't keep 2.4 and 5.9 (the enum has
    no tag, and each file has a ``within`` of its own), 8.9 (constants stand at the
    file's top), 12.1 (no parentheses where precedence decides), 15.5 (it returns
    early after a fault) and 17.8 (a bad reading is replaced in its argument). There
    is no heap, no recursion, no pointer arithmetic and no library.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> text = c_source(Firmware(law))
    >>> print(text[text.index("double u ="):].partition(";")[0])
    double u =
        D[0] * y[0] + D[1] * y[1] + D[2] * y[2] + D[3] * y[3]
    """
    check(firmware, name, precision)
    law = firmware.law
    values = {"COMPENSATES": int(firmware.compensation > 0), **spelling.ticks(firmware)}
    text = law_file("balance.c", firmware, name, precision, values)
    text = with_numbers(text, spelling.constants(firmware), precision)
    for label, value in spelling.matrices(law).items():
        size = "".join(f"[{n}]" for n in value.shape)
        braces = spelling.braces(value, precision)
        text = replaced(
            rf"^static const \w+ {label}\[[^;]*;\n",
            text,
            f"static const {C_TYPES[precision]} {label}{size} = {braces};\n"
            if value.any() or (label == "START" and law.order)
            else "",
        )
    rows = "".join(f"        {row},\n" for row in spelling.following(law))
    text = replaced(r"(next\[\w+\] = \{\n)[^}]*(?=    \})", text, rows)
    return replaced(r"( u =\n        )[^;]*(?=;)", text, spelling.output(law))


def serial_main(firmware, name="balance", precision="double"):
    """A main program for hardware in the loop: lines in, volts out.

    Parameters
    ----------
    firmware, name, precision
        As for `c_header`.

    Returns
    -------
    str
        The text of serial_<name>.c, which stands beside <name>.h and <name>.c.

    Examples
    --------
    >>> from sosbook.pendulum import PD_SIGNALS, Gain, SampledLaw
    >>> gain = Gain([[20, 0.8, 2, 0.9]], PD_SIGNALS)
    >>> law = SampledLaw.of_gain(gain, 0.01)
    >>> "int main(void)" in serial_main(Firmware(law))
    True
    """
    check(firmware, name, precision)
    return main_file("serial_balance.c", firmware, name, precision, {})


def law_file(template, firmware, name, precision, values):
    """The text of a ``template`` with ``values``, all of it in one precision.

    The ``firmware``, the ``name`` and the ``precision`` are those of `c_header`.
    """
    text = fill(template, provenance(firmware, precision), values, name)
    if precision == "single":
        for double, single in SINGLE.items():
            text = re.sub(double, single, text)
    return text


def main_file(template, firmware, name, precision, values):
    """The text of a ``template`` with ``values`` that calls a law.

    The ``firmware``, the ``name`` and the ``precision`` are those of `c_header`.
    """
    text = fill(template, provenance(firmware, precision), values, name)
    return replaced(r"(typedef )double(?= real;)", text, C_TYPES[precision])


def with_numbers(text, values, precision):
    """The ``text`` of C with ``values`` by their names, in a ``precision``."""
    for label, value in values.items():
        spelled = f"{spelling.literal(value, precision)};  /* {value:.9g}"
        text = replaced(rf"( {label} = )\S+;  /\* \S+", text, spelled)
    return text


def check(firmware, name, precision):
    """Refuse a ``firmware``, ``name`` or ``precision`` that gives no program.

    They are those of `c_header`, whose ValueError it raises.
    """
    if not isinstance(firmware, Firmware):
        raise ValueError("firmware must be a Firmware")
    if precision not in C_TYPES:
        raise ValueError(f"precision must be 'double' or 'single', got {precision!r}")
    if (
        not isinstance(name, str)
        or name in TAKEN_NAMES
        or name[:3] == "rc_"
        or not re.fullmatch(r"[a-z][a-z0-9_]{0,30}", name)
    ):
        raise ValueError(
            "name must begin a C identifier, in lower case, and be no "
            f"name that C or the robot's library has, got {name!r}"
        )
    for field in spelling.TICKS:
        if getattr(firmware, field) > MOST_TICKS:
            raise ValueError(
                f"{field} must be at most {MOST_TICKS}, for C's int, got "
                f"{getattr(firmware, field)}"
            )
    law = firmware.law
    if not (law.D.any() or (law.C.any() and law.B.any())):
        raise ValueError("law doesn't use what it measures: D is zero, and B or C")


def provenance(firmware, precision="double"):
    """Where a ``firmware`` in a ``precision`` comes from, line by line."""
    law = firmware.law
    about = firmware.note if not isinstance(firmware.note, str) else (firmware.note,)
    lines = [
        written_by(),
        *(line for text in about for line in str(text).splitlines()),
        *(
            [
                "Every number is rounded to single precision; what is said of "
                "the law is said of its decimals."
            ]
            * (precision == "single")
        ),
        f"T_s = {law.T:.9g} s, at most {firmware.limit:.9g} V, order {law.order}.",
    ]
    return lines
