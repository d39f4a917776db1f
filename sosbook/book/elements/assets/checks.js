// A reader's matrices by the checks of the package, with its words: those of
// `SecondOrderSystem`, of its integrators, of x(0) and of a cost.
import {weightFactors} from "../../kernel/exact.js";

import {number} from "./kit.js";
import {dot, leastEigenvalue, solve, transpose} from "./linalg.js";

const SIZES = [1e-100, 1e100], SAME = 1.2, RIDGE = 1e-9;  // as in the package's plants/checks.py
const ROUNDING = 1e-12,
      STEPS = Array.from({length: 12}, (_, k) => 2 ** (k - 51));  // as in requirements/weights.py
// The package's own words, in which a number has the place {}: an element fills them in.
export const refusals = {};
export const said = (name, x = 0) => refusals[name].replace("{}", general(x));

// What is wrong with what a reader wrote, in a sentence for the reader.
export class Fault extends Error {}
export const refuse = words => { throw new Fault(words);};

// As Python's format "g" writes a number.
function general(x, digits = 3) {
  const [mantissa, power] = x.toExponential(digits - 1).split("e"), e = Number(power);
  if (x === 0 || (e >= -4 && e < digits)) return String(Number(x.toPrecision(digits)));
  return `${Number(mantissa)}e${e < 0 ? "-" : "+"}${String(Math.abs(e)).padStart(2, "0")}`;
}

// "1 2; 3 4", lines of words, or [[1, 2], [3, 4]] as Python writes it: rows of words, with a point
// for a decimal comma. "1,5" is one number where a row has blanks as well, or M, D, S would not be
// square otherwise.
export function words(name, text) {
  const lists = /[[\]]/.test(text),
        rows = text.replace(/\]\s*,?\s*\[/g, ";")
                 .replace(/[[\]]/g, " ")
                 .replace(/[ \t]+([-+*])[ \t]+/g, "$1")
                 .split(/[;\n]/)
                 .map(row => row.trim().replace(/\s*,$/, ""))
                 .filter(row => row);
  const glued = lists ? [] : rows.flatMap(row => row.split(/\s+/)).filter(x => /^[^,]+,[^,]/.test(x));
  const commas = glued.length && decimals(name, rows, glued);
  if (commas === undefined)
    refuse(`${name}: "${
      glued[0]}" may be one number or several. Write decimals with a point, and a blank between numbers.`);
  const list = rows.map(row => (commas ? row.replace(/(\d),(\d)/g, "$1.$2") : row).split(/\s*,\s*|\s+/));
  list.forEach((row, k) => {
    if (row.length === list[0].length) return;
    refuse(`${name} must be a real matrix: its rows have different lengths; row ${k + 1} has ${
      row.length} numbers, the first has ${list[0].length}.`);
  });
  return list;
}

// Whether commas between digits are decimal: undefined where nobody can tell.
function decimals(name, rows, glued) {
  const one = /^[-+−]?\d+,\d+(e[-+]?\d+)?$/i, several = row => /\S\s+\S/.test(row);
  if (!glued.every(x => one.test(x)) || /\d\.\d/.test(rows.join()))
    return rows.some(several) ? undefined : false;
  if (rows.some(several)) return true;
  if (!"MDS".includes(name)) return undefined;
  return rows.length !== 2;
}

// The same as rows of numbers.
export function parsed(name, text) {
  const list = words(name, text), word = list.flat().find(x => Number.isNaN(number(x)));
  if (word !== undefined) refuse(`${name}: "${word}" is no number.`);
  return list.map(row => row.map(number));
}

function sized(name, X) {
  const sizes = X.flat().map(Math.abs), largest = Math.max(0, ...sizes);
  const said = `the largest entry of ${name} = ${general(largest)} is`;
  if (!sizes.every(isFinite)) refuse(`${name} has NaN or infinite entries`);
  if (largest > SIZES[1]) refuse(`${said} beyond 1e+100: choose other units`);
  if (largest > 0 && largest < SIZES[0]) refuse(`${said} below 1e-100: choose other units`);
  return X;
}

