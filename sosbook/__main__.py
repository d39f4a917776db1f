"""``python -m sosbook verify proof.json``: see `sosbook.proofs.command`."""

import sys
import warnings

from .proofs.command import main
from .runtime.saying import one_line

if __name__ == "__main__":
    warnings.formatwarning = lambda words, *_: f"warning: {one_line(words)}\n"
    sys.exit(main())
