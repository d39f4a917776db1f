"""Input shapers against published closed forms, simulated modes and dense scans."""

import numpy as np
import pytest
from scipy.optimize import linprog

import sosbook as sos
from sosbook import InputShaper
from tests.cases import campaign, seeds

G = 9.81
RNG = np.random.default_rng(7)


def mode(t, omega, zeta):
    """What is missing of a mode's step response at t >= 0, and its rate."""
    sigma, fast = omega * zeta, omega * np.sqrt(1 - zeta**2)
    decay, more = np.exp(-sigma * t), sigma / fast
    z = decay * (np.cos(fast * t) + more * np.sin(fast * t))
    return z, -decay * (fast + more * sigma) * np.sin(fast * t)


def amplitude(z, dz, omega, zeta):
    """Of a vibration that is at z and moves with dz."""
    return np.hypot(z, (dz + omega * zeta * z) / (omega * np.sqrt(1 - zeta**2)))


def left(shaper, omega, zeta):
    """The amplitude after the last impulse, by that of a step's begin: by sums of
    step responses.
    """
    t = shaper.times[-1] - shaper.times
    z, dz = (shaper.amplitudes @ x for x in mode(t, omega, zeta))
    first = amplitude(*mode(0.0, omega, zeta), omega, zeta)
    return amplitude(z, dz, omega, zeta) / first


@pytest.mark.parametrize("omega, zeta", [(0.3, 0), (G, 0.1), (77.0, 0.4), (2.0, 0.01)])
def test_the_published_shapers(omega, zeta):
    """Singer and Seering's; nothing is left of the mode that they are made for."""
    K = np.exp(-zeta * np.pi / np.sqrt(1 - zeta**2))
    half = np.pi / (omega * np.sqrt(1 - zeta**2))
    zv, zvd = (make(omega, zeta) for make in (InputShaper.zv, InputShaper.zvd))
    assert zv.amplitudes == pytest.approx(np.array([1, K]) / (1 + K))
    assert zvd.amplitudes == pytest.approx(np.array([1, 2 * K, K * K]) / (1 + K) ** 2)
    assert zvd.times == pytest.approx([0, half, 2 * half])
    for shaper in (zv, zvd):
        assert left(shaper, omega, zeta) < 1e-12
        assert shaper.residual(omega, zeta).proven < 1e-12


@pytest.mark.parametrize("V", [0.05, 0.01, 0.2])
def test_the_published_extra_insensitive_shapers(V):
    """EI of Singhose, Seering and Singer, with one, two and three humps."""
    X = np.cbrt(V**2 * (np.sqrt(1 - V**2) + 1))
    two = (3 * X**2 + 2 * X + 3 * V**2) / (16 * X)
    three = (1 + 3 * V + 2 * np.sqrt(2 * (V**2 + V))) / 16
    printed = {2: (1 + V) / 4, 3: two, 4: three}
    assert InputShaper.ei(2.0, residual=V).amplitudes[0] == pytest.approx(printed[2])
    for n, first in printed.items():
        edge = np.arccos(1 / np.cosh(np.arccosh(1 / V) / n)) * 2 / np.pi
        shaper = InputShaper._of((edge, 2 - edge), 0, n, 1 / np.cos(np.pi * edge / 2))
        assert shaper.amplitudes[0] == pytest.approx(first, rel=1e-6)
        assert shaper.residual((edge, 2 - edge)).proven == pytest.approx(V, abs=2e-5)


@pytest.mark.parametrize(
    "make, width",
    [(InputShaper.zv, 0.064), (InputShaper.zvd, 0.287), (InputShaper.ei, 0.399)],
)
def test_the_published_insensitivity(make, width):
    """The range of omega, by its middle, in which at most 5 % are left."""
    shaper, (low, high) = make(1.0), (1 - width / 2, 1 + width / 2)
    assert shaper.residual((low + 1e-3, high - 1e-3)).proven < 0.05 + 2e-5
    assert shaper.residual((low - 1e-3, high + 1e-3)).seen > 0.05


