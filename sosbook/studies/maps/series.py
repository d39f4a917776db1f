"""Many designs in a row, each of which starts from the last."""

from dataclasses import replace

import numpy as np

from ...synthesis.pid import design_pid
from ...synthesis.search import USUAL
from .parallel import sweep

DESIGNS_PER_PROCESS = 25  # in a row


def designs(plant, specifications, n_jobs=None, progress=True):
    """A design for each of many specifications.

    Each one starts from the last, if that was feasible: list neighbours
    next to each other.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.
    specifications : sequence of dict
        Keywords of `design_pid`. Without a word its coupling is "pairs"; with a
        ``law`` it has none, and each gain is searched anew.
    n_jobs, progress
        As in `sweep`; a worker takes 25 specifications at a time.

    Returns
    -------
    list of Design
        Those of `design_pid`, whatever the order and the workers.

    Raises
    ------
    ValueError
        If a specification isn't a dict, or a value in it is bad.

    Examples
    --------
    >>> import sosbook as sos
    >>> from sosbook.book import thesis
    >>> robot = thesis.example_1()
    >>> grid = designs(robot.plant, [
    ...     robot.requirements | dict(gamma=sos.HInfinity(g, mu=1))
    ...     for g in (0.3, 1, 2)])
    >>> [design.status for design in grid]
    ['infeasible', 'feasible', 'feasible']
    """
    specifications = list(specifications)
    for place, asked in enumerate(specifications):
        if not isinstance(asked, dict):
            raise ValueError(
                f"specification {place} must be a dict of keywords of "
                f"design_pid, got {type(asked).__name__}"
            )

    def solve(run):
        """The designs of a run of specifications, each started from the last."""
        designs_of_run, last = [], {}  # by the shape of U, and whether there is a law
        for asked in run:
            law = asked.get("law")
            shape = np.shape(getattr(law, "U", asked.get("U")))
            key = str(asked.get("coupling")), shape, getattr(law, "searched", False)
            how = asked.get("search", USUAL)
            usual = {"coupling": "pairs"}
            if key[2]:  # its loop has neither coupling nor a start
                usual = {}
            elif how.start is None:
                asked = asked | {"search": replace(how, start=last.get(key))}
            try:
                design = design_pid(plant, **usual | asked)
            except Exception as error:
                error.add_note(f"for the specification {asked!r}")
                raise
            designs_of_run.append(design)
            # next to a refusal the next one is probably refused, too
            last[key] = design if design.status == "feasible" else None
        return designs_of_run

    starts = range(0, len(specifications), DESIGNS_PER_PROCESS)
    runs = [specifications[k : k + DESIGNS_PER_PROCESS] for k in starts]
    return [d for run in sweep(solve, runs, n_jobs, progress) for d in run]
