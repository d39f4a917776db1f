"""The folder of an answer: gains, proof, page and, for a computer, the program.

``gains.json`` is the record: what was answered, about which plant, and the digest of
each file. So an answer takes the place of an earlier one about the same plant, whole,
and of nothing that somebody changed or wrote himself.
"""

import sys
from html import escape
from pathlib import Path

from ..exact.proof_file import laid_out
from ..plants.as_data import plant_data
from ..requirements.shorthand import bounds
from ..runtime.digests import digest
from ..runtime.later import later
from ..runtime.reading import named, read_bytes, read_json
from ..runtime.saying import say
from ..runtime.writing import write_texts

__all__ = [
    "CONTROLLER",
    "GAINS",
    "PROGRAM_PROOF",
    "PROOF",
    "check_folder",
    "controller_in",
    "controller_made",
    "pages",
    "unlimited",
    "write_folder",
]

GAINS, PROOF, PAGE = "gains.json", "proof.json", "index.html"
NAME = "axis"  # of the program and its folder, as `Design.report` has it
PROGRAM_PROOF = f"{NAME}/proof_{NAME}_sampled.json"
CONTROLLER = ("measured", "T", "delay", "counts", "u_max")
OTHER = "give --out another name"


def controller_in(data):
    """The checked value of a plant file's key "controller", with keys among
    `CONTROLLER`. Raises ValueError of others, of bad ones, and without T; ``data`` has
    it.
    """
    if not isinstance(data, dict):
        raise ValueError('controller must be an object, such as {"T": 0.001}')
    for name in data:
        if name not in CONTROLLER:
            raise ValueError(
                f"controller: {name!r:.80} isn't known: its keys are "
                f"{', '.join(CONTROLLER)}"
            )
    if "T" not in data:
        raise ValueError("controller: T is missing: give the seconds between samples")
    names = data.get("measured", [])
    if not isinstance(names, list) or not all(isinstance(x, str) for x in names):
        raise ValueError('controller: measured must be a list, such as ["z1"]')
    with named("controller"):
        later("controllers.clock", "checked_delay")(data["T"], data.get("delay", 0.0))
    return data


def controller_made(design, asked):
    """The `Controller` of a ``design``, with what a plant file ``asked`` of it."""
    asked = dict(asked)
    u_max = asked.pop("u_max", None)
    with named("controller"):
        made = design.controller(**asked)
        return made if u_max is None else made.limit(u_max)


def unlimited(design, asked):
    """A warning where a ``design`` bounds the input and its program, ``asked`` as in
    `controller_made`, limits none; else empty.
    """
    bound = bounds(design.request.requirements).get("u_max")
    if bound is None or asked.get("u_max") is not None:
        return ""
    return (
        f"warning: the input is bounded by {bound:.6g}, and the program has no limit: "
        f'write "u_max": {bound:.6g} under controller'
    )


def check_folder(folder, plant, force=False):
    """The names of files of an earlier answer in ``folder`` that a new one about a
    ``plant`` may replace, with ``force`` another's or changed ones, too. Raises
    FileExistsError of anything else.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise FileExistsError(f"{folder} is a file: {OTHER}")
    if not folder.is_dir() or not any(folder.iterdir()):
        return set()
    try:
        answer = read_json(folder / GAINS)
        about, files = answer["plant"], dict(answer.pop("files"))
        files[GAINS]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise FileExistsError(f"{folder} holds something else: {OTHER}") from None
    root = folder.resolve()
    there = {
        name: folder / name
        for name in files
        if (folder / name).resolve().is_relative_to(root) and (folder / name).is_file()
    }
    if force:
        return {*there}
    if about != digest(plant_data(plant)):
        raise FileExistsError(
            f"{folder} holds an answer about another plant: {OTHER}, or --force"
        )
    for name, path in there.items():
        now = digest(answer) if name == GAINS else digest(read_bytes(path))
        if now != files[name]:
            raise FileExistsError(
                f"{path} was changed since it was written: {OTHER}, or --force"
            )
    return {*there}


def write_folder(folder, answer, texts, earlier):
    """Write an ``answer``, with digests, and ``texts`` by name into a ``folder``; of
    the ``earlier`` files of `check_folder` those that nothing replaces are removed.
    """
    folder = Path(folder)
    files = {name: digest(text.encode()) for name, text in texts.items()}
    answer["files"] = files | {GAINS: digest(answer)}
    texts = texts | {GAINS: laid_out(answer) + "\n"}
    for name in texts:
        if name not in earlier and (folder / name).exists():
            raise FileExistsError(f"{folder / name} is there already: {OTHER}")
    write_texts(folder, texts, replace=True)
    for name in sorted(earlier - texts.keys()):
        (folder / name).unlink()
        say(f"{folder / name} is removed: it answered an earlier request", sys.stderr)


def pages(design, controller, claims):
    """The texts of a ``design`` for people, by their files' names.

    With a ``controller`` it is its report and program, else a card with ``claims``.
    """
    if controller is not None:
        report_texts = later("controllers.report", "report_texts")
        return report_texts(design, controller, NAME)
    items = "".join(f"<li>{escape(claim)}</li>" for claim in claims)
    proven = (
        f"<h2>Proven</h2><ul>{items}</ul>" if items else "<p>Nothing is proven.</p>"
    )
    return {
        PAGE: '<!doctype html><html lang="en"><meta charset="utf-8"><title>'
        f"{escape(design.status)}</title>{design._repr_html_()}{proven}</html>\n"
    }
