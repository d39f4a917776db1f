// Dense matrices of a few rows, row by row in a Float64Array: {rows, cols, at}.

// n zeros, a part of a longer array: browsers make small arrays of their own slowly.
const ROOM = 1 << 15;
export let room = new Float64Array(ROOM), taken = 0;
export function reals(n) {
  if (taken + n > room.length) {
    room = new Float64Array(Math.max(ROOM, n));
    taken = 0;
  }
  taken += n;
  return new Float64Array(room.buffer, 8 * (taken - n), n);
}

export function zeros(rows, cols) { return {rows, cols, at: reals(rows * cols)}; }

export function copied(x) {
  const y = reals(x.length);
  y.set(x);
  return y;
}

export function identity(n, value = 1) {
  const X = zeros(n, n);
  for (let i = 0; i < n; i++) X.at[i * n + i] = value;
  return X;
}

export function matrix(list, cols = list.length ? list[0].length : 0) {
  const X = zeros(list.length, cols);
  list.forEach((row, i) => row.forEach((x, j) => { X.at[i * cols + j] = x; }));
  return X;
}

export function rowsOf(X) {
  return Array.from({length: X.rows}, (_, i) => Array.from(X.at.slice(i * X.cols, (i + 1) * X.cols)));
}

export function transposed(X) {
  const {rows, cols, at: x} = X, T = zeros(cols, rows), t = T.at;
  for (let i = 0, k = 0; i < rows; i++)
    for (let j = 0; j < cols; j++, k++) t[j * rows + i] = x[k];
  return T;
}

// a X + b Y
export function combined(a, X, b, Y) {
  const Z = zeros(X.rows, X.cols), x = X.at, y = Y.at, z = Z.at;
  for (let k = 0; k < z.length; k++) z[k] = a * x[k] + b * y[k];
  return Z;
}

export function mapped(X, f) {
  const {rows, cols, at: x} = X, Z = zeros(rows, cols), z = Z.at;
  for (let i = 0, k = 0; i < rows; i++)
    for (let j = 0; j < cols; j++, k++) z[k] = f(x[k], i, j);
  return Z;
}

export function scaled(a, X) { return mapped(X, x => a * x); }

export function times(X, Y) { return accumulate(zeros(X.rows, Y.cols), X, Y); }

// Z + X Y, in the place of Z: the rows of Y that have a factor, four at a time.
let picked = new Int32Array(64);
export function accumulate(Z, X, Y) {
  const {rows, cols: inner} = X, cols = Y.cols, x = X.at, y = Y.at, z = Z.at;
  if (inner > picked.length) picked = new Int32Array(2 * inner);
  for (let i = 0, first = 0; i < rows; i++, first += cols) {
    const row = i * inner, last = first + cols;
    let count = 0, c = 0;
    for (let k = 0; k < inner; k++)
      if (x[row + k] !== 0) picked[count++] = k;
    for (; c + 3 < count; c += 4) {
      const p = picked[c], q = picked[c + 1], r = picked[c + 2], s = picked[c + 3];
      const a = x[row + p], b = x[row + q], e = x[row + r], f = x[row + s];
      for (let to = first, k = p * cols, l = q * cols, m = r * cols, n = s * cols; to < last;
        to++, k++, l++, m++, n++) {
        z[to] = z[to] + a * y[k] + b * y[l] + e * y[m] + f * y[n];
      }
    }
    for (; c + 1 < count; c += 2) {
      const p = picked[c], q = picked[c + 1], a = x[row + p], b = x[row + q];
      for (let to = first, k = p * cols, l = q * cols; to < last; to++, k++, l++)
        z[to] = z[to] + a * y[k] + b * y[l];
    }
    for (; c < count; c++) {
      const a = x[row + picked[c]];
      for (let to = first, k = picked[c] * cols; to < last; to++, k++) z[to] += a * y[k];
    }
  }
  return Z;
}

// Puts Y into X with its first entry at (top, left), multiplied by the factors.
export function place(X, top, left, Y, ...factors) {
  const a = factors.reduce((product, x) => product * x, 1);
  for (let i = 0; i < Y.rows; i++) {
    for (let j = 0; j < Y.cols; j++) X.at[(top + i) * X.cols + left + j] += a * Y.at[i * Y.cols + j];
  }
  return X;
}

// What a plant is laid out with; exact.js has the same for decimals.
export const FLOATS = {
  matrix,
  zeros,
  identity,
  transposed,
  times,
  scaled,
  combined,
  place
};

export function symmetrized(X) {
  const n = X.rows, x = X.at;
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < i; j++) x[i * n + j] = x[j * n + i] = (x[i * n + j] + x[j * n + i]) / 2;
  }
  return X;
}

export function dot(x, y) {
  let sum = 0;
  for (let k = 0; k < x.length; k++) sum += x[k] * y[k];
  return sum;
}

export function inner(X, Y) {
  let sum = 0;
  for (let k = 0; k < X.at.length; k++) sum += X.at[k] * Y.at[k];
  return sum;
}

// The Cholesky factor L of X = L L', or null where X isn't positive definite.
export function cholesky(X) {
  const n = X.rows, L = zeros(n, n), l = L.at;
  for (let j = 0; j < n; j++) {
    for (let i = j; i < n; i++) {
      let sum = X.at[i * n + j];
      for (let k = 0, a = i * n, b = j * n; k < j; k++) sum -= l[a + k] * l[b + k];
      if (i === j) {
        if (!(sum > 0) || sum === Infinity) return null;
        l[j * n + j] = Math.sqrt(sum);
      } else l[i * n + j] = sum / l[j * n + j];
    }
  }
  return L;
}

