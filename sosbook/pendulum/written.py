"""The files of a controller: programs, model, proofs; or the reason for none."""

import json

from ..controllers.written import record
from ..exact.checker import in_one_file
from .boards import wired_as_pyctrl
from .export import Program
from .firmware import SOFTNESS
from .fit_spread import FitSpread
from .modelled import Model

__all__ = ["check", "texts"]


def check(deployment):
    """A ValueError if a ``deployment`` isn't proven, or its margin is thin."""
    robot, peak = deployment.robot, deployment.sensitivity
    sector = 1 + 1 / SOFTNESS
    if not deployment.proven:
        raise ValueError(
            "this controller isn't proven, so it isn't written. "
            + ". ".join(deployment.lacking)
            + f". {_advice(deployment)}"
        )
    if peak > deployment.peak:
        raise ValueError(
            "this controller's margin is thin, so it isn't written: its sensitivity "
            f"peaks at {peak:.2f}, above {deployment.peak:g}. Leave R out, and the "
            "smallest that will do is searched"
        )
    if robot.compensation and peak / SOFTNESS >= sector:
        raise ValueError(
            f"compensation: with a sensitivity of {peak:.2f} a gain that varies from 1 "
            f"to {sector:g} isn't known to be stable: take a larger R, or leave it out"
        )
    if deployment.steering and deployment.steering.coupled_radius >= 1:
        raise ValueError(
            f"unequal = {robot.unequal:g}: with motors that differ so much balance and "
            "steering aren't stable together: match the motors, or take a larger R"
        )


def _advice(deployment):
    if deployment.robot.blend == 0:
        return (
            "With blend = 0 nothing corrects the estimate of theta: take a blend above "
            "0"
        )
    if isinstance(deployment.spread, FitSpread):
        return deployment.spread.cure
    if any("undecided" in failure for failure in deployment.lacking):
        return (
            "Where a proof is undecided, take more cells, or logs that say more: "
            "longer ones, or with a larger V"
        )
    return "Take a larger R, a smaller spread or delay"


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
            files |= program.ros
    else:
        files |= program.sketch
    files |= _proofs(deployment, name)
    return files | {f"program_{name}.json": record(files, name)}


def _proofs(deployment, name):
    """The proofs, and the checker of those in rationals."""
    rows = enumerate((x for row in deployment.sampled.values() for x in row), 1)
    proofs = dict(zip(("", "_hold"), deployment.continuous_proofs.values()))
    proofs |= {f"_sampled_{k}": proof for k, proof in rows}
    robots = enumerate(deployment.varying_robots, 1)
    proofs |= {f"_varying_{k}": proof for k, proof in robots}
    unequal = ()
    if deployment.steering:
        proofs |= {f"_{x}": proof for x, proof in deployment.steering.proofs.items()}
        unequal = deployment.steering.unequal
    return {
        **{
            f"unequal_motors/proof_{name}_{k}.json": proof.settled_text()
            for k, proof in enumerate(unequal, 1)
            if proof.proven
        },
        **{
            f"proof_{name}{file}.json": proof.settled_text()
            for file, proof in proofs.items()
        },
        "check_proof.py": in_one_file(),
    }
