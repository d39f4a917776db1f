"""The best known values of the book: proven, not false, and not beaten."""

import pytest

from sosbook import reproduction
from sosbook.book import ledger, thesis
from sosbook.delay import analyse_delay, delayed_loop, spectral_abscissa
from sosbook.delay.forms import FORMS
from sosbook.plants.descriptor import descriptors

STEP = 1e-4  # of the ledger's last digit, in s
#: Every method of the package, a new one too, with its first orders.
WAYS = [
    pytest.param(
        method,
        order,
        marks=[] if form.first_order else pytest.mark.slow,
        id=method + (f" {order}" if order is not None else ""),
    )
    for method, form in FORMS.items()
    for order in (list(form.orders)[:3] if hasattr(form, "orders") else [None])
]


@pytest.fixture(scope="module")
def wing():
    return thesis.delay_example_1(published=True)


@pytest.mark.parametrize("rate", ledger.RATES)
@pytest.mark.parametrize("method, order", WAYS)
def test_no_method_proves_more_for_the_wing(wing, rate, method, order):
    wider = round(ledger.wing(rate).proven + STEP, 4)
    answer = analyse_delay(
        wing.plant, wing.K, wing.U, wing.tau, wider, rate, method=method, order=order
    )
    assert answer.status != "feasible"


@pytest.mark.parametrize("rate", ledger.RATES)
def test_the_wings_values_are_bracketed_by_the_truth(wing, rate):
    found = ledger.wing(rate)
    again = analyse_delay(
        wing.plant, wing.K, wing.U, wing.tau, found.proven, rate, **ledger.SHARPEST
    )
    assert again.certify().proven
    (plant,) = descriptors(wing.plant, wing.U)
    loop = delayed_loop(plant, wing.K)
    assert -spectral_abscissa(*loop, wing.tau + found.false) < rate
    assert -spectral_abscissa(*loop, wing.tau + found.false - 2e-5) > rate
    assert found.proven < found.false
    assert found.share == found.proven / found.false


def test_the_erratum_says_what_the_ledger_says(wing):
    (erratum,) = (e for e in reproduction.errata() if e.place == "Example 1 with delay")
    best = ledger.wing(wing.delta)
    assert f"proven for mu = {best.proven / best.tau:.3f} tau" in erratum.correct
    assert f"false for mu above {best.false / best.tau:.3f} tau" in erratum.correct
    assert f"mu = {best.proven} s" in erratum.evidence
