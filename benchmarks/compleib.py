"""Control problems of COMPleib with proofs: python -m benchmarks.compleib [name ...].

x' = A x + B1 w + B u, z = C1 x + D12 u, y = C x + D21 w: the least H-infinity norm from
w to z by u = K y, or by a controller of a given order. The gain is searched, its norm
is proven a thousandth or two above what was reached, and where exact multipliers are
found they exclude every linear controller, of any order, below a number. CPU seconds,
into compleib.json; with names only these are run, and nothing is stored.

Others have published what their searches reached; tables of it that we could read and
compare weren't found, so none stands beside ours. Where slycot is installed, what
python-control's hinfsyn reports for a controller of full order stands there, and the
norm of its own loop: they needn't be one number, and a number below the excluded one
is none that a loop has. It asks for as many noises as sensors, and may not come back.

Source of the matrices: F. Leibfritz, COMPleib: constraint matrix-optimization problem
library, University of Trier, 2004, version 1.1 (COMPleib.m).
"""

import json
import sys
from importlib.util import find_spec
from multiprocessing import TimeoutError, get_context
from pathlib import Path
from time import process_time

import numpy as np
from scipy.linalg import block_diag

import sosbook as sos

from .records import store
from .run import machine

RESULTS = Path(__file__).with_name("compleib.json")


def problem(A, B, C, B1=None, C1=None, D12=None, D21=None, order=0):
    """The plant and the law of a problem; without B1 the library's own weights."""
    A = np.array(A, float)
    n = len(A)
    B, C = np.array(B, float).reshape(n, -1), np.array(C, float).reshape(-1, n)
    m = B.shape[1]
    if B1 is None:
        B1, C1 = np.eye(n), np.eye(n)
        D12 = np.vstack([np.zeros((n - m, m)), np.eye(m)])
    B1 = np.array(B1, float).reshape(n, -1)
    C1 = np.array(C1, float).reshape(-1, n)
    D12 = np.array(D12, float).reshape(-1, m)
    plant = sos.DescriptorSystem(np.eye(n), A, B, B1, C1, D12)
    if order:
        law = sos.DynamicLaw(order, C, strictly_proper=False, noise=D21)
    else:
        law = sos.PIDLaw(C, noise=D21)
    return plant, law


def springs(count=10, mass=4.0):
    """CSE1: masses on coupled springs, with a force at each end."""
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    K[0, 0] = K[-1, -1] = 1
    D = np.zeros((count, 2))
    D[0, 0], D[-1, 1] = 1, -1
    zero, one = np.zeros((count, count)), np.eye(count)
    A = np.block([[zero, one], [-K / mass, -one]])
    B = np.vstack([0 * D, D / mass])
    C = np.hstack([one, one])
    C1 = np.vstack([C, np.zeros((2, 2 * count))])
    D12 = np.vstack([np.zeros((count, 2)), np.eye(2)])
    return problem(A, B, C, -0.02 * B[:, 1:], C1, D12)


def beam(C1, weight):
    """EB1 and EB2: a beam of five modes, a noisy rate measured where the force is."""
    modes = [[[0, 1], [-(k**4), -0.02 * k**2]] for k in (1, 2, 3, 4, 5)]
    b = [0, 0.9877, 0, -0.309, 0, -0.891, 0, 0.5878, 0, 0.7071]
    B1 = np.column_stack([b, np.zeros(10)])
    C1 = [C1, np.zeros(10)]
    return problem(block_diag(*modes), b, b, B1, C1, [[0], [weight]], [[0, 1.9]])


def mass_damper():
    """TMD: a body on a moving base with two forces, after the mass is divided out."""
    md, ms, cs, ks, d, rho = 2, 5, 0.05, 3.0, 0.6, 0.4
    M = np.array([[md / 2, md / 2, 0], [-md / 2, md / 2, 0], [0, 0, ms]])
    D, S, back = np.diag([0, 0, cs]), np.diag([0, 0, ks]), np.linalg.inv(M)
    v, p = np.array([[0], [0], [cs]]), np.array([[0], [0], [ks]])
    u = [[-1, -1], [d**2 / rho**2, -(d**2) / rho**2], [1, 1]]
    A = np.block([[np.zeros((3, 3)), np.eye(3)], [-back @ S, -back @ D]])
    B1 = np.vstack([back @ v, back @ (p - D @ back @ v)])
    B = np.vstack([np.zeros((3, 2)), back @ u])
    C = [[1, 0, -1, 0, 0, 0], [0, 0, 0, 1, 0, -1], [0, 1, -1, 0, 0, 0],
         [0, 0, 0, 0, 1, -1]]  # fmt: skip
    C1 = np.zeros((3, 6))
    C1[0, 2] = 1
    D21 = C @ np.vstack([np.zeros((3, 1)), back @ v])
    return problem(A, B, C, B1, C1, [[0, 0], [1, 0], [0, 1]], D21)


