import {clean, define} from "./kit.js";
import {apply, combine, dot, eigenvalues, exponential, motion, rightmost, scale, stable} from "./linalg.js";
import {Mover, number, series} from "./mover.js";
import {Plot} from "./plot.js";

const T = 0.05, STEPS = 1200;  // s

class Circulation extends Mover {
  says = "With circulation κ = {kappa} and damping {damping} the hand starts at (0.2, 0.2).";
  get horizon() { return T * STEPS; }
  get still() { return 60; }
  get pace() { return 6; }

  figures = {
    path: "The robot's hand in the plane, from (0.2, 0.2) at rest; six times as fast.",
    poles: "Poles in the upper half-plane. Right of the axis: unstable.",
    energy: "Energy of masses and springs. Damping takes, circulation gives."
  };

  good({poles}) { return stable(poles); }
  get means() { return "it comes to rest"; }

  compute({kappa, damping}) {
    const {M, D, S, K, start} = this.data, n = M.length;
    const A = motion(M, scale(damping, D), combine(1, S, kappa, K));
    const step = exponential(scale(T, A)), all = [[...start, ...start.map(() => 0)]];
    for (let k = 0; k < STEPS; k++) all.push(apply(step, all.at(-1)));
    const energy =
      all.map(x => (dot(x.slice(n), apply(M, x.slice(n))) + dot(x.slice(0, n), apply(S, x.slice(0, n)))) / 2);
    return {poles: eigenvalues(A), z: all.map(x => x.slice(0, n)), energy};
  }

  show({poles, z, energy}, ghost, {kappa}) {
    const good = stable(poles), most = Math.max(0.3, ...z.flat().map(Math.abs)) * 1.05;
    this.tell(good ? "feasible" : "infeasible",

      good ? "It comes to rest." : "It never comes to rest: circulation gives more than damping takes.",
      `<p>κ = ${number(kappa)}. Rightmost pole: real part ${number(rightmost(poles), " s⁻¹")}. After ${
        this.horizon} s ${number(100 * energy.at(-1) / energy[0], " %")} of the energy is there.</p>`);
    this.poleMap(
      "poles", {x: [-0.7, 0.3], y: [0.6, 1.2], label: "Poles of the robot", poles, ghost: ghost?.poles});
    const plot = this.plot = new Plot({x: [-most, most], y: [-most, most], labels: ["z₁", "z₂"]});
    if (ghost) plot.line(ghost.z.filter(p => plot.has(p)), "--sos-first", "", " sos-ghost");
    plot.line([], "--sos-second", "", " sos-trail");
    plot.body += `<circle class="sos-hand" r="6" style="fill:var(--sos-first)"/>`;
    this.draw("path", plot, `Path of the hand to (${z.at(-1).map(x => clean(x)).join(", ")})`);
    const curve = list => ({points: series(list, T, 4)});
    this.curves(
      "energy", "energy", "Energy over time", [curve(energy)], {ghosts: ghost && [curve(ghost.energy)]});
  }

  pose({z}, time) {
    super.pose({z}, time);
    const k = Math.min(STEPS, Math.round(time / T)), [x, y] = z[k];
    this.find("trail").setAttribute("d", this.plot.path(z.slice(0, k + 1)));
    this.find("hand").setAttribute("transform", `translate(${this.plot.X(x)} ${this.plot.Y(y)})`);
  }
}

define("sos-circulation", Circulation);
