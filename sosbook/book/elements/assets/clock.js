import {clean, define, degrees} from "./kit.js";
import {apply, eigenvalues, spectralRadius} from "./linalg.js";
import {Mover, number, stairs} from "./mover.js";
import {sampledLoop} from "./pendulum.js";
import {markAll, Plot} from "./plot.js";

const TILT = 2 * Math.PI / 180;

class Clock extends Mover {
  says = "Under {law} a tick comes every {T}, its voltage {delay} later; the wheels' rate is {sensing}.";
  get horizon() { return 0.6; }
  get still() { return 0.6; }
  get pace() { return 0.2; }

  figures = {
    circle: "Eigenvalues of the sampled loop of the middle robot. Outside the circle: unstable.",
    tilt: "Tilt from 2°, a fifth of the true speed.",
    volts: "Voltage: held from tick to tick, late by the delay. No limit is at work here."
  };

  good({radius}) { return radius.every(r => r < 1); }
  get means() { return "all five robots are stable"; }

  compute({law, T: milliseconds, delay, sensing}) {
    const T = milliseconds / 1000, {K} = this.data.laws[law], late = delay / 100 * T;
    const loops = this.data.robots.map(robot => sampledLoop(robot, K, T, late, sensing === 1));
    const all = loops.map(([step]) => eigenvalues(step)), [[step, volts]] = loops;
    const theta = [], V = [], count = Math.round(this.horizon / T);
    let x = [TILT, 0, 0, 0, 0, -TILT, 0];  // the encoders' angle one tick ago, at rest
    for (let k = 0; k <= count; k++) {
      theta.push([Math.min(k * T, this.horizon), degrees(x[0])]);
      V.push([k * T + late, apply([volts], x)[0]]);
      x = apply(step, x);
    }
    return {poles: all[0], radius: all.map(spectralRadius), theta, V, T, late};
  }

  show({poles, radius, theta, V, T, late}, ghost) {
    const plot = new Plot({x: [-1.6, 1.6], y: [-1.6, 1.6], labels: ["Re z", "Im z"]});
    plot.body += `<ellipse class="sos-target" style="fill:none" cx="${plot.X(0)}" cy="${plot.Y(0)}" rx="${
      plot.X(1) - plot.X(0)}" ry="${plot.Y(0) - plot.Y(1)}"/>`;
    markAll(plot, ...[ghost?.poles ?? [], poles].map(all => all.filter(p => Math.hypot(...p) > 1e-9)));
    const good = this.good({radius}), [middle, ...others] = radius;
    this.draw("circle", plot, `Eigenvalues of the sampled loop, the largest of size ${clean(middle)}`);
    this.tell(good ? "feasible" : "infeasible",
      good ? "Stable for all five robots."
           : `Unstable for ${radius.filter(r => r >= 1).length} of five robots.`,
      `<p>Sampled at ${number(1 / T, " Hz")}, late by ${
        number(1000 * late, " ms")}. Largest modulus: middle robot ${number(middle, "", 4)}, worst vertex ${
        number(Math.max(...others), "", 4)}.</p>`);
    this.curves("tilt", "θ (degrees)", "Tilt at the ticks", [{points: theta}],
      {y: [-4, 4], ghosts: ghost && [{points: ghost.theta}]});
    this.curves("volts", "V (volts)", "Voltage over time",
      [{points: stairs(V, this.horizon), colour: "--sos-second"}], {y: [-4, 4]});
  }
}

define("sos-clock", Clock);