def plate():
    """DLR1: a space structure's plate."""
    A = np.zeros((10, 10))
    A[:5, 5:] = np.eye(5)
    A[5] = [-8.4268, 0, 9.6557, 0, -5.083, -0.0253, 0, 0.0155, 0, -0.0112]
    A[6] = [0, -20.2022, 0, 20.0736, 0, 0, -0.0244, 0, 0.0151, 0]
    A[7] = [-23.9425, 0, -10.7354, 0, -147.0685, -0.0049, 0, -0.0359, 0, -0.0849]
    A[8] = [0, 126.1547, 0, -132.8028, 0, 0, 0.0947, 0, -0.1089, 0]
    A[9] = [-39.905, 0, 6.607, 0, -188.4411, -0.0247, 0, 0.0016, 0, -0.1368]
    B, B1 = np.zeros((10, 2)), np.zeros((10, 2))
    B[5:] = [[-0.001, -0.001], [-0.0133, 0.0133], [0.048, 0.048], [-0.0516, 0.0516],
             [0.0213, 0.0213]]  # fmt: skip
    B1[5:] = np.array([-0.0076, -0.0351, 0.0972, -0.1824, 0.0748])[:, None]
    C = np.zeros((2, 10))
    C[:, 5:] = [[0.0115, -0.0536, 0.9713, -0.2009, -0.5746],
                [0.0115, 0.0536, 0.9713, 0.2009, -0.5746]]  # fmt: skip
    C1 = np.zeros((2, 10))
    C1[0, 1] = 1
    C1[1, [0, 2, 4]] = -0.8084, 0.7509, -0.9501
    return problem(A, B, C, B1, C1, np.eye(2), [[0, 0], [0.0972, 0.7509]])


def helicopter():
    """HE1: a helicopter."""
    A = [[-0.0366, 0.0271, 0.0188, -0.4555], [0.0482, -1.01, 0.0024, -4.0208],
         [0.1002, 0.3681, -0.7070, 1.42], [0, 0, 1, 0]]  # fmt: skip
    B = [[0.4422, 0.1761], [3.5446, -7.5922], [-5.52, 4.49], [0, 0]]
    B1 = [[4.678e-2, 0], [4.572e-2, 9.88e-3], [4.369e-2, 1.11e-3], [-2.179e-2, 0]]
    C1 = np.array([[2, 0, 0, 0], [0, 1, 0, 0]]) / np.sqrt(2)
    return problem(A, B, [0, 1, 0, 0], B1, C1, np.eye(2) / np.sqrt(2))


def aircraft():
    """AC15: an aircraft's lateral motion."""
    A = [[-0.037, 0.0123, 0.00055, -1], [0, 0, 1, 0], [-6.37, 0, -0.23, 0.0618],
         [1.25, 0, 0.016, -0.0457]]  # fmt: skip
    B = [[0.00084, 0.000236], [0, 0], [0.08, 0.804], [-0.0862, -0.0665]]
    C1 = np.vstack([np.eye(4), np.zeros((2, 4))])
    D12 = np.vstack([np.zeros((4, 2)), np.eye(2)])
    return problem(A, B, np.eye(4)[1:], np.eye(4), C1, D12)


def platform():
    """MFP: a moored floating platform, with the library's own weights."""
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [-0.101, -0.1681, -0.04564, -0.01075],
         [0.06082, -2.1407, -0.05578, -0.1273]]  # fmt: skip
    B = [[0, 0, 0], [0, 0, 0], [0.1179, 0.1441, 0.1476], [0.1441, 1.7057, -0.7557]]
    return problem(A, B, np.eye(4)[:2])


def third_body():
    """ROC7: an oscillator and a weak coupling, by a controller of order one."""
    A = [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1.02], [0.2, 0, 0, 0]]
    C, C1 = [[1, 0, 0, 0], [0, 0, 1, 0]], np.zeros((3, 4))
    C1[0, 0] = C1[1, 2] = 0.1
    return problem(A, [0, -0.2, 0, 1], C, [0, 1, 0, -0.2], C1, [0, 0, 0.2], order=1)


