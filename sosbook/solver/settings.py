"""Numbers by which the solver chooses between ways, and ends them.

They are fields of one object. `Blocks` carry it, so that whatever solves them reads
the same numbers; `LMIProblem` takes another one as ``settings``. What is left in the
modules are thresholds of rounding, which belong to floats of sixteen digits.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """How blocks are solved.

    Factors of time are those of the catalogue's held-back half; the command
    ``python -m benchmarks.ablation`` measures them again on another machine.

    Parameters
    ----------
    table_per_product : float
        All slopes are held as one dense table while it has no more entries than this
        for each product L X R of the blocks; so many are read in the time of one
        product's calls. A machine's number. Without any table vertices of few masses
        take 1.5 times as long.
    most_table_entries : float
        Nor more than this: 32 MB.
    table_per_pair : float
        Newton's matrix is made of that table while it has no more entries than this
        for each two unknowns that share a block; else of Kronecker products. A
        machine's number.
    slabs_from_rows : int
        A symmetric unknown of so many rows brings its part of Newton's matrix row by
        row, without what lies below the diagonal. A machine's number; without it a
        plate takes 1.6 times as long.
    arrow_from_variables : int
        From here on it is looked at whether the matrix is an arrow, as with a slack
        matrix. A machine's number; with 32 vertices of five masses the arrow is
        twice as fast.
    iterations_per_variable : float
        Of conjugate gradients, in the time of a dense matrix and its factor, for each
        variable. A machine's number, read from chains and beams of 8 to 40 masses.
    expected_iterations : float
        Conjugate gradients are used where the matrix takes longer than so many
        iterations. Without them 40 masses take five times as long.
    most_iterations : int
        For one solution, where a dense matrix can take over.
    most_iterations_alone : int
        Where it can't.
    most_dense_variables : int
        A matrix of so many takes 300 MB; no larger one is made.
    line_search_above : float
        Newton decrements above it get a search along the step; below the full step
        converges (Boyd and Vandenberghe 2004, section 9.6.4).
    straight_below : float
        Steps of a smaller decrement aren't bent, for its square is nothing. Without
        curves vertices take up to three times as long.
    most_terms : int
        Of a curve's series; sixteen save one step in twenty.
    farthest_pole : float
        Of a curve: at 0.9 the sum of its series is at most ten times as far.
    longest_curve : float
        Where a curve is tried first, by the best step on the line.
    most_promised : float
        Decrements, by which a step shall lower the barrier at most.
    small_term, last_term : float
        A curve's term of this length is the last: far from the centre, and near.
    centre_decrement : float
        Of the last step to a centre; a bent step leaves its cube or less.
    slow_fall : float
        Of one step's decrement: what falls less isn't the last step to a centre,
        unless it is so much smaller than that one. A gain whose unit is 0.3 was 1e-5
        off where the steps crept.
    centre_decrement_iterative : float
        What conjugate gradients may leave of it.
    last_step_below : float
        A decrement after which one step by conjugate gradients is enough.
    steps_alone : int
        Of Newton's method, before a step of points and multipliers is tried. Without
        these and without curves a set may be taken for one without a centre.
    steps_before_directions : int
        Of Newton's method, before directions without an end are looked for; few sets
        that have a centre need more.
    far_step : float
        A point so many times as far from 0 as the one before has them looked for at
        once.
    barrier_steps : int
        Of the barrier method, before points and multipliers find a minimum.
    phase_one_steps, minimum_steps, centre_steps, deepest_steps : int
        The most steps of points and multipliers; usually some twenty are taken.
    step_fraction : float
        Of the longest step that stays inside.
    direction_tolerance : float
        Of conjugate gradients in such a step; later steps correct it.
    polishing_steps : int
        After a minimum is known; they bring the point nearer.
    """

    table_per_product: float = 15_000
    most_table_entries: float = 4e6
    table_per_pair: float = 10_000
    slabs_from_rows: int = 20
    arrow_from_variables: int = 300
    iterations_per_variable: float = 1 / 18
    expected_iterations: float = 65
    most_iterations: int = 300
    most_iterations_alone: int = 3000
    most_dense_variables: int = 6000
    line_search_above: float = 0.3
    straight_below: float = 1e-6
    most_terms: int = 8
    farthest_pole: float = 0.9
    longest_curve: float = 4.0
    most_promised: float = 1.5
    small_term: float = 0.1
    last_term: float = 1e-8
    centre_decrement: float = 1e-4
    slow_fall: float = 0.1
    centre_decrement_iterative: float = 1e-5
    last_step_below: float = 3e-3
    steps_alone: int = 15
    steps_before_directions: int = 6
    far_step: float = 3.0
    barrier_steps: int = 8
    phase_one_steps: int = 60
    minimum_steps: int = 40
    centre_steps: int = 100
    deepest_steps: int = 80
    step_fraction: float = 0.95
    direction_tolerance: float = 0.1
    polishing_steps: int = 3


DEFAULTS = Settings()
