"""``python -m sosbook verify proof.json``: see `sosbook.proofs.command`.

A small proof is decided by `sosbook.exact.quick`, without the package's libraries.
"""

import sys
import warnings

from .exact import quick
from .runtime.saying import one_line


def main(words=None):
    """The exit code of the command line's ``words``, or of the program's."""
    words = sys.argv[1:] if words is None else words
    if len(words) == 2 and words[0] == "verify" and not words[1].startswith("-"):
        code = quick.verify(words[1])
        if code is not None:
            return code
    from .proofs import command

    return command.main(words)


if __name__ == "__main__":
    warnings.formatwarning = lambda words, *_: f"warning: {one_line(words)}\n"
    sys.exit(main(sys.argv[1:]))
