// The form of a reader's plant: its fields, and the request that stands in them.
import {descriptors} from "../../kernel/descriptor.js";
import {rowsOf} from "../../kernel/matrices.js";

import * as checks from "./checks.js";
import {parsed, refuse} from "./checks.js";
import {plants} from "./corners.js";
import {atRest, rest} from "./judge.js";
import {number} from "./kit.js";
import {lawOf, memory, outputsOf} from "./law.js";
import {typed} from "./spoken.js";
import {starts, typicalRate} from "./wishes.js";

export const STRANGE = "These matrices can't be computed with: choose other units, or take the package.";
// name, words, shape, and the box that asks for it
export const FIELDS = [
  ["M", "Mass M", "n × n"], ["D", "Damping D", "n × n"], ["S", "Stiffness S", "n × n"],
  ["B", "Inputs B", "n rows, a column for each input"], ["F", "Disturbances F", "n rows; may be empty"],
  ["U", "Integrated errors U", "a rows of n; may be empty"],
  [
    "ranges", "Parameters in ranges",
    "J2 = 0.003 .. 0.006, a line for each; their names may stand in matrices"
  ],
  ["r", "Step of the set point U z", "a numbers; ones without"],
  ["position", "Measured positions y", "a row of n for each sensor", "law"],
  ["velocity", "Measured rates", "a row of n for each; may be empty", "law"],
  ["filter", "Filter that makes rates of y", "its time in s; may be empty", "law"],
  ["structure", "Which gains are free", "diagonal, or K_P = 1 0, K_P = a a …; all without", "law"],
  ["outputs", "What γ bounds", "position = 0 1, or input = 0.01, a line each; z without", "gamma"],
  [
    "x0", "Initial state x(0)", "2n + a numbers: z, z′, integrals of U z; with a law z, z′ are enough",
    "u_max"
  ],
  ["Q", "Weight Q of the state", "2n + a numbers, a diagonal, or rows", "cost"],
  ["R", "Weight R of the input", "a number for each input, or rows", "cost"],
  ["T", "Sampling time T in s", "one number", "clock"],
  ["delay", "Dead time in s", "from a sample to the input; may be empty", "clock"],
  ["measured", "What is measured", "z1 z1' …; all without", "clock"]
];
export const BOXES = [
  ["law", "only this is measured"], ["gamma", "bound what w does (γ)"], ["cost", "bound the cost (Q, R)"],
  ["u_max", "bound the input from x(0)"], ["clock", "a computer with a clock"]
];

// One line, as an address has it; an empty row stays between two plants.
export const compact = text =>
  text.split(/[;\n]/).map(row => row.trim()).join(";").replace(/^;+|;+$/g, "").replace(/;{3,}/g, ";;");

