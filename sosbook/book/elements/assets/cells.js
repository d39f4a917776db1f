// A decay that every loop of a box keeps, proven cell by cell in decimals, without a rounding
// error. The loops are E x' = A x. Each of two parameters moves E by a matrix of rank one, or A
// alone; so inv(E) A is a mean of those at a cell's corners. These speak for the cell: with a Q > 0
//   A Q E' + E Q A' + 2 sigma E Q E' < 0
// there, inv(E) A Q + Q A' inv(E') + 2 sigma Q < 0 in all of it. `loop(point, ring)` is [E, A].
import {rounded} from "../../kernel/descriptor.js";
import {definite, EXACT} from "../../kernel/exact.js";
import {corners, unitsOf} from "../../kernel/law.js";
import {cholesky, FLOATS, identity, mapped, matrix, rowsOf, transposed} from "../../kernel/matrices.js";
import {lyapunov} from "../../kernel/spectrum.js";

import {round} from "./kit.js";
import {combine, eigenvalues, rightmost, solve} from "./linalg.js";

const SHARES = [0.5, 0.9];  // of the way from the claim to the truth: where Q is sought
const DIGITS = 10;          // of Q

/** @type {(cell: any) => any} */
export const middle = ([low, high]) => low.map((x, k) => Number(((x + high[k]) / 2).toPrecision(12)));

// The matrix X + p P + q Q + p q R of four lists of rows.
/** @type {(parts: any, point: any, ring: any) => any} */
export function affine(parts, [p, q], {matrix, combined}) {
  const [X, P, Q, R] = parts.map(rows => matrix(rows));
  return combined(1, combined(1, X, p, P), q, combined(1, Q, p, R));
}

// inv(E) A in floats.
/** @type {(loop: any, point: any) => any} */
export const quotient = (loop, point) => solve(...loop(point, FLOATS).map(rowsOf));

// -(A Q E' + E Q A' + 2 sigma E Q E').
/** @type {(given: any, sigma: number, ring: any) => any} */
export const decreasing = ([E, A, Q], sigma, ring) => {
  const X = ring.times(Q, ring.transposed(E));
  const half = ring.combined(-1, ring.times(A, X), -sigma, ring.times(E, X));
  return ring.combined(1, half, 1, ring.transposed(half));
};

// Whether one Q proves the decay in a cell: that of the loop in its middle, of less decay.
function kept(loop, cell, sigma) {
  const points = corners(cell), free = quotient(loop, middle(cell)), N = free.length;
  const room = -rightmost(eigenvalues(free)) - sigma, unit = unitsOf(matrix(free));
  if (!(room > 0)) return false;
  return SHARES.some(share => {
    const scaled =
      mapped(matrix(free), (x, i, j) => x * unit[j] / unit[i] + (i === j ? sigma + share * room : 0));
    const found = lyapunov(transposed(scaled), identity(N));
    if (!found) return false;
    const Q = mapped(found, (x, i, j) => rounded(x * unit[i] * unit[j], DIGITS)),
          exact = EXACT.matrix(rowsOf(Q));
    return points.every(point => cholesky(decreasing([...loop(point, FLOATS), Q], sigma, FLOATS))) &&
      definite(exact) &&
      points.every(point => definite(decreasing([...loop(point, EXACT), exact], sigma, EXACT)));
  });
}

// Two halves: the parameter is cut that moves a matrix most.
/** @type {(matrixAt: any, cell: any) => any} */
function halves(matrixAt, [low, high]) {
  const here = middle([low, high]);
  const moved = [0, 1].map(k => {
    const [X, Y] = [low, high].map(end => matrixAt(here.map((x, j) => j === k ? end[j] : x)));
    return Math.hypot(...combine(1, X, -1, Y).flat());
  });
  const k = moved[0] > moved[1] ? 0 : 1, below = [...high], above = [...low];
  below[k] = above[k] = here[k];
  return [[low, below], [above, high]];
}

// {done, open}: cells that are proven, and those that so many trials left. Yields after each.
export function* covering(loop, box, sigma, most) {
  const done = [], open = [box];
  for (let count = 0; open.length && count < most; count++) {
    const cell = open.shift();
    if (kept(loop, cell, sigma)) done.push(cell);
    else open.push(...halves(point => quotient(loop, point), cell));
    yield;
  }
  return {done, open};
}

// A box on a plot with its cells; a range without a length is drawn as a bar.
export function drawn(plot, box, done, open, colour) {
  const [thin, flat] = [0, 1].map(k => box[0][k] < box[1][k] ? 0 : 6);
  const rect = ([low, high], style) => {
    const w = Math.max(thin, plot.X(high[0]) - plot.X(low[0])),
          h = Math.max(flat, plot.Y(low[1]) - plot.Y(high[1]));
    return `<rect x="${round((plot.X(low[0]) + plot.X(high[0]) - w) / 2)}" y="${
      round((plot.Y(low[1]) + plot.Y(high[1]) - h) /
        2)}" width="${round(w)}" height="${round(h)}" style="${style}"/>`;
  };
  const green = "fill:var(--sos-region);fill-opacity:.3;stroke:var(--sos-region);stroke-width:.5";
  return done.map(cell => rect(cell, green)).join("") +
    open.map(cell => rect(cell, "fill:none;stroke:var(--sos-soft);stroke-dasharray:3 3")).join("") +
    rect(box, `fill:none;stroke:var(${colour});stroke-width:1.6`);
}

// The handles of both its ends.
export const ends = (plot, points) =>
  points
    .map(
      ([x, y], k) => `<circle class="sos-handle" data-end="${k}" cx="${plot.X(x)}" cy="${plot.Y(y)}" r="8"/>`)
    .join("");
