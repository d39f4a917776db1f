// The plant with its integrators, E x' = A x + Bu u + Bw w, z = C x, as in (2.8) and
// (2.11) of the thesis; x = [z; z'; x3], and x3 is the integral of U e.
import {alike, EXACT, exactTransposed, signOfDeterminant} from "./exact.js";
import {cholesky, combined, FLOATS, identity, inner, inverse, inverseLower, mapped, matrix, norm, scaled, solve, symmetricEigenvalues, times, transposed} from "./matrices.js";
import {eigenvalues, riccati} from "./spectrum.js";

// plant: {vertices: [{M, D, S, B, F}], U, K_A, law}, lists of rows. F, U, K_A and law may be missing;
// a law joins its integrals, and what its filters hold.
export function descriptors({vertices, U = [], K_A = null, law = null},
  /** @type {any} */ {matrix, zeros, identity, times, combined, place} = FLOATS) {
  return vertices.map(({M, D, S, B, F = null}) => {
    const {integrate = [], position = [], filter = 0} = law ?? {}, seen = matrix(position, M.length);
    const summed = law ? times(matrix(integrate, position.length), seen) : matrix(U);
    const n = M.length, a = summed.rows, f = filter ? position.length : 0, N = 2 * n + a + f, m = B[0].length;
    let mass = matrix(M);
    if (K_A) mass = combined(1, mass, -1, times(matrix(B), matrix(K_A)));
    const E = zeros(N, N), A = zeros(N, N), Bu = zeros(N, m), p = F ? F[0].length : 0;
    const Bw = zeros(N, p), C = zeros(n, N);
    place(place(place(E, 0, 0, identity(n)), n, n, mass), 2 * n, 2 * n, identity(a));
    place(E, 2 * n + a, 2 * n + a, identity(f, filter));
    place(place(place(A, 0, n, identity(n)), n, 0, matrix(S), -1), n, n, matrix(D), -1);
    place(A, 2 * n, 0, summed);
    if (f) place(place(A, 2 * n + a, 0, seen), 2 * n + a, 2 * n + a, identity(f), -1);
    place(Bu, n, 0, matrix(B));
    if (p) place(Bw, n, 0, matrix(F));
    place(C, 0, 0, identity(n));
    return {E, A, Bu, Bw, C, mass: M.map((row, i) => row[i])};
  });
}

const PARTS = ["E", "A", "Bu", "Bw"];
export const same = (d, e) => PARTS.every(name => d[name].at.every((x, k) => x === e[name].at[k]));

// The vertices, without those that repeat another one: their indices.
const distinct = vertices =>
  vertices.map((_, i) => i).filter(i => !vertices.slice(0, i).some(d => same(d, vertices[i])));

// Pairs (i, j), i <= j, of vertices that need a block. Where E_i = E_j the pair's
// block is the mean of the vertices' blocks; a vertex that repeats another is left out,
// and so are all pairs where the vertices suffice.
export function coupledPairs(request, coupling = request.coupling ?? "pairs") {
  const few = distinct(descriptors(request));
  return coupling === "vertices" ? few.map(i => [i, i]) : pairsOf(descriptors(request, EXACT), few);
}

// The same of exact descriptors, of which these `few` differ.
export function pairsOf(exactly, few) {
  const pairs = few.map(i => [i, i]), N = exactly[0].E.rows;
  if (!pairs[1]) return pairs;
  const all = alike(few.flatMap(i => PARTS.map(name => exactTransposed(exactly[i][name]))));
  const points = few.map((_, k) => all.slice(4 * k, 4 * k + 4).flatMap(({at}) => at));
  const E = points.map(p => p.slice(0, N * N));
  if (quotientInHull(points, E, N)) return pairs;
  few.forEach((i, k) => few.forEach((j, l) => {
    if (k < l && `${E[k]}` !== `${E[l]}`) pairs.push([i, j]);
  }));
  return pairs;
}

