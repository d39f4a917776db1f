r"""The functional behind a design, along a simulated motion.

Theorem A.3 says that :math:`e^{2\delta t} V(t)` never grows. A motion on which it does
would refute a certificate; where it shrinks fast, the certificate has room to spare.
"""

import numpy as np

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(3)
GAUSS_POINTS, GAUSS_WEIGHTS = (1 + GAUSS_POINTS) / 2, GAUSS_WEIGHTS / 2
# rows: what the parabola through the Gauss points makes of them, at the
# ends of a cell
ENDS = np.vander([0.0, 1.0], 3) @ np.linalg.inv(np.vander(GAUSS_POINTS))
MATRICES = ("P", "Q", "S", "R1", "R2", "R3", "Z")


def lyapunov_values(design, response):
    r"""V(t) of Theorem A.3 along a motion of the design's loop.

    Parameters
    ----------
    design : DelayDesign
        Feasible, of ``method="functional"`` or ``"shift"``.
    response : DelayedResponse
        Of one plant, without set point and disturbance (r = 0, w = 0),
        for V measures the distance from rest. V looks back tau + mu
        seconds, so the response must be longer than that.

    Returns
    -------
    (k,) array
        V at the times of the response, a number without unit. NaN
        during the first tau + mu seconds, whose past isn't covered.

    Raises
    ------
    ValueError
        If the design has no functional of this kind, or the response
        another number of states or too few seconds.

    Notes
    -----
    Between two times x is taken for the parabola through x, x' at the first and x at
    the second, and that is integrated exactly: the error is of order three in the step
    where jumps of x', which jumps of the delay cause, are among the times
    (``delay.jumps``), else of order one at these jumps. Rounding errors are near 1e-14
    of the largest :math:`e^{2\delta t} V`.

    The functional is that of `sosbook.delay.theorems`, with x in the design's own
    coordinates and tau as the unit of time. A design's matrices have a bar: :math:`P =
    \bar F^{-1} \bar P \bar F^{-\top}`. With "shift" it is that of :math:`y(s) =
    e^{\delta(s-t)} x(s)`: y for x, and delta = 0.

    Examples
    --------
    >>> from sosbook.delay import ConstantDelay, DelayedLoop, analyse_delay
    >>> d = analyse_delay(DelayedLoop([[0]], [[-1]]), tau=0.5, delta=0.1)
    >>> t = np.linspace(0, 10, 1001)
    >>> motion = d.simulate(t, ConstantDelay(0.5), history=lambda s: [1.0])
    >>> falling = (np.exp(0.2 * t) * lyapunov_values(d, motion))[t >= 0.5]
    >>> bool(falling[-1] > 0), bool((np.diff(falling) < 0).all())
    (True, True)
    """
    request = design.request
    P, Q, S, R, Z = _functional(design)
    x, dx = (getattr(response, name, None) for name in ("x", "dx"))
    if x is None or len(x) != request.states:
        raise ValueError(
            f"response must be a DelayedResponse with {request.states} "
            "states: for a polytope, the one of a single vertex"
        )
    tau, mu = request.tau, request.mu / request.tau
    t = (response.t - response.t[0]) / tau
    ready = t >= (1 + mu) * (1 - 1e-12)
    if not ready.any():
        raise ValueError(
            "response must last longer than tau + mu = "
            f"{request.tau + request.mu:.6g} s, the past in V"
        )
    T = request.frame.T
    x, dx = np.linalg.solve(T, x).T, tau * np.linalg.solve(T, dx).T
    delta = request.delta * tau
    weight = np.exp(2 * delta * t)  # of V, in what doesn't grow
    if request.method == "shift":
        lift = np.exp(delta * t)[:, None]
        x, dx = lift * x, lift * (dx + delta * x)
        delta = 0.0
    cells = _Cells(t, x, dx)
    w = np.concatenate([cells.x, cells.dx], -1)
    aged = np.exp(2 * delta * cells.s)
    now, x = t[ready], x[ready]

    def back(integral, lag):
        return integral(np.maximum(now - lag, 0))

    sums, _ = cells.integrals(cells.x)
    stored, _ = cells.integrals(aged * _square(S, cells.x))
    moved, moved_twice = cells.integrals(aged * _square(R, w))
    pushed, pushed_twice = cells.integrals(aged * _square(Z, cells.dx))

    eta = sums(now) - back(sums, 1)
    V = np.exp(2 * delta * now) * (_square(P, x) + 2 * ((x @ Q) * eta).sum(-1))
    V += stored(now) - back(stored, 1)
    V += moved(now) - (moved_twice(now) - back(moved_twice, 1))
    V += 2 * mu * pushed(now) - (
        back(pushed_twice, 1 - mu) - back(pushed_twice, 1 + mu)
    )
    values = np.full(len(t), np.nan)
    values[ready] = V / weight[ready]
    return values


def _functional(design):
    """P, Q, S, R, Z without a bar."""
    request = design.request
    if design.values is None:
        raise ValueError(f"the design is {design.status}: it has no V")
    if request.method == "legendre":
        raise ValueError(
            'design must have method="functional" or "shift": the V of '
            '"legendre" is another one'
        )
    v = {"Z": 0 * design.values["S"]} | design.values
    if request.gain is None:
        back = np.linalg.inv(v["F"])
        v |= {name: back @ v[name] @ back.T for name in MATRICES}
    R = np.block([[v["R1"], v["R2"].T], [v["R2"], v["R3"]]])
    return v["P"], v["Q"], v["S"], R, v["Z"]


def _square(form, x):
    return ((x @ form) * x).sum(-1)


class _Cells:
    """Between neighbouring times x is a parabola.

    ``t``, (k,) array; ``x``, ``dx``, (k, N) arrays.
    """

    def __init__(self, t, x, dx):
        self.t, self.h = t, np.diff(t)[:, None]
        bend = np.diff(x, axis=0) / self.h - dx[:-1]  # h x'' / 2
        part = self.h * GAUSS_POINTS
        self.s = t[:-1, None] + part
        part = part[..., None]
        ratio = GAUSS_POINTS[:, None]
        self.x = x[:-1, None] + part * (dx[:-1, None] + ratio * bend[:, None])
        self.dx = dx[:-1, None] + 2 * ratio * bend[:, None]

    def integrals(self, g):
        """The integral from t[0] of g, and the integral of that.

        ``g``, (k - 1, 3, ...): at the Gauss points of the cells. Returns two functions
        of the time.
        """
        from scipy.interpolate import CubicHermiteSpline

        h = self.h.reshape(-1, *(1,) * (g.ndim - 2))
        once = _sums(h * np.tensordot(GAUSS_WEIGHTS, g, (0, 1)))
        left = np.tensordot(GAUSS_WEIGHTS * (1 - GAUSS_POINTS), g, (0, 1))
        twice = _sums(h * (once[:-1] + h * left))
        first, last = (np.tensordot(ends, g, (0, 1)) for ends in ENDS)
        slopes = np.concatenate([first, last[-1:]])
        return (
            CubicHermiteSpline(self.t, once, slopes),
            CubicHermiteSpline(self.t, twice, once),
        )


def _sums(parts):
    return np.concatenate([0 * parts[:1], np.cumsum(parts, axis=0)])
