"""The whole book as one PDF, printed by a Chromium from the built pages."""

from .contents import Chapter, contents
from .printing import print_book

__all__ = ["Chapter", "contents", "print_book"]