// Rows and columns are counted where a number says how many there must be.
function matrix(name, X, rows, columns) {
  if (!X.length) refuse(`${name} is missing: give a matrix`);
  sized(name, X);
  const k = X[0].length, root = Math.round(Math.sqrt(k));
  const flat = X.length === 1 && k > 1 && columns > 0
    ? `: it is one row of ${k} numbers. Put a semicolon or a new line between rows` +
      (root * root === k
          ? `, as in ${
              Array.from({length: root}, (_, i) => X[0].slice(i * root, (i + 1) * root).join(" "))
                .join("; ")}`
          : "")
    : "";
  for (const [found, wanted, word] of [[X.length, rows, "rows"], [k, columns, "columns"]]) {
    if (wanted && found !== wanted) refuse(`${name} has ${found} ${word}, needs ${wanted}${flat}`);
  }
  return X;
}

// Singular values by rotations that make rows orthogonal (Hestenes 1958).
function singularValues(X) {
  const rows = X.map(row => [...row]);
  for (let turned = true, count = 0; turned && count < 60; count++) {
    turned = false;
    for (let i = 0; i < rows.length; i++) {
      for (let j = i + 1; j < rows.length; j++) {
        const [p, q] = [rows[i], rows[j]], a = dot(p, p), b = dot(q, q), c = dot(p, q);
        if (Math.abs(c) <= 1e-16 * Math.sqrt(a * b)) continue;
        const z = (b - a) / (2 * c), t = (z < 0 ? -1 : 1) / (Math.abs(z) + Math.hypot(1, z));
        const cos = 1 / Math.hypot(1, t);
        rows[i] = p.map((x, k) => cos * (x - t * q[k]));
        rows[j] = p.map((x, k) => cos * (t * x + q[k]));
        turned = true;
      }
    }
  }
  return rows.map(row => Math.sqrt(dot(row, row)));
}

// Whether X lacks rank whatever the units of its rows and columns are: `rank_deficient`.
function deficient(X, tolerance) {
  const k = X.length, l = X[0].length, N = k + l;
  if (k > l) return true;
  const pairs = Array.from({length: N}, () => Array(N).fill(0));
  const sums = Array.from({length: N}, () => [0]);
  X.forEach((row, i) => row.forEach((x, j) => {
    if (!x) return;
    for (const [p, q] of [[i, k + j], [k + j, i]]) {
      pairs[p][q] = 1;
      pairs[p][p]++;
      sums[p][0] += Math.log(Math.abs(x));
    }
  }));
  pairs.forEach((row, p) => { row[p] += RIDGE; });
  const scales = solve(pairs, sums).map(([x]) => Math.exp(-x));
  let M = X.map((row, i) => row.map((x, j) => scales[i] * x * scales[k + j]));
  const unit = row => {
    const size = Math.hypot(...row) || 1;
    return row.map(x => x / size);
  };
  for (let count = 0; count < 20; count++) {
    const columns = transpose(M.map(unit));
    const lengths = columns.map(c => Math.hypot(...c)).filter(x => x > 0);
    M = transpose(columns.map(unit));
    if (!lengths.length || Math.max(...lengths) < SAME * Math.min(...lengths)) break;
  }
  return singularValues(M).some(x => x <= tolerance);
}

// Why M is no mass matrix, in words; else empty.
function massFault(M) {
  const largest = Math.max(...M.flat().map(Math.abs));
  const skew = Math.max(...M.flatMap((row, i) => row.map((x, j) => Math.abs(x - M[j][i]))));
  if (skew > 1e-9 * largest) return said("skew", skew);
  const lowest = leastEigenvalue(M.map((row, i) => row.map((x, j) => (x + M[j][i]) / 2)));
  return lowest < -1e-9 * largest ? said("negative", lowest) : "";
}

// Where the entries of X beside its diagonal are, if all are on one side.
function side(X) {
  const there = test => X.some((row, i) => row.some((x, j) => x && test(i, j)));
  const above = there((i, j) => i < j), below = there((i, j) => i > j);
  return above === below ? "" : above ? "above" : "below";
}

