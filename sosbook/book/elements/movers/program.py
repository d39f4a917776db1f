"""A controller as a program, at work in the page."""

from math import floor

import numpy as np

from ..page import matrices, significant
from .mover import Mover, choice, slider

COUNTS = (0, 256, 1024, 4096, 16384)  # of the encoder, a turn; 0: no steps
DIGITS = 8  # of a bound
SHARE = 0.9  # of the motor that a ramp may ask: the rest is for the encoder's steps


def drive(controllers, u_max, *, r=20.0, counts=4096):
    """A two-mass drive under programs with several clocks, with and without a limit.

    What is proven of each program is asked here, in fractions and balls; the page
    simulates the same matrices.

    ``controllers``: one for each clock, a tick late, of the motor's angle and two
    loads; ``u_max``: the motor's limit; ``r``: the step at first, in rad; ``counts``:
    of the encoder at first, 0 or a power of 4 from 256 to 16384. Raises
    ValueError if a sampled loop isn't proven.
    """
    first = controllers[0]
    for c in controllers:
        if not c.certify().proven:
            raise ValueError(f"controllers: the loop at T = {c.T:g} s isn't proven")
    loads = [float(d.E[-1, -1]) for d in first.vertices]
    clocks = [f"{1000 * c.T:g} ms" for c in controllers]
    steps = [f"{n} counts a turn" if n else "without steps" for n in COUNTS]
    return Mover(
        "drive",
        "A law becomes a program",
        "Let the first program turn by 20 rad. Then tell its integral what is "
        "withheld.",
        [
            choice("law", "Set point", ["of all states", "quiet", "quiet, a ramp"]),
            choice("limit", "Motor", ["no limit", "a limit", "anti-windup"], 1),
            choice("clock", "Clock", clocks),
            choice("counts", "Encoder", steps, COUNTS.index(counts)),
            slider("r", "Step", " rad", (-1, 2), 0.05, r, "log"),
            slider("J", "Load", " kg m²", loads, 0.0001, loads[-1]),
            slider("w", "Load torque from 2.5 s", " N m", (0, 0.5), 0.05, 0),
        ],
        answer={"limit": 2},
        loads=loads,
        E=[d.E.tolist() for d in first.vertices],
        A=first.vertices[0].A.tolist(),
        B=np.hstack([first.vertices[0].Bu, first.vertices[0].Bw]).tolist(),
        stiffness=float(first.vertices[0].A[2, 1]),
        u_max=u_max,
        counts=list(COUNTS),
        clocks=[_clock(c, u_max) for c in controllers],
    )


def _clock(c, u_max):
    """The matrices of a controller and its naive brother, and what is proven."""
    naive = c.set_point(r=np.ones((2, 1)))
    deaf, told = (c.limit(u_max, anti_windup=on) for on in (False, True))
    moved = c.bounds.ramp().proven
    ramp = floor(SHARE * u_max / moved) if moved else 10
    noise = c.bounds.noise().proven
    return {
        **matrices(c, "ABCD"),
        "T": c.T,
        "asked": [matrices(x, ("B_r", "D_r")) for x in (c, naive)],
        "withheld": [x.W.tolist() for x in (deaf, told)],
        "noise": noise and significant(noise / float(c.readings.steps[0]), DIGITS),
        "asks": [
            x and significant(x, DIGITS)
            for x in (c.bounds.step().proven, naive.bounds.step().proven)
        ],
        "ramp": ramp,
        "ramp_asks": moved and significant(moved * ramp, DIGITS),
    }
