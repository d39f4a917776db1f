// What is measured, and what is bounded in the place of z: the fields of a law and of outputs, with
// the keys that the package's files have.
import {parsed, refuse} from "./checks.js";
import {clean, number} from "./kit.js";
import {apply, eye, mul, solve, trace, transpose} from "./linalg.js";
import {mixed} from "./sentence.js";

const SIGNALS = ["position", "velocity", "acceleration", "integral", "input", "disturbance"];
const GAINS = ["K_P", "K_D", "K_I"];
const NEAR = 1e-9;  // of a row of U, to what is measured

// [name, words of a row] of each line, such as "K_P = 1 0".
const lines = (field, text, names) =>
  text.split(/[;\n]/).map(line => line.trim()).filter(line => line).map(line => {
    const [, name, row] = /^(\w+)\s*=\s*(.*)$/.exec(line) ?? [];
    if (!names.includes(name)) refuse(`${field}: "${line}" must begin with one of ${names.join(", ")} and =`);
    return [name, row.split(/[\s,]+/).map(word => Number.isNaN(number(word)) ? word : number(word))];
  });

// The mixtures of measured positions that U integrates, or a Fault: what isn't measured can't be.
function integrated(U, position) {
  const t = transpose(position),
        T = transpose(solve(mul(position, t), mul(position, transpose(U))))
              .map(row => row.map(x => Number(x.toPrecision(12)) + 0));
  const back = mul(T, position);
  U.forEach((row, k) => {
    if (!row.every((x, j) => Math.abs(x - back[k][j]) <= NEAR * Math.max(...row.map(Math.abs))))
      refuse(
        `Row ${k + 1} of U is integrated but isn't measured: integrate what is measured, or measure it.`);
  });
  return T;
}

// The law as a plant file has it; null where nothing is typed, or all of z and z' is measured.
export function lawOf(texts, n, U) {
  const [position, velocity] = ["position", "velocity"].map(name => parsed(name, texts[name]));
  for (const [name, X] of [["position", position], ["velocity", velocity]]) {
    if (X.length && X[0].length !== n) refuse(`${name} has ${X[0].length} columns, needs ${n}`);
    const blind = X.findIndex(row => row.every(x => !x));
    if (blind >= 0) refuse(`${name}: row ${blind + 1} is zero: that sensor sees nothing`);
  }
  const [[filter] = []] = parsed("filter", texts.filter), all = JSON.stringify(eye(n));
  if (!position.length && !velocity.length)
    refuse("position is missing: say what is measured, a row for each sensor");
  if (filter !== undefined && velocity.length)
    refuse("filter and velocity are given: measured velocities need no filter");
  if (filter !== undefined && !(filter > 0))
    refuse(`filter must be a positive number of seconds, got ${filter}`);
  if (!texts.structure && [position, velocity].every(X => JSON.stringify(X) === all)) return null;
  if (U.length && !position.length)
    refuse("Row 1 of U is integrated but isn't measured: integrate what is measured, or measure it.");
  const {structure} = texts, free = {};
  if (structure !== "diagonal")
    for (const [name, row] of lines("structure", structure, GAINS)) (free[name] ??= []).push(row);
  return {
    ...(position.length && {position}),
    ...(velocity.length && {velocity}),
    ...(filter && {filter}),
    ...(U.length && {integrate: integrated(U, position)}),
    ...(structure && {structure: structure === "diagonal" ? structure : free})
  };
}

// What a law holds at first, for a plant that has stood at z: empty integrals, and in each filter
// what is measured.
export const memory = ({position = [], filter, integrate = []}, z) =>
  integrate.map(() => 0).concat(filter ? apply(position, z) : []);

// What the sum of the poles says of a law without measured rates, for no gain of it moves this sum:
// null, or why not all poles of a plant are faster than sigma.
export function summed({position = [], velocity = [], filter, integrate = []}, vertices, sigma) {
  const p = position.length, n = vertices[0].M.length, N = 2 * n + integrate.length + (filter ? p : 0);
  const damping = Math.min(...vertices.map(({M, D}) => trace(solve(M, D))));
  const limit = (damping + (filter ? p / filter : 0)) / N;
  if (velocity.length || !(sigma > limit * (1 + NEAR) + NEAR * sigma)) return null;
  const short = p / ((filter ? N : N + p) * sigma - damping);
  return {
    status: "infeasible",
    reason: `No gain of these sensors moves the sum of the poles: one of them has a real part of ${
      clean(-limit)} s⁻¹ or more.`,
    help: `Ask for σ below ${clean(limit)} s⁻¹, or give a filter time below ${
      Number((0.9 * short).toPrecision(2))} s: ${
      filter ? "then this sum is small enough"
             : "then the law has a derivative, and this sum is small enough"}.`
  };
}

// The names of the coordinates that a law sees.
export const seenBy = ({position = [], velocity = []}) => ["", "'"].flatMap(
  (prime, k) => [position, velocity][k].flatMap(
    row => row.flatMap((x, j) => x ? [`z${j + 1}${prime}`] : [])));

// The outputs that a line each names; a number is that multiple of the signal.
export const outputsOf = text => lines("outputs", text, SIGNALS).map(([name, row]) => {
  const word = row.find(x => typeof x === "string");
  if (word !== undefined) refuse(`outputs: "${word}" is no number.`);
  return {[name]: row.length > 1 ? [row] : row[0]};
});

// What is measured is a choice: the words of a sentence, where this stands in it whatever it is.
const ALL = "with all measured";
export function withChoice(sentences, law) {
  const {pieces} = sentences, at = pieces.findIndex(x => x.slot === "law");
  const choices = [ALL, ...sentences.laws().map(([words]) => `from ${words}`)];
  const choice = {slot: "law", choices, clause: {label: "what is measured"}};
  if (at > 0 && choices.includes(`from ${pieces[at].shown}`))
    return pieces.with(at - 1, {text: pieces[at - 1].text.replace(/from $/, "")})
      .with(at, {...choice, shown: `from ${pieces[at].shown}`});
  return law ? pieces : [...pieces, {text: ", "}, {...choice, shown: ALL}];
}
// The errors that are integrated in the place of U where only these rows are measured.
export const seen = (U, position) => U.length ? mul(mixed(U, position), position) : [];
