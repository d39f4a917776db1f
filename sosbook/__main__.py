"""``python -m sosbook verify proof.json``: see `sosbook.proofs.command`."""

import sys

from .proofs.command import main

if __name__ == "__main__":
    sys.exit(main())
