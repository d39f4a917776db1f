// What a page says of a proof file: it writes the file again, and decides its matrices.
import {decimal} from "./exact.js";
import {claimsOf} from "./proof.js";
import {requirements} from "./request.js";
import {fileOf, spread} from "./text.js";
import {unproven, unsymmetric} from "./written.js";

const ODD = 1e100;  // no number is as large, nor as small but for zero
const floatOf = text => {
  const x = Number(text), size = Math.abs(x);
  if (typeof text !== "string" || !(x === 0 || size < ODD && size > 1 / ODD) || decimal(x) !== text)
    throw new Error(`${JSON.stringify(text) ?? "nothing"} is no decimal in its shortest form`);
  return x;
};
const numbersOf = rows => rows.map(row => row.map(floatOf));
const angleOf = text => {
  const x = floatOf(text);
  if (!(x > 0 && x < 1.6)) throw new Error(`${text} is no half-angle of a sector`);
  return x;
};
// What a page asks for a requirement of a file, by its form or its kind.
const BOUNDS_ASKED = {
  "half-plane": r => ({sigma: floatOf(r.sigma)}),
  sector: r => ({theta: angleOf(r.theta)}),
  disk: r => ({rho: floatOf(r.rho)}),
  gamma: r => ({gamma: floatOf(r.gamma), mu: r.mu === null ? null : floatOf(r.mu)}),
  cost: r => ({cost: floatOf(r.bound), Q: numbersOf(r.Q), R: numbersOf(r.R), noise: r.noise}),
  input: r => ({u_max: floatOf(r.u_max), x0: r.x0.map(floatOf)})
};
const KIND_WORDS = {
  sampled: "a loop with a clock",
  "known gain": "a gain that was given",
  delay: "a loop with a delay",
  observer: "an observer",
  regularization: "a mass that is made regular",
  lmi: "LMIs of an author's own"
};
const REFUSALS =
  ["fixed mode", "growing", "sum of poles", "singular mass", "unreached response", "small input"];

// {status, words, about, claims}: proven, refused, beyond (it isn't decided here) or odd (no file).
export function judgedFile(text) {
  let file;
  try {
    file = JSON.parse(text);
  } catch (fault) { return {status: "odd", words: `This is no proof file: ${fault.message}.`}; }
  if (file?.format !== "sosbook proof" || file.version !== 2 || typeof file.kind !== "string")
    return {status: "odd", words: 'This is no proof file: "format", "version" or "kind" is another.'};
  const {kind} = file, refusal = kind.startsWith("infeasible ") || REFUSALS.includes(kind);
  const what = refusal ? "what is asked can't be" : KIND_WORDS[kind.split(", ")[0]] ?? "unknown here";
  const named = `It is of the kind ${JSON.stringify(kind)} (${what})`;
  try {
    if (kind === "design") return designOf(file, text);
    const about = kind === "sampled" ? clock(file) : [];
    return {status: "beyond", words: `This page doesn't decide the file. ${named}.`, about};
  } catch (fault) { return {status: "refused", words: `The file isn't well formed: ${fault.message}.`}; }
}

