"""Chapter 4: the claims about the robot's recordings, simulated."""

import control
import numpy as np

from ...pendulum import V_MAX, Firmware, Mip, SampledLaw, reduced, vertices
from ...pendulum.simulator import Sensors, simulate
from ...plants.descriptor import mean_descriptor
from .. import thesis
from .table import Row, claim

__all__ = ["observer_controller", "rows", "without_the_fast"]

DESK = "29_on_the_desk"
T, TILT, END = 0.01, np.deg2rad(10), 2.5
DELAYS = (0.0, T / 2, T)  # s
NEVER = 10**6  # ticks: no stall protection, so that chatter is seen
LOUD = 1.0  # V, standard deviation at rest: that is a limit cycle
REST = slice(170, None)  # ticks: beyond, a robot is at rest
HOW = "four vertices, from 10°; with 0, 5 and 10 ms of delay"


def rows():
    """Figures 4.8 to 4.16: what the text says, and what is simulated."""
    runs = {name: _runs(law) for name, law in _laws().items()}
    work = _each(runs, lambda run: np.square(run.V).mean())
    rest = _each(runs, lambda run: run.V[:, REST].std(axis=1).max())
    wild = {name: volts > LOUD for name, volts in rest.items()}
    peak = _each(runs, lambda run: run.peak_voltage.max())
    sway = _each(runs, lambda run: np.abs(run.x[0, :, REST]).max())
    away = _each(runs, lambda run: np.abs(run.x[1, :, REST]).max())
    ahead = _each(runs, lambda run: run.x[3, :, :50].max(axis=1).min()
                  + run.x[3, :, :50].min(axis=1).min())
    pds, pids = ("PD 1", "PD 2", "PD 5"), ("PID 2", "PID 5")
    yield _row(
        "PD: noise and effort fall with R", "Fig. 4.8", "yes",
        "mean V²: " + _words(work, pds, wild=wild), all(
            (np.diff([work[n][k] for n in pds]) < 0).all()
            for k in range(3)),
        "R = 1, 2 chatter with 0 and 10 ms: an unstable sampled loop, no "
        "noise of a sensor")
    yield _row(
        "PID: R = 5 is less noisy", "Fig. 4.9", "yes",
        "V at rest: " + _words(rest, pids, wild=wild),
        (rest["PID 5"] < rest["PID 2"]).all(), "likewise")
    yield _row(
        f"V doesn't exceed {V_MAX} V", "Figs 4.8 to 4.11", "yes",
        "peak V: " + _words(peak, (*pds, *pids), wild=wild),
        max(peak[n].max() for n in (*pds, *pids)) < V_MAX,
        "at the limit wherever it chatters; without chatter up to "
        + _reach("PD 1", V_MAX))
    yield _row(
        "PD and PID stabilise quickly", "Fig. 4.10, R = 5", "yes",
        "tilt after 1.7 s: " + _words(
            {n: np.degrees(v) for n, v in sway.items()},
            ("PD 5", "PID 5"), "°"),
        max(sway[n].max() for n in ("PD 5", "PID 5")) < 0.01, "")
    yield _row(
        "R hardly matters to the observer", "Fig. 4.13", "yes",
        "V at rest: " + _words(rest, ("LQE 1", "LQE 2")),
        np.abs(rest["LQE 1"] - rest["LQE 2"]).max() < 0.2,
        "as (4.29), (4.30); the controller of R = 1 held as it is, with "
        "its fast pole, oscillates: " + _words(rest, ("LQE 1 held",), wild=wild))
    yield _drift()
    both = ("PID 5", "LQE 2")
    yield _row(
        "PID and PD/LQE converge alike", "Fig. 4.14", "yes",
        "tilt after 1.7 s: " + _words(
            {n: np.degrees(v) for n, v in sway.items()}, both, "°"),
        max(sway[n].max() for n in both) < 0.01, "")
    yield _row(
        "both stay within 3 V", "Fig. 4.15", "yes",
        "peak V: " + _words(peak, both),
        max(peak[n].max() for n in both) < 3,
        "the start isn't printed; PID up to " + _reach("PID 5", 3))
    yield _row(
        "PID keeps the wheels, PD/LQE less", "Fig. 4.16", "yes",
        "wheels after 1.7 s: " + _words(away, both, " rad"),
        (3 * away["PID 5"] < away["LQE 2"]).all(),
        "the observer doesn't know the wheels' angle")
    yield _row(
        "the wheels shoot to the side of the fall", "Fig. 4.16", "yes",
        "their fastest speed is to that side",
        all((ahead[n] > 0).all() for n in both), "")


