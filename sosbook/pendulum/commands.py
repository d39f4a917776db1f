"""What the command does besides the chain: record, check and compare."""

import argparse
from pathlib import Path

from ..runtime.saying import say
from .comparison import compare, write_comparison
from .deployment import described_or_none
from .recorded import EXPERIMENTS, check_recording
from .recording import SWEEP_SECONDS, write_recorders

__all__ = ["COMMANDS", "REPLACE"]

#: The option of every command that writes programs.
REPLACE = {
    "action": "store_true",
    "help": "files of an earlier run that differ; without it nothing is written then",
}


def parser_of(name, text):
    """The parser of a command with this name, described by a text."""
    return argparse.ArgumentParser(
        prog=f"python -m sosbook.mip {name}", description=text, allow_abbrev=False
    )


def record(argv):
    """The command that writes the programs which record; returns their paths."""
    parser = parser_of("record", "Write programs that record the two logs.")
    parser.add_argument("robot", help="robot.toml")
    parser.add_argument("folder", nargs="?", default="recorders")
    parser.add_argument("--amplitude", type=float, help="of the sines, in V")
    parser.add_argument("--seconds", type=float, default=SWEEP_SECONDS)
    parser.add_argument("--replace", **REPLACE)
    asked = parser.parse_args(argv)
    paths = write_recorders(
        asked.robot,
        asked.folder,
        asked.replace,
        amplitude=asked.amplitude,
        seconds=asked.seconds,
    )
    for path in paths:
        say(f"wrote {path}")
    return paths


def check(argv):
    """The command that looks at logs; exits with 1 if one isn't usable."""
    parser = parser_of("check", "Say whether a log is usable, and why not.")
    parser.add_argument("logs", nargs="+", metavar="log.csv")
    parser.add_argument("--robot", help="robot.toml")
    parser.add_argument("--experiment", choices=EXPERIMENTS)
    asked = parser.parse_args(argv)
    robot = described_or_none(asked.robot)
    found = [check_recording(log, robot, asked.experiment) for log in asked.logs]
    for path, recording in zip(asked.logs, found):
        say(f"{path}: {recording.report}")
    if not all(recording.usable for recording in found):
        parser.exit(1)
    return found


def compared(argv):
    """The command that holds a running robot against its model."""
    parser = parser_of("compare", "Hold the log of a running program to its model.")
    parser.add_argument("log", metavar="log.csv")
    parser.add_argument("folder", nargs="?", default="deployment", help="its programs")
    asked = parser.parse_args(argv)
    comparison = compare(asked.log, asked.folder)
    path = write_comparison(comparison, Path(asked.log).parent)
    say(comparison.report)
    say(f"wrote {path}")
    return comparison


#: The commands by name; each takes the words after it.
COMMANDS = {"record": record, "check": check, "compare": compared}
