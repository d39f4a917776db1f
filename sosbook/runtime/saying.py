"""Output of a program: nothing that commands a terminal, and no broken pipe."""

import os
import sys
import warnings


def one_line(text):
    r"""A text in which everything that isn't printed is escaped, line ends as well.

    >>> print(one_line("P\nproven: \x1b[8m"))
    P\nproven: \x1b[8m
    """
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text)
    )


def visible(text):
    """A ``text`` of several lines, each as `one_line` has it."""
    return "\n".join(map(one_line, text.split("\n")))


def say(text, stream=None):
    """Print a ``text``, `visible`, on a ``stream``; a reader may go away."""
    stream = sys.stdout if stream is None else stream
    try:
        print(visible(str(text)), file=stream, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def warn_outside(words, category=UserWarning):
    """Warn of ``words``, in a ``category``, at the line outside that called us."""
    package, level = __name__.partition(".")[0], 2
    frame = sys._getframe(1)
    while frame and frame.f_globals.get("__name__", "").split(".")[0] == package:
        frame, level = frame.f_back, level + 1
    warnings.warn(words, category, stacklevel=level)
