"""Names of rooms, imported when they are asked for.

So a room that nobody asks isn't loaded, and one that isn't there is missed by those
alone who ask it.
"""

import sys
from importlib import import_module

PACKAGE = __package__.partition(".")[0]


class MissingRoom(ModuleNotFoundError):
    """A room of the package is asked for that isn't there; ``name`` is its module."""


def later(home, name=None):
    """The object ``name`` of a module of the package, ``home``, imported now; the
    module itself where no name is given. Raises MissingRoom if a module of the package
    isn't there.

    >>> later("plants.gain", "Gain").__module__
    'sosbook.plants.gain'
    >>> later("kitchen.stove", "Pan")
    Traceback (most recent call last):
        ...
    sosbook.runtime.later.MissingRoom: Pan needs sosbook.kitchen, which isn't there:
    that room was left out of this copy of the package
    """
    try:
        module = import_module(f"{PACKAGE}.{home}")
    except ModuleNotFoundError as missing:
        if not f"{missing.name}.".startswith(f"{PACKAGE}."):
            raise  # a library
        raise MissingRoom(
            f"{name or home} needs {missing.name}, which isn't there: that room was "
            "left out of this copy of the package",
            name=missing.name,
        ) from None
    return module if name is None else getattr(module, name)


def or_exit(home, name=None):
    """The object ``name`` of ``home``, as of `later`; a program whose room isn't there
    says so, and exits with 3.
    """
    try:
        return later(home, name)
    except MissingRoom as missing:
        sys.stderr.write(f"error: {missing}\n")
        raise SystemExit(3) from None


def by_name(package, homes):
    """The ``__getattr__`` of a ``package`` of the package that hands names on.

    ``homes``: {name: module}, each module as in `later`. What was found once is kept.
    """

    def __getattr__(name):
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = later(homes[name], name)
        setattr(import_module(package), name, value)
        return value

    return __getattr__
