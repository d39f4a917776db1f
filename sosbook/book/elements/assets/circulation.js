import {define} from "./kit.js";
import {apply, block, combine, eigenvalues, exponential, eye, scale, solve, zeros} from "./linalg.js";
import {Mover, number, series, verdict} from "./mover.js";
import {Plot} from "./plot.js";

const T = 0.05, STEPS = 1200;  // s
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);

class Circulation extends Mover {
  get horizon() { return T * STEPS; }
  get still() { return 60; }
  get pace() { return 6; }

  figures() {
    return [
      ["path", "The robot's hand in the plane, from (0.2, 0.2) at rest; six times as fast."],
      ["poles", "Poles in the upper half-plane. Right of the axis: unstable."],
      ["energy", "Energy of masses and springs. Damping takes, circulation gives."]
    ];
  }

  good({poles}) { return poles.every(([re]) => re < 0); }
  get means() { return "it comes to rest"; }

  compute({kappa, damping}) {
    const {M, D, S, K, start} = this.data, n = M.length, stiff = combine(1, S, kappa, K);
    const damp = scale(damping, D);
    const A =
      block([[zeros(n, n), eye(n)], [scale(-1, solve(M, stiff)), scale(-1, solve(M, damp))]]);
    const step = exponential(scale(T, A)), all = [[...start, ...start.map(() => 0)]];
    for (let k = 0; k < STEPS; k++) all.push(apply(step, all.at(-1)));
    const energy = all.map(
      x =>
        (dot(x.slice(n), apply(M, x.slice(n))) + dot(x.slice(0, n), apply(S, x.slice(0, n)))) / 2);
    return {poles: eigenvalues(A), z: all.map(x => x.slice(0, n)), energy};
  }

  show({poles, z, energy}, ghost, {kappa}) {
    const right = Math.max(...poles.map(([re]) => re)), good = this.good({poles});
    const most = Math.max(0.3, ...z.flat().map(Math.abs)) * 1.05;
    this.tell(good ? "feasible" : "infeasible",
      verdict(good ? "It comes to rest."
                   : "It never comes to rest: circulation gives more than damping takes.") +
        `<p>κ = ${number(kappa)}. Rightmost pole: real part ${number(right, " s⁻¹")}. After ${
          this.horizon} s ${
          number(100 * energy.at(-1) / energy[0], " %")} of the energy is there.</p>`);
    this.poleMap("poles",
      {x: [-0.7, 0.3], y: [0.6, 1.2], label: "Poles of the robot", poles, ghost: ghost?.poles});
    this.plot = new Plot({x: [-most, most], y: [-most, most], labels: ["z₁", "z₂"]});
    if (ghost)
      this.plot.body += `<path class="sos-line sos-ghost" style="stroke:var(--sos-first)" d="${
        this.plot.path(ghost.z.filter(p => this.plot.has(p)))}"/>`;
    this.plot.body +=
      `<path class="sos-line sos-trail" style="stroke:var(--sos-second)"/><circle class="sos-hand" r="6" style="fill:var(--sos-first)"/>`;
    this.find("path").innerHTML = this.plot.svg("Path of the hand");
    this.time_plot = this.curves("energy", {
      x: [0, this.horizon],
      labels: ["time t (s)", "energy"],
      label: "Energy over time",
      lines: [
        ...(ghost ? [{points: series(ghost.energy, T, 4), ghost: true}] : []),
        {points: series(energy, T, 4)}
      ]
    });
  }

  pose({z}, time) {
    const k = Math.min(STEPS, Math.round(time / T)), [x, y] = z[k];
    this.find("trail").setAttribute("d", this.plot.path(z.slice(0, k + 1)));
    this.find("hand").setAttribute("transform", `translate(${this.plot.X(x)} ${this.plot.Y(y)})`);
    this.now("energy", this.time_plot, k * T);
  }
}

define("sos-circulation", Circulation);
