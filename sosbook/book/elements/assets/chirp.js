import {clamp, clean, define, degrees, round} from "./kit.js";
import {solve} from "./linalg.js";
import {Mover, normal, number, series} from "./mover.js";
import {runge} from "./pendulum.js";
import {bar, picture} from "./plot.js";

const T = 0.01, STEPS = 1000;  // s

// [q, q'] of the hanging body, q'' = -e V - f q' - d sin q, or with q for sin q.
/** @param {any} ratios */
function swing([e, f, d], V, linear) {
  const rate = v => ([q, p]) => [p, -e * v - f * p - d * (linear ? q : Math.sin(q))];
  const all = [[0, 0]];
  for (const v of V) all.push(runge(rate(v), all.at(-1), T));
  return all;
}

// Output error by Gauss and Newton: the ratios whose simulation is nearest to y.
function fit(V, y, start, linear) {
  let x = [...start];
  for (let k = 0; k < 12; k++) {
    const base = swing(x, V, linear).map(s => s[1]), J = x.map((value, i) => {
      const step = 1e-5 * value, moved = swing(x.map((v, j) => j === i ? v + step : v), V, linear);
      return moved.map((s, n) => (s[1] - base[n]) / step);
    });
    const normal_matrix = J.map(a => J.map(b => a.reduce((sum, v, n) => sum + v * b[n], 0)));
    const move = solve(normal_matrix, J.map(a => [a.reduce((sum, v, n) => sum + v * (y[n] - base[n]), 0)]))
                   .map(([v]) => v);
    const limit = Math.min(1, ...move.map((m, i) => 0.3 * Math.abs(x[i] / m)));
    x = x.map((v, i) => v + limit * move[i]);
    if (Math.max(...move.map((m, i) => Math.abs(m / x[i]))) < 1e-7) break;
  }
  return x;
}

class Chirp extends Mover {
  says = "A chirp of {amplitude} shakes the body, and the noise of its gyro is {noise}.";
  get horizon() { return T * STEPS; }
  get still() { return 3; }

  figures = {
    scene: "The body hangs; the motors shake it.",
    log: "What the gyro says (solid) and the fitted models: pendulum (dashed), linear (dotted).",
    bars: "Error of the fitted ratios. Left: the pendulum; right: its linear model."
  };

  voltage(amplitude) {
    const {low, high} = this.data, end = T * STEPS;
    return Array.from({length: STEPS},
      (_, k) => amplitude * Math.sin(2 * Math.PI * (low * k * T + (high - low) * (k * T) ** 2 / (2 * end))));
  }

  compute({amplitude, noise}) {
    const {truth} = this.data, V = this.voltage(amplitude), motion = swing(truth, V, false);
    const random = normal(2023);
    const y = motion.map(s => s[1] + noise * Math.PI / 180 * random());
    const start = truth.map(v => 0.9 * v);
    return {V, y, q: motion.map(s => s[0]), fits: [false, true].map(linear => fit(V, y, start, linear))};
  }

  show({V, y, q, fits}) {
    const {truth} = this.data, off = fits.map(x => x.map((v, i) => 100 * (v / truth[i] - 1)));
    const widest = degrees(Math.max(...q.map(Math.abs))), names = ["e/c", "f/c", "d/c"];
    const bad = Math.abs(off[1][2]) > 1;
    this.tell(bad ? "infeasible" : "feasible",
      bad ? `The linear model's d/c is wrong by ${Math.abs(off[1][2]).toFixed(1)} %.`
          : "Both find d/c to a per cent.",
      `<p>The body swings up to ${number(widest, "°", 2)}. Errors of e/c, f/c, d/c: pendulum ${
        off[0].map(x => number(x, " %", 2)).join(", ")}; linear ${
        off[1].map(x => number(x, " %", 2)).join(", ")}.</p>`);
    const line = (values, colour, dash) => ({points: series(values, T, 3), colour, dash});
    const speeds = (x, linear) => swing(x, V, linear).map(s => s[1]);
    this.curves("log", "θ′ (rad/s)", "The gyro and two fits", [
      line(y), line(speeds(fits[1], true), "--sos-second", "2 2"),
      line(speeds(fits[0], false), "--sos-region", "6 4")
    ]);
    const top = Math.max(2, ...off.flat().map(Math.abs)), bars = names.map((name, i) => {
      const errors = off.map((row, j) => bar(50 + 95 * i + 32 * j, 28, 120, 90 * clamp(row[i] / top, -1, 1),
                               j ? "--sos-second" : "--sos-region"));
      return `${errors.join("")}<text x="${80 + 95 * i}" y="232" text-anchor="middle">${name}</text>`;
    });
    this.find("bars").innerHTML = picture(240, `Errors of the fitted ratios, at most ${clean(top, 2)} %`,
      `<path class="sos-axis" d="M20 120H330"/>${bars.join("")}<text x="20" y="18">±${
        top.toPrecision(2)} %</text>`);
    this.find("scene").innerHTML = picture(240, "The body hangs below its axle",
      `<path class="sos-thin" d="M60 70H280M170 70V220" stroke-dasharray="3 4"/>` +
        `<g><rect class="sos-part" x="-18" y="-8" width="36" height="130" rx="8" style="stroke:var(--sos-first)"/></g>` +
        `<circle class="sos-part" cx="170" cy="70" r="22" style="fill:var(--sos-paper)"/>`);
  }

  pose({q}, time) {
    super.pose({q}, time);
    const k = Math.min(STEPS, Math.round(time / T));
    this.find("scene").querySelector("g").setAttribute(
      "transform", `translate(170 70) rotate(${round(degrees(-q[k]))})`);
  }
}

define("sos-chirp", Chirp);
