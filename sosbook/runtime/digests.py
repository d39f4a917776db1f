"""Digests: a few letters that name contents."""

import hashlib
import json


def digest(content):
    """The SHA-256 of a content, in hexadecimal.

    ``content``: the latter as JSON with sorted keys and no spaces.

    >>> digest({"b": 1, "a": [2]}) == digest(b'{"a":[2],"b":1}')
    True
    """
    if not isinstance(content, bytes):
        text = json.dumps(content, sort_keys=True, separators=(",", ":"))
        content = text.encode()
    return hashlib.sha256(content).hexdigest()


def short_digest(content):
    """The first 12 letters of the `digest` of a content.

    Examples
    --------
    >>> short_digest([["1"]])
    'e28610836ab7'
    """
    return digest(content)[:12]
