"""Digests: a few letters that name contents."""

import hashlib
import json


def digest(content):
    """The SHA-256 of a ``content``: bytes, or JSON with sorted keys and no spaces."""
    if not isinstance(content, bytes):
        text = json.dumps(content, sort_keys=True, separators=(",", ":"))
        content = text.encode()
    return hashlib.sha256(content).hexdigest()
