// LMIs that a text states: as blocks of a search, and as a proof.
import {FRACTIONS, NUMBERS} from "./arithmetic.js";
import {Blocks} from "./blocks.js";
import {changed} from "./descriptor.js";
import {definite, divisor, exactTimes} from "./exact.js";
import {matrix, times} from "./matrices.js";
import {Reader} from "./reader.js";
import {followersOf, ownerOf, requirements, sizeName} from "./request.js";
import {keysOf, stated} from "./text.js";

const valueOf = X => ({X: {rows: X.rows, cols: X.cols, at: X.at}, terms: []});
const fractionsOf = ({places, at, ...X}) => valueOf({...X, at: at.map(x => [x, 10n ** BigInt(places)])});
const setsOf = pairs => ({pairs: pairs.map(pair => pair.map(i => String(i + 1)))});

// The blocks of a request in a frame, affine in P, Y, the sizes and J; where the `gain` is known Y isn't.
export function assembled(plain, pairs, asked, frame, gain = null) {
  if (asked.text) return writtenBlocks(plain, asked, frame);
  const [{E, Bu, Bw, C}] = plain, reader = new Reader(NUMBERS), {env} = reader;
  const followers = followersOf(asked), sized = r => followers.includes(ownerOf(r));
  const sizes = {N: E.rows, m: Bu.cols, p: Bw.cols};
  const said = stated(requirements(asked), sized, true, sizes), called = namesOf(said, pairs, plain);
  for (const [name, x] of Object.entries(said.data)) env[name] = reader.known(x);
  for (const name of ["left", "T", "back"]) env[name] = valueOf(frame[name]);
  plain.forEach((d, k) => vertexOf(env, d, k));
  Object.assign(env, {C: valueOf(C), scale: reader.number(frame.scale)});
  const unit = name => name === "J" ? frame.own
    : name in said.called           ? (frame.sizes[ownerOf(said.called[name])] || 1) ** -2
                                    : 1;
  const unknowns = unknownsOf(reader, said, called, unit);
  if (gain) {
    env.gain = valueOf(times(gain, frame.T));
    env.Y = reader.value(["mul", ["name", "gain"], ["name", "P"]]);
    unknowns.Y.rows = 0;
  }
  const text = [...said.lines.filter(line => !line.includes(".regular:")), ...said.loop].join("\n");
  return blocksOf(unknowns, reader, text, setsOf(pairs), called);
}

// What the blocks of a text are called, by their labels.
function namesOf({blocks, called}, pairs, plain) {
  const keys = keysOf(blocks, pairs);
  return label => {
    if (label in called) return sizeName(ownerOf(called[label]));
    const [, name, block, ...where] = keys.get(label) ?? [, label], many = plain.length > 1 && where.length;
    return (block || name) + (many ? ` ${where.map(i => i + 1).join(",")}` : "");
  };
}

// What is asked at a point, in the plant's own coordinates: a reader, and the text that it reads.
function pointOf(ring, value, plants, pairs, asked, sized, point) {
  const [{E, Bu, Bw, C}] = plants, reader = new Reader(ring), {env} = reader;
  const said = asked.text ? {lines: [asked.text], loop: [], data: asked.numbers, blocks: [], called: {}}
                          : stated(requirements(asked), sized, false, {N: E.rows, m: Bu.cols, p: Bw.cols});
  for (const [name, x] of Object.entries({...said.data, n: C.rows})) env[name] = reader.known(x);
  plants.forEach((d, k) => vertexOf(env, d, k, value));
  for (const [name, X] of Object.entries({C, ...point}))
    if (X) env[name] = value(X);
  return {reader, said, text: [...said.lines, ...said.loop].join("\n"), sets: asked.sets ?? setsOf(pairs)};
}

// The matrices that are stated positive at a point, by the names of their blocks.
export function statedAt(plain, pairs, asked, {P, Y, J, sizes}) {
  const followers = followersOf(asked), sized = r => followers.includes(ownerOf(r));
  const {reader, said, text, sets} = pointOf(NUMBERS, valueOf, plain, pairs, asked, sized, {P, Y, J});
  for (const label in said.called) reader.env[label] = reader.number(sizes[ownerOf(said.called[label])]);
  const called = namesOf(said, pairs, plain), all = reader.statements(text, sets, Object.keys(reader.env));
  return Object.fromEntries([...all].map(({name, value}) => [called(name), value.X]));
}

// The unknowns of a text, P and Y before the others; in the reader each is a multiple of itself.
export function unknownsOf(reader, {unknowns, called}, own = name => name, unit = _ => 1) {
  const shapes = {P: null, Y: null};
  for (const [name, shape] of Object.entries(unknowns)) {
    const [, symmetric, ...size] = /^(symmetric )?(\d+)(?: x (\d+))?$/.exec(shape) ?? [, , "1"];
    const rows = Number(size[0]), cols = Number(size[1] ?? rows);
    shapes[own(name)] = {rows, cols, symmetric: Boolean(symmetric)};
    const value = reader.env[name] = reader.unknown(own(name), rows, cols, name in called);
    if (unit(name) !== 1) value.terms[0].a = unit(name);
  }
  return shapes;
}

