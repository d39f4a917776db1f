// The exact proof of a design and its file, which `python -m sosbook verify` accepts.
// Everything is built again from decimals: the plant, the bounds, K and P.

const GAIN_DIGITS = [6, 8, 10, 12, 17], PLACES = [12, 17];   // in the order of trial

// {proven, text, claims, blocks, digits}: the first rounding that is proven, or the last.
function prove(request, result) {
  let last = null;
  for (const digits of GAIN_DIGITS) {
    for (const places of PLACES) {
      const to = (rows, d) => rows.map(row => row.map(x => rounded(x, d)));
      const own = Object.fromEntries(ownSizes(request, result).map(([key, s]) => [key, rounded(s, places)]));
      last = examined(request, to(result.K, digits), to(rowsOf(result.naturalP), places), own);
      if (last.proven) return {...last, digits};
    }
  }
  return last;
}

// With two requirements that fix the size of P, the file's P is that of the last one.
const ownSizes = ({asked}, {sizes}) => sized(asked).length > 1 && sizes.u_max ? [["size for gamma", 1 / sizes.u_max]] : [];

function examined(request, K, P, own) {
  const blocks = exactBlocks(request, K, P, own["size for gamma"]), claims = claimsOf(request);
  const failed = blocks.filter(([, G]) => !definite(G)).map(([key]) => key);
  const {vertices, U = [], K_A = null, coupling = "pairs"} = request;
  const contents = {format: "sosbook proof", version: 1, kind: "design", claims,
    plant: {kind: "second order", vertices: vertices.map(({M, D, S, B, F}) => ({M: decimals(M), D: decimals(D),
      S: decimals(S), B: decimals(B), F: F ? decimals(F) : M.map(() => [])}))},
    U: decimals(U), K_A: K_A && decimals(K_A), coupling, epsilon: null, E0: null, requirements: requirements(request.asked),
    K: decimals(K), unknowns: {P: decimals(P), ...Object.fromEntries(Object.entries(own).map(([k, s]) => [k, [[decimal(s)]]]))},
    blocks: blocks.map(([key]) => key)};
  const text = JSON.stringify({...contents, checksum: sha256(JSON.stringify(sortedKeys(contents)))}, null, 1) + "\n";
  return {proven: !failed.length, failed, claims: failed.length ? [] : claims, blocks: contents.blocks, text};
}

function sortedKeys(x) {
  if (Array.isArray(x)) return x.map(sortedKeys);
  if (x === null || typeof x !== "object") return x;
  return Object.fromEntries(Object.keys(x).sort().map(key => [key, sortedKeys(x[key])]));
}

// What a file says of the requirements: words and decimals, by field.
function requirements({sigma, theta, rho, gamma, mu = null, u_max, x0}) {
  const list = [];
  const region = (name, more, alpha, beta) => list.push({kind: "region", name, form: name, ...more, alpha: decimals(alpha), beta: decimals(beta)});
  if (sigma !== undefined) region("half-plane", {sigma: decimal(sigma)}, [[twiceAtLeast(sigma)]], [[1]]);
  if (theta !== undefined) {
    const {sin, cos, degrees} = sector(theta);
    region("sector", {theta: decimal(theta), apex: "0", degrees}, [[0, 0], [0, 0]], [[sin, cos], [-cos, sin]]);
  }
  if (rho !== undefined) region("disk", {rho: decimal(rho), centre: "0"}, [[-rho, 0], [0, -rho]], [[0, 1], [0, 0]]);
  if (gamma !== undefined) list.push({kind: "gamma", name: "gamma", gamma: decimal(gamma), mu: mu === null ? null : decimal(mu)});
  if (u_max !== undefined) list.push({kind: "input", name: "saturation", u_max: decimal(u_max), x0: decimals(x0), acceleration: false});
  return list;
}

function claimsOf(request) {
  const {vertices, asked, coupling = "pairs"} = request, count = vertices.length, plain = descriptors(request);
  const whole = coupledPairs(plain, coupling).length === coupledPairs(plain, "pairs").length;
  const where = count === 1 ? "the plant" : whole ? "every plant of the polytope"
    : `each of the ${count} vertices (not the plants between)`;
  const claims = [`${where}, under u = K x, is stable`];
  if (asked.sigma !== undefined) claims.push(`its poles lie in the half-plane Re s < ${decimal(-asked.sigma)}`);
  if (asked.theta !== undefined) claims.push(`its poles lie in the sector of half-angle ${sector(asked.theta).degrees} degrees`);
  if (asked.rho !== undefined) claims.push(`its poles lie in the disk of radius ${decimal(asked.rho)} around 0`);
  if (asked.gamma !== undefined) claims.push(`its H-infinity norm is below ${decimal(asked.gamma)}`);
  if (asked.u_max !== undefined) claims.push(`|K x(t)| <= ${decimal(asked.u_max)} from x0 (with r = 0, w = 0)`);
  return claims;
}

