"""Appendix A: what it says of its own inequalities."""

from .table import Row, claim

__all__ = ["rows"]


def rows():
    """What the structure of (A.17) saves, computed."""
    sizes = (2, 6, 100, 1000)
    ratios = [_free(2 * n) / _free(n) for n in sizes]
    yield Row(
        "appendix_a",
        "the number of variables with diag(X, X) in place of P",
        "(A.17)",
        "divided by four",
        ", ".join(f"{ratio:.2f} for n = {n}" for n, ratio in zip(sizes, ratios)),
        claim(abs(ratios[-1] - 4) < 0.01),
        "free entries of a symmetric matrix of 2n rows and of one of n rows: "
        "(4n + 2) / (n + 1), which tends to four; tested for n = 1000",
    )


def _free(n):
    """Number of free entries of a symmetric matrix of n rows."""
    return n * (n + 1) // 2
