// LMI blocks G(X, Y, ...) = G0 + sum (L X R + R' X' L') + sum s Gs: unknown matrices
// stand in products, unknown scalars s have symmetric matrices Gs.
import {accumulate, copied, inner, mapped, place, reals, symmetrized, times, transposed, zeros} from "./matrices.js";

export class Blocks {
  // unknowns: {name: {rows, cols, symmetric}}; a 1 x 1 unknown is a scalar.
  constructor(unknowns) {
    this.unknowns = [];
    this.list = [];
    let from = 0;
    for (const [name, {rows, cols, symmetric = false}] of Object.entries(unknowns)) {
      const size = symmetric ? rows * (rows + 1) / 2 : rows * cols;
      this.unknowns.push({name, rows, cols, symmetric, from, size, scalar: size === 1 && !symmetric});
      from += size;
    }
    this.size = from;
  }

  // terms: [name, L, R] each; slopes: [name, Gs] each. Powers of two bring the
  // diagonal near one, which rounds nothing.
  add(name, constant, terms, slopes = []) {
    const q = constant.rows, size = new Float64Array(q);
    const index = key => this.unknowns.findIndex(u => u.name === key);
    for (let i = 0; i < q; i++) {
      size[i] = Math.abs(constant.at[i * q + i]);
      for (const [, G] of slopes) size[i] += Math.abs(G.at[i * q + i]);
      for (const [, L, R] of terms) size[i] += 2 * rowLength(L, i) * columnLength(R, i);
    }
    const d = size.map(x => 2 ** Math.round(-Math.log2(x || 1) / 2));
    const both = X => mapped(X, (x, i, j) => x * d[i] * d[j]);
    const scaled = slopes.map(([key, G]) => ({of: index(key), G: both(G)}));
    const block = {name, q, d, constant: both(constant), slopes: scaled};
    block.terms = terms.map(([key, L, R]) => {
      const left = mapped(L, (x, i) => x * d[i]), right = mapped(R, (x, _, j) => x * d[j]);
      return {of: index(key), L: left, R: right, Lt: transposed(left), Rt: transposed(right)};
    });
    let width = 0;
    for (const term of block.terms) {
      term.left = width;
      width += term.L.cols;
    }
    const first = new Map();  // the R of several unknowns stands in C once
    block.terms.forEach((term, k) => {
      const R = terms[k][2];
      if (first.has(R)) term.right = first.get(R).right;
      else {
        first.set(R, term);
        term.right = width;
        width += R.rows;
      }
    });
    block.C = zeros(q, width);
    for (const {L, left} of block.terms) place(block.C, 0, left, L);
    for (const {Rt, right} of first.values()) place(block.C, 0, right, Rt);
    block.transposed = transposed(block.C);
    this.list.push(block);
    return this;
  }

  get degree() { return this.list.reduce((sum, {q}) => sum + q, 0); }
  get homogeneous() { return this.list.every(({constant}) => constant.at.every(x => x === 0)); }

  unpacked(x) {
    return this.unknowns.map(({rows, cols, symmetric, from}) => {
      const X = zeros(rows, cols);
      for (let i = 0, k = from; i < rows; i++) {
        for (let j = symmetric ? i : 0; j < cols; j++, k++) {
          X.at[i * cols + j] = x[k];
          if (symmetric) X.at[j * cols + i] = x[k];
        }
      }
      return X;
    });
  }

  packed(values) {
    const x = new Float64Array(this.size);
    for (const {name, rows, cols, symmetric, from} of this.unknowns) {
      for (let i = 0, k = from; i < rows; i++) {
        for (let j = symmetric ? i : 0; j < cols; j++, k++) x[k] = values[name].at[i * cols + j];
      }
    }
    return x;
  }

  // All blocks at x; without their constants where `linear`.
  at(x, linear = false) {
    const X = this.unpacked(x);
    return this.list.map(({q, constant, terms, slopes}) => {
      const half = zeros(q, q);
      for (const {of, L, R} of terms) accumulate(half, times(L, X[of]), R);
      const G = linear ? zeros(q, q) : {rows: q, cols: q, at: copied(constant.at)}, g = G.at;
      const h = half.at;
      for (let i = 0; i < q; i++)
        for (let j = 0; j < q; j++) g[i * q + j] += h[i * q + j] + h[j * q + i];
      for (const {of, G: slope} of slopes) place(G, 0, 0, slope, X[of].at[0]);
      return G;
    });
  }

