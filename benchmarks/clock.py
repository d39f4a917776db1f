"""CPU time, memory and truth of one competitor on one plant.

Each has a process of its own, forked from one that has imported everybody and
solved nothing. CPU time of the process and its children is what is measured,
not the time that passes: a busy computer changes it little. A call that uses
more than its limit of seconds or memory ends its process. Under such a limit
Linux counts in ticks of milliseconds: short calls are timed many at once.
"""

import multiprocessing
import signal
import statistics
import sys
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path

try:
    import resource
except ModuleNotFoundError:  # Windows has no such limits
    resource = None

from .catalogue import FAMILIES, case
from .competitors import COMPETITORS
from .questions import KINDS, NoAnswer, right

SECONDS = 20.0  # of CPU time that a call may take
MEMORY = 4096  # MB that a call may ask for
ENOUGH = 0.6  # seconds of calls after which a time is known well enough
MOST = 7  # times that are measured
TICKS = 25  # of the clock, that a measured time has at least
PATIENCE = 12  # a process may take so many times its CPU time, on a busy computer
OVER = "over the limit"


@dataclass(frozen=True)
class Job:
    """One competitor on one plant of a family.

    Parameters
    ----------
    family : str
    size : int
    competitor : str
    seconds : float
        Limit of the CPU time of a call.
    """

    family: str
    size: int
    competitor: str
    seconds: float = SECONDS

    def run(self, framed=False):
        """All calls: (seconds, those for the data), and the judgement of the last."""
        given = FAMILIES[self.family].make(self.size)
        competitor = COMPETITORS[self.competitor]()
        make = _maker(FAMILIES[self.family].kind, given, framed)
        competitor.prepare(make)
        at_once = 1
        spent, judgement = calls(competitor, make)
        while right(judgement) and at_once * spent[0] < TICKS * tick():
            at_once *= 2
            spent, judgement = calls(competitor, make, at_once)
        times = [spent] * at_once
        while right(judgement) and not _enough(times, at_once):
            spent, judgement = calls(competitor, make, at_once)
            times += [spent] * at_once
        return times, judgement


def _maker(kind, given, framed):
    return lambda: KINDS[kind](*given, framed)


def _enough(times, at_once):
    return sum(whole for whole, _ in times) >= ENOUGH or len(times) >= MOST * at_once


def calls(competitor, make, count=1):
    """CPU seconds of a call, of ``count`` in a row, and the last one's judgement.

    A call goes from the plant to the answer; the second number is its part until the
    data are finished.
    """
    begin = cpu()
    ready = [competitor.ready(make) for _ in range(count)]
    finished = cpu()
    for call in ready:
        question, answer = call()
    spent = (cpu() - begin) / count, (finished - begin) / count
    return spent, {k: float(v) for k, v in question.judge(answer).items()}


@cache
def tick():
    """The step of `cpu` in seconds, the largest of a few.

    A clock that counts in ticks makes a smaller step where the system takes the
    processor away.
    """
    steps = []
    for _ in range(5):
        begin = cpu()
        while (now := cpu()) == begin:
            pass
        steps.append(now - begin)
    return max(steps)


def cpu():
    """CPU seconds of this process and its children, which have ended."""
    if resource is None:
        return time.process_time()
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + ended.ru_utime + ended.ru_stime


def trial(job):
    """A job in a process of its own: status, times, memory.

    Returns
    -------
    dict
        ``status`` is "right", "wrong", "no answer" or "over the limit"; with
        ``cpu_s`` and ``data_s``, medians, ``calls``, ``coordinates``, ``margin`` or
        ``excess``, ``base_mb`` and ``peak_mb``, and ``why`` there is no answer.
    """
    ours, theirs = CONTEXT.Pipe(duplex=False)
    process = CONTEXT.Process(target=_alone, args=(job, theirs))
    process.start()
    theirs.close()
    try:
        answered = ours.poll(PATIENCE * (job.seconds + 5))
        found = ours.recv() if answered else dict(status=OVER, why="the clock's")
    except EOFError:
        process.join(10)
        late = process.exitcode == -getattr(signal, "SIGXCPU", 0)
        words = "CPU time" if late else f"its process ended with {process.exitcode}"
        found = dict(status=OVER if late else "no answer", why=words)
    process.kill()
    process.join()
    return found


