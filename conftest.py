"""Settings for every test: one thread for each process, repeatable examples."""

import os

for name in ("OMP", "OPENBLAS", "MKL", "RAYON"):
    os.environ.setdefault(f"{name}_NUM_THREADS", "1")

from hypothesis import settings

settings.register_profile("book", derandomize=True, deadline=None, database=None)
settings.load_profile("book")
