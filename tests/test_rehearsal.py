"""The rehearsal's noise: what it keeps, that it is there, and where it goes."""

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from scipy.linalg.lapack import dpotrf

from tests.processes import process
from tests.rehearsal import __main__ as rehearsal
from tests.rehearsal import sitecustomize as noise
from tests.rehearsal import worlds

RNG = np.random.default_rng(8)
A = RNG.normal(size=(6, 6))
P = A @ A.T + np.eye(6)
PROGRAM = """
import json, pickle, numpy, scipy.linalg
from scipy.linalg.lapack import dpotrf
A = numpy.array([[2.0, 1.0], [1.0, 3.0]])
assert pickle.loads(pickle.dumps(scipy.linalg.expm)) is scipy.linalg.expm
results = [numpy.linalg.solve(A, A[0] / 3), numpy.roots([1, 2, 5.5]).imag,
           scipy.linalg.expm(A), dpotrf(A)[0]]
print(json.dumps([result.tolist() for result in results]))
"""


def shaken(function, *args, seed=1, **keywords):
    return noise.noisy(function, "tests", function.__name__, seed)(*args, **keywords)


@pytest.mark.parametrize(
    "function, args",
    [
        (np.linalg.solve, (A, P)),
        (np.linalg.cholesky, (P,)),
        (np.linalg.qr, (A,)),
        (np.linalg.svd, (A,)),
        (np.linalg.eig, (A,)),
        (np.linalg.eigh, (P,)),
        (np.linalg.lstsq, (A, P[0])),
        (np.linalg.det, (A,)),
        (np.linalg.slogdet, (A,)),
        (scipy.linalg.expm, (A,)),
        (scipy.linalg.lu, (A,)),
        (scipy.linalg.ldl, (P,)),
        (scipy.linalg.schur, (A, "real")),
        (scipy.linalg.cho_factor, (P,)),
        (scipy.linalg.solve_continuous_lyapunov, (A, P)),
        (dpotrf, (P,)),
    ],
)
def test_every_number_moves_a_little_and_structure_stays(function, args):
    before = function(*args)
    after = shaken(function, *args)
    assert type(after) is type(before)
    pairs = zip(before, after) if isinstance(before, tuple) else [(before, after)]
    moved = 0
    for old, new in pairs:
        assert type(new) is type(old)
        old, new = np.asarray(old), np.asarray(new)
        assert new.dtype == old.dtype and new.shape == old.shape
        assert new.flags.f_contiguous == old.flags.f_contiguous
        assert new.flags.writeable == old.flags.writeable
        if old.dtype.kind not in "fc":
            assert np.array_equal(new, old)
            continue
        for one, other in ((old.real, new.real), (old.imag, new.imag)):
            kept = (one == 0) | (abs(one) == 1)
            assert np.array_equal(one[kept], other[kept])
            assert np.all(abs(other - one) <= 1.001 * noise.SIZE * abs(one))
            assert np.all(other[~kept] != one[~kept])
            moved += (~kept).sum()
    assert moved


def environment(**extra):
    clean = {k: v for k, v in os.environ.items() if k != noise.SEED}
    return clean | {"PYTHONPATH": str(Path(noise.__file__).parent)} | extra


def printed(**extra):
    done = process(sys.executable, "-c", PROGRAM, env=environment(**extra), check=True)
    return json.loads(done.stdout)


def differ(one, other):
    """All parts differ, by rounding errors."""
    for x, y in zip(map(np.array, one), map(np.array, other)):
        assert np.any(x != y) and np.allclose(x, y, rtol=1e-12, atol=0)


def test_the_noise_reaches_a_new_process(capsys):
    exec(PROGRAM, {})  # here
    quiet = json.loads(capsys.readouterr().out)
    first = printed(**{noise.SEED: "1"})
    assert first == printed(**{noise.SEED: "1"})
    differ(quiet, first)
    differ(first, printed(**{noise.SEED: "2"}))


