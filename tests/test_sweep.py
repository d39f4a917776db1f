"""One result, in any order, on any workers, also when one of them dies."""

import os
import random
import time
import warnings
from contextlib import suppress
from functools import partial

import joblib
import numpy as np
import pytest
from tqdm import tqdm

import sosbook as sos
from sosbook.studies import maps
from sosbook.studies.maps.parallel import sweep
from tests.cases import campaign

POINTS = [(k, 0.1 * k + 0.05) for k in range(9)]


# Functions inside functions travel by value: the workers of the tests don't
# import this module, nor the package.


def make_work():
    def work(point):
        """Some linear algebra; the early points take longest."""
        k, x = point
        time.sleep(0.02 * (9 - k) / 9)
        A = np.sin(np.arange(36.0).reshape(6, 6) + x) + 7 * np.eye(6)
        return np.linalg.solve(A, np.ones(6)).tobytes()

    return work


def make_deadly(folder, fatal):
    """Work that kills its process at the fatal points, the first time."""
    work = make_work()

    def deadly(point):
        flag = folder / str(point[0])
        if point[0] in fatal and not flag.exists():
            flag.touch()
            os._exit(1)
        return work(point)

    return deadly


def make_place():
    return lambda _: (os.environ.get("OPENBLAS_NUM_THREADS"), os.getpid())


work, place = make_work(), make_place()


@pytest.fixture(scope="module")
def serial():
    return [work(p) for p in POINTS]


def test_parallel_is_serial_in_the_order_of_the_points(serial):
    assert sweep(work, POINTS) == serial
    assert sweep(work, POINTS, n_jobs=2) == serial
    assert sweep(work, iter(POINTS), n_jobs=-1) == serial


def test_the_order_of_the_points_does_not_matter(serial):
    order = list(range(len(POINTS)))
    random.Random(1).shuffle(order)
    found = sweep(work, [POINTS[k] for k in order], n_jobs=2)
    assert found == [serial[k] for k in order]


def test_no_points_no_results():
    assert sweep(work, [], n_jobs=2) == []


def test_each_worker_has_one_blas_thread(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "4")
    found = sweep(place, range(4), n_jobs=3)  # a new pool: of three
    assert {count for count, _ in found} == {"1"}
    assert os.getpid() not in {process for _, process in found}


@pytest.mark.slow
def test_a_worker_that_dies_is_survived(serial, tmp_path):
    found = sweep(make_deadly(tmp_path, {4}), POINTS, n_jobs=2)
    assert found == serial
    assert [f.name for f in tmp_path.iterdir()] == ["4"]


@pytest.mark.slow
def test_a_point_that_always_kills_is_named():
    def fatal(k):
        return os._exit(1) if k == 7 else k

    with pytest.raises(RuntimeError, match=r"point 2, 7, kills its worker"):
        sweep(fatal, [5, 6, 7, 8], n_jobs=2, retries=1)


@pytest.mark.slow
@pytest.mark.parametrize("backend, n_jobs", [("loky", 1), ("loky", 2), ("dask", None)])
def test_an_exception_comes_back_with_its_point(request, backend, n_jobs):
    if backend == "dask":
        request.getfixturevalue("cluster")

    def fail(k):
        if k == 6:
            raise ZeroDivisionError("six")
        return k

    with (
        joblib.parallel_config(backend=backend),
        pytest.raises(ZeroDivisionError, match="six") as caught,
    ):
        sweep(fail, [4, 5, 6, 7], n_jobs=n_jobs)
    assert caught.value.__notes__ == ["at point 2 of the sweep: 6"]


@pytest.mark.parametrize("n_jobs", [0, 1.5, "2"])
def test_bad_n_jobs_is_named(n_jobs):
    with pytest.raises(ValueError, match="n_jobs"):
        sweep(work, POINTS, n_jobs=n_jobs)


def test_the_bar_counts_the_points(monkeypatch, capsys):
    monkeypatch.delenv("TQDM_DISABLE", raising=False)
    monkeypatch.setattr("tqdm.auto.tqdm", partial(tqdm, mininterval=0))
    sweep(abs, range(3))
    assert "3/3" in capsys.readouterr().err
    sweep(abs, range(3), progress=False)
    monkeypatch.setenv("TQDM_DISABLE", "1")
    sweep(abs, range(3))
    assert capsys.readouterr().err == ""


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        workers = distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
        )
        with distributed.Client(workers) as client:
            yield client
        # Its nannies start dead workers anew, and can't close while they do: they
        # fail to join a process that isn't there yet.
        with suppress(AssertionError, TimeoutError):
            workers.close()


@pytest.mark.slow
def test_the_same_call_runs_on_a_dask_cluster(cluster, serial):
    with joblib.parallel_config(backend="dask"):
        assert sweep(work, POINTS) == serial
        assert sweep(work, POINTS, n_jobs=2) == serial
        places = sweep(place, range(4))
    assert {count for count, _ in places} == {"1"}
    assert os.getpid() not in {process for _, process in places}


def make_load_case():
    def at_speed(speed):
        """A design for two modes of a rotor, looked at and proven on the whole."""
        import numpy as np

        import sosbook as sos

        turn = np.kron([[0, speed], [-speed, 0]], np.diag([0.01, 0.03]))
        stiff = np.diag([1.0, 400, 1.1, 440])
        plant = sos.SecondOrderSystem(
            np.eye(4), 0.02 * stiff + turn, stiff, np.eye(4)[:, [0, 2]]
        )
        region = sos.PoleRegion(0.1)
        design = sos.design_pid(
            plant.reduce(modes=2), region=region, search=sos.Search(prefer="least")
        )
        return design.check_on(plant).kept, design.certify(on=plant).proven

    return at_speed


@pytest.mark.campaign  # in the gate test_the_same_call_runs_on_a_dask_cluster does
def test_speeds_run_on_a_dask_cluster(cluster):
    at_speed, speeds = make_load_case(), [0.0, 3.0, 30.0]
    alone = [at_speed(speed) for speed in speeds]
    assert all(kept and proven for kept, proven in alone)
    with joblib.parallel_config(backend="dask"):
        assert sweep(at_speed, speeds) == alone


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", *campaign(["dask"])])
def test_a_point_has_its_own_time_limit(request, backend):
    """It is over in the worker, and the other points are none the worse."""
    if backend == "dask":
        request.getfixturevalue("cluster")

    def pushed(seconds):
        plant = sos.SecondOrderSystem(1, 0, 0, 1)
        edge = maps.edge(
            "rho",
            plant,
            region=sos.PoleRegion(sigma=1, rho=9),
            saturation=sos.Saturation(90, [1, 0]),
            digits=1,
            time_limit=seconds,
        )
        return edge.infeasible, edge.reason

    with joblib.parallel_config(backend=backend, n_jobs=2):
        (none, late), (radius, other) = sweep(pushed, [1e-6, 60.0])
    assert none is None and late == "stopped after 1e-06 s"
    assert radius == 1 and "stopped" not in other  # sigma = 1 leaves no room


@pytest.mark.campaign  # in the gate test_a_point_that_always_kills_is_named, by loky
def test_dask_names_a_point_that_always_kills(cluster, monkeypatch):
    monkeypatch.setattr(cluster.cluster.scheduler, "allowed_failures", 0)

    def fatal(k):
        return os._exit(1) if k == 7 else k

    with (
        joblib.parallel_config(backend="dask"),
        pytest.raises(RuntimeError, match=r"point 1, 7, kills its worker"),
    ):
        sweep(fatal, [5, 7, 8], retries=0)  # two deaths for two workers: none is new
