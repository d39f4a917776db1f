// A law that sees some of what a plant does, and how far a loop with its gains is proven: in cells, without
// a rounding error.
import {descriptors, meanDescriptor, pairsOf, reach, rounded, sized, stateSpace, withInverses} from "./descriptor.js";
import {poles} from "./design.js";
import {EXACT, exactMatrix, exactScalar, exactTimes, nearly} from "./exact.js";
import {cholesky, combined, FLOATS, identity, inverseLower, mapped, matrix, rowsOf, scaled, times, transposed, zeros} from "./matrices.js";
import {joined} from "./request.js";
import {centre, factored, phaseOne} from "./solver.js";
import {eigenvalues, lyapunov} from "./spectrum.js";
import {truth} from "./truth.js";
import {assembled, unprovenOf} from "./written.js";

const PLACES_OF_P = [10, 14];
const DEEPEST = 16;    // halvings of a cell, whose corners are decimals of few digits
const LARGEST_P = 64;  // times what was found: so far the centre of a cell's P is sought

// The rows that a law multiplies by its gains, on x = [z; z'; integrals; filters]: for its K_D these
// are measured rates, or what a filter hasn't followed yet, which is K_D over the filter's time.
export function readings({position = [], velocity = [], filter = 0, integrate = []}, n) {
  const p = position.length, f = filter ? p : 0, a = integrate.length, N = 2 * n + a + f;
  const rows = zeros(p + f + velocity.length + a, N), {place} = FLOATS;
  place(place(rows, 0, 0, matrix(position, n)), p, 0, matrix(f ? position : [], n));
  place(place(rows, p, 2 * n + a, identity(f, -1)), p + f, n, matrix(velocity, n));
  return place(rows, rows.rows - a, 2 * n, identity(a));
}

// Whether a plant is a box of ranges, or two plants with all between: what can be halved.
const ranges = ({vertices, family}) => family || vertices.length < 3 ? Math.log2(vertices.length) : 0;
export const wholeOf = request =>
  request.family || request.vertices.length < 3 ? [0, 1].map(x => Array(ranges(request)).fill(x)) : null;

// The plants at points of a box between 0 and 1, as means of its corners; without a box all of them.
export function mixtures(request, points, ring) {
  const list = descriptors(request, ring), k = ranges(request);
  if (!points) return list;
  const share = (t, v) => t.reduce((w, x, j) => w * (v >> (k - 1 - j) & 1 ? x : 1 - x), 1);
  return points.map(t => {
    const some = list.map((d, v) => [d, share(t, v)]).filter(([, w]) => w);
    const part = name =>
      some.map(([d, w]) => ring.scaled(w, d[name])).reduce((X, Y) => ring.combined(1, X, 1, Y));
    return Object.fromEntries(["E", "A", "Bu", "Bw", "C"].map(name => [name, part(name)]));
  });
}

/** @type {(cell: any) => any} */
export const corners = ([low, high]) =>
  low.reduce((list, x, j) => list.flatMap(t => [...new Set([x, high[j]])].map(y => [...t, y])), [[]]);

// Units of the states in which the rows of F are as long as its columns.
export function unitsOf(F) {
  const N = F.rows, unit = Array(N).fill(1);
  for (let count = 0; count < 10; count++)
    for (let i = 0; i < N; i++) {
      let row = 0, column = 0;
      for (let j = 0; j < N; j++) {
        if (i === j) continue;
        row += Math.abs(F.at[i * N + j]) * unit[j] / unit[i];
        column += Math.abs(F.at[j * N + i]) * unit[i] / unit[j];
      }
      if (row && column) unit[i] *= Math.sqrt(row / column);
    }
  return unit;
}

// Coordinates in which the motion of a mean loop, a little less damped, is as large everywhere, or in which
// what its motions still cost is.
function frameOfLoop(d, gain, asked) {
  const [F, , Bw] = stateSpace(d), N = F.rows, unit = unitsOf(F);
  if (asked.cost !== undefined) {
    const effort = times(transposed(gain), times(matrix(asked.R), gain));
    const X = lyapunov(F, combined(1, matrix(asked.Q), 1, effort)), L = X && cholesky(X);
    if (L) return framed(transposed(inverseLower(L)));
  }
  const slow = Math.max(...eigenvalues(F).map(([re]) => re)) / 2;
  const P =
    lyapunov(transposed(mapped(F, (x, i, j) => x * unit[j] / unit[i] - (i === j ? slow : 0))), identity(N));
  const T = mapped((P && cholesky(P)) ?? identity(N), (x, i) => x * unit[i]), [key] = sized(asked);
  const omega = Math.max(...eigenvalues(F).map(s => Math.hypot(...s)));
  return framed(scaled(Math.sqrt(reach(asked, T, Bw, omega)[key] ?? 1), T));

  function framed(T) {
    return {...withInverses(mapped(T, x => rounded(x, 6)), d, null), scale: 1, sizes: {}};
  }
}

