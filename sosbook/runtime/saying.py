"""What a program prints: nothing that commands a terminal, and no broken pipe."""

import os
import sys


def one_line(text):
    r"""A text in which everything that isn't printed is escaped, line ends as well.

    Examples
    --------
    >>> print(one_line("P\nproven: \x1b[8m"))
    P\nproven: \x1b[8m
    """
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text)
    )


def visible(text):
    r"""A ``text`` of several lines, each as `one_line` has it.

    Examples
    --------
    >>> print(visible("\x1b[2Jproven\n- all"))
    \x1b[2Jproven
    - all
    """
    return "\n".join(map(one_line, text.split("\n")))


def say(text, stream=None):
    """Print a text; a reader who went away, as ``head`` does, is no error.

    ``text``: its str is printed, `visible`; ``stream``: standard output without it.
    """
    stream = sys.stdout if stream is None else stream
    try:
        print(visible(str(text)), file=stream, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
