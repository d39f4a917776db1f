"""One thread of linear algebra to a process: the matrices of an LMI are small, and a
BLAS that spreads them over the cores waits more than it computes.
"""

import contextlib
import ctypes
import functools
import threading
from importlib.util import find_spec
from pathlib import Path

#: Environment of a process that is to compute with one thread; it is read
#: when numpy is imported, so it must be set before.
ONE_THREAD = {
    f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL", "RAYON")
}


class _OneThread(contextlib.ContextDecorator):
    """Limits BLAS while any thread of the program is inside."""

    def __init__(self):
        self._lock = threading.Lock()
        self._inside = 0
        self._restore = None

    def __enter__(self):
        with self._lock:
            if not self._inside:
                self._restore = _limit()
            self._inside += 1
        return self

    def __exit__(self, *error):
        with self._lock:
            self._inside -= 1
            if not self._inside:
                self._restore()


#: ``with one_thread:`` or ``@one_thread``: BLAS has one thread inside.
one_thread = _OneThread()


def _limit():
    """Limit every BLAS that is loaded; returns what undoes it."""
    before = [(get(), put) for get, put in _openblas()]
    if not before and (controller := _controller()):
        limiter = controller.limit(limits=1, user_api="blas").__enter__()
        return lambda: limiter.__exit__(None, None, None)
    for _, put in before:
        put(1)

    def restore():
        for count, put in before:
            put(count)

    return restore


@functools.cache
def _controller():
    """The controller of threadpoolctl, for other kinds of BLAS, or None; OpenBLAS
    itself is asked first: threadpoolctl lets one thread at a time set limits.
    """
    import scipy.linalg  # noqa: F401  (has a BLAS of its own)

    try:
        from threadpoolctl import ThreadpoolController
    except ModuleNotFoundError:
        return None
    return ThreadpoolController()


@functools.cache
def _openblas():
    """(get, set) of the OpenBLAS that numpy's and scipy's wheels carry."""
    functions = []
    for package in ("numpy", "scipy"):
        home = Path(find_spec(package).origin).parent
        folders = home.with_name(f"{package}.libs"), home / ".dylibs"
        for file in sorted(f for folder in folders for f in folder.glob("*openblas*")):
            with contextlib.suppress(OSError):
                functions += _functions(ctypes.CDLL(str(file)))
    return functions


def _functions(dll):
    """(get, set) of one library, under whichever name it has them."""
    for prefix in ("scipy_openblas", "openblas"):
        for suffix in ("64_", "_64", ""):  # with "_" they are Fortran's
            get = getattr(dll, f"{prefix}_get_num_threads{suffix}", None)
            put = getattr(dll, f"{prefix}_set_num_threads{suffix}", None)
            if get and put:
                get.restype, get.argtypes = ctypes.c_int, ()
                put.restype, put.argtypes = None, (ctypes.c_int,)
                return [(get, put)]
    return []