// Whether inv(E) [A Bu Bw] of each plant of a polytope is a mean of the vertices' ones, as
// `sosbook.plants.hull` tells. A point holds the columns of a vertex's [E A Bu Bw].
function quotientInHull(points, E, N) {
  const known = new Set(points.map(String)), box = new Map();
  const [first, ...others] = [...points].sort((p, q) => {
    const k = p.findIndex((x, k) => x !== q[k]);
    return p[k] < q[k] ? -1 : 1;
  });
  const less = p => p.map((x, k) => x - first[k]), ofE = p => `${p.slice(0, N * N)}`;
  const oneColumn = changes => {  // all columns are multiples of one
    const columns =
      changes.flatMap(c => c.filter((_, k) => k % N === 0).map((_, k) => c.slice(k * N, k * N + N)));
    const u = columns.find(c => c.some(x => x)), r = u.findIndex(x => x);
    return columns.every(c => c.every((x, i) => x * u[r] === u[i] * c[r]));
  };
  if (E.every(e => `${e}` === `${E[0]}`)) return true;
  if (!oneColumn(others.map(less))) {
    for (const p of [first, ...others]) {
      if (ofE(p) === ofE(first)) box.set(`${p}`, p);
      if (box.has(`${p}`)) continue;
      const change = less(p);
      if (!oneColumn([change])) return false;
      for (const q of [...box.values()]) {
        const moved = q.map((x, k) => x + change[k]);
        box.set(`${moved}`, moved);
      }
      if (![...box.keys()].every(k => known.has(k))) return false;
    }
  }
  const [sign, ...signs] = E.map(e => signOfDeterminant(e, N));
  return sign !== 0 && signs.every(x => x === sign);
}

export function meanDescriptor(vertices) {
  const few = distinct(vertices).map(i => vertices[i]), mean = {};
  for (const name of ["E", "A", "Bu", "Bw", "C"]) {
    mean[name] = few.map(d => d[name]).reduce((sum, X) => combined(1, sum, 1, X));
    mean[name] = scaled(1 / few.length, mean[name]);
  }
  const size = symmetricEigenvalues(times(transposed(mean.E), mean.E));
  return Math.sqrt(Math.max(0, size[0]) / size[size.length - 1]) < 1e-6 ? vertices[0] : mean;
}

// inv(E) [A Bu Bw]
export const stateSpace = ({E, A, Bu, Bw}) => [A, Bu, Bw].map(X => solve(E, X));

// The system in coordinates x = T xi, u = scale v, its rows times `left`.
export const changed = ({E, A, Bu, Bw, C}, {left, T, scale: a}) => ({
  E: times(times(left, E), T),
  A: times(times(left, A), T),
  Bu: scaled(a, times(left, Bu)),
  Bw: times(left, Bw),
  C: times(C, T)
});

export const rounded = (x, digits) => Number(x.toExponential(digits - 1));

// What asks for a size of P, the leader first: see `Request` of the package. The others
// have P / s, Y / s in their blocks, with an unknown s.
export function sized(asked) { return ["gamma", "cost", "u_max"].filter(name => asked[name] !== undefined); }

// Coordinates x = T xi, u = scale v in which the LMIs are well conditioned, from the
// Riccati equation of the mean vertex; sizes and gain start the search.
export function frameOf(vertices, asked) {
  const mean = meanDescriptor(vertices), n = mean.C.rows;
  const most = Math.max(...vertices.map(({Bu}) => Math.sqrt(inner(Bu, Bu))));
  const typical = Math.sqrt(inner(mean.Bu, mean.Bu)) > 0.1 * most ? mean : vertices[0];
  const [A, B] = stateSpace(typical), omega = typicalRate(asked, mean);
  const noise = asked.cost !== undefined && asked.noise;
  const cheap = noise && leastCost(A, B, asked);
  const {T: T0, K} = cheap || ofEnergy(vertices, A, B, omega);
  const reaches = reach(asked, T0, stateSpace(mean)[2], omega), names = sized(asked);
  const tied = asked.mu !== undefined && asked.mu !== null && names.length > 1;
  const many = names.length > 1 && !tied;
  const large = many         ? reaches[names[0]]
    : cheap || !names.length ? 1
                             : Math.max(1e-300, ...names.map(k => reaches[k]));
  let T = scaled(Math.sqrt(large), T0);
  const scale = (cheap ? norm(times(K, T)) : omega / (norm(solve(times(mean.E, T), mean.Bu)) || 1)) || 1;
  const gain = K && scaled(1 / scale, times(K, T));
  T = mapped(T, x => rounded(x, 6));
  const followers = tied ? [] : names.slice(1), now = reach(asked, T, stateSpace(mean)[2], omega);
  const sizes = Object.fromEntries(followers.map(k => [k, rounded(Math.sqrt(now[k] / now[names[0]]), 2)]));
  return {...withInverses(T, mean, noise), scale: rounded(scale, 6), gain, sizes, n};
}

