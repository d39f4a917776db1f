"""What exact arithmetic says of blocks, or of multipliers that exclude them."""

from dataclasses import dataclass

from .exact import definite, repair_multipliers

__all__ = ["InfeasibilityCertificate", "Proof", "refute"]


@dataclass(frozen=True, eq=False)
class Proof:
    """What exact arithmetic says of a design's blocks.

    Parameters
    ----------
    proven : bool
        Whether every block is positive definite, in rational arithmetic.
    claims : tuple of str
        What is proven, in words; empty without a proof.
    blocks : dict
        From a block's name to its smallest pivot, as a float (in large
        blocks to six digits: see `sosbook.lmi.exact.definite`).
    failed : tuple of str
        Names of the blocks that aren't positive definite.
    """

    proven: bool
    claims: tuple
    blocks: dict
    failed: tuple

    def __str__(self):
        if self.proven:
            return "\n- ".join(["proven:", *self.claims])
        return "not proven: " + ", ".join(self.failed)

    @staticmethod
    def of(blocks, claims):
        """Arguments of a `Proof`: check the blocks, claim if all hold.

        Parameters
        ----------
        blocks : dict
            From a name to a symmetric matrix of rationals.
        claims : tuple of str

        Returns
        -------
        dict
        """
        found = {name: definite(g) for name, g in blocks.items()}
        failed = tuple(n for n, (proven, _) in found.items() if not proven)
        return dict(
            proven=not failed, claims=() if failed else claims,
            blocks={n: float(size) for n, (_, size) in found.items()},
            failed=failed,
        )


@dataclass(frozen=True, eq=False)
class InfeasibilityCertificate:
    """Multipliers that exclude every design, by LMI duality.

    Parameters
    ----------
    proven : bool
        Whether the multipliers were made exact: then no P, Y exist.
    value : float
        sum <G_k0, Z_k>, not positive. A design would need it positive.
    multipliers : dict
        From a block's name to its multiplier Z_k (in the coordinates in
        which the LMIs were solved).
    """

    proven: bool
    value: float
    multipliers: dict


def refute(expressions, unknowns, Z):
    """Exact multipliers from float ones, where the repair succeeds.

    Parameters
    ----------
    expressions : dict
        From a block's name to its `Affine` expression in rationals.
    unknowns : list of Unknown
    Z : list of arrays

    Returns
    -------
    InfeasibilityCertificate
    """
    repaired = repair_multipliers(list(expressions.values()), unknowns, Z)
    names = list(expressions)
    if repaired is None:
        value = float(sum(
            (g.constant.astype(float) * z).sum()
            for g, z in zip(expressions.values(), Z)
        ))
        return InfeasibilityCertificate(False, value, dict(zip(names, Z)))
    multipliers, value = repaired
    return InfeasibilityCertificate(
        True, float(value), dict(zip(names, multipliers))
    )
