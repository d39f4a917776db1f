// A plant and what is asked of it as LMI blocks: the theorems of the thesis, laid out
// in products L X R. A column of blocks is one product.
//
// asked: {sigma, theta, rho, gamma, mu, cost, Q, R, noise, u_max, x0}; what is
// missing isn't asked.
import {Blocks} from "./blocks.js";
import {changed, sized} from "./descriptor.js";
import {weightFactors} from "./exact.js";
import {FLOATS, identity, matrix} from "./matrices.js";
import {writtenBlocks} from "./written.js";

// (2.18), (2.19), (2.20): regions alpha + beta s + beta' s* < 0, rounded inwards
// as the package's proofs want them.
function regions({sigma, theta, rho}) {
  const list = [];
  if (sigma !== undefined) list.push({name: "half-plane", alpha: [[2 * sigma]], beta: [[1]]});
  if (theta !== undefined) {
    const sin = Math.sin(theta) * (1 - 4 * Number.EPSILON);
    const cos = Math.cos(theta) * (1 + 4 * Number.EPSILON);
    list.push({name: "sector", alpha: [[0, 0], [0, 0]], beta: [[sin, cos], [-cos, sin]]});
  }
  if (rho !== undefined) list.push({name: "disk", alpha: [[-rho, 0], [0, -rho]], beta: [[0, 1], [0, 0]]});
  return list;
}

// The unknown scalars: sizes.
export const scalarsOf = ({unknowns}) => unknowns.filter(({scalar}) => scalar);

// The blocks of a request in a frame, affine in P, Y and the sizes s.
export function assembled(plain, pairs, asked, frame) {
  if (asked.text) return writtenBlocks(plain, asked, frame);
  const {unknowns, list} = laidOut(plain, pairs, asked, regions(asked), frame);
  const blocks = new Blocks(unknowns);
  for (const {name, constant, terms, slopes, multiplied} of list)
    blocks.add(name, constant, terms, slopes, multiplied);
  return blocks;
}

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

// In the words of a proof file.
export const KINDS = {
  gamma: ["gamma", "gamma"],
  cost: ["cost", "cost"],
  u_max: ["input", "saturation"]
};
// The kind and the name of a requirement whose blocks demand Re s < 0; undefined without one.
export const impliesStability = ({sigma, gamma, cost}) => sigma >= 0 ? ["region", "half-plane"]
  : gamma !== undefined                                              ? KINDS.gamma
  : cost !== undefined                                               ? KINDS.cost
                                                                     : undefined;
export const sizeName = name => `size for ${name}`;

// {unknowns, list}: each block has its name, its key in a proof file, its products
// [unknown, L, R], its constant, the slopes of scalars, and the symmetric matrix by which
// it is `multiplied` from both sides, so that its numbers are decimals where the
// theorem's have 1 / mu, 1 / scale or inv(R). In the ring EXACT nothing is rounded.
/** @returns {{unknowns: any, list: any[]}} */
export function laidOut(plain, pairs, asked, parts, frame, followers = followersOf(asked),
  /** @type {any} */ ring = FLOATS) {
  const {zeros, identity, scaled} = ring, vertices = plain.map(d => changed(d, frame, ring));
  const N = vertices[0].E.rows, m = vertices[0].Bu.cols, list = [];
  const channels = asked.noise === "F" ? vertices[0].Bw.cols : N;
  const unknowns = {P: {rows: N, cols: N, symmetric: true}, Y: {rows: m, cols: N}};
  for (const name of followers) unknowns[sizeName(name)] = {rows: 1, cols: 1};
  if (asked.cost !== undefined) unknowns.J = {rows: channels, cols: channels, symmetric: true};
  const itself = [["P", identity(N, 0.5), identity(N)]];
  list.push({name: "P", key: ["", "", "P"], terms: itself, constant: zeros(N, N), slopes: []});
  for (const name of followers) {
    const kind = KINDS[name], key = [...kind, sizeName([...new Set(kind)].join(" "))];
    list.push(
      {name: sizeName(name), key, terms: [], constant: zeros(1, 1), slopes: [[sizeName(name), identity(1)]]});
  }
  const add = (name, key, owner, {terms, constant, multiplied = null}) => {
    const s = followers.includes(owner) && sizeName(owner);
    const slopes =
      s && constant.at.some(x => x) ? [[s, scaled((frame.sizes[owner] || 1) ** -2, constant)]] : [];
    list.push(
      {name, key, terms, constant: s ? zeros(constant.rows, constant.rows) : constant, slopes, multiplied});
  };
  if (asked.cost !== undefined) {
    add("trace", [...KINDS.cost, "trace"], "cost", traceBound(asked, channels, frame, ring));
    const near = frame.near || identity(N);
    if (asked.noise !== "F")
      add("cost", [...KINDS.cost, "cost"], "cost", noiseShare([[near, near, 0.5]], frame.back, frame, ring));
  }
  const all = !impliesStability(asked) ? [{name: "stability", alpha: [[0]], beta: [[1]]}, ...parts] : parts;
  for (const [i, j] of pairs) {
    const place = plain.length > 1 ? ` ${i + 1}${i === j ? "" : `,${j + 1}`}` : "";
    const where = i === j ? [i] : [i, j];
    const a = vertices[i], b = vertices[j];
    const ends = i === j ? [[a, a, 1]] : [[a, b, 0.5], [b, a, 0.5]];
    if (asked.cost !== undefined) {
      add("lqr" + place, [...KINDS.cost, "lqr", ...where], "cost", costDecay(ends, asked, frame, ring));
      const inner = ends.map(([v, w, share]) => [v.E, w.E, share / 2]);
      const noise = ring.combined(0.5, a.Bw, 0.5, b.Bw);
      if (asked.noise === "F")
        add("cost" + place, [...KINDS.cost, "cost", ...where], "cost", noiseShare(inner, noise, frame, ring));
    }
    for (const part of all) {
      const key = part.name === "stability" ? Array(3).fill("stability") : ["region", part.name, ""];
      add(part.name + place, [...key, ...where], part.name, polePart(part, ends, N, ring));
    }
    if (asked.gamma !== undefined)
      add("hinf" + place, [...KINDS.gamma, "hinf", ...where], "gamma", boundedReal(ends, asked, ring));
  }
  if (asked.u_max !== undefined) {
    const [start, bound] = inputBound(asked, frame, N, m, ring);
    add("x0", [...KINDS.u_max, "x0"], "u_max", start);
    add("u_max", [...KINDS.u_max, "u_max"], "u_max", bound);
  }
  return {unknowns, list};
}

