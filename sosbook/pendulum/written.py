"""Every file that is written of a controller: programs, model, proofs."""

import json
from dataclasses import replace

from ..proofs import CHECKER
from .boards import wired_as_pyctrl
from .drive import Drive
from .export import (
    c_header,
    c_source,
    c_steering,
    pyctrl_script,
    rc_balance,
    serial_main,
)
from .modelled import Model
from .ros import ros_node
from .sketch import sketch

__all__ = ["texts"]


def texts(deployment, name):
    """The texts of all files of a ``deployment``, by the files' names.

    ``name`` is that of the C functions and files.
    """
    firmware, robot = deployment.firmware, deployment.robot
    designed, bench = deployment.steering, deployment.bench_firmware
    steering = designed and replace(designed.law, firmware=firmware)
    files = {
        f"provenance_{name}.json": json.dumps(deployment.facts, indent=2) + "\n",
        f"model_{name}.json": Model.of(deployment).text,
    }
    for precision, suffix in (("double", ""), ("single", "_single")):
        files[f"{name}{suffix}.h"] = c_header(firmware, f"{name}{suffix}", precision)
        files[f"{name}{suffix}.c"] = c_source(firmware, f"{name}{suffix}", precision)
        if steering:
            files |= c_steering(steering, f"{name}{suffix}", precision)
    files[f"serial_{name}.c"] = serial_main(firmware, name)
    files[f"{name}_stand.h"] = c_header(bench, f"{name}_stand")
    files[f"{name}_stand.c"] = c_source(bench, f"{name}_stand")
    if robot.board == "beaglebone":
        files |= _beaglebone(robot, name, firmware, deployment.drive, steering)
        files |= _beaglebone(robot, f"{name}_stand", bench, Drive(), None)
        if steering:
            files[f"ros_{name}.py"] = ros_node(firmware, robot, name)
    else:
        files |= sketch(firmware, robot, name, deployment.drive, steering)
    return files | _proofs(deployment, name)


def _beaglebone(robot, name, firmware, drive, steering):
    """The main programs for a BeagleBone Blue."""
    files = {
        f"rc_{name}.c": rc_balance(firmware, name, "double", robot, drive, steering)
    }
    if wired_as_pyctrl(robot):
        files[f"pyctrl_{name}.py"] = pyctrl_script(
            firmware, robot, drive, name, steering
        )
    return files


def _proofs(deployment, name):
    """The proofs, and the checker of those in rationals."""
    rows = enumerate((x for row in deployment.sampled.values() for x in row), 1)
    proofs = dict(zip(("", "_hold"), deployment.continuous_proofs.values()))
    proofs |= {f"_sampled_{k}": proof for k, proof in rows}
    if deployment.steering:
        proofs |= {f"_{x}": proof for x, proof in deployment.steering.proofs.items()}
        rows = enumerate(deployment.steering.unequal, 1)
        unequal = {
            f"unequal_motors/proof_{name}_{k}.json": proof.text
            for k, proof in rows
            if proof.proven
        }
    else:
        unequal = {}
    return unequal | {
        **{f"proof_{name}{file}.json": proof.text for file, proof in proofs.items()},
        "check_proof.py": CHECKER.read_text("utf-8"),
    }
