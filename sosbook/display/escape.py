"""The one place where text and data are made safe for a page."""

import html
import json


def page_text(words, quote=True):
    """The ``str`` of ``words`` as text of a page; in an attribute with ``quote``."""
    return html.escape(str(words), quote=quote)


def json_text(data):
    r"""A value, ``data``, as JSON that may stand in a page's script element.

    >>> json_text({"name": "</script>"})
    '{"name":"\\u003c/script>"}'
    """
    short = dict(ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return json.dumps(data, **short).replace("<", "\\u003c")
