"""The LQR of the thesis's mobile inverted pendulum as an LMI.

Theorem 2.4: minimise tr J. See `benchmarks.questions.Lqr` for the judge.
"""

from dataclasses import dataclass

import numpy as np

import sosbook as sos
from sosbook.lmi import Unknown, block, eye, he
from sosbook.plants.descriptor import descriptors
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame


@dataclass(frozen=True, eq=False)
class LqrTask:
    """Theorem 2.4 in given coordinates: x = T xi, u = scale v, rows, J."""

    plant: sos.SecondOrderSystem
    T: np.ndarray
    left: np.ndarray
    unit: float  # of w, in which J is small

    @classmethod
    def of(cls, plant, framed=False):
        d = descriptors(plant)[0]
        one = np.eye(len(d.E))
        if not framed:
            return cls(plant, one, one, 1.0)
        frame = Frame.of(Request(plant))
        left, T = frame.left, frame.T
        return cls(plant, T, left, np.linalg.norm(left @ d.Bw, 2))

    @property
    def unknowns(self):
        d = descriptors(self.plant)[0]
        N, m, p = len(d.E), d.Bu.shape[1], d.Bw.shape[1]
        return [
            Unknown("P", N, symmetric=True),
            Unknown("Y", m, N),
            Unknown("J", p, symmetric=True),
        ]

    def blocks(self, P, Y, J):
        """(2.35) and minus (2.36), with Q = I and R = I."""
        d = descriptors(self.plant)[0].change(self.left, self.T)
        m = d.Bu.shape[1]
        EP = d.E @ P
        theta = (d.A @ P + d.Bu @ Y) @ d.E.T
        Bw = d.Bw / self.unit
        return {
            "J": block([[J, Bw.T], [Bw, EP @ d.E.T]]),
            "lqr": -block(
                [
                    [he(theta), EP @ self.T.T, d.E @ Y.T],
                    [self.T @ EP.T, -eye(len(d.E)), 0],
                    [Y @ d.E.T, 0, -eye(m)],
                ]
            ),
        }

    def expressions(self):
        unknowns = self.unknowns
        return list(self.blocks(*unknowns).values()), unknowns

    def cost(self):
        """The trace of J in the free entries of P, Y, J."""
        *others, J = self.unknowns
        return np.concatenate(
            [
                *(np.zeros(u.size) for u in others),
                J.pack(np.eye(J.shape[0])).astype(float),
            ]
        )

    def gain(self, P, Y, J):
        return np.linalg.solve(self.T.T, np.linalg.solve(P.T, Y.T)).T
