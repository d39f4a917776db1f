"""Simulations of a log, and the parameters with which they come nearest to it."""

import numpy as np

from .doubts import STRUCTURED, refuse_model, roughness
from .fit import CORRELATED_SAMPLES, Fit, UnseenError, output_error, standing
from .moved import HeldInputs, matrices

#: Relative, either way, for derivatives. With a step of 1e-6 forwards, noise of 1e-13
#: in a simulation made an interval of a hardly seen parameter 1.7 times as wide.
STEP = 1e-3
UNSEEN = 0.5  # a standard deviation that is more of its value, or of the guess, is none
ROUNDS = 30
WEAK = 0.01  # relative: where a log knows less, fits begin at other places, too
STARTS = 4  # beside the guess, and by parts of the log
SAME = 1e-4  # of a residual's logarithm: two beginnings end in one place
SHARES = 4  # of a log, at least, are as wide as all windows of what is fitted; of one
HIDDEN = 2  # with motion before it, whose fit hides more of the noise's colour
VANISHED = 1e3  # times the guess, or its inverse
PARTS = 8, 4, 2  # of a log, from which a fit that failed begins again
FARTHEST = 2.0  # logarithm of a parameter over its guess, where a part ends


class Trial:
    """Simulations of a record, for logarithms of the parameters over their start.

    ``builder``, ``outputs`` and ``rest`` are as for `identify`, ``rubs`` its friction.
    """

    def __init__(self, builder, record, start, outputs, rubs, rest):
        self.builder, self.record, self.outputs = builder, record, outputs
        self.rubs, self.rest, self.names = rubs, rest, tuple(start)
        self.guess = np.array(list(start.values()), float)
        self.motion = HeldInputs(record.u, record.steps)
        A, _, C, _, _ = self.forms(self.guess)
        self.poles = np.linalg.eigvals(A)
        if len(C) != record.y.shape[1]:
            raise ValueError(
                f"the record has {record.y.shape[1]} outputs, and outputs={len(C)} "
                "rows: give outputs=sos.Output(...) with a row for each sensor"
            )

    def forms(self, values):
        """A, B, C, D of the plant with these values, and what friction pulls at."""
        values = dict(zip(self.names, map(float, values)))
        plant = self.builder(**{k: x for k, x in values.items() if k not in self.rubs})
        A, B, C, D = matrices(plant, self.outputs)
        if B.shape[1] != self.record.u.shape[1]:
            raise ValueError(
                f"the plant has {B.shape[1]} inputs, the record "
                f"{self.record.u.shape[1]}"
            )
        pull = np.zeros((len(A), len(self.rubs)))
        if self.rubs:
            n = plant.n
            rows = np.vstack(list(self.rubs.values()))
            pull[n:] = np.linalg.solve(plant.M, rows.T)
        return A, B, C, D, pull

    @np.errstate(all="ignore")  # what runs away is infinite, and isn't taken
    def left(self, logs):
        """Measured minus modelled, (P, N, q), for rows of logs, (P, p)."""
        y, u = self.record.y, self.record.u
        values = self.guess * np.exp(logs)
        A, B, C, D, pull = (np.array(x) for x in zip(*map(self.forms, values)))
        if self.rubs:
            rows = np.vstack(list(self.rubs.values()))
            rows = np.hstack([np.zeros_like(rows), rows])
            forces = values[:, [self.names.index(k) for k in self.rubs]]
            x = self.motion.rubbed(A, B, pull, rows, forces)
        else:
            x = self.motion.free_and_pushed(A, B, not self.rest)
        seen = C[:, None] @ x
        before = np.vstack([np.zeros_like(u[:1]), u[:-1]])  # y is read before u acts
        pushed = seen[..., 0] + (D[:, None] @ before[..., None])[..., 0]
        e = y - pushed
        if self.rest:
            kept = (e * self.keep).sum(axis=1, keepdims=True)
            return e - kept / self.keep.sum(axis=0)
        offsets = np.broadcast_to(np.eye(y.shape[1]), (*e.shape, y.shape[1]))
        basis = np.concatenate([offsets, seen[..., 1:]], axis=3)
        basis = basis / np.linalg.norm(basis, axis=(1, 2), keepdims=True).clip(1e-300)
        weights = self.keep * self.weights
        known = (basis * weights[..., None]).reshape(len(e), y.size, -1)
        flat = (e * weights).reshape(len(e), y.size, 1)
        shares = np.linalg.pinv(known, rcond=1e-9) @ flat
        return e - (basis @ shares[:, None])[..., 0]

    def modelled(self, *logs):
        """Modelled less measured, weighed, at logs; infinite where no plant is."""
        try:
            return -self.left(np.array([logs]))[0] * self.weights * self.keep
        except (ValueError, np.linalg.LinAlgError):
            return np.full_like(self.record.y, np.inf)

    def slopes(self, logs):
        """Derivatives of `modelled` by the logs, (N q, p)."""
        away = STEP * np.eye(len(logs))
        below, above = np.split(self.left(np.vstack([logs - away, logs + away])), 2)
        slopes = (below - above) * self.weights * self.keep / (2 * STEP)
        return slopes.reshape(len(logs), -1).T

    def fitted(self, keep):
        """The `Fit` to the samples to keep, (N, q)."""
        self.keep, still = keep, np.zeros(len(self.names))
        found = []
        for start in self._beginnings(still):
            found.append(self._scored(start))
            least, fit = min(found, key=lambda x: x[0])
            again = sum(score < least + SAME for score, _ in found) > 1
            sure = isinstance(fit, Fit) and self._rough(fit) < STRUCTURED
            if sure and (again or self._weakest(fit)[0] < WEAK):
                break  # else a least value nearby may not be the least
        if not isinstance(fit, Fit):
            raise fit
        self._refuse_unseen(fit)
        return fit

    def _beginnings(self, still):
        yield still
        yield self._from_parts(still)
        signs = np.random.default_rng(0).choice([-1, 1], (STARTS, len(still)))
        yield from signs * np.log(2)

    def _from_parts(self, logs):
        """A beginning, by more and more of the log."""
        whole, N = self.keep, len(self.keep)
        for share in PARTS:
            self.keep = whole * (np.arange(N) < N // share)[:, None]
            try:
                logs = self._nearest(logs).values
            except UnseenError as unseen:
                logs = unseen.values
            except ValueError:
                pass
            logs = logs.clip(-FARTHEST, FARTHEST)
        self.keep = whole
        return logs

    def _scored(self, logs):
        """How much a fit from these logarithms on leaves, and it, or its error."""
        try:
            fit = self._fitted(logs)
            return self._score(fit.residuals), fit
        except UnseenError as unseen:
            left = self._score(unseen.residuals / self.weights)
            text = f"{unseen}, or start is too far off"
            return left, UnseenError(text, unseen.values, unseen.residuals)
        except ValueError as failed:
            return np.inf, failed

    def _nearest(self, logs, window=1):
        start, rounds = dict(zip(self.names, logs)), 20 if self.rubs else ROUNDS
        goal = np.zeros(self.keep.shape)
        how = dict(rounds=rounds, slopes=self.slopes, window=window)
        return output_error(self.modelled, goal, start, **how)

    def _fitted(self, logs):
        """As `fitted`, from some logarithms on."""
        N, q = self.keep.shape
        self.weights = 1 / self.record.y.std(axis=0)
        # each fitted number takes about a window's width of what residuals say of noise
        count = len(logs) + q + (0 if self.rest else len(self.poles))
        shares = SHARES if self.rest else HIDDEN
        window = max(1, min(CORRELATED_SAMPLES, N // (shares * count)))
        for _ in range(3 if q > 1 else 1):
            try:
                fit = self._nearest(logs, window)
            except UnseenError as unseen:
                refuse_model(unseen.residuals / self.weights, self.record, self.keep)
                raise
            logs = fit.values
            left = self.left(logs[None])[0]
            rms = np.sqrt(np.mean(left**2, axis=0, where=self.keep > 0))
            self.weights = 1 / np.maximum(rms, 1e-9 / self.weights)
        refuse_model(left, self.record, self.keep)
        values = self.guess * np.exp(logs)
        spread = fit.covariance + self._of_rests(logs, left, window)
        spread = values[:, None] * spread * values
        spread = spread / (1 - count * window / N)
        return Fit(fit.names, values, spread, left)

    def _of_rests(self, logs, left, window):
        """The share of the covariance of the logs that readings at rest have."""
        slopes = self.slopes(logs)
        inverse = np.linalg.inv(slopes.T @ slopes)
        slopes = slopes.reshape(*self.keep.shape, -1)
        middle = np.zeros_like(inverse)
        for k, y in enumerate(self.record.y.T):
            runs, variance = standing(y, y - left[:, k], window)
            for run in runs:
                moves = slopes[run, k].sum(axis=0) * self.weights[k]
                middle += variance * np.outer(moves, moves)
        return inverse @ middle @ inverse

    def _score(self, residuals):
        kept = self.keep > 0
        return float(np.log(residuals.std(axis=0, where=kept).clip(1e-300)).sum())

    def _weakest(self, fit):
        """The largest relative deviation, and of which parameters."""
        scale = np.maximum(abs(fit.values), abs(self.guess))
        sizes, directions = np.linalg.eigh(fit.covariance / scale[:, None] / scale)
        share = abs(directions[:, -1])
        which = [n for n, x in zip(self.names, share) if x > 0.3 * share.max()]
        return sizes[-1] ** 0.5, which

    def _rough(self, fit):
        return max(map(roughness, self.record.y.T, fit.residuals.T))

    def _refuse_unseen(self, fit):
        """Raise where the log says nothing of a parameter, and name it."""
        times = self._rough(fit)
        far = (
            f". The fit leaves {times:.2g} times the noise: start may be far off, a "
            "load act, or the machine move when the log begins (rest=False)"
        )
        far = far if times > STRUCTURED else ""
        for name, x in zip(fit.names, fit.values / self.guess):
            if not 1 / VANISHED < x < VANISHED:
                raise ValueError(
                    f"the log doesn't tell {name} from "
                    f"{'zero' if x < 1 else 'infinity'}: excite the motion in which "
                    f"it counts, or build the plant so{far}"
                )
        size, which = self._weakest(fit)
        if size > UNSEEN:
            alone = f"the log doesn't tell {which[0]}"
            several = f"the log tells {' and '.join(which)} only together"
            raise ValueError(
                f"{several if which[1:] else alone}: one standard deviation is "
                f"{100 * size:.2g} %. Excite the motion in which {which[0]} counts: a "
                "longer sweep, to higher or lower frequencies, or a larger one; or fix "
                f"it in the builder{far}"
            )
