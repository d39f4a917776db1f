"""The rows of chapter 4, against Riccati equations and the loop itself."""

import control
import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.book.reproduction import mip
from sosbook.pendulum import Mip, vertices
from tests.cases import by_hand

PRINT = thesis.mip()


def find(rows, item, place=""):
    (row,) = (r for r in rows if r.item == item and place in r.place)
    return row


def numbers(text):
    return [float(x) for x in text.replace(";", "").split()]


@pytest.mark.parametrize("law, vertex", [("PD", 0), ("PID", 3)])
@pytest.mark.parametrize("R", [1, 2, 5])
def test_the_tables_are_regulators_of_one_vertex(rows, law, vertex, R):
    plant = vertices(Mip.printed())[vertex].plant()
    A, B = by_hand(plant)
    if law == "PID":
        A, B = np.vstack([np.pad(A, ((0, 0), (0, 1))), np.eye(5)[1]]), np.vstack([B, 0])
    K = -control.lqr(A, B, np.eye(len(A)), [[R]])[0]
    row = find(rows, f"{law} gains, R = {R}")
    assert row.verdict == "reproduced"
    assert np.allclose(numbers(row.ours), K[0], atol=1e-4)
    robust = find(rows, f"{law} gains, R = {R}, by Theorem 2.4")
    assert robust.verdict == "claim refuted"
    assert numbers(robust.ours)[0] < 0.95 * K[0, 0]


def test_the_claims_of_robustness_are_proven(rows):
    found = [r for r in rows if "robustly stable" in r.item]
    assert len(found) == 8
    assert {r.verdict for r in found} == {"property holds"}


def test_theorem_2_4_with_the_printed_matrices(rows):
    """F = [1; 1] beside M = (a c - b^2) I; by independent code."""
    row = find(rows, "PD gains, R = 1, by Theorem 2.4")
    assert np.allclose(numbers(row.ours), [27.71, 0.716, 2.796, 1.147], rtol=3e-3)


def test_what_the_letters_determine():
    """Other masses and lengths give a to f too; the printed ones can't."""
    x, q = PRINT.letters, PRINT.ratios
    geared = x["c"] * q["e_c"] / q["e_a"]
    for M_b, l, M_w in mip.PARAMETER_SETS:
        a = mip.R_W**2 * (M_b + 2 * M_w) + geared
        assert f"{a:.3e}" in ("4.747e-04", "4.748e-04")
        assert abs(M_b * l * mip.R_W / x["b"] - 1) < 1e-3
    total = (x["a"][0] - geared) / mip.R_W**2
    assert total - 2 * PRINT.constants["M_w"] < 0
    product = x["b"] / mip.R_W
    assert x["c"] - product**2 / PRINT.constants["M_b"] < 0
    assert abs(product**2 / x["c"] - 0.123) < 1e-3  # least M_b
