import {define, degrees} from "./kit.js";
import {add, apply, eigenvalues, held, make, mul} from "./linalg.js";
import {mark, Mover, number, verdict} from "./mover.js";
import {linear} from "./pendulum.js";
import {Plot} from "./plot.js";

const TILT = 2 * Math.PI / 180;

class Clock extends Mover {
  get horizon() { return 0.6; }
  get still() { return 0.6; }
  get pace() { return 0.2; }

  figures() {
    return [
      [
        "circle",
        "Eigenvalues of the sampled loop of the middle robot. Outside the circle: unstable."
      ],
      ["tilt", "Tilt from 2°, a fifth of the true speed."],
      ["volts", "Voltage: held from tick to tick, late by the delay. No limit is at work here."]
    ];
  }

  // x(k + 1) = step x(k); the state is [x; V(k - 1); wheels(k - 1); integral].
  loop(robot, K, T, delay, differenced) {
    const [A, B] = linear(robot), [Phi] = held(A, B, T), [rest, fresh] = held(A, B, T - delay);
    const [, old] = held(A, B, delay);
    const late = mul(rest, old), rate = differenced ? [-1 / T, 1 / T, 1, 0] : [0, 0, 0, 1];
    const volts = [[0, 1, 2, 3].map(i => (i < 3 ? K[i] : 0) + K[3] * rate[i]).concat([
      0, differenced ? -K[3] / T : 0, K[4] ?? 0
    ])];
    const free = make(7, 7,
      (i, j) => i < 4 ? (j < 4        ? Phi[i][j]
                            : j === 4 ? late[i][0]
                                      : 0)
        : i === 5     ? (j === 1      ? 1
                            : j === 0 ? -1
                                      : 0)
        : i === 6     ? (j === 1      ? T
                            : j === 6 ? (K.length > 4 ? 1 : 0)
                                      : 0)
                      : 0);
    return [add(free, mul(make(7, 1, i => i < 4 ? fresh[i][0] : i === 4 ? 1 : 0), volts)), volts];
  }

  good({radius}) { return radius.every(r => r < 1); }
  get means() { return "all five robots are stable"; }

  compute({law, T: milliseconds, delay, sensing}) {
    const T = milliseconds / 1000, {K} = this.data.laws[law], late = delay / 100 * T;
    const loops = this.data.robots.map(robot => this.loop(robot, K, T, late, sensing === 1));
    const poles = eigenvalues(loops[0][0]);
    const radius = loops.map(([step]) => Math.max(...eigenvalues(step).map(p => Math.hypot(...p))));
    const theta = [], V = [], count = Math.round(this.horizon / T);
    let x = [TILT, 0, 0, 0, 0, 0, 0];
    x[5] = -TILT;  // the encoders' angle one tick ago, at rest
    for (let k = 0; k <= count; k++) {
      theta.push(x[0]);
      V.push(apply(loops[0][1], x)[0]);
      x = apply(loops[0][0], x);
    }
    return {poles, radius, theta, V, T, late};
  }

  show({poles, radius, theta, V, T, late}, ghost) {
    const good = this.good({radius});
    const plot = new Plot({x: [-1.6, 1.6], y: [-1.6, 1.6], labels: ["Re z", "Im z"]});
    plot.body += `<ellipse class="sos-target" style="fill:none" cx="${plot.X(0)}" cy="${
      plot.Y(0)}" rx="${plot.X(1) - plot.X(0)}" ry="${plot.Y(0) - plot.Y(1)}"/>`;
    const live = list => list.filter(p => Math.hypot(...p) > 1e-9 && plot.has(p));
    live(ghost?.poles ?? []).forEach(p => mark(plot, p, "--sos-first", 0, "opacity:.3"));
    live(poles).forEach(p => mark(plot, p, "--sos-first"));
    this.find("circle").innerHTML = plot.svg("Eigenvalues of the sampled loop and the unit circle");
    this.tell(good ? "feasible" : "infeasible",
      verdict(good ? "Stable for all five robots."
                   : `Unstable for ${radius.filter(r => r >= 1).length} of five robots.`) +
        `<p>Sampled at ${number(1 / T, " Hz")}, late by ${
          number(1000 * late, " ms")}. Largest modulus: middle robot ${
          number(
            radius[0], "", 4)}, worst vertex ${number(Math.max(...radius.slice(1)), "", 4)}.</p>`);
    const clip = (v, most) => Math.max(-most, Math.min(most, v));
    const x = [0, this.horizon];
    const stairs = (list, step, delay) =>
      list
        .flatMap(
          (v, k) => [[k * step + delay, v], [Math.min(this.horizon, (k + 1) * step + delay), v]])
        .filter(p => p[0] <= this.horizon);
    this.plots = {
      tilt: this.curves("tilt", {
        x,
        y: [-4, 4],
        labels: ["time t (s)", "θ (degrees)"],
        label: "Tilt at the ticks",
        lines: [
          ...(ghost ? [{
            points: ghost.theta.map((v, k) => [k * ghost.T, degrees(v)]).filter(p => p[0] <= x[1]),
            ghost: true
          }]
                    : []),
          {points: theta.map((v, k) => [Math.min(k * T, x[1]), degrees(v)])}
        ]
      }),
      volts: this.curves("volts", {
        x,
        y: [-4, 4],
        labels: ["time t (s)", "V (volts)"],
        label: "Voltage over time",
        lines: [{points: stairs(V.map(v => clip(v, 100)), T, late), colour: "--sos-second"}]
      })
    };
  }

  pose(_, time) {
    for (const [name, plot] of Object.entries(this.plots)) this.now(name, plot, time);
  }
}

define("sos-clock", Clock);
