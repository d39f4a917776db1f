"""Hunt for differences until the time is over, or one request that is named.

    python3 tasks.py hunt                   ten minutes from a seed of the day
    python3 tasks.py hunt --seconds 60      one minute
    python3 tasks.py hunt --seed 4711 --requests 1     this request again

Every difference is printed with the seed that makes it again. Exit code: 0 where
there was none, 1 where there was one.
"""

import argparse
import sys
import time
from contextlib import contextmanager

from tests import browser
from tests.hunt.differences import Hunt
from tests.hunt.readers import Page


def main(words=None):
    parser = argparse.ArgumentParser(
        prog="tasks.py hunt",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--seconds", type=float, default=600.0, help="how long; 600")
    add("--seed", type=int, default=int(time.time()) // 86400 * 10**6, help="the first")
    add("--requests", type=int, default=10**9, help="at most so many")
    asked = parser.parse_args(words)
    end = time.monotonic() + asked.seconds
    with page() as solver:
        hunt = Hunt(Page(solver) if solver else None)
        for seed in range(asked.seed, asked.seed + asked.requests):
            if time.monotonic() > end:
                break
            for difference in hunt.ask(seed):
                print(f"DIFFERENCE, {difference}", flush=True)
    print(hunt)
    return int(bool(hunt.differences))


@contextmanager
def page():
    """An empty page with the book's solver; None, and loud, without a browser."""
    from sosbook.book.elements.scripts import script

    path = browser.find()
    if path is None:
        print(f"THE PAGE IS NOT ASKED.\n{browser.MISSING}", file=sys.stderr)
        yield None
        return
    from playwright.sync_api import sync_playwright

    with sync_playwright() as engine:
        window = engine.chromium.launch(**browser.options(path))
        empty = window.new_page()
        empty.add_script_tag(content=script("kernel"))
        yield empty
        window.close()


if __name__ == "__main__":
    sys.exit(main())
