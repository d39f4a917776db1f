"""The one place where text and data are made safe for a page."""

import html
import json


def page_text(words, quote=True):
    """Words as text of a page or as the value of an attribute.

    ``words``: its ``str`` is shown; ``quote``: escape quotation marks too, as
    attributes need it.

    >>> page_text("</script><b title='1'>")
    '&lt;/script&gt;&lt;b title=&#x27;1&#x27;&gt;'
    """
    return html.escape(str(words), quote=quote)


def json_text(data):
    """A value, ``data``, as JSON that may stand in a page's script element.

    Examples
    --------
    >>> json_text({"name": "</script>"})
    '{"name":"\\\\u003c/script>"}'
    """
    encoded = json.dumps(
        data, ensure_ascii=False, separators=(",", ":"), allow_nan=False
    )
    return encoded.replace("<", "\\u003c")
