"""Proofs as files: reading them, and a checker that stands alone.

``check.py`` needs Python and nothing else; ``proof.schema.json`` says what a
file holds. The checker decides every kind of file but three, and says so:
sampled loops (exponentials of matrices in balls), matrices that are balls, and
refusals by the slow modes of a delayed plant (eigenvalues in balls). These
``verify`` decides, or ``python -m sosbook verify proof.json``.
"""

from pathlib import Path

from ..delay.certificates import DelayCertificate, DelayInfeasibility
from ..delay.modes_certificate import ModesInfeasibility
from ..exact.proof import ProofFile, kinds, load
from ..lmi.certificates import LMIInfeasibility, LMIProof
from ..sampled.certificate import SampledCertificate, SchurCertificate
from ..synthesis.certificates import Certificate, DesignInfeasibility
from ..synthesis.exclusion_certificates import (
    FixedModeCertificate,
    SingularMassCertificate,
)
from ..synthesis.observer_certificate import ObserverCertificate, ObserverInfeasibility
from ..synthesis.regularity import MassInfeasibility, RegularityCertificate
from ..synthesis.small_input_certificate import SmallInputCertificate
from ..synthesis.unreached import UnreachedResponseCertificate

__all__ = [
    "CHECKER",
    "Certificate",
    "DelayCertificate",
    "DelayInfeasibility",
    "DesignInfeasibility",
    "FixedModeCertificate",
    "LMIInfeasibility",
    "LMIProof",
    "MassInfeasibility",
    "ModesInfeasibility",
    "ObserverCertificate",
    "ObserverInfeasibility",
    "ProofFile",
    "RegularityCertificate",
    "SampledCertificate",
    "SchurCertificate",
    "SingularMassCertificate",
    "SmallInputCertificate",
    "UnreachedResponseCertificate",
    "kinds",
    "load",
]

CHECKER = Path(__file__).with_name("check.py")
