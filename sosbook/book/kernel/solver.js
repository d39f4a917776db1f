// Phase one and the analytic centre of LMI blocks. The numbers of
// sections are those of Boyd and Vandenberghe (2004).
import {Blocks} from "./blocks.js";
import {cholesky, combined, dot, identity, inner, inverseLower, mapped, reals, scaled, solveCholesky, symmetricEigenvalues, symmetrized, times, transposed} from "./matrices.js";

const STEP_FRACTION = 0.95;    // of the longest step that stays inside
const LONGEST_CENTRE = 1e8;    // a norm of x beyond it is taken for infinity
const STEPS_ALONE = 40;        // of Newton's method, before multipliers help it to a centre
const EXCLUDED_ENOUGH = 1e11;  // the |x| that multipliers must exclude; solutions are shorter

export const factored = list => {
  const factors = [];
  for (const G of list) {
    const L = cholesky(G);
    if (!L) return null;
    factors.push(L);
  }
  return factors;
};
export const rootsOf = factors => factors.map(inverseLower);
export const inverses = roots => roots.map(N => times(transposed(N), N));
const whitened = (N, dG) => symmetrized(times(times(N, dG), transposed(N)));
export const plus = (x, a, d) => {
  const y = reals(x.length);
  for (let k = 0; k < y.length; k++) y[k] = x[k] + a * d[k];
  return y;
};
const innerOf = (S, Z) => S.reduce((sum, s, k) => sum + inner(s, Z[k]), 0);
const leastOf = list => Math.min(...list.map(G => symmetricEigenvalues(G)[0]));

// A function that solves H d = g; a ridge is added where H has no factor.
export function newtonSolver(H) {
  const n = H.rows, scale = new Float64Array(n);
  for (let i = 0; i < n; i++) scale[i] = 1 / Math.sqrt(H.at[i * n + i] || 1);
  const unit = mapped(H, (x, i, j) => i === j && x === 0 ? 1 : x * scale[i] * scale[j]);
  for (let ridge = 1e-15; ridge < 1; ridge *= 10) {
    for (let i = 0; i < n; i++) unit.at[i * n + i] += ridge;
    const L = cholesky(unit);
    if (L) return g => solveCholesky(L, g.map((x, k) => x * scale[k])).map((x, k) => x * scale[k]);
  }
  return null;
}

// ------------------------------------------------------- primal-dual steps
// Minimise c.x subject to S_k = G_k(x) >= 0, with multipliers Z_k >= 0 and
// sum <G_ka, Z_k> = c_a: the direction of Helmberg, Kojima and Monteiro, which needs
// Cholesky factors only, with Mehrotra's predictor and corrector, towards S Z = 0 or
// S Z = `target` I. Yields after each step.
function* interiorSteps(blocks, x, cost, weight, target = null, most = 60) {
  const degree = blocks.degree;
  let S = blocks.at(x), factors = factored(S);
  if (!factors) return;
  let roots = rootsOf(factors), W = inverses(roots), Z = W.map(w => scaled(1 / weight, w));
  for (let count = 0; count < most; count++) {
    const solver = newtonSolver(blocks.hessian(W, Z)), dualRoots = factored(Z);
    if (!solver || !dualRoots) return;
    const dual = rootsOf(dualRoots), mu = innerOf(S, Z) / degree;
    const towards = (sigmaMu, second) => {
      const T = W.map((w, k) => second ? combined(sigmaMu, w, -1, second[k]) : scaled(sigmaMu, w));
      const dx = solver(plus(blocks.adjoint(T), -1, cost));
      const dS = blocks.at(dx, true);
      const dZ = dS.map(
        (d, k) => combined(1, combined(1, T[k], -1, Z[k]), -1, symmetrized(times(times(W[k], d), Z[k]))));
      return [dx, dS, dZ];
    };
    const longest = (N, dS) =>
      1 / Math.max(1e-9, ...N.map((n, k) => -symmetricEigenvalues(whitened(n, dS[k]))[0]));
    // predictor: the target is zero
    const [, aS, aZ] = towards(0);
    const alpha = Math.min(1, longest(roots, aS)), beta = Math.min(1, longest(dual, aZ));
    const predicted =
      S.reduce((sum, s, k) => sum + inner(combined(1, s, alpha, aS[k]), combined(1, Z[k], beta, aZ[k])), 0) /
      degree;
    // corrector: the target is sigma mu, less the predictor's second-order error
    const sigma = Math.min(Math.max(predicted / mu, 0), 1) ** 3;
    const second = aS.map((d, k) => symmetrized(times(times(W[k], d), aZ[k])));
    const [dx, dS, dZ] = towards(target ?? sigma * mu, second);
    let primal = Math.min(1, STEP_FRACTION * longest(roots, dS));
    const step = Math.min(1, STEP_FRACTION * longest(dual, dZ));
    if (!dx.every(isFinite) || Math.max(primal, step) < 1e-8) return;
    for (;; primal /= 2) {  // rounding may put the end point outside
      S = blocks.at(plus(x, primal, dx));
      factors = factored(S);
      if (factors) break;
      if (primal < 1e-12) return;
    }
    x = plus(x, primal, dx);
    Z = Z.map((z, k) => combined(1, z, step, dZ[k]));
    roots = rootsOf(factors);
    W = inverses(roots);
    const residual = plus(cost, -1, blocks.adjoint(Z));
    yield {step: count + 1, x, S, Z, gap: innerOf(S, Z), residual: Math.sqrt(dot(residual, residual))};
  }
}

