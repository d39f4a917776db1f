"""The text of a proof file: JSON, with a version and a checksum."""

import json
import re

from ..runtime.digests import digest
from ..runtime.reading import parse_json

__all__ = ["FORMAT", "VERSION", "is_proof", "laid_out", "parse", "same", "written"]

FORMAT, VERSION = "sosbook proof", 1
HEAD = ("format", "version", "kind", "checksum")


def written(kind, data):
    """The text of a proof of some kind.

    Parameters
    ----------
    kind : str
        The kind of the proof.
    data : dict
        Lists, words, numbers as text, True, False and None.
    """
    whole = {"format": FORMAT, "version": VERSION, "kind": kind, **data}
    whole["checksum"] = checksum(whole)
    return laid_out(whole) + "\n"


def checksum(whole):
    """The SHA-256 of the contents, whatever their layout.

    It finds what was changed by accident. Who changes a file on purpose
    can mend it, and then the arithmetic decides.
    """
    return digest({key: value for key, value in whole.items() if key != "checksum"})


def parse(text):
    """The kind of a proof and its data, from its text.

    Raises ValueError if it is no proof file.
    """
    whole = parse_json(text)
    if not isinstance(whole, dict) or whole.get("format") != FORMAT:
        raise ValueError(f'there is no "format": "{FORMAT}"')
    if type(whole.get("version")) is not int or whole["version"] != VERSION:
        raise ValueError(f"version must be {VERSION}, got {whole.get('version')!r:.40}")
    if whole.get("checksum") != checksum(whole):
        raise ValueError("the checksum isn't that of the contents: they were changed")
    kind = whole.get("kind")
    if not isinstance(kind, str):
        raise ValueError("kind is missing")
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
