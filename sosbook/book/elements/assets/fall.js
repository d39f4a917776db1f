import {clamp, clean, define, degrees, round} from "./kit.js";
import {samples} from "./linalg.js";
import {Mover, number, series} from "./mover.js";
import {linear, runge, slope} from "./pendulum.js";
import {picture} from "./plot.js";

const T = 0.005, STEPS = 160, METRE = 900, GROUND = 200;  // s; units of the drawing a metre

class Fall extends Mover {
  says = "Let go at {angle}, with {volts} for the first {pulse}, and the inertia of the rotors {rotors}.";
  get horizon() { return T * STEPS; }
  get still() { return 0.3; }
  get pace() { return 0.25; }

  figures = {
    scene: "Solid: the pendulum. Dashed: its linear model. A quarter of the true speed.",
    tilt: "Tilt θ; dashed the linear model.",
    wheel: "Wheels' angle φ; dashed the linear model."
  };

  compute({angle, volts, pulse, rotors}) {
    const mip = this.data.robots[rotors], start = [angle * Math.PI / 180, 0, 0, 0];
    const V = Array.from({length: STEPS}, (_, k) => k * T < pulse - 1e-9 ? volts : 0);
    const [A, B] = linear(mip);
    const line = samples(A, B, start, V.map(v => [v]), T), all = [start];
    for (const v of V) all.push(runge(x => slope(mip, x, v), all.at(-1), T));
    const apart = all.findIndex((x, k) => Math.abs(x[0] - line[k][0]) > 5 * Math.PI / 180);
    const [theta, phi, lineTheta, linePhi] = [all, line].flatMap(run => [0, 1].map(i => run.map(x => x[i])));
    return {theta, phi, lineTheta, linePhi, apart: apart < 0 ? null : apart * T};
  }

  show({theta, phi, lineTheta, linePhi, apart}, ghost) {
    const plot = (name, label, y, line, curve, old) =>
      this.curves(name, `${label} (degrees)`, `${label} (degrees)`,
        [
          {points: series(line.map(degrees), T), colour: "--sos-second", dash: "6 4"},
          {points: series(curve.map(degrees), T)}
        ],
        {y, ghosts: old && [{points: series(old.map(degrees), T)}]});
    plot("tilt", "θ", [-120, 120], lineTheta, theta, ghost?.theta);
    const far = phi.map(x => 1.2 * degrees(x)), turned = [Math.min(-90, ...far), Math.max(90, ...far)];
    plot("wheel", "φ", turned, linePhi, phi, ghost?.phi);
    const down = theta.findIndex(x => Math.abs(x) > Math.PI / 2);
    this.tell("feasible",
      apart === null ? `Both models agree within 5° for ${clean(this.horizon)} s.`
                     : `The models are 5° apart after ${clean(apart)} s.`,
      `<p>After ${clean(this.horizon)} s the pendulum leans by ${
        number(degrees(theta.at(-1)), "°")}, its linear model by ${number(degrees(lineTheta.at(-1)), "°")}.` +
        (down < 0 ? "" : ` The pendulum passes 90° after ${number(down * T, " s")}.`) + "</p>");
    const robot = dash =>
      `<g><path class="sos-part" style="fill:none;stroke:var(${
        dash ? "--sos-second" : "--sos-first"})" stroke-dasharray="${dash}" d="M-10 6V-78H10V6Z"/>` +
      `<circle class="sos-part" style="fill:var(--sos-paper)" stroke-dasharray="${dash}" r="${
        METRE * 0.032}"/><path class="sos-thin" d="M0 0V-26"/></g>`;
    this.find("scene").innerHTML = picture(260, "The falling pendulum and its linear model",
      `<path class="sos-thin" d="M0 ${GROUND}H340"/>${robot("5 4")}${robot("")}`);
  }

  pose({theta, phi, lineTheta, linePhi}, time) {
    super.pose(null, time);
    const k = Math.min(STEPS, Math.round(time / T));
    const groups = this.find("scene").querySelectorAll("g");
    [[lineTheta, linePhi], [theta, phi]].forEach(([lean, turn], i) => {
      const x = clamp(170 + METRE * 0.032 * turn[k], -40, 380);
      groups[i].setAttribute("transform", `translate(${round(x)} ${round(GROUND - METRE * 0.032)})`);
      groups[i].children[0].setAttribute("transform", `rotate(${round(degrees(lean[k]))})`);
      groups[i].children[2].setAttribute("transform", `rotate(${round(degrees(turn[k]))})`);
    });
  }
}

define("sos-fall", Fall);
