"""A signal of a loop, and what it is there."""

from dataclasses import dataclass

from ..plants.gain import input_names, signals


@dataclass(frozen=True)
class Signal:
    """A signal of a loop: its ``name``, its ``unit`` and its ``role``, which is
    "state", "memory", "disturbance", "set point", "reading", "input" or "output".
    """

    role: str
    name: str
    unit: str = ""


def signals_of(bare, law, c=None):
    """Every `Signal` of a plant, ``bare`` of sensors that are late, under a ``law``,
    and those of a controller c where a clock runs it.
    """
    plant, law = law.on(bare)
    names, parts, goals, units = signals(plant), law.parts(plant), (), {}
    memory, readings = parts.states, parts.sensors
    if c is not None:
        memory, units = c.states, c.units
        readings, goals = (
            [s.name for s in x] for x in (c.readings.signals, c.set_points)
        )
    found = [
        ("state", names),
        ("memory", memory),
        ("disturbance", [f"w[{k}]" for k in range(plant.p)]),
        ("set point", goals),
        ("reading", readings),
        ("input", input_names(plant.m)),
        ("output", names[: bare.n] if hasattr(bare, "coordinates") else ()),
    ]
    return tuple(Signal(r, x, units.get(x, "")) for r, some in found for x in some)