@pytest.mark.slow
def test_the_noise_reaches_a_kernel_and_a_worker():
    from jupyter_client.manager import run_kernel

    code = "from joblib import Parallel, delayed, numpy_pickle\n"
    code += "import subprocess, sys, numpy\nworkers = Parallel(2)\n"
    code += "A = numpy.array([[2.0, 1.0], [1.0, 3.0]])\n"
    code += "print(float(numpy.linalg.det(A)).hex(), *(float(x).hex() for x in "
    code += "workers(delayed(numpy.linalg.det)(A) for _ in range(2))))"
    texts = []
    with run_kernel(
        kernel_name="python3", env=environment(**{noise.SEED: "1"})
    ) as client:
        client.execute_interactive(
            code,
            timeout=60,
            output_hook=lambda m: texts.append(m["content"].get("text", "")),
        )
    A = np.array([[2.0, 1.0], [1.0, 3.0]])
    wanted = float(shaken(np.linalg.det, A)).hex()
    assert wanted != float(np.linalg.det(A)).hex()
    assert "".join(texts).split() == 3 * [wanted]


def test_a_world_is_chosen_by_name_or_kind():
    assert [w.name for w in worlds.choose(["noise"], [1, 4])] == ["noise-1", "noise-4"]
    (one,) = worlds.choose(["noise-2"])
    assert one.environment()[noise.SEED] == "2"
    assert one.environment()["PYTHONPATH"].startswith(str(Path(noise.__file__).parent))


@pytest.mark.campaign
def test_other_kernels_and_narrow_vectors_are_really_in_use():
    usual = worlds.probe(worlds.World("usual", "usual", {}))
    kernels = [worlds.probe(world)[0] for world in worlds.kernels()]
    assert usual[0] not in kernels
    assert len({*map(tuple, kernels)}) == len(kernels)
    for world in worlds.simd():
        assert set(worlds.probe(world)[1]) < set(usual[1])


REPORT = """<testsuites><testsuite>
<testcase classname="book.01_a.ipynb" name="Cell 0"/>
<testcase classname="book.01_a.ipynb" name="Cell 1"><failure message="x"/></testcase>
<testcase classname="book.01_a.ipynb" name="Cell 2"><error message="x"/></testcase>
<testcase classname="tests.test_b" name="test_c"><skipped message="x"/></testcase>
<testcase classname="tests.test_b" name="test_d"/>
</testsuite></testsuites>"""


def test_a_report_says_what_failed_where(tmp_path):
    report = tmp_path / "report.xml"
    report.write_text(REPORT, "utf-8")
    bad = rehearsal.read(report)
    assert bad == {
        "book.01_a.ipynb": {"Cell 0": True, "Cell 1": False, "Cell 2": False},
        "tests.test_b": {"test_d": True},
    }
    good = {"book.01_a.ipynb": {f"Cell {k}": True for k in range(3)}}
    words = rehearsal.failures({"noise-1": bad, "Haswell": good})
    assert "01_a  Cell 1:  noise-1" in words and "Cell 0" not in words
    assert "Nothing depends" in rehearsal.failures({"Haswell": good})


UNITS = "not book and not browser and not live"


@pytest.mark.parametrize("status, exit_status", [(0, 0), (1, 1), (3, 1)])
def test_the_exit_status_tells_of_failures_and_of_a_broken_pytest(
    monkeypatch, capsys, status, exit_status
):
    ran = []

    def run(world, name, words, processes):
        ran.append((world.name, name, words))
        return status, {"tests.test_b": {"test_d": status != 1}}

    monkeypatch.setattr(rehearsal, "run", run)
    assert rehearsal.main(["--worlds", "noise-1", "--unit", "--", "03"]) == exit_status
    assert ran == [
        ("noise-1", "notebooks", ["--nbval", "book/03_lmis.ipynb"]),
        ("noise-1", "unit", ["-m", f"{UNITS} and not last_digits", "tests", "sosbook"]),
    ]
    assert ("pytest itself failed" in capsys.readouterr().out) == (status == 3)
    assert rehearsal.lanes(rehearsal.arguments(["--only-unit"]), "kernels") == {
        "unit": ["-m", UNITS, "tests", "sosbook"]
    }
    with pytest.raises(SystemExit, match="no notebook's name starts with 99"):
        rehearsal.main(["--worlds", "noise", "--", "99"])
