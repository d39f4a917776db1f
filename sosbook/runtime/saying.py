"""What a program prints: nothing that commands a terminal, and no broken pipe."""

import os
import sys

__all__ = ["say", "visible"]


def visible(text):
    """A ``text`` whose control characters are spelled, but for the ends of lines.

    Examples
    --------
    >>> print(visible("\\x1b[2Jproven"))
    \\x1b[2Jproven
    """
    return "".join(
        c if c == "\n" or c.isprintable() else c.encode("unicode_escape").decode()
        for c in text
    )


def say(text, stream=None):
    """Print a text; a reader who went away, as ``head`` does, is no error.

    Parameters
    ----------
    text : object
        Its str is printed, `visible`.
    stream : file, optional
        Standard output without it.
    """
    stream = sys.stdout if stream is None else stream
    try:
        print(visible(str(text)), file=stream, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
