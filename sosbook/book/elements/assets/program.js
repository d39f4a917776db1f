// What is asked, as the one object of a plant file, and the Python that is made of it alone.
import {Sentences} from "./sentence.js";

export const list = x => Array.isArray(x) ? `[${x.map(list).join(", ")}]`
  : typeof x === "object"
  ? `{${Object.entries(x).map(([key, y]) => `${JSON.stringify(key)}: ${list(y)}`).join(", ")}}`
  : typeof x === "string" ? JSON.stringify(x)
                          : String(x);

// What there is of an object; undefined where that is nothing.
function filled(x) {
  const there = Object.entries(x).filter(([, y]) => y !== undefined && y !== null);
  return there.length ? Object.fromEntries(there) : undefined;
}

// The half-angle, in degrees, of modes that overshoot by a share, and back.
export const degreesOf = share => Math.atan2(Math.PI, -Math.log(share)) * 180 / Math.PI;
export const shareOf = theta => Math.exp(-Math.PI / Math.tan(theta * Math.PI / 180));

// The sector as a file has it: by an overshoot of few digits where there is one.
function sector(theta) {
  const shares = [1, 2, 3, 4].map(digits => Number(shareOf(theta).toPrecision(digits)));
  const overshoot = shares.find(share => degreesOf(share) === theta && share < 1);
  return overshoot === undefined ? {theta_deg: theta} : {overshoot};
}

// The plant file of a plant, of what is fixed and of bounds by name, in the units shown.
/** @type {(data: any, bounds: any) => any} */
export function asks({request, x0, mu, cost, law, outputs, clock, words: vocabulary, symbols}, bounds) {
  const {vertices, family, U, K_A, coupling} = request;
  const {sigma, theta, rho, gamma, cost: bound, u_max} = bounds;
  const {parameters, ...words} = family ?? {}, [one, ...others] = vertices.map(filled);
  const ranges = parameters?.map(([name, ...ends]) => [name, ends]);
  return filled({
    plant: family     ? {parameters: Object.fromEntries(ranges), ...words}
      : others.length ? {vertices: [one, ...others]}
                      : one,
    words: vocabulary,
    U: law || !U.length ? null : U,
    law,
    K_A,
    region: filled({sigma, ...(symbols ? {theta_deg: theta} : sector(theta)), rho}),
    ...(outputs || mu && gamma ? {hinf: filled({gamma, mu, outputs})} : {gamma}),
    cost: bound === undefined ? null : {...cost, bound},
    saturation: u_max === undefined ? null : {u_max, x0},
    coupling: coupling === "pairs" ? null : coupling,
    controller: clock && filled({...clock, u_max})
  });
}

// The sentences about the plant of a request, and of what is asked of it; `rest` is that of judge.js.
export function sentences(asked, {request: {vertices: [plant]}, symbols = false}, rest = undefined) {
  const at = rows => {
    const z = rest(plant, rows, (rows.length ? rows : plant.M).map(() => 1));
    return z.every(isFinite) ? z : null;
  };
  return new Sentences(asked, plant.M?.length ?? 0, rest && at, symbols);
}

// What `writers` make of each key of a request; a key that none of them knows is an error.
export const written = (asked, writers) => Object.entries(asked).map(([key, x]) => {
  if (!Object.hasOwn(writers, key)) throw new Error(`no writer knows ${key}`);
  return writers[key](x);
});

// A plant, then a call of the package; arguments are [name, text], and those without a text are
// left out.
export function program(plant, call, words, notes = [], more = "") {
  const made = matrices => "sos.SecondOrderSystem(\n" +
    Object.entries(matrices).map(([name, X]) => `    ${name}=${list(X)},\n`).join("") + ")";
  const {parameters, vertices} = plant;
  const text = parameters
    ? `sos.Uncertain.read(sos.SecondOrderSystem, {\n${
        Object
          .entries({...plant, parameters: Object.entries(parameters).map(([name, ends]) => [name, ...ends])})
          .map(([name, X]) => `    "${name}": ${list(X)},\n`)
          .join("")}}, rows=True)`
    : vertices ? `sos.Polytope([\n${vertices.map(made).join(",\n")}])`
               : made(plant);
  const given = words.filter(([, text]) => text).map(([name, text]) => `    ${name}=${text},\n`).join("");
  return `import sosbook as sos\n${notes.map(note => note + "\n").join("")}\nplant = ${text}\ndesign = sos.${
           call}(\n    plant,\n${given})\n` +
    `print(design.status)\nprint(design.K)\n${more}`;
}

const named = x => Object.entries(x).map(([name, y]) => `${name}=${list(y)}`).join(", ");
const outputs = rows => rows.map(row => `sos.Output(${named(row)})`).join(" & ");
const hinf = ({outputs: rows, ...x}) =>
  `sos.HInfinity(${named(x)}${rows ? `, outputs=${outputs(rows)}` : ""})`;
const argument = (name, write = list) => [name, x => [name, write(x)]];
const object = (name, kind) => argument(name, x => `sos.${kind}(${named(x)})`);
// How Python writes each key of a request: as an argument of `design_pid`, or not among them.
export const PYTHON = Object.fromEntries([
  ["plant", () => []], ["words", () => []], ...["U", "K_A", "gamma", "coupling"].map(name => argument(name)),
  object("law", "PIDLaw"), object("region", "PoleRegion"), object("saturation", "Saturation"),
  ["cost", x => ["requirements", `sos.QuadraticCost(${named(x)})`]], ["hinf", x => ["requirements", hinf(x)]],
  ["controller", () => []]
]);

// The design of what is asked: `program_data`, and bounds by name in the units shown.
export function design(data, bounds, resting = undefined) {
  const {own = [], found = null} = data, known = {...bounds};
  for (const {key} of own) delete known[key];
  const asked = asks(data, known);
  const words = written(asked, PYTHON), rest = own.map(({key, text}) => text.replace("{}", bounds[key]));
  const more = words.filter(([name]) => name === "requirements").map(([, text]) => text).concat(rest);
  return program(asked.plant, found ? "analyse_pid" : "design_pid",
    [
      ["K", found && list(found)], ...words.filter(([name]) => name && name !== "requirements"),
      ["requirements", more.length && `[${more.join(", ")}]`]
    ],
    [
      ...(own.length ? [] : [`# ${sentences(asked, data, resting)}`]),
      ...new Set(own.map(({note}) => note).filter(note => note))
    ],
    (found ? `proof = design.certify()\nprint(proof)\nproof.save("proof.json")\n` : "") +
      (asked.controller ? sampled(asked.controller) : ""));
}

// The same gain with a clock, and an observer for what isn't measured.
function sampled({u_max, measured, ...clock}) {
  return `if design.status == "feasible":\n    controller = design.controller(${
           measured ? `${list(measured)}, ` : ""}${named(clock)})\n` +
    (u_max === undefined ? "" : `    controller = controller.limit(u_max=${u_max})\n`) +
    `    print(controller.certify(time_limit=60))\n    print(design.report("report", controller=controller))\n` +
    `else:\n    print(design.reason)\n`;
}
