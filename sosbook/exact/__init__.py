"""Blocks decided in rational numbers: proofs, multipliers, refusals."""
