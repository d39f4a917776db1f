"""What isn't installed is named with its cure; BLAS has one thread in a solve."""

import os
import sys
import threading
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg  # noqa: F401  (brings its own BLAS)
import threadpoolctl

import sosbook as sos
from sosbook.runtime import libraries, progress, threads
from sosbook.runtime.reading import read_bytes, read_json
from sosbook.runtime.writing import write_file
from sosbook.studies import maps
from tests.closed import analyse_loop
from tests.processes import process

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
PLANT = sos.SecondOrderSystem([[1]], [[1]], [[2]], [[1]], [[1]])


def absent(monkeypatch, *names):
    """As if these libraries weren't installed."""
    for name in list(sys.modules):
        if name.partition(".")[0] in names:
            monkeypatch.delitem(sys.modules, name)
    for name in names:
        monkeypatch.setitem(sys.modules, name, None)


@pytest.mark.parametrize(
    "name, extra", [(n, extra) for extra, ns in libraries.EXTRAS.items() for n in ns]
)
def test_a_missing_library_names_the_command_that_installs_it(name, extra, monkeypatch):
    absent(monkeypatch, name)
    with pytest.raises(ModuleNotFoundError) as caught:
        libraries.library(name)
    assert f'pip install "sosbook[{extra}]"' in str(caught.value)
    assert caught.value.name == name


def test_each_extra_exists_and_installs_what_it_says():
    packages = {"IPython": "ipython"}
    extras = PROJECT["optional-dependencies"]
    for extra, names in libraries.EXTRAS.items():
        wanted = " ".join(extras[extra])
        assert all(packages.get(name, name) in wanted for name in names), extra
    every = " ".join(extras["all"])
    assert all(f"sosbook[{extra}]" in every for extra in extras if extra != "all")


