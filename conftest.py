"""Settings for every test: one thread each, no progress bars, repeatable examples.

Notebooks run with ``pytest --nbval`` in the environment of pytest, and a cell
may take ten minutes.
"""

import os
from pathlib import Path

for name in ("OMP", "OPENBLAS", "MKL", "RAYON"):
    os.environ.setdefault(f"{name}_NUM_THREADS", "1")
os.environ["TQDM_DISABLE"] = "1"  # no progress bars in compared outputs

from hypothesis import settings

settings.register_profile("book", derandomize=True, deadline=None, database=None)
settings.load_profile("book")


def pytest_configure(config):
    option = config.option
    if getattr(option, "nbval", False):
        if not option.nbval_kernel_name:
            option.nbval_current_env = True
        option.nbval_cell_timeout = min(option.nbval_cell_timeout, 600)
        option.nbval_sanitize_with = str(
            Path(__file__).with_name("tests") / "nbval_sanitize.cfg")
