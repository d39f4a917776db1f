// Gains of a law: descents from a few starts, as the package's `synthesis.structured` has them.
import {descend} from "./descent.js";
import {descriptors, meanDescriptor, rounded, stateSpace} from "./descriptor.js";
import {poles} from "./design.js";
import {cellOf, judgedGains, mixtures, readings, wholeOf} from "./law.js";
import {combined, FLOATS, identity, inverse, mapped, matrix, rowsOf, scaled, solve, times, transposed, zeros} from "./matrices.js";
import {eigenvalues, lyapunov, riccati} from "./spectrum.js";
import {truth} from "./truth.js";

const DESCENT = 120, SHORT = 40;   // steps of a descent, of poles and of other bounds
const ROOM_LEFT = 0.02;            // of the rate: with so much room a descent ends
const LIMIT = 100, BEYOND = 30;    // units of a gain, and what a part beyond that costs
const PROJECTED = 6, SPREAD = 3;   // starts that are projected; how far their rates reach
const SHIFT = 1e-3, RIDGE = 1e-9;  // of the rate, that needn't be stabilised; of a covariance
const PENALTY = 20;                // of a violation, where one of the bounds shall be as good as can be
const DIFFERENCE = 1e-5;           // of a gain's unit
const FIGURES = 6;
const GRID = 9;  // plants a side of the box, that are looked at between
/** @type {any} */
const NOWHERE = {
  value: -Infinity
};
const BOUNDED = {
  gamma: "norm",
  cost: "cost",
  u_max: "peak"
};

const mean = list => list.reduce((a, b) => a + b, 0) / list.length;

// What a bound says of a pole s = [re, im], over the rate: how far it is off, or its size where that shall
// fall (`bound` is zero then), and the slope of that.
const LEVELS = {
  sigma: (bound, rate, [re]) => [(re + bound) / rate, [1 / rate, 0]],
  theta: (bound, rate, [re, im]) => {
    const [sin, cos] = bound ? [2 * Math.sin(bound) / rate, 2 * Math.cos(bound) / rate] : [0, 0];
    const square = re * re + im * im || 1;
    return bound ? [re * sin + Math.abs(im) * cos, [sin, Math.sign(im) * cos]]
                 : [Math.atan2(Math.abs(im), -re), [Math.abs(im) / square, -re * Math.sign(im) / square]];
  },
  rho: (bound, rate, s) => {
    const size = Math.hypot(...s);
    return [(size - bound) / rate, s.map(x => x / (size || 1) / rate)];
  }
};

// The slope of a pole of A + B K C in the entries of K, weighed by those in its real and imaginary
// part: by both eigenvectors, in real matrices of twice the size.
function slopeOf(A, B, C, [re, im], [along, across]) {
  const N = A.rows, M = zeros(2 * N, 2 * N), {place} = FLOATS, off = 1e-9 * (Math.hypot(re, im) || 1);
  const shifted = mapped(A, (x, i, j) => i === j ? x - re - off : x);
  place(place(M, 0, 0, shifted), N, N, shifted);
  place(place(M, 0, N, identity(N, im + off)), N, 0, identity(N, -im - off));
  const X = inverse(M);
  if (!X) return null;
  const vector = Y => {  // normed, after some steps
    let v = mapped(zeros(2 * N, 1), (_, i) => Math.cos(i * i + 1));
    for (let count = 0; count < 3; count++) {
      v = times(Y, v);
      v = scaled(1 / Math.hypot(...v.at), v);
    }
    return [0, N].map(from => ({rows: N, cols: 1, at: v.at.slice(from, from + N)}));
  };
  const [v, w] = vector(X), [l, k] = vector(transposed(X));  // left: l - i k
  const row = Y => times(transposed(Y), B), product = (Y, Z) => times(transposed(Y), Z).at[0];
  const u = [row(l), scaled(-1, row(k))], y = [times(C, v), times(C, w)];
  const size = [product(l, v) + product(k, w), product(l, w) - product(k, v)];
  const length = size[0] ** 2 + size[1] ** 2, turn = [along, -across];
  // (along - i across) / (l - i k)' (v + i w)
  const g =
    [(turn[0] * size[0] + turn[1] * size[1]) / length, (turn[1] * size[0] - turn[0] * size[1]) / length];
  return mapped(zeros(B.cols, C.rows), (_, i, j) => {
    const [ur, ui] = u.map(X => X.at[i]), [yr, yi] = y.map(X => X.at[j]);
    return g[0] * (ur * yr - ui * yi) - g[1] * (ur * yi + ui * yr);
  });
}

