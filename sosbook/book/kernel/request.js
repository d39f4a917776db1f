// A plant and what is asked of it as LMI blocks: the theorems of the thesis, laid out
// in products L X R. A column of blocks is one product.
//
// asked: {sigma, theta, rho, gamma, mu, u_max, x0, minimize}; what is missing isn't asked.

// (2.18), (2.19), (2.20): regions alpha + beta s + beta' s* < 0, rounded inwards
// as the package's proofs want them.
function regions({sigma, theta, rho}) {
  const list = [];
  if (sigma !== undefined) list.push({name: "half-plane", alpha: [[2 * sigma]], beta: [[1]]});
  if (theta !== undefined) {
    const sin = Math.sin(theta) * (1 - 4 * Number.EPSILON), cos = Math.cos(theta) * (1 + 4 * Number.EPSILON);
    list.push({name: "sector", alpha: [[0, 0], [0, 0]], beta: [[sin, cos], [-cos, sin]]});
  }
  if (rho !== undefined) list.push({name: "disk", alpha: [[-rho, 0], [0, -rho]], beta: [[0, 1], [0, 0]]});
  return list;
}

// The blocks of a request in a frame, affine in P, Y, the sizes s and the level.
function assembled(plain, asked, coupling, frame) {
  const {unknowns, list} = laidOut(plain, coupledPairs(plain, coupling), asked, regions(asked), frame);
  const blocks = new Blocks(unknowns);
  for (const {name, constant, terms, slopes} of list) blocks.add(name, constant, terms, slopes);
  return blocks;
}

// Which requirements have a P of their own: that of the leader over an unknown size.
function followersOf(asked) {
  const names = sized(asked), tied = asked.mu !== undefined && asked.mu !== null && names.length > 1;
  return tied ? [] : names.slice(1);
}

const KINDS = {gamma: ["gamma", "gamma"], u_max: ["input", "saturation"]};   // in the words of a proof file
const sizeName = name => `size for ${name}`;

// {unknowns, list}: each block has its name, its key in a proof file, its products
// [unknown, L, R], its constant, the slopes of scalars, and by what its rows are
// `multiplied` to have neither 1 / mu nor 1 / scale among its numbers. In the ring
// EXACT nothing is rounded.
function laidOut(plain, pairs, asked, parts, frame, followers = followersOf(asked), ring = FLOATS) {
  const {zeros, identity, scaled} = ring, vertices = plain.map(d => changed(d, frame, ring));
  const N = vertices[0].E.rows, m = vertices[0].Bu.cols, list = [];
  const unknowns = {P: {rows: N, cols: N, symmetric: true}, Y: {rows: m, cols: N}};
  for (const name of followers) unknowns[sizeName(name)] = {rows: 1, cols: 1};
  if (asked.minimize) unknowns.level = {rows: 1, cols: 1};
  list.push({name: "P", key: ["", "", "P"], terms: [["P", identity(N, 0.5), identity(N)]], constant: zeros(N, N), slopes: []});
  for (const name of followers) {
    const kind = KINDS[name], key = [...kind, sizeName([...new Set(kind)].join(" "))];
    list.push({name: sizeName(name), key, terms: [], constant: zeros(1, 1), slopes: [[sizeName(name), identity(1)]]});
  }
  const add = (name, key, owner, {terms, constant, level = null, multiplied = null}) => {
    const s = followers.includes(owner) && sizeName(owner), slopes = level ? [["level", level]] : [];
    if (s && constant.at.some(x => x)) slopes.unshift([s, scaled((frame.sizes[owner] || 1) ** -2, constant)]);
    list.push({name, key, terms, constant: s ? zeros(constant.rows, constant.rows) : constant, slopes, multiplied});
  };
  const all = asked.sigma === undefined && asked.gamma === undefined ? [{name: "stability", alpha: [[0]], beta: [[1]]}, ...parts] : parts;
  for (const [i, j] of pairs) {
    const place = plain.length > 1 ? ` ${i + 1}${i === j ? "" : `,${j + 1}`}` : "", where = i === j ? [i] : [i, j];
    const a = vertices[i], b = vertices[j], ends = i === j ? [[a, a, 1]] : [[a, b, 0.5], [b, a, 0.5]];
    for (const part of all) {
      const key = part.name === "stability" ? Array(3).fill("stability") : ["region", part.name, ""];
      add(part.name + place, [...key, ...where], part.name, polePart(part, ends, N, ring));
    }
    if (asked.gamma !== undefined) add("hinf" + place, [...KINDS.gamma, "hinf", ...where], "gamma", boundedReal(ends, asked, ring));
  }
  if (asked.u_max !== undefined) {
    const [start, bound] = inputBound(asked, frame, N, m, ring);
    add("x0", [...KINDS.u_max, "x0"], "u_max", start);
    add("u_max", [...KINDS.u_max, "u_max"], "u_max", bound);
  }
  return {unknowns, list};
}

