"""Numbers of a machine, by which the solver chooses between ways.

`Blocks` carry them, so that whatever solves them reads the same ones. Factors of time
are those of the catalogue's held-back half: ``python -m benchmarks.ablation`` measures
them again. Numbers that end a phase, and of rounding, stand beside their use.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """How blocks are solved: the numbers from which on a path is taken."""

    #: All slopes are one dense table while it has no more entries than this for each
    #: product L X R: so many are read in the time of one product's calls. Without any
    #: table vertices of few masses take 1.5 times as long.
    table_per_product: float = 15_000
    most_table_entries: float = 4e6  # 32 MB
    #: A symmetric unknown of so many rows brings its part of Newton's matrix row by
    #: row, without what is below the diagonal: a plate takes 1.6 times as long without.
    slabs_from_rows: int = 20
    #: From here on the matrix may be an arrow, as with a slack matrix, which is twice
    #: as fast with 32 vertices of five masses.
    arrow_from_variables: int = 300
    #: Of conjugate gradients, in the time of a dense matrix and its factor, for each
    #: variable: read from chains and beams of 8 to 40 masses.
    iterations_per_variable: float = 1 / 18
    #: Conjugate gradients are used where the matrix takes longer than so many
    #: iterations; without them 40 masses take five times as long.
    expected_iterations: float = 65
    most_dense_variables: int = 6000  # whose matrix takes 300 MB; no larger one is made
    #: Steps of a smaller decrement aren't bent, for its square is nothing. Without
    #: curves vertices take up to three times as long.
    straight_below: float = 1e-6


DEFAULTS = Settings()
