// From a plant and what is asked of it to gains, or to why there are none.
import {coupledPairs, descriptors, frameOf, meanDescriptor, rounded, sized, stateSpace, withInverses} from "./descriptor.js";
import {cholesky, combined, identity, inverse, mapped, norm, rowsOf, scaled, solve, symmetricEigenvalues, symmetrized, times, transposed, zeros} from "./matrices.js";
import {refusalOf} from "./refusal.js";
import {conditionOf, joined, scalarsOf} from "./request.js";
import {centre, factored, inverses, newtonSolver, phaseOne, plus, ratesOf, rootsOf} from "./solver.js";
import {eigenvalues} from "./spectrum.js";
import {assembled, statedAt} from "./written.js";

const MARGIN_IN_FLOATS = 1e-9;  // a smaller one is no proof in floats
const RETRIES = 2;              // in closer frames, where nothing is decided
const LARGEST_UNKNOWN = 1e3;    // beyond it unknowns are measured in a bad unit
const NO_COMMON_P =
  " There is no common P in this form of the rows; the package goes on with one for each vertex.";
const FLOATS_ALONE =
  "Multipliers exclude every solution of these LMIs in floating point, and no exact ones were found.";

// {status, K, P, sizes, margins, poles, scale, ...}; `start` is an earlier result of a
// plant of the same shape: faster, the answer is the same. "infeasible" is proven in exact
// arithmetic, unless `hasty`.
export function design(request, start = null, hasty = false) {
  const {asked} = request, plain = descriptors(request), pairs = coupledPairs(request);
  const empty = asked.rho !== undefined && asked.sigma !== undefined && asked.rho <= asked.sigma;
  if (empty) return {status: "infeasible", reason: "The region is empty.", steps: [0, 0]};
  let frame = frameOf(plain, asked), blocks = assembled(plain, pairs, asked, frame);
  let found = null;
  if (start && start.status === "feasible") {
    const near = inFrame(blocks, frame, start);
    if (near && factored(blocks.at(near))) found = {verdict: "feasible", x: near, steps: 0};
  }
  found ??= phaseOne(blocks, guess(blocks, frame));
  for (let count = 0; count < RETRIES && found.verdict === "undecided" && found.last; count++) {
    const closer = around(plain, frame, blocks, found.last);
    if (!closer) break;
    frame = closer;
    blocks = assembled(plain, pairs, asked, frame);
    found = phaseOne(blocks, guess(blocks, frame));
  }
  if (found.verdict !== "feasible") {
    const refusal = found.verdict === "infeasible" && !hasty && !asked.text
      ? refusalOf(request, frame, blocks, found.Z)
      : null;
    const reason = refusal ? `Exact multipliers of the LMIs exclude every solution${conditionOf(asked)}.${
                               pairs.length > 1 ? NO_COMMON_P : ""}`
      : found.verdict === "undecided" ? "Neither a design nor a proof that there is none was found."
                                      : FLOATS_ALONE;
    const refused = refusal || (hasty && found.verdict === "infeasible");
    const more = refusal ? {refusal} : {};
    return {status: refused ? "infeasible" : "undecided", ...more, steps: [found.steps, 0], reason};
  }
  let at = {frame, blocks, x: found.x};
  if (blocks.unknowns.length > 2 && Math.max(...Array.from(found.x, Math.abs)) > LARGEST_UNKNOWN)
    at = nearer(plain, pairs, asked, at) ?? at;
  return finished(plain, pairs, asked, anyCentre(plain, pairs, asked, at), found.steps);
}

function guess(blocks, frame) {
  if (!frame.gain) return null;
  const values = {P: identity(frame.T.rows), Y: frame.gain};
  for (const {name, rows} of blocks.unknowns.slice(2)) values[name] = identity(rows, name === "J" ? 2 : 1);
  return blocks.packed(values);
}