// A search's task: its plants, units and limits of the gains, and the function that shall fall. Beside
// the corners stand `points` between them.
function taskOf(given) {
  const bare = given.asked.gamma === undefined && given.asked.noise !== "F";  // then w is of no use
  const request = bare ? {...given, vertices: given.vertices.map(({F: _, ...v}) => v)} : given;
  const {asked, law, goal = null, points = []} = request, C = readings(law, request.vertices[0].M.length);
  const all = [...descriptors(request), ...mixtures(request, points, FLOATS)];
  const plants = all.map(d => stateSpace(d)), [A, B] = stateSpace(meanDescriptor(all));
  const own = eigenvalues(A), sizes = own.map(s => Math.hypot(...s)).filter(x => x > 0);
  const some = sizes.filter(x => x > 1e-6 * Math.max(...sizes));
  const [slow, fast] = some.length ? [Math.min(...some), Math.max(...some)] : [1, 1];
  const rate = asked.rho !== undefined ? asked.rho / 2
    : asked.sigma > 0                  ? 4 * asked.sigma
                                       : Math.sqrt(slow * fast);
  const beside = s => {
    while (own.some(([re, im]) => Math.hypot(re - s, im) < s / 4)) s *= 1.5;
    return s;
  };
  // Units of inputs and of what is measured, in which the answers at a real rate are about one.
  const scales = s => {
    const G = times(C, solve(mapped(A, (x, i, j) => (i === j ? beside(s) : 0) - x), B));
    const most = Math.max(...G.at.map(Math.abs)),
          log = rowsOf(G).map(row => row.map(x => Math.log(Math.max(Math.abs(x), 1e-9 * most))));
    let u = log[0].map(() => 0), y = [];
    for (let count = 0; count < 20; count++) {
      y = log.map(row => mean(row.map((x, i) => x + u[i])));
      u = u.map((_, i) => mean(log.map((row, j) => y[j] - row[i])));
    }
    return {of_u: u.map(Math.exp), of_y: y.map(Math.exp)};
  };
  const unit = s => {
    const {of_u, of_y} = scales(s);
    return mapped(zeros(B.cols, C.rows), (_, i, j) => of_u[i] / of_y[j]);
  };
  const bounds = [slow, rate, fast].map(unit);
  const limits = mapped(bounds[0], (_, i, j) => LIMIT * Math.max(...bounds.map(X => X.at[i * C.rows + j])));
  const ruled = Object.keys(LEVELS).filter(key => key !== goal && asked[key] !== undefined);
  const inner = Object.entries(BOUNDED).filter(([key]) => asked[key] !== undefined);

  const more = (old, [value, turn], s, i) => value > old.value ? {value, turn, s, i} : old;
  // {value, slope, all} of the poles alone, under K
  function ofPoles(K) {
    let worst = NOWHERE, far = NOWHERE;
    const loops = plants.map(([F, B]) => combined(1, F, 1, times(B, times(K, C))));
    const all = loops.map(eigenvalues);
    if (!all.flat(2).every(isFinite)) return {value: Infinity};
    all.forEach((list, i) => list.forEach(s => {
      if (s[1] < 0) return;
      for (const key of ruled) worst = more(worst, LEVELS[key](asked[key], rate, s), s, i);
      if (goal) far = more(far, LEVELS[goal](0, rate, s), s, i);
    }));
    const slope = ({i, s, turn}) => slopeOf(loops[i], plants[i][1], C, s, turn);
    if (!goal) return {value: worst.value, slope: () => slope(worst), all, off: worst.value};
    const over = Math.max(0, worst.value + SHIFT) * PENALTY;
    return {
      value: far.value + over,
      slope: () => {
        const one = slope(far), two = over && one && slope(worst);
        return over ? two && combined(1, one, PENALTY, two) : one;
      },
      all,
      off: worst.value
    };
  }
  // the same with all that is bounded beside them
  function ofAll(K) {
    const first = ofPoles(K);
    if (goal || !inner.length || !(first.value < 0)) return first;
    const at = K => {
      const {all} = ofPoles(K), Kx = rowsOf(times(K, C));
      const found = truth(request, {K: Kx, poles: all});
      return Math.max(...inner.map(([key, name]) => Math.log(found[name] / asked[key])));
    };
    const value = at(K);
    if (!(value > first.value)) return first;
    const step = unit(rate);
    return {
      value,
      slope: () => mapped(K,
        (_, i, j) => {
          const h = DIFFERENCE * step.at[i * K.cols + j];
          return (at(mapped(K, (x, k, l) => k === i && l === j ? x + h : x)) - value) / h;
        }),
      all: first.all
    };
  }
  return {rate, rates: [slow, fast], C, A, B, unit, beside, scales, limits, ofPoles, ofAll, inner};
}

