"""What changes of the page's reader are asked: texts, numbers, files and requests."""

import json

import numpy as np

import sosbook as sos
from sosbook.exact.proof_file import KINDS

DATA = {
    "x.1": "-2/3", "x.2": "1e-3", "x.3": "2.5e0", "x.4": "1.5e3",
    "M": [["2", "1"], ["1", "1"]], "none": {"zeros": [2, 0]}, "v": [["1"], ["-0.5"]],
}  # fmt: skip
SETS = {"pairs": [["1", "2"], ["2", "3"]], "one": [["3"]]}
TEXTS = (  # in twos: the first is true, the second isn't
    *("a: 1/3 + 1/6 - 1/2 == 0", "a: 1/3 + 1/6 - 1/2 == 1"),
    *("a: 0.1 + 0.2 - 0.3 == 0", "a: 0.1 + 0.2 - 0.3 > 0"),
    *("a: 3 - 2 > 0", "a: 2 - 2 > 0"),
    *("a: 1/(0 - 4) + 1 > 0", "a: 1/(0 - 4) > 0"),
    *("a: -2/3 - x.1 == 0", "a: x.1 > 0"),
    *("a: 1000 x.2 == 1", "a: 100 x.2 == 1"),
    *("a: x.3 + x.3 == 5", "a: x.3 == 5"),
    *("a: x.4 == 1500", "a: x.4 + 1 == 1"),
    *("a: inv(2) == 1/2", "a: 1/0 == 1/0"),
    *("a: 2^3 == 8", "a: 2^3 == 9"),
    *("a: 2^0 == 1", "a: 2^0 == 0"),
    *("a: inv(4) == 0.25", "a: inv(0) == 0"),
    *("a: 6/4 == 3/2", "a: 6/0 == 0"),
    *("a: M inv(M) == I(2)", "a: inv(M) == M"),
    *("a: inv([0, 1; 2, 0]) == [0, 0.5; 1, 0]", "a: inv([1, 2; 2, 4]) > 0"),
    *("a: inv([0, 0, 1; 0, 3, 0; 1, 0, 0]) [1; 3; 2] == [2; 1; 1]", "a: inv([0]) > 0"),
    *("a: M > 0", "a: M - I(2) > 0"),
    *("a: M' M - M M == O(2, 2)", "a: O(2, 2) > 0"),
    *("a: he([1, 2; 0, 4]) == [2, 2; 2, 8]", "a: he([1, 4; 0, 4]) > 0"),
    *("a: [4, 2, 2; ., 5, 3; ., ., 6] > 0", "a: [4, 2, 2; ., 2, 3; ., ., 3] > 0"),
    *("a: [1, 2; 2, 5] > 0", "a: [1, 2; 3, 50] > 0"),
    *("a: [1, 1/2; 1/2, 1/3] > 0", "a: [1, 1/2; 1/2, 1/4] > 0"),
    *("a: tr([1, 7; 8, 2]) == 3", "a: tr([1, 7; 8, 2]) == 15"),
    *("a: at([1, 2; 3, 4], 2, 1) == 3", "a: at([1, 2; 3, 4], 3, 1) == 3"),
    *("a: at([1, 2, 3], 1, 3) == 3", "a: at([1, 2, 3], 1, 4) == 3"),
    *("a: at([1, 2], 1, 1) == 1", "a: at([1, 2], 0, 1) == 1"),
    *("a: pick(2, 3, 1) [1; 2; 3] == [2]", "a: pick(0, 3, 1) [1; 2; 3] == [2]"),
    *("a: pick(1, 2, 2) [M; M] == M", "a: pick(3, 2, 2) [M; M] == M"),
    *("a: pick(2, 2, 1) [1; 2] == [2]", "a: pick(1, 2, 1) [1; 2] == [2]"),
    *("a: kron([1, 2], [3; 4]) == [3, 6; 4, 8]", "a: kron([1, 2], [3; 4]) == [3, 4]"),
    *("a: rows([1, 2]) + cols([1, 2]) == 3", "a: rows([1, 2]) == 2"),
    *("a: at([1, 2; 3, 4], 2, 2) == 4", "a: at([1, 2; 3, 4], 1, 3) == 3"),
    *("a: at([1, 2; 3, 4], 1, 1) == 1", "a: at([1, 2; 3, 4], 0, 3) == 1"),
    *("a: at([1, 2; 3, 4], 1, 2) == 2", "a: at([1, 2; 3, 4], 3, 0) == 4"),
    *("a: at([1, 2; 3, 4], 2, 1) == 3", "a: at([1, 2; 3, 4], 2, 0) == 2"),
    *("a: rows([5, 1; 1, M]) == 4", "a: rows([5, 1; 1, M]) == 3"),
    *("a: [2] [2] == [4]", "a: [2]^2 == [4]"),
    *("a: tr([1, 7; 8, 2]) M == 3 M", "a: tr([1, 2]) == 1"),
    *("a: M/2 == 0.5 M", "a: M/[2] == 0.5 M"),
    *("a: [M, 0; ., 1] > 0", "a: [M, 0; ., -1] > 0"),
    *("a: [2, v'; v, 3] > 0", "a: [1, v'; v, 1] > 0"),
    *("a: [5, 1, 0; 1, 5, 1; 0, 1, M] > 0", "a: [5, 1, 0; 1, 5, 9; 0, 9, M] > 0"),
    *("a: I(2) [1, 2; 3, 4] == [1, 2; 3, 4]", "a: I(2) == [1, 0; 1, 1]"),
    *("a: O(1, 2) == [0, 0]", "a: O(1, 2) == [0]"),
    *("a: O(0, 0) > 0", "a: I(2000) > 0"),
    *("a: M + 1 == M + I(2)", "a: M + 1 == M"),
    *("a: 1 - [0.5] == [0.5]", "a: [1, 2] + [1; 2] == 0"),
    *("a: [1, 2] [1; 1] == [3]", "a: [1, 2] [1; 1; 5] == [3]"),
    *("a: [1; 2] + [1; 2] == [2; 4]", "a: [1; 2] + [1; 2; 9] == [2; 4]"),
    *("a: [1, 2] + [1, 2] == [2, 4]", "a: [1, 2] + [1, 2, 9] == [2, 4]"),
    *("a: inv([2]) == [0.5]", "a: inv([2, 0, 0]) == [0.5]"),
    *("a: [1, 2] == [1, 2]", "a: [1, 2] == [1; 2]"),
    *("a: 2 M == M + M", "a: 2 M == M"),
    *("a: M 2 == M + M", "a: [1, 2] [1, 2] == 5"),
    *("a: M/2 + M/2 == M", "a: M/M == I(2)"),
    *("a: [v, v] == [1, 1; -0.5, -0.5]", "a: [v, v; v] == 0"),
    *("a: [M, v; ., 9] > 0", "a: [M, v; ., 1] > 0"),
    *("a: [M, 0; 0, 1] > 0", "a: [M, 0; 0, -1] > 0"),
    *("a: [2, v'; v, I(2)] > 0", "a: [1, v'; v, I(2)] > 0"),
    *("a: [M, none] == M", "a: [M, none] == [M, v]"),
    *("a: [M, none; none', 1] == M", "a: [M, none; none', 1] == I(3)"),
    *("b = M M\na: b + M > 0", "b = M M\na: M - b > 0"),
    *("a: 5 - (2 - 1) == 4", "a: 5 - (2 - 1) == 2"),
    *("a: -(1 - 3) == 2", "a: - 1 - 3 == 2"),
    *("a: M' == M  # its mirror image", "a: [1, 2]' == [1, 2]"),
    *(f"for i, j in pairs:\n  a.i.j: x.i + x.j{x} > 0" for x in (" + 1", "")),
    *(f"for k in one:\n  y.k = x.k{x}\n  a.k: y.k > 0\nb: 1 > 0" for x in ("", " - 3")),
    *("a: 1 > 0\n\nb: 2 > 0", "a: 1 > 0\nb: 2 > 1"),
    *("a: (2) (3) == 6", "a: (2 (3) == 6"),
    *("a: x.3 > 0", "a: y > 0"),
    *("a: M == M", "a > 0"),
)  # fmt: skip


