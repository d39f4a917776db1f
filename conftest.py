"""Settings for every test: one thread each, no progress bars, repeatable examples."""

import os

for name in ("OMP", "OPENBLAS", "MKL", "RAYON"):
    os.environ.setdefault(f"{name}_NUM_THREADS", "1")
os.environ["TQDM_DISABLE"] = "1"  # no progress bars in compared outputs

from hypothesis import settings

settings.register_profile("book", derandomize=True, deadline=None, database=None)
settings.load_profile("book")
