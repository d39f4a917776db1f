import {clean, define, round} from "./kit.js";
import {eigenvalues, make, motion, samples, spectralRadius} from "./linalg.js";
import {Mover, number, series} from "./mover.js";
import {picture, spring} from "./plot.js";

const STEPS = 300;

class Mass extends Mover {
  says =
    "The last body weighs m₄ = {m4}, on a damper of b₄ = {b4}; feedback of its acceleration lends it {lent}.";
  get horizon() { return 0.05; }
  get still() { return 0.05; }
  get pace() { return 0.01; }

  figures = {
    scene:
      "The chain; the last body is pushed with 1 N. A hundred times slower, motions as large as they fit.",
    speed: "Velocity of the last body.",
    size: "The largest pole over the mass. The mark is here; dashed b₄/m and dotted √(k₄/m)."
  };

  plant({b4}, mass) {
    const {D, S, k4} = this.data, more = b4 - k4.damper;
    const damp = D.map((row, i) => row.map((x, j) => x + (i > 1 && j > 1 ? (i === j ? more : -more) : 0)));
    return motion(make(4, 4, (i, j) => i === j ? [3, 2, 1, mass][i] : 0), damp, S);
  }

  largest(place, mass) { return spectralRadius(eigenvalues(this.plant(place, mass))); }

  compute(place) {
    const mass = place.m4 + place.lent, A = this.plant(place, mass), T = this.horizon / STEPS;
    const x =
      samples(A, make(8, 1, i => i === 7 ? 1 / mass : 0), Array(8).fill(0), Array(STEPS).fill([1]), T);
    const curve =
      Array.from({length: 25}, (_, k) => 10 ** (-5 + k / 4.8)).map(m => [m, this.largest(place, m)]);
    return {mass, poles: eigenvalues(A), z: x.map(v => v.slice(0, 4)), v: x.map(w => w[7]), curve};
  }

  show({mass, poles, z, v, curve}, ghost, {b4, lent}) {
    const T = this.horizon / STEPS, size = spectralRadius(poles);
    const peak = Math.max(...v), limit = b4 ? 1 / b4 : null;
    this.tell("feasible",
      b4 ? `A jump: the velocity goes to 1/b₄ = ${clean(limit)} m/s, the sooner the smaller the mass.`
         : "An impulse: without the damper the velocity has no limit as the mass vanishes.",
      `<p>Largest pole ${number(size, " rad/s")}; highest velocity ${number(peak, " m/s")}. ` +
        `Acceleration feedback lends ${number(lent, " kg")}: ${number(mass, " kg")} are felt.</p>`);
    this.curves("speed", "velocity (m/s)", "Velocity of the last body", [{points: series(v, T)}], {
      y: [Math.min(0, 1.1 * Math.min(...v)), Math.max(0.06, 1.1 * peak)],
      rules: limit ? [limit] : [],
      ghosts: ghost && [{points: series(ghost.v, T)}]
    });
    const log = list => list.map(p => p.map(Math.log10)), masses = curve.map(([m]) => m);
    const limitLine = (f, dash, colour) => ({points: log(masses.map(m => [m, f(m)])), dash, colour});
    this.curves("size", ["log₁₀ of the mass in kg", "log₁₀ of |s| in rad/s"], "Largest pole over the mass",
      [
        ...(b4 ? [limitLine(m => b4 / m, "6 4", "--sos-second")] : []),
        limitLine(m => Math.sqrt(this.data.k4.spring / m), "2 3", "--sos-third"), {points: log(curve)}
      ],
      {
        x: [-5, 0],
        y: [0, 7],
        marks: log([[Math.min(1, mass), size]]).map(point => [point, "--sos-first", 1])
      });
    this.grow = 18 / Math.max(1e-9, ...z.flat().map(Math.abs));
    const body = (k, w) => `<g><rect class="sos-part" x="${- w / 2}" y="-18" width="${w}" height="36" rx="4"${
      k === 3 ? ` style="stroke:var(--sos-first)" stroke-dasharray="${mass < 0.01 ? "4 3" : ""}"`
              : ""}/></g>`;
    this.find("scene").innerHTML = picture(120, "Four bodies in a row behind a wall",
      `<path class="sos-thin" d="M12 25V95"/><path class="sos-thin sos-springs"/>` +
        [46, 40, 34, 14 + 24 * Math.min(1, Math.cbrt(mass))].map((w, k) => body(k, w)).join("") +
        `<path class="sos-thin" style="stroke:var(--sos-bad)" d="M292 100h30m-8 -5l8 5l-8 5"/>` +
        `<text x="290" y="116">1 N</text>`);
  }

  pose({z}, time) {
    super.pose({z}, time);
    const k = Math.min(STEPS, Math.round(time / this.horizon * STEPS)), scene = this.find("scene");
    const x = z[k].map((value, i) => 70 + 76 * i + this.grow * value);
    scene.querySelectorAll("g").forEach(
      (group, i) => group.setAttribute("transform", `translate(${round(x[i])} 60)`));
    this.find("springs").setAttribute("d", [
      [12, x[0] - 23], [x[0] + 23, x[1] - 20], [x[1] + 20, x[2] - 17], [x[2] + 17, x[3] - 8]
    ].map(([a, b]) => spring([a, 60], [b,
       60])).join(""));
  }
}

define("sos-mass", Mass);
