"""Proof files of known gains: cells cover all plants; changed files are refused."""

import json

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import kernel, verdict
from tests.asking import mended
from tests.cases import crossed, norm_on_a_grid
from tests.hunt.tampering import verdicts
from tests.test_proof_files import proof_of

KNOWN = [
    "known gain", "known gain, in a box", "known gain, in a simplex", "known law",
    "known dynamic law",
    "known gain, outputs",
    "known gain, outputs that differ",
]  # fmt: skip
CUT = KNOWN[:3]


def accepted(whole):
    """Whether each reader takes a file, after its digests are mended."""
    return verdicts(mended(whole))


def written_anew(whole):
    """The file with the text that what it asks gets, if it gets one."""
    asked = verdict.asked_of(whole)
    try:
        return json.loads(json.dumps(verdict.written(asked)[0]))
    except (kernel.Refused, *kernel.MALFORMED):
        return whole


def file_of(name):
    return json.loads(proof_of(name).text)


def cells(whole):
    """The cuts of the first requirement that has some."""
    return next(c for _, _, c in whole["asks"]["cells"] if len(c) > 1)


def no_halves(whole):
    cells(whole)[:] = [None]


def one_half(whole):
    cuts = cells(whole)
    del cuts[cuts.index(None)]


def one_more(whole):
    cells(whole).append(None)


def no_cells(whole):
    whole["asks"]["cells"].pop()


def twice(whole):
    whole["asks"]["cells"].append(whole["asks"]["cells"][-1])


def exchanged(whole):
    """The unknowns of two cells are exchanged."""
    q = 1 + next(k for k, x in enumerate(whole["asks"]["cells"]) if len(x[2]) > 1)
    point = whole["point"]
    for name in [x for x in point if x.split(".")[1:3] == [str(q), "1"]]:
        head, _, _, *rest = name.split(".")
        other = ".".join([head, str(q), "2", *rest])
        point[name], point[other] = point[other], point[name]


@pytest.mark.parametrize(
    "name, attack",
    crossed(CUT, [no_halves, one_half, one_more, no_cells, twice, exchanged]),
)
def test_no_cell_is_lost_or_moved(name, attack):
    whole = file_of(name)
    assert accepted(whole) == (True, True)
    attack(whole)
    assert accepted(whole) == accepted(written_anew(whole)) == (False, False)


@pytest.mark.parametrize("name, sign", crossed(KNOWN, [-1, 30]))
def test_each_matrix_counts(name, sign):
    """P, F and G of a cell, with another sign or size."""
    for start in ("P.", "F.", "G."):
        whole = file_of(name)
        key = next(x for x in whole["point"] if x.startswith(start))
        rows = np.array(whole["point"][key], float)
        whole["point"][key] = [[repr(float(x)) for x in row] for row in sign * rows]
        assert accepted(whole) == (False, False)


EASIER = dict(gamma="0.01", u_max="0.01", h2="0.01", bound="0.01", sigma="40")


@pytest.mark.parametrize("name", KNOWN)
def test_no_bound_is_better_than_the_blocks(name):
    whole = file_of(name)
    names = [x for x in whole["data"] if x.split(".")[0] in EASIER]
    for key in names:
        changed = json.loads(json.dumps(whole))
        changed["data"][key] = EASIER[key.split(".")[0]]
        assert accepted(changed) == accepted(written_anew(changed)) == (False, False)
    assert names


def test_a_box_is_one_and_has_all_vertices():
    """Another order of the corners makes them no parallelogram."""
    whole = file_of("known gain, in a box")
    box = whole["asks"]["corners"]
    for other in ([box[1], box[0], *box[2:]], box[:2], [*box[:3], box[0]], [1, 2, 3]):
        whole["asks"]["corners"] = other
        assert accepted(whole) == accepted(written_anew(whole)) == (False, False)


def as_matrices(whole, *alpha):
    """The disk of a file as a region that is told by its matrices."""
    (asked,) = whole["asks"]["requirements"]
    asked.update(form="matrices", name="mine")
    for key in ("rho", "centre"):
        asked.pop(key, None)
    for cell in whole["asks"].get("cells", ()):
        cell[1] = "mine" if cell[0] == "region" else cell[1]
    (_, q), _ = whole["data"]["alpha.1"]
    if alpha:
        whole["data"]["alpha.1"] = [[alpha[0], q], [q, alpha[1]]]
    return json.dumps(written_anew(whole))


@pytest.mark.parametrize("coupling", ["multipliers", "slack", "pairs"])
def test_a_region_that_is_no_disk_is_never_proven_as_one(coupling):
    """Some blocks are those of a disk, whose radius is one and positive."""
    plant, region = sos.SecondOrderSystem(1, 3, 3, 1), sos.LMIRegion.disk(5, -1)
    found = sos.analyse_pid(plant, [[0, 0]], region=region, coupling=coupling)
    whole = json.loads(found.certify().text)
    assert verdict.check(as_matrices(whole))
    for alpha in ("5", "5"), ("-5", "-0.01"), ("-5", "100"):
        with pytest.raises((kernel.Refused, *kernel.MALFORMED)):
            verdict.check(as_matrices(whole, *alpha))