// X among zero rows, and among zero columns.
export const below = ({zeros, place}, rows, top, X, ...factors) =>
  place(zeros(rows, X.cols), top, 0, X, ...factors);
const beside = ({zeros, place}, cols, left, X) => place(zeros(X.rows, cols), 0, left, X);

// The identity of q rows, but for X on its diagonal.
const stretched = ({zeros, identity, place}, q, from, X) =>
  place(place(place(zeros(q, q), 0, 0, identity(from)), from, from, X), from + X.rows, from + X.rows,
    identity(q - from - X.rows));

// Theorem 2.2, (A.9): minus the matrix of alpha_kl EPE' + beta_kl Theta + beta_lk Theta',
// with Theta = (A_i P + B_i Y) E_j' and its mirror image for a pair of vertices.
function polePart({alpha, beta}, ends, N, ring) {
  const {zeros, place, transposed} = ring, k = alpha.length, terms = [];
  for (let column = 0; column < k; column++) {
    for (const [a, b, share] of ends) {
      const R = beside(ring, k * N, column * N, transposed(b.E)), P = zeros(k * N, N);
      const Y = zeros(k * N, a.Bu.cols);
      for (let row = 0; row < k; row++) {
        place(P, row * N, 0, a.E, -alpha[row][column], share / 2);
        place(P, row * N, 0, a.A, -beta[row][column], share);
        place(Y, row * N, 0, a.Bu, -beta[row][column], share);
      }
      terms.push(["P", P, R]);
      if (Y.at.some(x => x)) terms.push(["Y", Y, R]);
    }
  }
  return {terms, constant: zeros(k * N, k * N)};
}

// Theorem 2.1, (2.15): minus [[he Theta, E P C', Bw], [., -gamma^2 / mu, 0], [., 0, -mu]].
function boundedReal(ends, {gamma, mu}, ring) {
  const {zeros, identity, place, scaled, combined, transposed} = ring;
  const [a, b] = ends[0], N = a.E.rows, n = a.C.rows, p = a.Bw.cols, q = N + n + p, terms = [];
  for (const [v, w, share] of ends) {
    const R = beside(ring, q, 0, transposed(w.E));
    terms.push(["P", below(ring, q, 0, v.A, -share), R], ["Y", below(ring, q, 0, v.Bu, -share), R]);
  }
  const size = mu || 1, mean = combined(-0.5, a.E, -0.5, b.E);
  terms.push(["P", below(ring, q, 0, mean), beside(ring, q, N, scaled(size, transposed(a.C)))]);
  const constant = zeros(q, q), noise = combined(0.5, a.Bw, 0.5, b.Bw);
  place(place(constant, 0, N + n, noise, -1), N + n, 0, transposed(noise), -1);
  place(constant, N + n, N + n, identity(p), size);
  place(constant, N, N, identity(n), gamma, gamma, size);
  return {terms, constant, multiplied: stretched(ring, q, N, identity(n, size))};
}

