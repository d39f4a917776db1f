// Plants that are known by ranges of parameters, or several of them: what is typed, as the
// corners of a polytope. Entries are polynomials in words, as in the package's plant files, and
// are computed in exact decimals.
import {exactScalar, exactSum, exactTimes, nearly} from "../../kernel/exact.js";

import {refuse, words} from "./checks.js";
import {number} from "./kit.js";

const NAMES = ["M", "D", "S", "B", "F"];
const REAL = String.raw`[-+−]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[-+]?\d+)?`, NAME = String.raw`[A-Za-z_]\w*`;
const RANGE = new RegExp(String.raw`^(${NAME})\s*(?:=|:|in\b|from\b|∈|\s)\s*(?:\[\s*(${REAL})\s*[,\s]\s*(${
                           REAL})\s*\]|(${REAL})\s*(\.\.+|…|to\b|±|\+-|\s)\s*(${REAL}))$`,
  "i");
const FACTOR = `(?:${NAME}(?:\\^\\d{1,2})?|(?:\\d+\\.?\\d*|\\.\\d+)(?:e[-+]?\\d+)?)`;
const TERM = new RegExp(`^([-+]?)(${FACTOR}(?:\\*${FACTOR})*)`, "i");

// [{name, low, high}] of lines such as "J2 = 0.003 .. 0.006", "k in [1, 2]" or "m = 2 ± 0.1".
export function ranges(text) {
  const list = text.split(/[;\n]/).map(line => line.trim()).filter(line => line).map(line => {
    const found = RANGE.exec(line);
    if (!found) refuse(`Ranges: "${line}" is no range. Write J2 = 0.003 .. 0.006, a line for each.`);
    const [, name, left, right, a, how, b] = found, value = x => number(x.replace(",", "."));
    let [low, high] = left === undefined ? [value(a), value(b)] : [value(left), value(right)];
    if (how === "±" || how === "+-") {
      const [mean, half] = [low, high].map(exactScalar);
      [low, high] = [-1, 1].map(side => nearly(exactSum(mean, exactTimes(exactScalar(side), half))));
    }
    if (!(low < high)) refuse(`${name} must have low < high, got ${low} .. ${high}`);
    return {name, low, high};
  });
  const twice = list.find(({name}, k) => list.slice(0, k).some(one => one.name === name));
  if (twice) refuse(`Ranges: ${twice.name} is there twice.`);
  return list;
}

// A polynomial of the text "2*m - 0.5*m*k": [{c, powers}], c exact and a power for each of the names.
function polynomial(matrix, text, names) {
  const terms = new Map();
  for (let rest = text.replaceAll("−", "-"), first = true; rest || first; first = false) {
    const term = TERM.exec(rest);
    if (!term || (!first && !term[1])) refuse(`${matrix}: "${text}" is no number, and no sum of products.`);
    let c = exactScalar(term[1] === "-" ? -1 : 1);
    const powers = names.map(() => 0);
    for (const factor of term[2].split("*")) {
      const [name, power = "1"] = factor.split("^"), k = names.indexOf(name);
      if (k >= 0) powers[k] += Number(power);
      else if (Number.isNaN(number(factor)))
        refuse(`${matrix}: "${name}" is no number${
          names.length ? `, and no parameter: those are ${names.join(", ")}` : ""}.`);
      else if (!isFinite(Number(factor))) refuse(`${matrix} has NaN or infinite entries`);
      else c = exactTimes(c, exactScalar(Number(factor)));
    }
    const old = terms.get(`${powers}`);
    terms.set(`${powers}`, {c: old ? exactSum(old.c, c) : c, powers});
    rest = rest.slice(term[0].length);
  }
  return [...terms.values()].filter(({c}) => c.at[0]);
}

// {vertices, box, words, rounded} of the texts by name: the matrices at all corners; the box of
// ranges and each matrix in words; and whether a corner has more digits than a number keeps.
export function plants(texts) {
  const box = ranges(texts.ranges ?? "");
  const blocks = Object.fromEntries(NAMES.map(
    name => [name, texts[name].split(/\n\s*\n|;\s*;/).map(text => words(name, text)).filter(X => X.length)]));
  const count = Math.max(1, ...NAMES.map(name => blocks[name].length));
  const odd = NAMES.find(name => blocks[name].length > 1 && blocks[name].length < count);
  if (odd) refuse(`${odd} is there ${blocks[odd].length} times, and another matrix ${count} times.`);
  if (count > 1 && box.length) refuse("Give several plants or ranges, not both.");
  const listed = Array.from({length: count},
    (_, k) =>
      Object.fromEntries(NAMES.map(name => [name, blocks[name][blocks[name].length > 1 ? k : 0] ?? []])));
  const [typed] = listed;
  const found = count > 1 ? listed.map(plant => cornersOf(plant, [])) : [cornersOf(typed, box)];
  const vertices = found.flatMap(({vertices}) => vertices), rounded = found.some(({rounded}) => rounded);
  return {vertices, box, typed, rounded};
}

function cornersOf(typed, box) {
  const names = box.map(({name}) => name);
  const entries = Object.fromEntries(
    NAMES.map(name => [name, typed[name].map(row => row.map(text => polynomial(name, text, names)))]));
  divide(entries, box);
  const all = Object.values(entries).flat(2),
        idle = names.filter((_, k) => !all.flat().some(t => t.powers[k]));
  if (idle.length) refuse(`the plant doesn't depend on ${idle.join(", ")}`);
  const power = names.filter((_, k) => all.flat().some(t => t.powers[k] > 1));
  if (power.length)
    refuse(`${power[0]} has a power above one: this page takes products of different parameters. ` +
      "The package takes powers: sosbook.Uncertain.");
  let rounded = false;
  const places = box.reduce((list, {low, high}) => list.flatMap(p => [[...p, low], [...p, high]]), [[]]);
  const value = (terms, place) => {
    const sum = terms.reduce(
      (sum, {c, powers}) =>
        exactSum(sum, powers.reduce((x, power, k) => power ? exactTimes(x, exactScalar(place[k])) : x, c)),
      exactScalar(0));
    const x = nearly(sum), back = exactScalar(x);
    rounded ||= Boolean(exactSum(sum, {...back, at: [-back.at[0]]}).at[0]);
    return x;
  };
  const vertices = places.map(place => Object.fromEntries(Object.entries(entries).map(
                                ([name, X]) => [name, X.map(row => row.map(terms => value(terms, place)))])));
  return {vertices, rounded};
}

// Each equation divided by the parameters that all its terms have, as in the package: no motion
// changes, and the corners are nearer.
function divide(entries, box) {
  entries.M.forEach((_, i) => {
    const terms = NAMES.flatMap(name => entries[name][i] ?? []).flat();
    box.forEach(({low, high}, k) => {
      const common = Math.min(...terms.map(({powers}) => powers[k]));
      if (!terms.length || !common || low * high <= 0) return;
      for (const term of terms) {
        term.powers[k] -= common;
        if (low < 0 && common % 2) term.c = exactTimes(exactScalar(-1), term.c);
      }
    });
  });
}