// What is odd about a plant's matrices, and may be right all the same: `suspicion` of the package.
function suspicion({M, D, S}) {
  const sides =
    Object.entries({M, D, S}).map(([name, X]) => `${name} ${side(X)}`).filter(x => !x.endsWith(" "));
  if (sides.length > (M.length === 2 ? 1 : 0)) return sides.map(x => refusals[x]).join("; ");
  const sizes = M.map((row, i) => Math.abs(row[i])), most = Math.max(...sizes) || 1;
  const scales = sizes.map(x => 1 / Math.sqrt(x || most));
  const fault = massFault(M);
  if (fault) return fault;
  const least =
    leastEigenvalue(M.map((row, i) => row.map((x, j) => scales[i] * scales[j] * (x + M[j][i]) / 2)));
  return Math.abs(least) <= 1e-9 ? said("light", least) : "";
}

// A warning, or nothing; a Fault where there is no such plant, or U doesn't fit it.
export function plant({M, D, S, B, F, U}) {
  const n = M.length;
  for (const [name, X, columns] of [["M", M, n], ["D", D, n], ["S", S, n], ["B", B]])
    matrix(name, X, n, columns);
  if (F.length) matrix("F", F, n);
  if (deficient(M.map((row, i) => [...row, ...B[i]]), 1e-14)) refuse(said("massless"));
  if (U.length) matrix("U", U, 0, n);
  if (deficient(M, 1e-14)) refuse(`${said("singular")}. This page has none: take the package.`);
  const zero = U.length && [
    ...S.map((row, i) => [...row.map(x => -x), ...B[i]]),
    ...U.map(row => [...row, ...Array(B[0].length).fill(0)])
  ];
  if (zero && deficient(zero, 1e-10)) {
    const sizes = U.length > n ? [0] : singularValues(U), most = Math.max(...sizes);
    refuse(said(sizes.some(x => x <= most * n * Number.EPSILON) ? "dependent" : "uncontrollable"));
  }
  return suspicion({M, D, S});
}

export function start(x0, N) {
  const list = sized("x0", x0).flat();
  if (list.length !== N) refuse(`x0 has ${list.length} entries, needs 2n + a = ${N}: [z(0); z'(0); x3(0)]`);
  return list;
}

// Its rank in exact arithmetic; -1 where it isn't semidefinite.
const rank = (X) => {
  try {
    return weightFactors(X).W.rows;
  } catch { return -1; }
};

// The states that Q joins to this one.
function joined(Q, i, known = new Set([i])) {
  Q[i].forEach((x, j) => {
    if (x && !known.has(j)) joined(Q, j, known.add(j));
  });
  return [...known].sort((p, q) => p - q);
}

// A weight of so many rows; one row of numbers is a diagonal. What roundings have
// spoilt is mended, as in requirements/weights.py: the diagonal of Q grows by a few.
export function weight(name, rows, size) {
  const given = rows.length === 1 ? rows[0].map((x, i) => rows[0].map((_, j) => i === j ? x : 0)) : rows;
  matrix(name, given);
  if (given.length !== given[0].length)
    refuse(`${name} must be square, got ${given.length} x ${given[0].length}`);
  const near = (x, i, j) =>
    Math.abs(x - given[j][i]) <= ROUNDING * Math.sqrt(Math.abs(given[i][i] * given[j][j]));
  if (!given.every((row, i) => row.every((x, j) => near(x, i, j)))) refuse(`${name} must be symmetric`);
  const X = given.map((row, i) => row.map((x, j) => x / 2 + given[j][i] / 2));
  if (name === "R" && rank(X) < X.length)
    refuse("R must be positive definite: each input needs a price above zero");
  for (const part of name === "Q" ? X.map((_, i) => joined(X, i)).filter((list, i) => list[0] === i) : []) {
    const larger = step => part.map(i => part.map(j => i === j ? X[i][i] * (1 + step) : X[i][j]));
    const step = [0, ...STEPS].find(step => rank(larger(step)) >= 0);
    if (step === undefined || (step && part.some(i => X[i][i] <= 0))) {
      refuse(`Q has a negative eigenvalue, in the states [${
               part.map(i => i + 1).join(", ")}]: it must be positive semidefinite. ` +
        "A weight of outputs y = C x is given as C");
    }
    for (const i of part) X[i][i] *= 1 + step;
  }
  return matrix(name, X, size, size);
}
