"""Two drawings in SVG, compared as a reader sees them: places may differ by one px.

Curves and marks of one look that follow each other may change their order.
"""

from difflib import SequenceMatcher
from functools import lru_cache
from itertools import groupby

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching
from scipy.spatial import cKDTree

from . import paths, words
from .shapes import drawn

TOLERANCE = 1.0
SAME_MARK = 0.03
MANY = 60


def differences(stored, now, limit=5):
    """What two svg elements (trees.Node) don't agree in: a list of str."""
    before, after = _drawn(stored), drawn(now)
    _share_marks(before, after)
    faults = [*_looks(before, after)] or [*_places(before, after)]
    return words.first(faults, limit)


_drawn = lru_cache(maxsize=24)(drawn)  # of what is compared with several others


def _share_marks(before, after):
    """Give marks of nearly the same outline the very same."""
    theirs = dict.fromkeys(shape.outline for shape in before if _is_mark(shape))
    alias = {}
    for shape in filter(_is_mark, after):
        outline = shape.outline
        if outline not in theirs and outline not in alias:
            alias[outline] = next(
                (other for other in theirs if _nearly(outline, other)), outline
            )
        shape.outline = alias.get(outline, outline)


def _is_mark(shape):
    return shape.kind == "mark" and _is_small(shape.outline)


@lru_cache(maxsize=1024)
def _is_small(outline):
    return np.ptp(paths.bounds(outline)) < 40


def _is_point(shape):
    """Whether its outline is compared closely, and its place loosely."""
    return shape.kind == "glyph" or _is_mark(shape)


def _nearly(one, two):
    """Whether two outlines of marks are as good as the same."""
    a, b = paths.bounds(one), paths.bounds(two)
    slack = 0.02 + SAME_MARK * np.hypot(*(a[1] - a[0]))
    if np.abs(a - b).max() > slack:
        return False
    everywhere = (-1e4, -1e4, 1e4, 1e4)
    return paths.distance(paths.lines(one), paths.lines(two), everywhere) < slack


def _look(shape):
    return shape.kind, shape.style, shape.outline if _is_point(shape) else ""


def _looks(before, after):
    """Shapes that are missing, new or of another look."""
    old, new = [*map(_look, before)], [*map(_look, after)]
    if old == new:
        return
    match = SequenceMatcher(None, old, new, autojunk=False)
    for change, i, j, k, m in match.get_opcodes():
        if change != "equal":
            yield (
                f"stored {_several(before[i:j])}, now {_several(after[k:m])}"
                f"{_where((before[i:j] or after[k:m])[0])}"
            )


def _several(shapes):
    if not shapes:
        return "nothing"
    kinds = {}
    for shape in shapes:
        kinds[str(shape)] = kinds.get(str(shape), 0) + 1
    return ", ".join(f"{count} {kind}" for kind, count in list(kinds.items())[:4])


def _where(shape):
    x, y, *_ = shape.corners
    return f" at ({x:.0f}, {y:.0f})"


def _places(before, after):
    """Shapes of the same look that moved."""
    numbers = {}
    pairs = zip(before, after)
    for (kind, *_), run in groupby(pairs, lambda pair: _look(pair[0])):
        run = [*run]
        first = numbers.get(kind, 0) + 1
        numbers[kind] = first + len(run) - 1
        if kind == "text":
            for one, two in run:
                yield from words.differences(one.text, two.text)
        astray = [
            (first + n, *pair)
            for n, pair in enumerate(run)
            if _differ(*pair) and _moved(*pair) > TOLERANCE
        ]
        if len(astray) > 1 and kind != "text":
            astray = _unmatched(astray)
        for number, one, two in astray:
            name = str(one).removeprefix(one.kind).strip()
            yield (
                f"{one.kind} {number} {name} moved by "
                f"{_moved(one, two):.2g} px{_where(one)}"
            )


def _differ(one, two):
    return one.matrix != two.matrix or one.outline != two.outline


def _moved(one, two):
    """How far one shape is from the other."""
    if one.outline == two.outline or one.kind == "text":
        return _shift(one, two)
    if "A" in (one.outline + two.outline).upper():
        return np.inf
    return paths.distance(one.polylines, two.polylines, one.box)


def _shift(one, two):
    apart = np.subtract(one.corners, two.corners).reshape(2, 2)
    return np.hypot(*apart.T).max()


def _unmatched(astray):
    """Those of some pairs that find no partner in any order."""
    _, before, after = zip(*astray)
    if _is_point(before[0]):
        near = _near_points(before, after)
    elif len(astray) <= MANY:
        near = csr_array(
            [[_moved(one, two) <= TOLERANCE for two in after] for one in before]
        )
    else:
        return astray
    partner = maximum_bipartite_matching(near, perm_type="column")
    rest = set(range(len(after))) - set(partner.tolist())
    return [
        (astray[i][0], before[i], after[j])
        for i, j in zip(np.flatnonzero(partner < 0), sorted(rest))
    ]


def _near_points(before, after):
    one, two = (np.array([shape.corners for shape in side]) for side in (before, after))
    found = cKDTree(one).query_ball_tree(cKDTree(two), TOLERANCE * 2**0.5)
    rows = np.repeat(np.arange(len(one)), [len(row) for row in found])
    columns = np.concatenate([np.array(row, int) for row in found])
    return csr_array(
        (np.ones(len(rows), bool), (rows, columns)), shape=(len(one), len(two))
    )
