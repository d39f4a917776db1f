"""A theorem to type in the page, which designs for it, proves and saves it."""

import numpy as np

from ...exact.checker import verdict
from ...exact.rational import decimals
from ...plants.second_order import SecondOrderSystem
from ...requirements.input_bound import Saturation
from ...synthesis.request import Request
from ...synthesis.request_as_data import request_data
from .movers.mover import Mover, slider
from .page import matrices

LINES = ("energy: [-he(Theta), W; ., 1] > 0", "peak: [peak^2, C EP'; ., EPE] > 0")
WORDS = "|z(t)| stays below peak from rest, for every gust w of energy one"
KNOWN = (
    ("Theta", "= (A P + B Y) E′"),
    ("EPE", "= E P E′"),
    ("EP, W, C, P, Y", "as in the text"),
    ("peak", "the number in the sentence"),
    ("he(X)", "= X + X′"),
    (".", "mirror image"),
    ("1", "the identity"),
)
# a P at which a block that isn't symmetric shows it
SAMPLE = np.eye(4) + np.arange(4) * 0.1 + np.arange(4)[:, None] * 0.1


class OwnTheorem(Mover):
    """A page element for a theorem that the reader types; made by `own_theorem`.

    Its ``script``, ``title``, ``hint``, ``controls`` and ``given`` are a `Mover`'s.
    """

    sheets = ("mover", "theorem")


def own_theorem(title="A theorem of your own"):
    """An element in which readers type the blocks of a theorem.

    Parameters
    ----------
    title : str
        The heading of the element.

    Returns
    -------
    OwnTheorem
        It designs for two carts, proves in fractions and saves the proof as a file.
    """
    D, S = [[0.5, -0.2], [-0.2, 0.2]], [[5, -4], [-4, 4]]
    plant = SecondOrderSystem(np.eye(2), D, S, [[1], [0]], [[0], [1]])
    limit = Saturation(120, [0.1, 0.1, 0, 0])
    request = Request(plant, requirements=[limit])
    theorem = {"numbers": {"own.2.peak": "0.6"}, "unknowns": {}, "blocks": []}
    theorem["blocks"] = [["pair", "mark", "P"]]
    asked = request_data(request) | {"kind": "design", "K": decimals(np.zeros((1, 4)))}
    asked["unknowns"] = {"P": decimals(np.eye(4))}
    asked["requirements"].append(
        {"kind": "own", "name": "own", "claim": WORDS, "theorem": theorem}
    )
    file, *_ = verdict.written(asked)
    vertex = matrices(plant, "MDSBF")
    return OwnTheorem(
        "theorem",
        title,
        "Ask for a shorter peak. Then write W/4 for W below: what is true?",
        [
            slider("peak", "Bound peak of |z|", "", (0.1, 1.5), 0.02, 0.6),
            slider("u_max", "Input bound u_max", "", (1.0, 3.0), 0.02, 120.0, "log"),
        ],
        answer={"peak": 0.3},
        lines=list(LINES),
        words=WORDS,
        known=[list(pair) for pair in KNOWN],
        request={"vertices": [vertex], "U": [], "K_A": None, "coupling": "pairs"},
        x0=limit.x0.tolist(),
        mark="own.2.",
        sample={"K": [[0.3, -0.2, 0.5, 0.7]], "P": SAMPLE.tolist()},
        file=file,
    )
