"""Keep every proof that a program makes: ``collect.start(folder)`` before it runs."""

import hashlib
from pathlib import Path

from sosbook.exact.proof_file import ProofFile


def start(folder):
    """Write each proof that is made from now on into a folder, named by its digest."""
    folder, of = Path(folder), ProofFile.of.__func__
    folder.mkdir(parents=True, exist_ok=True)

    def kept(cls, data):
        proof = of(cls, data)
        if proof.proven:
            name = hashlib.sha256(proof.text.encode()).hexdigest()[:16]
            proof.save(folder / f"{name}.json")
        return proof

    ProofFile.of = classmethod(kept)
