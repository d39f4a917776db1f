"""Couplings are objects: one table knows their words, and a fifth one needs no other
place.
"""

import re
from pathlib import Path

import numpy as np
import pytest

import sosbook as sos
from sosbook.exact.checker import verdict
from sosbook.plants import coupling

ROOT = Path(sos.__file__).parents[1]
COMPARED = re.compile(
    r"(?<!for )\bcoupling[\w\"'()\[\].]* *(==|!=|\bin\b|\bnot in\b) *[(\[\"']"
    r"|is_word\([^\n]*coupling|[\"'](slack|multipliers|pairs)[\"'] *(==|!=)"
)
SECOND_WRITING = "exact/checker"  # by hand, on purpose: it stands alone


def family(mass, swing):
    """Four corners of z'' + .3 z' + 9.81 s z = u, of masses and stiffnesses."""
    return sos.Polytope(
        [
            sos.SecondOrderSystem(m, 0.3, 9.81 * s, 1, 0.3)
            for m in (1, mass)
            for s in (1, swing)
        ]
    )


@pytest.fixture
def halves():
    """The coupling that CONTRIBUTING tells, registered."""
    recipe = (ROOT / "CONTRIBUTING.md").read_text("utf8").partition("## A coupling")[2]
    exec(re.search(r"```python\n(.*?)```", recipe, re.DOTALL)[1], {})
    yield coupling.BY_WORD["halves"]
    del coupling.BY_WORD["halves"]


def test_no_word_of_a_coupling_is_compared_outside_its_table():
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in (ROOT / "sosbook").rglob("*.py")
        if SECOND_WRITING not in path.as_posix()
        for line in path.read_text("utf8").splitlines()
        if COMPARED.search(line)
    ]
    assert found == []
    assert COMPARED.search('if request.coupling == "slack":')
    assert COMPARED.search('if request.coupling in ("slack", "multipliers"):')
    assert COMPARED.search('is_word(self.options.get("coupling"), ("auto",))')


@pytest.mark.parametrize("mass, slack", [(1.4, 0.3), (2.2, None)])
def test_the_recipe_of_a_fifth_coupling_designs_and_proves(halves, mass, slack):
    plants, asked = family(mass, 1.3), dict(region=sos.PoleRegion(sigma=0.4))
    design = sos.design_pid(plants, coupling=("halves", slack), **asked)
    assert type(design.request.coupling) is halves and design.status == "feasible"
    P = design.P
    assert (P[0] == P[1]).all() and (P[2] == P[3]).all() and (P[1] != P[2]).any()
    unknowns = {u.name for u in design.request.unknowns()}
    assert unknowns == {"P 1", "P 3", "V", "Y"}
    for plant in plants.vertices:
        A = [[0, 1], [-plant.S.item(), -0.3]] + np.array([[0], [1]]) @ design.K
        A[1] /= plant.M.item()
        assert np.linalg.eigvals(A).real.max() < -0.4
    proof = design.certify()
    assert proof.proven and verdict.check(proof.text) == list(proof.claims)
    assert proof.claims[0].startswith("every constant plant of the polytope")
    kept = sos.analyse_pid(plants, design.K, coupling="halves", **asked)
    assert kept.status == "feasible" and kept.certify().proven


def test_multipliers_of_the_fifth_coupling_refuse_nothing_that_its_file_allows(halves):
    """Mathieu's plant: 1 + 0.4 cos 2t pumps it up, so there is no common P, which is
    what halves of the same two plants ask for. A P for each of the two there is.
    """
    soft, stiff = (sos.SecondOrderSystem(1, 0.1, s, 1) for s in (0.6, 1.4))
    plants = sos.Polytope([soft, stiff, soft, stiff])
    own = sos.analyse_pid(plants, [[0, 0]], coupling="slack")
    halves = coupling.coupling_of("halves", own.slack)
    assert own.status == "feasible"
    half = sos.analyse_pid(plants, [[0, 0]], coupling=halves)
    assert half.request.lyapunov == ("P 1",) * 4 and half.status == "undecided"


@pytest.mark.parametrize("word", ["pears", 3, None, np.array(["pairs"])])
def test_what_is_no_coupling_is_refused_by_name(word):
    with pytest.raises(ValueError, match=r'coupling must be "pairs"'):
        sos.design_pid(family(1.4, 1.3), coupling=word)


def test_each_word_finds_a_coupling_that_knows_its_word():
    for word in coupling.BY_WORD:
        assert coupling.coupling_of(word).word == word
    assert coupling.COUPLINGS == ("vertices", "pairs", "slack")
    with pytest.raises(ValueError, match="slack must be positive"):
        coupling.coupling_of("slack", -1)
    one = coupling.coupling_of("slack", 0.3)
    assert coupling.coupling_of(one) == one == coupling.PPerVertex(0.3)
