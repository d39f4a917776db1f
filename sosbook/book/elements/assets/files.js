// Matrices in files that a page can read, under the names that the package's `load_plant` knows.
import {Fault, refuse} from "./checks.js";
import {number} from "./kit.js";
import {make} from "./linalg.js";
import {opened} from "./outputs.js";

const MOST = 60;  // rows and columns of a matrix that stands in a field
const NAMES = ["M", "D", "S", "B", "F"], PENALTY = 1e30;  // as in the package's plants/files.py
const MOST_BYTES = 200_000_000;                           // as in the package's runtime/reading.py
const WIDEST = 8 * MOST * MOST;                           // bytes of what such a matrix has in a file
// MATLAB's numbers for kinds of numbers, for what holds them, and a bit of a complex one.
const KINDS = [, "Int8", "Uint8", "Int16", "Uint16", "Int32", "Uint32", "Float32", , "Float64"];
KINDS[12] = "BigInt64";
KINDS[13] = "BigUint64";
const MATRIX = 14, PACKED = 15, SPARSE = 5, DOUBLE = 6, LAST = 15, COMPLEX = 0x800;

const text = bytes => new TextDecoder().decode(bytes).replace(/^\ufeff/, "");
// A number that a reader wrote as a word; NaN for none. What no float is near is refused.
function near(word) {
  const x = number(word);
  if (Math.abs(x) === Infinity) refuse(`${word} is too large: choose other units`);
  if (x === 0 && /[1-9]/.test(word.split(/e/i)[0]))
    refuse(`${word} is too small: write 0, or choose other units`);
  return x;
}

// The entry of a sparse matrix, which one program adds and another overwrites.
function once(places, shift = 0) {
  const seen = new Set();
  for (const [i, j] of places) {
    if (seen.has(`${i} ${j}`)) refuse(`the entry in row ${i + shift}, column ${j + shift} is there twice`);
    seen.add(`${i} ${j}`);
  }
}

const viewOf = bytes => new DataView(bytes.buffer, bytes.byteOffset, bytes.length);