def _drift():
    """The wheels' speed while the gyro keeps a tenth of a degree/s."""
    speeds = {}
    printed = thesis.mip()
    for name, table in (("PD 5", printed.pd), ("PID 5", printed.pid)):
        law = SampledLaw.of_gain(table[5], T)
        run = simulate(
            Mip.printed(), Firmware(law), 0.0, 10.0, substeps=2,
            sensors=Sensors(ideal=True), bias=-np.deg2rad(0.1))
        speeds[name] = np.degrees(run.x[1, 0, -1] - run.x[1, 0, -101])
    K = printed.pd[5][0]
    return Row(
        DESK, "PD's wheels wander, PID's stay", "Fig. 4.11, R = 5", "yes",
        ", ".join(f"{n}: {v:.2f}°/s" for n, v in speeds.items()),
        claim(abs(speeds["PD 5"]) > 5 * abs(speeds["PID 5"])),
        "if 0.1°/s of the gyro's offset is left over; by the theorem "
        f"{-0.1 * (1 + K[0] / K[1]):.2f} and -0.10°/s")


def _row(item, where, printed, ours, holds, why):
    return Row(DESK, item, where, printed, ours, claim(bool(holds)),
               "; ".join(w for w in (HOW, why) if w))


def _words(table, names, unit="", wild=None):
    """Three numbers for each name, one for each delay.

    A limit cycle's digits are chance: where ``wild`` it is only named.
    """
    return "; ".join(
        f"{n}: " + ", ".join(
            "chatter" if wild and wild[n][k] else f"{x:.2g}{unit}"
            for k, x in enumerate(table[n]))
        for n in names)


def _reach(name, volts):
    law, R = name.split()
    K = getattr(thesis.mip(), law.lower())[int(R)]
    return f"{np.degrees(volts / K[0, 0]):.1f}° ({name})"


def _each(runs, number):
    """A number for each law and delay."""
    return {n: np.array([number(run) for run in each])
            for n, each in runs.items()}


def _laws():
    printed = thesis.mip()
    laws = {f"PD {R}": SampledLaw.of_gain(printed.pd[R], T)
            for R in (1, 2, 5)}
    laws |= {f"PID {R}": SampledLaw.of_gain(printed.pid[R], T)
             for R in (2, 5)}
    for R in (1, 2):
        laws[f"LQE {R}"] = SampledLaw.of_controller(
            without_the_fast(observer_controller(R)), T)
    laws["LQE 1 held"] = SampledLaw.of_controller(observer_controller(1), T)
    return laws


def observer_controller(R):
    """The controller of Table 4.3, in continuous time."""
    K, L = thesis.mip().lqe[R]
    C = np.array(thesis.mip().C)
    A, B, _ = mean_descriptor(
        reduced(Mip.printed()).vertices).state_space()
    return control.ss(A + B @ K + L @ C, -L, K, np.zeros((1, 2)))


def without_the_fast(given, edge=200):
    """(4.29) for (4.28): poles and zeros beyond the edge are left out.

    The gains at s = 0 are kept, and four digits of everything.
    """
    def kept(values):
        values = np.sort(values.real[abs(values) < edge])
        return np.poly([float(f"{x:.4g}") for x in values])

    den, B, D = kept(given.poles()), [], []
    for k in (0, 1):
        num = kept(control.ss2tf(given[0, k]).zeros())
        gain = given.dcgain()[0, k] * den[-1] / num[-1]
        num = np.pad(float(f"{gain:.4g}") * num, (3 - len(num), 0))
        B.append(num[1:] - num[0] * den[1:])
        D.append(num[0])
    return control.ss([[-den[1], 1], [-den[2], 0]], np.transpose(B),
                      [[1, 0]], [D])


def _runs(law):
    """The four vertices at each delay, in one go."""
    robots, firmware = vertices(Mip.printed()), Firmware(law, stall=NEVER)
    return [simulate(robots, firmware, TILT, END, late, substeps=2)
            for late in DELAYS]
