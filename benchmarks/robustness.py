"""Verdicts of `design_pid` on random requests that are decided already.

``python -m benchmarks.robustness [count] [first] [largest]`` solves
``count`` (1000) of the requests of ``tests.random_plants``, from the
seed ``first`` (0) on, with up to ``largest`` (8) degrees of freedom, each
of them in five systems of units, with a few CPU seconds for each. To every
fifth one comes an attack: a controllable plant, of which only the place
of its poles is asked, with a gain that puts them there exactly. Each gain
is checked by the interval arithmetic of `benchmarks.truth`, each refusal
needs an exact proof.

Numbers are multiplied by units in floats, so that plants in other units
differ in their last digits. That is a change of the physics for one sort of
requests: those whose mode is out of the inputs' reach but for rounding. A
plant in one of the units may be controllable, by a part in 1e17, and another
one not. Such requests are counted apart, as "by rounding".

What came out goes into ``robustness.json`` next to
this file; ``_build/robustness.jsonl`` keeps what was judged already, and a
run that is cut off goes on from there.
"""

import json
import signal
import sys
import time
from collections import Counter
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from unittest.mock import patch

import numpy as np
from tqdm import tqdm

import sosbook as sos
from sosbook.runtime import time_limit
from sosbook.synthesis import feasibility
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests import clarabel
from tests.attacks import attack
from tests.random_plants import ROUNDED, Units, float_blocks, random_case, scaled

from .truth import broken

TARGET = Path(__file__).with_name("robustness.json")
ROWS = TARGET.parents[1] / "_build" / "robustness.jsonl"
SLOW = 2.0  # CPU seconds
TIME = 10.0  # CPU seconds that a request is given
LIMIT = 60  # CPU seconds, after which a request counts as an error
ATTACKED = 5  # an attack to every fifth request
CROSS_CHECK = 5  # every fifth request goes to Clarabel, too
DIGITS = (6, 12, 17)
EXACT = {
    "FixedModeRefusal": "uncontrollable mode",
    "SingularMassRefusal": "singular mass",
    "SmallInputRefusal": "small input",
    "UnreachedResponseRefusal": "unreached response",
}


@dataclass(frozen=True)
class Row:
    """What became of one request.

    Parameters
    ----------
    seed, n, m, vertices : int
    kind, known, reason : str
        The kind of request, its known verdict, and why it is known.
    verdict : str
        The answer, or "error: ..." with an exception's text.
    backing : str
        Of "feasible": "6 digits", "12 digits", "17 digits", the length
        of the gain that was certified. Of "infeasible": "exact
        multipliers", "uncontrollable mode", "singular mass", "small input",
        "unreached response". Otherwise "none".
    seconds : float
        CPU time of `design_pid` alone.
    elsewhere : tuple of str
        The verdicts in other units.
    faults : tuple of str
        What a gain breaks, and refusals without a proof, in all units.
    clarabel : float or None
        Clarabel's largest t with all blocks >= t I; None where it was
        not asked or failed.
    """

    seed: int
    kind: str
    known: str
    reason: str
    n: int
    m: int
    vertices: int
    verdict: str
    backing: str
    seconds: float
    clarabel: float = None
    elsewhere: tuple = ()
    faults: tuple = ()

    @property
    def wrong(self):
        """Whether the answer contradicts what is known."""
        return self.verdict in ("feasible", "infeasible") and (
            self.verdict != self.known
        )

    @property
    def contradicted(self):
        """Whether it is feasible in some units and infeasible in others."""
        return {"feasible", "infeasible"} <= {self.verdict, *self.elsewhere}

    @property
    def changed(self):
        """Whether there is another verdict in some units."""
        return bool(set(self.elsewhere) - {self.verdict})

    @property
    def by_rounding(self):
        """Whether a mode is within reach by the last digits of the data only."""
        return ROUNDED in self.reason

    @property
    def proven(self):
        """Whether the answer has an exact proof."""
        exact = "exact multipliers", *EXACT.values()
        return self.backing in (*exact, *(f"{k} digits" for k in DIGITS))