// The numbers of each line that counts.
const table = (bytes, comment = /#.*/, between = undefined) =>
  text(bytes)
    .split(/\r?\n/)
    .flatMap((line, k) => {
      const words = line.replace(comment, "").trim(), part = between ?? /[;,]/.exec(words)?.[0] ?? /\s+/;
      return words && [words.split(part).map(word => {
        const x = near(word.trim());
        return Number.isNaN(x)
          ? refuse(`line ${k + 1}: "${word.trim()}" is no number; write 0.5 with a point`)
          : x;
      })];
    })
    .filter(row => row);

function sized(rows, columns, entry = (_i, _j) => 0) {
  if (Math.max(rows, columns) > MOST)
    refuse(`it is ${rows} x ${columns}, and a field has ${MOST} rows and columns at most: reduce the plant ` +
      "in the package, by plant.reduce(modes=...)");
  return make(rows, columns, entry);
}

// A matrix of Matrix Market; of Abaqus the entries by "node,dof node,dof".
function mtx(bytes) {
  const [head, , form, field, kind] = text(bytes).split(/\s+/, 5).map(word => word.toLowerCase());
  if (head !== "%%matrixmarket") return entries(table(bytes, /^\*.*/, ","));
  if (!/^(real|integer)$/.test(field)) refuse(`its numbers are ${field}`);
  const [[rows, columns, count], ...list] = table(bytes, /^%.*/, /\s+/), X = sized(rows, columns);
  const below = kind === "general" ? -rows - columns : Number(kind === "skew-symmetric");
  const places = form === "array"
    ? X[0].flatMap((_, j) => X.map((_, i) => [i, j])).filter(([i, j]) => i - j >= below)
    : list.map(([i, j]) => [i - 1, j - 1]);
  if (list.length !== (count ?? places.length) || !places.every(([i, j]) => X[i]?.[j] === 0))
    refuse("its entries aren't those that its head promises");
  const mirrored = below < 0 ? [] : places.filter(([i, j]) => i !== j).map(([i, j]) => [j, i]);
  once([...places, ...mirrored], 1);
  places.forEach(([i, j], k) => {
    X[i][j] = list[k].at(-1);
    if (below >= 0) X[j][i] = below && i !== j ? -X[i][j] : X[i][j];
  });
  return X;
}

function entries(list) {
  if (list.some(row => row.length !== 5))
    refuse('its lines are neither "node, dof, node, dof, value" of Abaqus nor is the first %%MatrixMarket');
  const found = new Map(list.map(row => [`${row.slice(0, 2)} ${row.slice(2, 4)}`, row[4]]));
  if (found.size < list.length) refuse("an entry is there twice");
  const mirror = key => key.split(" ").reverse().join(" "), keys = [...found.keys()];
  if (!keys.some(key => key !== mirror(key) && found.has(mirror(key))))
    for (const key of keys) found.set(mirror(key), found.get(key));
  return found;
}

// Of Abaqus's matrices one row for each degree of freedom of all nodes, sorted.
function assembled(matrices) {
  const tables = Object.values(matrices).filter(X => X instanceof Map);
  const dofs = [...new Set(tables.flatMap(X => [...X.keys()].map(key => key.split(" ")[0])))];
  const order = dof => dof.split(",").reduce((sum, x) => 1000 * sum + Number(x), 0);  // a node has few
  dofs.sort((a, b) => order(a) - order(b));
  for (const [name, X] of Object.entries(matrices))
    if (X instanceof Map)
      matrices[name] = sized(dofs.length, dofs.length, (i, j) => X.get(`${dofs[i]} ${dofs[j]}`) ?? 0);
  return matrices;
}

// The parts of a file of MATLAB, as [kind, bytes].
function parts(bytes) {
  const view = viewOf(bytes), found = [];
  for (let at = 0; at + 8 <= bytes.length;) {
    const word = view.getUint32(at, true), short = word >>> 16, size = short || view.getUint32(at + 4, true);
    const from = at + (short ? 4 : 8);
    found.push([word & 0xffff, bytes.subarray(from, from + size)]);
    at = short ? at + 8 : from + (word === PACKED ? size : 8 * Math.ceil(size / 8));
  }
  return found;
}
const list = ([kind, bytes]) => {
  const view = viewOf(bytes), name = KINDS[kind] ?? "Uint8", wide = parseInt(name.match(/\d+/)[0]) / 8;
  return Array.from({length: bytes.length / wide}, (_, k) => Number(view[`get${name}`](k * wide, true)));
};
async function unpacked(bytes, budget) {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  const found = [];
  for (let part; !(part = await reader.read()).done; found.push(part.value)) {
    budget.left -= part.value.length;
    if (budget.left < 0) refuse(`it unpacks to more than ${MOST_BYTES} bytes`);
  }
  return new Uint8Array(await new Blob(found).arrayBuffer());
}

// The matrices in a file of MATLAB's versions 5 to 7.
async function mat(bytes) {
  const found = Object.create(null), budget = {left: MOST_BYTES};
  if (text(bytes.subarray(126, 128)) !== "IM")
    refuse("it is no file of MATLAB's versions 5 to 7: save with '-v7'");
  for (const part of parts(bytes.subarray(128))) {
    const [kind, inner] = part[0] === PACKED ? parts(await unpacked(part[1], budget))[0] : part;
    if (kind !== MATRIX) continue;
    const pieces = parts(inner), [[flags], [rows, columns], letters] = pieces.slice(0, 3).map(list);
    const type = flags & 0xff, name = String.fromCharCode(...letters);
    if (type !== SPARSE && (type < DOUBLE || type > LAST)) {
      found[name] = undefined;
      continue;
    }
    if (flags & COMPLEX) refuse(`${name} is complex`);
    const X = found[name] = sized(rows, columns);
    if (pieces.slice(3).some(([, {length}]) => length > 2 * WIDEST)) refuse(`${name} has too many entries`);
    const [values, starts, entries] = pieces.slice(3).map(list), places = [];
    for (let j = 0; j < columns; j++)
      for (let k = type === SPARSE ? starts[j] : j * rows;
        k < (type === SPARSE ? starts[j + 1] : (j + 1) * rows); k++) {
        places.push([type === SPARSE ? values[k] : k - j * rows, j]);
        X[places.at(-1)[0]][j] = (type === SPARSE ? entries : values)[k];
      }
    once(places, 1);
  }
  return found;
}

// The line that makes what a page reads of what the package reads, which a page can't look into.
function byPackage(name, kind) {
  if (!["npz", "h5", "op4"].includes(kind)) return "Open .json, .mat, .mtx, .csv or .txt";
  const safe = /^[\w. -]+$/.test(name) ? name : "YOUR_FILE";
  return `If it holds M, D, S and B, the package makes a plant.json of it: python -c "import json, ` +
    `sosbook.plants as p; v = p.load_plant('${
      safe}'); json.dump({k: getattr(v, k).tolist() for k in 'MDSBF'}, open('plant.json', ` +
    `'w'))"`;
}

// The matrices of the fields among those that are there: K and C may be S and D. `left` are others.
function chosen(given) {
  const known = [...NAMES, "K", "C", "A"], large = known.some(name => name in given);
  const there = Object.create(null);
  for (const [name, X] of Object.entries(given)) there[large ? name : name.toUpperCase()] = X;
  const {M, D, S, K, C} = there;
  if (M && K && C && D && !S) refuse("beside K, is C or D the damping? Leave one of them out");
  const square = X => M && X?.length === M.length && X[0].length === M.length ? X : undefined;
  const all = {...there, D: D ?? square(C), S: S ?? square(K)};
  if (large && "f" in there && !("F" in there)) refuse("f isn't read: call it F");
  const lacking = NAMES.filter(name => !all[name] && name !== "F");
  const listed = Object.keys(given).join(", ").slice(0, 200) || "nothing";
  const more = lacking.includes("B") && lacking.length < 4
    ? ". Add B, a column for each actuator with ones in the rows that it pushes"
    : "";
  if (lacking.length)
    refuse(`${lacking.join(", ")} is missing; ${listed} is there: use these letters${more}`);
  for (const name of ["M", "D", "S"]) {
    const held = all[name].flatMap((row, i) => Math.abs(row[i]) >= PENALTY ? [i] : []);
    if (held.length)
      refuse(`${name} has penalties on its diagonal instead of supports: leave out rows and columns ${
        held.map(i => i + 1).join(", ")}`);
  }
  const used = [...NAMES, ...(D ? [] : ["C"]), ...(S ? [] : ["K"])];
  const left = Object.keys(given).filter(name => !used.includes(large ? name : name.toUpperCase()));
  return [
    Object.fromEntries(NAMES.filter(name => all[name]?.[0].length).map(name => [name, all[name]])), left
  ];
}

// What JSON holds: no key comes twice, and each number is near a float.
function json(bytes) {
  const words = text(bytes), content = JSON.parse(words), open = [];
  const tokens = words.match(/"(?:[^"\\]|\\.)*"|[{}[\]:,]|[^\s{}[\]:,"]+/g);
  tokens.forEach((token, k) => {
    if (token === "{" || token === "[") open.push(new Set());
    if (token === "}" || token === "]") open.pop();
    if (token[0] !== '"') {
      if (/[-\d]/.test(token[0])) near(token);
    } else if (tokens[k + 1] === ":") {
      const key = JSON.parse(token);
      if (open.at(-1).has(key)) refuse(`the key '${key}' comes twice`);
      open.at(-1).add(key);
    }
  });
  return plain(content);
}

