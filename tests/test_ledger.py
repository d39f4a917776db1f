"""The best known values of the book: proven, not false, and not beaten."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

from sosbook.book import ledger, thesis
from sosbook.delay import DelayRequest, delayed_loop, solve_delay, spectral_abscissa
from sosbook.delay.forms import FORMS
from sosbook.plants.descriptor import descriptors
from tests.cases import CAMPAIGN, campaign

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

QUICK = [  # the slowest is asked of the wing in the campaign, of the masses always
    pytest.param(
        *way.values,
        marks=[*way.marks, *[pytest.mark.campaign] * (way.id == "functional")],
        id=way.id,
    )
    for way in WAYS
]


PAGE = Path(__file__).parents[1] / "book" / "reproduction.ipynb"


@pytest.fixture(scope="module", autouse=True)
def best_of_the_page():
    """In the gate the page of the ledger searches what is proven, and shows it; the
    campaign searches it here, too.
    """

    def shown(name, ex, true, **asked):
        row = "two masses: rate" if name == "delta" else f"rate {asked['delta']}: mu"
        cells = rf"{row}</a></th><td>[^<]*</td><td>([\d.]+) "
        (value,) = re.findall(cells, PAGE.read_text("utf-8"))
        return float(value)

    with pytest.MonkeyPatch.context() as patched:
        if not os.environ.get(CAMPAIGN):
            patched.setattr(ledger, "_largest", shown)
        yield
    ledger.wing.cache_clear()
    ledger.masses.cache_clear()


@pytest.fixture(scope="module")
def wing():
    return thesis.delay_example_1(published=True)


def proven(ex, method, order, *asked):
    """Whether a form is found for its printed gain; why not isn't asked."""
    asked = dict(zip(("tau", "mu", "delta"), asked, strict=True))
    request = DelayRequest(
        ex.plant, ex.U, **asked, method=method, order=order, gain=ex.K
    )
    return solve_delay(request, refuse=False).status == "feasible"


@pytest.mark.parametrize("rate", [ledger.RATES[0], *campaign(ledger.RATES[1:])])
@pytest.mark.parametrize("method, order", QUICK)
def test_no_method_proves_more_for_the_wing(wing, rate, method, order):
    wider = round(ledger.wing(rate).proven + STEP, 4)
    assert not proven(wing, method, order, wing.tau, wider, rate)


@pytest.mark.parametrize("method, order", WAYS)
def test_no_method_proves_more_for_the_two_masses(method, order):
    ex = thesis.delay_example_2()
    faster = round(ledger.masses().proven + 10 * STEP, 3)
    assert not proven(ex, method, order, ex.tau, ex.mu, faster)


@pytest.mark.parametrize("rate", [ledger.RATES[0], *campaign(ledger.RATES[1:])])
def test_the_wings_values_are_bracketed_by_the_truth(wing, rate):
    best = ledger.wing(rate)
    (plant,) = descriptors(wing.plant, wing.U)
    loop = delayed_loop(plant, wing.K)
    assert -spectral_abscissa(*loop, wing.tau + best.false) < rate
    assert -spectral_abscissa(*loop, wing.tau + best.false - 2e-5) > rate
    assert best.share == best.proven / best.false < 1


def test_the_two_masses_are_as_slow_as_the_ledger_says():
    ex, best = thesis.delay_example_2(), ledger.masses()
    (plant,) = descriptors(ex.plant, ex.U)
    loop, taus = delayed_loop(plant, ex.K), np.linspace(0.2, 0.6, 41)
    rates = [-spectral_abscissa(*loop, tau) for tau in taus]
    assert (
        best.printed < best.proven < min(rates) == pytest.approx(best.false, abs=1e-3)
    )


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_norm_lies_between_a_sweep_and_its_proof(number):
    ex, best = getattr(thesis, f"example_{number}")(), ledger.norm(number)
    peak = 0.0
    for d in descriptors(ex.plant, ex.U, ex.K_A):
        E, A = np.asarray(d.E), d.A + d.Bu @ ex.K
        w = np.geomspace(1e-3, 1e3, 2001)[:, None, None]
        z = np.linalg.solve(1j * w * E - A, d.Bw + 0j)[:, : ex.plant.n]
        peak = max(peak, np.linalg.norm(z, 2, axis=(1, 2)).max())
    assert 0.999 * peak < best.false <= 1.001 * peak < best.proven < best.printed / 20


def test_the_errata_say_what_the_ledger_says(wing, errata):
    (erratum,) = (e for e in errata if e.place == "Example 1 with delay")
    best = ledger.wing(wing.delta)
    assert f"proven for mu = {best.proven / wing.tau:.3f} tau" in erratum.correct
    assert f"false for mu above {best.false / wing.tau:.3f} tau" in erratum.correct
    assert f"mu = {best.proven} s" in erratum.evidence
