// Matrices {rows, cols, at} of numbers of a ring: floats, or fractions. A number is one with
// `scalar`. (Its name is before that of reader.js, as a page's one script has them in order.)
import {divisor} from "./exact.js";
import {odd} from "./grammar.js";
import {reals, times} from "./matrices.js";

const fraction = (n, d) => {
  if (!d) throw new Error("a division by zero");
  const g = d < 0n ? -divisor(-d, n) : divisor(d, n);
  return g === 1n ? [n, d] : [n / g, d / g];
};

/**
 * Numbers [n, d] of integers, in lowest terms where they would grow: sums and products of
 * decimals don't.
 * @type {any}
 */
export const FRACTIONS = {
  room: n => Array(n),
  zero: [0n, 1n],
  one: [1n, 1n],
  of: text => {
    const [, sign, whole, rest = "", e = 0, over = 1] =
      /^(-?)(\d+)(?:\.(\d+))?(?:e([-+]?\d+))?(?:\/(\d+))?$/.exec(text) ?? odd(`${text} is no number`);
    const places = rest.length - Number(e), n = BigInt(sign + whole + rest);
    return places < 0 ? fraction(n * 10n ** BigInt(-places), BigInt(over))
                      : fraction(n, BigInt(over) * 10n ** BigInt(places));
  },
  plus: ([a, b], [c, d]) => b === d ? [a + c, b]
    : d % b                         ? b % d ? fraction(a * d + c * b, b * d) : [a + c * (b / d), b]
                                    : [a * (d / b) + c, d],
  times: ([a, b], [c, d]) => a && c ? [a * c, b * d] : [0n, 1n],
  over: ([a, b]) => fraction(b, a),
  least: ([a, b]) => fraction(a, b),
  none: ([a]) => a === 0n,
  same: ([a, b], [c, d]) => a * d === c * b,
};

/** @type {any} */
export const NUMBERS = {
  room: reals,
  zero: 0,
  one: 1,
  of: text => text.split("/").map(Number).reduce((a, b) => a / b),
  plus: (a, b) => a + b,
  times: (a, b) => a * b,
  over: a => 1 / a,
  least: a => a,
  none: a => a === 0,
  product: times,
  same: (a, b) => a === b,
};


export class Arithmetic {
  constructor(ring) { this.ring = ring; }

  matrix(rows, cols, entry) {
    const at = this.ring.room(rows * cols);
    for (let i = 0, k = 0; i < rows; i++)
      for (let j = 0; j < cols; j++) at[k++] = entry(i, j);
    return {rows, cols, at};
  }
  unit(n) { return this.matrix(n, n, (i, j) => i === j ? this.ring.one : this.ring.zero); }
  zeros(rows, cols) { return this.matrix(rows, cols, () => this.ring.zero); }
  turned(X) { return {...this.matrix(X.cols, X.rows, (i, j) => X.at[j * X.cols + i]), scalar: X.scalar}; }

  entries({rows, cols, scalar}, entry) {
    const at = this.ring.room(rows * cols);
    for (let k = 0; k < at.length; k++) at[k] = entry(k);
    return {rows, cols, scalar, at};
  }
  scaled(f, X) { return this.entries(X, k => this.ring.times(f, X.at[k])); }
  product(X, Y) {
    if (X.scalar || Y.scalar) {
      const S = X.scalar ? this.scaled(X.at[0], Y) : this.scaled(Y.at[0], X);
      return {...S, scalar: X.scalar && Y.scalar};
    }
    if (X.cols !== Y.rows) odd("a product of shapes that don't fit");
    const {plus, times, zero, none, product} = this.ring;
    if (product) return product(X, Y);
    return this.matrix(X.rows, Y.cols, (i, j) => {
      let sum = zero;
      for (let k = 0; k < X.cols; k++) {
        const x = X.at[i * X.cols + k], y = Y.at[k * Y.cols + j];
        if (!none(x) && !none(y)) sum = plus(sum, times(x, y));
      }
      return sum;
    });
  }
  sum(X, Y) {
    if (!X.scalar !== !Y.scalar) {  // a number stands for that multiple of the identity
      const [f, M] = X.scalar ? [X, Y] : [Y, X];
      return this.sum(M, this.scaled(f.at[0], this.unit(M.rows)));
    }
    if (X.rows !== Y.rows || X.cols !== Y.cols) odd("a sum of two shapes");
    return this.entries(X, k => this.ring.plus(X.at[k], Y.at[k]));
  }
  kronecker(F, X) {
    const {rows, cols} = X;
    return this.matrix(F.rows * rows, F.cols * cols,
      (i, j) => this.ring.times(
        F.at[Math.floor(i / rows) * F.cols + Math.floor(j / cols)], X.at[i % rows * cols + j % cols]));
  }
  inverse(X) {
    const n = X.rows, {plus, times, over, none, least} = this.ring;
    if (n !== X.cols) odd("the inverse of a matrix that isn't square");
    const minus = this.ring.of("-1"),
          rows = Array.from({length: n},
            (_, i) => [...X.at.slice(i * n, (i + 1) * n), ...this.unit(n).at.slice(i * n, (i + 1) * n)]);
    for (let k = 0; k < n; k++) {
      const size = i => none(rows[i][k]) ? 0 : this.ring === NUMBERS ? Math.abs(rows[i][k]) : 1;
      let top = k;
      for (let i = k + 1; i < n; i++) top = size(i) > size(top) ? i : top;
      if (!size(top)) odd("a matrix that must be regular is singular");
      [rows[k], rows[top]] = [rows[top], rows[k]];
      const f = over(rows[k][k]);
      rows[k] = rows[k].map(x => least(times(f, x)));
      rows.forEach((row, i) => {
        const g = times(minus, row[k]);
        if (i !== k && !none(g)) rows[i] = row.map((x, j) => least(plus(x, times(g, rows[k][j]))));
      });
    }
    return this.matrix(n, n, (i, j) => rows[i][n + j]);
  }
}
