// A loop whose rate hears of its past.
import {clamp} from "./kit.js";
import {runge} from "./pendulum.js";

// {t, d, x, old}: instants, the delays d(t), the states, and what arrives of them, x(t - d(t)); x
// is `start` until t = 0. The rate is that of x, of what arrives, and of whether it left since t =
// 0. Runge and Kutta's method, which doesn't look across a jump of the delay at a step's end;
// between two instants the past is Hermite's cubic.
export function delayedRun(rate, start, late, horizon, steps) {
  const T = horizon / steps, t = Array.from({length: steps + 1}, (_, k) => k * T), d = t.map(late);
  const x = [start], f = [], past = time => {
    if (time <= 0) return start;
    const k = Math.min(Math.floor(time / T + 1e-9), f.length - 2), r = time / T - k;
    if (k < 0) return start.map((v, i) => v + time * (f[0]?.[i] ?? 0));
    const b = x[k + 1], p = f[k], q = f[k + 1], to = r * r * (3 - 2 * r), from = 1 - to;
    const now = T * r * (1 - r) ** 2, then = T * r * r * (1 - r);
    return x[k].map((v, i) => from * v + to * b[i] + now * p[i] - then * q[i]);
  };
  const arrived = (now, time, delay) => delay < 1e-12 ? now : past(time - delay);
  const slope = (now, time, delay) => rate(now, arrived(now, time, delay), time - delay >= -1e-9);
  for (let k = 0; k <= steps; k++) {
    f.push(slope(x[k], t[k], d[k]));
    const inside = time => clamp(time, t[k] + 1e-7 * T, t[k] + T - 1e-7 * T);
    if (k < steps) x.push(runge((now, time) => slope(now, inside(time), late(inside(time))), x[k], T, t[k]));
  }
  return {t, d, x, old: d.map((delay, k) => arrived(x[k], t[k], delay))};
}
