"""Control by a computer: sample, compute, hold."""

from .discretize import hold, sampled_loop
from .lqr import SampledLQR, design_sampled_lqr, sampled_cost
from .proof import SampledCertificate, certify_sampled, prove_schur

__all__ = [
    "SampledCertificate",
    "SampledLQR",
    "certify_sampled",
    "design_sampled_lqr",
    "hold",
    "prove_schur",
    "sampled_cost",
    "sampled_loop",
]
