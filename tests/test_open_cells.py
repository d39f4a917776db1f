"""The cells that write a theorem out agree with the package's call below them."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

import sosbook as sos
from sosbook.book import thesis

BOOK = Path(__file__).parent.parent / "book"


def cells(chapter):
    """The code cells of a chapter that write blocks in the open."""
    (path,) = BOOK.glob(f"{chapter}_*.ipynb")
    every = json.loads(path.read_text("utf8"))["cells"]
    written = ["".join(c["source"]) for c in every if c["cell_type"] == "code"]
    return [x for x in written if "symmetric(" in x or "LMIProblem(" in x]


def names(**given):
    """What a cell finds in its chapter: the words, the libraries and ``given``."""
    words = {}
    exec(
        "from numpy.linalg import eigvals, inv, solve\n"
        "from sosbook.lmi import *\nfrom sosbook.plants import descriptors",
        words,
    )
    return words | {"np": np, "sos": sos} | given


def run(chapter, count, **given):
    """The names after the first ``count`` open cells of a chapter have run."""
    space = names(**given)
    for source in cells(chapter)[:count]:
        exec(source, space)
    return space


def test_procedure_2_1_gives_the_package_s_gains():
    example = thesis.example_1()
    design = sos.design_pid(example.plant, **example.requirements)
    open_ = run("07", 2, plant=example.plant, U=np.eye(2))
    assert_allclose(open_["K"], design.K, atol=1e-9)
    assert open_["point"].prove().proven


@pytest.mark.parametrize("name, moved", [("sector", 0), ("half-plane", 1), ("norm", 2)])
def test_a_block_that_is_left_out_is_missed(name, moved):
    """Against the loop's own eigenvalues: what the block asked isn't kept any more."""
    plant = thesis.example_1().plant
    space = run("07", 3, plant=plant, U=np.eye(2))
    all_in, less = space["left_out"]("none"), space["left_out"](name)
    assert all_in[0] < 45 and all_in[1] < -0.7
    assert (less[0] > 45, less[1] > -0.7, less[2] < all_in[2] / 4)[moved]