def _context():
    ways = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context(
        "forkserver" if "forkserver" in ways else "spawn"
    )
    if "forkserver" in ways:
        names = {c.package for c in COMPETITORS.values() if c.installed()}
        context.set_forkserver_preload(["benchmarks.clock", *sorted(names)])
    return context


CONTEXT = _context()


def _alone(job, pipe):
    """The process's work: in the plant's coordinates, then in sosbook's."""
    competitor = COMPETITORS[job.competitor]
    _warm(FAMILIES[job.family].kind, competitor())
    base = memory("VmRSS")
    _reset_peak()
    _limit_memory()
    frames = (True,) if competitor.name == "sosbook" else (False, True)
    for framed in frames:
        _limit_cpu(job.seconds + (ENOUGH if job.seconds > ENOUGH else 0))
        found = _tried(job, framed)
        found["coordinates"] = "frame" if framed else "raw"
        if found["status"] == "right" or found["status"] == OVER:
            break
    pipe.send(found | dict(base_mb=base, peak_mb=memory("VmHWM")))


def _tried(job, framed):
    try:
        times, judgement = job.run(framed)
    except NoAnswer as error:
        return dict(status="no answer", why=str(error)[:200])
    except Exception as error:  # a competitor's failure is a finding
        words = f"{type(error).__name__}: {error}"[:200]
        return dict(status="no answer", why=words)
    seconds, data = map(statistics.median, zip(*times))
    found = dict(cpu_s=seconds, data_s=data, calls=len(times), **judgement)
    if judgement.get("excess") == float("inf"):
        found["excess"] = None
    if not right(judgement):
        return found | dict(status="wrong", why=f"after {seconds:.3g} s")
    if seconds > job.seconds:
        return found | dict(status=OVER, why=f"{seconds:.3g} s")
    return found | dict(status="right")


def _warm(kind, competitor):
    """A small question of the kind, so that libraries are loaded."""
    name = next(n for n, f in FAMILIES.items() if f.kind == kind)
    given = FAMILIES[name].make(FAMILIES[name].sizes[0])
    make = _maker(kind, given, True)
    try:
        competitor.prepare(make)
        competitor.answer(make)
    except NoAnswer:
        pass


def _limit_memory():
    """No more memory than now and `MEMORY`."""
    if sys.platform == "linux":
        limit = int((memory("VmSize") + MEMORY) * 2**20)
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))


def _limit_cpu(seconds):
    """End the process where it uses more, beside what it used so far."""
    if resource is None:  # then `PATIENCE` is the limit
        return
    soft = int(cpu() + seconds + 1)
    resource.setrlimit(resource.RLIMIT_CPU, (soft, resource.RLIM_INFINITY))


def memory(key):
    """VmRSS, VmHWM or VmSize of this process, in MB."""
    try:
        lines = Path("/proc/self/status").read_text("utf-8").splitlines()
    except OSError:
        if resource is None:
            return None
        unit = 1 if sys.platform == "darwin" else 1024
        used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return used * unit / 2**20
    words = next(line for line in lines if line.startswith(key)).split()
    return int(words[1]) / 1024


def _reset_peak():
    """Forget what was used before; where the system can't, nothing happens."""
    try:
        Path("/proc/self/clear_refs").write_text("5", "utf-8")
    except OSError:
        pass


def sizes(family, size):
    """n, states, unknowns and vertices of a family's plant."""
    question = case(family, size, True)
    _, unknowns = question.expressions()
    plant = question.plant
    return dict(
        n=plant.n,
        m=plant.m,
        unknowns=sum(u.size for u in unknowns),
        vertices=len(plant.vertices),
    )
