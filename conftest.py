"""Settings for every test: one thread each, no progress bars, repeatable examples.

With ``pytest --nbval`` notebooks run in the environment of pytest, in kernels that are
forks of a process with the libraries; one may take four minutes to start and a cell
ten, and outputs are compared by their values (tests/values).
"""

import gc
import os

from sosbook.runtime.progress import WITHOUT_BARS
from sosbook.runtime.threads import ONE_THREAD

os.environ.update(ONE_THREAD | dict(os.environ) | WITHOUT_BARS)  # before numpy

from hypothesis import settings

from tests.values import cells
from tests.values.forks import forked

gc.set_threshold(100_000)  # thousands of tests are no garbage: a sixth of collecting

# Its seeds are fixed. Yet some of hypothesis's draws are constants of the package's
# modules that are loaded, and it has no switch against that (HypothesisWorks/hypo-
# thesis, issue 4627): an edit of another module may change the examples.
settings.register_profile("book", derandomize=True, deadline=None, database=None)
settings.load_profile("book")


def pytest_configure(config):
    option = config.option
    if getattr(option, "nbval", False):
        from jupyter_client.provisioning import local_provisioner as local

        local.launch_kernel = forked(local.launch_kernel)
        option.nbval_current_env = not option.nbval_kernel_name
        option.nbval_cell_timeout = min(option.nbval_cell_timeout, 600)
        option.nbval_kernel_startup_timeout = 240


def pytest_itemcollected(item):
    cells.adopt(item)
