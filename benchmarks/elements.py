"""Finite elements of beams and plates: their masses and stiffnesses."""

import numpy as np


def beam_element(h):
    """Mass and stiffness of a beam's element of length h, Hermite cubics.

    Deflection and slope at either end; mass per length and bending stiffness
    are one.
    """
    M = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h**2, 13 * h, -3 * h**2],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
        ]
    )
    S = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h**2, -6 * h, 2 * h**2],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h**2, -6 * h, 4 * h**2],
        ]
    )
    return h / 420 * M, S / h**3


def beam_matrices(elements, held=(0, 1)):
    """M and S of a beam of length one, without the coordinates that are held.

    Those are the deflection and the slope of its first node, of a cantilever.
    """
    M, S = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    m, s = beam_element(1 / elements)
    for e in range(elements):
        here = slice(2 * e, 2 * e + 4)
        M[here, here] += m
        S[here, here] += s
    free = np.delete(np.arange(2 * elements + 2), held)
    return M[np.ix_(free, free)], S[np.ix_(free, free)]


def plate_element(a, b, poisson=0.3):
    """Mass and stiffness of a plate's rectangle a times b.

    Deflection, slope along x and slope along y at each corner, in the order
    (0, 0), (a, 0), (a, b), (0, b). Twelve polynomials, of the third degree but
    for x^3 y and x y^3, that don't bend quite alike at a common edge. Source:
    A. Adini and R. W. Clough, 1960; O. C. Zienkiewicz, The Finite Element
    Method, chapter on plates. Mass per area and bending stiffness are one.
    """
    powers = [(i, d - i) for d in range(4) for i in range(d, -1, -1)]
    p, q = np.array([*powers, (3, 1), (1, 3)]).T

    def derivative(x, y, dx=0, dy=0):
        factor = np.ones(12)
        for k in range(dx):
            factor = factor * (p - k)
        for k in range(dy):
            factor = factor * (q - k)
        return factor * x ** np.maximum(p - dx, 0) * y ** np.maximum(q - dy, 0)

    corners = [(0, 0), (a, 0), (a, b), (0, b)]
    values = [
        derivative(x, y, *order)
        for x, y in corners
        for order in ((0, 0), (1, 0), (0, 1))
    ]
    shape = np.linalg.inv(np.array(values, float))  # polynomials of the nodes
    nodes, weights = np.polynomial.legendre.leggauss(4)
    material = np.array([[1, poisson, 0], [poisson, 1, 0], [0, 0, (1 - poisson) / 2]])
    M, S = np.zeros((2, 12, 12))
    for x, u in zip((nodes + 1) * a / 2, weights * a / 2):
        for y, v in zip((nodes + 1) * b / 2, weights * b / 2):
            w = derivative(x, y) @ shape
            curvature = np.array(
                [
                    derivative(x, y, 2, 0),
                    derivative(x, y, 0, 2),
                    2 * derivative(x, y, 1, 1),
                ]
            )
            curvature = curvature @ shape
            M += u * v * np.outer(w, w)
            S += u * v * curvature.T @ material @ curvature
    return M, S


def plate_matrices(columns, rows, length=1.0, width=1.0):
    """M and S of a free plate; three numbers a node, nodes column by column."""
    m, s = plate_element(length / columns, width / rows)
    count = 3 * (columns + 1) * (rows + 1)
    M, S = np.zeros((2, count, count))
    for c in range(columns):
        for r in range(rows):
            first = c * (rows + 1) + r
            nodes = [first, first + rows + 1, first + rows + 2, first + 1]
            at = np.add.outer(3 * np.array(nodes), np.arange(3)).ravel()
            M[np.ix_(at, at)] += m
            S[np.ix_(at, at)] += s
    return M, S