// ---------------------------------------------------------------- phase one
// The blocks with one more scalar t: G_k(x) - t I.
const LIFT = {
  name: "t",
  rows: 1,
  cols: 1,
  symmetric: false,
  size: 1,
  scalar: true
};
function lifted(blocks) {
  const more = new Blocks({});
  Object.assign(more, {size: blocks.size + 1, unknowns: [...blocks.unknowns, {...LIFT, from: blocks.size}]});
  const cone = blocks.homogeneous, of = blocks.unknowns.length;
  more.list = blocks.list.map((block, k) => ({
    ...block,
    constant: cone && k === 0 ? identity(block.q, -1) : block.constant,  // X > 0 is read as X > I
    slopes: [...block.slopes, {of, G: identity(block.q, -1)}]
  }));
  return more;
}

// {verdict, x} with a point x inside all blocks, or {verdict, Z, excluded}: multipliers
// that no x of a norm below `excluded` can meet. Raises t as in section 11.4.
export function phaseOne(blocks, start = null) {
  if (start && factored(blocks.at(start))) return {verdict: "feasible", x: start, steps: 0};
  const problem = lifted(blocks), n = blocks.size, cost = new Float64Array(n + 1);
  cost[n] = -1;
  const with_t = (x, t) => Float64Array.from([...x, t]);
  let x = new Float64Array(n), least = leastOf(problem.at(with_t(x, 0))), below = 1;
  const near = start ? leastOf(problem.at(with_t(start, 0))) : -Infinity;
  if (near > least) {
    x = start;
    least = near;
    below = Math.max(Math.abs(near), 0.1);
  }
  x = with_t(x, Math.min(least, 0) - below);
  const first = factored(problem.at(x));
  if (!first) return {verdict: "undecided", x: null, last: start, steps: 0};
  const weight = inverses(rootsOf(first)).reduce((sum, w) => sum + inner(w, identity(w.rows)), 0);
  let last = null, tries = 0;
  for (const state of interiorSteps(problem, x, cost, weight)) {
    last = state;
    const inside = state.x.slice(0, n);
    if (state.x[n] > 0 && factored(problem.at(with_t(inside, 0)))) {
      return {verdict: "feasible", x: inside, steps: state.step};
    }
    if (state.x[n] + 1.1 * state.gap < 0 && state.residual < 1e-3) {  // weak duality
      const {Z, excluded} = refined(problem, blocks, state.Z);
      if (excluded > EXCLUDED_ENOUGH)
        return {verdict: "infeasible", Z, excluded, last: inside, steps: state.step};
      if (state.residual < 1e-7 && ++tries > 8) break;  // an edge: nothing will decide
    }
  }
  return {verdict: "undecided", last: last && last.x.slice(0, n), steps: last ? last.step : 0};
}