export function inverseLower(L) {
  const n = L.rows, N = zeros(n, n), x = N.at, l = L.at;
  for (let j = 0; j < n; j++) {
    x[j * n + j] = 1 / l[j * n + j];
    for (let i = j + 1; i < n; i++) {
      let sum = 0;
      for (let k = j; k < i; k++) sum -= l[i * n + k] * x[k * n + j];
      x[i * n + j] = sum / l[i * n + i];
    }
  }
  return N;
}

// X = L L' solved for one right-hand side.
export function solveCholesky(L, b) {
  const n = L.rows, l = L.at, x = Float64Array.from(b);
  for (let i = 0; i < n; i++) {
    let sum = x[i];
    for (let k = 0; k < i; k++) sum -= l[i * n + k] * x[k];
    x[i] = sum / l[i * n + i];
  }
  for (let i = n - 1; i >= 0; i--) {
    let sum = x[i];
    for (let k = i + 1; k < n; k++) sum -= l[k * n + i] * x[k];
    x[i] = sum / l[i * n + i];
  }
  return x;
}

// inv(X) Y by elimination with row pivots, and |det X|; null where X is singular.
export function solve(X, Y, size = {}) {
  const n = X.rows, m = Y.cols, a = copied(X.at), Z = {rows: n, cols: m, at: copied(Y.at)};
  const z = Z.at;
  size.logarithm = 0;
  for (let k = 0; k < n; k++) {
    let pivot = k;
    for (let i = k + 1; i < n; i++)
      if (Math.abs(a[i * n + k]) > Math.abs(a[pivot * n + k])) pivot = i;
    const lead = a[pivot * n + k];
    if (!(Math.abs(lead) > 0) || !isFinite(lead)) return null;
    size.logarithm += Math.log(Math.abs(lead));
    if (pivot !== k) {
      for (let j = 0; j < n; j++) [a[k * n + j], a[pivot * n + j]] = [a[pivot * n + j], a[k * n + j]];
      for (let j = 0; j < m; j++) [z[k * m + j], z[pivot * m + j]] = [z[pivot * m + j], z[k * m + j]];
    }
    for (let i = k + 1; i < n; i++) {
      const factor = a[i * n + k] / lead;
      if (factor === 0) continue;
      for (let j = k; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
      for (let j = 0; j < m; j++) z[i * m + j] -= factor * z[k * m + j];
    }
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let j = 0; j < m; j++) {
      let sum = z[i * m + j];
      for (let k = i + 1; k < n; k++) sum -= a[i * n + k] * z[k * m + j];
      z[i * m + j] = sum / a[i * n + i];
    }
  }
  return Z;
}

export function inverse(X, size) { return solve(X, identity(X.rows), size); }

// Eigenvalues of a symmetric matrix in rising order: Householder's tridiagonal
// form, then implicit QL steps (Golub and Van Loan, sections 8.3.1 and 8.3.3).
export function symmetricEigenvalues(X) {
  const n = X.rows, a = copied(X.at), d = reals(n), e = reals(n);
  for (let i = n - 1; i > 0; i--) {
    let h = 0;
    for (let k = 0; k < i - 1; k++) h += a[i * n + k] ** 2;
    const f = a[i * n + i - 1];
    if (h === 0) {
      e[i] = f;
      d[i] = 0;
      continue;
    }
    h += f * f;
    const g = f > 0 ? -Math.sqrt(h) : Math.sqrt(h);
    e[i] = g;
    h -= f * g;
    a[i * n + i - 1] = f - g;
    let sum = 0;
    for (let j = 0; j < i; j++) {
      let g = 0;
      for (let k = 0; k <= j; k++) g += a[j * n + k] * a[i * n + k];
      for (let k = j + 1; k < i; k++) g += a[k * n + j] * a[i * n + k];
      e[j] = g / h;
      sum += e[j] * a[i * n + j];
    }
    const half = sum / (2 * h);
    for (let j = 0; j < i; j++) {
      const v = a[i * n + j], w = e[j] - half * v;
      e[j] = w;
      for (let k = 0; k <= j; k++) a[j * n + k] -= v * e[k] + w * a[i * n + k];
    }
  }
  for (let i = 0; i < n; i++) d[i] = a[i * n + i];
  for (let i = 1; i < n; i++) e[i - 1] = e[i];
  if (n) e[n - 1] = 0;
  for (let l = 0; l < n; l++) {
    for (let count = 0; count < 60; count++) {
      let m = l;
      for (; m < n - 1; m++) {
        const size = Math.abs(d[m]) + Math.abs(d[m + 1]);
        if (Math.abs(e[m]) <= Number.EPSILON * size) break;
      }
      if (m === l) break;
      let g = (d[l + 1] - d[l]) / (2 * e[l]), r = Math.hypot(g, 1);
      g = d[m] - d[l] + e[l] / (g + (g >= 0 ? r : -r));
      let s = 1, c = 1, p = 0, i = m - 1;
      for (; i >= l; i--) {
        const f = s * e[i], b = c * e[i];
        r = Math.hypot(f, g);
        e[i + 1] = r;
        if (r === 0) {
          d[i + 1] -= p;
          e[m] = 0;
          break;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        r = (d[i] - g) * s + 2 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
      }
      if (r === 0 && i >= l) continue;
      d[l] -= p;
      e[l] = g;
      e[m] = 0;
    }
  }
  return d.sort();
}

// The largest singular value.
export function norm(X) {
  const top = symmetricEigenvalues(times(transposed(X), X));
  return top.length ? Math.sqrt(Math.max(0, top[top.length - 1])) : 0;
}
