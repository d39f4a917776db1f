"""Chapter 4: the claims about the robot's recordings, simulated."""

from dataclasses import replace

import numpy as np

from ...pendulum import V_MAX, Firmware, Mip, SampledLaw, polytope, vertices
from ...pendulum.simulator import Sensors, simulate
from ...runtime.libraries import library
from ...synthesis.pid import analyse_pid
from .. import thesis
from .observer import controller as observer_controller
from .table import evaluate

control = library("control")


__all__ = ["observer_controller", "rows", "without_the_fast"]

T, START_TILT, END_TIME = 0.01, np.deg2rad(10), 2.5
DELAYS = (0.0, T / 2, T)  # s
NEVER_STALLED = 10**6  # ticks: no stall protection, so that chatter is seen
SENSOR_VOLTS = 0.1  # V, standard deviation: a robot's sensors make as much
CHATTER_VOLTS = 1.0  # V, standard deviation at rest: that is a limit cycle
TICKS_AT_REST = slice(170, None)  # beyond, a robot is at rest
PDS, PIDS = ("PD 1", "PD 2", "PD 5"), ("PID 2", "PID 5")


def rows():
    """Figures 4.8 to 4.16: what the text says, and what is simulated."""
    runs, gentle = {}, {}
    for name, law in _laws().items():
        if name in (*PDS, *PIDS, "LQE 2"):
            runs[name], gentle[name] = _runs(law, START_TILT, START_TILT / 2)
        else:
            (runs[name],) = _runs(law, START_TILT)
    volts_at_rest = _each(runs, lambda run: run.V[:, TICKS_AT_REST].std(axis=1).max())
    yield from _noise(runs, volts_at_rest)
    yield from _limits(runs, gentle, volts_at_rest)
    yield from _rests(runs)
    yield _drift()


def _noise(runs, volts_at_rest):
    """Judge if noise matters: by a quarter, and by more than `SENSOR_VOLTS`."""
    work = _each(runs, lambda run: np.square(run.V).mean())
    wild = {name: volts > CHATTER_VOLTS for name, volts in volts_at_rest.items()}
    late = [work[n][1] for n in PDS]  # by half a tick
    yield evaluate(
        "desk-effort",
        (np.diff(late) < 0).all() and not any(wild[n][1] for n in PDS),
        ours=_words(work, PDS, wild=wild),
    )
    for name, more, less, effect in (
        ("desk-noise", "PID 2", "PID 5", True),
        ("desk-observer", "LQE 1", "LQE 2", False),
    ):
        quarter = volts_at_rest[more] > 1.25 * volts_at_rest[less]
        volts = volts_at_rest[more] - volts_at_rest[less] > SENSOR_VOLTS
        readings = [quarter.all(), volts.all()]
        if not effect:
            readings = [not quarter.any(), not volts.any()]
        ours = _words(volts_at_rest, (more, less), wild=wild, digits=1)
        yield evaluate(name, *readings, ours=ours, volts=SENSOR_VOLTS)


def _limits(runs, gentle, volts_at_rest):
    """The start isn't printed: from START_TILT, and from half of it."""
    wild = {name: volts > CHATTER_VOLTS for name, volts in volts_at_rest.items()}
    peaks = [
        _each(simulated, lambda run: run.peak_voltage.max())
        for simulated in (runs, gentle)
    ]
    for name, volts, names, law in (
        ("desk-limit", V_MAX, (*PDS, *PIDS), "PD 1"),
        ("desk-3-V", 3, ("PID 5", "LQE 2"), "PID 5"),
    ):
        within = [
            max(peak[n][k] for n in names) < volts for peak in peaks for k in range(3)
        ]
        words = dict(ours=_words(peaks[0], names, wild=wild), volts=volts)
        yield evaluate(name, *within, **words, reach=_reach(law, volts))


def _rests(runs):
    sway = _each(runs, lambda run: np.degrees(np.abs(run.x[0, :, TICKS_AT_REST])).max())
    away = _each(runs, lambda run: np.abs(run.x[1, :, TICKS_AT_REST]).max())
    rates = _each(runs, lambda run: run.x[3, :, :50].max(axis=1).min())
    back = _each(runs, lambda run: run.x[3, :, :50].min(axis=1).min())
    lead = {name: rates[name] + back[name] for name in runs}
    both = ("PID 5", "LQE 2")
    for name, names in (("desk-quickly", ("PD 5", "PID 5")), ("desk-alike", both)):
        holds = max(sway[n].max() for n in names) < 0.6
        yield evaluate(name, holds, ours=_words(sway, names, "°"))
    kept = (3 * away["PID 5"] < away["LQE 2"]).all()
    yield evaluate("desk-wheels", kept, ours=_words(away, both, " rad"))
    ahead = all((lead[n] > 0).all() for n in both)
    yield evaluate("desk-side", ahead, ours=_words(lead, both, " rad/s"))


