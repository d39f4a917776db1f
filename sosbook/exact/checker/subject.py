"""The subject of a proof: by digests, in sizes, and as a reader's own file has it."""

import hashlib
import json

from .arithmetic import Beyond, need
from .families import keys


def digest(value):
    plain = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(plain.encode()).hexdigest()


def parts(asked):
    """The matrices that a proof is about, by name."""
    about = [
        (k, asked[k]) for k in ("plant", "U", "K_A", "K", "law", "L") if asked.get(k)
    ]
    several = asked.get("requirements")
    several = several if isinstance(several, list) else []
    starts = [r["x0"] for r in several if isinstance(r, dict) and "x0" in r]
    return about + [("x0", x) for x in starts]


def about(asked):
    """The first letters of digests."""
    return {name: digest(value)[:12] for name, value in parts(asked)}


def subject(asked):
    """The subject of a proof with data ``asked``: digests, and numbers or sizes.

    >>> subject({"K": [["1", "-2"]], "U": []})
    'K e31ba7a7b60d = [[1, -2]]'
    """
    words = []
    for name, value in parts(asked):
        text = json.dumps(value).replace('"', "")
        text = f"= {text}" if len(text) <= 120 else f"({size(value)})"
        words.append(f"{name} {digest(value)[:12]} {text}")
    return ", ".join(words)


def size(value):
    if isinstance(value, dict):
        return ", ".join(f"{key} {size(inner)}" for key, inner in value.items())
    if not isinstance(value, list) or not value:
        return json.dumps(value).replace('"', "")[:120]
    if isinstance(value[0], dict):
        return f"{len(value)} with {size(value[0])}"
    if isinstance(value[0], list):
        return f"{len(value)} x {len(value[0])}"
    return f"{len(value)} numbers"


def wanted_plant(given):
    """The plant, and U and K_A if any, of a plant file as proof files write them."""
    plant = given.get("plant", given)
    if "parameters" in plant:
        raise Beyond("a file with parameters is compared by python -m sosbook verify")
    vertices = []
    for v in plant.get("vertices", [plant]):
        keys(dict(v, F=0), "M D S B F")
        v = dict({"F": [[] for _ in v["M"]]}, **v)
        vertices.append({k: decimals(v[k]) for k in "MDSBF"})
    wanted = {"plant": {"kind": "second order", "vertices": vertices}}
    for name, none in (("U", []), ("K_A", None)) if "plant" in given else ():
        wanted[name] = none if given.get(name) is None else decimals(given[name])
    return wanted


def wanted_gain(given):
    return {"K": decimals(given["K"] if isinstance(given, dict) else given)}


def decimals(rows):
    """Numbers of JSON as proof files write them."""
    if isinstance(rows, list):
        return [decimals(x) for x in rows]
    good = type(rows) in (int, float)
    need(good, "a plant or a gain has something that is no number")
    text = repr(float(rows) + 0.0)
    return text[:-2] if text.endswith(".0") else text
