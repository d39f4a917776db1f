"""The command line: verify a proof file, or design a controller with proof.

Exit codes: 0 proven, 1 not proven, or about another plant, gain or program, 2 bad
input, 3 a room of the package that it needs isn't there, 4 not decided within the time
or memory that there is, 5 proven, where an author says what the blocks of his own
theorem mean.
"""

import argparse
import re
import sys
from dataclasses import replace
from pathlib import Path

from ..exact.checker.verdict import AUTHOR, MOST_VERTICES, SECONDS, at_most, by_author
from ..exact.proof_file import ProofFile, is_proof, laid_out, load, parse
from ..laws.taken import law_of
from ..plants.as_data import plant_data
from ..plants.kinds import checked_plant
from ..requirements.in_files import asked_in_file, made
from ..requirements.wish import wish_in
from ..runtime.digests import digest
from ..runtime.later import MissingRoom
from ..runtime.reading import named, read_bytes
from ..runtime.saying import one_line, say
from ..runtime.time_limit import checked_seconds
from ..runtime.writing import may_replace
from ..synthesis.pid import design_pid
from ..synthesis.search import Search
from .folder import (
    PROGRAM_PROOF,
    PROOF,
    check_folder,
    controller_in,
    controller_made,
    pages,
    unlimited,
    write_folder,
)
from .subject import compare_code, compare_gain, compare_plant, proofs_beside, subject

__all__ = ["main"]

PROVEN, NOT_PROVEN, BAD_INPUT, BEYOND, NOT_DECIDED = range(5)
OF_OTHERS = (
    "names, without, condensed, push and rayleigh stand in a file for design: "
    '{"plant": {"file": "plant.mat", "names": {"S": "K"}}, "region": {"sigma": 1}}'
)


def main(arguments: list | None = None) -> int:
    """Run the command line.

    ``arguments``: those of the program without it. Returns the exit code.
    """
    parser = argparse.ArgumentParser(prog="python -m sosbook", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="command")
    verifying = commands.add_parser("verify", help="check a proof file")
    verifying.add_argument(
        "proof",
        nargs="?",
        help="a file that a certificate's save wrote; without it those beside --code",
    )
    verifying.add_argument("--plant", help="refuse a proof about another plant")
    verifying.add_argument("--gain", help='refuse another gain: JSON, {"K": [[..]]}')
    verifying.add_argument(
        "--code",
        help="refuse another program in C: its .c or .h, with the files beside it",
    )
    verifying.add_argument(
        "--time-limit",
        type=float,
        default=SECONDS,
        metavar="SECONDS",
        help=f"say after so long that it isn't decided ({SECONDS:g})",
    )
    verifying.set_defaults(run=verify)
    designing = commands.add_parser("design", help="design a PID controller")
    designing.add_argument(
        "plant",
        help="JSON or TOML, see plant.schema.json beside this module, whose plant may "
        "be the name of a file; or whatever load_plant reads, to be made stable",
    )
    goes = designing.add_mutually_exclusive_group()
    goes.add_argument(
        "--proof",
        default=PROOF,
        help="where to write it; an older proof about the same plant is replaced, and "
        "removed where there is none for this request; nothing else is",
    )
    goes.add_argument(
        "--out",
        metavar="FOLDER",
        help="write gains, proof and a page here, and the program of a controller; an "
        "older answer about the same plant is replaced, nothing else is",
    )
    designing.add_argument(
        "--force",
        action="store_true",
        help="replace what is about another plant or was changed, too",
    )
    designing.set_defaults(run=design)
    asked = parser.parse_args(arguments)
    try:
        return asked.run(asked)
    except (OSError, ValueError) as fault:
        words = [f"error: {one_line(fault)}", *getattr(fault, "__notes__", ())]
        if re.search(r"\b(names|without|condensed|push|rayleigh)=", words[0]):
            words.append(OF_OTHERS)
        say("\n".join(words), sys.stderr)
        return BAD_INPUT
    except MissingRoom as missing:
        say(f"error: {missing}", sys.stderr)
        return BEYOND
    except MemoryError:
        say("not decided: it takes more memory than there is")
        return NOT_DECIDED


def verify(asked):
    """Compute everything in a proof file again, and print what it proves."""
    if asked.proof is None:
        if asked.code is None:
            raise ValueError("give a proof file, or --code and a program in C")
        # the first bad answer counts, and the rest says what it would
        answers = [
            verify(argparse.Namespace(**vars(asked) | {"proof": file}))
            for file in proofs_beside(asked.code)
        ]
        return next((x for x in answers if x != PROVEN), PROVEN)
    limit = checked_seconds(asked.time_limit, needed=True)
    with at_most(limit, "this says nothing about the proof; "):
        proof = load(asked.proof)
        data = proof.data
        many = vertices_of(data)
        if many > MOST_VERTICES:
            say(
                f"not decided: the plant has {many} vertices, more than {MOST_VERTICES}"
            )
            return NOT_DECIDED
        proven = proof.proven
    trouble, compared = "", []
    if proven and asked.plant is not None:
        trouble = compare_plant(data, asked.plant)
    if proven and not trouble and asked.gain is not None:
        trouble = compare_gain(data, asked.gain)
    if proven and not trouble and asked.code is not None:
        trouble, compared = compare_code(proof, asked.code)
    if trouble:
        say(f"refused: {trouble}. It is about {subject(data) or 'no plant'}")
        return NOT_PROVEN
    first, *claims = str(proof).splitlines()
    about = subject(data) if proven else ""
    if about:
        first = f"{first.removesuffix(':')}, of {about}:"
    heads, said = [f"of {asked.code}, compared: {words}" for words in compared], []
    if proven and proof.examined.alone:
        why = proof.examined.alone
        said.append(f"this package alone decides it, not the checker: {why}")
    say("\n".join([*heads, first, *claims, *said]))
    if proven and by_author({**data, "kind": parse(proof.text)[0]}):
        return AUTHOR
    return PROVEN if proven else NOT_PROVEN


