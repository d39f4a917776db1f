"""A signal of a loop, and what it is there."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Signal:
    """A signal of a loop: its ``name``, its ``unit`` and its ``role``, which is
    "state", "memory", "disturbance", "set point", "reading", "input" or "output".
    """

    role: str
    name: str
    unit: str = ""
