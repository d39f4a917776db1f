"""Every file that is written of a controller: programs, model, proofs."""

import json

from ..exact.checker import in_one_file
from .boards import wired_as_pyctrl
from .export import Program
from .modelled import Model

__all__ = ["texts"]


def texts(deployment, name):
    """The texts of all files of a ``deployment``, by the files' names.

    ``name`` is that of the C functions and files.
    """
    firmware, robot = deployment.firmware, deployment.robot
    designed, bench = deployment.steering, deployment.bench_firmware
    steering, stand = designed and designed.law, f"{name}_stand"
    about = dict(robot=robot, drive=deployment.drive, steering=steering)
    program = Program(firmware, name, **about)
    on_stand = Program(bench, stand, robot=robot)
    files = {
        f"provenance_{name}.json": json.dumps(deployment.facts, indent=2) + "\n",
        f"model_{name}.json": Model.of(deployment).text,
        **program.law,
        **Program(firmware, f"{name}_single", "single", **about).law,
        **on_stand.law,
    }
    if robot.board == "beaglebone":
        for one in (program, on_stand):
            files |= one.rc_balance
            if wired_as_pyctrl(robot):
                files[f"pyctrl_{one.name}.py"] = one.pyctrl
        if steering:
            files[f"ros_{name}.py"] = program.ros
    else:
        files |= program.sketch
    return files | _proofs(deployment, name)


def _proofs(deployment, name):
    """The proofs, and the checker of those in rationals."""
    rows = enumerate((x for row in deployment.sampled.values() for x in row), 1)
    proofs = dict(zip(("", "_hold"), deployment.continuous_proofs.values()))
    proofs |= {f"_sampled_{k}": proof for k, proof in rows}
    unequal = ()
    if deployment.steering:
        proofs |= {f"_{x}": proof for x, proof in deployment.steering.proofs.items()}
        unequal = deployment.steering.unequal
    return {
        **{
            f"unequal_motors/proof_{name}_{k}.json": proof.text
            for k, proof in enumerate(unequal, 1)
            if proof.proven
        },
        **{f"proof_{name}{file}.json": proof.text for file, proof in proofs.items()},
        "check_proof.py": in_one_file(),
    }
