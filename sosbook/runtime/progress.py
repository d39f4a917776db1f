"""Progress bars, where tqdm is installed and they are wanted."""

import os

#: Environment of a process that shows no bars; any value will do.
WITHOUT_BARS = {"TQDM_DISABLE": "1"}


class _Silent:
    """Stands for a bar that nobody sees."""

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return None

    def update(self, count=1):
        """Count on, unseen."""


def bar(total, unit="it", progress=True):
    """A context in which ``update()`` moves a bar of ``total`` steps, each a ``unit``;
    none without ``progress`` or tqdm, or with TQDM_DISABLE, unread in notebooks.
    """
    if not progress or WITHOUT_BARS.keys() & os.environ.keys():
        return _Silent()
    try:
        from tqdm.auto import tqdm
    except ModuleNotFoundError:
        return _Silent()
    return tqdm(total=total, unit=unit, leave=False, disable=False)


def each(items, unit="it", progress=True):
    """Yield the ``items``, and count each ``unit`` in a bar if ``progress``."""
    with bar(len(items), unit, progress) as done:
        for item in items:
            yield item
            done.update()