// Multipliers with sum <G_ka, Z_k> nearer to zero: Z + Z F(y) Z with the least y.
// `excluded` is the norm that every feasible x has at least: 0 <= value + residual.x.
function refined(problem, blocks, Z) {
  const constants = problem.list.map(({constant}) => constant);
  let best = {Z, excluded: reach(Z)};
  for (let count = 0; count < 3; count++) {
    const solver = newtonSolver(blocks.hessian(Z, Z));
    if (!solver) break;
    const change = blocks.at(solver(blocks.adjoint(Z)), true);
    Z = Z.map((z, k) => symmetrized(combined(1, z, -1, times(times(z, change[k]), z))));
    if (!factored(Z)) break;
    const excluded = reach(Z);
    if (excluded > best.excluded) best = {Z, excluded};
  }
  return best;

  function reach(Z) {
    const value = innerOf(constants, Z), residual = blocks.adjoint(Z);
    return value < 0 ? -value / Math.sqrt(dot(residual, residual)) : 0;
  }
}

// ---------------------------------------------------------- analytic centre
// The x that maximises sum log det G_k from an x inside (section 8.5.3). Where the set is
// unbounded, or the numbers give out on a long way, the last x and `lost`. Newton's method
// with an exact line search (section 9.7.1).
export function centre(blocks, x, enough = 1e-8) {
  let factors = factored(blocks.at(x));
  for (let count = 1; count <= 200; count++) {
    const roots = rootsOf(factors), W = inverses(roots);
    const solver = newtonSolver(blocks.hessian(W, W));
    if (!solver) return {x, lost: true};
    const gradient = blocks.adjoint(W), d = solver(gradient);
    const decrement = Math.sqrt(Math.max(dot(gradient, d), 0));
    let length = 1;
    if (decrement > 0.2) {
      const change = blocks.at(d, true);
      length = lineSearch(ratesOf(roots, change));
    }
    let moved;
    for (;; length /= 2) {
      moved = plus(x, length, d);
      factors = factored(blocks.at(moved));
      if (factors) break;
      if (length < 1e-12) return decrement < 1e-4 ? {x, steps: count} : {x, lost: true};
    }
    x = moved;
    if (decrement < enough) return {x, steps: count};
    if (dot(x, x) > LONGEST_CENTRE ** 2) return {x, lost: true};
    if (count === STEPS_ALONE) {
      const near = nearCentre(blocks, x);
      if (!near) return {x, lost: true};
      x = near;
      factors = factored(blocks.at(x));
    }
  }
  return {x, lost: true};
}

// Eigenvalues of the changes of blocks that these roots scale.
export const ratesOf = (roots, change) =>
  roots.flatMap((N, k) => Array.from(symmetricEigenvalues(whitened(N, change[k]))));

// A point next to the centre, or null: S Z = I and sum <G_ka, Z_k> = 0. Newton's method
// may take hundreds of short steps where such ones, of S and of Z, take some twenty.
function nearCentre(blocks, x) {
  for (const state of interiorSteps(blocks, x, new Float64Array(blocks.size), 1, 1, 100)) {
    const size = Math.sqrt(dot(state.x, state.x));
    if (size > LONGEST_CENTRE) return null;
    if (state.residual * size < 0.1) return state.x;
  }
  return null;
}

// The s that maximises sum log(1 + s r): Newton's method kept within an interval.
function lineSearch(rates) {
  const least = Math.min(...rates), limit = least < 0 ? -1 / least : Infinity;
  let s = Math.min(1, 0.9 * limit), low = 0, high = limit;
  for (let count = 0; count < 30; count++) {
    let first = 0, second = 0;
    for (const r of rates) {
      const ratio = r / (1 + s * r);
      first -= ratio;
      second += ratio * ratio;
    }
    if (Math.abs(first) < 1e-3 * Math.sqrt(second)) break;
    if (first < 0) low = s;
    else high = s;
    s -= first / second;
    if (!(s > low && s < high)) s = isFinite(high) ? (low + high) / 2 : 2 * low;
  }
  return Math.min(s, 0.99 * limit);
}