// The gains nearest to a feedback of the whole state of the mean plant, LQR for signals as large as
// they are at the rate; null without one.
function projected({A, B, C, beside, scales}, speed) {
  const s = beside(speed), N = A.rows, {of_u, of_y} = scales(speed),
        push = mapped(B, (x, _, j) => x * of_u[j]);
  const answer = rowsOf(solve(mapped(A, (x, i, j) => (i === j ? s : 0) - x), push));
  const of_x = answer.map(row => Math.hypot(...row) || 1);
  const a = mapped(A, (x, i, j) => x * of_x[j] / of_x[i] / s), b = mapped(push, (x, i) => x / of_x[i] / s);
  const c = mapped(C, (x, i, j) => x * of_x[j] / of_y[i]);
  const weight = combined(1, times(transposed(c), c), 1, identity(N, RIDGE));
  const slower = mapped(a, (x, i, j) => i === j ? x - SHIFT : x), X = riccati(slower, b, weight);
  if (!X) return null;
  const K = scaled(-1, times(transposed(b), X)), loop = combined(1, slower, 1, times(b, K));
  const P = lyapunov(transposed(loop), times(b, transposed(b)));
  if (!P) return null;
  const seen = times(times(c, P), transposed(c)), most = Math.max(...seen.at);
  const back = solve(mapped(seen, (x, i, j) => i === j ? x * (1 + RIDGE) + 1e-12 * most : x),
    times(times(c, P), transposed(K)));
  return back && mapped(transposed(back), (x, i, j) => x * of_u[i] / of_y[j]);
}

// A descent from the start of this number, or from the gains that are `near`: {K, value}, K of the rows
// of `readings`; below zero all that is asked is kept, but where a decay is sought.
export function descent(request, start, near = null) {
  const own = taskOf(request), {rate, rates: [slow, fast], unit, limits} = own;
  const ends = [Math.min(slow, rate), SPREAD * Math.max(fast, rate)];
  const speeds = [rate, ...[1, 2, 3, 4, 5].map(k => ends[0] * (ends[1] / ends[0]) ** (k / 6))];
  const speed = speeds[start % PROJECTED], size = unit(near ? rate : speed);
  let seed = start + 1;
  const uniform = () => (seed = seed * 16807 % 2147483647) / 2147483647;
  for (let k = 0; k < 9; k++) uniform();
  let K = near ? matrix(near) : start < PROJECTED ? projected(own, speed) : null;
  if (!K || !K.at.every(isFinite)) {
    const far = 10 ** (3 * uniform() - 2.5);
    K = mapped(size, x => x * far * 2 * (uniform() + uniform() + uniform() - 1.5));
  }
  const of = x => ({rows: size.rows, cols: size.cols, at: Float64Array.from(x, (y, k) => y * size.at[k])});
  const f = rule => x => {
    const over = x.map((y, k) => Math.max(0, Math.abs(y * size.at[k]) / limits.at[k] - 1));
    const {value, slope} = rule(of(x));
    return [
      value + BEYOND * over.reduce((a, b) => a + b, 0),
      () => {
        const S = slope();
        return x.map((y, k) => (S?.at[k] ?? 0) * size.at[k] +
            (over[k] ? BEYOND * Math.sign(y) * size.at[k] / limits.at[k] : 0));
      }
    ];
  };
  const enough = request.goal ? -Infinity : own.inner.length ? -ROOM_LEFT / 5 : -ROOM_LEFT;
  const first = Array.from(K.at, (x, k) => Math.max(-limits.at[k], Math.min(limits.at[k], x)) / size.at[k]);
  let {end, value} = descend(f(own.ofPoles), first, DESCENT, enough);
  if (own.inner.length && value < 0) ({end, value} = descend(f(own.ofAll), end, SHORT, -ROOM_LEFT));
  const found = mapped(of(end), (x, i, j) => {
    const most = limits.at[i * size.cols + j];
    return rounded(Math.max(-most, Math.min(most, x)), FIGURES);
  });
  const {value: now, off, all = [[]]} = own.ofAll(found),
                                reached = key => Math.max(...all.flat().map(s => LEVELS[key](0, 1, s)[0]));
  return {
    K: rowsOf(found),
    value: now,
    off,
    reached: {sigma: -reached("sigma"), theta: reached("theta"), rho: reached("rho")}
  };
}

// A point of the box between its corners where the poles under these gains are further off than at those, and
// not where they shall be; null without one.
export function between({K, ...request}) {
  const {rate, C} = taskOf(request), gain = times(matrix(K), C), {asked} = request;
  const grid = (wholeOf(request)?.[0] ??
    []).reduce(list => list.flatMap(t => Array.from({length: GRID}, (_, k) => [...t, k / (GRID - 1)])), [[]]);
  let worst = 0, found = null;
  for (const point of grid) {
    const [d] = mixtures(request, wholeOf(request) && [point], FLOATS);
    for (const s of poles(d, gain))
      for (const key of Object.keys(LEVELS)) {
        const value = asked[key] === undefined ? -1 : LEVELS[key](asked[key], rate, s)[0];
        if (value > worst) [worst, found] = [value, point];
      }
  }
  return found;
}

// What a worker does for a law, by the name of a job.
export const OF_LAW = {
  descent: ({start, near, ...request}) => descent(request, start, near),
  between: request => ({point: between(request)}),
  cell: cellOf,
  judged: judgedGains
};