def whole(text):
    """A file of the kernel that has a text alone, and values of its names."""
    return {"text": text.split("\n"), "data": DATA, "sets": SETS, "unknowns": {},
            "point": {}}  # fmt: skip


def calls():
    """Numbers, angles and texts that single functions take, at their edges."""
    for x in (0, 1e-4, 9.9e-5, 1e15, 1e16, 1.5e22, 123456.789, 1e-7, 2.0**-20, 5e-324):
        yield from (("decimal", x), ("decimal", -x))
    yield from (
        ("twiceAtLeast", x)
        for x in (
            0.1,
            9.81,
            1.1e-7,
            3,
            0.35229254104585617,
            4.063946027087733,
            2.1359837693070287,
        )
    )
    yield from (("sector", x) for x in (0.05, 0.1, 0.5, 0.7853981633974483, 1.2, 1.57))
    for Q in (
        [[4, 2], [2, 1]],
        [[4, 2], [2, 5]],
        [[0, 0], [0, 0.25]],
        [[1, 2], [2, 1]],
        [[0.5, 0, 1], [0, 0, 0], [1, 0, 2]],
        [[0, 1], [1, 0]],
        [[30, 7], [7, 2.5]],
    ):
        yield "weightFactors", Q
    rng = np.random.default_rng(4)
    for n in (1, 2, 3, 3, 4, 4, 4):
        X, Y = rng.integers(-3, 4, (2, n, n))
        Z = X[:, ::-1] @ X[:, ::-1].T + np.eye(n, dtype=int) * rng.integers(0, 2)
        for A in (X, Y, Z, X * (np.arange(n) != 0), X - 2 * Y * (np.arange(n) > 1)):
            yield "signOfDeterminant", whole_numbers(A)["at"], n
            yield from (("definite", whole_numbers(x)) for x in (A, A + A.T))
        one, two = whole_numbers(X, 1), whole_numbers(Y[:, :2], 2)
        yield from (("exactTimes", one, two), ("exactSum", one, whole_numbers(Y, 3)))
        yield from (("exactInner", one, whole_numbers(Y)), ("exactTransposed", two))
        yield "exactScaled", whole_numbers([[7]], 2), one
        wide = np.array([10**k for k in range(n)])
        for Q, R in ((Z, Y), (wide[:, None] * Z * wide, wide[:, None] * Y * wide)):
            yield from certain(Q, R)
    yield "exactZeros", 2, 3
    one, near, far = (whole_numbers([[x]], k) for x, k in ((1, 0), (2, 0), (410000, 5)))
    yield "staysDefinite", near, far, "1n"
    yield "excludes", [{"constant": one}], [one], [one], ["1n"]
    yield from (("exactMatrix", x) for x in ([[1.5e22, 2.5]], [[1, 2], [3, 4]], []))
    for order in ([1, 0], [1, 2, 0], [2, 1, 0], [2, 0, 1], [3, 0, 1, 2], [3, 2, 1, 0]):
        at = whole_numbers(3 * np.eye(len(order), dtype=int)[order])["at"]
        yield "signOfDeterminant", at, len(order)
    M, D, S, B = (
        [[2, 0.1], [0.3, 1]],
        [[0.4, 0], [0.1, 0.2]],
        [[6, -2], [-2, 4]],
        [[1], [3]],
    )
    small = {"M": [[2]], "D": [[1]], "S": [[3]], "B": [[1]]}
    law = {"position": [[7]], "filter": 0.5, "integrate": [[5]]}
    yield "descriptors", {"vertices": [small], "law": law}
    law = {"position": [[1, 2]], "filter": 0.3, "integrate": [[5]]}
    for more in (
        {},
        {"U": [[1, 0]]},
        {"K_A": [[0.2, -0.3]]},
        {"law": law},
        {"law": {"position": [[7, 3]]}},
    ):
        for F in ({}, {"F": [[0], [1]]}):
            vertex = dict(M=M, D=D, S=S, B=B, **F)
            yield "descriptors", {"vertices": [vertex], **more}
    yield from (("sha256", ("sos" * 60)[:n]) for n in (0, 1, 55, 56, 63, 64, 119, 120))


