"""A primal-dual interior-point method with Nesterov-Todd scaling.

It solves the pair of semidefinite programs

    minimise c.x       subject to S_k = G_k(x) >= 0,
    maximise -sum <G_k0, Z_k>  subject to sum <G_ka, Z_k> = c_a, Z_k >= 0,

whose points satisfy c.x + sum <G_k0, Z_k> = sum <S_k, Z_k>, the duality gap,
where the dual equations hold. Each step takes, in this order,

1. the scaling point of every block: R with inv(R) S inv(R') = R' Z R = Lambda
   (Nesterov and Todd 1997; computed by Cholesky factors and a singular value
   decomposition as in Todd, Toh and Tütüncü 1998);
2. the predictor, Newton's direction towards S Z = 0 (Mehrotra 1992);
3. Mehrotra's target sigma mu, with mu = <S, Z> / nu and
   sigma = (mu after the predictor / mu)^3;
4. the corrector, with the predictor's second-order error;
5. 95 % of the longest steps that stay inside, one for S and one for Z.

The number of steps hardly depends on the size. With one more variable t, which
is maximised, the method finds a point inside, or sees that there is none: phase
one as in section 11.4 of Boyd and Vandenberghe (2004).
"""

import numpy as np

from .stacks import gram

SHORTEST_STEP = 1e-8  # shorter ones change nothing any more
SMALLEST_SQUARE = 1e-8  # of Lambda^2, by the largest; eigenvalues lose smaller ones
FARTHEST_POINT = 1e8  # a norm of x beyond it is taken for infinity
LARGEST_SHIFT = 1e-7  # of a minimum, relative, that rounding leaves uncertain
# the most steps; usually some twenty are taken
PHASE_ONE_STEPS, MINIMUM_STEPS, CENTRE_STEPS = 60, 40, 100
POLISHING_STEPS = 3  # after a minimum is known; they bring the point nearer
DIRECTION_TOLERANCE = 0.1  # of conjugate gradients; later steps correct it
STEP_FRACTION = 0.95  # of the longest step that stays inside


class _Scaling:
    """Nesterov and Todd's scaling of the blocks S and the multipliers Z.

    With S = L L', Z = M M' and the singular value decomposition M' L = U Lambda V'

        R = L V Lambda^(-1/2),   inv(R) = Lambda^(-1/2) U' M'

    give inv(R) S inv(R') = R' Z R = Lambda, and W = inv(R') inv(R) is the scaling
    point: W S W = Z. Where Lambda is near a multiple of I, the eigenvectors L' Z L = V
    Lambda^2 V' are as accurate, and inv(R) = Lambda^(-3/2) V' L' Z.
    """

    def __init__(self, S, Z):
        L = np.linalg.cholesky(S)
        LZ = L.mT @ Z
        squares, V = np.linalg.eigh(LZ @ L)
        if squares.min() > SMALLEST_SQUARE * squares.max():
            self.lam = np.sqrt(squares)
            self.root = 1 / np.sqrt(self.lam)
            self.R_inv = (self.root / self.lam)[..., None] * (V.mT @ LZ)
            return
        M = np.linalg.cholesky(Z)
        U, self.lam, _ = np.linalg.svd(M.mT @ L)
        self.root = 1 / np.sqrt(self.lam)
        self.R_inv = self.root[..., None] * (U.mT @ M.mT)

    def scaled(self, dS):
        """A change of S in these coordinates: inv(R) dS inv(R')."""
        return self.R_inv @ dS @ self.R_inv.mT

    def unscaled_dual(self, dZ):
        """A change R' dZ R of the scaled Z, in the blocks' own coordinates."""
        return self.R_inv.mT @ dZ @ self.R_inv

    def inverse(self):
        """inv(S) = inv(R') inv(Lambda) inv(R)."""
        return self.R_inv.mT / self.lam[..., None, :] @ self.R_inv

    def rates(self, change):
        """The r of a scaled ``change``: Lambda + a change > 0 where 1 + a r > 0."""
        return np.linalg.eigvalsh(
            self.root[..., None] * change * self.root[..., None, :]
        )

    def divide(self, change):
        """T with (Lambda T + T Lambda) / 2 = change: a Lyapunov equation."""
        return 2 * change / (self.lam[..., None] + self.lam[:, None, :])