// {proven, halves} of a cell of the box: whether one P proves there what is asked, in exact arithmetic, for
// the loop with these gains; else its halves, if there are any.
export function cellOf({K, cell, ...request}) {
  const rows = rowsOf(readings(request.law, request.vertices[0].M.length)), points = cell && corners(cell);
  const [gain, exactGain] = [FLOATS, EXACT].map(ring => ring.times(ring.matrix(K), ring.matrix(rows)));
  const closed = (ring, gain) =>
    mixtures(request, points, ring)
      .map(({E, A, Bu, Bw, C}) =>
             ({E, A: ring.combined(1, A, 1, ring.times(Bu, gain)), Bu: ring.zeros(E.rows, K.length), Bw, C}));
  const plain = closed(FLOATS, gain), exactly = closed(EXACT, exactGain), {asked} = request;
  const pairs = pairsOf(exactly, exactly.map((_, k) => k)), middle = meanDescriptor(plain);
  const frame = frameOfLoop(middle, gain, asked), blocks = assembled(plain, pairs, asked, frame, gain);
  // a sector or a disk alone, which needn't be stable
  blocks.list = blocks.list.filter(({name}) => !name.startsWith("stability"));
  const first =
    blocks.unknowns.map(({name, rows, cols}) => [name, rows ? identity(rows, 2) : zeros(rows, cols)]);
  const found = phaseOne(blocks, blocks.packed(Object.fromEntries(first)));
  let proven = false;
  if (found.verdict === "feasible") {
    const part = joined(blocks, LARGEST_P * Math.max(1, ...found.x.map(Math.abs)));
    const {x} = factored(part.at(found.x)) ? centre(part, found.x) : found, [P, , J] = blocks.unpacked(x);
    const own = times(times(frame.T, P), transposed(frame.T));
    proven = PLACES_OF_P.some(digits => {
      const exact = X =>
        exactMatrix(rowsOf(mapped(X, (x, i, j) => rounded(i < j ? x : X.at[j * X.cols + i], digits))));
      return unprovenOf(exactly, pairs, asked, exactGain, exact(own), J && exact(J))
        .every(label => label.startsWith("stability"));
    });
  }
  return {proven, halves: proven ? [] : halvesOf(cell ?? [], point => stateSpace(closedAt(point)))};

  function closedAt(point) {
    const [{E, A, Bu, Bw, C}] = mixtures(request, [point], FLOATS);
    return {E, A: combined(1, A, 1, times(Bu, times(matrix(K), matrix(rows)))), Bu, Bw, C};
  }
}

// Two halves: the parameter is cut that moves the loop most; none of a cell without an end.
function halvesOf([low, high] = [], at = null) {
  if (!low?.length || low.reduce((sum, x, j) => sum - Math.log2(high[j] - x), 0) >= DEEPEST) return [];
  const middle = low.map((x, j) => (x + high[j]) / 2);
  const moved = middle.map((_, j) => {
    const [[X], [Y]] = [low, high].map(end => at(middle.with(j, end[j])));
    return Math.hypot(...combined(1, X, -1, Y).at);
  });
  const k = moved.indexOf(Math.max(...moved));
  return [[low, high.with(k, middle[k])], [low.with(k, middle[k]), high]];
}

// What is true of the loop at all corners, its gain of the whole state, and the law's own: its K_D is a
// product of decimals, so that all three stand for the very loop that is proven.
export function judgedGains({K, ...request}) {
  const {law, vertices: [{M}]} = request, {position = [], filter, integrate = []} = law;
  const rows = readings(law, M.length), gain = rowsOf(times(matrix(K), rows)), p = position.length;
  const list = descriptors(/** @type {any} */ (request)).map(d => poles(d, matrix(gain)));
  const rate = x => filter ? nearly(exactTimes(exactScalar(x), exactScalar(filter))) : x;
  const parts = {
    K_P: K.map(row => row.slice(0, p)),
    K_D: K.map(row => row.slice(p, row.length - integrate.length).map(rate)),
    K_I: K.map(row => row.slice(row.length - integrate.length))
  };
  const gains = Object.fromEntries(Object.entries(parts).filter(([, rows]) => rows[0].length));
  return {gains, K: gain, poles: list, ...truth(request, {K: gain, poles: list})};
}
