"""Report the loose numbers of pages: ``python -m tests.prose [FILE ...]``."""

import argparse
from collections import Counter
from pathlib import Path

from . import check, numerals, pages, power


def report(path):
    """A page's report."""
    found, stale = check.loose(path)
    lines = [f"{path.name}: {len(found)} loose numbers, {len(stale)} stale entries"]
    lines += [str(loose) for loose in found]
    lines += [f"stale in tests/given/{path.stem}.toml: {phrase}" for phrase in stale]
    lines += list(vague(path))
    return "\n".join(lines)


def vague(path):
    """What only a reader can compare: twice, a third, half of."""
    for passage in check.read(path).passages:
        for match in numerals.VAGUE.finditer(passage.prose):
            around = passage.source[max(0, match.start() - 60) : match.end() + 60]
            yield (
                f"    by eye, cell {passage.cell}, line "
                f"{passage.line_of(match.start())}: {' '.join(around.split())}"
            )


def strength(paths):
    """How many changes of typed numbers are noticed, over all pages."""
    noticed, tried = Counter(), Counter()
    for path in paths:
        yes, all_of_them, _ = power.survey(path)
        noticed += yes
        tried += all_of_them
    for digits in sorted(tried):
        more = " or more" if digits == 4 else ""
        yield (
            f"{digits}{more} digits: {noticed[digits]} of {tried[digits]} "
            f"changes noticed, {noticed[digits] / tried[digits]:.0%}"
        )


def main():
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument(
        "--power",
        action="store_true",
        help="change each number and count what is noticed",
    )
    options = parser.parse_args()
    paths = [p.resolve() for p in options.files] or pages.all_pages()
    print(
        "\n".join(strength(paths)) if options.power else "\n\n".join(map(report, paths))
    )


if __name__ == "__main__":
    main()
