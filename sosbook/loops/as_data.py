"""Loops as plain data, and back again."""

from dataclasses import asdict, fields

import numpy as np

from ..exact.rational import decimals, read_array
from ..laws import DynamicLaw, FullState, PIDLaw
from ..plants.as_data import plant_data, read_plant
from ..plants.checks import as_written
from ..plants.outputs import Output
from .clock import Clock, Late

LAWS = {"full state": FullState, "PID": PIDLaw, "dynamic": DynamicLaw}
WRITTEN = {"form": "structure", "rates": "velocity"}  # fields of other names
CLOCKS = {"clock": Clock, "late": Late}


def loop_data(plant, law, gains, clock):
    """The ``plant``, ``law``, ``gains`` and ``clock`` of a loop as JSON holds them."""
    names = getattr(plant, "coordinates", None)
    kind = next((k for k, x in LAWS.items() if type(law) is x), None)
    if kind is None:
        raise ValueError(
            f"law: {type(law).__name__} is a law of your own; written are "
            f"{', '.join(x.__name__ for x in LAWS.values())}"
        )
    words = {WRITTEN.get(f.name, f.name): getattr(law, f.name) for f in fields(law)}
    if clock is not None:
        kinds = [k for k, x in CLOCKS.items() if isinstance(clock, x)]
        clock = {kinds[0]: asdict(clock)}
    return {
        "plant": plant_data(plant) | ({"coordinates": list(names)} if names else {}),
        "law": {kind: {k: _plain(x) for k, x in words.items() if x is not None}},
        "gains": decimals(np.asarray(gains, float)),
        "clock": clock,
    }


def _plain(x):
    if isinstance(x, Output):
        return x.data()
    return x.tolist() if isinstance(x, np.ndarray) else x


@as_written()
def read_loop(data):
    """plant, law, gains and clock of the ``data`` that `loop_data` writes."""
    plant = dict(data["plant"])
    names = plant.pop("coordinates", None)
    ((kind, words),) = data["law"].items()
    if "sensors" in words:
        words = words | {"sensors": Output.read(words["sensors"])}
    if "velocity" in words:
        words = words | {"velocity": Output.read(words["velocity"]).velocity}
    law, clock = LAWS[kind](**words), None
    if data["clock"] is not None:
        ((kind, times),) = data["clock"].items()
        late = times.get("delay")
        times |= {"delay": tuple(late)} if isinstance(late, list) else {}
        clock = CLOCKS[kind](**times)
    return read_plant(plant, names), law, read_array(data["gains"], None, None), clock