def maximize_t(newton, x, watch=None):
    """Raise t, the last variable, until all blocks hold with t = 0.

    In ``newton`` are blocks G_k(x) - t D_k with D_k > 0, positive definite at x;
    ``watch`` gets a dict after each step: step, x, t, gap, residual, step lengths,
    iterations. Returns (verdict, x): "feasible", "undecided", or "infeasible", which is
    a guess by a dual point that isn't exact.
    """
    cost = np.zeros(len(x))
    cost[-1] = -1.0
    without_t = np.append(np.ones(len(x) - 1), 0.0)
    inverses = _inverses(newton.at(x))
    weight = -newton.adjoint(inverses)[-1]  # so that sum <D_k, Z_k> = 1
    Z = [w / weight for w in inverses]
    for state in interior_steps(newton, x, cost, weight, PHASE_ONE_STEPS, Z=Z):
        x = state["x"]
        if watch is not None:
            watch(state | {"t": x[-1]})
        if x[-1] > 0 and positive(newton.at(x * without_t)):
            return "feasible", x * without_t
        # weak duality: the largest t is at most t + gap
        if x[-1] + 1.1 * state["gap"] < 0 and np.linalg.norm(state["residual"]) < 1e-6:
            return "infeasible", x
    return "undecided", x


def minimize_linear(newton, x, cost, gap, weight):
    """(x, bound) of a minimum of cost.x over ``newton``'s blocks to the relative
    accuracy ``gap``, or None; ``weight`` is that of the ``cost`` in `interior_steps`.
    """
    near, count = None, 0
    for state in interior_steps(newton, x, cost, weight, MINIMUM_STEPS):
        last, x, residual = x, state["x"], state["residual"]
        if x @ x > FARTHEST_POINT**2:
            return None
        size, norm = abs(cost @ x), np.linalg.norm(residual)
        # the minimum is hardly farther away than the last point
        shift = abs(residual @ x) + norm * np.linalg.norm(x - last)
        known = state["gap"] < gap * size and shift < LARGEST_SHIFT * size
        if known and norm < 1e-6 * np.linalg.norm(cost) and positive(newton.at(x)):
            near, count = (x, cost @ x - state["gap"] - shift), count + 1
            if count > POLISHING_STEPS:
                break
        elif near is not None:
            break
    return near


def near_centre(newton, x):
    """A point near the analytic centre of ``newton``'s blocks, S Z = I, from x, or
    None: where Newton's steps are short, steps of S and of Z take some twenty.
    """
    zero = np.zeros(len(x))
    for state in interior_steps(newton, x, zero, 1.0, CENTRE_STEPS, target=1.0):
        far = np.linalg.norm(state["x"])
        if far > FARTHEST_POINT:
            return None
        inside = np.linalg.norm(state["residual"]) * far < 0.1
        if inside and positive(newton.at(state["x"])):
            return state["x"]
    return None


def interior_steps(newton, x, cost, weight, most, target=None, Z=None):
    """Yield what is known after each step from x inside, until no step helps.

    At most ``most`` steps of ``newton``'s blocks, towards S Z = target I, without a
    ``target`` S Z = 0. They start from ``Z``, else from the central path's dual point
    at this ``weight`` of the ``cost``, inv(S) / weight (Boyd and Vandenberghe 2004,
    section 11.6). Each dict has step, x, Z (stacked), gap = sum <G_k(x), Z_k>, the dual
    equations' residual, the lengths primal and dual, and iterations.
    """
    S = newton.at(x)
    if Z is None:
        Z = [w / weight for w in _inverses(S)]
    gap, residual = newton.inner(S, Z), cost - newton.adjoint(Z)
    for count in range(most):
        try:
            scalings = [_Scaling(s, z) for s, z in zip(S, Z)]
            dx, dz, primal, dual = _direction(
                newton, scalings, x, gap / newton.degree, cost, target
            )
        except np.linalg.LinAlgError:
            return
        if max(primal, dual) < SHORTEST_STEP:
            return
        x = x + primal * dx
        Z = [z + dual * d for z, d in zip(Z, dz)]
        Z = [(z + z.mT) / 2 for z in Z]
        S = newton.at(x)
        gap, residual = newton.inner(S, Z), cost - newton.adjoint(Z)
        lengths = dict(primal=primal, dual=dual, iterations=newton.iterations[-2:])
        yield dict(step=count + 1, x=x, Z=Z, gap=gap, residual=residual, **lengths)


