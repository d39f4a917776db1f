// Exact arithmetic: matrices of decimals, {rows, cols, at, places}, whose entries are
// BigInt multiples of 10^-places. No division is needed, so nothing is rounded.

// A float as Python writes it: the shortest decimal that is read back as it.
export function decimal(x) {
  if (!isFinite(x)) throw new Error(`${x} is no decimal number`);
  const [mantissa, power] = (x + 0 || 0).toExponential().split("e"), e = Number(power);
  if (x === 0 || (e >= -4 && e < 16)) return fixed(mantissa, e);
  return `${mantissa}e${e < 0 ? "-" : "+"}${String(Math.abs(e)).padStart(2, "0")}`;
}

function fixed(mantissa, e) {
  const sign = mantissa.startsWith("-") ? "-" : "", digits = mantissa.replace(/[-.]/g, "");
  if (e < 0)
    return sign + "0." +
      "0".repeat(-e - 1) + digits;
  const whole = digits.slice(0, e + 1).padEnd(e + 1, "0"), rest = digits.slice(e + 1);
  return sign + whole + (rest ? "." + rest : "");
}

export const decimals = list => list.map(x => Array.isArray(x) ? decimals(x) : decimal(x));

// The decimal as [BigInt, places].
/** @returns {[bigint, number]} */
function parsed(x) {
  const [, sign, whole, rest = "", e = 0] = /^(-?)(\d+)(?:\.(\d+))?(?:e([-+]\d+))?$/.exec(decimal(x));
  const value = BigInt(sign + whole + rest), places = rest.length - Number(e);
  return places < 0 ? [value * 10n ** BigInt(-places), 0] : [value, places];
}

export function exactMatrix(list, cols = list.length ? list[0].length : 0) {
  const entries = list.flat().map(parsed), places = Math.max(0, ...entries.map(([, p]) => p));
  return {rows: list.length, cols, places, at: entries.map(([v, p]) => v * 10n ** BigInt(places - p))};
}

export const exactScalar = x => exactMatrix([[x]]);

export function exactTimes(X, Y) {
  const at = new Array(X.rows * Y.cols).fill(0n);
  /** @type {any[]} */
  const rows = [];
  for (let k = 0; k < Y.rows; k++) {
    rows.push([]);
    for (let j = 0; j < Y.cols; j++)
      if (Y.at[k * Y.cols + j] !== 0n) rows[k].push([j, Y.at[k * Y.cols + j]]);
  }
  for (let i = 0; i < X.rows; i++) {
    for (let k = 0; k < X.cols; k++) {
      const x = X.at[i * X.cols + k];
      if (x !== 0n)
        for (const [j, y] of rows[k]) at[i * Y.cols + j] += x * y;
    }
  }
  return {rows: X.rows, cols: Y.cols, places: X.places + Y.places, at};
}

export function exactTransposed(X) {
  const at = [];
  for (let j = 0; j < X.cols; j++)
    for (let i = 0; i < X.rows; i++) at.push(X.at[i * X.cols + j]);
  return {rows: X.cols, cols: X.rows, places: X.places, at};
}

export const exactScaled = (s, X) => ({...X, places: X.places + s.places, at: X.at.map(x => s.at[0] * x)});

export const atPlaces = (X, places) => {
  const unit = 10n ** BigInt(places - X.places);
  return unit === 1n ? X : {...X, places, at: X.at.map(x => x * unit)};
};

// The same matrices, all with the places of the longest.
export const alike = list => list.map(X => atPlaces(X, Math.max(...list.map(({places}) => places))));

export function exactSum(X, Y) {
  const places = Math.max(X.places, Y.places), at = atPlaces(X, places).at.slice();
  atPlaces(Y, places).at.forEach((y, k) => { at[k] += y; });
  return {...X, places, at};
}

// sum X_ij Y_ij, a 1 x 1 matrix
export function exactInner(X, Y) {
  /** @type {any} */
  let sum = 0n;
  X.at.forEach((x, k) => {
    if (x !== 0n) sum += x * Y.at[k];
  });
  return {rows: 1, cols: 1, places: X.places + Y.places, at: [sum]};
}

/** @returns {any} */
export const exactZeros = (rows, cols) => ({rows, cols, places: 0, at: new Array(rows * cols).fill(0n)});

// The nearest float to a scalar, whatever its length.
export const nearly = ({places, at}) => Number(`${at[0]}e-${places}`);