def test_what_a_library_misses_is_not_blamed_on_the_library(monkeypatch, tmp_path):
    (tmp_path / "half_installed.py").write_text("import no_such_thing\n", "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="No module named 'no_such_thing'"):
        libraries.library("half_installed")
    with pytest.raises(ModuleNotFoundError, match='pip install "no_such_thing"'):
        libraries.library("no_such_thing")


def test_without_joblib_the_points_run_one_by_one_and_it_says_so(monkeypatch):
    absent(monkeypatch, "joblib")
    monkeypatch.delitem(sys.modules, "joblib")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert maps.sweep(abs, [-2, 1], progress=False) == [2, 1]
    absent(monkeypatch, "joblib")
    with pytest.warns(UserWarning, match=r"sosbook\[parallel\].* one by one"):
        assert maps.sweep(abs, [-2, 1], n_jobs=2, progress=False) == [2, 1]


def test_without_tqdm_nothing_is_shown_and_nothing_fails(monkeypatch, capsys):
    monkeypatch.delenv("TQDM_DISABLE", raising=False)
    assert list(progress.each("ab", "letter")) == ["a", "b"]
    assert "0/2" in capsys.readouterr().err, "with tqdm there is a bar"
    absent(monkeypatch, "tqdm")
    assert list(progress.each("ab", "letter")) == ["a", "b"]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize("value", ["1", "0", ""])
def test_one_variable_hides_every_bar(value, monkeypatch, capsys):
    monkeypatch.setenv("TQDM_DISABLE", value)
    assert list(progress.each(range(3))) == [0, 1, 2]
    assert capsys.readouterr().err == ""


# Threads


@pytest.fixture(params=["threadpoolctl", "OpenBLAS itself"])
def two(request, monkeypatch):
    """A process whose BLAS libraries have two threads each; counts them."""
    if request.param == "threadpoolctl":
        monkeypatch.setattr(threads, "_openblas", lambda: [])
    elif not threads._openblas():
        pytest.skip("numpy and scipy here carry no OpenBLAS")

    def counts():
        pools = threadpoolctl.threadpool_info()
        return {p["num_threads"] for p in pools if p["user_api"] == "blas"}

    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        if counts() != {2}:
            pytest.skip("BLAS here has no threads to count")
        yield counts


def test_a_block_has_one_thread_and_gives_the_others_back(two):
    with threads.one_thread:
        assert two() == {1}
        with threads.one_thread:
            assert two() == {1}
        assert two() == {1}
    assert two() == {2}
    with pytest.raises(ZeroDivisionError), threads.one_thread:
        1 / 0
    assert two() == {2}


@pytest.mark.parametrize("two", ["OpenBLAS itself"], indirect=True)
def test_blocks_of_several_threads_may_overlap(two):
    entered, leave = threading.Event(), threading.Event()

    def long():
        with threads.one_thread:
            entered.set()
            leave.wait(10)

    other = threading.Thread(target=long)
    with threads.one_thread:
        other.start()
        entered.wait(10)
    assert two() == {1}  # the other one is still inside
    leave.set()
    other.join()
    assert two() == {2}


LIGHT = sos.SecondOrderSystem(np.diag([2, 0]), np.eye(2), np.eye(2), np.eye(2))
Q, R = np.eye(2), np.eye(1)
FREE = sos.SecondOrderSystem([[1]], [[1]], [[0]], [[1]])
AXIS = sos.analyse_pid(FREE, [[-1, -1]]).controller(T=0.1, counts=500)
DOORS = {
    "design_pid": lambda: sos.design_pid(PLANT),
    "analyse_pid": lambda: sos.analyse_pid(PLANT, [[-1, -1]]),
    "analyse_loop": lambda: analyse_loop(np.eye(1), [[-1.0]]),
    "design_lqr": lambda: sos.design_lqr(PLANT, Q, R),
    "design_observer": lambda: sos.design_observer(PLANT, [[-1, -1]], np.eye(4), R),
    "design_delay_pid": lambda: sos.design_delay_pid(
        PLANT, tau=0.04, mu=0.02, delta=0.2
    ),
    "design_sampled_lqr": lambda: sos.design_sampled_lqr(PLANT, Q, R, 0.1),
    "certify_sampled": lambda: sos.certify_sampled(PLANT, [[-1, -1]], 0.1),
    "regularize": lambda: sos.regularize(LIGHT),
    "furthest_sampled": lambda: sos.furthest_sampled(
        PLANT, [[-1, -1]], T=(0.01, 0.1), tolerance=0.3
    ),
    "bounds.noise": lambda: AXIS.bounds.noise(),
    "bounds.step_response": lambda: AXIS.bounds.step_response(),
    "margins": lambda: AXIS.margins(0, 0.2),
}


@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS)
def test_a_design_factors_with_one_thread(door, two, monkeypatch):
    seen = []

    def watched(function):
        def call(*words, **more):
            seen.append(two())
            return function(*words, **more)

        return call

    door()  # imports what it needs
    for name in ("cholesky", "eigh", "eigvalsh", "inv", "solve"):
        monkeypatch.setattr(np.linalg, name, watched(getattr(np.linalg, name)))
    door()
    assert seen and all(s == {1} for s in seen)
    assert two() == {2}


def test_a_process_of_one_thread_says_so_before_numpy():
    assert set(threads.ONE_THREAD.values()) == {"1"}
    code = (
        "import os, sys; from sosbook.runtime.threads import ONE_THREAD; "
        "assert 'numpy' not in sys.modules; os.environ.update(ONE_THREAD); "
        "import numpy, threadpoolctl; "
        "print({p['num_threads'] for p in threadpoolctl.threadpool_info()})"
    )
    free = {k: v for k, v in os.environ.items() if k not in threads.ONE_THREAD}
    done = process(sys.executable, "-c", code, check=True, env=free)
    assert done.stdout.strip() == "{1}"


def test_a_folder_in_the_place_of_a_file_is_named(tmp_path):
    for ask in (read_bytes, read_json, lambda path: write_file(path, "text")):
        with pytest.raises(IsADirectoryError, match="is a folder: give the name"):
            ask(tmp_path)
