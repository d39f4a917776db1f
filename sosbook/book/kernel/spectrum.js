// Eigenvalues and the exponential of a real matrix, and the Riccati equation that gives
// the kernel its coordinates.
import {cholesky, combined, identity, inverse, place, rowsOf, scaled, solve, symmetrized, times, transposed, zeros} from "./matrices.js";

// Eigenvalues as [re, im]: balance, Hessenberg form, double QR steps of Francis
// (Golub and Van Loan, sections 7.4 and 7.5; after EISPACK's balanc, elmhes, hqr).
export function eigenvalues(X) {
  const n = X.rows, a = X.at.slice(), at = (i, j) => a[i * n + j], list = [];
  for (let done = false; !done;) {
    done = true;
    for (let i = 0; i < n; i++) {
      let r = 0, c = 0;
      for (let j = 0; j < n; j++)
        if (j !== i) {
          c += Math.abs(at(j, i));
          r += Math.abs(at(i, j));
        }
      if (c === 0 || r === 0) continue;
      let f = 1;
      const sum = c + r;
      while (c < r / 2) {
        f *= 2;
        c *= 4;
      }
      while (c >= r * 2) {
        f /= 2;
        c /= 4;
      }
      if ((c + r) / f < 0.95 * sum) {
        done = false;
        for (let j = 0; j < n; j++) a[i * n + j] /= f;
        for (let j = 0; j < n; j++) a[j * n + i] *= f;
      }
    }
  }
  for (let m = 1; m < n - 1; m++) {
    let pivot = m;
    for (let j = m + 1; j < n; j++)
      if (Math.abs(at(j, m - 1)) > Math.abs(at(pivot, m - 1))) pivot = j;
    const lead = at(pivot, m - 1);
    if (pivot !== m) {
      for (let j = m - 1; j < n; j++) [a[pivot * n + j], a[m * n + j]] = [a[m * n + j], a[pivot * n + j]];
      for (let j = 0; j < n; j++) [a[j * n + pivot], a[j * n + m]] = [a[j * n + m], a[j * n + pivot]];
    }
    if (lead === 0) continue;
    for (let i = m + 1; i < n; i++) {
      const y = at(i, m - 1) / lead;
      if (y === 0) continue;
      for (let j = m - 1; j < n; j++) a[i * n + j] -= y * a[m * n + j];
      for (let j = 0; j < n; j++) a[j * n + m] += y * a[j * n + i];
    }
  }
  for (let i = 2; i < n; i++)
    for (let j = 0; j < i - 1; j++) a[i * n + j] = 0;
  let size = 0, shift = 0, high = n - 1, count = 0;
  for (const x of a) size += Math.abs(x);
  while (high >= 0) {
    let l = high;
    for (; l > 0; l--) {
      const s = Math.abs(at(l - 1, l - 1)) + Math.abs(at(l, l)) || size;
      if (Math.abs(at(l, l - 1)) <= Number.EPSILON * s) {
        a[l * n + l - 1] = 0;
        break;
      }
    }
    let x = at(high, high);
    if (l === high) {
      list.push([x + shift, 0]);
      high--;
      count = 0;
      continue;
    }
    let y = at(high - 1, high - 1), w = at(high, high - 1) * at(high - 1, high);
    if (l === high - 1) {
      const p = (y - x) / 2, q = p * p + w, z = Math.sqrt(Math.abs(q));
      x += shift;
      if (q >= 0) {
        const far = p + (p >= 0 ? z : -z);
        list.push([x + far, 0], [far ? x - w / far : x + far, 0]);
      } else list.push([x + p, z], [x + p, -z]);
      high -= 2;
      count = 0;
      continue;
    }
    if (count === 60) return list.concat(Array(high + 1).fill([NaN, NaN]));
    if (count === 10 || count === 20 || count === 40) {  // an exceptional shift
      shift += x;
      for (let i = 0; i <= high; i++) a[i * n + i] -= x;
      const s = Math.abs(at(high, high - 1)) + Math.abs(at(high - 1, high - 2));
      x = y = 0.75 * s;
      w = -0.4375 * s * s;
    }
    count++;
    let p, q, r, m = high - 2;
    for (; m >= l; m--) {
      const z = at(m, m), s = x - z, t = y - z;
      p = (s * t - w) / at(m + 1, m) + at(m, m + 1);
      q = at(m + 1, m + 1) - z - s - t;
      r = at(m + 2, m + 1);
      const scale = Math.abs(p) + Math.abs(q) + Math.abs(r);
      p /= scale;
      q /= scale;
      r /= scale;
      if (m === l) break;
      const small = Math.abs(at(m, m - 1)) * (Math.abs(q) + Math.abs(r));
      const near = Math.abs(p) * (Math.abs(at(m - 1, m - 1)) + Math.abs(z) + Math.abs(at(m + 1, m + 1)));
      if (small <= Number.EPSILON * near) break;
    }
    for (let i = m + 2; i <= high; i++) {
      a[i * n + i - 2] = 0;
      if (i > m + 2) a[i * n + i - 3] = 0;
    }
    for (let k = m; k < high; k++) {
      const last = k === high - 1;
      if (k > m) {
        p = at(k, k - 1);
        q = at(k + 1, k - 1);
        r = last ? 0 : at(k + 2, k - 1);
        x = Math.abs(p) + Math.abs(q) + Math.abs(r);
        if (x === 0) continue;
        p /= x;
        q /= x;
        r /= x;
      }
      const root = Math.sqrt(p * p + q * q + r * r), s = p < 0 ? -root : root;
      if (s === 0) continue;
      if (k === m) {
        if (l !== m) a[k * n + k - 1] *= -1;
      } else a[k * n + k - 1] = -s * x;
      p += s;
      x = p / s;
      y = q / s;
      const z = r / s;
      q /= p;
      r /= p;
      for (let j = k; j <= high; j++) {
        let f = at(k, j) + q * at(k + 1, j);
        if (!last) {
          f += r * at(k + 2, j);
          a[(k + 2) * n + j] -= f * z;
        }
        a[(k + 1) * n + j] -= f * y;
        a[k * n + j] -= f * x;
      }
      const low = Math.min(high, k + 3);
      for (let i = l; i <= low; i++) {
        let f = x * at(i, k) + y * at(i, k + 1);
        if (!last) {
          f += z * at(i, k + 2);
          a[i * n + k + 2] -= f * r;
        }
        a[i * n + k + 1] -= f * q;
        a[i * n + k] -= f;
      }
    }
  }
  return list;
}