function vertexOf(env, d, k, value = valueOf) {
  for (const name of ["E", "A", "Bu", "Bw"]) env[`${name}.${k + 1}`] = value(d[name]);
}

function blocksOf(unknowns, reader, text, sets, called = name => name) {
  const blocks = new Blocks(unknowns);
  for (const {name, constant, terms, slopes} of products(reader, text, sets))
    blocks.add(called(name), constant, terms, slopes);
  return blocks;
}

// The blocks in P and Y of a text with numbers by name, in a frame. Of them x0 is a state and
// u_max is measured as the input is.
function writtenBlocks(plain, {text, sets, numbers}, frame) {
  const reader = new Reader(NUMBERS), vertices = plain.map(d => changed(d, frame)), {env} = reader;
  const N = vertices[0].E.rows, m = vertices[0].Bu.cols;
  for (const [name, x] of Object.entries(numbers)) env[name] = reader.known(x);
  if (env.x0) env.x0 = valueOf(times(frame.back, matrix(numbers.x0.map(row => row.map(Number)))));
  if (env.u_max) env.u_max = reader.number(Number(numbers.u_max) / frame.scale);
  vertices.forEach((d, k) => vertexOf(env, d, k));
  Object.assign(env, {C: valueOf(vertices[0].C), n: reader.number(vertices[0].C.rows)});
  Object.assign(env, {P: reader.unknown("P", N, N), Y: reader.unknown("Y", m, N)});
  return blocksOf({P: {rows: N, cols: N, symmetric: true}, Y: {rows: m, cols: N}}, reader, text, sets);
}

// What a text states of unknowns: a name, a constant, products [unknown, L, R] whose sum with their
// mirror images is the rest, and slopes of numbers. What is in the reader isn't defined again.
export function* products(reader, text, sets) {
  for (const {name, value} of reader.statements(text, sets, Object.keys(reader.env))) {
    const some = value.terms.filter(({scalar}) => !scalar), slopes = new Map();
    for (const {of, a, L, R} of value.terms.filter(({scalar}) => scalar)) {
      const G = reader.scaled(a, reader.product(L, R));
      slopes.set(of, slopes.has(of) ? reader.sum(slopes.get(of), G) : G);
    }
    if (value.terms.length) yield {name, constant: value.X, terms: halves(reader, some), slopes: [...slopes]};
  }
}

// Products whose sum with their mirror images is the symmetric sum of some others: half of
// each. Those with one R are one; for a symmetric X, L X R and R' X L' are one, too.
function halves(reader, terms) {
  const {over, none, of: number} = reader.ring, half = over(number("2")), found = [], rights = [];
  const same = (X, Y) => X.cols === Y.cols && X.at.every((x, k) => reader.ring.same(x, Y.at[k]));
  for (let {of, flip, a, L, R} of terms) {
    if (L.at.every(none) || R.at.every(none)) continue;
    if (flip) [L, R] = [reader.turned(R), reader.turned(L)];
    let known = found.find(([name, , X]) => name === of && same(X, R));
    if (!known && of !== "Y") {
      const turned = reader.turned(L);
      known = found.find(([name, , X]) => name === of && same(X, turned));
      if (known) L = reader.turned(R);
    }
    L = reader.scaled(reader.ring.times(half, a), L);
    if (known) known[1] = reader.sum(known[1], L);
    else {
      const right = rights.find(X => same(X, R)) ?? R;  // one for several unknowns
      if (right === R) rights.push(R);
      found.push([of, L, right]);
    }
  }
  return found.filter(([, L]) => !L.at.every(none));
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
export const unproven = (text, sets, data) => failedOf(readerOf(data), text, sets);

function failedOf(reader, text, sets, given = []) {
  const failed = [];
  for (const {name, mark, value, right} of reader.statements(text, sets, given)) {
    const same = mark === "==" && reader.equal(value, right);
    if (!same && !(mark === ">" && definite(integers(value.X)))) failed.push(name);
  }
  return failed;
}

// The same of an exact P and J and what is asked of closed loops, exact descriptors, with this gain.
export function unprovenOf(exactly, pairs, asked, gain, P, J) {
  const point = {P, Y: exactTimes(gain, P), J}, none = () => false;
  const {reader, text, sets} = pointOf(FRACTIONS, fractionsOf, exactly, pairs, asked, none, point);
  return failedOf(reader, text, sets, Object.keys(reader.env));
}

// The multiple of a matrix of fractions by their common denominator.
function integers({rows, at}) {
  let over = 1n;
  for (const [, d] of at) over = over / divisor(over, d) * d;
  return {rows, at: at.map(([n, d]) => n * (over / d))};
}
