// A drive with the sensors that are ticked: its law, its loop in floats or in decimals, and gains
// that give a set of plants with one input a large decay: descents from a few starts. The same
// question has the same answer.
import {descend} from "../../kernel/descent.js";
import {FLOATS, rowsOf} from "../../kernel/matrices.js";

import {affine} from "./cells.js";
import {clamp} from "./kit.js";
import {combine, eigenvalues, eye, mul, solve, spectralRadius, trace, zeros} from "./linalg.js";

const STEPS = 80;                                       // of a descent
const WALL = 300;                                       // of the way beyond a gain's limit, measured by it
const DIGITS = 6;                                       // of a gain
const NONE = 1e-9;                                      // of a sum: nothing
const STARTS = [[0.01, 0.03], [0.1, 0.3], [0.5, 0.6]];  // of the limits: of angles, and of their rates

/** @type {(place: any, kind: string) => number[]} */
export const ticked = (place, kind) => [0, 1].filter(i => place[`${kind}${i + 1}`]);
/** @type {(N: number, at: number) => number[]} */
export const unit = (N, at) => Array.from({length: N}, (_, j) => j === at ? 1 : 0);

// What is measured: for each gain its name and a row of y, on x = [z; z'; integral; lagging
// angles]; and x' = A x of what the law remembers.
export function law({rates: filters, parts}, place) {
  const angles = ticked(place, "p"), rates = ticked(place, "v"), lagging = rates.length ? [] : angles;
  const a = filters[place.filter], sum = angles.length ? place.integral : 0;
  const N = 4 + sum + lagging.length, memory = zeros(N, N);
  /** @type {any[]} */
  const measured = [
    ...angles.map(i => ["K_P", unit(N, i)]), ...rates.map(i => ["K_D", unit(N, 2 + i)]),
    ...lagging.map((i, k) => ["K_D", Object.assign(unit(N, -1), {[i]: a, [4 + sum + k]: -a})]),
    ...(sum ? [["K_I", unit(N, 4)]] : [])
  ];
  lagging.forEach((i, k) => Object.assign(memory[4 + sum + k], {[i]: a, [4 + sum + k]: -a}));
  if (sum) memory[4][angles[0]] = 1;
  const push = [...zeros(2, 1), ...parts.B, ...zeros(N - 4, 1)];
  return {N, memory, push, names: measured.map(([name]) => name), rows: measured.map(([, row]) => row)};
}

// [E, A] of its loop with u = gains y for a load and a shaft, in floats or in decimals.
export function loop({parts}, {N, memory, push, rows}, gains) {
  return (point, ring) => {
    const {identity, matrix, place, combined, times} = ring;
    const [M, S] = [parts.M, parts.S].map(X => affine(X, point, ring));
    const E = place(identity(N), 2, 2, combined(1, M, -1, identity(2)));
    const A = place(matrix(memory), 0, 2, identity(2));
    place(place(A, 2, 0, S, -1), 2, 2, matrix(parts.D), -1);
    return [
      E, gains.length ? combined(1, A, 1, times(matrix(push), times(matrix([gains]), matrix(rows)))) : A
    ];
  };
}

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