def _drift():
    """The wheels under a torque, and while the gyro keeps an offset."""
    speeds, ends = {}, {}
    printed, plants = thesis.mip(), polytope(Mip.printed())
    for name, U in (("PD", None), ("PID", [[0, 1]])):
        gain = printed.gains[name][5]
        firmware = Firmware(SampledLaw.of_gain(gain, T))
        gyro = Sensors(ideal=True, bias=-np.deg2rad(0.1))
        run = simulate(Mip.printed(), firmware, 0.0, 10.0, sensors=gyro, substeps=2)
        speeds[name] = np.degrees(run.x[1, 0, -1] - run.x[1, 0, -101])
        loop = analyse_pid(plants, gain.K, U, coupling="vertices")
        ends[name] = max(abs(x.dcgain()[1, 0]) for x in loop.closed_loop()) / 1000
    K = printed.pd[5][0]
    return evaluate(
        "desk-drift",
        abs(speeds["PD"]) > 5 * abs(speeds["PID"]) and ends["PID"] < 1e-6 < ends["PD"],
        speeds=", ".join(f"{n}: {v:.2f}°/s" for n, v in speeds.items()),
        ends=", ".join(f"{n}: {v:.2f} rad" for n, v in ends.items()),
        theorem=-0.1 * (1 + K[0] / K[1]),
    )


def _words(table, names, unit="", wild=None, digits=2):
    """Three numbers for each name, one for each delay.

    A limit cycle's digits are chance: where ``wild`` it is only named.
    """
    return "; ".join(
        f"{n}: "
        + ", ".join(
            "chatter" if wild and wild[n][k] else f"{x:.{digits}g}{unit}"
            for k, x in enumerate(table[n])
        )
        for n in names
    )


def _reach(name, volts):
    law, R = name.split()
    K = getattr(thesis.mip(), law.lower())[int(R)]
    return f"{np.degrees(volts / K[0, 0]):.1f}° ({name})"


def _each(runs, measure):
    """A number for each law and delay."""
    return {n: np.array([measure(run) for run in row]) for n, row in runs.items()}


def _laws():
    gains = thesis.mip().gains
    laws = {
        f"{law} {R}": SampledLaw.of_gain(gains[law][R], T)
        for law, R in (("PD", 1), ("PD", 2), ("PD", 5), ("PID", 2), ("PID", 5))
    }
    for R in (1, 2):
        laws[f"LQE {R}"] = SampledLaw.of_controller(
            without_the_fast(observer_controller(R)), T
        )
    laws["LQE 1 held"] = SampledLaw.of_controller(observer_controller(1), T)
    return laws


def without_the_fast(controller, edge=200):
    """(4.29) for (4.28): a ``controller`` without poles and zeros beyond the ``edge``,
    with the same gains at s = 0, and four digits of everything.
    """

    def kept(values):
        values = np.sort(values.real[abs(values) < edge])
        return np.poly([float(f"{x:.4g}") for x in values])

    den, B, D = kept(controller.poles()), [], []
    for k in (0, 1):
        num = kept(control.ss2tf(controller[0, k]).zeros())
        gain = controller.dcgain()[0, k] * den[-1] / num[-1]
        num = np.pad(float(f"{gain:.4g}") * num, (3 - len(num), 0))
        B.append(num[1:] - num[0] * den[1:])
        D.append(num[0])
    return control.ss([[-den[1], 1], [-den[2], 0]], np.transpose(B), [[1, 0]], [D])


def _runs(law, *tilts):
    """The four vertices at each delay, for each of the tilts; all in one go."""
    robots, firmware = vertices(Mip.printed()), Firmware(law, stall=NEVER_STALLED)
    n, four = len(robots), len(tilts) * list(robots)
    start = np.repeat(tilts, n)
    beside = [
        simulate(four, firmware, start, END_TIME, late, substeps=2) for late in DELAYS
    ]
    return [
        [_some(run, slice(k * n, (k + 1) * n)) for run in beside]
        for k in range(len(tilts))
    ]


def _some(run, which):
    """Some of the robots of a run."""
    parts = {name: getattr(run, name)[which] for name in ("V", "estimate", "fault")}
    return replace(run, x=run.x[:, which], **parts)
