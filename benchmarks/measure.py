"""Time, memory and truth of one competitor on one case.

`Job.run` is one call, with both clocks and the answer's judgement. It runs
in a fresh process first (`trial`), which gives the peak memory and guards
against calls that take too long; what is quick runs again in this process,
in turns with the others (`rounds`).
"""

import multiprocessing
import resource
import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from .cases import CASES
from .peers import PEERS, NoAnswer

__all__ = ["Job", "record", "rounds", "trial"]

SMALLEST = 1e-9  # margin that floats can tell from zero
ONCE = 40  # size beyond which a complete design is timed as a whole only
LARGEST_EXCESS = 1e-3  # of a cost over the optimum

FIELDS = {
    "family": "example, chain, lqr, public, vertices, slider, answers, map or designs",
    "case": "name of the plant and its requirements",
    "n": "degrees of freedom",
    "states": "N = 2n + a",
    "unknowns": "free numbers in P and Y (and J)",
    "vertices": "of the polytope",
    "competitor": "who solved it",
    "coordinates": "raw: the plant's own; frame: sosbook's well conditioned ones",
    "clock": "end to end: from the plant to the gain, compiling included; "
    "solve only: with the data in the solver's own form (not for "
    "those who compile each time); else what the words say",
    "formulation": "the question that was put to the solver",
    "note": "what else to know",
    "status": "right; wrong: its answer breaks a block; no answer; over the "
    "limit; not tried: over the limit on a smaller case, or out of "
    "its range; not installed",
    "margin": "smallest eigenvalue of all blocks at the answer, each "
    "diagonal scaled to one, in the plant's own coordinates; "
    "right demands more than 1e-9, except for lqr",
    "excess": "lqr only: true cost of the loop over the Riccati optimum, "
    "relative; right demands less than 1e-3",
    "median_s": "median wall time of a call in seconds, None unless right",
    "min_s": "the shortest",
    "repeats": "how many calls; 1 means the call in a fresh process",
    "base_mb": "resident memory before the call, MB, of a fresh process in "
    "which all competitors are imported",
    "peak_mb": "its peak during the call",
    "ratio": "median over sosbook's for the same case and clock",
    "limit_s": "time that a call was allowed",
    "count": "how many designs, moves or specifications the time is for",
    "measured": "how many of them were measured, if the rest is scaled",
    "solves": "how many LMI problems were solved",
    "agreement": "share of verdicts that equal the one-by-one verdicts",
    "share_solver": "of the time, slider moves",
    "share_simulation": "of the time: poles and response",
    "share_drawing": "of the time: SVG and tables as text",
}


def record(**values):
    """A flat record with every field; unknown names are refused."""
    if wrong := set(values) - set(FIELDS):
        raise ValueError(f"{sorted(wrong)} aren't fields of a record")
    return dict.fromkeys(FIELDS) | values


@dataclass(frozen=True)
class Job:
    """One competitor on one case.

    Parameters
    ----------
    case, peer : str
        Names in `CASES` and `PEERS`.
    coordinates : {"raw", "frame"}
    """

    case: str
    peer: str
    coordinates: str

    def record(self, **values):
        peer = PEERS[self.peer]
        case = CASES[self.case]
        formulation = peer.formulation
        if case.family == "lqr":
            formulation = "minimise tr J (Theorem 2.4)"
        return record(
            family=case.family,
            case=self.case,
            competitor=self.peer,
            coordinates=self.coordinates,
            formulation=formulation,
            note=peer.note,
            **values,
        )

    def sizes(self):
        plant, asked = CASES[self.case].build()
        task = CASES[self.case].kind.of(plant, asked, "raw")
        unknowns = task.unknowns
        return dict(
            n=plant.n,
            states=unknowns[0].shape[0],
            unknowns=sum(u.size for u in unknowns),
            vertices=len(plant.vertices),
        )

    def run(self):
        """One call.

        Returns
        -------
        times : dict
            Seconds by clock.
        judgement : dict
            margin and, for lqr, excess.

        Raises
        ------
        NoAnswer
        """
        case, peer = CASES[self.case], PEERS[self.peer]()
        plant, asked = case.build()
        times = {}
        if peer.whole is None or case.size <= ONCE:
            start = time.perf_counter()
            task = case.kind.of(plant, asked, self.coordinates)
            data = peer.prepare(task)
            ready = time.perf_counter()
            answer = peer.solve(data)
            times["solve only"] = time.perf_counter() - ready
            task.gain(*answer)
            times["end to end"] = time.perf_counter() - start
            judgement = task.judge(*answer)
        if peer.whole is not None:
            start = time.perf_counter()
            design = peer.whole(plant, **asked)
            times["end to end"] = time.perf_counter() - start
            if design.P is None:
                raise NoAnswer(design.status)
            judgement = dict(margin=min(design.margins.values()))
        times = {c: s for c, s in times.items() if c in peer.clocks}
        return times, {k: float(v) for k, v in judgement.items()}


