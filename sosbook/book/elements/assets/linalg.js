// Matrices of the page elements are lists of rows; eigenvalues are pairs [real part,
// imaginary part]. Sums and products are a matter of rows; the rest the kernel computes.
import * as kernel from "../../kernel/matrices.js";
import * as spectrum from "../../kernel/spectrum.js";

const {matrix, rowsOf} = kernel;
const onRows = f => (...given) => rowsOf(f(...given.map(X => matrix(X))));

export function make(n, m, entry) {
  const A = [];
  for (let i = 0; i < n; i++) {
    A.push([]);
    for (let j = 0; j < m; j++) A[i].push(entry(i, j));
  }
  return A;
}
export const eye = n => make(n, n, (i, j) => i === j ? 1 : 0);
export const zeros = (n, m) => make(n, m, () => 0);
export const transpose = A => make(A[0].length, A.length, (i, j) => A[j][i]);
export const mul = (...factors) => factors.reduce((A, B) => {
  const columns = transpose(B);
  return A.map(row => columns.map(column => dot(row, column)));
});
export const dot = kernel.dot;
export const combine = (a, A, b, B) => A.map((row, i) => row.map((x, j) => a * x + b * B[i][j]));
export const add = (A, B) => combine(1, A, 1, B);
export const scale = (a, A) => A.map(row => row.map(x => a * x));
export const apply = (A, x) => A.map(row => dot(row, x));
export const block = rows => rows.flatMap(row => row[0].map((_, i) => row.flatMap(A => A[i])));
export const part = (A, [top, bottom], [left, right]) =>
  A.slice(top, bottom).map(row => row.slice(left, right));
// A of x' = A x for x = [z; z'] with M z'' + D z' + S z = 0.
export const motion = (M, D, S) => [...block([[zeros(M.length, M.length), eye(M.length)]]),
  ...solve(M, block([[scale(-1, S), scale(-1, D)]]))];
export const trace = A => A.reduce((sum, row, i) => sum + row[i], 0);

// A^-1 B; NaN where A is singular.
export const solve = onRows((A, B) => kernel.solve(A, B) ?? kernel.mapped(B, () => NaN));
export const exponential = onRows(X => spectrum.exponential(X, 1));
export const lyapunov = onRows(spectrum.lyapunov);
export const eigenvalues = A => spectrum.eigenvalues(matrix(A)).sort((a, b) => a[0] - b[0] || a[1] - b[1]);

// Of poles or eigenvalues: the largest real part and modulus, and whether they decay.
export const rightmost = poles => Math.max(...poles.map(([re]) => re));
export const spectralRadius = poles => Math.max(...poles.map(p => Math.hypot(...p)));
export const stable = poles => rightmost(poles) < 0;
export const leastEigenvalue = A => eigenvalues(A)[0][0];

// The stabilising solution of A^T X + X A - X B R^-1 B^T X + Q = 0.
export const riccati =
  onRows((A, B, Q, R) => spectrum.riccati(
           A, kernel.times(B, kernel.transposed(kernel.inverseLower(kernel.cholesky(R)))), Q));

// The gain K of u = K x with the least cost x^T Q x + u^T R u.
export const regulator = (A, B, Q, R) => scale(-1, solve(R, mul(transpose(B), riccati(A, B, Q, R))));

// [Phi, Gamma] of x(t + T) = Phi x + Gamma u for an input that is held.
export function held(A, B, T) {
  const n = A.length, m = B[0].length;
  const E = exponential(scale(T, block([[A, B], [zeros(m, n), zeros(m, m)]])));
  return [part(E, [0, n], [0, n]), part(E, [0, n], [n, n + m])];
}

// Samples of x' = A x + B u, exact for an input that is held from one to the next.
export function samples(A, B, x, inputs, T) {
  const [Phi, Gamma] = held(A, B, T), all = [x];
  let last = null, driven = [];
  for (const u of inputs) {
    if (u !== last) driven = apply(Gamma, last = u);
    const next = driven.slice();
    for (let i = 0; i < next.length; i++) next[i] += dot(Phi[i], x);
    all.push(x = next);
  }
  return all;
}

// The same from rest, with so many steps, for a push b that stays.
export const pushed = (A, b, horizon, steps) =>
  samples(A, b.map(x => [x]), b.map(() => 0), Array(steps).fill([1]), horizon / steps);
