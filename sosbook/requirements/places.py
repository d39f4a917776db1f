"""The content of a plant file: its places, and the form that a sentence leads to."""

from copy import deepcopy


def canonical(data):
    """The ``data`` of a plant file in the one form that a sentence leads to."""
    data = deepcopy(data)
    region, law = data.get("region") or {}, data.get("law") or {}
    if "settling_time" in region:
        region["sigma"] = 4 / region.pop("settling_time")
    if "integrate" in law:
        position = law.get("position", [])
        eye = [
            [float(i == j) for j in range(len(position))] for i in range(len(position))
        ]
        law["integrate"] = eye if law["integrate"] is True else law["integrate"] or []
        if not law["integrate"]:
            del law["integrate"]
    if "controller" in data and "T" in data["controller"] and limit(data) is not None:
        data["controller"].setdefault("u_max", limit(data))
    return data


def integrated(data):
    """The rows of z that the law of a plant file's ``data`` integrates."""
    law = data.get("law")
    if not law:
        return data.get("U") or []
    position = law.get("position", [])
    return [
        [sum(x * y for x, y in zip(row, column)) for column in zip(*position)]
        for row in law.get("integrate", [])
    ]


def mixed(rows, position):
    """The mixtures of measured coordinates (the rows ``position``) that a law
    integrates in the place of ``rows``: the same where they are measured, else as many
    of those that are.
    """
    seen = [row.index(1) for row in position]
    if all(not x for row in rows for j, x in enumerate(row) if j not in seen):
        return [[row[j] for j in seen] for row in rows]
    few = range(min(len(rows), len(seen)))
    return [[float(i == j) for j in range(len(seen))] for i in few]


def limit(data):
    """The bound of the input in the ``data`` of a file, or None."""
    return (data.get("saturation") or {}).get("u_max")


def get(data, at):
    """The value in ``data`` at a place, the keys ``at``; None without one."""
    for name in at:
        data = data.get(name) if isinstance(data, dict) else None
    return data


def put(data, at, value):
    """Put a ``value`` into ``data`` at a place, the keys ``at``; None takes away what
    is there, and what is empty then.
    """
    *way, name = at
    if value is not None:
        for key in way:
            data = data.setdefault(key, {})
        data[name] = value
        return
    inner = get(data, way)
    if isinstance(inner, dict) and name in inner:
        del inner[name]
        if way and not inner:
            put(data, way, None)
