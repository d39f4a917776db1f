"""Lower bounds of gamma in a joint request."""

from dataclasses import dataclass

import numpy as np

from ...analysis.linear import balancing, hinf_norm, loop_matrix, poles
from ...analysis.riccati import lyapunov
from ...plants.checks import matrix, positive
from ...plants.gain import gain_of
from ...plants.kinds import SecondOrderPlant, checked_plant
from ...synthesis.request import Request

__all__ = ["GammaLowerBounds", "gamma_lower_bounds"]


@dataclass(frozen=True)
class GammaLowerBounds:
    """Three lower bounds on what (2.15) and (2.21) can prove together: gamma is above
    the largest H-infinity ``norm`` from w to z; gamma^2 > mu ``energy``, the largest
    integral of z'z of the free motion from x(0); and mu is above ``mu``, else some w of
    energy 1 / mu drives |K x| from rest above u_max.
    """

    norm: float
    energy: float
    mu: float

    def gamma(self, mu):
        """No joint certificate has a smaller gamma at this ``mu``."""
        if positive("mu", mu) <= self.mu:
            return np.inf
        return float(max(self.norm, np.sqrt(mu * self.energy)))

    @property
    def corner(self):
        """The mu at which x(0) begins to cost: norm^2 / energy."""
        return self.norm**2 / self.energy if self.energy else np.inf


def gamma_lower_bounds(plant, K, U=None, saturation=None, K_A=None):
    """The `GammaLowerBounds` of a stable loop, the largest over its vertices.
    ``plant``, ``K``, ``U``, ``K_A``: as in `analyse_pid`; ``saturation``: u_max and
    x(0). With V = x' P^-1 x the LMIs say that along every motion V' < mu w'w - (mu /
    gamma^2) z'z, V(x(0)) < 1 and |K x|^2 < u_max^2 V: put w = 0, or start from rest.
    Raises ValueError if the loop isn't stable, or nothing is disturbed.

    >>> from sosbook.book import thesis
    >>> ex = thesis.example_1()
    >>> lower = gamma_lower_bounds(ex.plant, ex.K, ex.U, ex.saturation)
    >>> round(lower.norm, 4), round(lower.gamma(1.0), 3)
    (0.0113, 0.306)
    """
    plant = checked_plant(plant, SecondOrderPlant)
    if plant.p == 0:
        raise ValueError("the plant has no F: there is no norm to bound")
    request = Request(plant, U, saturation=saturation, K_A=K_A)
    if all(r.bounds_input_from() is None for r in request.requirements):
        raise ValueError(
            "saturation must be a Saturation(u_max, x0) without acceleration"
        )
    vertices = request.vertices
    K = matrix("K", gain_of(K, plant, U), (plant.m, request.order))
    if max(poles(d, K).real.max() for d in vertices) >= 0:
        raise ValueError("K doesn't stabilise every vertex")
    bounds = np.array([_lower_bounds(d, K, saturation) for d in vertices])
    return GammaLowerBounds(*map(float, bounds.max(axis=0)))


def _lower_bounds(d, K, saturation):
    A, (_, _, B) = loop_matrix(d, K), d.state_space()
    units = balancing(A)  # x = units xi
    A, B, C = A / units[:, None] * units, B / units[:, None], d.C * units
    x0, drive = saturation.x0 / units, K * units
    seen = lyapunov(A.T, -C.T @ C)
    reached = lyapunov(A, -B @ B.T)
    force = np.linalg.eigvalsh(drive @ reached @ drive.T)[-1]
    return hinf_norm(d, K), x0 @ seen @ x0, force / saturation.u_max**2