// Plain data, where each plant in it has the keys that the package knows.
function plain(data) {
  const plant = data?.plant ?? data;
  if (Object(plant) !== plant || "file" in plant) return data;
  const several = plant.vertices ?? [plant];
  if (plant.vertices && (!Array.isArray(several) || Object.keys(plant).length > 1))
    refuse("vertices must be a list, and the only key");
  for (const v of several) {
    const strange = Object.keys(v).filter(key => ![...NAMES, "coordinates", "parameters"].includes(key));
    const also = {K: "S", C: "D"},
          faults = ["M", "D", "S", "B"].flatMap(key => key in v ? [] : [`${key} is missing`]);
    for (const key of strange)
      faults.push(`'${key}' isn't known${also[key] in v || !also[key] ? "" : `, call it ${also[key]}`}`);
    if (faults.length)
      refuse(`a plant has M, D, S, B, and perhaps F and coordinates, and what is asked stands beside a key ` +
        `"plant" for them: ${faults.join("; ")}`);
    if (Boolean(v.F?.[0]?.length) !== Boolean(several[0].F?.[0]?.length))
      refuse("vertices differ in size: F is in some of them alone");
  }
  return data;
}

const READERS = {
  json,
  csv: table,
  txt: table,
  mtx,
  mat
};

// What a Fault of some file says begins with its name.
async function blamed(name, act) {
  try {
    return await act();
  } catch (error) {
    return refuse(`${name}: ${error instanceof Fault ? error.message : "it can't be read as such a file"}`);
  }
}

// What files that are chosen at once hold for an address: one in JSON, or matrices by name.
export const read = async files => {
  const found = Object.create(null), [{name: first}] = files;
  for (const file of files) {
    const {name} = file, [, stem, end] = /^(.*)\.(\w+)$/.exec(name) ?? [, name, ""], kind = end.toLowerCase();
    const there = await blamed(name, async () => {
      if (!Object.hasOwn(READERS, kind))
        refuse(`a page can't read this kind of file. ${byPackage(name, kind)}`);
      if (kind === "json" && files.length > 1) refuse("a plant in JSON is read by itself");
      if (file.size > MOST_BYTES) refuse(`it has more than ${MOST_BYTES} bytes: too large to read`);
      const there = await READERS[kind](new Uint8Array(await file.arrayBuffer()));
      return kind === "json" ? opened(there) : kind === "mat" ? Object.entries(there) : [[stem, there]];
    });
    if (kind === "json") return there;
    for (const [own, X] of there) {
      if (own in found) refuse(`${name}: ${own} is there twice`);
      found[own] = X;
    }
  }
  return blamed(files.length > 1 ? "." : first, () => {
    const [matrices, left] = chosen(assembled(found)), {fields} = opened(matrices);
    return {fields, left: left.join(", ")};
  });
};
