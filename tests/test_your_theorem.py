"""Chapter 41, followed literally: two files outside the package, and pytest."""

import json
import os
import sys
from pathlib import Path

import nbformat
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm

import sosbook as sos
from sosbook.analysis.linear import loop_matrix
from sosbook.plants import descriptors
from tests.cases import campaign
from tests.energy_to_peak import PAGE, EnergyToPeak, file_of, true_peak
from tests.processes import process

ROOT = Path(__file__).parents[1]
FILE, TEST = "energy_to_peak.py", "test_energy_to_peak.py"


@pytest.fixture
def folder(tmp_path):
    """What a reader has who copied the marked cells."""
    (tmp_path / FILE).write_text(file_of(FILE), "utf-8")
    (tmp_path / TEST).write_text(
        f"from energy_to_peak import *\n\n\n{file_of(TEST)}", "utf-8"
    )
    return tmp_path


def run(folder, *words):
    """A fresh process in that folder, with the package but not the tests."""
    return process(
        sys.executable,
        *words,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        timeout=250,
    )


SLIPS = {
    "gust in the slack": [
        ("epsilon * c.Bw],", "0 * c.Bw],"),
        ("epsilon * c.Bw.T", "0 * c.Bw.T"),
    ],
    "sign of Theta": [("[[-he(c.Theta), c.Bw]", "[[he(c.Theta), c.Bw]")],
    "level": [("size = loop.level(self) *", "size = 2 * loop.level(self) *")],
    "cross": [("c.EPE - c.EVE + epsilon", "c.EPE - c.EVE - epsilon")],
}


PASS_AND_FAIL = f"""
import json, sys
import numpy as np
import pytest
status = pytest.main(["-q", "-p", "no:cacheprovider", "-p", "no:nbval", "{TEST}"])
assert status == 0, status
texts, tests = json.load(open("slips.json"))
for name, text in texts.items():
    space = {{"__name__": "energy_to_peak"}}
    exec(text + tests, space)
    for test in [test for test in space if test.startswith("test_")]:
        try:
            with np.errstate(invalid="ignore"):  # an unstable loop's truth
                space[test]()
        except (AssertionError, KeyError):  # it fails, or there is no design
            print(name)
            break
"""


SOONEST = "sign of Theta", "level"


@pytest.mark.slow
@pytest.mark.parametrize("slips", [SOONEST, *campaign([[*SLIPS]])])
def test_its_own_tests_pass_outside_the_package_and_notice_a_slip(slips, folder):
    """In a process of its own: a class made anew takes the place of the last one."""
    texts = {}
    for slip in slips:
        texts[slip] = file_of(FILE)
        for old, new in SLIPS[slip]:
            assert old in texts[slip]
            texts[slip] = texts[slip].replace(old, new)
    whole = json.dumps([texts, f"\n\n\n{file_of(TEST)}"])
    (folder / "slips.json").write_text(whole, "utf-8")
    done = run(folder, "-c", PASS_AND_FAIL)
    assert done.returncode == 0, done.stdout + done.stderr
    passed, *noticed = done.stdout.splitlines()[-1 - len(slips) :]
    assert "3 passed" in passed and noticed == [*slips]


def test_the_truth_by_integration_and_by_its_worst_gust():
    """Not by Lyapunov's equation: quadrature of the impulse response."""
    rng = np.random.default_rng(4)
    plant = sos.SecondOrderSystem(
        np.diag([1, 2]), 0.6 * np.eye(2), [[3, -1], [-1, 2]], np.eye(2),
        rng.normal(size=(2, 2)),
    )  # fmt: skip
    (d,), K = descriptors(plant), rng.normal(size=(2, 4)) / 5
    A, (_, _, B), C = loop_matrix(d, K), d.state_space(), d.C

    def entry(t, i, j):
        g = C @ expm(A * t) @ B
        return (g @ g.T)[i, j]

    W = [[quad(entry, 0, 200, (i, j), limit=800)[0] for j in (0, 1)] for i in (0, 1)]
    assert np.sqrt(np.linalg.eigvalsh(W)[-1]) == pytest.approx(
        true_peak(d, K), rel=1e-6
    )
    assert EnergyToPeak(1.0).truth([d, d], K) == true_peak(d, K)


def test_weights_of_the_input_count():
    """z = C x + D u: the inequality and the truth agree at the edge."""
    plant = sos.DescriptorSystem(
        np.eye(2), [[0, 1], [-1, -0.5]], [[0], [1]], [[0], [1]], [[1, 0], [0, 0]],
        [[0], [0.7]],
    )  # fmt: skip
    K = np.array([[-0.4, -0.8]])
    truth = true_peak(plant.vertices[0], K)
    for more in ({}, dict(coupling=("slack", 0.5))):
        for factor, good in ((1.01, True), (0.99, False)):
            found = sos.analyse_pid(
                plant, K, requirements=[EnergyToPeak(factor * truth)], **more
            )
            assert (found.status == "feasible") == good


@pytest.mark.parametrize(
    "peak, F, words",
    [
        (1.0, None, "peak needs a plant with F"),
        (-1.0, [[1]], "peak must be positive"),
        (None, [[1]], "peak is None: give a number, or let minimize=.peak. find it"),
    ],
)
def test_bad_input_is_named(peak, F, words):
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]], F)
    with pytest.raises(ValueError, match=words):
        sos.design_pid(plant, requirements=[EnergyToPeak(peak)])


def test_cells_are_short():
    for cell in nbformat.read(PAGE, 4).cells:
        if cell.cell_type == "code":
            assert len(cell.source.splitlines()) <= 15, cell.source
