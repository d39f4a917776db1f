// What a text of the proof files' language says of matrices, in floats or in fractions.
//
// A value is {X, terms}: the sum of a matrix and of products {of, flip, a, L, R} in unknowns,
// a L X R or a L X' R with a number a.
import {Arithmetic} from "./arithmetic.js";
import {odd, parsedLine} from "./grammar.js";

// The reader of a ring of numbers: FRACTIONS or NUMBERS.
export class Reader extends Arithmetic {
  // env: values by name, see `known` and `unknown`.
  constructor(ring, env = {}) {
    super(ring);
    /** @type {any} */
    this.env = {...env};
  }

  number(x) { return {X: {rows: 1, cols: 1, at: [x], scalar: true}, terms: []}; }
  // Data: lists of lists of texts or numbers, or one of them.
  known(data) {
    const of = x => this.ring.of(String(x));
    if (data.zeros) return {X: this.zeros(...data.zeros), terms: []};
    if (!Array.isArray(data)) return this.number(of(data));
    return {X: this.matrix(data.length, data[0].length, (i, j) => of(data[i][j])), terms: []};
  }
  unknown(of, rows, cols, scalar = false) {
    const X = {...this.zeros(rows, cols), scalar};
    return {X, terms: [{of, scalar, flip: false, a: this.ring.one, L: this.unit(rows), R: this.unit(cols)}]};
  }

  certain(value, words) { return value.terms.length ? odd(`${words} of an unknown`) : value.X; }
  size(x) {
    const X = this.certain(this.value(x), "a size"), [n] = X.at,
          k = !X.scalar  ? NaN
      : Array.isArray(n) ? Number(n[0]) / Number(n[1])
                         : n;
    return Number.isInteger(k) && k >= 0 && k < 2000 ? k : odd("no size");
  }

  // A value from one, by what becomes of L X R: the constant by `whole`, factors by the others.
  mapped({X, terms}, whole, left, right) {
    return {X: whole(X), terms: terms.map(t => ({...t, L: left(t.L), R: right(t.R)}))};
  }

  multiple(f, {X, terms}) {
    return {X: this.scaled(f, X), terms: terms.map(t => ({...t, a: this.ring.times(f, t.a)}))};
  }