// {T, K} of the regulator of least cost, x = T xi, whose P is the identity there; null
// without one. In coordinates in which both weights are the identity.
function leastCost(A, B, {Q, R}) {
  const most = Math.max(...Q.map((row, i) => row[i]));
  const more = x => x + 1e-6 * Math.max(x, 1e-6 * most);
  const left = cholesky(mapped(matrix(Q), (x, i, j) => i === j ? more(x) : x));
  const right = cholesky(matrix(R));
  if (!left || !right) return null;
  const turn = transposed(left), back = inverse(turn), push = transposed(inverseLower(right));
  const input = times(times(turn, B), push), X = riccati(times(times(turn, A), back), input);
  const L = X && cholesky(X);
  if (!L) return null;
  return {
    T: times(back, transposed(inverseLower(L))),
    K: scaled(-1, times(push, times(times(transposed(input), X), turn)))
  };
}

// The same of a regulator whose weights are energies.
function ofEnergy(vertices, A, B, omega) {
  const N = A.rows, weight = energy(vertices, omega);
  const effort = Array.from({length: B.cols}, (_, j) => {
    let sum = 0;
    for (let i = 0; i < N; i++) sum += weight[i] * B.at[i * B.cols + j] ** 2;
    return sum / omega ** 2 || 1;
  });
  const size = weight.map(Math.sqrt), force = effort.map(Math.sqrt);
  const shift = mapped(A, (x, i, j) => size[i] * x / size[j] / omega + (i === j ? 0.1 : 0));
  const push = mapped(B, (x, i, j) => size[i] * x / force[j] / omega);
  const X = riccati(shift, push), L = X && cholesky(X);
  return {
    T: mapped(L ? transposed(inverseLower(L)) : identity(N), (x, i) => x / size[i]),
    K: L && mapped(times(transposed(push), X), (x, i, j) => -x * size[j] / force[i])
  };
}

// To six digits, as T is: the blocks only undergo congruences, whatever `left` and `back`
// are, and exact arithmetic stays short.
export function withInverses(T, mean, noise) {
  const [left, back] = [times(mean.E, T), T].map(X => mapped(inverse(X), x => rounded(x, 6)));
  const push = noise && times(back, noise === "F" ? solve(mean.E, mean.Bw) : identity(T.rows));
  return {T, left, back, noise, own: (noise && rounded(norm(push) ** 2, 2)) || 1};
}

function typicalRate({sigma, rho}, mean) {
  if (rho !== undefined) return rho / 2;
  if (sigma) return 4 * sigma;
  return Math.max(...eigenvalues(stateSpace(mean)[0]).map(s => Math.hypot(...s))) || 1;
}

// Diagonal weights of x that have the unit of energy.
function energy(vertices, omega) {
  const few = distinct(vertices).map(i => vertices[i]);
  const {A, C} = vertices[0], n = C.rows, N = A.rows, inertia = new Float64Array(n);
  for (const {mass, A} of few) {
    for (let i = 0; i < n; i++) {
      const at = j => Math.abs(A.at[(n + i) * N + j]);
      inertia[i] += (Math.abs(mass[i]) + at(n + i) / omega + at(i) / omega ** 2) / few.length;
    }
  }
  const list = [];
  for (let i = 0; i < n; i++) {
    inertia[i] ||= 1;
    list.push(omega ** 2 * inertia[i]);
  }
  list.push(...inertia);
  for (let k = 2 * n; k < N; k++) {
    let sum = 0;
    for (let j = 0; j < n; j++) sum += A.at[k * N + j] ** 2 / inertia[j];
    list.push(omega ** 4 / sum);
  }
  return list;
}

// How large each requirement's P must be, roughly.
export function reach({mu, x0}, T, Bw, omega) {
  const X = x0 && solve(T, {rows: x0.length, cols: 1, at: Float64Array.from(x0)});
  const noise = norm(solve(T, Bw)) ** 2;
  return {gamma: noise / (mu || 1) / omega || 1, cost: 1, u_max: x0 ? 2 * inner(X, X) || 1 : 1};
}
