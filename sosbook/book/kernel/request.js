// A plant and what is asked of its loop, as LMI blocks: the theorems of the thesis,
// laid out in products L X R. A column of blocks is one product.
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
  const vertices = plain.map(d => changed(d, frame.left, frame.T, frame.scale));
  const N = vertices[0].E.rows, m = vertices[0].Bu.cols, names = sized(asked);
  const tied = asked.mu !== undefined && asked.mu !== null && names.length > 1;
  const followers = tied ? [] : names.slice(1), unknowns = {P: {rows: N, cols: N, symmetric: true}, Y: {rows: m, cols: N}};
  for (const name of followers) unknowns[sizeName(name)] = {rows: 1, cols: 1};
  if (asked.minimize) unknowns.level = {rows: 1, cols: 1};
  const blocks = new Blocks(unknowns);
  blocks.add("P", zeros(N, N), [["P", identity(N, 0.5), identity(N)]]);
  for (const name of followers) blocks.add(sizeName(name), zeros(1, 1), [], [[sizeName(name), identity(1)]]);
  const add = (name, owner, terms, constant, level = null) => {
    const s = followers.includes(owner) && sizeName(owner), unit = (frame.sizes[owner] || 1) ** -2, zero = zeros(constant.rows, constant.rows);
    const slopes = s && constant.at.some(x => x) ? [[s, scaled(unit, constant)]] : [];
    if (level) slopes.push(["level", level]);
    blocks.add(name, s ? zero : constant, terms, slopes);
  };
  const parts = regions(asked);
  if (asked.sigma === undefined && asked.gamma === undefined) parts.push({name: "stability", alpha: [[0]], beta: [[1]]});
  for (const [i, j] of coupledPairs(plain, coupling)) {
    const place = plain.length > 1 ? ` ${i + 1}${i === j ? "" : `,${j + 1}`}` : "";
    const a = vertices[i], b = vertices[j], ends = i === j ? [[a, a, 1]] : [[a, b, 0.5], [b, a, 0.5]];
    for (const part of parts) {
      const k = part.alpha.length;
      add(part.name + place, part.name, poleTerms(part, ends, N), zeros(k * N, k * N));
    }
    if (asked.gamma !== undefined) {
      const [terms, constant, level] = boundedReal(ends, asked);
      add("hinf" + place, "gamma", terms, constant, asked.minimize === "gamma" ? level : null);
    }
  }
  if (asked.u_max !== undefined) addInputBound(add, asked, frame, N, m);
  return blocks;
}

const sizeName = name => `size for ${name}`;
const below = (rows, top, X) => place(zeros(rows, X.cols), top, 0, X);      // X among zero rows
const beside = (cols, left, X) => place(zeros(X.rows, cols), 0, left, X);   // X among zero columns

// Theorem 2.2, (A.9): minus the matrix of alpha_kl EPE' + beta_kl Theta + beta_lk Theta',
// with Theta = (A_i P + B_i Y) E_j' and its mirror image for a pair of vertices.
function poleTerms({alpha, beta}, ends, N) {
  const k = alpha.length, terms = [];
  for (let column = 0; column < k; column++) {
    for (const [a, b, share] of ends) {
      const R = beside(k * N, column * N, transposed(b.E)), P = zeros(k * N, N), Y = zeros(k * N, a.Bu.cols);
      for (let row = 0; row < k; row++) {
        place(P, row * N, 0, a.E, -alpha[row][column] * share / 2);
        place(P, row * N, 0, a.A, -beta[row][column] * share);
        place(Y, row * N, 0, a.Bu, -beta[row][column] * share);
      }
      terms.push(["P", P, R]);
      if (Y.at.some(x => x)) terms.push(["Y", Y, R]);
    }
  }
  return terms;
}

// Theorem 2.1, (2.15): minus [[he Theta, E P C', Bw], [., -gamma^2 / mu, 0], [., 0, -mu]].
function boundedReal(ends, {gamma, mu, minimize}) {
  const [a, b] = ends[0], N = a.E.rows, n = a.C.rows, p = a.Bw.cols, q = N + n + p, terms = [];
  for (const [v, w, share] of ends) {
    const R = beside(q, 0, transposed(w.E));
    terms.push(["P", below(q, 0, scaled(-share, v.A)), R], ["Y", below(q, 0, scaled(-share, v.Bu)), R]);
  }
  terms.push(["P", below(q, 0, combined(-0.5, a.E, -0.5, b.E)), beside(q, N, transposed(a.C))]);
  const constant = zeros(q, q), level = zeros(q, q), noise = combined(0.5, a.Bw, 0.5, b.Bw), size = mu || 1;
  place(place(constant, 0, N + n, noise, -1), N + n, 0, transposed(noise), -1);
  place(constant, N + n, N + n, identity(p, size));
  place(minimize === "gamma" ? level : constant, N, N, identity(n, (minimize === "gamma" ? 1 : gamma ** 2) / size));
  return [terms, constant, level];
}

// Lemma 2.2, (2.21): x(0) lies in the ellipsoid of P, and |K x| <= u_max on it.
function addInputBound(add, {u_max, x0, minimize}, frame, N, m) {
  const start = times(frame.back, {rows: N, cols: 1, at: Float64Array.from(x0)});
  const corner = place(zeros(N + 1, N + 1), 0, 0, identity(1));
  place(place(corner, 1, 0, start), 0, 1, transposed(start));
  add("x0", "u_max", [["P", below(N + 1, 1, identity(N, 0.5)), beside(N + 1, 1, identity(N))]], corner);
  const terms = [["P", below(N + m, 0, identity(N, 0.5)), beside(N + m, 0, identity(N))],
    ["Y", below(N + m, N, identity(m)), beside(N + m, 0, identity(N))]];
  const bound = place(zeros(N + m, N + m), N, N, identity(m));
  if (minimize === "u_max") add("u_max", "u_max", terms, zeros(N + m, N + m), bound);
  else add("u_max", "u_max", terms, scaled((u_max / frame.scale) ** 2, bound));
}

// Blocks that bound P, Y and the sizes where the set has no bound: [[r I - P, Y'], [Y, r I]].
function joined(blocks, r) {
  const more = new Blocks(Object.fromEntries(blocks.unknowns.map(u => [u.name, u])));
  more.list = [...blocks.list];
  const [P, Y] = blocks.unknowns, N = P.rows, m = Y.rows, q = N + m;
  more.add("scale", identity(q, r), [["P", below(q, 0, identity(N, -0.5)), beside(q, 0, identity(N))],
    ["Y", below(q, N, identity(m)), beside(q, 0, identity(N))]]);
  for (const {name} of blocks.unknowns.slice(2)) {
    more.add("scale", identity(2, r), [], [[name, matrix([[0, 1], [1, 0]])]]);
  }
  return more;
}