// The same operations as those of FLOATS.
export const EXACT = {
  matrix: exactMatrix,
  zeros: exactZeros,
  transposed: exactTransposed,
  times: exactTimes,
  identity: (n, value = 1) => {
    const s = exactScalar(value), X = exactZeros(n, n);
    for (let i = 0; i < n; i++) X.at[i * n + i] = s.at[0];
    return {...X, places: s.places};
  },
  scaled: (a, X) => exactScaled(exactScalar(a), X),
  combined: (a, X, b, Y) => exactSum(EXACT.scaled(a, X), EXACT.scaled(b, Y)),
  place: (X, top, left, Y, ...factors) => {
    for (const a of factors) Y = EXACT.scaled(a, Y);
    if (Y.places > X.places) Object.assign(X, atPlaces(X, Y.places));
    Y = atPlaces(Y, X.places);
    for (let i = 0; i < Y.rows; i++)
      for (let j = 0; j < Y.cols; j++) X.at[(top + i) * X.cols + left + j] += Y.at[i * Y.cols + j];
    return X;
  },
};

// Whether a symmetric matrix is positive definite: all its leading minors, by the
// elimination of Bareiss, whose divisions leave no remainder.
export function definite({rows: n, at}) {
  for (let i = 0; i < n; i++)
    for (let j = 0; j < i; j++)
      if (at[i * n + j] !== at[j * n + i]) return false;
  /** @type {any} */
  let last = 1n;
  let rows = Array.from({length: n}, (_, i) => at.slice(i * n + i, (i + 1) * n));
  while (rows.length) {
    const [head, ...others] = rows, lead = head[0];
    if (lead <= 0n) return false;
    rows = others.map((row, k) => row.map((x, j) => (lead * x - head[k + 1] * head[k + 1 + j]) / last));
    last = lead;
  }
  return true;
}

// The sign of the determinant, by the same elimination with exchanged rows.
export function signOfDeterminant(at, n) {
  /** @type {any} */
  let last = 1n;
  let rows = Array.from({length: n}, (_, i) => at.slice(i * n, (i + 1) * n)), sign = 1;
  while (rows.length) {
    const top = rows.findIndex(([x]) => x);
    if (top < 0) return 0;
    const [head] = rows.splice(top, 1);
    if (top % 2) sign = -sign;
    rows = rows.map(row => row.slice(1).map((x, j) => (head[0] * x - row[0] * head[j + 1]) / last));
    last = head[0];
  }
  return last > 0n ? sign : -sign;
}

// {L, W, d} with Q = L inv(W) L' for a positive semidefinite Q, else an Error: W is diagonal,
// and the columns of L are those that begin with one, times d (Bareiss, with a common factor
// taken out). Nothing of Q is left out.
export function weightFactors(Q) {
  const {at, places, rows: N} = exactMatrix(Q), columns = [], W = [], d = [];
  /** @type {any} */
  let last = 1n;
  let rest = Array.from({length: N}, (_, i) => at.slice(i * N, (i + 1) * N));
  const unit = 10n ** BigInt(places);
  for (let k = 0; k < N; k++) {
    const pivot = rest[k][k], column = rest.map(row => row[k]), head = rest[k];
    if (pivot <= 0n) continue;
    const g = column.reduce(divisor, last), e = String(pivot / g).length - 1;
    columns.push({at: column.map(x => x / g), places: e});
    W.push({at: [unit * last * pivot / g / g], places: 2 * e});
    d.push({at: [pivot / g], places: e});
    rest = rest.map((row, i) => row.map((x, j) => (pivot * x - column[i] * head[j]) / last));
    last = pivot;
  }
  if (rest.some(row => row.some(x => x)))
    throw new Error("Q has a negative eigenvalue: it must be positive semidefinite.");
  const along = list => list.reduce(
    (X, x, k) => EXACT.place(X, k, k, {rows: 1, cols: 1, ...x}), exactZeros(list.length, list.length));
  const L = columns.reduce(
    (X, x, k) => EXACT.place(X, 0, k, {rows: N, cols: 1, ...x}), exactZeros(N, columns.length));
  return {L, W: along(W), d: along(d)};
}

// The greatest common divisor, for x of any sign and y > 0.
export function divisor(y, x) {
  let a = x < 0n ? -x : x;
  while (a) [y, a] = [a, y % a];
  return y;
}

// x / y in lowest terms, for y > 0.
export function ratio(x, y) {
  const a = divisor(y, x);
  return y === a ? String(x / a) : `${x / a}/${y / a}`;
}

// ------------------------------------------------- correctly rounded functions
const BITS = 240n, UNIT = 1n << BITS;
const PI =
  31415926535897932384626433832795028841971693993751058209749445923078164062862089986280348253421170679n;