def status(judgement):
    if "excess" in judgement:
        return "right" if judgement["excess"] < LARGEST_EXCESS else "wrong"
    return "right" if judgement["margin"] > SMALLEST else "wrong"


def trial(job, limit):
    """One call in a fresh process: a dict with status, times, memory.

    The process is forked from one that has imported every competitor and
    solved nothing, so that all start alike.
    """
    ours, theirs = CONTEXT.Pipe(duplex=False)
    process = CONTEXT.Process(target=_alone, args=(job, theirs))
    process.start()
    theirs.close()
    try:
        answered = ours.poll(limit + 10)  # the rest is for its start
        found = ours.recv() if answered else dict(status="over the limit")
    except EOFError:
        found = dict(status="no answer", why="its process died")
    process.kill()
    process.join()
    if max(found.get("times", {}).values(), default=0) > limit:
        return dict(status="over the limit")
    return found


def _context():
    ways = multiprocessing.get_all_start_methods()
    way = "forkserver" if "forkserver" in ways else "spawn"
    context = multiprocessing.get_context(way)
    if way == "forkserver":
        names = {peer.package for peer in PEERS.values()}
        context.set_forkserver_preload(["benchmarks.__main__", *names])
    return context


CONTEXT = _context()


def _alone(job, pipe):
    """The fresh process's work."""
    warm = "pendulum LQR" if CASES[job.case].family == "lqr" else "chain 2"
    try:
        Job(warm, job.peer, "frame").run()  # libraries are loaded now
    except NoAnswer:
        pass
    base = memory("VmRSS")
    try:
        times, judgement = job.run()
        found = dict(status=status(judgement), times=times, **judgement)
    except NoAnswer as error:
        found = dict(status="no answer", times={}, why=str(error)[:200])
    except Exception as error:  # a peer's failure is a finding
        found = dict(
            status="no answer", times={}, why=f"{type(error).__name__}: {error}"[:200]
        )
    pipe.send(found | dict(base_mb=base, peak_mb=memory("VmHWM")))


def rounds(jobs, budget, most=15):
    """Call the jobs in turns: A B C A B C.

    Parameters
    ----------
    jobs : dict
        From `Job` to the seconds of its trial.
    budget : float
        Seconds for all.

    Returns
    -------
    dict
        From `Job` to a dict from clock to its times.
    """
    each = sum(jobs.values())
    count = min(most, max(3, int(budget / each))) if jobs else 0
    found = {job: {} for job in jobs}
    for turn in range(-1, count):  # one to warm up
        for job, seconds in jobs.items():
            if turn < 0 and seconds > 0.3:
                continue
            times, judgement = job.run()
            if status(judgement) != "right":
                raise AssertionError(f"{job} was right and is now wrong")
            for clock, seconds in times.items() if turn >= 0 else ():
                found[job].setdefault(clock, []).append(seconds)
    return found


def summary(times):
    return dict(median_s=statistics.median(times), min_s=min(times), repeats=len(times))


def memory(key):
    """VmRSS or VmHWM of this process, in MB.

    ``ru_maxrss`` would include what the parent held when it forked.
    """
    try:
        lines = Path("/proc/self/status").read_text("utf-8").splitlines()
    except OSError:
        unit = 1 if sys.platform == "darwin" else 1024
        used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return used * unit / 2**20
    words = next(line for line in lines if line.startswith(key)).split()
    return int(words[1]) / 1024
