"""A plugin of pytest: CPU seconds of each test, stored, and of the longest files.

``pytest -p tests.durations`` writes ``_build/durations.json``: of each test the seconds
of its processor, with those of its fixtures and of processes that ended in it.
"""

import json
import os
from collections import Counter

import pytest

BEGUN = pytest.StashKey()
SHOWN = 25
seconds = {}


def spent():
    """CPU seconds of this process and of those that it has waited for."""
    return sum(os.times()[:4])


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    item.stash[BEGUN] = spent()
    return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item):
    """The report of its end takes the number from a worker to who prints."""
    try:
        return (yield)
    finally:
        item.user_properties.append(("cpu", spent() - item.stash[BEGUN]))


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
