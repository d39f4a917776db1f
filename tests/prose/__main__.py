"""Report the loose numbers of pages: ``python -m tests.prose [FILE ...]``."""

import argparse
from pathlib import Path

from . import check, pages


def report(path):
    """A page's report."""
    found, stale = check.loose(path)
    lines = [f"{path.name}: {len(found)} loose numbers, {len(stale)} stale entries"]
    lines += [str(loose) for loose in found]
    lines += [f"stale in tests/given/{path.stem}.toml: {phrase}" for phrase in stale]
    return "\n".join(lines)


def main():
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path)
    files = parser.parse_args().files
    paths = [path.resolve() for path in files] or pages.all_pages()
    print("\n\n".join(map(report, paths)))


if __name__ == "__main__":
    main()
