"""Controllers as systems with named inputs and outputs."""

import numpy as np

from ..exact.rational import exact
from ..plants.gain import input_names, signals
from ..plants.sensed import row_words
from ..runtime.libraries import library


def system_of(request):
    """The controller of a ``request`` with a gain as python-control's StateSpace."""
    plant, law = request.plant, request.law
    names = signals(plant, request.U)
    if law is None:
        K = np.asarray(request.gain, float)
        parts = np.zeros((0, 0)), np.zeros((0, len(names))), np.zeros((len(K), 0)), K
        inputs = names
    else:
        found = request.law_parts.controller(exact(request.gain))
        parts = (np.asarray(x, float) for x in found)
        rows = request.law_parts.rows.astype(float).tolist()
        inputs = [row_words(x, names, repr) for x in rows]
    outputs = list(input_names(plant.m))
    inputs = [x.replace(".", "_") for x in inputs]
    return library("control").ss(*parts, inputs=inputs, outputs=outputs, dt=0)