// {frame, blocks, x, bounded, steps}: the centre, if need be in a frame of its own; where there
// is none, that of a part so large that the gain settles, if anything bounds the gain.
function anyCentre(plain, pairs, asked, start) {
  const small = () => ({...start, steps: 0, bounded: true, ...centreBelow(start.blocks, start.x, 16)});
  if (start.blocks.homogeneous || gainsRunOff(plain, start)) return small();
  let at = start, part = null;
  for (let count = 0; at && count < 2; count++) {
    const found = centre(at.blocks, at.x);
    if (!found.lost) return {...at, ...found, bounded: false};
    at = nearer(plain, pairs, asked, {...at, ...found});
  }
  for (const r of [16 ** 4, 16 ** 6]) {  // floats lose larger bounds
    const next = centreBelow(start.blocks, part ? part.x : start.x, r);
    if (!next || finished(plain, pairs, asked, {...start, ...next}).status !== "feasible") break;
    part = next;
    if (settles(start.blocks, part.x, r)) break;
  }
  return part ? {...start, ...part, bounded: true} : small();
}

// The centre of the part with P below r I, or of a larger one; null if it is lost.
function centreBelow(blocks, x, r) {
  for (; r < 1e16; r *= 16) {
    const part = joined(blocks, r), inside = factored(part.at(x)) ? x : phaseOne(part).x;
    if (!inside) continue;
    const {lost, ...found} = centre(part, inside);
    return lost ? null : found;
  }
  return null;
}

// Whether the gain may grow against the input forever while P stays.
function gainsRunOff(plain, {frame, blocks, x}) {
  const [, B] = stateSpace(meanDescriptor(plain)), push = scaled(-frame.scale, solve(frame.T, B));
  const zero = Object.fromEntries(blocks.unknowns.map(({name, rows, cols}) => [name, zeros(rows, cols)]));
  const change = blocks.at(blocks.packed({...zero, Y: transposed(push)}), true);
  const factors = factored(blocks.at(x));
  if (!factors) return false;
  const rates = ratesOf(rootsOf(factors), change);
  return Math.min(...rates) > -1e-10 * Math.max(...rates);
}

// Whether a centre x with P below r I has hardly another gain with a larger r, by one Newton
// step: less than a thousandth, or a ten thousandth of the Riccati equation's.
function settles(blocks, x, r) {
  const part = joined(blocks, 1.01 * r), factors = factored(part.at(x));
  if (!factors) return false;  // rounding puts x outside
  const W = inverses(rootsOf(factors));
  const gain = y => {
    const [P, Y] = blocks.unpacked(y);
    return times(Y, inverse(P));
  };
  const here = gain(x), there = gain(plus(x, 1, newtonSolver(part.hessian(W, W))(part.adjoint(W))));
  const largest = K => Math.max(...K.at.map(Math.abs));
  return largest(combined(1, there, -1, here)) <= 1e-5 * Math.max(largest(here), 0.1);
}

// The same point and blocks in a frame in which P is the identity and the sizes are one; or null.
function nearer(plain, pairs, asked, {frame, blocks, x}) {
  const closer = around(plain, frame, blocks, x, 0);
  const there = closer && assembled(plain, pairs, asked, closer);
  const moved = there && inFrame(there, closer, inPlantUnits(frame, blocks, x));
  return moved && factored(there.at(moved)) ? {frame: closer, blocks: there, x: moved} : null;
}

// A point of another frame, in this one.
function inFrame(blocks, frame, {P, Y, J, sizes}) {
  if (P.rows !== frame.T.rows || Y.rows !== blocks.unknowns[1].rows) return null;
  const back = inverse(frame.T), right = transposed(back);
  const values = {P: times(times(back, P), right), Y: scaled(1 / frame.scale, times(Y, right))};
  const own = blocks.unknowns.find(({name}) => name === "J");
  if (own && J?.rows !== own.rows) return null;
  if (own) values.J = scaled((sizes.cost || 1) / frame.own, J);
  for (const {name} of scalarsOf(blocks)) {
    const owner = name.replace("size for ", "");
    if (!(sizes[owner] > 0)) return null;
    values[name] = identity(1, sizes[owner] * (frame.sizes[owner] || 1) ** 2);
  }
  return blocks.packed(values);
}

