"""The outline of a region of the complex plane, as corners of a polygon."""

import numpy as np

RAYS = 360  # corners of an outline: one a degree


def region_outline(region, window=(-10.0, 2.0, 6.0)):
    """Corners of a polygon that traces a ``region`` within a ``window`` (left, right,
    height), as complex points; empty if it misses the window.

    A region f(z) = alpha + beta z + beta' conj(z) < 0 is convex and symmetric about the
    real axis. From an interior point c the boundary along a direction d is where f(c) +
    t (f(c + d) - f(c)) becomes singular: one eigenvalue problem a ray, no search.
    """
    left, right, height = window
    parts = region_parts(region)
    pairs = [(np.asarray(x.alpha, float), np.asarray(x.beta, float)) for x in parts]
    one, turned = np.ones((1, 1)), np.array([[0, 1], [-1, 0]]) / 2
    pairs += [(left * one, -one / 2), (-right * one, one / 2)]
    pairs += [(np.diag([-height, -height]) + 0.0, turned)]

    def values(points):
        z, worst = points[:, None, None], []
        for alpha, beta in pairs:
            size = np.linalg.norm(alpha) + np.linalg.norm(beta)
            f = alpha + beta * z + beta.T * z.conj()
            worst.append(np.linalg.eigvalsh(f)[:, -1] / size)
        return np.max(worst, axis=0)

    a, b = left, right
    for _ in range(6):  # convex along the real axis
        grid = np.linspace(a, b, 41)
        worst = values(grid + 0j)
        k = int(np.argmin(worst))
        a, b = grid[max(k - 1, 0)], grid[min(k + 1, 40)]
    if worst[k] >= -1e-9:
        return np.empty(0, complex)
    centre = grid[k]
    directions = np.exp(2j * np.pi * (np.arange(RAYS) + 0.5) / RAYS)
    z, reach = directions[:, None, None], np.full(RAYS, np.inf)
    for alpha, beta in pairs:
        at_centre = alpha + centre * (beta + beta.T)
        root = np.linalg.inv(np.linalg.cholesky(-at_centre))
        slope = beta * z + beta.T * z.conj()
        top = np.linalg.eigvalsh(root @ slope @ root.T)[:, -1]
        far = np.where(top > 1e-12, 1 / np.maximum(top, 1e-12), np.inf)
        reach = np.minimum(reach, far)
    return centre + reach * directions


def region_parts(region):
    """The LMI regions whose intersection `region` is; an empty tuple for None."""
    if region is None:
        return ()
    if hasattr(region, "parts"):
        return tuple(region.parts)
    return tuple(region) if isinstance(region, (list, tuple)) else (region,)


def window_of(poles, region=None):
    """A window (left, right, height) that shows the ``poles`` and the ``region``.

    >>> window_of([-1 + 1j, -1 - 1j])
    (-1.3, 0.325, 1.3)
    """
    poles = poles if len(poles) else [-1 + 1j]
    points = np.concatenate([np.ravel(np.asarray(p, complex)) for p in poles])
    points = points[np.isfinite(points)]
    far = max(np.max(np.abs(points.real)), np.max(np.abs(points.imag)), 1e-9)
    rho = getattr(region, "rho", None)
    far = 1.08 * max(far, rho) if rho else 1.3 * far
    right = max(0.25 * far, 1.3 * np.max(points.real))
    return (float(round(-far, 6)), float(round(right, 6)), float(round(far, 6)))
