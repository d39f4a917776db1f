// Dense linear algebra for the small matrices of the page elements. A matrix is a
// list of rows; eigenvalues and roots are pairs [real part, imaginary part].
window.sosLinalg ??= (() => {
  "use strict";

  const make = (n, m, entry) => Array.from({length: n}, (_, i) => Array.from({length: m}, (_, j) => entry(i, j)));
  const eye = n => make(n, n, (i, j) => i === j ? 1 : 0);
  const zeros = (n, m) => make(n, m, () => 0);
  const transpose = A => make(A[0].length, A.length, (i, j) => A[j][i]);
  const mul = (A, B, ...more) => {
    const C = make(A.length, B[0].length, (i, j) => A[i].reduce((sum, a, k) => sum + a * B[k][j], 0));
    return more.length ? mul(C, ...more) : C;
  };
  const combine = (a, A, b, B) => A.map((row, i) => row.map((x, j) => a * x + b * B[i][j]));
  const add = (A, B) => combine(1, A, 1, B);
  const scale = (a, A) => A.map(row => row.map(x => a * x));
  const apply = (A, x) => A.map(row => row.reduce((sum, a, k) => sum + a * x[k], 0));
  const block = rows => rows.flatMap(row => row[0].map((_, i) => row.flatMap(A => A[i])));
  const part = (A, [top, bottom], [left, right]) => A.slice(top, bottom).map(row => row.slice(left, right));
  const trace = A => A.reduce((sum, row, i) => sum + row[i], 0);
  const norm = A => Math.max(...A.map(row => row.reduce((sum, x) => sum + Math.abs(x), 0)));   // of rows

  // A^-1 B by Gaussian elimination with partial pivoting; [solution, |det A|].
  function eliminate(A, B) {
    const n = A.length, W = A.map((row, i) => [...row, ...B[i]]);
    let det = 1;
    for (let k = 0; k < n; k++) {
      let p = k;
      for (let i = k + 1; i < n; i++) if (Math.abs(W[i][k]) > Math.abs(W[p][k])) p = i;
      [W[k], W[p]] = [W[p], W[k]];
      det *= Math.abs(W[k][k]);
      for (let i = k + 1; i < n; i++) {
        const factor = W[i][k] / W[k][k];
        if (factor) for (let j = k; j < W[i].length; j++) W[i][j] -= factor * W[k][j];
      }
    }
    for (let k = n - 1; k >= 0; k--) {
      for (let j = n; j < W[k].length; j++) {
        for (let i = k + 1; i < n; i++) W[k][j] -= W[k][i] * W[i][j];
        W[k][j] /= W[k][k];
      }
    }
    return [W.map(row => row.slice(n)), det];
  }

  const solve = (A, B) => eliminate(A, B)[0];

  // Eigenvalues: Hessenberg form, then shifted QR with complex rotations and
  // deflation (Golub and Van Loan, Matrix Computations, section 7.5).
  function eigenvalues(A) {
    let n = A.length;
    const H = hessenberg(balance(A)), Z = H.map(() => Array(n).fill(0)), found = [];   // H + Z j
    const size = norm(H) || 1, abs = (i, j) => Math.abs(H[i][j]) + Math.abs(Z[i][j]);
    for (let count = 0; n > 0; count++) {
      let l = n - 1;
      while (l > 0 && abs(l, l - 1) > 1.1e-16 * ((abs(l, l) + abs(l - 1, l - 1)) || size)) l--;
      if (l === n - 1 || count > 90) {
        n--;
        found.push([H[n][n], Z[n][n]]);
        count = -1;
        continue;
      }
      const [sr, si] = count % 11 === 10 ? [H[n - 1][n - 1] + abs(n - 1, n - 2), 0] : corner(H, Z, n);
      sweep(H, Z, l, n, sr, si);
    }
    const real = 1e-13 * size;
    return found.map(([re, im]) => [re, Math.abs(im) < real ? 0 : im]).sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  }

  // Rows and columns scaled by powers of two until they are alike.
  function balance(A) {
    const B = A.map(row => [...row]), n = B.length;
    for (let again = true; again;) {
      again = false;
      for (let i = 0; i < n; i++) {
        let r = 0, c = 0;
        for (let j = 0; j < n; j++) if (j !== i) { r += Math.abs(B[i][j]); c += Math.abs(B[j][i]); }
        const f = r && c ? 2 ** Math.round(Math.log2(r / c) / 2) : 1;
        if (f === 1 || c * f + r / f > 0.95 * (c + r)) continue;
        again = true;
        for (let j = 0; j < n; j++) { B[i][j] /= f; B[j][i] *= f; }
      }
    }
    return B;
  }

  // By Householder reflections.
  function hessenberg(H) {
    const n = H.length;
    for (let k = 0; k + 2 < n; k++) {
      const v = H.map((row, i) => i > k ? row[k] : 0), length = Math.hypot(...v);
      if (Math.hypot(...v.slice(k + 2)) === 0) continue;
      v[k + 1] += v[k + 1] < 0 ? -length : length;
      const square = v.reduce((sum, x) => sum + x * x, 0);
      for (let j = 0; j < n; j++) {
        const s = 2 / square * v.reduce((sum, x, i) => sum + x * H[i][j], 0);
        for (let i = k + 1; i < n; i++) H[i][j] -= s * v[i];
      }
      for (let i = 0; i < n; i++) {
        const s = 2 / square * v.reduce((sum, x, j) => sum + x * H[i][j], 0);
        for (let j = k + 1; j < n; j++) H[i][j] -= s * v[j];
      }
    }
    return H;
  }

  const root = (re, im) => {
    const r = Math.hypot(re, im), a = Math.sqrt((r + Math.abs(re)) / 2);
    if (!a) return [0, 0];
    return re >= 0 ? [a, im / (2 * a)] : [Math.abs(im) / (2 * a), im < 0 ? -a : a];
  };

  // The eigenvalue of the last 2 x 2 block that is nearer to its last entry.
  function corner(H, Z, n) {
    const [i, j] = [n - 2, n - 1], re = (H[i][i] - H[j][j]) / 2, im = (Z[i][i] - Z[j][j]) / 2;
    const [r, s] = root(re * re - im * im + H[i][j] * H[j][i] - Z[i][j] * Z[j][i],
      2 * re * im + H[i][j] * Z[j][i] + Z[i][j] * H[j][i]), sign = re * r + im * s > 0 ? -1 : 1;
    return [H[j][j] + re + sign * r, Z[j][j] + im + sign * s];
  }

  // One QR step with a shift on the rows and columns l to n - 1.
  function sweep(H, Z, l, n, sr, si) {
    const turns = [];
    for (let k = l; k < n; k++) { H[k][k] -= sr; Z[k][k] -= si; }
    for (let k = l; k + 1 < n; k++) {
      const r = Math.hypot(H[k][k], Z[k][k], H[k + 1][k], Z[k + 1][k]) || 1;
      const t = [H[k][k] / r, Z[k][k] / r, H[k + 1][k] / r, Z[k + 1][k] / r];
      turns.push(t);
      const [a, b, c, d] = t;                                // conj(a + b j), conj(c + d j) in the first row
      for (let j = k; j < n; j++) {
        const [x, y, u, v] = [H[k][j], Z[k][j], H[k + 1][j], Z[k + 1][j]];
        H[k][j] = a * x + b * y + c * u + d * v;
        Z[k][j] = a * y - b * x + c * v - d * u;
        H[k + 1][j] = a * u - b * v - c * x + d * y;
        Z[k + 1][j] = a * v + b * u - c * y - d * x;
      }
    }
    turns.forEach(([a, b, c, d], at) => {
      const k = l + at;
      for (let i = l; i < Math.min(k + 2, n); i++) {
        const [x, y, u, v] = [H[i][k], Z[i][k], H[i][k + 1], Z[i][k + 1]];
        H[i][k] = a * x - b * y + c * u - d * v;
        Z[i][k] = a * y + b * x + c * v + d * u;
        H[i][k + 1] = a * u + b * v - c * x - d * y;
        Z[i][k + 1] = a * v - b * u - c * y + d * x;
      }
    });
    for (let k = l; k < n; k++) { H[k][k] += sr; Z[k][k] += si; }
  }

  // exp(A): Taylor's series of A / 2^s, squared s times.
  function exponential(A) {
    const squarings = Math.max(0, Math.ceil(Math.log2(norm(A) / 0.4))) || 0, small = scale(2 ** -squarings, A);
    let term = eye(A.length), E = term;
    for (let k = 1; k < 17; k++) {
      term = scale(1 / k, mul(term, small));
      E = add(E, term);
    }
    for (let k = 0; k < squarings; k++) E = mul(E, E);
    return E;
  }

  // X with A^T X + X A + Q = 0, as one system of linear equations.
  function lyapunov(A, Q) {
    const n = A.length, all = make(n * n, n * n, (row, column) => {
      const [i, j, k, l] = [Math.floor(row / n), row % n, Math.floor(column / n), column % n];
      return (j === l ? A[k][i] : 0) + (i === k ? A[l][j] : 0);
    });
    const x = solve(all, make(n * n, 1, row => -Q[Math.floor(row / n)][row % n]));
    return make(n, n, (i, j) => (x[i * n + j][0] + x[j * n + i][0]) / 2);
  }

  // The stabilising solution of A^T X + X A - X B R^-1 B^T X + Q = 0: the sign of
  // the Hamiltonian matrix, then one step of Newton and Kleinman.
  function riccati(A, B, Q, R) {
    const n = A.length, feed = solve(R, transpose(B)), S = mul(B, feed);
    let Z = block([[A, scale(-1, S)], [scale(-1, Q), scale(-1, transpose(A))]]);
    for (let k = 0; k < 60; k++) {
      const [inverse, det] = eliminate(Z, eye(2 * n)), c = k < 12 ? det ** (-1 / (2 * n)) : 1;
      const next = combine(c / 2, Z, 1 / (2 * c), inverse), moved = norm(combine(1, next, -1, Z));
      Z = next;
      if (moved < 1e-13 * norm(Z)) break;
    }
    // (sign(H) + I) [I; X] = 0, solved in the least squares sense
    const W = add(Z, eye(2 * n)), right = part(W, [0, 2 * n], [n, 2 * n]), left = part(W, [0, 2 * n], [0, n]);
    const X = solve(mul(transpose(right), right), scale(-1, mul(transpose(right), left)));
    const K = mul(feed, X);
    return lyapunov(combine(1, A, -1, mul(B, K)), add(Q, mul(transpose(K), R, K)));
  }

  // The gain K of u = K x with the least cost x^T Q x + u^T R u.
  const regulator = (A, B, Q, R) => scale(-1, solve(R, mul(transpose(B), riccati(A, B, Q, R))));

  // [Phi, Gamma] of x(t + T) = Phi x + Gamma u for an input that is held.
  function held(A, B, T) {
    const n = A.length, m = B[0].length, E = exponential(scale(T, block([[A, B], [zeros(m, n), zeros(m, m)]])));
    return [part(E, [0, n], [0, n]), part(E, [0, n], [n, n + m])];
  }

  return {add, apply, block, combine, eigenvalues, exponential, eye, held, lyapunov, make, mul, norm, part, regulator,
    riccati, scale, solve, trace, transpose, zeros};
})();
