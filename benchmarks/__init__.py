"""Timings and campaigns, with one thread to a process and without progress bars."""

import os

from sosbook.runtime.progress import WITHOUT_BARS
from sosbook.runtime.threads import ONE_THREAD

os.environ.update(ONE_THREAD | WITHOUT_BARS)  # before numpy is imported
