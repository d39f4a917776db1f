import {clean, define, round} from "./kit.js";
import {add, dot, make, motion, mul, samples, scale, solve, zeros} from "./linalg.js";
import {Mover, number, series} from "./mover.js";
import {picture, spring} from "./plot.js";

const STEPS = 600, HEIGHT = 0.05;         // m, of the bump
const GROW = 700, AHEAD = 300, AT = 170;  // pixels a metre up, a second ahead, and the car

const most = values => Math.max(...values.map(Math.abs));

class Ride extends Mover {
  says =
    "The force makes small {made}, with a stroke of at most {stroke}; a body of {m} meets a bump that lasts {bump}.";
  snaps = ["stroke"];
  get horizon() { return 1.5; }
  get still() { return 0.07; }
  get pace() { return 0.3; }

  figures = {
    scene: "The car over a bump of 5 cm, a third as fast as it is. Heights are stretched.",
    felt: "Acceleration of the body; dashed without a force.",
    stroke: "Stroke, body minus wheel; dashed without a force.",
    force: "Force between body and wheel."
  };

  // What was designed here; its gain is missing where nothing was found.
  design({made, stroke}) {
    const {designs, strokes} = this.data;
    const near = strokes.map(s => Math.abs(s - stroke));
    return made ? designs[made - 1][near.indexOf(Math.min(...near))] : {K: null};
  }

  road(t, bump) { return t > 0 && t < bump ? HEIGHT * Math.sin(Math.PI * t / bump) ** 2 : 0; }

  run({m, bump}, K) {
    const [light, heavy] = this.data.plants, [low, high] = this.data.masses;
    const part = (m - low) / (high - low),
          between = key => add(scale(1 - part, light[key]), scale(part, heavy[key]));
    const [M, D, S, B, F] = ["M", "D", "S", "B", "F"].map(between);
    const free = motion(M, D, S), driven = solve(M, F), T = this.horizon / STEPS;
    const A = K ? add(free, [...zeros(2, 4), ...mul(solve(M, B), [K])]) : free;
    const w = make(1, STEPS + 1, (_, k) => this.road((k + 0.5) * T, bump))[0];
    const x = samples(A, [...zeros(2, 1), ...driven], [0, 0, 0, 0], w.slice(0, -1).map(v => [v]), T);
    const a = x.map((v, k) => dot(A[2], v) + driven[0][0] * w[k]), u = x.map(v => K ? dot(K, v) : 0);
    return {z: x.map(v => v.slice(0, 2)), a, s: x.map(v => v[0] - v[1]), u};
  }

  compute(place) {
    const design = this.design(place), passive = this.run(place, null);
    return {design, passive, ...(design.K ? this.run(place, design.K) : passive)};
  }

  show({design, passive, a, s, u}, _ghost, {made}) {
    const T = this.horizon / STEPS, {K, bounds, status} = design;
    this.tell(!made || K ? "feasible" : "infeasible",
      !made ? "No force: spring and damper alone."
        : K
        ? "Proven for every car: " + bounds.map(b => `${b.name} below ${clean(b.proven, 4)}`).join(", ") + "."
        : `These bounds: ${status}. The car rolls without a force.`,
      `<p>This car on this bump: acceleration up to ${number(most(a), " m/s²")} (without a force ${
        number(most(passive.a), " m/s²")}), stroke up to ${number(1000 * most(s), " mm")} (${
        number(1000 * most(passive.s), " mm")}), force up to ${number(most(u), " kN")}.</p>`);
    const beside = (key, by = 1) => {
      const points = values => series(values.map(v => by * v), T);
      return [
        {points: points(passive[key]), colour: "--sos-second", dash: "6 4"},
        ...(K ? [{points: points({a, s, u}[key])}] : [])
      ];
    };
    this.curves("felt", "acceleration (m/s²)", "Acceleration of the body", beside("a"));
    this.curves("stroke", "stroke (mm)", "Stroke over time", beside("s", 1000));
    this.curves("force", "force (kN)", "Force between body and wheel", [{points: series(u, T)}],
      {y: [Math.min(-0.1, 1.1 * Math.min(...u)), Math.max(0.1, 1.1 * Math.max(...u))]});
    this.find("scene").innerHTML = picture(190, "A car's body on a wheel on a road with a bump",
      `<path class="sos-thin sos-road"/><path class="sos-thin sos-springs"/>` +
        `<rect class="sos-part sos-body" x="${AT - 55}" y="-42" width="110" height="42" rx="6"/>` +
        `<circle class="sos-part sos-wheel" cx="${AT}" cy="-22" r="22"/>`);
  }

  pose(result, time) {
    super.pose(result, time);
    const k = Math.min(STEPS, Math.round(time / this.horizon * STEPS)), [body, wheel] = result.z[k];
    const ground = 170, up = height => round(ground - GROW * height);
    this.find("body").setAttribute("transform", `translate(0 ${up(body) - 75})`);
    this.find("wheel").setAttribute("transform", `translate(0 ${up(wheel)})`);
    this.find("springs").setAttribute("d", spring([AT, up(wheel) - 44], [AT, up(body) - 75], 9));
    this.find("road").setAttribute("d",
      Array
        .from({length: 86},
          (_, i) => `${i ? "L" : "M"}${4 * i} ${up(this.road(time + (4 * i - AT) / AHEAD, this.place.bump))}`)
        .join(""));
  }
}

define("sos-ride", Ride);