// exp(X h) by scaling, Taylor's series and squaring.
export function exponential(X, h) {
  const size = Math.max(...rowsOf(X).map(row => row.reduce((sum, x) => sum + Math.abs(x), 0))) * h;
  const halvings = Math.max(0, Math.ceil(Math.log2(size || 1)) + 2);
  const small = scaled(h / 2 ** halvings, X);
  let term = identity(X.rows), sum = term;
  for (let k = 1; k <= 14; k++) {
    term = scaled(1 / k, times(term, small));
    sum = combined(1, sum, 1, term);
  }
  for (let k = 0; k < halvings; k++) sum = times(sum, sum);
  return sum;
}

// X of A'X + XA - X B B' X + Q = 0 by the sign of the Hamiltonian matrix, with
// Newton's iteration, scaled by its determinant (Byers 1987); null without one.
export function riccati(A, B, Q = identity(A.rows)) {
  const n = A.rows, push = times(B, transposed(B));
  let H = zeros(2 * n, 2 * n);
  place(place(H, 0, 0, A), 0, n, push, -1);
  place(place(H, n, 0, Q, -1), n, n, transposed(A), -1);
  for (let count = 0; count < 100; count++) {
    const size = {}, back = inverse(H, size);
    if (!back) return null;
    const c = Math.exp(-size.logarithm / (2 * n));
    const next = combined(c / 2, H, 1 / (2 * c), back);
    let change = 0, all = 0;
    for (let k = 0; k < H.at.length; k++) {
      change += Math.abs(next.at[k] - H.at[k]);
      all += Math.abs(next.at[k]);
    }
    H = next;
    if (!isFinite(all)) return null;
    if (change < 1e-13 * all) break;
  }
  // sign(H) [I; X] = -[I; X]: [W12; W22 + I] X = -[W11 + I; W21], by least squares
  const left = zeros(2 * n, n), right = zeros(2 * n, n);
  for (let i = 0; i < 2 * n; i++) {
    for (let j = 0; j < n; j++) {
      left.at[i * n + j] = H.at[i * 2 * n + n + j] + (i === n + j ? 1 : 0);
      right.at[i * n + j] = -H.at[i * 2 * n + j] - (i === j ? 1 : 0);
    }
  }
  const turned = transposed(left), X = solve(times(turned, left), times(turned, right));
  return X && refinedRiccati(A, push, Q, symmetrized(X));
}

// Two steps of Newton and Kleinman, which leave rounding errors only: with
// F = A - B B' X each solves F'Y + Y F = -(X B B' X + Q).
function refinedRiccati(A, push, Q, X) {
  for (let count = 0; count < 2; count++) {
    const F = combined(1, A, -1, times(push, X));
    const right = combined(1, times(X, times(push, X)), 1, Q);
    const Y = lyapunov(F, right);
    if (!Y || !cholesky(Y)) return null;
    X = Y;
  }
  return X;
}

// Y of F'Y + Y F + Q = 0 for a stable F, by n (n + 1) / 2 linear equations.
export function lyapunov(F, Q) {
  const n = F.rows, f = F.at;
  const index = (i, j) => i <= j ? i * n - i * (i - 1) / 2 + j - i : index(j, i);
  const count = n * (n + 1) / 2, M = zeros(count, count), b = zeros(count, 1);
  for (let i = 0; i < n; i++) {
    for (let j = i; j < n; j++) {
      const row = index(i, j);
      b.at[row] = -Q.at[i * n + j];
      for (let k = 0; k < n; k++) {
        M.at[row * count + index(k, j)] += f[k * n + i];
        M.at[row * count + index(i, k)] += f[k * n + j];
      }
    }
  }
  const y = solve(M, b), Y = zeros(n, n);
  if (!y) return null;
  for (let i = 0; i < n; i++)
    for (let j = 0; j < n; j++) Y.at[i * n + j] = y.at[index(i, j)];
  return Y;
}