// sine and cosine of angle / UNIT, times UNIT, by Taylor's series.
function sineCosine(angle) {
  let sin = 0n, cos = 0n, term = UNIT;
  for (let k = 1n; term !== 0n; k++) {
    if (k % 2n) cos += k % 4n === 1n ? term : -term;
    else sin += k % 4n === 2n ? term : -term;
    term = term * angle / (UNIT * k);
  }
  return [sin, cos];
}

const float = x => Number(x) / 2 ** Number(BITS);

// The pair (sin, cos) of a sector, rounded inwards as the package rounds it, and its
// half-angle in degrees, rounded up to a hundredth, as text: that of their decimals.
// The angle is the smaller one of the float and of its decimal, which a file holds.
export function sector(theta) {
  const binary = floatExactly(theta), [digits, places] = parsed(theta);
  const read = digits * UNIT / 10n ** BigInt(places);
  const [s, c] = sineCosine(read < binary ? read : binary);
  const sin = float(s) * (1 - 4 * Number.EPSILON), cos = float(c) * (1 + 4 * Number.EPSILON);
  const [S, p] = parsed(sin), [C, q] = parsed(cos), left = S * 10n ** BigInt(q);
  const right = C * 10n ** BigInt(p);
  let h = Math.max(0, Math.floor(theta * 18000 / Math.PI) - 2);
  for (;; h++) {
    const angle = PI * UNIT * BigInt(h) / (18000n * 10n ** 100n), [sinH, cosH] = sineCosine(angle);
    if (left * cosH <= sinH * right) return {sin, cos, degrees: decimal(h / 100)};
  }
}

// A float times UNIT, exactly (it has at least 2^-180 for its last bit).
function floatExactly(x) {
  let scale = 0n;
  while (!Number.isInteger(x)) {
    x *= 2;
    scale++;
  }
  return BigInt(x) * UNIT >> scale;
}

// A float that isn't below 2 sigma, as a binary number and as a decimal.
export function twiceAtLeast(sigma) {
  const [value, places] = parsed(sigma);
  let bound = 2 * sigma;
  for (;;) {
    const [b, p] = parsed(bound), common = Math.max(p, places);
    if (b * 10n ** BigInt(common - p) >= 2n * value * 10n ** BigInt(common - places)) return bound;
    const bytes = new Float64Array([bound]), bits = new BigInt64Array(bytes.buffer);
    bits[0] += 1n;  // the next float
    bound = bytes[0];
  }
}

// ------------------------------------------------------------------- SHA-256
// FIPS 180-4, of an ASCII text, as hexadecimal digits. Its constants are the fractions
// of the roots of the first primes.
export function sha256(text) {
  const primes = [];
  for (let k = 2; primes.length < 64; k++)
    if (primes.every(p => k % p)) primes.push(k);
  const fraction = x => (x - Math.floor(x)) * 2 ** 32 | 0, turn = (x, n) => x >>> n | x << 32 - n;
  const K = primes.map(p => fraction(Math.cbrt(p)));
  const H = primes.slice(0, 8).map(p => fraction(Math.sqrt(p)));
  const bytes = [...text].map(c => c.charCodeAt(0)), bits = bytes.length * 8;
  bytes.push(128);
  while (bytes.length % 64 !== 56) bytes.push(0);
  for (let k = 7; k >= 0; k--) bytes.push(Math.floor(bits / 2 ** (8 * k)) & 255);
  for (let from = 0; from < bytes.length; from += 64) {
    const w = [];
    for (let t = 0; t < 64; t++) {
      if (t < 16) {
        const b = from + 4 * t;
        w[t] = bytes[b] << 24 | bytes[b + 1] << 16 | bytes[b + 2] << 8 | bytes[b + 3];
        continue;
      }
      const x = w[t - 15], y = w[t - 2];
      w[t] =
        w[t - 16] + (turn(x, 7) ^ turn(x, 18) ^ x >>> 3) + w[t - 7] + (turn(y, 17) ^ turn(y, 19) ^ y >>> 10) |
        0;
    }
    let [a, b, c, d, e, f, g, h] = H;
    for (let t = 0; t < 64; t++) {
      const one = h + (turn(e, 6) ^ turn(e, 11) ^ turn(e, 25)) + (e & f ^ ~e & g) + K[t] + w[t] | 0;
      const two = (turn(a, 2) ^ turn(a, 13) ^ turn(a, 22)) + (a & b ^ a & c ^ b & c) | 0;
      [a, b, c, d, e, f, g, h] = [one + two | 0, a, b, c, d + one | 0, e, f, g];
    }
    [a, b, c, d, e, f, g, h].forEach((x, k) => { H[k] = H[k] + x | 0; });
  }
  return H.map(x => (x >>> 0).toString(16).padStart(8, "0")).join("");
}
