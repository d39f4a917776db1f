"""The whole book as one PDF, printed by a Chromium from the built pages."""

from .contents import Chapter, chosen, contents
from .printing import print_book

__all__ = ["Chapter", "chosen", "contents", "print_book"]
