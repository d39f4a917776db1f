"""Controllers as systems with named inputs and outputs."""

import numpy as np

from ..exact.rational import exact
from ..plants.gain import input_names, signals
from ..plants.sensed import row_words
from ..runtime.libraries import library


def system_of(request):
    """The controller of a ``request`` with a gain as python-control's StateSpace."""
    plant, parts = request.plant, request.applied.parts
    A, B, C, D = (np.asarray(x, float) for x in parts.controller(exact(request.gain)))
    dt = request.step or 0
    if dt:  # the memory's change in a tick
        A, B = np.eye(len(A)) + dt * A, dt * B
    rows, names = parts.rows.astype(float).tolist(), signals(plant)
    inputs = [row_words(x, names, repr) for x in rows]
    outputs = list(input_names(plant.m))
    inputs = [x.replace(".", "_") for x in inputs]
    return library("control").ss(A, B, C, D, inputs=inputs, outputs=outputs, dt=dt)
