"""The solver's steps are drawn when they are taken."""

import numpy as np
import pytest
from sosbook.widgets.steps import explore_steps

import sosbook as sos
from sosbook.solver import newton


def chain(n):
    T = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    plant = sos.SecondOrderSystem(
        np.eye(n), 0.2 * np.eye(n), np.eye(n) + T, np.eye(n)[:, ::2]
    )
    return plant, {
        "region": sos.PoleRegion(sigma=0.2, rho=5),
        "saturation": sos.Saturation(9, np.eye(2 * n)[0]),
    }


@pytest.fixture
def pages():
    """All pictures of an explorer, the last one at the end."""
    explorer, seen = explore_steps(chain, [4, 2]), []
    explorer.picture.observe(lambda change: seen.append(change.new), "value")
    explorer.sliders["masses"].value = 4
    return seen


def test_there_is_a_picture_for_each_step(pages):
    last = pages[-1]
    assert "at the centre" in last
    circles = [page.count("<circle") for page in pages]
    assert circles == sorted(circles) and circles[0] == 0
    assert set(circles) == set(range(circles[-1] + 1))
    assert f"<strong>{8 * 9 // 2 + 2 * 8}</strong> variables" in last


def test_bars_stand_for_the_products_of_conjugate_gradients(pages, monkeypatch):
    assert "<polygon" in pages[-1] and "a dense matrix" in pages[-1]
    monkeypatch.setattr(newton, "hessian_work", lambda stacked: np.inf)
    iterative = explore_steps(chain, [2, 4]).picture.value
    assert "with conjugate gradients" in iterative
    assert "no conjugate" not in iterative


def test_a_refusal_has_no_centre():
    def heavy(n):
        plant, asked = chain(n)
        return plant, asked | {
            "saturation": sos.Saturation(1e-3, 9 * np.eye(2 * n)[0]),
            "region": sos.PoleRegion(sigma=3),
        }

    assert "infeasible: no centre" in explore_steps(heavy, [2]).picture.value
