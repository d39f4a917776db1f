// What a loop really does, whatever its LMIs promise: its H-infinity norm and the
// largest input from an initial state.
import {descriptors} from "./descriptor.js";
import {combined, dot, identity, inner, matrix, norm, place, rowsOf, solve, times, transposed, zeros} from "./matrices.js";
import {eigenvalues, exponential, lyapunov} from "./spectrum.js";

// The gain of C inv(sI - A) B + through I at s = jw, a function of w: by real matrices of twice the size.
export function gainsOf(A, B, C, through = 0) {
  const n = A.rows, left = zeros(2 * n, 2 * n), right = place(zeros(2 * n, B.cols), 0, 0, B);
  place(place(left, 0, 0, A, -1), n, n, A, -1);
  return w => {
    for (let i = 0; i < n; i++) {
      left.at[i * 2 * n + n + i] = -w;
      left.at[(n + i) * 2 * n + i] = w;
    }
    const X = solve(left, right), k = n * B.cols;
    if (!X) return Infinity;
    const [re, im] = [0, k].map(from => times(C, {rows: n, cols: B.cols, at: X.at.subarray(from, from + k)}));
    if (through) place(re, 0, 0, identity(re.rows, through));
    const both = place(place(zeros(2 * re.rows, 2 * re.cols), 0, 0, re), re.rows, re.cols, re);
    return norm(place(place(both, 0, re.cols, im, -1), re.rows, 0, im));
  };
}

// The norm of C inv(sI - A) B. A level is too low where the Hamiltonian matrix has
// imaginary eigenvalues; between them it is raised (Bruinsma and Steinbuch 1990).
function hinfNorm(A, B, C) {
  const n = A.rows, at = gainsOf(A, B, C);
  let level =
    Math.max(at(0), ...eigenvalues(A).filter(([, im]) => im >= 0).map(([re, im]) => at(Math.hypot(re, im))));
  const push = times(B, transposed(B)), out = times(transposed(C), C);
  for (let count = 0; count < 20; count++) {
    const test = level * (1 + 1e-5), H = zeros(2 * n, 2 * n);
    place(place(H, 0, 0, A), 0, n, push, 1 / test ** 2);
    place(place(H, n, 0, out, -1), n, n, transposed(A), -1);
    const values = eigenvalues(H), size = Math.max(...values.map(s => Math.hypot(...s)));
    const crossings =
      values.filter(([re, im]) => im > 0 && Math.abs(re) < 1e-8 * size + 1e-6 * im).map(([, im]) => im);
    crossings.sort((a, b) => a - b);
    const between = crossings.slice(1).map((w, k) => Math.sqrt(w * crossings[k]));
    const higher = Math.max(level, ...between.map(at));
    if (higher <= test) return higher;
    level = higher;
  }
  return level;
}

// The largest |K x| from x0, in two passes: one for the fast poles, one for the slow.
function peakInput(A, K, x0, spectrum) {
  const rates = spectrum.map(([re]) => -re);
  let most = 0;
  for (const horizon of [8 / Math.max(...spectrum.map(s => Math.hypot(...s))), 8 / Math.min(...rates)]) {
    const forward = rowsOf(exponential(A, horizon / 600)), gain = rowsOf(K);
    for (let k = 0, x = x0; k <= 600; k++, x = forward.map(row => dot(row, x))) {
      const u = gain.map(row => dot(row, x));
      most = Math.max(most, Math.sqrt(dot(u, u)));
    }
  }
  return most;
}

// The mean of x'Qx + u'Ru under white noise, (2.30) and (2.31).
function quadraticCost(d, A, gain, {Q, R, noise}) {
  const effort = times(transposed(gain), times(matrix(R), gain));
  const X = lyapunov(A, combined(1, matrix(Q), 1, effort));
  const push = noise === "F" ? solve(d.E, d.Bw) : identity(A.rows);
  return inner(push, times(X, push));
}

// {norm, peak, cost} of the worst vertex under a design's gain.
export function truth(request, {K, poles}) {
  let worst = null, peak = null, cost = null;
  descriptors(request).forEach((d, k) => {
    const gain = matrix(K), A = solve(d.E, combined(1, d.A, 1, times(d.Bu, gain)));
    if (d.Bw.cols) worst = Math.max(worst, hinfNorm(A, solve(d.E, d.Bw), d.C));
    if (request.asked.x0) peak = Math.max(peak, peakInput(A, gain, request.asked.x0, poles[k]));
    if (request.asked.Q) cost = Math.max(cost, quadraticCost(d, A, gain, request.asked));
  });
  return {norm: worst, peak, cost};
}
