"""Beams, plates and rotors of finite elements.

Each function gives a plant and what is asked of it, by the arguments of
the kind of request that `benchmarks.catalogue` names. Units are such that
the lowest frequencies are of the order of one to ten.
"""

import numpy as np
from scipy.linalg import solve_continuous_are

import sosbook as sos
from sosbook.plants.descriptor import descriptors

from .elements import beam_matrices, plate_matrices
from .foreign import wiresaw
from .plants import beam


def cantilever(n):
    """A clamped beam with n degrees of freedom: see `benchmarks.plants.beam`."""
    return beam(_elements(n, 2))


def observed_beam(n):
    """A clamped beam whose tip's deflection is measured."""
    M, S = beam_matrices(_elements(n, 2))
    D = 0.3 * M + 0.0005 * S
    tip = np.eye(n)[:, [-2]]
    plant = sos.SecondOrderSystem(M, D, S, tip, tip)
    return plant, observed(plant, tip.T)


def observed_wire(n):
    """The wire of `benchmarks.foreign.wiresaw`, our damping, and one sensor."""
    wire, _ = wiresaw(n)
    seen = np.sin(0.3 * np.pi * np.arange(1, n + 1))[None]
    D = wire.D + 0.05 * np.eye(n)
    plant = sos.SecondOrderSystem(wire.M, D, wire.S, seen.T, seen.T)
    return plant, observed(plant, seen)


def observed(plant, seen):
    """What `design_observer` is given: an LQR's gain, what is seen, the noise."""
    (d,) = descriptors(plant)
    A, B, _ = d.state_space()
    N = len(A)
    X = solve_continuous_are(A, B, np.eye(N), np.eye(B.shape[1]))
    return dict(
        K=-B.T @ X,
        Q_F=np.vstack([np.eye(N), np.zeros((N, N))]),
        R_F=0.1 * np.eye(len(seen)),
        C=np.hstack([seen, 0 * seen]),
    )


def plate(n):
    """A clamped plate of one column of elements or more, two across if it can.

    Clamped along x = 0, twice as long as wide. Forces act on the corners of
    the free end. With one element across n is a multiple of six, with two of
    nine.
    """
    rows = 2 if n % 9 == 0 else 1
    columns = _elements(n, 3 * (rows + 1))
    M, S = (x[-n:, -n:] for x in plate_matrices(columns, rows, 2.0, 1.0))
    corners = [n - 3, n - 3 * (rows + 1)]
    B = np.eye(n)[:, corners]
    plant = sos.SecondOrderSystem(M, 0.1 * M + 0.002 * S, S, B, B)
    return plant, dict(region=sos.PoleRegion(sigma=0.2))


def rotor(n, speed=2.0):
    """A shaft that is clamped at one end, turns, and carries a disk a node.

    Two bending planes, 4 degrees of freedom a node: x, its slope, y, its slope.
    The disks' polar inertia couples the slopes of both planes: the skew part of
    D. Source: G. Genta, Dynamics of Rotating Systems, 2005, chapter 4. The
    numbers are our own; two forces act on the last disk.
    """
    elements = _elements(n, 4)
    m, S = beam_matrices(elements)
    disk = 0.5 / elements
    m = m + np.kron(np.eye(elements), np.diag([disk, 0.05 * disk]))
    polar = np.kron(np.eye(elements), np.diag([0, 0.1 * disk]))
    turn = np.array([[0, 1], [-1, 0]])
    M, S = np.kron(np.eye(2), m), np.kron(np.eye(2), S)
    D = 0.05 * M + 0.0005 * S + speed * np.kron(turn, polar)
    B = np.eye(n)[:, [n // 2 - 2, n - 2]]
    return sos.SecondOrderSystem(M, D, S, B, B), {}


def _elements(n, each):
    if n < each or n % each:
        raise ValueError(f"n = {n} must be a multiple of {each}")
    return n // each
