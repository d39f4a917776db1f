"""Arrays that nobody changes behind an object's back."""

import numpy as np


class ReadOnly:
    """A frozen dataclass with read-only arrays, also in its copies and pickles."""

    def __post_init__(self):
        put(self, **frozen({**vars(self)}))

    def __setstate__(self, state):
        put(self, **frozen({**state}))


def put(thing, /, **values):
    """Give a frozen ``thing`` some ``values`` of its fields, in its constructor."""
    for name, value in values.items():
        object.__setattr__(thing, name, value)


def frozen(value):
    """A ``value`` that can't be written to: an array, or lists and dicts of them."""
    if isinstance(value, np.ndarray) and value.flags.writeable:
        value = value.copy()
        value.flags.writeable = False
    elif type(value) in (list, tuple):
        value = type(value)(map(frozen, value))
    elif type(value) is dict:
        value = {key: frozen(inner) for key, inner in value.items()}
    return value