@pytest.mark.parametrize("seed", seeds(6))
def test_the_bound_holds_and_is_sharp(seed):
    """Of any impulses, negative ones too, on any range."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=rng.integers(2, 6)) + 0.5
    times = np.append(0, np.cumsum(rng.uniform(0.01, 1, len(A) - 1))) * 0.3
    omega, zeta = np.sort(rng.uniform(0.1, 30, 2)), np.sort(rng.uniform(0, 0.9, 2))
    shaper = InputShaper(A / A.sum(), times)
    found = shaper.residual(omega, zeta)
    grid = np.meshgrid(np.linspace(*omega, 301), np.linspace(*zeta, 13))
    scan = np.array([left(shaper, *x) for x in zip(*(g.ravel() for g in grid))])
    assert scan.max() <= found.proven <= scan.max() + 2e-3
    assert left(shaper, *found.at) == pytest.approx(found.seen, abs=1e-9)
    assert found.seen <= found.proven <= found.seen + 2e-5 * max(1, found.seen)


@pytest.mark.parametrize(
    "omega, zeta, share",
    [
        ((0.8, 1.2), 0, 0.05),
        ((np.sqrt(G / 3), np.sqrt(G)), (0, 0.02), 0.05),  # ropes of 1 to 3 m
        ((0.3, 0.6), (0.01, 0.2), 0.1),
        (G, (0, 0.3), 0.01),
    ],
)
def test_a_range_keeps_at_most_what_was_asked(omega, zeta, share):
    """As few impulses as do, none is negative; and modes of it by simulation."""
    shaper = InputShaper.ei(omega, zeta, residual=share)
    assert shaper.residual(omega, zeta).proven <= share
    assert (shaper.amplitudes > 0).all()
    n = len(shaper.times) - 1
    low, high = np.broadcast_to(omega, 2)
    if n > 1:
        fewer = InputShaper._of(
            omega, zeta, n - 1, 1 / np.cos(np.pi * low / (low + high))
        )
        assert fewer.residual(omega, zeta).proven > share
    for _ in range(5):
        w, d = RNG.uniform(low, high), RNG.uniform(*np.broadcast_to(zeta, 2))
        swing = sos.SecondOrderSystem(1, 2 * d * w, w * w, w * w)
        end = shaper.times[-1]
        run = swing.simulate([0, end, 2 * end], u=shaper([1.0]))
        size = amplitude(run.z[0] - 1, run.dz[0], w, d)
        whole = amplitude(-1.0, 0.0, w, d)
        assert size[1] / whole <= share + 1e-9
        assert size[1] / whole == pytest.approx(left(shaper, w, d), abs=1e-7)
        assert size[2] <= size[1] + 1e-9


def test_no_impulses_at_these_times_leave_less():
    """Chebyshev's polynomial by a linear program of 16 directions and 60 modes."""
    omega = (0.6, 1.4)
    best = InputShaper._of(omega, 0, 3, 1 / np.cos(np.pi * 0.3))
    rows = []
    for w in np.linspace(*omega, 60):
        g = np.exp(1j * w * best.times)
        turns = np.exp(2j * np.pi * np.arange(16) / 16)
        rows += [np.append((turn * g).real, -1) for turn in turns]
    found = linprog(
        [0, 0, 0, 0, 1], A_ub=rows, b_ub=np.zeros(len(rows)),
        A_eq=[[1, 1, 1, 1, 0]], b_eq=[1], bounds=[(None, None)] * 4 + [(0, None)],
    )  # fmt: skip
    least = best.residual(omega).proven
    assert np.cos(np.pi / 16) * least - 1e-3 <= found.fun <= least


def convolved(shaper, r, t):
    """The sum of what each impulse makes of r, which is zero before 0."""
    parts = zip(shaper.amplitudes, shaper.times)
    return sum(a * np.where(t >= s, r(np.maximum(t - s, 0)), 0) for a, s in parts)


@pytest.mark.parametrize(
    "r",
    [
        sos.Steps([0, 0.3, 2], [[1, 0], [G, -0.3], [2, 2]]),
        sos.Ramps([0, 0.3, 0.3, 2], [[1, 0], [G, 1], [3, 1], [2, 2]]),
        sos.Ramps(np.arange(50) * 0.1, RNG.normal(size=(50, 2))),
    ],
)
def test_a_shaped_signal_is_the_convolution_and_of_its_kind(r):
    shaper = InputShaper.ei((3.0, 5.0), 0.1) * InputShaper.zv(17.0)
    shaped = shaper(r)
    assert type(shaped) is type(r)
    t = np.sort(RNG.uniform(0, 8, 1000))
    assert shaped(t) == pytest.approx(convolved(shaper, r, t), abs=1e-9)
    assert shaped(50.0) == pytest.approx(r(50.0))
    assert len(shaped.times) <= (len(shaper.times) + 1) * (len(r.times) + 1)


def test_two_modes_one_after_the_other():
    """Nothing is left of either, and a spring between two masses shows it."""
    slow, fast = 1.3, 7.7
    shaper = InputShaper.zv(slow) * InputShaper.zv(fast)
    assert len(shaper.times) == 4
    for omega in (slow, fast):
        assert shaper.residual(omega).proven < 1e-12
    twice = InputShaper.zv(slow, 0.1) * InputShaper.zv(slow, 0.1)
    assert twice.amplitudes == pytest.approx(InputShaper.zvd(slow, 0.1).amplitudes)


def crane(length):
    """A trolley that a drive holds in place, and a load of 100 kg on a rope."""
    return sos.SecondOrderSystem(
        [[150.0, 100 * length], [100 * length, 100 * length**2]],
        [[30.0, 0], [0, 2.0]],
        [[0, 0], [0, 100 * G * length]],
        [[1], [0]],
        coordinates=["trolley", "angle"],
    )


