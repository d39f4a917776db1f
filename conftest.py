"""Settings for every test: one thread each, no progress bars, repeatable examples.

With ``pytest --nbval`` notebooks run in the environment of pytest, kernels are forks
of a process with the libraries, one that doesn't answer is started again, a cell may
take ten minutes, and outputs are compared by their values (tests/values).
"""

import gc
import os

from sosbook.runtime.progress import WITHOUT_BARS
from sosbook.runtime.threads import ONE_THREAD

os.environ.update(ONE_THREAD | dict(os.environ) | WITHOUT_BARS)  # before numpy

import pytest
from hypothesis import settings

from tests.values import cells
from tests.values.forks import forked
from tests.values.kernels import started_again

# Its seeds are fixed. Yet some of hypothesis's draws are constants of the package's
# modules that are loaded, and it has no switch against that (HypothesisWorks/hypo-
# thesis, issue 4627): an edit of another module may change the examples.
settings.register_profile("book", derandomize=True, deadline=None, database=None)
settings.load_profile("book")


def pytest_configure(config):
    option = config.option
    if getattr(option, "nbval", False):
        import nbval.kernel
        from jupyter_client.provisioning import local_provisioner as local

        local.launch_kernel = forked(local.launch_kernel)
        nbval.kernel.start_new_kernel = started_again(nbval.kernel.start_new_kernel)
        option.nbval_current_env = not option.nbval_kernel_name
        option.nbval_cell_timeout = min(option.nbval_cell_timeout, 600)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Nine thousand tests are no garbage: nobody looks for it among them."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(20_000)  # arrays come and go by the hundred, few in cycles
        gc.enable()


def pytest_itemcollected(item):
    cells.adopt(item)
