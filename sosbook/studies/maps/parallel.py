"""A function over many points, in parallel, with the same result anyhow.

joblib does the work, so the same call runs in this process, in worker
processes, or on a Dask cluster::

    with joblib.parallel_config(backend="dask"):
        sweep(function, points)
"""

import os
from concurrent.futures.process import BrokenProcessPool
from contextlib import nullcontext

from joblib import Parallel, delayed, parallel_config
from joblib.parallel import get_active_backend
from tqdm.auto import tqdm

__all__ = ["sweep"]


def sweep(function, points, n_jobs=None, progress=True, retries=3):
    """``[function(p) for p in points]``, the points in parallel.

    Parameters
    ----------
    function : callable
        Of one point. Without side effects: a point may run again.
    points : iterable
    n_jobs : int, optional
        Worker processes; -1 for one on each core. Left out, it is what
        a surrounding ``joblib.parallel_config`` says, or 1.
    progress : bool
        Show a progress bar, unless the environment variable
        TQDM_DISABLE is set.
    retries : int
        How often a pool of workers may die before its points are run
        one by one.

    Returns
    -------
    list
        In the order of the points, whatever the order of completion.

    Raises
    ------
    RuntimeError
        If a point kills its worker, again and alone.
    Exception
        Whatever the function raises, with a note that names the point.

    Notes
    -----
    Each worker process gets one BLAS thread. A worker that dies takes
    nothing with it but time: what it had not delivered runs again. On a
    Dask cluster its scheduler sees to that; a point that kills more
    workers than ``allowed-failures`` is given up there, of which joblib
    1.6 isn't told, so that the call waits: try the point locally.

    Examples
    --------
    >>> sweep(abs, [-3, 2, -1], progress=False)
    [3, 2, 1]
    """
    points = list(points)
    found = {}
    with bar(len(points), progress) as done:
        for place, value in finished(function, points, n_jobs, retries):
            found[place] = value
            done.update()
    return [found[place] for place in range(len(points))]


def bar(total, progress=True):
    """A progress bar; in notebooks tqdm doesn't read TQDM_DISABLE."""
    hidden = not progress or "TQDM_DISABLE" in os.environ
    return tqdm(total=total, leave=False, disable=hidden)


def finished(function, points, n_jobs=None, retries=3):
    """Yield (place, value) of each point, as they are completed."""
    if n_jobs is not None and (not isinstance(n_jobs, int) or n_jobs == 0):
        raise ValueError(
            f"n_jobs = {n_jobs!r} must be a whole number: 1 or more "
            "workers, or -1 for one on each core"
        )
    left, deaths, suspects = dict(enumerate(points)), 0, set()
    while left:
        alone = deaths >= retries
        batch = list(left.items())[:1 if alone else None]
        try:
            for place, value in _run(function, batch, n_jobs):
                del left[place]
                yield place, value
        except Exception as error:
            if not _died(error):
                raise
            deaths += 1
            if not alone:
                continue
            place, point = batch[0]
            if place in suspects:
                raise RuntimeError(
                    f"point {place}, {point!r}, kills its worker, again "
                    "and alone: run the function on it in this process"
                ) from error
            suspects.add(place)


def _run(function, batch, n_jobs):
    def call(place, point):  # pickled by value: no import of the package
        try:
            return place, function(point)
        except Exception as error:
            error.add_note(f"at point {place} of the sweep: {point!r}")
            raise

    backend, around = get_active_backend()
    n_jobs = around if n_jobs is None else n_jobs
    local = backend.supports_inner_max_num_threads  # joblib's own: loky
    if local and n_jobs in (None, 1):
        yield from (call(*item) for item in batch)
        return
    with (
        parallel_config("loky", inner_max_num_threads=1) if local
        else nullcontext()
    ):
        yield from Parallel(
            n_jobs=n_jobs, batch_size=1, return_as="generator_unordered"
        )(delayed(call)(*item) for item in batch)


def _died(error):
    """Whether a worker died, here or on a Dask cluster."""
    return (
        isinstance(error, BrokenProcessPool)
        or type(error).__name__ == "KilledWorker"
    )
