"""A measured frequency response, from its file into the band of a family."""

import sys
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.sparse

import sosbook as sos
from sosbook.book import plots
from sosbook.plants import MeasuredResponse
from tests.cases import crossed, later

OMEGA = np.geomspace(0.3, 30, 40)


def arm(m, k):
    """Two masses; the second is measured."""
    return sos.SecondOrderSystem(
        np.diag([9.81, m]),
        [[0.5, -0.2], [-0.2, 0.3]],
        [[2 * k, -k], [-k, k]],
        [[1], [0]],
    )


FAMILY = sos.Uncertain(arm, m=(0.3, 0.5), k=(20, 30))


def response(m, k, omega=OMEGA):
    """In closed form, by Cramer's rule."""
    s = 1j * omega
    a, b = 9.81 * s**2 + 0.5 * s + 2 * k, m * s**2 + 0.3 * s + k
    c = -0.2 * s - k
    return -c / (a * b - c * c)


def table(path, unit, omega, H):
    lines = [f"{w!r},{h.real!r},{h.imag!r}" for w, h in zip(omega.tolist(), H.tolist())]
    (path / "frf.csv").write_text("\n".join([f"{unit},re,im", *lines]), "utf-8")
    return path / "frf.csv"


@pytest.mark.parametrize("unit, turn", [("Hz", 2 * np.pi), *later(("rad/s", 1.0))])
def test_a_plant_of_the_family_lies_in_its_band(unit, turn, tmp_path):
    """On the grid every point does; one that is twice as stiff is outside."""
    path = table(tmp_path, unit, OMEGA / turn, response(0.4, 25.0))
    seen = MeasuredResponse.read(path)
    assert seen.omega == pytest.approx(OMEGA)
    found = seen.beside(FAMILY, sensor=1)
    assert found.plants.shape == (81, 40) and found.share == 1.0
    assert abs(found.plants - response(0.4, 25.0)).min(0).max() < 1e-12
    assert str(found) == "40 of 40 points lie within the band of 81 plants"
    off = MeasuredResponse(OMEGA, response(0.4, 50.0)).beside(FAMILY, sensor=[0, 1])
    assert off.share < 0.5 and "the furthest outside is at" in str(off)
    with plt.rc_context():
        axes = plots.frequency_band(plt.subplots(2)[1], off)
        counts = [len(line.get_xdata()) for line in axes[0].lines]
    plt.close("all")
    assert counts == [off.inside.sum(), (~off.inside).sum()]


def test_the_phase_counts_too():
    """Of the right size and with the other sign."""
    corners = sos.Polytope([arm(m, k) for m in (0.3, 0.5) for k in (20, 30)])
    wrong = MeasuredResponse(OMEGA[:9], -response(0.4, 25.0)[:9])
    assert wrong.beside(corners, sensor=1).share == 0
    right = MeasuredResponse(OMEGA[:9], response(0.4, 25.0)[:9])
    assert right.beside(corners, sensor=1).share == 1


@pytest.mark.parametrize(
    "text, words",
    [
        ("f,re,im\n1,2,3", "first line must be Hz,re,im or rad/s,re,im"),
        ("Hz,re,im\n1,2", "line 2 lacks a value"),
        ("Hz,re,im\n-1,2,1", "omega must be above 0"),
        ("", "first line must be"),
    ],
)
def test_a_table_that_is_none_is_named(text, words, tmp_path):
    (tmp_path / "frf.csv").write_text(text, "utf-8")
    with pytest.raises(ValueError, match=f"frf.csv: (its )?{words}"):
        MeasuredResponse.read(tmp_path / "frf.csv")