function clockOf({T, delay, measured}, n, U, law) {
  const one = (name, text) => {
    const x = typed(text);
    if (!(x >= 0) || (name === "T" && x === 0))
      refuse(`${name} must be a positive number of seconds, got "${text}"`);
    return x;
  };
  const names = measured.split(/[\s,;]+/).filter(name => name);
  const odd = names.find(name => !/^z[1-9]\d*'?$/.test(name) || parseInt(name.slice(1)) > n);
  if (odd) refuse(`measured: "${odd}" is none of z1 to z${n}, nor a rate such as z1'`);
  if (names.length && law) refuse("measured and a law are given: the law says what is measured");
  const blind = names.length
    ? U.flatMap(row => row.flatMap((x, j) => x && !names.includes(`z${j + 1}`) ? [`z${j + 1}`] : []))
    : [];
  if (blind.length)
    refuse(`${blind[0]} is integrated but isn't measured: integrate what is measured (${
      names.join(", ")}), or measure ${blind[0]}`);
  return {...(names.length && {measured: names}), T: one("T", T), ...(delay && {delay: one("delay", delay)})};
}

// One for each goal: the rows of U, or all of z.
export const goals = (n, U) => Array(U.length || n).fill(1);

// x(0) of the loop; a law's memory follows from z.
function startOf(x0, law, n, N) {
  if (law && x0.length === 2 * n) return [...x0, ...memory(law, x0.slice(0, n))];
  if (law && x0.length !== N)
    refuse(`x0 has ${x0.length} entries, needs 2n = ${2 * n}: [z(0); z'(0)], or ${
      N} with the law's integrals and filters, which hold what was measured`);
  return checks.start([x0], N);
}

// {request, x0, cost, r, clock, warning, rounded} of what is typed and asked; a Fault says what
// doesn't fit.
export function requestOf(texts, wanted) {
  const {vertices, box, typed: words, rounded} = plants(texts), U = parsed("U", texts.U);
  const warnings = vertices.map(v => checks.plant({...v, U})), {M, B, F} = vertices[0];
  const law = wanted.law ? lawOf(texts, M.length, U) : null,
        outputs = wanted.gamma ? outputsOf(texts.outputs) : [];
  const n = M.length, held = law ? memory(law, M.map(() => 0)) : U, N = 2 * n + held.length;
  const r = parsed("r", texts.r).flat(), ones = goals(n, U);
  if (r.length && r.length !== ones.length) refuse(`r has ${r.length} numbers, needs ${ones.length}`);
  if (wanted.gamma && !F.length) refuse(checks.said("disturbance"));
  const weight = (name, size) => checks.weight(name, parsed(name, texts[name]), size);
  const entry = text => Number.isNaN(number(text)) ? text : number(text);
  const named = plant =>
    Object.fromEntries(Object.entries(plant).filter(([name, X]) => name !== "F" || X.length));
  const family = box.length && {
    parameters: box.map(({name, low, high}) => [name, low, high]),
    ...Object.fromEntries(
      Object.entries(named(words)).map(([name, X]) => [name, X.map(row => row.map(entry))]))
  };
  return {
    request: {vertices: vertices.map(named), U, K_A: null, coupling: "pairs", ...(family && {family})},
    warning: warnings.find(words => words) ?? "",
    rounded,
    r: r.length ? r : ones,
    law,
    outputs: outputs.length ? outputs : null,
    clock: wanted.clock ? clockOf(texts, n, U, law) : null,
    x0: wanted.u_max ? startOf(parsed("x0", texts.x0).flat(), law, n, N) : null,
    cost: wanted.cost ? {Q: weight("Q", N), R: weight("R", B[0].length), noise: F.length ? "F" : "states"}
                      : null
  };
}

// What the explorer needs to know of a plant.
export function dataOf(found, wanted) {
  const {request, law, r} = found, loops = descriptors({...request, law}).map(typicalRate);
  const [{B}] = loops, {omega} = typicalRate(descriptors(request)[0]), a = request.U.length;
  const {M} = request.vertices[0], n = M.length, at = rest(request.vertices[0], request.U, r);
  const held = atRest({...request, law}, at).slice(2 * n + a);
  if (!loops.every(({A, B}) => [...A.at, ...B.at].every(isFinite)) || omega > 1e98 || omega < 1e-98)
    refuse(STRANGE);  // the package's bounds end at 1e100
  const far = 10 * omega, s = [...Array(2 * n).fill(0), ...(a ? r : []).map(x => -x), ...held.map(() => 0)];
  const steps = request.U.length ? "the set point of U z" : "the set point";
  return {
    ...found,
    mu: null,
    goal: r,
    bounds: starts(found, omega, wanted),
    shape: [n, B.cols, a],
    r: at,
    horizon: Number((40 / omega).toPrecision(2)),
    window: [-1.06 * far, 0.2 * far, far],
    vertices: loops.map(({A, B}) => ({A: rowsOf(A), B: rowsOf(B), s, held})),
    caption:
      `Step of ${steps}, ${r.join(", ")}, from rest${request.vertices.length > 1 ? ", at all corners" : ""}.`
  };
}