# units of time, length and force: newton and metre come first
SYSTEMS = {
    "kN, m": (1, 1, 1e-3),
    "N, mm": (1, 1e3, 1),
    "uN, mm, ms": (1e3, 1e3, 1e6),
    "MN, km, hours": (1 / 3600, 1e-3, 1e-6),
}


def in_units(case, time, length, force):
    """The plant and the requirements of a case in other units."""
    return asked_in_units(case.plant, case.requirements, time, length, force)


def asked_in_units(plant, asked, time, length, force):
    """A plant and the arguments of `design_pid` in other units."""
    units = Units(
        time,
        length * np.eye(plant.n),
        force * np.eye(plant.n),
        np.eye(plant.m) / force,
        np.eye(len(asked.get("U", ()))),
    )
    return units.plant(plant), units.requirements(asked)


def judge(case, ask_clarabel=False, systems=()):
    """Solve a `Case` and see what backs the answer.

    Returns
    -------
    Row
    """
    plant, asked = case.plant, case.requirements
    verdict, backing, faults, seconds = _answer(plant, asked)
    t = None
    if ask_clarabel and plant.n <= 3 and not verdict.startswith("error"):
        t = _clarabel(Request(plant, **asked))
    elsewhere = []
    for name in systems:
        there, _, more, _ = _answer(*in_units(case, *SYSTEMS[name]))
        elsewhere.append(there)
        faults += [f"{name}: {fault}" for fault in more]
    return Row(
        case.seed,
        case.kind,
        case.verdict,
        case.reason,
        plant.n,
        plant.m,
        len(plant.vertices),
        verdict,
        backing,
        round(seconds, 3),
        t,
        tuple(elsewhere),
        tuple(faults),
    )


def _answer(plant, asked):
    """Verdict, backing, faults and CPU seconds of one request."""
    start = time.process_time()
    try:
        with cpu_time_limits(), at_most(LIMIT):
            design = sos.design_pid(plant, **asked, search=sos.Search(time_limit=TIME))
    except Exception as error:  # whatever it is, it is a failure
        text = f"error: {type(error).__name__}: {error}"[:200]
        return text, "none", [text], time.process_time() - start
    seconds = time.process_time() - start
    backing, faults = _backing(design), []
    if design.status == "feasible":
        faults = broken(plant, asked, design.K)
    if design.status == "infeasible" and backing == "none":
        faults = ["a refusal without proof"]
    return design.status, backing, faults, seconds


@contextmanager
def cpu_time_limits():
    """Let ``time_limit=`` count CPU seconds, which a busy machine doesn't use up."""
    with (
        patch.object(time_limit, "monotonic", time.process_time),
        patch.object(feasibility, "monotonic", time.process_time),
    ):
        yield


@contextmanager
def at_most(seconds):
    """Raise a TimeoutError after so many CPU seconds, where the system can."""

    def stop(*_):
        raise TimeoutError(f"no answer in {seconds} CPU s")

    if not hasattr(signal, "SIGPROF"):
        yield
        return
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def _backing(design):
    """What supports the verdict of a design."""
    if design.status == "feasible":
        for digits in DIGITS:
            if design.certify(digits).proven:
                return f"{digits} digits"
    if design.status == "infeasible":
        proof = design.infeasibility
        if proof is not None and proof.proven:
            return EXACT.get(type(proof).__name__, "exact multipliers")
    return "none"


def _clarabel(request):
    """Clarabel's largest t with G >= t I, in the request's frame."""
    blocks = float_blocks(request, Frame.of(request))
    if not any(c.any() for c in blocks.constants):  # read P > 0 as P > I
        first = -np.eye(request.order)
        blocks = clarabel.Explicit([first] + blocks.constants[1:], blocks.slopes)
    _, t, status = clarabel.deepest(scaled(blocks))
    return float(t) if status == "Solved" else None