def test_noise_of_a_sensor_is_in_no_bounded_signal_at_once():
    """White noise that u follows without a lag costs infinitely much."""
    carts = sos.SecondOrderSystem(1, 0.5, 1, 1, 1)
    law = sos.PIDLaw([[1]], filter=0.3, noise=[[0.1]])
    asked = dict(
        law=law, requirements=[sos.QuadraticCost(np.eye(3), [[1]], "F", bound=1e3)]
    )
    with pytest.raises(ValueError, match="cost: the noise of a sensor is in u"):
        sos.analyse_pid(carts, [[-0.5, -0.3]], **asked)
    with pytest.raises(ValueError, match="cost: the noise of a sensor is in u"):
        sos.design_pid(carts, **asked)


def test_words_of_a_law_say_what_the_file_holds():
    """What K multiplies, by name; the matrices are there by their digest."""
    proof = proof_of("known law")
    assert "under u = K y with y = [" in proof.claims[0]
    assert any("|u(t)| <= 9" in words for words in proof.claims)
    assert "law" in json.loads(proof.text)["about"]
    whole = file_of("known law")
    whole["data"]["law.rows"][0][0] = "-1"
    assert accepted(whole) == (False, False)


def test_noise_of_a_sensor_is_in_the_output_of_a_plant_whose_output_sees_u():
    """Its norm by frequencies; another noise is another proof."""
    B1, C, D = [[0, 0], [1, 0]], [[1, 0], [0, 0]], [[0], [0.2]]
    plant = sos.DescriptorSystem(np.eye(2), [[0, 1], [-1, -0.1]], [[0], [1]], B1, C, D)
    law = sos.PIDLaw([[1, 0]], noise=[[0, 0.5]])
    found = sos.analyse_pid(plant, [[-0.7]], law=law, minimize="gamma")
    A, W = np.array([[0, 1], [-1.7, -0.1]]), np.array([[0, 0], [1, -0.35]])
    y, through = np.array([[1, 0], [-0.14, 0]]), np.array([[0, 0], [0, -0.07]])
    true = norm_on_a_grid(A, W, y, through)
    assert found.bounds()["gamma"].true == pytest.approx(true, rel=1e-5)
    assert true < found.gamma < 1.02 * true
    push = norm_on_a_grid(A, W, np.array([[-0.7, 0]]), np.array([[0, -0.35]]))
    force = [sos.HInfinity(outputs=sos.Output(input=1.0))]
    least = sos.analyse_pid(
        plant, [[-0.7]], law=law, requirements=force, minimize="gamma"
    )
    assert least.bounds()["gamma"].true == pytest.approx(push, rel=1e-5)
    whole = json.loads(found.certify().text)
    assert accepted(whole) == (True, True)
    whole["data"]["law.noise"] = [["0", "5"]]
    assert accepted(whole) == (False, False)
    felt = sos.HInfinity(9.0, outputs=sos.Output(position=1, input=1))
    cart = sos.SecondOrderSystem(1, 0.5, 1, 1, [[1, 0]])
    seen = sos.PIDLaw([[1]], noise=[[0, 0.1]])
    asked = sos.analyse_pid(cart, [[-0.5]], law=seen, requirements=[felt])
    assert asked.certify().proven


def test_what_a_law_integrates_is_an_output():
    """1 / (s^3 + 0.9 s^2 + 1.5 s + 0.3) by frequencies; a lag is no integral."""
    s = 1j * np.linspace(0, 3, 30001)
    true = np.abs(1 / (s**3 + 0.9 * s**2 + 1.5 * s + 0.3)).max()
    felt = sos.HInfinity(1.05 * true, outputs=sos.Output(integral=1))
    asked = dict(law=sos.PIDLaw([[1]], velocity=[[1]], integrate=True))
    gains = dict(K_P=[[-0.5]], K_D=[[-0.4]], K_I=[[-0.3]])
    cart = sos.SecondOrderSystem(1, 0.5, 1, 1, 1)
    proof = sos.analyse_pid(cart, gains, requirements=[felt], **asked).certify()
    whole = json.loads(proof.text)
    assert proof.proven and accepted(whole) == (True, True)
    changed = json.loads(proof.text)
    changed["data"]["gamma"] = repr(round(0.99 * true, 4))
    assert accepted(changed) == (False, False)
    whole["data"]["law.A"] = [["-9"]]
    assert accepted(whole) == accepted(written_anew(whole)) == (False, False)
