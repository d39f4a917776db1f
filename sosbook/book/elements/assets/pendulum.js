// The mobile inverted pendulum: its equations about upright and without an approximation.
import {add, held, make, mul, solve} from "./linalg.js";

export const STEP = 0.0025;  // s

// The pendulum with e/c and e/a times so much; the geared inertia moves with them.
function scaled(mip, body, wheels) {
  const inertia = mip.I_w * body / wheels;
  return {...mip, a: mip.a + 2 * (inertia - mip.I_w), e: mip.e * body, I_w: inertia};
}

export const vertices = (mip, s) => [[1 - s, 1 - s], [1 - s, 1 + s], [1 + s, 1 - s], [1 + s, 1 + s]].map(
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
  return [dtheta, dphi, (a * body - both * wheels) / det, (c * wheels - both * body) / det, x[1]].slice(
    0, x.length);
}

// [A, K] of a loop from tick to tick, late by a part of T: x(k + 1) = A x(k) and V = K x, where
// x is [x; V(k - 1); wheels(k - 1); sum of T phi]. The wheels' rate may be differenced.
export function sampledLoop(robot, K, T, delay, differenced = false) {
  const [A, B] = linear(robot), [Phi] = held(A, B, T), [rest, fresh] = held(A, B, T - delay);
  const before = mul(rest, held(A, B, delay)[1]), rate = differenced ? [-1 / T, 1 / T, 1] : [0, 0, 0];
  const volts = [
    ...[0, 1, 2].map(i => K[i] + K[3] * rate[i]), differenced ? 0 : K[3], 0, differenced ? -K[3] / T : 0,
    K[4] ?? 0
  ];
  const free = make(7, 7, (i, j) => i < 4 && j < 4 ? Phi[i][j] : i < 4 && j === 4 ? before[i][0] : 0);
  free[5].splice(0, 2, -1, 1);
  free[6][1] = T;
  free[6][6] = K.length > 4 ? 1 : 0;
  const driven = make(7, 1, i => i < 4 ? fresh[i][0] : i === 4 ? 1 : 0);
  return [add(free, mul(driven, [volts])), volts];
}

// A step from t on of Runge and Kutta's method for x' = rate(x, t).
export function runge(rate, x, h, t = 0) {
  const ahead = (s, k) => x.map((value, i) => value + s * k[i]), k = rate(x, t);
  const l = rate(ahead(h / 2, k), t + h / 2), m = rate(ahead(h / 2, l), t + h / 2);
  const n = rate(ahead(h, m), t + h);
  return x.map((value, i) => value + h / 6 * (k[i] + 2 * l[i] + 2 * m[i] + n[i]));
}
