"""Notches, leads and internal models as parts of a law."""

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import verdict as checker
from sosbook.laws import Filter, ShapedLaw

S = control.tf("s")


def roots(loop):
    return np.sort_complex(control.poles(loop))


def test_a_drive_behind_a_notch_has_the_poles_of_the_whole_loop():
    drive = sos.SecondOrderSystem(1, 1.2, 3600, 3600, F=[[1]])
    notch, lead = Filter.notch(60, 0.05, 0.5), Filter.lead(30, 300)
    law = ShapedLaw(sos.PIDLaw(position=[[1]], integrate=True), [notch, lead])
    d = sos.design_pid(drive, law=law, region=sos.PoleRegion(sigma=0.9))
    assert d.certify().proven and checker.check(d.certify().text)
    P, I = (d.gains[x].item() for x in ("K_P", "K_I"))
    shaped = (S**2 + 6 * S + 3600) / (S**2 + 60 * S + 3600) * (S / 30 + 1)
    plant = 3600 / (S**2 + 1.2 * S + 3600)
    loop = control.feedback(-plant * shaped / (S / 300 + 1) * (P + I / S), 1)
    mine = np.sort_complex(d.poles())
    for s in mine:  # feedback keeps what cancels
        assert abs(roots(loop) - s).min() < 1e-4 * abs(s)
    s = 17.3j
    seen = control.evalfr(d.loop.to_ss(), s)
    wanted = control.evalfr(shaped / (S / 300 + 1) * (P + I / S), s)
    assert abs(seen - wanted) < 1e-6 * abs(wanted)


def test_ramps_and_sines_leave_no_error():
    mass = sos.SecondOrderSystem(0.3, 0.1, 9.81, 1, F=[[1]])
    inner = sos.PIDLaw(position=[[1]], integrate=True, filter=0.02)
    law = ShapedLaw(inner, ramp=True, sines=[3.0])
    d = sos.design_pid(mass, law=law, region=sos.PoleRegion(sigma=0.3))
    assert d.certify().proven and d.gains["K_R"].shape == (1, 3)
    c = d.loop.to_ss()
    plant = control.ss([[0, 1], [-32.7, -1 / 3]], [[0], [1 / 0.3]], [[1, 0]], 0)
    pushed = control.feedback(plant, control.ss(c.A, c.B, c.C, c.D), sign=1)
    assert roots(pushed).real.max() < -0.3
    for s in (3j, 1e-4):  # a sine; and a ramp w = t, whose error is T(0) / s
        assert abs(control.evalfr(pushed, s)) < 1e-6
    assert abs(control.evalfr(pushed, 2.7j)) > 1e-3
    program = d.controller(T=1e-3)
    assert program.certify().proven and program.radius < 1
    assert d.loop.late(1e-3).prove().proven


def test_a_dynamic_law_behind_a_resonance():
    mass = sos.SecondOrderSystem(0.3, 0.1, 9.81, 1)
    law = ShapedLaw(sos.DynamicLaw(1, position=[[1]]), [Filter.resonance(6, 0.5)])
    d = sos.design_pid(mass, law=law, region=sos.PoleRegion(sigma=0.3))
    assert d.certify().proven
    c = d.loop.to_ss()
    assert c.nstates == 3
    parts = [d.gains[x].item() for x in ("A_c", "B_c", "C_c")]
    a, b, k = parts
    wanted = 36 / (S**2 + 6 * S + 36) * (k * b / (S - a))
    assert abs(control.evalfr(c, 2j) - control.evalfr(wanted, 2j)) < 1e-6