  value([op, ...parts]) {
    const same = X => X;
    const row = (n, k) => this.matrix(1, n, (_, j) => j === k ? this.ring.one : this.ring.zero);
    if (op === "number") return this.number(this.ring.of(parts[0]));
    if (op === "name") return this.env[parts[0]] ?? odd(`${parts[0]} isn't known`);
    if (op === "block") return this.block(parts[0]);
    if (op === "I") return {X: this.unit(this.size(parts[0])), terms: []};
    if (op === "O") return {X: this.zeros(this.size(parts[0]), this.size(parts[1])), terms: []};
    if (op === "pick") {
      const [k, p, n] = parts.map(x => this.size(x));
      if (k < 1 || k > p) odd("no such part");
      return {X: this.kronecker(row(p, k - 1), this.unit(n)), terms: []};
    }
    if (op === "pow") {
      const x = this.certain(this.value(parts[0]), "a power"), k = this.size(parts[1]);
      if (!x.scalar) odd("a power of a matrix");
      return this.number(Array(k).fill(x.at[0]).reduce(this.ring.times, this.ring.one));
    }
    const a = this.value(parts[0]);
    if (op === "neg") return this.multiple(this.ring.of("-1"), a);
    if (op === "T") return this.mirrored(a);
    if (op === "he") return this.added(a, this.mirrored(a));
    if (op === "rows" || op === "cols") return this.number(this.ring.of(String(a.X[op])));
    if (op === "inv") {
      const X = this.certain(a, "the inverse");
      return X.scalar ? this.number(this.ring.over(X.at[0])) : {X: this.inverse(X), terms: []};
    }
    if (op === "at") {
      const X = this.certain(a, "an entry"), [i, j] = parts.slice(1).map(x => this.size(x));
      return i < 1 || j < 1 || i > X.rows || j > X.cols ? odd("no such entry")
                                                        : this.number(X.at[(i - 1) * X.cols + j - 1]);
    }
    if (op === "tr") {
      const n = a.X.rows;
      if (n !== a.X.cols) odd("the trace of a matrix that isn't square");
      let total = this.number(this.ring.zero);
      for (let k = 0; k < n; k++) {
        const e = row(n, k), left = X => this.product(e, X), right = X => this.product(X, this.turned(e));
        total = this.added(total, this.mapped(a, X => ({...right(left(X)), scalar: true}), left, right));
      }
      return total;
    }
    const b = this.value(parts[1]);
    if (op === "add") return this.added(a, b);
    if (op === "kron") {
      const F = this.certain(a, "kron"), {X, terms} = b,
            column = j => this.matrix(F.rows, 1, i => F.at[i * F.cols + j]);
      const cut = (t, j) =>
        ({...t, L: this.kronecker(column(j), t.L), R: this.kronecker(row(F.cols, j), t.R)});
      return {
        X: this.kronecker(F, X),
        terms: terms.flatMap(t => Array.from({length: F.cols}, (_, j) => cut(t, j)))
      };
    }
    if (op === "div") {
      const f = this.ring.over(this.certain(b, "a division").at[0]);
      return b.X.scalar ? this.multiple(f, a) : odd("a division by a matrix");
    }
    if (op !== "mul") odd(`${op} isn't known`);
    if (a.terms.length && b.terms.length) odd("a product of two unknowns");
    const [x, B] = a.terms.length ? [a, b.X] : [b, a.X], front = x === b;
    if (x.X.scalar && !B.scalar) return this.spread(x, B);
    if (B.scalar) return this.multiple(B.at[0], x);
    const by = X => front ? this.product(B, X) : this.product(X, B);
    return front ? this.mapped(x, by, by, same) : this.mapped(x, by, same, by);
  }

  added(a, b) {
    const [x, y] = a.X.scalar && !b.X.scalar && a.terms.length ? [this.spread(a, this.unit(b.X.rows)), b]
      : b.X.scalar && !a.X.scalar && b.terms.length            ? [a, this.spread(b, this.unit(a.X.rows))]
                                                               : [a, b];
    return {X: this.sum(x.X, y.X), terms: [...x.terms, ...y.terms]};
  }
  mirrored({X, terms}) {
    return {
      X: this.turned(X),
      terms: terms.map(t => ({...t, flip: !t.flip, L: this.turned(t.R), R: this.turned(t.L)}))
    };
  }
  // An unknown number times a certain matrix, by its columns.
  spread(x, B) {
    const columns = Array.from({length: B.cols}, (_, j) => j);
    const terms = x.terms.flatMap(t => columns.map(j => ({
      ...t,
      L: this.product(this.matrix(B.rows, 1, i => B.at[i * B.cols + j]), t.L),
      R: this.product(t.R, this.matrix(1, B.cols, (_, k) => j === k ? this.ring.one : this.ring.zero))
    })));
    return {X: this.product(x.X, B), terms};
  }