def _inverses(S):
    """Inverses of the positive definite matrices in a list of stacks S."""
    return gram([np.linalg.inv(np.linalg.cholesky(s)) for s in S])


def _direction(newton, scalings, x, mu, cost, target=None):
    """Mehrotra's predictor and corrector: dx, dZ and both lengths; mu = <S, Z> / nu.

    In scaled coordinates Newton's equations for S Z = target read

        dS + dZ = T,   dS = inv(R) (sum_a dx_a G_a) inv(R'),
        sum <G_a, Z + dZ> = cost_a,

    where T solves (Lambda T + T Lambda) / 2 = target - Lambda^2 - (the second-order
    term): it is target inv(Lambda) - Lambda, less the term's part. Eliminating dS and
    dZ leaves

        H dx = adjoint(inv(R') (T + Lambda) inv(R)) - cost

    with the H of `Newton.solver` at W = inv(R') inv(R); without that term inv(R') (T +
    Lambda) inv(R) is target inv(S). Towards a given target conjugate gradients spare
    the predictor: its second-order term isn't worth another solution.
    """
    solve = newton.solver([s.R_inv for s in scalings], x)

    def step_towards(T, raised):
        """dx and the scaled dS and dZ with dS + dZ = T and no dual residual."""
        dx = solve(raised - cost, DIRECTION_TOLERANCE)
        if not np.isfinite(dx).all():
            raise np.linalg.LinAlgError("no finite step")
        dS = [s.scaled(d) for s, d in zip(scalings, newton.along(dx))]
        return dx, dS, [t - d for t, d in zip(T, dS)]

    errors = None
    if target is None or not newton.iterative:
        # predictor: the target is zero, so that T = -Lambda and each r_Z = -1 - r_S
        lam = [_diagonal(s.lam) for s in scalings]
        _, dS, dZ = step_towards([-h for h in lam], 0.0)
        errors = [
            s.divide((a @ b + (a @ b).mT) / 2) for s, a, b in zip(scalings, dS, dZ)
        ]
    if target is None:
        rates = [s.rates(d) for s, d in zip(scalings, dS)]
        primal = min(1.0, _longest(rates))
        dual = min(1.0, _longest([-1 - r for r in rates]))
        S = [h + primal * d for h, d in zip(lam, dS)]
        Z = [h + dual * d for h, d in zip(lam, dZ)]
        predicted = newton.inner(S, Z) / newton.degree
        target = min(max(predicted / mu, 0.0), 1.0) ** 3 * mu
    # corrector: towards the target, less the error dS dZ of the predictor
    T = [_diagonal(target / s.lam - s.lam) for s in scalings]
    raised = [target * s.inverse() for s in scalings]
    if errors is not None:
        T = [t - e for t, e in zip(T, errors)]
        raised = [r - s.unscaled_dual(e) for s, r, e in zip(scalings, raised, errors)]
    dx, dS, dZ = step_towards(T, newton.adjoint(raised))
    rates = [s.rates(np.array(d)) for s, *d in zip(scalings, dS, dZ)]
    primal = min(1.0, STEP_FRACTION * _longest([r[0] for r in rates]))
    dual = min(1.0, STEP_FRACTION * _longest([r[1] for r in rates]))
    return dx, [s.unscaled_dual(d) for s, d in zip(scalings, dZ)], primal, dual


def _diagonal(entries):
    """Diagonal matrices with the rows of ``entries``, as a stack."""
    return entries[..., None] * np.eye(entries.shape[-1])


def _longest(rates):
    """The longest step a <= 2 with 1 + a r > 0 for all rates r, a list of arrays."""
    return 1 / max(-min(r.min() for r in rates), 0.5)


def positive(stacks):
    """True if all matrices in a list of stacks are positive definite."""
    try:
        for s in stacks:
            np.linalg.cholesky(s)
    except np.linalg.LinAlgError:
        return False
    return True
