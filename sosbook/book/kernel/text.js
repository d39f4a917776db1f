// Proof files: the text that the package's checker writes for what a page can ask, to the
// letter, and its data. Its lines are those of texts.json, which the checker wrote.
import TEXTS from "../../book/kernel/texts.json" with {type : "json"};

import {coupledPairs} from "./descriptor.js";
import {decimals, ratio, sha256, weightFactors} from "./exact.js";

// What requirements state for {N, m, p} states, inputs and disturbances, the one that implies
// stability first: lines, those of a pair of vertices, data, what is asked by their names,
// unknowns, whose the sizes are, and {key, label} of blocks. Those that are `sized` have a size of
// their own; what is `framed` is in coordinates, and has no gain.
export function stated(requirements, sized, framed, sizes) {
  const fill = (x, k = 0) =>
    JSON.parse(JSON.stringify(x).replace(/#|\{(\w)\}/g, (_, size) => String(size ? sizes[size] : k)));
  const part = (r, k) => {
    const place = TEXTS.parts.findIndex(({of}) => Object.entries(of).every(([key, x]) => r[key] === x));
    const {sure, texts} = TEXTS.parts[place];
    return {r, k, place, sure, ...fill(texts[Number(framed)][Number(sized(r))], k + 1)};
  };
  const parts = requirements.map(part), frame = fill(TEXTS.frames[Number(framed)]);
  const first =
    parts.find(({r, sure}) => sure && !(r.sigma < 0)) ?? part({kind: "stability", name: "stability"}, -1);
  const own = parts.filter(({r}) => sized(r)).sort((a, b) => a.place - b.place);
  const data = {}, asks = requirements.map(r => ({...r})), once = [], each = [];
  const keep = ({r, k}, {lines, given}) => {
    for (const [field, name] of Object.entries(given)) {
      put(data, name.slice(1), name[0] === "|" ? r[field].map(x => [x]) : r[field]);
      asks[k][field] = name;
    }
    return lines;
  };
  const lines = [...frame.first, ...own.map(({positive}) => positive), ...frame.then];
  const called = Object.fromEntries(own.map(({r, size}) => [size, r]));
  const unknowns = {...Object.fromEntries(own.map(({size}) => [size, "number"])), ...frame.unknowns};
  const blocks = [{key: ["", "", "P"], label: "P"}];
  for (const {r, size} of own) blocks.push({key: [r.kind, r.name, sizeOf(r)], label: size});
  for (const part of parts) lines.push(...keep(part, part.numbers));
  for (const part of [first, ...parts.filter(part => part !== first)]) {
    const {kind, name, Q} = part.r;
    lines.push(...keep(part, part.more));
    if (Q) factors(Q.map(row => row.map(Number)), data);
    Object.assign(unknowns, part.unknowns);
    for (const [where, block, line] of part.blocks) {
      (where === "pair" ? each : once).push(line);
      blocks.push({key: [kind, name, block], label: line.split(":")[0]});
    }
  }
  lines.push(...once);
  const loop = ["for i, j in pairs:", ...[...frame.pairs, ...each].map(line => "  " + line)];
  return {lines, loop, data, asks, unknowns, called, blocks};
}

function put(data, name, x, width = 0) {
  const empty = Array.isArray(x) && !(x.length && x[0].length);
  data[name] = empty ? {zeros: [x.length, x.length ? 0 : width]} : x;
  return "=" + name;
}

// L and W with Q = L inv(W) L' and W diagonal, in fractions, become data.
function factors(Q, data) {
  const {L, W, d} = weightFactors(Q), N = L.rows, n = L.cols, unit = k => d.at[k * n + k];
  const table = (rows, value) =>
    Array.from({length: rows}, (_, i) => Array.from({length: n}, (_, k) => value(i, k)));
  put(data, "L", table(N, (i, k) => ratio(L.at[i * n + k], unit(k))));
  put(data, "Wq", table(n, (i, k) => i === k ? ratio(W.at[i * n + k], unit(k) ** 2n) : "0"));
}

// What the file calls the size of a requirement's P.
export const sizeOf = ({kind, name}) => ["size for", ...new Set([kind, name])].join(" ");

// The file of a kind of proof: what a request asks, as the requirements of a file, and K with
// the `unknowns`, or coordinates, with the multipliers of blocks once there are some.
export function fileOf(
  kind, request, requirements, {K = null, unknowns = null, coordinates = null, sizes = []}) {
  const {vertices, U = [], K_A = null, coupling = "pairs"} = request, [first] = vertices;
  const plant = {
    kind: "second order",
    vertices: vertices.map(v => Object.fromEntries(["M", "D", "S", "B", "F"].map(
                             name => [name, v[name] ? decimals(v[name]) : v.M.map(() => [])])))
  };
  const data = {}, keep = (name, x) => put(data, name, x);
  const asks = {
    plant: {
      kind: plant.kind,
      vertices: plant.vertices.map((v, k) => Object.fromEntries(Object.entries(v).map(
                                     ([name, x]) => [name, keep(`${name}.${k + 1}`, x)])))
    },
    U: U.length ? keep("U", decimals(U)) : [],
    K_A: K_A && keep("K_A", decimals(K_A)),
    coupling,
    epsilon: null,
    E0: null
  };
  const frame = coordinates &&
    Object.fromEntries(
      Object.entries(coordinates).map(([name, x]) => [name, name === "sizes" ? x : keep(name, x)]));
  const gain = K && keep("K", K), N = 2 * first.M.length + U.length;
  const m = first.B[0].length, p = first.F?.[0].length;
  const sized = unknowns ? Object.keys(unknowns) : sizes;
  const said = stated(requirements, r => sized.includes(sizeOf(r)), frame !== null, {N, m, p});
  Object.assign(data, said.data);
  const pairs = coupledPairs(request), about = {plant, U: decimals(U), K_A: K_A && decimals(K_A), K};
  for (const {x0} of requirements)
    if (x0) about.x0 = x0;
  const keyOf = name => name in said.called ? sizeOf(said.called[name]) : name;
  const point = unknowns &&
    Object.fromEntries(Object.keys(said.unknowns)
        .map(name => [name, name in said.called ? unknowns[keyOf(name)][0][0] : unknowns[name]]));
  const names = Object.fromEntries(
    Object.keys(said.unknowns).map(name => [keyOf(name), (name in said.called ? "#" : "=") + name]));
  const more = unknowns ? {unknowns: Object.fromEntries(Object.keys(unknowns).map(key => [key, names[key]]))}
                        : {coordinates: frame};
  const file = {
    format: "sosbook proof",
    version: 2,
    kind,
    about: Object.fromEntries(
      Object.entries(about).filter(([, x]) => x && (x === plant || x.length)).map(([name,
        x]) => [name, sha256(JSON.stringify(sortedKeys(x))).slice(0, 12)])),
    asks: {...asks, requirements: said.asks, K: gain, ...more},
    text:
      [...TEXTS.plant[[U.length ? "U" : "", K_A ? "K_A" : ""].join(" ").trim()], ...said.lines, ...said.loop],
    data,
    sets: {
      vertices: vertices.map((_, i) => [String(i + 1)]),
      pairs: pairs.map(pair => pair.map(i => String(i + 1)))
    },
    unknowns: said.unknowns,
    ...point && { point }
  };
  return {file, keys: keysOf(said.blocks, pairs), said};
}

// The keys of blocks by their labels.
export const keysOf = (blocks, pairs) => new Map(blocks.flatMap(({key, label}) => label.endsWith(".i.j")
    ? pairs.map(([i, j]) => [label.replace(".i.j", `.${i + 1}.${j + 1}`), [...key, ...new Set([i, j])]])
    : [[label, key]]));

// JSON with what is named on a line of its own.
export function spread(whole) {
  const named = ([key, x]) => `${JSON.stringify(key)}:${JSON.stringify(x)}`;
  const lines = Object.entries(whole).map(([key, x]) => {
    const inner = Array.isArray(x) ? `[\n${x.map(y => JSON.stringify(y)).join(",\n")}]`
      : typeof x === "object" && Object.keys(x).length ? `{\n${Object.entries(x).map(named).join(",\n")}}`
                                                       : JSON.stringify(x);
    return `${JSON.stringify(key)}:${inner}`;
  });
  return `{${lines.join(",\n")}}\n`;
}

function sortedKeys(x) {
  if (Array.isArray(x)) return x.map(sortedKeys);
  if (x === null || typeof x !== "object") return x;
  return Object.fromEntries(Object.keys(x).sort().map(key => [key, sortedKeys(x[key])]));
}
