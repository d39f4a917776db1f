"""``python checker proof.json`` for this folder, wherever it lies."""

import sys
from importlib import import_module
from pathlib import Path

here = Path(__file__).resolve().parent
sys.path[0] = str(here.parent)
sys.exit(import_module(here.name + ".verdict").main(sys.argv[1:]))