def summary(rows):
    """Counts, and the seeds of all that went wrong."""

    def seeds(test):
        return [r.seed for r in rows if test(r)]

    def table(key, among=rows):
        return dict(sorted(Counter(key(r) for r in among).items()))

    data = [r for r in rows if not r.by_rounding]
    feasible = [r for r in rows if r.verdict == "feasible"]
    infeasible = [r for r in rows if r.verdict == "infeasible"]
    asked = [r for r in rows if r.clarabel is not None]
    against = [
        r
        for r in asked
        if abs(r.clarabel) > 1e-4
        and r.verdict in ("feasible", "infeasible")
        and (r.clarabel > 0) != (r.verdict == "feasible")
    ]
    times = np.array([r.seconds for r in rows])
    slowest = sorted(rows, key=lambda r: -r.seconds)[:10]
    return {
        "requests": len(rows),
        "kinds": table(lambda r: f"{r.kind}, known {r.known}"),
        "verdicts": table(lambda r: f"{r.kind}, known {r.known}: {r.verdict[:10]}"),
        "feasible": table(lambda r: r.backing, feasible),
        "infeasible": table(lambda r: r.backing, infeasible),
        "undecided share": _undecided(rows),
        "undecided share, not by rounding": _undecided(data),
        "wrong": {
            "feasible, called infeasible": seeds(
                lambda r: r.wrong and r.known == "feasible" and not r.proven
            ),
            "infeasible, called feasible": seeds(
                lambda r: r.wrong and r.known == "infeasible" and not r.proven
            ),
        },
        "units": {
            "asked": sum(bool(r.elsewhere) for r in rows),
            "feasible here, infeasible there": seeds(lambda r: r.contradicted),
            "another verdict": seeds(lambda r: r.changed and not r.by_rounding),
            "another verdict, by rounding": seeds(
                lambda r: r.changed and r.by_rounding
            ),
        },
        "by rounding": table(
            lambda r: r.verdict[:10], [r for r in rows if r.by_rounding]
        ),
        "faults": {str(r.seed): r.faults for r in rows if r.faults},
        "known verdict disproven": seeds(lambda r: r.wrong and r.proven),
        "undecided": seeds(lambda r: r.verdict == "undecided"),
        "errors": {
            str(r.seed): r.verdict for r in rows if r.verdict.startswith("error")
        },
        "feasible, not certified": seeds(
            lambda r: r.verdict == "feasible" and r.backing == "none"
        ),
        "infeasible, no backing": seeds(
            lambda r: r.verdict == "infeasible" and r.backing == "none"
        ),
        "Clarabel": {
            "asked": len(asked),
            "disagrees": [r.seed for r in against],
            "disagrees with a proof": [r.seed for r in against if r.proven],
        },
        "seconds": {
            "median": round(float(np.median(times)), 3),
            "90 %": round(float(np.quantile(times, 0.9)), 3),
            "largest": round(float(times.max()), 3),
            "above 2 s": seeds(lambda r: r.seconds > SLOW),
        },
        "slowest": [
            dict(
                seed=r.seed,
                n=r.n,
                m=r.m,
                vertices=r.vertices,
                seconds=r.seconds,
                reason=r.reason,
            )
            for r in slowest
        ],
    }


def _undecided(rows):
    """The share of the rows without an answer."""
    return sum(r.verdict == "undecided" for r in rows) / max(len(rows), 1)


def main(count=1000, first=0, largest=8):
    known = {(r.seed, r.kind): r for r in _stored(largest)}
    rows = []

    def add(seed, make, **more):
        case = make()
        row = known.get((seed, case.kind))
        if row is None:
            row = judge(case, systems=SYSTEMS, **more)
            _store(row, largest)
        rows.append(row)

    for seed in tqdm(range(first, first + count), unit="request", disable=False):
        asked = seed % CROSS_CHECK == 0
        add(seed, lambda s=seed: random_case(s, largest), ask_clarabel=asked)
        if seed % ATTACKED == 0:
            add(seed, lambda s=seed: attack(s))
    found = {"first seed": first, "largest n": largest} | summary(rows)
    TARGET.write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    print(json.dumps(found, indent=1))


def _stored(largest):
    """The rows of earlier runs."""
    if not ROWS.exists():
        return
    for line in ROWS.read_text("utf-8").splitlines():
        fields = json.loads(line)
        if fields.pop("largest") == largest:
            yield Row(**fields)


def _store(row, largest):
    ROWS.parent.mkdir(exist_ok=True)
    with ROWS.open("a", encoding="utf-8") as file:
        file.write(json.dumps({"largest": largest} | asdict(row)) + "\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
