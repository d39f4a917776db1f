"""One loop: a plant, a law with its numbers, and the clock that runs it."""

from .clock import Clock, Late
from .loop import Loop, opened
from .signal import Signal

__all__ = ["Clock", "Late", "Loop", "Signal", "opened"]
