"""Appendix A: what it says of its own inequalities."""

from .table import evaluate


def rows():
    """What the structure of (A.17) saves, computed."""
    sizes = (2, 6, 100, 1000)
    ratios = [_free(2 * n) / _free(n) for n in sizes]
    words = ", ".join(f"{ratio:.2f} for n = {n}" for n, ratio in zip(sizes, ratios))
    yield evaluate("diag-variables", abs(ratios[-1] - 4) < 0.01, ours=words)


def _free(n):
    """Number of free entries of a symmetric matrix of n rows."""
    return n * (n + 1) // 2
