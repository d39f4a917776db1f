import {delayedRun} from "./history.js";
import {define, withConjugates} from "./kit.js";
import {apply, combine, eigenvalues, eye, make, scale, solve, trace} from "./linalg.js";
import {Mover, number} from "./mover.js";

// The loop x' = A x + A_d x(t - h) on Chebyshev nodes between t - h and t.
function generator(A, Ad, h, n) {
  const N = A.length, theta = make(n + 1, 1, k => h * (Math.cos(Math.PI * k / n) - 1) / 2).flat();
  const c = theta.map((_, k) => (k % n ? 1 : 2) * (-1) ** k);
  const slope = make(n + 1, n + 1, (i, j) => i === j ? 0 : c[i] / c[j] / (theta[i] - theta[j]));
  slope.forEach((row, i) => { row[i] = -row.reduce((sum, x) => sum + x, 0); });
  return make(N * (n + 1), N * (n + 1), (i, j) => {
    const [k, l] = [Math.floor(i / N), Math.floor(j / N)];
    if (k === 0) return l === 0 ? A[i][j] : l === n ? Ad[i][j % N] : 0;
    return i % N === j % N ? slope[k][l] : 0;
  });
}

// One Newton step for det(s I - A - A_d exp(-s h)) = 0.
/** @type {(A: any, Ad: any, h: any, s: any) => any} */
function newton(A, Ad, h, [re, im]) {
  const N = A.length, size = Math.exp(-re * h);
  const [c, d] = [size * Math.cos(im * h), -size * Math.sin(im * h)];
  const complex = (X, Y) =>
    make(2 * N, 2 * N, (i, j) => (i < N) === (j < N) ? X[i % N][j % N] : (i < N ? -1 : 1) * Y[i % N][j % N]);
  const I = eye(N);
  const value = complex(combine(1, combine(re, I, -1, A), -c, Ad), combine(im, I, -d, Ad));
  const X = solve(value, complex(combine(1, I, h * c, Ad), scale(h * d, Ad)));
  const u = trace(X.slice(0, N)), v = trace(X.slice(N)), square = u * u + v * v;
  return [re - u / square, im + v / square];
}

function roots(A, Ad, h, n) {
  if (h === 0) return eigenvalues(combine(1, A, 1, Ad));
  const found = [];
  for (const start of eigenvalues(generator(A, Ad, h, n)).filter(([re, im]) => im >= 0 && re * h > -4)) {
    let s = start, moved = Infinity;
    for (let k = 0; k < 12 && moved > 1e-11; k++) {
      const next = newton(A, Ad, h, s);
      moved = Math.hypot(next[0] - s[0], next[1] - s[1]) / (1 + Math.hypot(...s));
      s = next;
    }
    s = [s[0], Math.abs(s[1]) < 1e-9 ? 0 : Math.abs(s[1])];
    if (moved < 1e-9 &&
      !found.some(r => Math.hypot(r[0] - s[0], r[1] - s[1]) < 1e-6 * (1 + Math.hypot(...s))))
      found.push(s);
  }
  return withConjugates(found).sort((p, q) => q[0] - p[0]);
}

const LATE = {
  constant: h => () => h,
  clinging: (h, rest) => t => Math.min((t + 1e-9) % (rest + h), h)
};  // d grows with the time, as if the input stood still

const growing = x => Math.max(...x.slice(-200).map(Math.abs)) > Math.max(...x.slice(0, 200).map(Math.abs));

class Delayed extends Mover {
  markup() {
    const loop = this.control("loop") ? "loop of the {loop}" : "loop";
    this.says = `With {gain} its gain the ${loop} hears its input h = {h} late; the delay is {kind}.`;
    return super.markup();
  }
  good({roots: [[right]], x}) { return right < 0 && !growing(x); }
  get means() { return "the loop is stable"; }
  get horizon() { return this.data.horizon; }
  get still() { return this.horizon; }
  get pace() { return this.horizon / 6; }

  figures = {
    roots: "Characteristic roots for the constant delay h. The chain behind them goes on for ever.",
    time: "The first state, from 1 and at rest before. Dashed: what arrives late.",
    delay: "The delay."
  };

  compute({loop, h, gain, kind}) {
    const {loops, rest, steps} = this.data, {A, Ad: full} = loops[loop ?? 0], N = A.length;
    const Ad = scale(gain, full), late = LATE[kind ? "clinging" : "constant"](h, rest);
    const rate = (x, old) => {
      const [u, v] = [apply(A, x), apply(Ad, old)];
      return u.map((value, i) => value + v[i]);
    };
    const run = delayedRun(rate, A.map((_, i) => i ? 0 : 1), late, this.horizon, steps);
    const [x, old] = [run.x, run.old].map(all => all.map(v => v[0]));
    return {...run, roots: roots(A, Ad, h, [24, 24, 20, 16, 14, 12][N] ?? 10), x, old};
  }

  show({roots: all, t, x, old, d}, ghost, {h, kind}) {
    const right = all[0][0], wide = this.data.window;
    const top = Math.min(3, 1.1 * Math.max(...x.map(Math.abs).filter(Number.isFinite)));
    const grows = growing(x);
    this.tell(this.good({roots: all, x}) ? "feasible" : "infeasible",
      right >= 0        ? "Unstable for this constant delay."
        : kind && grows ? "Grows; at a constant delay it wouldn't."
        : kind          ? "Settles, as with a constant delay."
                        : "Stable for this constant delay.",
      `<p>Rightmost root: real part ${number(right, " s⁻¹")}${
        all[0][1] ? `, ${number(Math.abs(all[0][1]), " rad/s")}` : ""}.</p>`);
    this.poleMap(
      "roots", {x: wide[0], y: wide[1], label: "Characteristic roots", poles: all, ghost: ghost?.roots});
    const line = (values, colour, dash) =>
      ({points: values.map((v, k) => [t[k], v]).filter((_, k) => k % 3 === 0), colour, dash});
    this.curves("time", "x₁", "The first state over time", [line(old, "--sos-second", "5 4"), line(x)],
      {y: [-top, top], ghosts: ghost && [line(ghost.x)]});
    this.curves(
      "delay", "d (s)", "The delay over time", [line(d, "--sos-third")], {y: [0, 1.15 * Math.max(h, 0.1)]});
  }
}

define("sos-delayed", Delayed);