@pytest.mark.parametrize("length", [1.7, *campaign([1.0, 3.0])])
def test_a_crane_whose_rope_has_any_length(length):
    """The range of its loops' poles, at the ends of the rope, holds those between."""
    K = [[-300.0, 0, -300.0, 0]]

    def loop(length):
        """Loop matrix, and what its swing asks of a state."""
        d, sway = crane(length), np.eye(4)
        A = np.vstack([
            sway[2:],
            np.linalg.solve(d.M, d.B @ K - np.hstack([d.S, d.D])),
        ])  # fmt: skip
        poles, rows = np.linalg.eig(A.T)
        k = np.argmax(poles.imag)
        return A, poles[k], rows[:, k]

    p = np.array([loop(x)[1] for x in np.linspace(1, 3, 41)])
    omega, zeta = abs(p), -p.real / abs(p)
    ranges = (omega.min(), omega.max()), (zeta.min(), zeta.max())
    shaper = InputShaper.ei(*ranges, residual=0.05)
    design = sos.analyse_pid(crane(length), K)
    _, pole, row = loop(length)
    assert abs(design.poles() - pole).min() < 1e-9
    run = design.simulate([0, shaper.times[-1]], r=shaper([1.0, 0]))
    kept, whole = (abs(row @ (x - [1, 0, 0, 0])) for x in (run.x[:, -1], np.zeros(4)))
    assert kept / whole <= 0.05
    assert kept / whole == pytest.approx(
        left(shaper, abs(pole), -pole.real / abs(pole))
    )


@pytest.mark.parametrize("T", [0.01, 0.1, 0.3])
def test_a_clock_splits_impulses(T):
    """They keep their mean time, and what they add is of second order in T."""
    omega, zeta = (2.0, 3.0), (0, 0.1)
    shaper = InputShaper.ei(omega, zeta)
    split = shaper.at(T)
    assert split.times / T == pytest.approx((split.times / T).round(), abs=1e-9)
    mean = [x.amplitudes @ x.times for x in (shaper, split)]
    assert mean[0] == pytest.approx(mean[1])
    one, two = (x.residual(omega, zeta).proven for x in (shaper, split))
    assert two <= one + (omega[1] * T) ** 2 / 8
    assert split.at(T).times.tolist() == split.times.tolist()
    waits = InputShaper(shaper.amplitudes, np.ceil(shaper.times / T) * T)
    if T == 0.3:  # an impulse that waits for its tick is worse
        assert waits.residual(omega, zeta).seen > two


@pytest.mark.parametrize("T", [0.07, *campaign([0.1])])
def test_a_program_reads_the_split_impulses_at_its_ticks(T):
    """Its law sees a coordinate that stays at rest, so u is r: what it leaves of modes
    is as much as is proven. Impulses that wait for their ticks leave more.
    """
    omega, plain = (2.0, 3.0), InputShaper.ei((2.0, 3.0))
    kept = {}
    for shaper in (plain, plain.at(T)):
        kept[shaper] = 0.0
        for w in np.linspace(*omega, 5):
            plant = sos.SecondOrderSystem(
                np.eye(2), np.zeros((2, 2)), np.diag([1, w * w]), [[0], [w * w]]
            )
            law = sos.PIDLaw([[1, 0]])
            c = sos.Loop(plant, law, {"K_P": [[-1]]}).at(T=T, delay=0.0)
            x = c.simulate(12.0, r=shaper([1.0])).x[0, -1]
            size = amplitude(x[1] - 1, x[3], w, 0)
            if shaper is not plain:
                assert size == pytest.approx(left(shaper, w, 0), abs=1e-9)
            kept[shaper] = max(kept[shaper], size)
    assert kept[shaper] <= shaper.residual(omega).proven < kept[plain]


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: InputShaper.zv(0), "omega must be one number above 0"),
        (lambda: InputShaper.zv((2, 1)), "omega must be one number above 0"),
        (lambda: InputShaper.zv([1, 2, 3]), "omega must be one number above 0"),
        (lambda: InputShaper.zv(1, 1.0), "zeta must be one number from 0, below 1"),
        (lambda: InputShaper.ei(1, residual=1), "residual must be below 1"),
        (lambda: InputShaper.ei(1, residual=-1), "residual must be"),
        (lambda: InputShaper([0.5, 0.4], [0, 1]), "add up to 1"),
        (lambda: InputShaper([0.5, 0.5], [0, 0]), "times must increase from 0"),
        (lambda: InputShaper([0.5, 0.5], [0]), "amplitudes"),
        (lambda: InputShaper.zv(1).at(0), "T must be"),
        (lambda: InputShaper.zv(1)(np.sin), r"as Ramps\(times, levels\)"),
        (
            lambda: InputShaper.ei((0.3, G), (0, 0.3)),
            r"no shaper of up to 8 .* leaves at most 9.* % .*omega in \[0.3, 9.81\]",
        ),
    ],
)
def test_what_is_wrong_is_said(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_the_words_are_no_less_than_the_bound():
    found = InputShaper.ei((0.8, 1.2)).residual((0.8, 1.2))
    said = float(str(found).split("at most ")[1].split(" %")[0])
    assert said >= 100 * found.proven > 100 * found.seen > said - 0.05
    assert "every omega in [0.8, 1.2] and zeta = 0, by an enclosure" in str(found)