def certain(Z, Y):
    """Multipliers and the decimals near them, of blocks that they exclude or not."""
    near, one = whole_numbers(Z + Z.T), np.eye(len(Z), dtype=int)
    for scale in (1, 300):
        for off in (0, 1, 400, 1000, 3000):  # thousandths
            far = scale * (1000 * Z + off * Y)
            far = whole_numbers(far + far.T, 3)
            yield "staysDefinite", near, far, f"{scale}n"
            longer = whole_numbers(100 * scale * (1000 * Z + off * Y), 5)
            yield "staysDefinite", whole_numbers(Z), longer, f"{scale}n"
            for signs in ((-1, -1), (1, 0), (0, 0), (-1, 0), (2, -1)):
                blocks = [{"constant": whole_numbers(sign * one)} for sign in signs]
                some = [whole_numbers(scale * (Z + Z.T)), far]
                yield "excludes", blocks, some, [near, near], [f"{scale}n"] * 2


def whole_numbers(rows, places=0):
    """A matrix of the page's exact arithmetic; its integers are written 7n."""
    rows = np.asarray(rows).tolist()
    at = [f"{x}n" for row in rows for x in row]
    return {"rows": len(rows), "cols": len(rows[0]), "places": places, "at": at}


def inputs():
    """[kind, what is asked] of what tests ask of the page's reader."""
    from tests.page_requests import page_request
    from tests.test_check_file import (
        ASKED,
        clocked,
        odd_angles,
        of_no_page,
        others_with_a_clock,
        proof,
        spoiled,
    )
    from tests.test_every_need import AT_A_POINT
    from tests.test_page_kernel import polytopes, random_cost_request, requests

    for name in ASKED:
        yield "file", proof(name).text
        every = spoiled(name)
        yield from (("file", every[k]()) for k in range(0, len(every), 7))
    for some in (clocked, others_with_a_clock, odd_angles, of_no_page):
        yield from (("file", x) for x in some())
    bare = sos.SecondOrderSystem([[2, 0.1], [0.1, 1]], np.eye(2), np.eye(2), [[1], [3]])
    for U in (None, [[1, 0]]):
        yield "file", sos.design_pid(bare, U).certify().text
    head = {"format": "sosbook proof", "version": 2}
    for kind in (*KINDS, "lmi, own", "infeasible lmi, own", "x", 3):
        yield "file", json.dumps(head | {"kind": kind})
    for lines in (x for some in AT_A_POINT.values() for x in some.values()):
        yield "text", [lines, {}, {}]
    yield from (("call", x) for x in calls())
    yield from (("text", [x, SETS, DATA]) for x in TEXTS)
    yield from (("pairs", page_request(**x)) for x in polytopes())
    plain, costs = [*requests(2, 50)], [*requests(2, 30, random_cost_request)]
    for k in (0, 1, 2, 3, 17, 18, 44, 48):  # the last four can't be had
        yield "design", page_request(**plain[k])
    for k, more in ((18, {"mu": 1.0}), (0, {"sigma": 0})):
        asked = page_request(**plain[k])
        yield "design", asked | {"asked": asked["asked"] | more}
    for k in (0, 1, 2, 4, 5, 18, 28, 29):  # the last five
        yield "design", page_request(**costs[k])