def test_bad_filters_and_laws_are_refused():
    inner = sos.PIDLaw(position=[[1]])
    mass = sos.SecondOrderSystem(1, 1, 1, 1)
    for made, words in (
        (lambda: ShapedLaw(inner), "give through"),
        (lambda: ShapedLaw(sos.laws.FullState(), [Filter.lead(1, 2)]), "PIDLaw"),
        (lambda: ShapedLaw(inner, ["notch"]), "Filter"),
        (lambda: Filter([1.0], [1.0, -1.0], "x"), "stable"),
        (lambda: Filter([1.0, 0, 0], [1.0, 1.0], "x"), "highest power"),
        (
            lambda: sos.design_pid(mass, law=ShapedLaw(inner, ramp=True)),
            "integrate=True",
        ),
        (
            lambda: sos.design_pid(
                sos.DescriptorSystem(1, 0.5, 1, dt=0.1),
                law=ShapedLaw(inner, [Filter.lead(1, 2)]),
            ),
            "discrete time",
        ),
    ):
        with pytest.raises(ValueError, match=words):
            made()


@pytest.mark.parametrize(
    "form, free", [("diagonal", 10), ([["a", "b"], ["b", "c"]], 15), (None, 20)]
)
def test_models_keep_the_structure_of_the_law(form, free):
    """A decentralised law had gains across by its ramps and sines; here are two axes
    that are hardly damped, and neither symmetric.
    """
    M = np.diag([9.81, 0.3])
    D, stiff = np.array([[0.03, -0.02], [0.01, 0.01]]), np.array([[30, -3], [-2, 3.0]])
    plant = sos.SecondOrderSystem(M, D, stiff, np.eye(2))
    inner = sos.PIDLaw(position=np.eye(2), integrate=True, filter=0.05, structure=form)
    law = ShapedLaw(inner, ramp=True, sines=[1.0, 2.0])
    *_, models = law.structure(plant).blocks
    assert models.name == "K_R" and len(models.shares) == free
    numbers = np.random.default_rng(4).normal(size=free)
    K_R = np.tensordot(numbers, models.shares, 1)
    one = np.array([[-3.0, 0], [0, -2.0]])
    gains = {"K_P": one, "K_D": one, "K_I": one, "K_R": K_R}
    for part in np.split(K_R, 5, axis=1):  # the ramp; sine and cosine of each frequency
        assert (np.diag(np.diag(part)) == part).all() == (form == "diagonal")
        assert (part.T == part).all() == (form is not None)
    d = sos.analyse_pid(plant, gains, law=law)
    for s in (0.3 + 0.7j, 1.7j):  # det(M s^2 + D s + S - k), and the poles of k
        k = one * (1 + s / (0.05 * s + 1) + 1 / s) + K_R[:, :2] / s**2
        own = s**4 * (s + 20) ** 2
        for w, part in zip((1.0, 2.0), np.split(K_R[:, 2:], 2, axis=1)):
            k = k + (part[:, :2] * s - part[:, 2:] * w) / (s**2 + w**2)
            own *= (s**2 + w**2) ** 2
        own *= np.linalg.det(M * s**2 + D * s + stiff - k)
        assert abs(np.prod(s - d.poles()) * np.linalg.det(M) - own) < 1e-8 * abs(own)
    wrong = K_R.copy()
    wrong[0, 1] += 1
    if form is not None:
        with pytest.raises(ValueError, match="structure allows"):
            sos.analyse_pid(plant, gains | {"K_R": wrong}, law=law)


def test_limits_name_the_gain_of_the_models_where_there_are_some():
    plant = sos.SecondOrderSystem(
        [[0.9, 0.1], [0.1, 0.33]], [[0.02, 0.05], [-0.05, 0.01]],
        [[9.81, -2], [-1, 3.2]], [[1, 0.2], [0, 0.7]],
    )  # fmt: skip
    inner = sos.PIDLaw(position=np.eye(2), filter=0.02, limits={"K_R": 0.6, "K_P": 30})
    asked = dict(region=sos.PoleRegion(sigma=0.01))
    d = sos.design_pid(plant, law=ShapedLaw(inner, sines=[2.3]), **asked)
    assert d.certify().proven and abs(d.gains["K_R"]).max() <= 0.6
    assert abs(d.gains["K_P"]).max() <= 30
    for law in (inner, ShapedLaw(inner, [Filter.lead(1, 2)])):  # without models
        with pytest.raises(ValueError, match="no gain 'K_R'"):
            sos.design_pid(plant, law=law, **asked)
