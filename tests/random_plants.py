"""Random requests whose verdict is known before they are solved, in random units.

"feasible"    A gain and P are known from a Riccati equation; bounds are backed off.
"infeasible"  A reason without an LMI excludes every gain (`Case.reason`), or a bound
              lies below an optimum that Clarabel finds.
"marginal"    Either, within a fraction of 1e-3 to 1e-6 of the edge.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigvals, solve_continuous_are

import sosbook as sos
from sosbook.lmi import Unknown
from sosbook.plants.descriptor import descriptors
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import margin
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests import clarabel

ROUNDED = ", but for rounding"
KINDS = ("feasible", "infeasible", "marginal")

#: Units of time, length and force that have no short decimals nor binary fractions.
ODD = 0.3, 1 / 9.81, 2.2046
ODD_POWERS = tuple(float(np.log10(x)) for x in (*ODD, 0.3, 2.2046))


@dataclass(frozen=True, eq=False)
class Units:
    """Other units: w0 t, T z, u = Q v, rows by R, integrators by G, w by sqrt(w0).

    With gamma T must be, with saturation Q must be, a multiple of an orthogonal matrix.
    """

    w0: float
    T: np.ndarray
    R: np.ndarray
    Q: np.ndarray
    G: np.ndarray

    @classmethod
    def plain(cls, n, m, a):
        """Nothing changes."""
        return cls(1.0, np.eye(n), np.eye(n), np.eye(m), np.eye(a))

    def system(self, v):
        """A SecondOrderSystem in these units."""
        back, R, w0 = np.linalg.inv(self.T), self.R, self.w0
        return sos.SecondOrderSystem(
            R @ v.M @ back * w0**2,
            R @ v.D @ back * w0,
            R @ v.S @ back,
            R @ v.B @ self.Q,
            R @ v.F * np.sqrt(w0),
        )

    def plant(self, plant):
        """A plant or a polytope in these units."""
        if isinstance(plant, sos.SecondOrderSystem):
            return self.system(plant)
        return sos.Polytope([self.system(v) for v in plant.vertices])

    @property
    def state(self):
        """The matrix from [z; z'; x3] to the same in these units."""
        n, a = len(self.T), len(self.G)
        out = np.zeros((2 * n + a, 2 * n + a))
        out[:n, :n] = self.T
        out[n : 2 * n, n : 2 * n] = self.T / self.w0
        out[2 * n :, 2 * n :] = self.w0 * self.G
        return out

    def gain(self, K):
        """K in these units."""
        return np.linalg.solve(self.Q, K) @ np.linalg.inv(self.state)

    def lyapunov(self, P):
        """P in these units."""
        P = self.state @ P @ self.state.T
        return (P + P.T) / 2

    def requirements(self, asked):
        """The requirements in these units."""
        out, w0, back = dict(asked), self.w0, np.linalg.inv(self.T)
        if "U" in asked:
            out["U"] = self.G @ asked["U"] @ back
        if "region" in asked:
            r = asked["region"]
            out["region"] = sos.PoleRegion(
                r.sigma and r.sigma / w0, r.theta, r.rho and r.rho / w0
            )
        if "gamma" in asked:
            size = np.linalg.norm(self.T, 2) * np.sqrt(w0)
            out["gamma"] = asked["gamma"] * size
        if "saturation" in asked:
            s = asked["saturation"]
            out["saturation"] = sos.Saturation(
                s.u_max / np.linalg.norm(self.Q, 2), self.state @ s.x0
            )
        if "K_A" in asked:
            out["K_A"] = np.linalg.solve(self.Q, asked["K_A"] @ back * w0**2)
        return out


def as_units(plant, powers, a):
    """Units of time, length, force, input and ``a`` integrators, as powers of ten."""
    time, length, force, signal, integral = (10.0**p for p in powers)
    return Units(
        time,
        length * np.eye(plant.n),
        force * np.eye(plant.n),
        signal * np.eye(plant.m),
        integral * np.eye(a),
    )


@dataclass(frozen=True, eq=False)
class Case:
    """A request, and what is known about it."""

    seed: int
    kind: str  # one of KINDS
    verdict: str  # "feasible" or "infeasible": what the answer has to be
    reason: str
    plant: object
    requirements: dict
    units: Units  # which were applied last
    witness: tuple = None  # K and P that fulfil a feasible request


def random_request(seed):
    """The plant and the requirements of `random_case`."""
    case = random_case(seed)
    return case.plant, case.requirements


def random_case(seed, largest=8):
    """A `Case`; same seed, same request, of so many degrees of freedom at most."""
    kind = KINDS[seed % 3]
    rng = np.random.default_rng([seed, 20])
    make = {
        "feasible": [_backed_off],
        "infeasible": [_mode, _out_of_reach, _force, _static, _signs, _edge],
        "marginal": [_mode, _edge],
    }[kind]
    marginal = kind == "marginal"
    while True:
        found = make[rng.integers(len(make))](rng, largest, marginal)
        if found is not None:
            break
    plant, asked, feasible, reason, *witness = found
    units = _random_units(rng, plant, asked)
    if witness:
        K, P = witness
        witness = units.gain(K), units.lyapunov(P)
    return Case(
        seed,
        kind,
        "feasible" if feasible else "infeasible",
        reason,
        units.plant(plant),
        units.requirements(asked),
        units,
        witness or None,
    )


def _log(rng, low, high):
    """10 to a random power."""
    return 10 ** rng.uniform(low, high)


def _orthogonal(rng, n):
    return np.linalg.qr(rng.standard_normal((n, n)))[0]


def _random_units(rng, plant, asked):
    n, m = plant.n, plant.m
    a = len(asked.get("U", ()))
    if rng.random() < 0.2:
        return Units.plain(n, m, a)

    def scales(size, alone):
        if alone or rng.random() < 0.6:
            return np.eye(size) * _log(rng, -6, 6)
        return np.diag(_log(rng, -3, 3) * 10 ** rng.uniform(-2, 2, size))

    return Units(
        _log(rng, -6, 6),
        scales(n, "gamma" in asked),
        scales(n, False),
        scales(m, "saturation" in asked),
        scales(a, False),
    )


def _degrees_of_freedom(rng, largest, least=1):
    """Small plants are more likely."""
    sizes = np.arange(least, largest + 1)
    weights = 1 / sizes
    return int(rng.choice(sizes, p=weights / weights.sum()))


def _parts(rng, n, m, p):
    """M, D, S, B, F of a random plant, in plain units."""
    style = rng.choice(["any", "structure", "stiff"])
    root = rng.standard_normal((n, n))
    M = np.eye(n) + 0.3 * root @ root.T
    if style == "any":  # neither symmetric nor stable
        D, S = rng.standard_normal((n, n)), 3 * rng.standard_normal((n, n))
    else:  # lightly damped, gyroscopic
        spread = 1 if style == "structure" else 3
        Q = _orthogonal(rng, n)
        S = Q * 10 ** rng.uniform(-0.5, -0.5 + spread, n) @ Q.T
        G = rng.standard_normal((n, n))
        D = 0.02 * S / np.sqrt(np.diag(S).max()) + 0.02 * M + 0.1 * (G - G.T)
    return [M, D, S, rng.standard_normal((n, m)), rng.standard_normal((n, p))]


def _with_integrators(rng, parts, asked):
    """The plant of these parts, or None; some ask for a controllable U, too."""
    try:
        plant = sos.SecondOrderSystem(*parts)
    except ValueError:
        return None
    if a := int(rng.integers(0, plant.m + 1)):
        U = rng.standard_normal((a, plant.n))
        try:
            Request(plant, U=U)
        except ValueError:
            return plant
        asked["U"] = U
    return plant


def _polytope(rng, parts, count, spread, mass):
    """Vertices around a plant: other D, S and, if asked, M."""
    if count == 1:
        return sos.SecondOrderSystem(*parts)
    M, D, S, B, F = parts
    n = len(M)

    def near(X):
        return X * (1 + spread * rng.uniform(-1, 1, (n, n)))

    def symmetric(X):
        tilt = spread * rng.uniform(-1, 1, n)
        return X * np.sqrt(np.outer(1 + tilt, 1 + tilt))

    return sos.Polytope(
        [
            sos.SecondOrderSystem(symmetric(M) if mass else M, near(D), near(S), B, F)
            for _ in range(count)
        ]
    )


def _base(rng, largest, least=1, fewer_inputs=False):
    """A random plant with U and K_A, as a list of its parts."""
    n = _degrees_of_freedom(rng, largest, least)
    m = int(rng.integers(1, n + (not fewer_inputs)))
    parts = _parts(rng, n, m, int(rng.integers(1, min(n, 2) + 1)))
    asked = {}
    if rng.random() < 0.15:  # a coordinate without mass
        Q = _orthogonal(rng, n)
        parts[0] = Q[:, 1:] * rng.uniform(0.5, 2, n - 1) @ Q[:, 1:].T
        found = sos.regularize(sos.SecondOrderSystem(*parts), beta=0.3)
        if found.status != "feasible" or found.bound < 0.05:
            return None
        asked["K_A"] = found.K_A
    return parts, asked


def _based(rng, *size):
    """As `_base`, and the plant of these parts, with integrators; or None."""
    base = _base(rng, *size)
    plant = base and _with_integrators(rng, *base)
    return plant and (*base, plant)


def _vertex_count(rng, n):
    return int(rng.integers(1, 5)) if n <= 4 else int(rng.integers(1, 3))


# ---- feasible: backed off from a gain that is known
def _backed_off(rng, largest, marginal):
    """Requirements that a gain from a Riccati equation fulfils."""
    found = _known(rng, largest)
    if found is None:
        return None
    known, asked, spread = found
    return (
        known.plant,
        asked,
        True,
        f"the gain of a Riccati equation, spread {spread:.1g}",
        known.K,
        known.P,
    )


def _known(rng, largest):
    """A `_Known`, all that it is asked, the spread of its vertices."""
    base = _based(rng, largest)
    if base is None:
        return None
    parts, asked, single = base
    (d,) = descriptors(single, asked.get("U"), asked.get("K_A"))
    A, B, _ = d.state_space()
    shift = rng.uniform(0.05, 0.3)
    if not _controllable(A, B, 1e-3):
        return None
    effort = _log(rng, -2, 1)
    X = solve_continuous_are(
        A + shift * np.eye(len(A)), B, np.eye(len(A)), effort * np.eye(single.m)
    )
    K = -B.T @ X / effort
    T = np.linalg.inv(np.linalg.cholesky(X)).T  # P = T T'
    count = _vertex_count(rng, single.n)
    mass = "K_A" not in asked and rng.random() < 0.3
    state = rng.bit_generator.state
    spread = 0.2
    while True:  # the same corners, closer and closer
        rng.bit_generator.state = state
        try:
            plant = _polytope(rng, parts, count, spread, mass)
            known = _Known(plant, asked, K, T)
            if known.proves(sigma=shift / 2):
                break
        except ValueError:  # M - B K_A became singular
            pass
        spread /= 2
        if spread < 1e-4:
            return None
    if count == 1:
        spread = 0
    return known, asked | known.requirements(rng, shift / 2), spread


def _controllable(A, B, least):
    """Whether no mode is closer than this to being out of reach."""
    if np.linalg.norm(B) == 0:
        return False
    scale = np.linalg.norm(A, 2)
    return all(
        np.linalg.svd(
            np.hstack([(A - s * np.eye(len(A))) / scale, B / np.linalg.norm(B, 2)]),
            compute_uv=False,
        )[-1]
        > least
        for s in eigvals(A)
    )


class _Known:
    """A gain K and a Lyapunov matrix P = size T T' of a plant."""

    def __init__(self, plant, asked, K, T):
        self.plant, self.asked = plant, dict(asked)
        self.K, self.T = K, T
        self.size = 1.0

    def margin(self, sigma=None, theta=None, rho=None, **more):
        """The smallest eigenvalue of all blocks, in units of P."""
        region = None
        if (sigma, theta, rho) != (None,) * 3:
            region = sos.PoleRegion(sigma, theta, rho)
        request = Request(self.plant, **self.asked, **more, region=region)
        frame = self.frame(request)
        blocks = request.blocks(
            np.eye(request.order), self.K @ frame.T / frame.scale, frame=frame
        )
        return min(margin(g) for g in blocks.values())

    @property
    def P(self):
        return self.size * self.T @ self.T.T

    def frame(self, request):
        """The frame in which the known P is the identity."""
        T = self.T * np.sqrt(self.size)
        return Frame(
            np.linalg.inv(request.vertices[0].E @ T),
            T,
            np.linalg.inv(T),
            np.linalg.norm(self.K @ T, 2),
        )

    def proves(self, **asked):
        return self.margin(**asked) > 1e-6

    def edge(self, name, good, bad, **more):
        """Where a requirement's value ceases to be proven."""
        if not self.proves(**{name: good}, **more):
            return None
        for _ in range(25):
            middle = np.sqrt(good * bad)
            if self.proves(**{name: middle}, **more):
                good = middle
            else:
                bad = middle
        return good

    def requirements(self, rng, shift):
        """Random ones, backed off from the edges."""

        def back():
            return 1 + _log(rng, -2, 0.3)

        region, out = {}, {}
        if rng.random() < 0.7:
            region["sigma"] = self.edge("sigma", shift, 1e3) / back()
        if rng.random() < 0.5:
            theta = self.edge("theta", np.pi / 2, 1e-3)
            if theta is not None:
                region["theta"] = min(theta * back(), np.pi / 2)
        if rng.random() < 0.6:
            rho = self.edge("rho", 1e6, 1e-3)
            if rho is not None:
                region["rho"] = rho * back()
        if rng.random() < 0.4:
            x0 = _log(rng, -1, 1) * rng.standard_normal(len(self.T))
            xi = np.linalg.solve(self.T, x0)
            self.size = xi @ xi * back()
            u_max = np.linalg.norm(self.K @ self.T, 2) * np.sqrt(self.size)
            out["saturation"] = sos.Saturation(u_max * back(), x0)
        if rng.random() < 0.5:
            if "saturation" not in out:
                self.size = 1e-3
            while self.size < 1e12:
                gamma = self.edge("gamma", 1e4, 1e-6)
                if gamma is not None:
                    break
                if "saturation" in out:  # P is fixed: a weaker w instead
                    break
                self.size *= 4
            if gamma is not None:
                out["gamma"] = gamma * back()
        if region:
            out["region"] = sos.PoleRegion(**region)
        return out


# ---- infeasible for a reason that needs no LMI
def _around(rng, parts, spread, mass):
    """A polytope with the plant itself, which excludes every gain."""
    count = 2 if len(parts[0]) > 4 else int(rng.integers(2, 5))
    others = _polytope(rng, parts, count, spread, mass).vertices[1:]
    return sos.Polytope([sos.SecondOrderSystem(*parts), *others])


def _mode(rng, largest, marginal):
    """A mode that no input reaches, half of them rotated: so up to rounding."""
    if largest < 2:
        return None
    n = _degrees_of_freedom(rng, largest, 2)
    m = int(rng.integers(1, n))
    parts = _parts(rng, n - 1, m, 1)
    omega, zeta = _log(rng, -0.5, 0.8), rng.uniform(0.05, 0.9)
    kind = rng.choice(["sigma", "theta", "rho"])
    edge = {"sigma": zeta * omega, "theta": np.arccos(zeta), "rho": omega}
    far = _log(rng, -6, -3) if marginal else rng.uniform(0.05, 0.8)
    inside = marginal and rng.random() < 0.5
    tighter = (kind == "sigma") != inside  # sigma grows, others shrink
    value = edge[kind] * ((1 + far) if tighter else 1 / (1 + far))
    region = {kind: min(value, np.pi / 2) if kind == "theta" else value}
    M, D, S, B, F = (np.zeros((n, x.shape[1] + 1)) for x in parts)
    B, F = B[:, :m], F[:, :1]
    for full, part in zip((M, D, S, B, F), parts):
        full[: n - 1, : part.shape[1]] = part
    M[-1, -1], D[-1, -1], S[-1, -1] = 1, 2 * zeta * omega, omega**2
    coupled = 0.3 * rng.standard_normal((2, n - 1))
    D[:-1, -1], S[:-1, -1] = coupled
    F[-1, 0] = rng.standard_normal()
    rotated = rng.random() < 0.5
    if rotated:
        Q, R = _orthogonal(rng, n), _orthogonal(rng, n)
    else:
        Q, R = np.eye(n)[rng.permutation(n)], np.eye(n)
    plant = sos.SecondOrderSystem(R @ M @ Q, R @ D @ Q, R @ S @ Q, R @ B, R @ F)
    asked = {"region": sos.PoleRegion(**region)}
    if rng.random() < 0.5:
        U = np.zeros((1, n))
        U[0, : n - 1] = rng.standard_normal(n - 1)
        asked["U"] = U @ Q
    (d,) = descriptors(
        sos.SecondOrderSystem(*parts),
        (asked["U"] @ Q.T)[:, : n - 1] if "U" in asked else None,
    )
    if not _controllable(*d.state_space()[:2], 1e-3):
        return None
    return (
        plant,
        asked,
        inside or rotated,
        f"a mode out of reach, {kind} {far:.1g} from its edge"
        + (ROUNDED if rotated and not inside else ""),
    )


def _extras(rng, asked):
    """More requirements: they never make a request feasible."""
    region = {}
    if rng.random() < 0.3:
        region["theta"] = rng.uniform(0.3, np.pi / 2)
    if rng.random() < 0.3:
        region["rho"] = _log(rng, 1, 3)
    if region and "region" not in asked:
        asked["region"] = sos.PoleRegion(**region)


def _out_of_reach(rng, largest, marginal):
    """gamma below what w does without input: N'B = 0 gives, in every loop,
    N'(S + i omega D - omega^2 M) z = N'F w; |z| is at least the least-norm solution.
    """
    base = _based(rng, largest, 2, True)
    if base is None:
        return None
    parts, asked, plant = base
    M, D, S, B, F = parts
    N = np.linalg.svd(B)[0][:, B.shape[1] :].T
    bound = max(
        np.linalg.norm(np.linalg.pinv(N @ (S + 1j * w * D - w**2 * M)) @ N @ F, 2)
        for w in np.append(0, np.logspace(-2, 2, 200))
    )
    asked["gamma"] = bound * rng.uniform(0.2, 0.97)
    _extras(rng, asked)
    spread = 0.1 if rng.random() < 0.5 else 0.0
    if spread:
        plant = _around(rng, parts, spread, False)
    return plant, asked, False, "gamma below the unreached response"


def _force(rng, largest, marginal):
    """u_max too small for a mode: (a + sigma)|v x0| <= |v B| u_max, with v a left
    eigenvector, of real part a; the copy with exp(sigma t) stays in the ellipsoid, too.
    """
    base = _based(rng, largest)
    if base is None:
        return None
    parts, asked, plant = base
    (d,) = descriptors(plant, asked.get("U"), asked.get("K_A"))
    A, B, _ = d.state_space()
    sigma = _log(rng, -1, 0.5) if rng.random() < 0.6 else 0.0
    x0 = rng.standard_normal(len(A))
    found, left = np.linalg.eig(A.T)
    need = 0.0
    for s, v in zip(found, left.T):
        push = np.linalg.norm(v @ B)
        if s.real + sigma > 1e-3 and push > 1e-6 * np.linalg.norm(B):
            need = max(need, (s.real + sigma) * abs(v @ x0) / push)
    if need == 0:
        return None
    asked["saturation"] = sos.Saturation(need * rng.uniform(0.2, 0.97), x0)
    if sigma:
        asked["region"] = sos.PoleRegion(sigma)
    else:
        _extras(rng, asked)
    if rng.random() < 0.5 and "K_A" not in asked:
        plant = _around(rng, parts, 0.1, rng.random() < 0.3)
    return plant, asked, False, "u_max below the force a mode needs"


def _static(rng, largest, marginal):
    """gamma against rho: |det(S - B K_P)| is det(M) times all poles, < det(M) rho^2n;
    with F = I the static response exceeds (det(M) rho^2n)^(-1/n).
    """
    base = _base(rng, largest)
    if base is None:
        return None
    parts, asked = base
    n = len(parts[0])
    if "K_A" in asked:
        return None
    parts[4] = np.eye(n)
    rho = _log(rng, 0, 2)
    least = 1 / (np.linalg.det(parts[0]) ** (1 / n) * rho**2)
    asked["gamma"] = least * rng.uniform(0.2, 0.97)
    asked["region"] = sos.PoleRegion(rho=rho)
    plant = sos.SecondOrderSystem(*parts)
    if rng.random() < 0.5:
        plant = _around(rng, parts, 0.05, rng.random() < 0.3)
    return plant, asked, False, "gamma below what the disk allows"


def _signs(rng, largest, marginal):
    """B at one vertex, -B at the other: between them it is exactly zero, unrounded."""
    base = _base(rng, largest)
    if base is None:
        return None
    parts, asked = base
    if "K_A" in asked:
        return None
    M, D, S, B, F = parts
    A = np.block(
        [
            [np.zeros_like(M), np.eye(len(M))],
            [-np.linalg.solve(M, S), -np.linalg.solve(M, D)],
        ]
    )
    slowest = -eigvals(A).real.max()
    asked["region"] = sos.PoleRegion(
        sigma=max(slowest, 0) * (1 + rng.uniform(0.05, 1)) + 0.05
    )
    plant = sos.Polytope(
        [sos.SecondOrderSystem(*parts), sos.SecondOrderSystem(M, D, S, -B, F)]
    )
    return plant, asked, False, "an input of either sign"


# ---- an edge that Clarabel finds
def float_blocks(request, frame, levels=()):
    """The blocks of a request, with explicit slopes."""
    expressions, unknowns = request.in_unknowns(frame, levels=levels)
    blocks = Blocks(expressions.values(), unknowns)
    return clarabel.Explicit(
        [c.astype(float) for c in blocks.constants],
        [s.astype(float) for s in blocks.slopes],
    )


def scaled(blocks):
    """The blocks after a diagonal congruence to entries near one."""
    constants, slopes = [], []
    for c, s in zip(blocks.constants, blocks.slopes):
        size = np.abs(np.diag(c)) + np.linalg.norm(
            np.diagonal(s, axis1=1, axis2=2), axis=0
        )
        d = 2.0 ** np.round(-np.log2(np.where(size == 0, 1, size)) / 2)
        constants.append(c * np.outer(d, d))
        slopes.append(s * np.outer(d, d))
    return clarabel.Explicit(constants, slopes)


def _edge(rng, largest, marginal):
    """gamma or u_max above or below the optimum of a small request."""
    found = _known(rng, min(largest, 3))
    if found is None:
        return None
    known, asked, _ = found
    which = [k for k in ("gamma", "saturation") if k in asked]
    region = asked.get("region")
    if not which or region is None or region.rho is None:
        return None
    which = which[int(rng.integers(len(which)))]
    edge = _Edge(known, asked, which)
    if edge.value is None:
        return None
    inside = marginal and rng.random() < 0.5
    far = _log(rng, -6, -3) if marginal else rng.uniform(0.02, 0.6)
    factor = 1 + far if inside else 1 / (1 + far)
    witness = edge.witness(factor) if inside else ()
    if witness is None or edge.doubt > far / 3:
        return None
    reason = f"{which} {far:.1g} from Clarabel's edge"
    asked = edge.at(factor)
    if not inside:  # the edge is that of one P for all pairs: a slack may pass it
        asked["coupling"] = "pairs"
    return known.plant, asked, inside, reason, *witness


class _Edge:
    """Clarabel's smallest ``which`` ("gamma" or "saturation") in a gain's frame."""

    def __init__(self, known, asked, which):
        self.known, self.asked, self.which = known, asked, which
        self.request = Request(known.plant, **asked)
        self.unit = self._bound() ** 2
        frame = known.frame(self.request)
        x = self._optimum(frame)
        other = self._optimum(Frame.of(self.request))
        self.value = self.doubt = None
        if x is None or other is None:
            return
        self.frame, self.x = frame, x
        self.value = np.sqrt(x[-1] * self.unit)
        self.doubt = abs(other[-1] / x[-1] - 1)

    def _bound(self):
        if self.which == "gamma":
            return self.request.gamma
        return self.request.saturation.u_max

    def at(self, factor):
        """The requirements with the bound so many times the edge."""
        bound = self.value * factor
        if self.which == "gamma":
            return self.asked | {"gamma": bound}
        x0 = self.asked["saturation"].x0
        return self.asked | {"saturation": sos.Saturation(bound, x0)}

    def _blocks(self, frame):
        """With bound^2 / unit as the last variable."""
        one, two = (self._fixed(frame, k * self.unit) for k in (1, 2))
        slope = [b - a for a, b in zip(one.constants, two.constants)]
        return scaled(
            clarabel.Explicit(
                [a - s for a, s in zip(one.constants, slope)],
                [np.concatenate([s, d[None]]) for s, d in zip(one.slopes, slope)],
            )
        )

    def _fixed(self, frame, bound2):
        request = self.request
        if self.which == "gamma":
            return float_blocks(request, frame, {"gamma": bound2})
        return float_blocks(
            replace(
                request,
                saturation=sos.Saturation(np.sqrt(bound2), request.saturation.x0),
            ),
            frame,
        )

    def _optimum(self, frame):
        blocks = self._blocks(frame)
        cost = np.zeros(blocks.variables)
        cost[-1] = 1.0
        x, status = clarabel.minimize(blocks, cost)
        good = status == "Solved" and 1e-6 < x[-1] < 1
        return x if good else None

    def witness(self, factor):
        """K and P between Clarabel's and the known ones, or None."""
        N, m = self.request.order, self.known.plant.m
        P, Y = Unknown("P", N, symmetric=True), Unknown("Y", m, N)
        if len(self.x) != P.size + Y.size + 1:
            return None  # a requirement has a P of its own size
        frame, edge = self.frame, self.x[-1]
        share = (factor**2 - 1) * edge / (1 - edge)
        if share >= 1:
            return self.known.K, self.known.P
        there = np.concatenate(
            [P.pack(np.eye(N)), Y.pack(self.known.K @ frame.T / frame.scale), [1.0]]
        )
        x = self.x + share * (there - self.x)
        if min(margin(g) for g in self._blocks(frame)(x)) <= 0:
            return None
        P, Y = P.unpack(x[: P.size]), Y.unpack(x[P.size : -1])
        K = np.linalg.solve(P, Y.T).T @ np.linalg.inv(frame.T) * frame.scale
        return K, frame.T @ P @ frame.T.T
