"""Proofs as files: reading them, and a checker that stands alone.

A file is a text with data, which a kernel checks that knows no control; the folder
``CHECKER`` holds it, and what writes the texts beside the words that they prove. It
needs Python and nothing else: ``python checker proof.json``. The checker decides
every kind of file but three, and says so: sampled loops (exponentials of matrices in
balls), refusals by the slow modes of a delayed plant (eigenvalues in balls), and
energies of large plants (sparse factors in floats). These
``verify`` decides, or ``python -m sosbook verify proof.json``.
"""

from ..delay.certificates import DelayCertificate, DelayRefusal
from ..delay.modes import ModesRefusal
from ..exact.checker import CHECKER
from ..exact.proof_file import ProofFile, kinds, load
from ..exact.refusal import Refusal
from ..lmi.certificates import LMIProof, LMIRefusal
from ..sampled.certificate import SampledCertificate
from ..synthesis.certificates import Certificate, DesignRefusal
from ..synthesis.fixed_mode import FixedModeRefusal, SingularMassRefusal
from ..synthesis.known_certificate import KnownGainProof
from ..synthesis.observer_problem import ObserverCertificate, ObserverRefusal
from ..synthesis.regularity import MassRefusal, RegularityCertificate
from ..synthesis.small_input_certificate import SmallInputRefusal
from ..synthesis.structured.any_order import AnyOrder
from ..synthesis.structured.doors import SumOfPoles
from ..synthesis.unreached import UnreachedResponseRefusal
from ..synthesis.whole import EnergyProof

__all__ = [
    "CHECKER",
    "AnyOrder",
    "Certificate",
    "DelayCertificate",
    "DelayRefusal",
    "DesignRefusal",
    "EnergyProof",
    "FixedModeRefusal",
    "KnownGainProof",
    "LMIProof",
    "LMIRefusal",
    "MassRefusal",
    "ModesRefusal",
    "ObserverCertificate",
    "ObserverRefusal",
    "ProofFile",
    "Refusal",
    "RegularityCertificate",
    "SampledCertificate",
    "SingularMassRefusal",
    "SmallInputRefusal",
    "SumOfPoles",
    "UnreachedResponseRefusal",
    "kinds",
    "load",
]
