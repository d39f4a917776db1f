"""What rooms further down offer to objects of those above."""

from importlib import import_module


def later(room, name):
    """A function of a later room, imported when a method needs it.

    A method of a result may hand the result on to a later room; the earlier room
    knows nothing else of it. The tests of the rooms list who does so.

    ``room``: such as "controllers"; ``name``: of something public there.

    >>> later("sampled", "c2d").__name__
    'c2d'
    """
    return getattr(import_module(f"..{room}", __package__), name)
