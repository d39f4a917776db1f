import {define} from "./kit.js";
import {add, combine, eigenvalues, leastEigenvalue, mul, rightmost, scale, solve, stable, transpose} from "./linalg.js";
import {Mover, number} from "./mover.js";

const POINTS = 100;

class Segment extends Mover {
  says = "On the segment of the {plant}, the second vertex weighs {weight}.";
  figures = {
    poles: "Poles on the way from one vertex to the other (dots), and here (crosses).",
    right: "Real part of the rightmost pole. Above zero: unstable.",
    lmi:
      "Smallest eigenvalue of −L for the common P. Below zero the inequality fails; dashed: the pair's inequality −L₁₂ − L₂₁."
  };

  at({E, A}, a) { return [combine(1 - a, E[0], a, E[1]), combine(1 - a, A[0], a, A[1])]; }

  // Poles, and the smallest eigenvalue of -(A P E^T + E P A^T), at the weight a.
  look(plant, a) {
    const [E, A] = this.at(plant, a), half = mul(A, plant.P, transpose(E));
    const L = scale(-1, add(half, transpose(half)));
    return {poles: eigenvalues(solve(E, A)), least: leastEigenvalue(L)};
  }

  good({poles}) { return stable(poles); }
  get means() { return "this plant is stable"; }

  probe({plant, weight}) { return this.good(this.look(this.data.plants[plant], weight)); }

  compute({plant, weight}) {
    const chosen = this.data.plants[plant];
    const all = Array.from({length: POINTS + 1}, (_, k) => this.look(chosen, k / POINTS));
    const {E, A, P} = chosen;
    const pair = add(mul(A[0], P, transpose(E[1])), mul(A[1], P, transpose(E[0])));
    const least = leastEigenvalue(scale(-1, add(pair, transpose(pair))));
    return {...this.look(chosen, weight), way: all, pair: least};
  }

  show({poles, least, way, pair}, ghost, {plant, weight}) {
    const right = rightmost(poles), {window} = this.data.plants[plant];
    const bad = way.filter(p => rightmost(p.poles) >= 0).length / way.length;
    this.tell(this.good({poles}) ? "feasible" : "infeasible",
      right < 0 ? "This plant is stable." : "This plant is unstable.",
      `<p>Weight of the second vertex ${number(weight)}: rightmost pole ${
        number(right, " s⁻¹")}, smallest eigenvalue of −L ${number(least)}. ` +
        `At the vertices ${number(way[0].least)} and ${number(way.at(-1).least)}; of the pair ${
          number(pair)}. About ${number(100 * bad, " %", 2)} of the way is unstable.</p>`);
    this.poleMap("poles", {
      x: window[0],
      y: window[1],
      label: "Poles along the segment",
      poles,
      ghost: ghost?.poles,
      draw: plot => {
        for (const p of way.flatMap(w => w.poles).filter(p => plot.has(p)))
          plot.body += `<circle class="sos-dot" cx="${plot.X(p[0])}" cy="${
            plot.Y(p[1])}" r="1.3" style="fill:var(--sos-soft)"/>`;
      }
    });
    const curve = f => way.map((w, k) => [k / POINTS, f(w)]), axis = {x: [0, 1]};
    const label = "weight of the second vertex";
    this.curves("right", [label, "Re s (s⁻¹)"], "Rightmost pole along the segment",
      [{points: curve(w => rightmost(w.poles))}], {
        ...axis,
        rules: [0],
        marks: [
          [[weight, right], "--sos-first", 0],
          ...[0, 1].map(a => [[a, rightmost(way[a * POINTS].poles)], "--sos-region", 1])
        ]
      });
    this.curves("lmi", [label, "eigenvalue"], "Smallest eigenvalue of the inequality along the segment",
      [{points: [[0, pair], [1, pair]], colour: "--sos-second", dash: "5 4"}, {points: curve(w => w.least)}],
      {
        ...axis,
        rules: [0],
        marks: [
          [[weight, least], "--sos-first", 0],
          ...[0, 1].map(a => [[a, way[a * POINTS].least], "--sos-region", 1])
        ]
      });
  }
}

define("sos-segment", Segment);
