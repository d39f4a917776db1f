"""A request as plain data, and back again: what proof files say of it."""

import numpy as np

from ..exact.rational import decimals, read_array, read_number
from ..laws.taken import law_of
from ..plants.as_data import plant_data, read_plant
from ..plants.checks import as_written
from ..plants.coupling import coupling_of
from ..plants.near_box import NearBox
from ..requirements.base import Requirement
from .request import Request


def request_data(request):
    """The plant and what is asked of it by a request: lists, words and decimals."""
    return {
        **loop_data(request),
        **request.coupling.data(request),
        "requirements": [r.data() for r in request.requirements],
        **({} if request.ground.near is None else {"box": request.ground.near.data()}),
    }


@as_written()
def read_request(data, gain=None, law=None):
    """The `Request` of the ``data`` that `request_data` writes, with a ``gain`` and its
    ``law``.
    """
    plant = read_plant(data["plant"])
    if "box" in data:
        NearBox.read(plant, data["box"])
    U, K_A = data["U"], data["K_A"]
    law = law_of(read_array(U, None, plant.n) if U else None, law)
    if gain is not None or plant.m == 0:
        gain = (
            np.zeros((0, plant.order))
            if plant.m == 0
            else read_array(gain, plant.m if law.whole else None, None)
        )
    slack = None if data["epsilon"] is None else read_number(data["epsilon"])
    return Request(
        plant,
        K_A=None if K_A is None else read_array(K_A, plant.m, plant.n),
        coupling=coupling_of(data["coupling"], slack),
        gain=gain,
        law=law,
        requirements=[Requirement.read(r) for r in data["requirements"]],
    )


def loop_data(request):
    """The data of a request's plant, whatever is asked."""
    K_A = request.K_A
    return {
        "plant": plant_data(request.plant),
        "U": [] if request.U is None else decimals(request.U),
        "K_A": None if K_A is None else decimals(K_A),
    }
