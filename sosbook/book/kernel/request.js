// What is asked, and what the package's proof files say of it.
//
// asked: {sigma, theta, rho, gamma, mu, cost, Q, R, noise, u_max, x0}; what is
// missing isn't asked.
import {Blocks} from "./blocks.js";
import {sized} from "./descriptor.js";
import {decimal, decimals, sector, twiceAtLeast} from "./exact.js";
import {identity, matrix, place, zeros} from "./matrices.js";

// What a file says of the requirements: words and decimals, by field.
/** @returns {any[]} */
export function requirements({sigma, theta, rho, gamma, mu = null, cost, Q, R, noise, u_max, x0}) {
  const list = [];
  const region = (name, more, alpha, beta) =>
    list.push({kind: "region", name, form: name, ...more, alpha: decimals(alpha), beta: decimals(beta)});
  if (sigma !== undefined) region("half-plane", {sigma: decimal(sigma)}, [[twiceAtLeast(sigma)]], [[1]]);
  if (theta !== undefined) {
    const {sin, cos, degrees} = sector(theta);
    region(
      "sector", {theta: decimal(theta), apex: "0", degrees}, [[0, 0], [0, 0]], [[sin, cos], [-cos, sin]]);
  }
  if (rho !== undefined)
    region("disk", {rho: decimal(rho), centre: "0"}, [[-rho, 0], [0, -rho]], [[0, 1], [0, 0]]);
  if (gamma !== undefined)
    list.push({kind: "gamma", name: "gamma", gamma: decimal(gamma), mu: mu === null ? null : decimal(mu)});
  if (cost !== undefined)
    list.push({kind: "cost", name: "cost", Q: decimals(Q), R: decimals(R), noise, bound: decimal(cost)});
  if (u_max !== undefined)
    list.push(
      {kind: "input", name: "saturation", u_max: decimal(u_max), x0: decimals(x0), acceleration: false});
  return list;
}

// The unknown scalars: sizes.
export const scalarsOf = ({unknowns}) => unknowns.filter(({scalar}) => scalar);

// Which requirements have a P of their own: that of the leader over an unknown size.
export function followersOf(asked) {
  const names = sized(asked);
  const tied = asked.mu !== undefined && asked.mu !== null && names.length > 1;
  return tied ? [] : names.slice(1);
}

// What a refusal is subject to: " for mu = 1"; else empty.
export function conditionOf(asked, written = mu => String(+mu.toPrecision(6))) {
  return sized(asked).length > 1 && !followersOf(asked).length ? ` for mu = ${written(asked.mu)}` : "";
}

const OWNERS = {
  gamma: "gamma",
  cost: "cost",
  input: "u_max"
};
export const ownerOf = ({kind}) => OWNERS[kind];
export const sizeName = name => `size for ${name}`;

// Blocks that bound P, Y and the sizes where the set has no bound: [[r I - P, Y'], [Y, r I]].
export function joined(blocks, r) {
  const more = new Blocks(Object.fromEntries(blocks.unknowns.map(u => [u.name, u])));
  more.list = [...blocks.list];
  const [P, Y, ...others] = blocks.unknowns, N = P.rows, m = Y.rows, q = N + m;
  const part = (rows, cols, top, a = 1) =>
    place(zeros(rows, cols), top, 0, identity(Math.min(rows, cols)), a);
  const below_r = ({name, rows: n}, q) => [name, part(q, n, 0, -0.5), part(n, q, 0)];
  const own = others.filter(u => u.symmetric);
  const below = place(zeros(q, m), N, 0, identity(m));
  const input = ["Y", below, part(N, q, 0)];
  more.add("scale", identity(q, r), own.length ? [input] : [below_r(P, q), input]);
  for (const X of own.length ? [P, ...own] : []) more.add("scale", identity(X.rows, r), [below_r(X, X.rows)]);
  for (const {name} of scalarsOf(blocks)) {
    more.add("scale", identity(2, r), [], [[name, matrix([[0, 1], [1, 0]])]]);
  }
  return more;
}
