"""Proofs as files: reading them, and a checker that stands alone.

A file is a text with data, which a kernel checks that knows no control; the folder
``CHECKER`` holds it, and what writes the texts beside the words that they prove. It
needs Python and nothing else: ``python checker proof.json``. The checker decides
every kind of file but two, and says so: sampled loops (exponentials of matrices in
balls) and refusals by the slow modes of a delayed plant (eigenvalues in balls). These
``verify`` decides, or ``python -m sosbook verify proof.json``.
"""

from ..exact.checker import CHECKER
from ..exact.proof_file import KINDS, ProofFile, kinds, load
from ..exact.refusal import Refusal
from ..runtime.later import by_name

__all__ = ["CHECKER", "ProofFile", "Refusal", "kinds", "load"]
_HOMES = {name: home for home, name in (x.rsplit(".", 1) for x in KINDS.values())}
__all__ += sorted(_HOMES)
__getattr__ = by_name(__name__, _HOMES)
