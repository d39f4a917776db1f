// What a reader takes home of a design: the control law in C, the request as a file of
// `python -m sosbook design`, and a page for others.
import PIECES from "../../../book/elements/assets/control.json" with {type : "json"};

import {refuse} from "./checks.js";
import {escape} from "./kit.js";
import {mul, transpose} from "./linalg.js";
import {degreesOf, written} from "./program.js";

const number = x => String(Number(x.toPrecision(9)));
const table = rows => rows.map(row => `    {${row.map(number).join(", ")}}`).join(",\n");

// What the program in C does of each key of a request: all of them stand in its head.
export const IN_C = {
  ...Object.fromEntries(["plant", "words", "U", "K_A", "region", "gamma", "hinf", "cost", "coupling"].map(
    key => [key, () => ({})])),
  law: law => ({law}),
  saturation: ({u_max}) => ({limit: u_max}),
  controller: ({T, measured, u_max}) => ({T, measured, limit: u_max})
};

// The control law as a C function of its own: the pieces of control.json whose words hold. `points` are the
// set points of single goals, in what is measured; of a law `gains` has the gain of each part.
export function program(asked, {K, U, points, gains = null}, sentence) {
  const {limit, T, measured, law} = Object.assign({}, ...written(asked, IN_C));
  const {filter = 0, velocity = [], integrate = []} = law ?? {}, sums = law ? integrate : U;
  const n = points[0].length, a = sums.length, speeds = law ? velocity.length : n,
        rates = filter ? n : speeds;
  const {plant: _, words: __, ...head} = asked;
  const holds = {law, T, filter, measured, bounded: limit !== undefined, sums: a, speeds, rates};
  const said = {
    sentence,
    asked: flat(head),
    T,
    filter,
    measured: measured?.join(", "),
    n,
    rates,
    inputs: K.length,
    a,
    goals: points.length,
    limit: number(limit ?? 0),
    K: table(gains ? joined(gains) : K),
    R: table(transpose(points)),
    U: table(sums),
    state: law ? "y" : "z",
    speed: filter ? "rate" : "velocity",
    lag: number(filter),
    share: number(1 - Math.exp(-T / filter))
  };
  const there = word => word[0] === "-" ? !holds[word.slice(1)] : !word || holds[word];
  return PIECES.filter(([when]) => when.split(" ").every(there))
    .map(([, text]) => text.replace(/\{(\w+)\}/g, (_, name) => said[name]))
    .join("");
}
// The rows of all parts of a gain.
export const joined = parts =>
  Object.values(parts)[0].map((_, i) => Object.values(parts).flatMap(rows => rows[i]));

// The request as the command line reads it.
const flat = x => JSON.stringify(x).replaceAll(",", ", ").replaceAll(":", ": ");
export const file = asked =>
  `{\n${Object.entries(asked).map(([key, value]) => ` "${key}": ${flat(value)}`).join(",\n")}\n}\n`;

// What a plant file has under its keys, by the names of fields and sliders where those are others.
const PLACES = Object
                 .entries({
                   "": "U gamma",
                   law: "position velocity filter integrate structure",
                   region: "sigma theta_deg:theta rho settling_time overshoot",
                   hinf: "gamma:bound outputs",
                   saturation: "u_max x0",
                   cost: "Q R noise bound:cost",
                   controller: "measured T delay"
                 })
                 .flatMap(([key, words]) => words.split(" ").map(word => {
                   const [inner, name = inner] = word.split(":");
                   return [name, key, inner];
                 }));

