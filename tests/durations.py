"""A plugin of pytest: CPU seconds of each test, stored, and of the longest files.

``pytest -p tests.durations`` writes ``_build/durations.json``: of each test the seconds
of its processor, with those of its fixtures and of processes that it started or, as a
browser, used; on other systems than Linux only of those that ended in it.
"""

import json
import os
from collections import Counter

import pytest

ENDED = pytest.StashKey()
SHOWN = 25
seconds = {}


def spent():
    """CPU seconds of this process and its children, the ended and the living; of two
    readings the larger, for a child that ends during one is missing from it.
    """
    before = os.times()
    others = living("self")
    if not others and os.times()[2:4] == before[2:4]:
        return sum(before[:4])
    return max(sum(before[:4]) + others, sum(os.times()[:4]) + living("self"))


def living(process):
    """CPU seconds of a process's living descendants, where /proc lists them."""
    found = 0.0
    for thread in threads(process):
        for child in read(f"/proc/{process}/task/{thread}/children").split():
            # User and system, its own and of those that it has waited for.
            ticks = read(f"/proc/{child}/stat").rpartition(")")[2].split()[11:15]
            found += sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK") + living(child)
    return found


def threads(process):
    """The numbers of a process's threads; none of one that has ended."""
    try:
        return os.listdir(f"/proc/{process}/task")
    except OSError:
        return []


def read(path):
    """A file's text; none of a process that has ended."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError:
        return ""


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    if ENDED not in item.session.stash:  # a test begins where the one before ended
        item.session.stash[ENDED] = spent()
    return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item):
    """The report of its end takes the number from a worker to who prints."""
    before = spent()
    try:
        return (yield)
    finally:  # a browser that ends here leaves processes whose seconds nobody gets
        begun, ended = item.session.stash[ENDED], spent()
        item.user_properties.append(("cpu", max(before, ended) - begun))
        item.session.stash[ENDED] = ended


def pytest_runtest_logreport(report):
    if report.when == "teardown":
        seconds[report.nodeid] = round(dict(report.user_properties)["cpu"], 3)


def pytest_terminal_summary(terminalreporter, config):
    files = Counter()
    for name, spent in seconds.items():
        files[name.split("::")[0]] += spent
    target = config.rootpath / "_build" / "durations.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(Counter(seconds).most_common(), indent=0), "utf-8")
    tr = terminalreporter
    tr.section(f"{files.total():.0f} CPU seconds; each test's are in {target}")
    for name, spent in files.most_common(SHOWN):
        tr.line(f"{spent:8.1f} s  {name}")
