"""The text of a proof file: JSON, a text with data, see `sosbook.exact.checker`.

What no text says, as matrices in balls, has its data alone. Files of version 1, which
have them beside a checksum, are read.
"""

import json
import re

from ..runtime.reading import parse_json
from .checker import verdict
from .checker.arithmetic import Beyond, Refused

__all__ = ["FORMAT", "is_proof", "laid_out", "parse", "same", "written"]

FORMAT = verdict.FORMAT
HEAD = ("format", "version", "kind", "checksum")
MADE = ("claims", "blocks")  # of version 2 these are made from what is asked


def written(kind, data):
    """The text of a proof of some kind, and what `verdict.written` says; else None.

    ``kind``: the kind of the proof; ``data``: lists, words, numbers as text, True,
    False and None.
    """
    asked = {"kind": kind} | {k: v for k, v in data.items() if k not in MADE}
    try:
        whole, *said = verdict.written(asked)
        if not same(verdict.asked_of(whole), asked):
            raise Refused("its data don't say again what is asked")
    except (Beyond, Refused):  # no text says it
        asks = {k: v for k, v in asked.items() if k != "kind"}
        return spread(verdict.head(asked) | {"asks": asks}), None
    return spread(whole), (whole, *said)


def spread(whole):
    """The ``whole`` of version 2 as JSON, with what is named on a line of its own."""

    def line(value):
        return json.dumps(value, separators=(",", ":"))

    lines = []
    for key, value in whole.items():
        text = line(value)
        if isinstance(value, dict) and value:
            parts = (f"{line(k)}:{line(v)}" for k, v in value.items())
            text = "{\n" + ",\n".join(parts) + "}"
        elif isinstance(value, list):
            text = "[\n" + ",\n".join(map(line, value)) + "]"
        lines.append(f"{line(key)}:{text}")
    return "{" + ",\n".join(lines) + "}\n"


def parse(text):
    """The kind of a proof and its data, from its text.

    Raises ValueError if it is no proof file.
    """
    whole = parse_json(text)
    if not isinstance(whole, dict) or whole.get("format") != FORMAT:
        raise ValueError(f'there is no "format": "{FORMAT}"')
    version, kind = whole.get("version"), whole.get("kind")
    if type(version) is not int or version not in (1, 2):
        raise ValueError(f"version must be 1 or 2, got {version!r:.40}")
    if not isinstance(kind, str):
        raise ValueError("kind is missing")
    if version == 2:
        try:
            asked = verdict.asked_of(whole)
        except (*verdict.MALFORMED, Refused) as fault:
            raise ValueError(f"its data aren't what it asks for: {fault}") from None
        return kind, {key: value for key, value in asked.items() if key != "kind"}
    if whole.get("checksum") != verdict.checksum(whole):
        raise ValueError("the checksum isn't that of the contents: they were changed")
    return kind, {key: value for key, value in whole.items() if key not in HEAD}


def is_proof(content):
    """Whether a file's bytes, ``content``, say that it is a proof, whole or not."""
    return re.search(rb'"format"\s*:\s*"sosbook proof"', content) is not None


def same(a, b):
    """Whether two contents, a and b, are written alike: True isn't 1 here."""
    return json.dumps(a, sort_keys=True) == json.dumps(b, sort_keys=True)


def laid_out(value, indent=""):
    """A ``value`` as JSON with each row of a matrix on a line of its own.

    The lines stand behind this ``indent``.
    """
    deeper = indent + " "
    if isinstance(value, dict) and value:
        lines = (
            f"{deeper}{json.dumps(key)}: {laid_out(inner, deeper)}"
            for key, inner in value.items()
        )
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(x, (dict, list)) for x in value):
        lines = (deeper + laid_out(inner, deeper) for inner in value)
        return "[\n" + ",\n".join(lines) + f"\n{indent}]"
    return json.dumps(value)
