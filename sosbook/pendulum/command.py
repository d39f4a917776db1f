"""Identify a robot from two logs; write a proven program for it.

The robot is described in a TOML file, from which any number may differ
by an option. Without logs it takes those that the package ships, and
the description of their robot, the thesis's.

Other commands, each with its own --help: record (programs that record
the logs), check (one log) and compare (a running robot).
"""

import argparse
import sys
from dataclasses import fields
from pathlib import Path

from ..runtime.saying import say, visible
from .comparison import compare, write_comparison
from .deployment import deploy, described, described_or_none, inspect
from .recorded import EXPERIMENTS, check_recording
from .recording import SWEEP_SECONDS, write_recorders
from .report import write_report
from .rig import DATA
from .robot import LAWS, Robot
from .ticks import HEADER

OPTION_HELP = {
    "R": "weight of the voltage; without it the smallest is searched "
    "that keeps the peak",
    "spread": "of e/c and e/a, relative",
    "confidence": "0.99 for example: all five ratios are uncertain, in a box that "
    "holds the robot so probably, instead of two by the spread",
    "decay": "to be proven behind the hold, 1/s, at most",
    "peak": "of the sensitivity, at most (2)",
    "patience": "for a proof that lets delays and ticks vary, s; without it none",
}
#: The option of every command that writes programs.
REPLACE = {
    "action": "store_true",
    "help": "files of an earlier run that differ; without it nothing is written then",
}
USAGE = "%(prog)s [options] [[robot.toml] body.csv wheels.csv [folder]]"


def main(argv=None):
    """The command; returns the `Deployment`, or what another command found."""
    argv = sys.argv[1:] if argv is None else list(argv)
    command, words = chain, argv
    if argv and argv[0] in COMMANDS:
        command, words = COMMANDS[argv[0]], argv[1:]
    try:
        return command(words)
    except (OSError, ValueError) as error:
        sys.stderr.write(visible(f"{error}\n"))
        raise SystemExit(1) from None


def chain(argv):
    """The command that identifies, designs, proves and writes, of words ``argv``."""
    parser = argparse.ArgumentParser(
        prog="python -m sosbook.pendulum",
        description=__doc__,
        usage=USAGE,
        allow_abbrev=False,
    )
    parser.add_argument("paths", nargs="*", help="see above")
    parser.add_argument("--name", default="balance", help="of the programs")
    for name, text in OPTION_HELP.items():
        parser.add_argument(f"--{name}", type=float, help=text)
    about = dict(action="store_true", default=None)
    parser.add_argument("--force", help="go on with logs that are refused", **about)
    parser.add_argument("--replace", **REPLACE)
    parser.add_argument("--cells", type=int, help="for the sampled proofs")
    words = "diagonal of the weight of theta, phi, their rates and x3"
    parser.add_argument("--Q", type=float, nargs=5, metavar="q", help=words)
    keys = parser.add_argument_group(
        "keys of the description that differ from robot.toml's"
    )
    for x in fields(Robot):
        if x.type in (float, int):
            keys.add_argument(
                f"--{x.name}",
                *["--voltage"] * (x.name == "limit"),
                dest=x.name,
                type=x.type,
                help=", ".join(filter(None, (x.metadata["text"], x.metadata["unit"]))),
            )
        elif x.type is bool:
            keys.add_argument(
                f"--{x.name}",
                action=argparse.BooleanOptionalAction,
                help=x.metadata["text"],
            )
    keys.add_argument("--law", choices=LAWS, help="what the program computes")
    options = {
        name: value
        for name, value in vars(parser.parse_args(argv)).items()
        if value is not None
    }
    paths, name = options.pop("paths"), options.pop("name")
    replace = options.pop("replace")
    changes = {x.name: options.pop(x.name) for x in fields(Robot) if x.name in options}
    robot, body, wheels, folder = _places(paths)
    if robot is None:  # the thesis's, with the weight of the book
        options.setdefault("R", 20.0)
    robot = described(robot, (body, wheels)).but(**changes)
    report = write_report(inspect(body, wheels, robot), folder)
    say(f"wrote {report}")
    deployment = deploy(body, wheels, robot, **options)
    for word, text in deployment.facts.items():
        say(f"{word}: {text}")
    for path in deployment.write(folder, name, replace):
        say(f"wrote {path}")
    return deployment


def _places(paths):
    """The description or None, the two logs and the folder."""
    paths = list(paths)
    first = paths.pop(0) if paths and paths[0].endswith(".toml") else None
    if len(paths) not in (0, 2, 3) or (first and not paths):
        raise ValueError(
            "give robot.toml, body.csv and wheels.csv, and perhaps a "
            f"folder; got {' '.join(filter(None, [first, *paths]))!r}"
        )
    shipped = [DATA / "body.csv", DATA / "wheels.csv", "deployment"]
    return (first, *paths, *shipped[len(paths) :])


def parser_of(name, text):
    """The parser of a command with this name, described by a text."""
    return argparse.ArgumentParser(
        prog=f"python -m sosbook.pendulum {name}", description=text, allow_abbrev=False
    )


def record(argv):
    """The command, of words ``argv``, that writes programs which record: paths."""
    parser = parser_of("record", "Write programs that record the two logs.")
    parser.add_argument("robot", help="robot.toml")
    parser.add_argument("folder", nargs="?", default="recorders")
    parser.add_argument("--amplitude", type=float, help="of the sines, in V")
    parser.add_argument("--seconds", type=float, default=SWEEP_SECONDS)
    parser.add_argument("--replace", **REPLACE)
    asked = parser.parse_args(argv)
    sweep = dict(amplitude=asked.amplitude, seconds=asked.seconds)
    paths = write_recorders(asked.robot, asked.folder, asked.replace, **sweep)
    for path in paths:
        say(f"wrote {path}")
    return paths


def check(argv):
    """The command, of words ``argv``, that looks at logs; 1 if one isn't usable."""
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
    text = f"Hold the log of a running program to its model: {HEADER}."
    parser = parser_of("compare", text)
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
