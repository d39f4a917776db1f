// A decay that every loop of a box keeps, proven cell by cell in decimals, without a rounding
// error. The loops are E x' = A x with inv(E) A a mean of those at a cell's corners, where they
// are affine in the second parameter, and E in the first by a matrix of rank one. So the corners
// speak for a cell: with one Q > 0 and
//   A Q E' + E Q A' + 2 sigma E Q E' < 0
// there, inv(E) A Q + Q A' inv(E') + 2 sigma Q < 0 in all of it. `loop(point, ring)` is [E, A].
import {rounded} from "../../kernel/descriptor.js";
import {definite, EXACT} from "../../kernel/exact.js";
import {cholesky, FLOATS, identity, mapped, matrix, rowsOf, transposed} from "../../kernel/matrices.js";
import {lyapunov} from "../../kernel/spectrum.js";

import {combine, eigenvalues, rightmost, solve} from "./linalg.js";

const SHARES = [0.5, 0.9];  // of the way from the claim to the truth: where Q is sought
const DIGITS = 10;          // of Q
const HALVINGS = 10;        // of units, which bring rows and columns to one size

/** @type {(cell: any) => any} */
export const middle = ([low, high]) => low.map((x, k) => Number(((x + high[k]) / 2).toPrecision(12)));
// Without those that repeat others, where a range has no length.
/** @type {(cell: any) => any} */
export const corners = ([[a, b], [c, d]]) =>
  (a < c ? [a, c] : [a]).flatMap(x => (b < d ? [b, d] : [b]).map(y => [x, y]));

// inv(E) A in floats.
/** @type {(loop: any, point: any) => any} */
export const quotient = (loop, point) => solve(...loop(point, FLOATS).map(rowsOf));

const decreasing = ([E, A], Q, sigma, ring) => {
  const X = ring.times(Q, ring.transposed(E));
  const half = ring.combined(-1, ring.times(A, X), -sigma, ring.times(E, X));
  return ring.combined(1, half, 1, ring.transposed(half));
};

// Whether one Q proves the decay in a cell: that of the loop in its middle, of less decay.
function kept(loop, cell, sigma) {
  const ends = corners(cell), free = quotient(loop, middle(cell)), N = free.length;
  const room = -rightmost(eigenvalues(free)) - sigma, unit = units(free);
  if (!(room > 0)) return false;
  return SHARES.some(share => {
    const scaled =
      mapped(matrix(free), (x, i, j) => x * unit[j] / unit[i] + (i === j ? sigma + share * room : 0));
    const found = lyapunov(transposed(scaled), identity(N));
    if (!found) return false;
    const Q = mapped(found, (x, i, j) => rounded(x * unit[i] * unit[j], DIGITS)),
          exact = EXACT.matrix(rowsOf(Q));
    return ends.every(point => cholesky(decreasing(loop(point, FLOATS), Q, sigma, FLOATS))) &&
      definite(exact) && ends.every(point => definite(decreasing(loop(point, EXACT), exact, sigma, EXACT)));
  });
}

// Units of the states in which the rows of A are as long as its columns.
function units(A) {
  const unit = A.map(() => 1);
  for (let count = 0; count < HALVINGS; count++)
    A.forEach((_, i) => {
      const sum = f => A.reduce((all, _, j) => i === j ? all : all + Math.abs(f(j)), 0);
      const row = sum(j => A[i][j] * unit[j] / unit[i]), column = sum(j => A[j][i] * unit[i] / unit[j]);
      if (row && column) unit[i] *= Math.sqrt(row / column);
    });
  return unit;
}

// Two halves: the parameter is cut that moves a matrix most.
/** @type {(matrixAt: any, cell: any) => any} */
export function halves(matrixAt, [low, high]) {
  const here = middle([low, high]);
  const moved = [0, 1].map(k => {
    const [X, Y] = [low, high].map(end => matrixAt(here.map((x, j) => j === k ? end[j] : x)));
    return Math.hypot(...combine(1, X, -1, Y).flat());
  });
  const k = moved[0] > moved[1] ? 0 : 1, below = [...high], above = [...low];
  below[k] = above[k] = here[k];
  return [[low, below], [above, high]];
}

// The cells of a proof, or null where so many trials don't end it. Yields after each.
export function* covering(loop, box, sigma, most) {
  const done = [], todo = [box];
  for (let count = 0; todo.length; count++) {
    if (count === most) return null;
    const cell = todo.pop();
    if (kept(loop, cell, sigma)) done.push(cell);
    else todo.push(...halves(point => quotient(loop, point), cell));
    yield;
  }
  return done;
}
