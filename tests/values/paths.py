"""Path data of SVG as polylines, and their distance in units of the viewBox."""

import re
from functools import lru_cache

import numpy as np
from scipy.spatial import cKDTree

PIECE = re.compile(r"([MmLlHhVvCcSsQqTtZz])([^MmLlHhVvCcSsQqTtZz]*)")
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
TAKES = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "Z": 0}
STEP = 0.4
REACH = 8.0
T = np.linspace(0, 1, 9)[1:, None]


@lru_cache(maxsize=8192)
def lines(data):
    """The subpaths of path data as (n, 2) arrays, curves flattened; no arc A."""
    found, line = [], []
    pen = start = control = np.zeros(2)
    before = ""
    for command, text in PIECE.findall(data):
        kind = command.upper()
        values = np.array(NUMBER.findall(text), float)
        count = TAKES[kind]
        rows = values.reshape(-1, count) if count else np.zeros((1, 0))
        for row in rows:
            origin = pen if command.islower() else np.zeros(2)
            if kind in "HV":
                point = pen.copy()
                axis = "HV".index(kind)
                point[axis] = row[0] + origin[axis]
                points = [point]
            elif kind == "Z":
                points = [start]
            else:
                points = list(row.reshape(-1, 2) + origin)
            if kind == "M":
                if line:
                    found.append(np.array(line))
                line, start, pen = [points[0]], points[0], points[0]
                kind, before = "L", "M"
                continue
            if not line:
                line = [pen]
            if kind in "ST":
                smooth = before in ("CS" if kind == "S" else "QT")
                points.insert(0, 2 * pen - control if smooth else pen)
            if len(points) == 3:
                line.extend(_cubic(pen, *points))
            elif len(points) == 2:
                line.extend(_quadratic(pen, *points))
            else:
                line.append(points[0])
            control = points[-2] if len(points) > 1 else points[-1]
            pen, before = points[-1], kind
            if kind == "Z":
                found.append(np.array(line))
                line = []
    if line:
        found.append(np.array(line))
    return tuple(found)


def _cubic(a, b, c, d):
    return (
        (1 - T) ** 3 * a + 3 * (1 - T) ** 2 * T * b + 3 * (1 - T) * T**2 * c + T**3 * d
    )


def _quadratic(a, b, c):
    return (1 - T) ** 2 * a + 2 * (1 - T) * T * b + T**2 * c


@lru_cache(maxsize=8192)
def bounds(data):
    """The corners (2, 2) of path data's box; zeros without a point."""
    points = lines(data)
    if not points:
        return np.zeros((2, 2))
    points = np.vstack(points)
    return np.array([points.min(axis=0), points.max(axis=0)])


def distance(some, others, box):
    """Hausdorff distance of two sets of polylines in a box; up to 8, or inf."""
    return max(_way(some, others, box), _way(others, some, box))


def _way(some, others, box):
    """The largest distance from a point of `some` to `others`."""
    seen = _samples(some, box)
    if not len(seen):
        return 0.0
    left, top, right, bottom = box
    wide = _samples(others, (left - REACH, top - REACH, right + REACH, bottom + REACH))
    if not len(wide):
        return np.inf
    return cKDTree(wide).query(seen)[0].max()


def _samples(polylines, box):
    """Points on the lines within a box, at most STEP apart."""
    if not len(polylines):
        return np.zeros((0, 2))
    starts = np.vstack([line[:-1] if len(line) > 1 else line for line in polylines])
    ends = np.vstack([line[1:] if len(line) > 1 else line for line in polylines])
    along = ends - starts
    low, high = np.zeros(len(starts)), np.ones(len(starts))
    for axis in (0, 1):
        still = along[:, axis] == 0
        slope = np.where(still, 1, along[:, axis])
        first = (box[axis] - starts[:, axis]) / slope
        last = (box[axis + 2] - starts[:, axis]) / slope
        outside = still & (first * last > 0)
        first, last = np.minimum(first, last), np.maximum(first, last)
        low = np.maximum(low, np.where(still, 0, first))
        high = np.where(outside, -1, np.minimum(high, np.where(still, 1, last)))
    keep = low <= high
    starts, along, low, high = starts[keep], along[keep], low[keep], high[keep]
    counts = np.ceil((high - low) * np.hypot(*along.T) / STEP).astype(int) + 1
    which = np.repeat(np.arange(len(starts)), counts)
    place = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = place / np.maximum(counts - 1, 1)[which]
    t = low[which] + share * (high - low)[which]
    return starts[which] + t[:, None] * along[which]
