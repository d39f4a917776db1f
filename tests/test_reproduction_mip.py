"""The rows of chapter 4, against Riccati equations and the loop itself."""

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook.mip import V_MAX, Mip, vertices

PRINT = sos.thesis.mip()


def find(rows, item, place=""):
    (row,) = (r for r in rows if r.item == item and place in r.place)
    return row


def numbers(text):
    return [float(x) for x in text.replace(";", "").split()]


@pytest.mark.parametrize("law, vertex", [("PD", 0), ("PID", 3)])
@pytest.mark.parametrize("R", [1, 2, 5])
def test_the_tables_are_regulators_of_one_vertex(rows, law, vertex, R):
    plant = vertices(Mip.printed())[vertex].plant()
    N = 4 if law == "PD" else 5
    A, B = np.zeros((N, N)), np.zeros((N, 1))
    A[:2, 2:4] = np.eye(2)
    A[2:4, :4] = -np.linalg.solve(plant.M, np.hstack([plant.S, plant.D]))
    B[2:4] = np.linalg.solve(plant.M, plant.B)
    if law == "PID":
        A[4, 1] = 1
    K = -control.lqr(A, B, np.eye(N), [[R]])[0]
    row = find(rows, f"{law} gains, R = {R}")
    assert row.verdict == "reproduced"
    assert np.allclose(numbers(row.ours), K[0], atol=1e-4)
    robust = find(rows, f"{law} gains, R = {R}, by Theorem 2.4")
    assert robust.verdict == "differs"
    assert numbers(robust.ours)[0] < 0.95 * K[0, 0]


def test_the_claims_of_robustness_are_proven(rows):
    found = [r for r in rows if "robustly stable" in r.item]
    assert len(found) == 8
    assert {r.verdict for r in found} == {"property holds"}


@pytest.mark.parametrize("item, place, verdict", [
    ("the gain after the zero is moved", "(4.19)", "reproduced"),
    ("a to f", "4.2.2", "reproduced"),
    ("M of the four vertices", "(4.25)", "reproduced"),
    ("D of the four vertices", "(4.25)", "reproduced"),
    ("L, R = 1", "Table 4.3", "reproduced"),
    ("K, R = 2", "Table 4.3", "reproduced"),
    ("poles", "(4.28)", "reproduced"),
    ("gain and zeros from phi'", "(4.28)", "reproduced"),
    ("gains without the fast pole and zero", "(4.29)", "reproduced"),
    ("the controller at 100 Hz", "(4.30)", "reproduced"),
    ("values of R", "4.3.1", "differs"),
])
def test_verdicts(rows, item, place, verdict):
    assert find(rows, item, place).verdict == verdict


@pytest.mark.parametrize("law, table", [
    ("PD", PRINT.pd), ("PID", PRINT.pid)])
def test_the_first_instant_has_the_peak_of_the_voltage(rows, law, table):
    row = find(rows, f"{law}: the voltage stays below 7.4 V")
    for R, K in table.items():
        reach = np.degrees(V_MAX / K[0, 0])
        assert f"{reach:.0f}° for R = {R}" in row.ours


def test_where_the_wheels_end(rows):
    """In closed form, from the two equations of motion at rest."""
    row = find(rows, "PID keeps the wheels' position, PD lets it vary")
    ends = []
    for v in vertices(Mip.printed()):
        # rest: -d theta = -e V + w and 0 = e V + w
        theta, V = -2e-3 / v.d, -1e-3 / v.e
        K = PRINT.pd[5][0]
        ends.append(abs((V - K[0] * theta) / K[1]))
    assert f"{max(ends):.2f} rad away with PD, 0 with PID" in row.ours
