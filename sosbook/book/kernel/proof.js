// The exact proof of a design and its file, which `python -m sosbook verify` accepts.
// Everything is built again from decimals: the plant, the bounds, K and P.
import {coupledPairs, descriptors, plainFrame, rounded, sized} from "./descriptor.js";
import {decimal, decimals, definite, EXACT, exactMatrix, exactScalar, exactScaled, exactSum, exactTimes, exactTransposed, sector, twiceAtLeast} from "./exact.js";
import {rowsOf} from "./matrices.js";
import {impliesStability, KINDS, laidOut, sizeName} from "./request.js";
import {fileOf} from "./text.js";

const GAIN_DIGITS = [6, 8, 10, 12, 17], PLACES = [12, 17];  // in the order of trial

// {proven, text, claims, blocks, digits}: the first rounding that is proven, or the last.
export function prove(request, result) {
  let last = null;
  for (const digits of GAIN_DIGITS) {
    for (const places of PLACES) {
      const to = (rows, d) => rows.map(row => row.map(x => rounded(x, d)));
      const own = Object.fromEntries(ownSizes(request, result).map(([key, s]) => [key, rounded(s, places)]));
      last = examined(request, to(result.K, digits), to(rowsOf(result.naturalP), places), own,
        result.J && to(rowsOf(result.J), places));
      if (last.proven) return {...last, digits};
    }
  }
  return last;
}

// With requirements that fix the size of P, the file's P is that of the last one.
function ownSizes({asked}, {sizes}) {
  const names = sized(asked), last = sizes[names.pop()];
  return last ? names.map(name => [sizeName(name), (sizes[name] || 1) / last]) : [];
}

function examined(request, K, P, own, J) {
  const blocks = blocksAt(request, K, P, own, J), claims = claimsOf(request);
  const failed = blocks.filter(([, G]) => !definite(G)).map(([key]) => key);
  const bare = ([, kind, name]) => !blocks.some(([key]) => key[0] === kind && key[1] === name);
  failed.push(...statementsOf(request).filter(bare));  // a claim rests on blocks of its own
  const proven = !failed.length, sizes = Object.entries(own).map(([k, s]) => [k, [[decimal(s)]]]);
  const unknowns = {P: decimals(P), ...(J && {J: decimals(J)}), ...Object.fromEntries(sizes)};
  const text = fileOf("design", request, requirements(request.asked), {K: decimals(K), unknowns});
  return {proven, failed, claims: proven ? claims : [], blocks: blocks.map(([key]) => key), text};
}

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

// [words, kind, name]: each claim beside the requirement whose blocks prove it.
function statementsOf(request) {
  const {vertices, asked} = request, count = vertices.length;
  const whole = coupledPairs(request).length === coupledPairs(request, "pairs").length;
  const where = count === 1 ? "the plant"
    : whole                 ? "every constant or changing plant of the polytope"  // one P for all
                            : `each of the ${count} vertices (not the plants between)`;
  const {sigma, theta, rho, gamma, cost, u_max} = asked, said = [];
  const say = (bound, words, ...owner) => bound === undefined || said.push([words(bound), ...owner]);
  say(sigma, x => `its poles lie in the half-plane Re s < ${decimal(-x)}`, "region", "half-plane");
  say(
    theta, x => `its poles lie in the sector of half-angle ${sector(x).degrees} degrees`, "region", "sector");
  say(rho, x => `its poles lie in the disk of radius ${decimal(x)} around 0`, "region", "disk");
  say(gamma, x => `its H-infinity norm is below ${decimal(x)}`, ...KINDS.gamma);
  say(
    cost, x => `its quadratic cost is below ${decimal(x)} times the largest noise intensity`, ...KINDS.cost);
  say(u_max, x => `|K x(t)| <= ${decimal(x)} from x0 (with r = 0, w = 0)`, ...KINDS.u_max);
  return [
    [`${where}, under u = K x, is stable`, ...impliesStability(asked) || ["stability", "stability"]], ...said
  ];
}

export const claimsOf = request => statementsOf(request).map(([words]) => words);

// The regions as a file has them: rounded inwards, as numbers.
export const exactRegions = asked =>
  requirements(asked).filter(({kind}) => kind === "region").map(({name,
    alpha,
    beta}) => ({name, alpha: alpha.map(row => row.map(Number)), beta: beta.map(row => row.map(Number))}));

// (key, matrix) of each block in the plant's own coordinates, without a rounding error:
// those of Theorem 2.1 multiplied by the size of their P and by powers of mu.
function blocksAt(request, K, P, own, J) {
  const {asked} = request, X = exactMatrix(P),
        followers = Object.keys(own).map(key => key.replace("size for ", ""));
  const values = {P: X, Y: exactTimes(exactMatrix(K), X)};
  for (const [key, s] of Object.entries(own)) values[key] = exactScalar(s);
  const size = values[sizeName("cost")];
  if (J) values.J = size ? exactScaled(size, exactMatrix(J)) : exactMatrix(J);
  return blocksOf(descriptors(request, EXACT), coupledPairs(request), asked, values, followers);
}

// The same of exact descriptors and of values of the unknowns.
export function blocksOf(plain, pairs, asked, values, followers = []) {
  const {list} =
    laidOut(plain, pairs, asked, exactRegions(asked), plainFrame(values.P.rows, EXACT), followers, EXACT);
  return list.map(({key, terms, constant, slopes}) => {
    let G = constant;
    for (const [name, L, R] of terms) {
      const half = exactTimes(exactTimes(L, values[name]), R);
      G = exactSum(exactSum(G, half), exactTransposed(half));
    }
    for (const [name, slope] of slopes) G = exactSum(G, exactScaled(values[name], slope));
    return [key, G];
  });
}
