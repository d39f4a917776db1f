"""The command line: verify a proof file, or design a controller with proof.

Exit codes: 0 proven, 1 not proven, 2 bad input.
"""

import argparse
import sys

from ..lmi.proof import ProofFile, load
from ..lmi.proof_text import laid_out
from ..plants.files import plant_of, read_json
from ..requirements.in_files import KEYS, asked_in_file
from ..synthesis.pid import design_pid

__all__ = ["main"]

PROVEN, NOT_PROVEN, BAD_INPUT = 0, 1, 2


def main(arguments: list | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : list of str, optional
        Those of the program without it.

    Returns
    -------
    int
        The exit code.
    """
    parser = argparse.ArgumentParser(prog="python -m sosbook", description=__doc__)
    commands = parser.add_subparsers(required=True, metavar="command")
    verifying = commands.add_parser("verify", help="check a proof file")
    verifying.add_argument("proof", help="a file that a certificate's save wrote")
    verifying.set_defaults(run=verify)
    designing = commands.add_parser("design", help="design a PID controller")
    designing.add_argument("plant", help="see plant.schema.json beside this module")
    designing.add_argument("--proof", help="where to write it", default="proof.json")
    designing.set_defaults(run=design)
    asked = parser.parse_args(arguments)
    try:
        return asked.run(asked)
    except (OSError, ValueError) as fault:
        print(f"error: {fault}", file=sys.stderr)
        return BAD_INPUT


def verify(asked):
    """Compute everything in a proof file again, and print what it proves."""
    proof = load(asked.proof)
    print(proof)
    return PROVEN if proof.verify() else NOT_PROVEN


def design(asked):
    """Design for a plant file; print gains and margins, write the proof."""
    plant, requirements = read_plant_file(asked.plant)
    try:
        result = design_pid(plant, **requirements)
    except (ValueError, TypeError) as error:
        raise ValueError(f"{asked.plant}: {error}") from None
    answer, proof = {"status": result.status}, result.infeasibility
    if result.status == "feasible":
        proof = result.certify()
        n = plant.n
        answer |= {
            "K": proof.K.tolist(),
            "K_P": proof.K[:, :n].tolist(),
            "K_D": proof.K[:, n : 2 * n].tolist(),
            "K_I": proof.K[:, 2 * n :].tolist(),
            "digits": proof.digits,
            "margins": {name: float(f"{x:.3g}") for name, x in result.margins.items()},
        }
    else:
        answer["advice"] = result.advice
    proven = isinstance(proof, ProofFile) and proof.proven
    answer |= {"proven": proven, "claims": list(proof.claims) if proven else []}
    if proven:
        proof.save(asked.proof)
        answer["proof"] = str(asked.proof)
    print(laid_out(answer))
    return PROVEN if proven and result.status == "feasible" else NOT_PROVEN


def read_plant_file(path):
    """The plant and the keywords of `design_pid` of a file.

    Parameters
    ----------
    path : str or Path
        JSON, as ``plant.schema.json`` says.
    """
    data = read_json(path)
    if not isinstance(data, dict) or not isinstance(data.get("plant"), dict):
        raise ValueError(
            f'{path}: "plant" is missing: give {{"M": .., "D": .., "S": .., "B": ..}} '
            'or {"vertices": [..]}'
        )
    data.pop("$schema", None)
    unknown = data.keys() - {"plant", *KEYS}
    if unknown:
        raise ValueError(
            f"{path}: {sorted(unknown)[0]!r} isn't known: the keys are "
            f"plant, {', '.join(KEYS)}"
        )
    try:
        return plant_of(data.pop("plant")), asked_in_file(data)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
