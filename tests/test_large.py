"""Large requests: no dense matrix of all variables, in time or in memory."""

import os
import subprocess
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from sosbook.lmi import Unknown, he
from sosbook.lmi.blocks import Blocks
from sosbook.lmi.bounded import any_centre, bounded
from sosbook.lmi.centre import centre

FREE_CHAIN = """
import resource, sys
import numpy as np
import sosbook as sos

n = int(sys.argv[1])
links = np.diff(np.eye(n), axis=0)
S = links.T @ links + 0.1 * np.eye(n)
B = np.eye(n)[:, :: 4]
plant = sos.SecondOrderSystem(np.eye(n), 0.02 * S, S, B)
region = sos.PoleRegion(0.1, np.radians(75), 8)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
design = sos.design_pid(plant, U=B.T, region=region)
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
unit = 1 if sys.platform == "darwin" else 1024
assert design.status == "feasible", design.reason
print((after - before) * unit)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs the module resource")
def test_an_unbounded_request_of_60_states_needs_no_dense_matrix():
    """One slope a variable as a dense matrix would take 600 MB."""
    command = [sys.executable, "-c", FREE_CHAIN, "30"]
    ran = subprocess.run(
        command, capture_output=True, encoding="utf-8", check=True, env=os.environ
    )
    assert int(ran.stdout) < 150e6


def lyapunov(A):
    P = Unknown("P", len(A), symmetric=True)
    return Blocks.of([P, -he(A @ P)], [P]), P


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e6])
def test_the_lid_of_a_cone_holds_a_multiple_of_any_point(length, monkeypatch):
    """No phase one: it would begin anew."""
    monkeypatch.setattr("sosbook.lmi.bounded.phase_one", None)
    A = np.array([[0.0, 1.0], [-2.0, -1.0]])
    blocks, P = lyapunov(A)
    X = np.array([[1.0, -0.3], [-0.3, 1.5]])
    x = length * P.pack(X)
    joined, inside = bounded(blocks, [P], x)
    assert all(np.linalg.eigvalsh(g)[0] > 0 for g in joined(inside))
    assert_allclose(inside * np.linalg.norm(x), x * np.linalg.norm(inside))
    found = any_centre(blocks, [P], x)
    assert_allclose(found, centre(joined, inside), rtol=1e-6)
