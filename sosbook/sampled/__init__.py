"""Control by a computer: sample, compute, hold."""

from .discretize import c2d, sampled_loop
from .furthest import furthest_sampled
from .lqr import SampledLQR, design_sampled_lqr, sampled_cost
from .proof import SampledProof, certify_sampled
from .system import SampledSystem

__all__ = [
    "SampledLQR",
    "SampledProof",
    "SampledSystem",
    "c2d",
    "certify_sampled",
    "design_sampled_lqr",
    "furthest_sampled",
    "sampled_cost",
    "sampled_loop",
]
