"""A function over many points, in parallel, with the same result anyhow.

joblib does the work, so the same call runs in this process, in worker
processes, or on a Dask cluster::

    with joblib.parallel_config(backend="dask"):
        sweep(function, points)
"""

import sys
import warnings
from concurrent.futures.process import BrokenProcessPool
from contextlib import nullcontext

from ...runtime.libraries import library
from ...runtime.progress import bar


def sweep(function, points, n_jobs=None, progress=True, retries=3):
    """``[function(p) for p in points]``, the points in parallel.

    Parameters
    ----------
    function : callable
        A function of one point, without side effects, for a point may run
        again.
    points : iterable
        Where the function is called.
    n_jobs : int, optional
        Worker processes; -1 for one on each core. Left out, it is what
        a surrounding ``joblib.parallel_config`` says, or 1. Without
        joblib the points run one by one, with a warning.
    progress : bool
        Show a progress bar; see `sosbook.runtime.progress.bar`.
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
    Dask cluster its scheduler sees to that. It gives up a point that kills
    more workers than ``allowed-failures``, as often as there are retries.

    Examples
    --------
    >>> sweep(abs, [-3, 2, -1], progress=False)
    [3, 2, 1]
    """
    points = list(points)
    values = {}
    with bar(len(points), progress=progress) as done:
        for place, value in finished(function, points, n_jobs, retries):
            values[place] = value
            done.update()
    return [values[place] for place in range(len(points))]


def finished(function, points, n_jobs=None, retries=3):
    """Yield (place, value) of a function at points, as they are completed by ``n_jobs``
    workers, whose death is forgiven ``retries`` times: see `sweep`.
    """
    if n_jobs is not None and (not isinstance(n_jobs, int) or n_jobs == 0):
        raise ValueError(
            f"n_jobs = {n_jobs!r} must be a whole number: 1 or more "
            "workers, or -1 for one on each core"
        )
    waiting, deaths, suspects = dict(enumerate(points)), 0, set()
    while waiting:
        alone = deaths >= retries
        batch = list(waiting.items())[: 1 if alone else None]
        try:
            for place, value in _run(function, batch, n_jobs):
                del waiting[place]
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
    """Yield (place, result) of the points of a ``batch``."""

    def call(place, point):  # pickled by value: no import of the package
        try:
            return place, function(point)
        except Exception as error:
            error.add_note(f"at point {place} of the sweep: {point!r}")
            raise

    if _without_joblib(n_jobs):
        yield from (call(*item) for item in batch)
        return
    joblib = library("joblib")
    backend, around = joblib.parallel.get_active_backend()
    if hasattr(backend, "client"):
        yield from _on_cluster(backend.client, call, batch)
        return
    n_jobs = around if n_jobs is None else n_jobs
    local = backend.supports_inner_max_num_threads  # joblib's own: loky
    if local and n_jobs in (None, 1):
        yield from (call(*item) for item in batch)
        return
    config = joblib.parallel_config  # acts when it is made
    how = dict(batch_size=1, return_as="generator_unordered")
    with config("loky", inner_max_num_threads=1) if local else nullcontext():
        workers = joblib.Parallel(n_jobs=n_jobs, **how)
        yield from workers(joblib.delayed(call)(*item) for item in batch)


def _on_cluster(client, call, batch):
    """The results of a Dask cluster; joblib isn't told of points that it gives up."""
    as_completed = library("distributed").as_completed
    futures = [client.submit(call, *item, pure=False) for item in batch]
    try:
        for future in as_completed(futures):
            yield future.result()
    finally:
        client.cancel(futures)


def _without_joblib(n_jobs):
    """True if the points run here, one after another, for want of joblib."""
    if sys.modules.get("joblib"):  # a parallel_config may say something
        return False
    if n_jobs in (None, 1):
        return True
    try:
        library("joblib")
    except ModuleNotFoundError as error:
        warnings.warn(f"{error}. The points run one by one.", stacklevel=2)
        return True
    return False


def _died(error):
    """True if a worker died, here or on a Dask cluster."""
    dead = type(error).__name__ == "KilledWorker"
    return dead or isinstance(error, BrokenProcessPool)
