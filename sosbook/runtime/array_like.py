"""The arguments that NumPy makes arrays of: one word in a signature, where NumPy's own
prints 350 characters.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy.typing import ArrayLike as ArrayLike
else:

    class ArrayLike:
        """A number, a list of numbers, lists of such lists, or an array."""

        __module__ = "builtins"  # which no signature prints