  block(rows) {
    const nought = (i, j) => String(rows[i][j]) === "number,0", n = rows.length, m = rows[0].length;
    if (rows.some(row => row.length !== m)) odd("the rows of a block matrix differ");
    /** @type {any[][]} */
    const e = rows.map(row => row.map(x => x[0] === "mirror" ? null : this.value(x)));
    const zero =
      rows.map((row, i) => row.map((x, j) => x[0] === "mirror" ? j < i && nought(j, i) : nought(i, j)));
    e.forEach((row, i) => row.forEach((x, j) => {
      if (!x) row[j] = j < i && e[j]?.[i] ? this.mirrored(e[j][i]) : odd("a mirror image of nothing");
    }));
    const high = Array(n).fill(null), wide = Array(m).fill(null);  // a block may have no rows
    const tell = (list, k, size) => {
      if ((list[k] ??= size) !== size) odd("blocks that don't fit");
    };
    e.forEach((row, i) => row.forEach(({X}, j) => {
      if (!X.scalar) tell(high, i, X.rows), tell(wide, j, X.cols);
    }));
    for (let k = 0; k < n + m; k++)
      e.forEach((row, i) => row.forEach(({X}, j) => {
        const size = high[i] ?? wide[j];
        if (X.scalar && !zero[i][j] && size !== null) tell(high, i, size), tell(wide, j, size);
      }));
    let top = 0;
    const h = high.map(x => x ?? 1), w = wide.map(x => x ?? 1), q = w.reduce((a, b) => a + b, 0);
    const height = h.reduce((a, b) => a + b, 0), total = this.zeros(height, q), terms = [];
    e.forEach((row, i) => {
      let left = 0;
      row.forEach((x, j) => {
        if (!zero[i][j]) {
          const {X, terms: inner} = !x.X.scalar ? x
            : x.terms.length                    ? this.spread(x, this.unit(h[i]))
                                                : {X: this.scaled(x.X.at[0], this.unit(h[i])), terms: []};
          const [r0, c0] = [top, left];
          X.at.forEach((v, k) => { total.at[(r0 + Math.floor(k / X.cols)) * q + c0 + k % X.cols] = v; });
          for (const t of inner)
            terms.push({
              ...t,
              L: this.matrix(height, t.L.cols,
                (k, l) => k >= r0 && k < r0 + h[i] ? t.L.at[(k - r0) * t.L.cols + l] : this.ring.zero),
              R: this.matrix(
                t.R.rows, q, (k, l) => l >= c0 && l < c0 + w[j] ? t.R.at[k * w[j] + l - c0] : this.ring.zero)
            });
        }
        left += w[j];
      });
      top += h[i];
    });
    return {X: total, terms};
  }

  equal({X, terms}, {X: Y, terms: others}) {
    return !terms.length && !others.length && X.rows === Y.rows && X.cols === Y.cols &&
      this.sum(X, this.scaled(this.ring.of("-1"), Y)).at.every(this.ring.none);
  }

  // What a text says: {name, mark, value, right} of its statements, in order; sets: lists of
  // words by name. Names that are `given` aren't defined again.
  * statements(text, sets = {}, given = []) {
    /** @type {any} */
    let loop = {words: [], values: [[]]};
    /** @type {any[]} */
    const steps = [];
    for (const line of text.split("\n")) {
      const open = /^for (\w+(?:, \w+)*) in (\w+):/.exec(line), inner = /^\s/.test(line);
      if (open)
        loop = {
          words: open[1].split(", "),
          values: sets[open[2]] ?? odd(`there is no set ${open[2]}`),
          body: []
        };
      else if (!inner || !loop.body) loop = {words: [], values: [[]], body: []};
      if (!inner || open) steps.push(loop);
      const step = open ? null : parsedLine(line);
      if (step) loop.body.push(step);
    }
    for (const {words, values, body} of steps)
      for (const some of values)
        for (const step of body)
          yield* this.said(step, Object.fromEntries(words.map((word, k) => [word, some[k]])), given);
  }
  * said({name, mark, x, right}, at, given) {
    const called = text => text.split(".").map((word, k) => k && at[word] || word).join(".");
    const renamed = x => !Array.isArray(x) ? x : x[0] === "name" ? ["name", called(x[1])] : x.map(renamed);
    if (mark === "=" && given.includes(called(name))) return;
    const value = this.value(renamed(x));
    if (mark === "=") this.env[called(name)] = value;
    else {
      const other = this.value(renamed(right)), X = this.certain(other, "on the right of a statement");
      if (mark !== "==" && !(X.scalar && this.ring.none(X.at[0]))) odd("a matrix is positive, or it isn't");
      yield {name: called(name), mark, value, right: other};
    }
  }
}