// X among zero rows, and among zero columns.
const below = ({zeros, place}, rows, top, X, ...factors) => place(zeros(rows, X.cols), top, 0, X, ...factors);
const beside = ({zeros, place}, cols, left, X) => place(zeros(X.rows, cols), 0, left, X);

// Theorem 2.2, (A.9): minus the matrix of alpha_kl EPE' + beta_kl Theta + beta_lk Theta',
// with Theta = (A_i P + B_i Y) E_j' and its mirror image for a pair of vertices.
function polePart({alpha, beta}, ends, N, ring) {
  const {zeros, place, transposed} = ring, k = alpha.length, terms = [];
  for (let column = 0; column < k; column++) {
    for (const [a, b, share] of ends) {
      const R = beside(ring, k * N, column * N, transposed(b.E)), P = zeros(k * N, N), Y = zeros(k * N, a.Bu.cols);
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
function boundedReal(ends, {gamma, mu, minimize}, ring) {
  const {zeros, identity, place, scaled, combined, transposed} = ring;
  const [a, b] = ends[0], N = a.E.rows, n = a.C.rows, p = a.Bw.cols, q = N + n + p, terms = [];
  for (const [v, w, share] of ends) {
    const R = beside(ring, q, 0, transposed(w.E));
    terms.push(["P", below(ring, q, 0, v.A, -share), R], ["Y", below(ring, q, 0, v.Bu, -share), R]);
  }
  const size = mu || 1, mean = combined(-0.5, a.E, -0.5, b.E);
  terms.push(["P", below(ring, q, 0, mean), beside(ring, q, N, scaled(size, transposed(a.C)))]);
  const constant = zeros(q, q), level = minimize === "gamma" ? zeros(q, q) : null, noise = combined(0.5, a.Bw, 0.5, b.Bw);
  place(place(constant, 0, N + n, noise, -1), N + n, 0, transposed(noise), -1);
  place(constant, N + n, N + n, identity(p), size);
  if (level) place(level, N, N, identity(n), size);
  else place(constant, N, N, identity(n), gamma, gamma, size);
  return {terms, constant, level, multiplied: [[N, N + n, size]]};
}

// Lemma 2.2, (2.21): x(0) lies in the ellipsoid of P, and |K x| <= u_max on it.
function inputBound({u_max, x0, minimize}, {back, near, scale}, N, m, ring) {
  const {matrix, zeros, identity, place, transposed, times} = ring, start = times(back, matrix(x0.map(x => [x])));
  const corner = place(zeros(N + 1, N + 1), 0, 0, identity(1)), turn = near || identity(N);
  place(place(corner, 1, 0, start), 0, 1, transposed(start));
  const inside = [["P", below(ring, N + 1, 1, turn, 0.5), beside(ring, N + 1, 1, transposed(turn))]];
  const terms = [["P", below(ring, N + m, 0, identity(N, 0.5)), beside(ring, N + m, 0, identity(N))],
    ["Y", below(ring, N + m, N, identity(m), scale), beside(ring, N + m, 0, identity(N))]];
  const bound = {terms, constant: zeros(N + m, N + m), multiplied: [[N, N + m, scale]]};
  if (minimize === "u_max") bound.level = place(zeros(N + m, N + m), N, N, identity(m), scale, scale);
  else place(bound.constant, N, N, identity(m), u_max, u_max);
  return [{terms: inside, constant: corner}, bound];
}

// Blocks that bound P, Y and the sizes where the set has no bound: [[r I - P, Y'], [Y, r I]].
function joined(blocks, r) {
  const more = new Blocks(Object.fromEntries(blocks.unknowns.map(u => [u.name, u])));
  more.list = [...blocks.list];
  const [P, Y] = blocks.unknowns, N = P.rows, m = Y.rows, q = N + m;
  more.add("scale", identity(q, r), [["P", below(FLOATS, q, 0, identity(N, -0.5)), beside(FLOATS, q, 0, identity(N))],
    ["Y", below(FLOATS, q, N, identity(m)), beside(FLOATS, q, 0, identity(N))]]);
  for (const {name} of blocks.unknowns.slice(2)) {
    more.add("scale", identity(2, r), [], [[name, matrix([[0, 1], [1, 0]])]]);
  }
  return more;
}