// What stands for a name: data, or what was found.
function valuesOf({data, point}) {
  const value = x => {
    if (typeof x !== "string" || !/^[=|#]/.test(x)) return x;
    const found = data[x.slice(1)] ?? point[x.slice(1)];
    if (found === undefined) throw new Error(`there is no ${x.slice(1)}`);
    const full = found.zeros ? Array.from({length: found.zeros[0]}, () => []) : found;
    return x[0] === "|" ? full.map(row => row[0]) : x[0] === "#" ? [[full]] : full;
  };
  const inner = x => x === null || typeof x !== "object" ? value(x)
    : Array.isArray(x) ? x.map(inner)
                       : Object.fromEntries(Object.entries(x).map(([key, y]) => [key, inner(y)]));
  return inner;
}

function designOf(file, text) {
  const {plant, U, K_A, coupling, epsilon, E0, K, unknowns, requirements: list, ...more} =
    valuesOf(file)(file.asks);
  const words = "This page doesn't decide the file: it asks for something that no page asks.";
  const plain = plant.kind === "second order" && plant.vertices && !plant.reduced && K && unknowns;
  const plainly = r => !["u", "inputs", "outputs"].some(x => x in r) && !Array.isArray(r.x0?.[0]);
  const known = list.every(r => Object.hasOwn(BOUNDS_ASKED, r.form ?? r.kind) && plainly(r)),
        odd = K_A ?? epsilon ?? E0 ?? null;
  if (!plain || !known || odd !== null || coupling !== "pairs" || Object.keys(more).length)
    return {status: "beyond", words};
  const asked = Object.assign({}, ...list.map(r => BOUNDS_ASKED[r.form ?? r.kind](r)));
  const vertices =
    plant.vertices.map(v => Object.fromEntries(Object.entries(v).map(([name, X]) => [name, numbersOf(X)])));
  [K, ...Object.values(unknowns)].forEach(numbersOf);  // throws
  const request = {vertices, U: numbersOf(U), K_A, coupling, asked}, own = requirements(asked);
  const inOrder = list.map(r => own.find(({kind, name}) => r.kind === kind && r.name === name));
  if (!inOrder.every(r => r)) return {status: "beyond", words};
  if (own.length !== list.length || spread(fileOf("design", request, inOrder, {K, unknowns}).file) !== text)
    return {status: "refused", words: "Another text is written for what the file asks, letter by letter."};
  const lines = file.text.join("\n"), values = {...file.data, ...file.point};
  const failed = [...unsymmetric(lines, file.sets, values), ...unproven(lines, file.sets, values)];
  if (failed.length)
    return {status: "refused", words: `Not all matrices are positive definite: ${failed.join(", ")}.`};
  const [{M, B}] = vertices, law = `u = K x, x = [z; z'${U.length ? "; integrals of U z" : ""}]`;
  return {
    status: "proven",
    words: "Proven by this page, in fractions: it wrote the text again, and decided each of its matrices.",
    about: [
      `plant ${file.about.plant} of ${vertices.length} ${vertices.length > 1 ? "vertices" : "vertex"}: M is ${
        M.length} x ${M.length}, B is ${B.length} x ${B[0].length}`,
      `law ${law}, K ${file.about.K} = ${JSON.stringify(K).replaceAll('"', "")}`, "no clock"
    ],
    claims: claimsOf(request)
  };
}

// What a sampled file asks, in words.
function clock(file) {
  const {T, delay, K, plant, U} = valuesOf(file)(file.asks);
  const span = ([lo, hi]) => lo === hi ? lo : `${lo} to ${hi}`;
  const names = K.inputs || K.outputs ? `, ${lawOf(K, plant, U)}` : "";
  return [`plant ${file.about.plant}`, `a tick every ${span(T)} s, a delay of ${span(delay)} s${names}`];
}

// What K makes of what, in words: the names must be those of the plant's inputs and states.
function lawOf({inputs = [], outputs = [], D}, plant, U) {
  const {M, E} = plant.vertices?.[0] ?? plant, z = inputs.slice(0, (M ?? []).length);
  const given = D.length > 1 ? D.map((_, k) => `u${k + 1}`) : ["u"];
  const states = M ? [...z, ...z.map(x => `${x}'`)] : plant.states ?? E.map((_, k) => `x${k + 1}`);
  const all = M ? U.length : 0, rest = inputs.slice(states.length);
  const good = String(outputs) === String(given) && states.every((x, k) => x && x === inputs[k]) &&
    new Set(inputs).size === inputs.length && rest.length === all &&
    rest.every(x => String(x).startsWith("integral of "));
  if (!good) throw new Error("K.inputs and K.outputs aren't the names of the plant's states and inputs");
  return `K makes ${outputs.join(", ")} of ${inputs.join(", ")}`;
}
