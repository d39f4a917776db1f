"""The thesis's plants and printed numbers, each with its place.

Nothing here is computed. Where the thesis is wrong, the correction is made in
the open: see the field's comment and the errata.
"""

from .delayed import DelayExample, delay_example_1, delay_example_2
from .pendulum import MipPrint, mip
from .regulators import (
    Example,
    arm,
    car_seat,
    example_1,
    example_2,
    example_3,
    example_4,
)

__all__ = [
    "DelayExample",
    "Example",
    "MipPrint",
    "arm",
    "car_seat",
    "delay_example_1",
    "delay_example_2",
    "example_1",
    "example_2",
    "example_3",
    "example_4",
    "mip",
]
