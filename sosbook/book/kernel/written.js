// LMIs that a text states: as blocks of a search, and as a proof.
import {FRACTIONS, NUMBERS} from "./arithmetic.js";
import {Blocks} from "./blocks.js";
import {changed} from "./descriptor.js";
import {definite, divisor} from "./exact.js";
import {FLOATS, matrix, times} from "./matrices.js";
import {Reader} from "./reader.js";

const valueOf = X => ({X: {rows: X.rows, cols: X.cols, at: Array.from(X.at)}, terms: []});
const floats = ({rows, cols, at}) => ({rows, cols, at: Float64Array.from(at)});

// The blocks in P and Y of a text with numbers by name, in a frame. Of them x0 is a state and
// u_max is measured as the input is.
export function writtenBlocks(plain, {text, sets, numbers}, frame) {
  const reader = new Reader(NUMBERS), vertices = plain.map(d => changed(d, frame, FLOATS)), {env} = reader;
  const N = vertices[0].E.rows, m = vertices[0].Bu.cols, state = frame.back;
  for (const [name, x] of Object.entries(numbers)) env[name] = reader.known(x);
  if (env.x0) env.x0 = valueOf(times(state, matrix(numbers.x0.map(row => row.map(Number)))));
  if (env.u_max) env.u_max = reader.number(Number(numbers.u_max) / frame.scale);
  vertices.forEach((d, k) => {
    for (const name of ["E", "A", "Bu", "Bw"]) env[`${name}.${k + 1}`] = valueOf(d[name]);
  });
  Object.assign(env, {C: valueOf(vertices[0].C), n: reader.number(vertices[0].C.rows)});
  Object.assign(env, {P: reader.unknown("P", N, N), Y: reader.unknown("Y", m, N)});
  const blocks = new Blocks({P: {rows: N, cols: N, symmetric: true}, Y: {rows: m, cols: N}});
  for (const {name, value} of reader.statements(text, sets, Object.keys(env)))
    if (value.terms.length) blocks.add(name, floats(value.X), halves(reader, value.terms));
  return blocks;
}

// Products whose sum with their mirror images is the symmetric sum of some others: half of
// each. Those with one R are one; for a symmetric X, L X R and R' X L' are one, too.
function halves(reader, terms) {
  const found = new Map();
  for (let {of, flip, L, R} of terms) {
    if (flip) [L, R] = [reader.turned(R), reader.turned(L)];
    L = reader.scaled(0.5, L);
    const turned = `${of} ${reader.turned(L).at.map(x => 2 * x)}`;
    let key = `${of} ${R.at}`;
    if (of === "P" && !found.has(key) && found.has(turned)) {
      [L, R] = [reader.scaled(0.5, reader.turned(R)), reader.scaled(2, reader.turned(L))];
      key = turned;
    }
    found.set(key, [of, found.has(key) ? reader.sum(found.get(key)[1], L) : L, R]);
  }
  return [...found.values()].filter(([, L]) => L.at.some(x => x)).map(([of, L,
    R]) => [of, floats(L), floats(R)]);
}

function readerOf(data) {
  const reader = new Reader(FRACTIONS);
  for (const [name, x] of Object.entries(data)) reader.env[name] = reader.known(x);
  return reader;
}

// The labels of a text's statements whose matrices aren't symmetric, in fractions.
export function unsymmetric(text, sets, data) {
  const reader = readerOf(data);
  return [...reader.statements(text, sets)]
    .filter(({value}) => !reader.equal(value, reader.mirrored(value)))
    .map(({name}) => name);
}

// The labels of those that don't hold for its data.
export function unproven(text, sets, data) {
  const reader = readerOf(data), failed = [];
  for (const {name, mark, value, right} of reader.statements(text, sets)) {
    const same = mark === "==" && reader.equal(value, right);
    if (!same && !(mark === ">" && definite(integers(value.X)))) failed.push(name);
  }
  return failed;
}

// The multiple of a matrix of fractions by their common denominator.
function integers({rows, at}) {
  let over = 1n;
  for (const [, d] of at) over = over / divisor(over, d) * d;
  return {rows, at: at.map(([n, d]) => n * (over / d))};
}
