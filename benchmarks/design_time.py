"""How long a slider waits: design, verdict, proof, against cvxpy.

Prints medians in milliseconds. Run ``python benchmarks/design_time.py``
with one thread (OMP_NUM_THREADS=1).
"""

import statistics
import time

import cvxpy

import sosbook as sos
from sosbook.lmi.conic import cvxpy_constraints
from sosbook.request import Request

REPEATS = 15


def median(function):
    """Median wall time of a call, in milliseconds, after a warm-up."""
    function()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        function()
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times)


def cvxpy_centre(request):
    """The same centre as sum of log det, through cvxpy and Clarabel."""
    constraints, P, Y = cvxpy_constraints(request)
    blocks = [c.args[0] for c in constraints]
    volume = sum(cvxpy.log_det(g) for g in blocks)
    cvxpy.Problem(cvxpy.Maximize(volume)).solve(solver="CLARABEL")
    return P, Y


def main():
    robot = sos.thesis.example_1()
    asked = robot.requirements
    impossible = dict(asked, gamma=0.1)
    design = sos.design_pid(robot.plant, **asked)
    refused = sos.design_pid(robot.plant, **impossible)

    def advise():
        return sos.design_pid(robot.plant, **impossible).advice

    rows = {
        "design_pid, feasible": lambda: sos.design_pid(robot.plant, **asked),
        "design_pid, infeasible": lambda: sos.design_pid(
            robot.plant, **impossible),
        "design_pid, infeasible, with advice": advise,
        "exact proof of a design": design.certify,
        "the same centre by cvxpy + Clarabel": lambda: cvxpy_centre(
            Request(robot.plant, **asked)),
    }
    assert refused.status == "infeasible"
    for name, function in rows.items():
        print(f"{median(function):8.1f} ms  {name}")


if __name__ == "__main__":
    main()