def vertices_of(data):
    """How many vertices the plant has in the ``data`` of a file."""
    plant = data.get("plant")
    vertices = plant.get("vertices") if isinstance(plant, dict) else None
    return len(vertices) if isinstance(vertices, list) else 0


def design(asked):
    """Design for a plant file; print gains and margins, write the proof or a folder."""
    folder, earlier, made = asked.out, Path(asked.proof), None
    try:
        wish = wish_in(asked.plant)
        plant, requirements, computer = _keywords(asked.plant, wish)
        whole, _ = law_of(None, requirements.get("law")).on(plant)
        if folder is not None:
            there = check_folder(folder, whole, asked.force)
        elif computer is None:
            check_place(earlier, whole, asked.force)
        else:
            raise ValueError(
                f"{asked.plant}: a controller is asked for: give --out FOLDER for its "
                "program"
            )
        try:
            result = design_pid(plant, **requirements)
            if computer is not None and result.status == "feasible":
                made = controller_made(result, computer)
                if limit := unlimited(result, computer):
                    say(limit, sys.stderr)
        except (ValueError, TypeError) as error:
            raise ValueError(f"{asked.plant}: {error}") from None
    except ValueError as error:
        old = earlier if folder is None else Path(folder) / PROOF
        if old.is_file() and is_proof(read_bytes(old)):
            error.add_note(f"{old} is still the answer to an earlier request")
        raise
    answer = {"asked": wish.sentence, "status": result.status}
    proof = result.infeasibility
    if result.status == "feasible":
        proof = made.certificate if made else result.certify()
        parts = replace(result, K=proof.K).gains
        answer |= {
            "K": proof.K.tolist(),
            **{name: part.tolist() for name, part in parts.items()},
            "digits": proof.digits,
            "margins": {name: float(f"{x:.3g}") for name, x in result.margins.items()},
            "central": result.central,
            "reason": result.reason,
        }
    else:
        answer |= {"reason": result.reason, "advice": result.advice}
    proven = isinstance(proof, ProofFile) and proof.settled
    answer |= {"proven": proven, "claims": list(proof.claims) if proven else []}
    if folder is not None:
        done = proven and result.status == "feasible"
        texts = {PROOF: proof.text} if proven else {}
        texts |= pages(result, made if done else None, answer["claims"])
        if computer is not None:
            done = answer["controller_proven"] = done and PROGRAM_PROOF in texts
            if made is None or not proven:
                say("no program is written: no gain is proven", sys.stderr)
        answer["plant"] = digest(plant_data(plant))
        write_folder(folder, answer, texts, there)
        say(laid_out(answer))
        return PROVEN if done else NOT_PROVEN
    if proven:
        proof.save(asked.proof)
        answer["proof"] = str(asked.proof)
    elif earlier.is_file():
        earlier.unlink()
        say(f"{earlier} is removed: it answered an earlier request", sys.stderr)
    say(laid_out(answer))
    return PROVEN if proven and result.status == "feasible" else NOT_PROVEN


def check_place(path, plant, force):
    """Raise where a file is there that no proof may replace, or its folder isn't."""
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{path}: there is no such folder")
    may_replace(path, is_proof, "give --proof another name")
    if not force:
        may_replace(
            path,
            lambda old: _plant_in(old) == plant_data(plant),
            "a proof about another plant; give --proof another name, or --force",
        )


def _plant_in(content):
    """The plant in the bytes of a proof file, as data; None of a broken one."""
    try:
        return parse(content.decode())[1].get("plant")
    except ValueError:
        return None


def read_plant_file(path):
    """The plant of a file, its keywords of `design_pid`, and its controller's or None.

    ``path``: JSON or TOML, as ``plant.schema.json`` says, or what `load_plant` takes.
    """
    return _keywords(path, wish_in(path))


def _keywords(path, wish):
    """`read_plant_file` of the `Wish` of a file."""
    with named(path):
        plant, data = wish.plant, dict(wish.data)
        for name in ("$schema", "words"):
            data.pop(name, None)
        plant = checked_plant(plant)
        computer = data.pop("controller", None)
        if computer is not None:
            computer = controller_in(computer)
        how = data.pop("search", None)
        asked = asked_in_file(data)
        if how is not None:
            asked["search"] = made("search", Search, how)
        if "law" in asked:
            with named("law"):
                asked["law"].parts(plant), asked["law"].structure(plant)
        return plant, asked, computer