// (key, matrix) of each block, without a rounding error. A pair's blocks are doubled and
// those of Theorem 2.1 multiplied by the size of their P, which is positive.
function exactBlocks(request, K, P, size) {
  const {asked, coupling = "pairs"} = request, ends = exactDescriptors(request);
  const X = exactMatrix(P), Y = exactTimes(exactMatrix(K), X), N = X.rows, two = exactScalar(2);
  const list = [[["", "", "P"], X]];
  if (size !== undefined) list.push([["gamma", "gamma", "size for gamma"], exactScalar(size)]);
  const parts = requirements(asked).filter(({kind}) => kind === "region").map(({name, alpha, beta}) =>
    [["region", name, ""], alpha.map(row => row.map(Number)), beta.map(row => row.map(Number))]);
  if (asked.sigma === undefined && asked.gamma === undefined) parts.unshift([["stability", "stability", "stability"], [[0]], [[1]]]);
  for (const [i, j] of coupledPairs(descriptors(request), coupling)) {
    const a = ends[i], b = ends[j], vertices = i === j ? [i] : [i, j];
    const half = (v, w) => exactTimes(exactSum(exactTimes(v.A, X), exactTimes(v.Bu, Y)), exactTransposed(w.E));
    const Theta = exactSum(half(a, b), half(b, a)), mirrored = exactTransposed(Theta);
    const cross = exactTimes(exactTimes(a.E, X), exactTransposed(b.E)), EPE = exactSum(cross, exactTransposed(cross));
    for (const [key, alpha, beta] of parts) {   // (A.9)
      const entry = (k, l) => exactNegative(exactSum(exactScaled(exactScalar(alpha[k][l]), EPE),
        exactScaled(exactScalar(beta[k][l]), Theta), exactScaled(exactScalar(beta[l][k]), mirrored)));
      list.push([[...key, ...vertices], exactBlock(alpha.map((_, k) => alpha.map((_, l) => entry(k, l))))]);
    }
    if (asked.gamma !== undefined) {   // (2.15)
      const s = exactScalar(size ?? 1), mu = exactScalar(asked.mu ?? 1), gamma = exactScalar(asked.gamma);
      const out = exactNegative(exactTimes(exactTimes(exactSum(a.E, b.E), X), exactScaled(mu, exactTransposed(a.C))));
      const noise = exactNegative(exactScaled(s, exactSum(a.Bw, b.Bw))), double = exactScaled(two, exactScaled(mu, s));
      list.push([["gamma", "gamma", "hinf", ...vertices], exactBlock([
        [exactNegative(exactSum(Theta, mirrored)), out, noise],
        [exactTransposed(out), exactIdentity(a.C.rows, exactScaled(gamma, exactScaled(gamma, double))), null],
        [exactTransposed(noise), null, exactIdentity(a.Bw.cols, double)]])]);
    }
  }
  if (asked.u_max !== undefined) {   // (2.21)
    const x0 = exactMatrix(asked.x0.map(x => [x])), u = exactScalar(asked.u_max), bound = exactIdentity(Y.rows, exactTimes(u, u));
    list.push([["input", "saturation", "x0"], exactBlock([[exactScalar(1), exactTransposed(x0)], [x0, X]])]);
    list.push([["input", "saturation", "u_max"], exactBlock([[X, exactTransposed(Y)], [Y, bound]])]);
  }
  return list;
}

function exactDescriptors({vertices, U = [], K_A = null}) {
  return vertices.map(({M, D, S, B, F}) => {
    const n = M.length, a = U.length, m = B[0].length, zero = (r, c) => ({rows: r, cols: c, places: 0, at: Array(r * c).fill(0n)});
    const mass = K_A ? exactSum(exactMatrix(M), exactNegative(exactTimes(exactMatrix(B), exactMatrix(K_A)))) : exactMatrix(M);
    const one = exactIdentity(n), stack = (X, cols) => exactBlock([[zero(n, cols)], [X], [zero(a, cols)]]);
    return {
      E: exactBlock([[one, null, zero(n, a)], [null, mass, zero(n, a)], [zero(a, n), zero(a, n), exactIdentity(a)]]),
      A: exactBlock([[zero(n, n), one, zero(n, a)], [exactNegative(exactMatrix(S)), exactNegative(exactMatrix(D)), zero(n, a)],
        [a ? exactMatrix(U) : zero(0, n), zero(a, n), zero(a, a)]]),
      Bu: stack(exactMatrix(B), m),
      Bw: F && F[0].length ? stack(exactMatrix(F), F[0].length) : zero(2 * n + a, 0),
      C: exactBlock([[one, zero(n, n + a)]]),
    };
  });
}
