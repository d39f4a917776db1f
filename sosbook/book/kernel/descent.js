// Local minima of functions that aren't smooth: BFGS with weak Wolfe steps (Lewis and
// Overton 2013).
import {dot} from "./matrices.js";

const TRIALS = 30;                          // of a line search
const [DECREASE, CURVATURE] = [1e-4, 0.9];  // of the weak Wolfe conditions
const FIRST = 0.1;                          // the first step's length

const ones = x => x.map((_, i) => x.map((_, j) => Number(i === j)));

// The points of a descent with the value at its end, which is `enough` or may fall no further. `f` has
// a value at a point, and a function that finds its slope there.
export function descend(f, start, steps, enough = -Infinity) {
  let x = start, [value, slope] = f(x), g = slope(), H = ones(x), first = true;
  const path = [x];
  for (let count = 0; count < steps && value > enough; count++) {
    let d = H.map(row => -dot(row, g));
    if (!(dot(d, g) < 0)) [H, d] = [ones(x), g.map(t => -t)];
    if (first) d = d.map(t => t * FIRST / (Math.hypot(...g) || 1));
    const found = wolfe(f, x, value, g, d);
    if (!found) {
      if (first) break;
      [H, first] = [ones(x), true];
      continue;
    }
    const s = found.x.map((t, k) => t - x[k]), y = found.g.map((t, k) => t - g[k]), sy = dot(s, y);
    if (sy > 1e-12 * Math.hypot(...s) * Math.hypot(...y)) {
      if (first) H = H.map(row => row.map(h => h * sy / dot(y, y)));
      first = false;
      const Hy = H.map(row => dot(row, y)), c = (1 + dot(y, Hy) / sy) / sy;
      H = H.map((row, i) => row.map((h, j) => h + c * s[i] * s[j] - (s[i] * Hy[j] + Hy[i] * s[j]) / sy));
    }
    const fallen = value - found.value;
    ({x, value, g} = found);
    path.push(x);
    if (fallen < 1e-7 && Math.hypot(...s) < 1e-6) break;
  }
  return {path, value, end: x};
}

function wolfe(f, x, value, g, d) {
  let low = 0, high = Infinity, t = 1, kept = null;
  const down = dot(g, d);
  for (let count = 0; count < TRIALS; count++) {
    const there = x.map((u, k) => u + t * d[k]), [v, slope] = f(there);
    if (!(v <= value + DECREASE * t * down)) high = t;
    else {
      kept = {x: there, value: v, g: slope()};
      if (dot(kept.g, d) >= CURVATURE * down) return kept;
      low = t;
    }
    t = high === Infinity ? 2 * low : (low + high) / 2;
  }
  return kept;
}