@pytest.mark.parametrize("sparse", [False, True])
def test_one_plant_is_a_line(sparse):
    """A response beside the model's: how far apart, and where; with a picture."""
    plant = arm(0.4, 25)
    if sparse:
        parts = [scipy.sparse.csc_array(getattr(plant, x)) for x in "MDS"]
        plant = sos.SecondOrderSystem(*parts, plant.B)
    H = response(0.4, 25.0) * (1 + 0.02 * np.cos(OMEGA))
    k = np.abs(np.cos(OMEGA)).argmax()
    found = MeasuredResponse(OMEGA, H).beside(plant, sensor=1)
    assert found.apart == pytest.approx(abs(0.02 * np.cos(OMEGA)), abs=1e-9)
    assert f"the furthest 2 % away, at {OMEGA[k]:.4g} rad/s" in str(found)
    with plt.rc_context():
        axes = plots.frequency_band(plt.subplots(2)[1], found)
    plt.close("all")
    assert len(axes[0].lines) == 2


def test_no_such_sensor_or_actuator():
    seen = MeasuredResponse(OMEGA, response(0.4, 25.0))
    for beside, words in ((dict(sensor=[1]), "sensor"), (dict(actuator=1), "actuator")):
        with pytest.raises(ValueError, match=words):
            seen.beside(FAMILY, **beside)


WRONGLY = {
    "as velocities": 1j * OMEGA,
    "as accelerations": -(OMEGA**2),
    "with the other sign": -1,
}


@pytest.mark.parametrize("name, plants", crossed(WRONGLY, [arm(0.4, 25), FAMILY]))
def test_what_was_measured_instead_is_named(name, plants):
    """And nothing is said of what is no such thing."""
    factor = WRONGLY[name]
    H, noise = response(0.4, 25.0), 1 + 0.01 * np.sin(31 * OMEGA)
    wrong = MeasuredResponse(OMEGA, H * factor * noise).beside(plants, sensor=1)
    assert f"; read {name} half of them" in str(wrong)
    for right in (H * noise, response(0.4, 90.0), H * np.exp(-0.05j * OMEGA)):
        found = MeasuredResponse(OMEGA, right).beside(plants, sensor=1)
        assert "; read" not in str(found)


def test_the_frequency_zero_is_left_out(tmp_path):
    path = table(tmp_path, "Hz", np.append(0, OMEGA), np.append(1, response(0.4, 25.0)))
    assert len(MeasuredResponse.read(path).omega) == len(OMEGA)


class Universal:
    """What pyuff gives of a file with a geometry, a coherence and two responses."""

    def __init__(self, path):
        self.x = np.array([0.0, 1.0, 2.0])

    def get_set_types(self):
        return np.array([15, 58, 58, 58])

    def read_sets(self, k):
        ordinate = 12 if k == 2 else 8  # an acceleration, displacements
        kinds = {"func_type": 6 if k == 3 else 4, "ordinate_spec_data_type": ordinate}
        nodes = {"rsp_node": 103 + k, "rsp_dir": -3, "ref_node": 21, "ref_dir": 1}
        return {"x": self.x, "data": k * (1 + 1j * self.x)} | kinds | nodes


def test_a_universal_file_is_read_by_pyuff(tmp_path, monkeypatch):
    """The frequency zero is left out; of two responses one is said."""
    path = tmp_path / "x.uff"
    path.write_text("", "utf-8")
    monkeypatch.setitem(sys.modules, "pyuff", None)
    with pytest.raises(ModuleNotFoundError, match=r"sosbook\[uff\]"):
        MeasuredResponse.read(path)
    monkeypatch.setitem(sys.modules, "pyuff", SimpleNamespace(UFF=Universal))
    with pytest.raises(
        ValueError, match=r"be one of 0: 104\.-3 by 21\.1, 1: 105\.[^,]*$"
    ):
        MeasuredResponse.read(path)
    seen = MeasuredResponse.read(path, which=1)
    assert seen.omega == pytest.approx([2 * np.pi, 4 * np.pi])
    assert seen.H == pytest.approx(np.array([2 + 2j, 2 + 4j]) / -(seen.omega**2))
