// Gains that give a set of plants with one input a large decay: descents from a few starts. The
// same question has the same answer.
import {FLOATS, rowsOf} from "../../kernel/matrices.js";

import {descend} from "./descent.js";
import {clamp} from "./kit.js";
import {combine, eigenvalues, eye, mul, solve, spectralRadius, trace} from "./linalg.js";

const STEPS = 80;                                       // of a descent
const WALL = 300;                                       // of the way beyond a gain's limit, measured by it
const DIGITS = 6;                                       // of a gain
const NONE = 1e-9;                                      // of a sum: nothing
const STARTS = [[0.01, 0.03], [0.1, 0.3], [0.5, 0.6]];  // of the limits: of angles, and of their rates

const times = ([a, b], [c, d]) => [a * c - b * d, a * d + b * c];
const value = (q, s) => q.reduce((sum, x) => times(sum, s).map((y, k) => k ? y : y + x), [0, 0]);

// The polynomials c adj(s I - F) b of the rows c, the highest power first (Faddeev).
function numerators(F, b, rows) {
  let X = eye(F.length);
  const q = rows.map(() => []);
  F.forEach((_, k) => {
    mul(rows, mul(X, b)).forEach(([x], i) => q[i].push(x));
    const next = mul(F, X);
    X = combine(1, next, -trace(next) / (k + 1), eye(F.length));
  });
  return q;
}

// [F, b] of E x' = A x + b u: x' = F x + b u.
export const driven = (loop, push, point) => {
  const [E, A] = loop(point, FLOATS).map(rowsOf);
  return [solve(E, A), solve(E, push)];
};

// The largest real part of all poles under u = kappa y, and its slope: as the sum of
// kappa_i q_i(s) is taken from the characteristic polynomial p, a pole moves by q_i / p'.
function height(plants, rows, limits) {
  const loops = plants.map(([F, b]) => ({F, b, q: numerators(F, b, rows)}));
  return part => {
    const u = mul([part.map((x, k) => x * limits[k])], rows);
    const all = loops.map(({F, b, q}) => {
      const poles = eigenvalues(combine(1, F, 1, mul(b, u))), last = poles.length - 1;
      return {poles, q, last, right: poles[last][0]};
    });
    const {poles, q, last, right} = all.reduce((one, two) => two.right > one.right ? two : one);
    const over = part.map(x => Math.max(0, Math.abs(x) - 1));
    const slope = () => {
      const d =
        poles.slice(0, last).reduce((p, [re, im]) => times(p, [right - re, poles[last][1] - im]), [1, 0]);
      const size = d[0] ** 2 + d[1] ** 2 || 1e-300;
      return q.map((list, k) => {
        const [re, im] = value(list, poles[last]);
        return limits[k] * (re * d[0] + im * d[1]) / size + (over[k] ? WALL * Math.sign(part[k]) : 0);
      });
    };
    return [right + WALL * over.reduce((a, b) => a + b, 0), slope];
  };
}

// The gains of `rows`, each within its limit; `rate` says which rows are rates.
export function sought(plants, rows, limits, rate) {
  const f = height(plants, rows, limits);
  const ends = STARTS.map(([slow, fast]) => descend(f, rate.map(x => x ? -fast : -slow), STEPS));
  const best = ends.reduce((a, b) => b.value < a.value ? b : a);
  return best.end.map((x, k) => Number((clamp(x, -1, 1) * limits[k]).toPrecision(DIGITS)));
}

// Poles of x' = F x + b u that no controller moves which sees y of these rows alone.
export function hidden(F, b, rows) {
  const q = numerators(F, b, rows), poles = eigenvalues(F), size = spectralRadius(poles);
  const large = list => list.reduce((sum, x) => sum * size + Math.abs(x), 0);
  return poles.filter(s => q.every(list => Math.hypot(...value(list, s)) <= NONE * large(list)));
}