  // <G_a, M> for every variable a; the M are symmetric, one for each block.
  adjoint(M) {
    const g = new Float64Array(this.size);
    this.list.forEach(({terms, slopes}, k) => {
      for (const {of, Lt, Rt} of terms) fold(g, this.unknowns[of], times(times(Lt, M[k]), Rt).at, 2);
      for (const {of, G} of slopes) g[this.unknowns[of].from] += inner(G, M[k]);
    });
    return g;
  }

  // H_ab = sum <G_a, W G_b Z> over the blocks. Each product L X R makes it a sum of
  // Kronecker products of parts of C'WC and C'ZC, with C = [L .. R' ..].
  hessian(W, Z) {
    const n = this.size, H = zeros(n, n);
    this.list.forEach((block, k) => {
      const CW = times(block.transposed, times(W[k], block.C));
      const CZ = W === Z ? CW : times(block.transposed, times(Z[k], block.C));
      for (const s of block.terms) {
        for (const t of block.terms)
          if (t.of >= s.of) this.pair(H, block, s, t, CW.at, CZ.at);
      }
      for (const {of, G} of block.slopes) this.scalar(H, block, of, times(times(W[k], G), Z[k]));
    });
    for (let i = 0; i < n; i++)
      for (let j = 0; j < i; j++) H.at[i * n + j] = H.at[j * n + i];
    return H;
  }

  // The part of two terms s and t; above the diagonal alone where they are of one unknown.
  pair(H, block, s, t, CW, CZ) {
    const X = this.unknowns[s.of], Y = this.unknowns[t.of], same = s.of === t.of, w = block.C.cols;
    const n = this.size;
    const {rows: r, cols: c} = Y, F = reals(r * c), h = H.at;
    const both = CW !== CZ, double = both ? 1 : 2;
    const gather = (i, j, top) => {
      const li = (s.left + i) * w, rj = (s.right + j) * w;
      for (let k = top; k < r; k++) {
        const from = li + t.left + k, to = rj + t.left + k, d = CZ[from], g = CZ[to], a = CW[to];
        const e = CW[from], end = (k + 1) * c;
        let l = li + t.right, m = rj + t.right;
        if (both)
          for (let f = k * c; f < end; f++, l++, m++)
            F[f] = F[f] + (d * CW[m] + g * CW[l]) + (a * CZ[l] + e * CZ[m]);
        else
          for (let f = k * c; f < end; f++, l++, m++) F[f] += d * CW[m] + g * CW[l];
      }
    };
    let row = X.from;
    for (let i = 0; i < X.rows; i++) {
      for (let j = X.symmetric ? i : 0; j < X.cols; j++, row++) {
        const top = same ? i : 0;
        F.fill(0, top * c);
        gather(i, j, top);
        if (X.symmetric && i !== j) gather(j, i, top);
        for (let k = 0, column = row * n + Y.from; k < r; k++) {
          if (k < top) {
            column += Y.symmetric ? c - k : c;
            continue;
          }
          for (let l = Y.symmetric ? k : 0; l < c; l++, column++) {
            h[column] += double * (F[k * c + l] + (Y.symmetric && l !== k ? F[l * c + k] : 0));
          }
        }
      }
    }
  }

  // The part of a scalar, whose V = W Gs Z was formed: <G_a, V> for all variables.
  scalar(H, block, of, V) {
    const n = this.size, me = this.unknowns[of].from, g = new Float64Array(n);
    symmetrized(V);
    for (const {of: other, Lt, Rt} of block.terms)
      fold(g, this.unknowns[other], times(times(Lt, V), Rt).at, 2);
    for (const {of: other, G} of block.slopes) {
      const you = this.unknowns[other].from;
      if (you >= me) H.at[me * n + you] += inner(G, V);
    }
    for (let b = 0; b < n; b++) H.at[Math.min(b, me) * n + Math.max(b, me)] += g[b];
  }
}

function rowLength(X, i) { return Math.hypot(...X.at.slice(i * X.cols, (i + 1) * X.cols)); }

function columnLength(X, j) {
  let sum = 0;
  for (let i = 0; i < X.rows; i++) sum += X.at[i * X.cols + j] ** 2;
  return Math.sqrt(sum);
}

// Adds a derivative by the entries of X to that by its variables.
function fold(g, {rows, cols, symmetric, from}, F, factor) {
  for (let i = 0, k = from; i < rows; i++) {
    for (let j = symmetric ? i : 0; j < cols; j++, k++) {
      g[k] += factor * (F[i * cols + j] + (symmetric && i !== j ? F[j * cols + i] : 0));
    }
  }
}