// What such a file, or a plant alone, has for an address; `left` has no field.
export function opened(data) {
  const {plant, words, ...asked} = "plant" in data ? data : {plant: data};
  const {vertices = [plant], parameters = {}, coordinates, file = plant} = plant, found = {};
  if (asked.controller?.u_max === asked.saturation?.u_max) delete asked.controller?.u_max;
  if (typeof file === "string") refuse(`its plant is the file ${file}: open that, and type what is asked`);
  for (const [name, key, inner] of PLACES) {
    const home = key ? asked[key] : asked;
    if (home?.[inner] == null) continue;
    found[name] = home[inner];
    delete home[inner];
  }
  if ("settling_time" in found) found.sigma = 4 / Number(found.settling_time);
  if ("overshoot" in found) found.theta = degreesOf(Number(found.overshoot));
  const text = X => [X].flat().map(row => [row].flat().join(" ")).join(";");
  const named = X => typeof X === "string"
    ? X
    : Object.entries(X)
        .flatMap(([name, rows]) => [rows].flat().map(row => `${name} = ${text([row])}`))
        .join(";");
  const {integrate, bound, outputs, structure, position} = found;
  const fields = Object.fromEntries(Object.entries(found).map(([name, X]) => [name, text(X)]));
  for (const name of ["M", "D", "S", "B", "F"])
    if (vertices[0][name]?.[0]?.length) fields[name] = vertices.map(v => text(v[name])).join(";;");
  fields.ranges =
    Object.entries(parameters).map(([name, ends]) => `${name} = ${ends.join(" .. ")}`).join(";");
  if (bound !== undefined) fields.gamma = text(bound);
  if (integrate) fields.U = text(integrate === true ? position : mul(integrate, position));
  if (structure) fields.structure = named(structure);
  if ([outputs ?? []].flat().some(one => Object.keys(one).length > 1))
    refuse("hinf: an output of several signals has no field: the form adds none up");
  if (outputs) fields.outputs = [outputs].flat().map(named).join(";");
  const boxes =
    {gamma: "gamma", cost: "R", u_max: "x0", clock: "T", law: found.velocity ? "velocity" : "position"};
  fields.bounds = Object.keys(boxes).filter(key => boxes[key] in fields).join(" ");
  const left = Object.entries({...asked, coordinates})
                 .flatMap(([key, X]) => X === Object(X) && !Array.isArray(X)
                     ? Object.keys(X).map(inner => `${key}.${inner}`)
                     : X === undefined || key === "$schema" ? []
                                                            : [key]);
  return {fields, left: left.join(", "), words};
}

const STYLE = `body{font:16px/1.5 system-ui,sans-serif;max-width:52rem;margin:2rem auto;padding:0 1rem;
--sos-first:#0072b2;--sos-second:#d55e00;--sos-third:#6a51a3;--sos-region:#009e73;--sos-soft:#555;--sos-ink:#111;
--sos-paper:#fff;--sos-line:#ccc;--sos-good:#00674b;--sos-bad:#b00020}svg{max-width:24rem}
pre{background:#f4f4f4;padding:.6rem;overflow:auto}table{border-collapse:collapse}td,th{border:1px solid #999;
padding:.2rem .5rem;text-align:left}.sos-matrix{display:inline-grid;gap:0 .8em;border:solid #555;border-width:0 1px;
padding:0 .4em}.sos-gain{margin-right:1.4em}.sos-region{fill:#009e73;fill-opacity:.2}.sos-grid{stroke:#ccc}
.sos-axis,.sos-target{stroke:#555}.sos-pole{stroke:#0072b2;stroke-width:2;fill:none}.sos-line{fill:none;
stroke-width:1.7}.sos-ghost,.sos-handle,.sos-hit{display:none}text{font:12px sans-serif}`;

// A page that needs no other file. Parts: [heading, HTML], and texts [heading, text].
export const report = (title, parts, texts) => `<!doctype html><html lang="en"><meta charset="utf-8"><title>${
  escape(title)}</title><style>${STYLE}</style><h1>${escape(title)}</h1>${
  parts.map(([name, html]) => `<h2>${escape(name)}</h2>${html}`).join("")}${
  texts.map(([name, text]) => `<h2>${escape(name)}</h2><pre>${escape(text)}</pre>`).join("")}</html>\n`;
