// The mobile inverted pendulum: its equations about upright and without an approximation.
import {make, solve} from "./linalg.js";

export const STEP = 0.0025;  // s

// The pendulum with e/c and e/a times so much; the geared inertia moves with them.
function scaled(mip, body, wheels) {
  const inertia = mip.I_w * body / wheels;
  return {...mip, a: mip.a + 2 * (inertia - mip.I_w), e: mip.e * body, I_w: inertia};
}

export const vertices =
  (mip, s) => [[1 - s, 1 - s], [1 - s, 1 + s], [1 + s, 1 - s], [1 + s, 1 + s]].map(
    ([x, y]) => scaled(mip, x, y));

// x' = A x + B V about upright; with the integral of phi for five states.
export function linear({a, b: lever, c, d, e, f, J = 0}, N = 4) {
  const b = lever - J;
  const z = solve([[c, b], [b, a]], [[d, 0, -f, f, -e], [0, 0, f, -f, e]]);
  const A = make(N, N,
    (i, j) => i < 2 ? (j === i + 2 ? 1 : 0)
      : i === 4     ? (j === 1 ? 1 : 0)
      : j < 4       ? z[i - 2][j]
                    : 0);
  return [A, make(N, 1, i => i === 2 || i === 3 ? z[i - 2][4] : 0)];
}

export function slope({a, b, c, d, e, f, J = 0}, x, V) {
  const [theta, , dtheta, dphi] = x, sin = Math.sin(theta), both = b * Math.cos(theta) - J;
  const torque = e * V - f * (dphi - dtheta);
  const body = d * sin - torque, wheels = b * sin * dtheta ** 2 + torque, det = a * c - both ** 2;
  return [
    dtheta, dphi, (a * body - both * wheels) / det, (c * wheels - both * body) / det, x[1]
  ].slice(0, x.length);
}

// A step of Runge and Kutta's method for x' = rate(x).
export function runge(rate, x, h) {
  const ahead = (s, k) => x.map((value, i) => value + s * k[i]);
  const k = rate(x), l = rate(ahead(h / 2, k)), m = rate(ahead(h / 2, l)), n = rate(ahead(h, m));
  return x.map((value, i) => value + h / 6 * (k[i] + 2 * l[i] + 2 * m[i] + n[i]));
}
