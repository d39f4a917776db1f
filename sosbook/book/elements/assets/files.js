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
const MATRIX = 14, PACKED = 15, STRUCT = 2, SPARSE = 5, DOUBLE = 6, LAST = 15, COMPLEX = 0x800;

const text = bytes => new TextDecoder().decode(bytes).replace(/^\ufeff/, "");
// A number that a reader wrote as a word; NaN for none. What no float is near is refused.
function near(given) {
  const word = given.replace(/(?<=[\d.])[dD](?=[-+]?\d+$)/, "e"), x = number(word);  // Fortran's 1.5D+00
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

const HEADING = /^row[\s;,]+column[\s;,]+value$/i;  // above a table of entries
// The numbers of each line that counts.
const table = (bytes, comment = /#.*/, between = undefined) =>
  text(bytes)
    .split(/\r?\n/)
    .flatMap((line, k) => {
      const words = line.replace(comment, "").trim(),
            part = between ?? [";", ","].find(mark => words.includes(mark)) ?? /\s+/;
      return words && [words.split(part).map(word => {
        const x = near(word.trim());
        return Number.isNaN(x)
          ? refuse(`line ${k + 1}: "${word.trim()}" is no number; write 0.5 with a point`)
          : x;
      })];
    })
    .filter(row => row);

// A table of numbers. `lines`: says which lines open with the package what a page can't open.
function csv(bytes, lines) {
  const [head] = text(bytes).split(/\r?\n/).map(line => line.replace(/#.*/, "").trim()).filter(line => line);
  return HEADING.test(head) ? listed(lines) : table(bytes);
}
const listed = lines =>
  refuse(`it lists entries, and a page reads whole matrices, or entries below %%MatrixMarket. ${lines()}`);

function sized(rows, columns, lines) {
  if (Math.max(rows, columns) > MOST)
    refuse(`it is ${rows} x ${columns}, and a field has ${MOST} rows and columns at most. ${
      lines(".reduce(modes=6)")}`);
  return make(rows, columns, (_i, _j) => 0);
}

// A matrix of Matrix Market.
function mtx(bytes, lines) {
  const [head, , form, field, kind] = text(bytes).split(/\s+/, 5).map(word => word.toLowerCase());
  if (head !== "%%matrixmarket") listed(lines);
  if (!/^(real|integer)$/.test(field)) refuse(`its numbers are ${field}`);
  const [[rows, columns, count], ...list] = table(bytes, /^%.*/, /\s+/), X = sized(rows, columns, lines);
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

// The matrices in a file of MATLAB's versions 5 to 7; those of a struct are called "struct.field".
async function mat(bytes, lines) {
  const found = Object.create(null), budget = {left: MOST_BYTES};
  if (text(bytes.subarray(126, 128)) !== "IM")
    refuse(`it is no file of MATLAB's versions 5 to 7: save with '-v7'. ${lines()}`);
  for (const part of parts(bytes.subarray(128))) {
    const [kind, inner] = part[0] === PACKED ? parts(await unpacked(part[1], budget))[0] : part;
    if (kind === MATRIX) put(found, parts(inner), lines);
  }
  return found;
}

// Put what these pieces of a file of MATLAB are, by its own name or a field's of a struct.
function put(found, pieces, lines, field = "") {
  const [[flags], [rows, columns], letters] = pieces.slice(0, 3).map(list),
                                   word = x => String.fromCharCode(...x);
  const type = flags & 0xff, name = field || word(letters);
  if (type === STRUCT && rows * columns === 1) {
    const [[wide], names] = pieces.slice(3, 5).map(list);
    pieces.slice(5).forEach(([, inner], k) => {
      const own = word(names.slice(k * wide, (k + 1) * wide)).replace(/\0.*/, "");
      put(found, parts(inner), lines, `${name}.${own}`);
    });
    return;
  }
  if (type !== SPARSE && (type < DOUBLE || type > LAST)) {
    found[name] = undefined;
    return;
  }
  if (flags & COMPLEX)
    refuse(`${name} is complex; of hysteretic damping give the real part, and imag(${name}) / omega for D, ` +
      "at the frequency omega that matters");
  const X = found[name] = sized(rows, columns, lines);
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

// Kinds of files that the package reads, with a plant or a matrix in each.
const WHOLES = ["npz", "h5", "hdf5", "op4", "pch", "toml"];
const PARTS = ["csv", "txt", "mtx", "npy", "sti", "mas", "dof", "hb", "rb", "rsa", "rua", "rza"];
const safely = name => /^[\w. -]+$/.test(name) ? name : "YOUR_FILE";

// The lines that open with the package what a page can't look into, and make of it what a page reads; `then`
// is done to the plant.
function byPackage(name, then = "") {
  const read = `load_plant('${name}'`;
  return `The package designs for it: python -m sosbook design "${
           name}". For this page it makes a plant.json ` +
    `of what has M, D, S and B: python -c "import json, sosbook.plants as p; v = p.${read})${
      then}; json.dump({k: getattr(v, k).tolist() for k in 'MDSBF'}, open('plant.json', 'w'))". What its last ` +
    `line asks for stands beside the name: ${read}, push=[0])`;
}

// The matrices of the fields among those that are there: K and C may be S and D, and those of a struct
// serve where there is no plant beside it. `left` are others.
function chosen(given, name) {
  const known = [...NAMES, "K", "C", "A", "ABCD"], all = Object.keys(given);
  const within = ["", ...new Set(all.flatMap(name => name.match(/^.*\./) ?? []))].map(start => {
    const own = all.filter(name => name.startsWith(start)).map(name => name.slice(start.length));
    const large = known.some(name => own.includes(name)), there = Object.create(null);
    for (const name of own) there[large ? name : name.toUpperCase()] = given[start + name];
    return {start, large, there, plant: ["M", "A", "ABCD"].some(name => name in there)};
  });
  const own = within.filter(({plant}) => plant), [{start, large, there}] = [...own, ...within];
  if (own.length > 1 && start)
    refuse(`which is the plant, ${own.map(x => x.start.slice(0, -1)).join(" or ")}? Save one alone`);
  const {M, D, S, K, C} = there;
  if (!M && ("A" in there || "ABCD" in there))
    refuse(
      "it is a state space, and the fields here are M, D, S and B; the package designs for it, as it is: " +
      `python -m sosbook design "${name}"`);
  if (M && K && C && D && !S) refuse("beside K, is C or D the damping? Leave one of them out");
  const square = X => M && X?.length === M.length && X[0].length === M.length ? X : undefined;
  const plant = {...there, D: D ?? square(C), S: S ?? square(K)};
  if (large && "f" in there && !("F" in there)) refuse("f isn't read: call it F");
  const lacking = NAMES.filter(name => !plant[name] && name !== "F");
  const listed = all.join(", ").slice(0, 200) || "nothing";
  const more = lacking.includes("B") && lacking.length < 4
    ? ". Add B, a column for each actuator with ones in the rows that it pushes"
    : "";
  if (lacking.length)
    refuse(`${lacking.join(", ")} is missing; ${listed} is there: use these letters${more}`);
  for (const name of ["M", "D", "S"]) {
    const held = plant[name].flatMap((row, i) => Math.abs(row[i]) >= PENALTY ? [i] : []);
    if (held.length)
      refuse(`${name} has penalties on its diagonal instead of supports: leave out rows and columns ${
        held.map(i => i + 1).join(", ")}`);
  }
  const fit = NAMES.flatMap(name => plant[name]?.length === M.length ? [plant[name]] : []);
  const empty = M.flatMap((_, i) => fit.some(X => X[i].some(x => x)) ? [] : [i + 1]);
  if (empty.length) refuse(`rows are empty in M, D, S and B: leave out rows and columns ${empty.join(", ")}`);
  const used = [...NAMES, ...(D ? [] : ["C"]), ...(S ? [] : ["K"])];
  const left = all.filter(name => !name.startsWith(start) ||
      !used.includes(large ? name.slice(start.length) : name.slice(start.length).toUpperCase()));
  const matrices = NAMES.filter(name => plant[name]?.[0].length).map(name => [name, plant[name]]);
  return {matrices: Object.fromEntries(matrices), left: left.join(", ")};
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
  csv,
  txt: csv,
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
    const place = files.length > 1 || PARTS.includes(kind) ? "." : safely(name);
    const there = await blamed(name, async () => {
      if (!Object.hasOwn(READERS, kind))
        refuse(`a page can't read this kind of file. ${
            [...WHOLES, ...PARTS].includes(kind) ? byPackage(place)
                                                 : "Open .json, .mat, .mtx, .csv or .txt"}`);
      if (kind === "json" && files.length > 1) refuse("a plant in JSON is read by itself");
      if (file.size > MOST_BYTES) refuse(`it has more than ${MOST_BYTES} bytes: too large to read`);
      const there =
        await READERS[kind](new Uint8Array(await file.arrayBuffer()), then => byPackage(place, then));
      return kind === "json" ? opened(there) : kind === "mat" ? Object.entries(there) : [[stem, there]];
    });
    if (kind === "json") return there;
    for (const [own, X] of there) {
      if (own in found) refuse(`${name}: ${own} is there twice`);
      found[own] = X;
    }
  }
  return blamed(files.length > 1 ? "." : first, () => {
    const {matrices, ...more} = chosen(found, files.length > 1 ? "." : safely(first));
    return {...more, fields: opened(matrices).fields};
  });
};