// Coordinates in which the P of a point is the identity, and the sizes are one.
function around(plain, frame, blocks, x, thinnest = 1e-6) {
  const [P, Y] = blocks.unpacked(x), values = symmetricEigenvalues(P), n = P.rows;
  const lift = Math.max(0, thinnest * values[n - 1] - values[0]);
  const L = values[n - 1] > 0 && cholesky(combined(1, P, 1, identity(n, lift)));
  if (!L) return null;
  const T = mapped(times(frame.T, L), v => rounded(v, 6));
  if (!inverse(T)) return null;
  const K = times(Y, inverse(times(L, transposed(L))));
  const scale = frame.scale * (norm(times(K, L)) || 1), sizes = {...frame.sizes};
  scalarsOf(blocks).forEach(({name, from}) => {
    const owner = name.replace("size for ", ""), s = x[from];
    if (s > 0) sizes[owner] = rounded((frame.sizes[owner] || 1) / Math.sqrt(s), 2);
  });
  const turned = withInverses(T, meanDescriptor(plain), frame.noise);
  turned.own = rounded(turned.own / (sizes.cost || 1) ** 4, 2);  // J is multiplied by the size
  return {...frame, sizes, ...turned, scale, gain: scaled(frame.scale / scale, times(K, L))};
}

// K, P, Y, J and the sizes of a point, in the plant's units.
function inPlantUnits(frame, blocks, x) {
  const [P0, Y0, ...rest] = blocks.unpacked(x), T = frame.T, sizes = {};
  const own = blocks.unknowns.findIndex(({name}) => name === "J");
  const P = symmetrized(times(times(T, P0), transposed(T)));
  const K = scaled(frame.scale, transposed(solve(transposed(T), transposed(times(Y0, inverse(P0))))));
  scalarsOf(blocks).forEach(({name, from}) => {
    const owner = name.replace("size for ", "");
    sizes[owner] = x[from] / (frame.sizes[owner] || 1) ** 2;
  });
  const J = own < 0 ? null : scaled(frame.own / (sizes.cost || 1), rest[own - 2]);
  return {K, P, Y: times(K, P), J, sizes};
}

// What is known of a point: in the plant's units, with margins and poles.
function finished(plain, pairs, asked, {frame, blocks, x, bounded, steps}, searched) {
  const point = inPlantUnits(frame, blocks, x), margins = marginsOf(plain, pairs, asked, point, blocks);
  const {K, P, sizes} = point;
  const good = Math.min(...Object.values(margins)) > MARGIN_IN_FLOATS,
        naturalP = scaled(1 / (sizes[sized(asked).pop()] || 1), P);
  const said = good ? {status: "feasible", reason: ""}
                    : {status: "undecided", reason: "The margins are too small for floating point."};
  const more = {naturalP, poles: plain.map(d => poles(d, K)), steps: [searched, steps]};
  return {...point, ...said, K: rowsOf(K), margins, bounded, frame, ...more};
}

// The smallest eigenvalue of each block, its diagonal scaled to one, in the plant's own
// coordinates: what phase one and the centre say isn't believed.
function marginsOf(plain, pairs, asked, point, blocks) {
  const known = statedAt(plain, pairs, asked, point);
  return Object.fromEntries(blocks.list.map(({name}) => [name, margin(symmetrized(known[name]))]));
}

function margin(G) {
  const d = Array.from({length: G.rows}, (_, i) => G.at[i * G.rows + i]), least = Math.min(...d);
  if (!(least > 0)) return least;
  return symmetricEigenvalues(mapped(G, (x, i, j) => x / Math.sqrt(d[i] * d[j])))[0];
}

export function poles({E, A, Bu}, K) { return eigenvalues(solve(E, combined(1, A, 1, times(Bu, K)))); }