// Lemma 2.2, (2.21): x(0) lies in the ellipsoid of P, and |K x| <= u_max on it.
function inputBound({u_max, x0}, {back, near, scale}, N, m, ring) {
  const {matrix, zeros, identity, place, transposed, times} = ring;
  const start = times(back, matrix(x0.map(x => [x])));
  const corner = place(zeros(N + 1, N + 1), 0, 0, identity(1)), turn = near || identity(N);
  place(place(corner, 1, 0, start), 0, 1, transposed(start));
  const inside = [["P", below(ring, N + 1, 1, turn, 0.5), beside(ring, N + 1, 1, transposed(turn))]];
  const terms = [
    ["P", below(ring, N + m, 0, identity(N, 0.5)), beside(ring, N + m, 0, identity(N))],
    ["Y", below(ring, N + m, N, identity(m), scale), beside(ring, N + m, 0, identity(N))]
  ];
  const constant = place(zeros(N + m, N + m), N, N, identity(m), u_max, u_max);
  const multiplied = stretched(ring, N + m, N, identity(m, scale));
  return [{terms: inside, constant: corner}, {terms, constant, multiplied}];
}

// Theorem 2.4, (2.34): the bound less the trace of J, which the frame measures in its own
// unit.
function traceBound({cost}, channels, {own}, ring) {
  const {zeros, identity, place} = ring, one = identity(1), terms = [];
  for (let k = 0; k < channels; k++) {
    terms.push(["J", place(zeros(1, channels), 0, k, one, -0.5, own), place(zeros(channels, 1), k, 0, one)]);
  }
  return {terms, constant: identity(1, cost)};
}

// (2.35): [[J, noise'], [noise, E P E']]; inner: [L, R, share] for the products L P R' of E P E'.
function noiseShare(inner, noise, {own}, ring) {
  const {zeros, identity, place, transposed} = ring, N = noise.rows, p = noise.cols, q = p + N;
  const terms = [
    ["J", below(ring, q, 0, identity(p, 0.5), own), beside(ring, q, 0, identity(p))],
    ...inner.map(([L, R, share]) => ["P", below(ring, q, p, L, share), beside(ring, q, p, transposed(R))])
  ];
  const constant = place(place(zeros(q, q), p, 0, noise), 0, p, transposed(noise));
  return {terms, constant};
}

// (2.36): minus [[he Theta, E P L, E Y'], [., -W, 0], [., 0, -inv(R)]] with Q = L inv(W) L'.
function costDecay(ends, asked, {T, scale}, ring) {
  const {zeros, matrix, place, scaled, combined, times, transposed} = ring;
  const {L, W, d} = weightFactors(asked.Q);
  const [a, b] = ends[0], N = a.E.rows, k = W.rows, R = matrix(asked.R), q = N + k + R.rows;
  const terms = [];
  for (const [v, w, share] of ends) {
    const right = beside(ring, q, 0, transposed(w.E));
    terms.push(["P", below(ring, q, 0, v.A, -share), right], ["Y", below(ring, q, 0, v.Bu, -share), right]);
  }
  const mean = combined(-0.5, a.E, -0.5, b.E);
  if (k) terms.push(["P", below(ring, q, 0, mean), beside(ring, q, N, times(transposed(T), ring.known(L)))]);
  terms.push(["Y", below(ring, q, N + k, R, scale), beside(ring, q, 0, transposed(mean))]);
  const constant = place(place(zeros(q, q), N, N, ring.known(W)), N + k, N + k, R);
  const rows = place(place(zeros(q - N, q - N), 0, 0, ring.known(d)), k, k, scaled(scale, R));
  return {terms, constant, multiplied: stretched(ring, q, N, rows)};
}

// Blocks that bound P, Y and the sizes where the set has no bound: [[r I - P, Y'], [Y, r I]].
export function joined(blocks, r) {
  const more = new Blocks(Object.fromEntries(blocks.unknowns.map(u => [u.name, u])));
  more.list = [...blocks.list];
  const [P, Y, ...others] = blocks.unknowns, N = P.rows, m = Y.rows, q = N + m;
  const below_r =
    ({name, rows: n}, q) => [name, below(FLOATS, q, 0, identity(n, -0.5)), beside(FLOATS, q, 0, identity(n))];
  const own = others.filter(u => u.symmetric);
  const input = ["Y", below(FLOATS, q, N, identity(m)), beside(FLOATS, q, 0, identity(N))];
  more.add("scale", identity(q, r), own.length ? [input] : [below_r(P, q), input]);
  for (const X of own.length ? [P, ...own] : []) more.add("scale", identity(X.rows, r), [below_r(X, X.rows)]);
  for (const {name} of scalarsOf(blocks)) {
    more.add("scale", identity(2, r), [], [[name, matrix([[0, 1], [1, 0]])]]);
  }
  return more;
}