def masses(count, order):
    """ROC8 and ROC9: free masses on springs; force on one end, noise at the other."""
    S = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    S[0, 0] = S[-1, -1] = 1
    A = np.zeros((2 * count, 2 * count))
    A[::2, 1::2], A[1::2, ::2] = np.eye(count), -S
    one = np.eye(2 * count)
    C1 = np.vstack([one, np.zeros((1, 2 * count))])
    D12 = np.append(np.zeros(2 * count), 1)
    return problem(A, one[1], one[-2], one[-1], C1, D12, [[1]], order)


EB1 = [0, 0.809, 0, -0.9511, 0, 0.309, 0, 0.5878, 0, -1]
EB2 = [0.809, 0, -0.9511, 0, 0.309, 0, 0.5878, 0, -1, 0]
PROBLEMS = {
    "HE1": helicopter,
    "AC15": aircraft,
    "MFP": platform,
    "CSE1": springs,
    "EB1": lambda: beam(EB1, 1.9),
    "EB2": lambda: beam(EB2, 0.5),
    "TMD": mass_damper,
    "DLR1": plate,
    "ROC7": third_body,
    "ROC8": lambda: masses(3, 3),
    "ROC9": lambda: masses(2, 2),
}
STARTS = {"CSE1": 8, "ROC8": 32}  # of a search; the others have 64
LIMITS = {"HE1": 100.0}  # of the gain: without one it grows as the norm falls
PATIENCE = 30.0  # seconds for hinfsyn, which can't be stopped otherwise


def full_order(name):
    """What hinfsyn reports for a problem, and the norm of its loop; or its error."""
    import control

    plant, law = PROBLEMS[name]()
    (d,), parts = plant.vertices, law.parts(plant)
    C, D21 = parts.rows.astype(float), parts.noise.astype(float)
    (q, p), (s, m) = (len(d.C), d.Bw.shape[1]), (len(C), d.Bu.shape[1])
    D = np.block([[np.zeros((q, p)), d.Du], [D21, np.zeros((s, m))]])
    whole = control.ss(d.A, np.hstack([d.Bw, d.Bu]), np.vstack([d.C, C]), D)
    try:
        _, loop, reported, _ = control.hinfsyn(whole, s, m)
        return {"reported": float(reported), "loop": float(control.linfnorm(loop)[0])}
    except Exception as error:  # the wrapper has kinds of its own, unknown elsewhere
        return {"error": " ".join(str(error).split())}


def by_hinfsyn(name):
    """The same within `PATIENCE`; nothing without slycot."""
    if find_spec("slycot") is None:
        return {}
    with get_context("spawn").Pool(1) as pool:  # the end of the block ends it
        try:
            return {"hinfsyn": pool.apply_async(full_order, [name]).get(PATIENCE)}
        except TimeoutError:
            return {"hinfsyn": {"error": f"no answer in {PATIENCE:g} s"}}


def measured(names=(), log=print):
    """Records: what was reached, proven, and excluded for every controller."""
    records = []
    for name in names or PROBLEMS:
        plant, law = PROBLEMS[name]()
        if name in LIMITS:
            law = sos.PIDLaw(law.position, limits={"K_P": LIMITS[name]})
        begun = process_time()
        asked = dict(minimize="gamma", backoff=0.001, starts=STARTS.get(name, 64))
        design = sos.design_pid(plant, law=law, **asked)
        record = dict(
            problem=name, states=plant.order, gains=law.structure(plant).shape
        )
        record |= dict(status=design.status, searched=str(design.searched))
        record["search_and_proof_s"] = round(process_time() - begun, 2)
        if design.status == "feasible":
            begun = process_time()
            gamma = design.bounds()["gamma"]
            record |= dict(
                K=design.K.tolist(),
                reached=gamma.true,
                proven=gamma.proven,
                decay=float(-design.poles().real.max()),
            )
            record["excluded_for_all"] = gamma.excluded
            record["bounds_s"] = round(process_time() - begun, 2)
        record |= by_hinfsyn(name)
        log(json.dumps({k: x for k, x in record.items() if k != "K"}))
        records.append(record)
    return records


if __name__ == "__main__":
    chosen = tuple(sys.argv[1:])
    found = measured(chosen)
    if not chosen:
        store(RESULTS, {"machine": machine(), "records": found})
