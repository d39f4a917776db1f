"""A `Firmware` as C99 that needs nothing else.

The programs do what `Controller` does, operation by operation. Their
text depends on the firmware and on the package's version alone.
"""

import re

from . import spelling
from .firmware import FAULTS, Firmware
from .template import comment, fill, written_by

__all__ = ["c_header", "c_source", "guards", "provenance", "serial_main", "words"]

C_TYPES = {"double": "double", "single": "float"}
DIGITS = {"double": ("DBL", 53), "single": ("FLT", 24)}  # binary ones of a mantissa
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
    values = words(firmware, name, precision)
    order = firmware.law.order
    reason = {
        "running": "no fault",
        "sensor": f"over {firmware.missing} bad readings in a row"
        + (f", or over {firmware.frozen} repeated" if firmware.frozen else "")
        + (
            f", or over {firmware.deaf} of still wheels under voltage"
            if firmware.deaf
            else ""
        ),
        "fall": f"the body tilts by more than {firmware.tip:.9g} rad",
        "stall": f"over {firmware.stall} ticks at the voltage's limit",
        "command": "the law's answer is no number to trust",
    }
    faults = [
        f"    {name.upper()}_{fault.upper()} = {k},  /* {reason[fault]} */"
        for k, fault in enumerate(FAULTS)
    ]
    x = f"x[{order}];".ljust(12)
    state = f"    {C_TYPES[precision]} {x}/* the law's state */\n"
    return fill(
        "law.h",
        values,
        faults="\n".join(faults).replace(
            f" = {len(FAULTS) - 1},", f" = {len(FAULTS) - 1} "
        ),
        x=state if order else "",
        T=f"{firmware.law.T:.9g}",
        tip=f"{firmware.tip:.9g} rad",
    )


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
    >>> print(text[text.index("const double u"):].partition(";")[0])
    const double u =
        D[0] * y[0] + D[1] * y[1] + D[2] * y[2] + D[3] * y[3]
    """
    values = words(firmware, name, precision)
    law, real = firmware.law, C_TYPES[precision]

    def number(value):
        return spelling.literal(value, precision)

    constants = spelling.c_constants(spelling.constants(firmware), real, number) + [
        f"static const int {label} = {value};  /* ticks in a row */"
        for label, value in spelling.counts(firmware)
    ]
    matrices = [
        f"static const {real} {label}{spelling.size(value)} = "
        f"{spelling.braces(value, number)};"
        for label, value in spelling.matrices(law)
    ]
    output, following = spelling.output(law), spelling.following(law)
    start = [f"    s->x[{i}] = START[{i}] * tilt;\n" for i in range(law.order)]
    alias = f"    const {real} *x = s->x;\n"
    after = ""
    if law.order:
        rows = "".join(f"        {row},\n" for row in following)
        after = (
            f"    const {real} next[{law.order}] = {{\n{rows}"
            f"    }};\n    for (int i = 0; i < {law.order}; i++)\n"
            "        s->x[i] = next[i];\n"
        )
    uses_x = "x[" in output + "".join(following)
    return fill(
        "law.c",
        values,
        constants="\n".join(constants),
        guards=guards(precision),
        matrices="\n".join(matrices),
        start="".join(start),
        alias=alias if uses_x else "",
        command=_command(firmware, output, real),
        next=after,
    )


def _command(firmware, output, real):
    """The lines of C that make the command u from the law's output."""
    more = spelling.compensated(firmware, "{0} ? {1} : {2}".format)
    if not more:
        return f"    const {real} u =\n        {output};\n"
    return (
        f"    {real} u =\n        {output};\n"
        f"    u = u + ({more}); /* against friction */\n"
    )


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
    return fill("serial.c", words(firmware, name, precision))


def guards(precision):
    """What keeps a compiler from another arithmetic than that of a ``precision``."""
    mantissa, digits = DIGITS[precision]
    real = C_TYPES[precision]
    return fill(
        "guards.c", {"mantissa": mantissa, "digits": digits, "real": real}
    ).rstrip()


def words(firmware, name, precision):
    """What every template of a ``firmware`` needs, by its word.

    The ``name`` of the files and the ``precision`` are those of `c_header`;
    arguments are checked.
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
    for field in ("missing", "frozen", "stall", "deaf"):
        if getattr(firmware, field) > MOST_TICKS:
            raise ValueError(
                f"{field} must be at most {MOST_TICKS}, for C's int, got "
                f"{getattr(firmware, field)}"
            )
    law = firmware.law
    if not (law.D.any() or (law.C.any() and law.B.any())):
        raise ValueError("law doesn't use what it measures: D is zero, and B or C")
    return {
        "name": name,
        "NAME": name.upper(),
        "real": C_TYPES[precision],
        "note": comment(provenance(firmware, precision), " * "),
    }


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
