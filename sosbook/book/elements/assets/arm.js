// An arm of many modes under one gain: it moves as its slowest mode, and each mode has a row of poles.
import {clamp, clean, define, round} from "./kit.js";
import {block, eigenvalues, make, rightmost, scale, zeros} from "./linalg.js";
import {Mover, number} from "./mover.js";
import {mark, picture, Plot} from "./plot.js";

const [LEFT, LONG, MIDDLE, HIGH] = [56, 264, 62, 34];  // of the arm in the picture, and its largest motion
const WINDOW = [-6, 4];                                // 1/s

class Arm extends Mover {
  says = "The arm is pushed at {a}, against the rate that is measured at {s}, with {g} for each m/s.";
  get horizon() { return 2; }
  get still() { return 0; }

  figures = {
    map: "Its slowest mode, slowed down and grown. Drag the push (arrow) and the sensor (ring).",
    poles: "Real parts, a row for each mode: crosses are kept, circles left out; pale without the push."
  };

  wire() {
    this.plot = {at: ({x}) => [(x - LEFT) / LONG]};
    super.wire();
    this.handles(({end}) => [end]);
  }

  good({all}) { return rightmost(all) < 0; }
  get means() { return "the arm settles"; }

  // Of the modes at a place, and the poles of the first n modes, in rows that are as large as their
  // frequency.
  at(x) { return this.data.shapes.map(shape => shape[Math.round(x * (shape.length - 1))]); }
  loop(n, push, seen, g) {
    const {frequencies: w, damping} = this.data, W = make(n, n, (i, j) => i === j ? w[i] : 0);
    const D = make(n, n, (i, j) => -g * push[i] * seen[j] - (i === j ? damping[i] : 0));
    return eigenvalues(block([[zeros(n, n), W], [scale(-1, W), D]]))
      .filter(([, im]) => im > 0)
      .sort((p, q) => Math.hypot(...p) - Math.hypot(...q));
  }

  compute({a, s, g}) {
    const {frequencies: w, damping, shapes, kept} = this.data, push = this.at(a), seen = this.at(s);
    const [few, all] = [kept, w.length].map(n => this.loop(n, push, seen, g));
    const slow = all.findIndex(([re]) => re === rightmost(all)), [re, im] = all[slow];
    // mode k moves as its share of the push over s² + d s + w²
    const amounts = w.map((v, k) => {
      const x = re * re - im * im + damping[k] * re + v * v, y = im * (2 * re + damping[k]);
      return [x, y].map((part, j) => (j ? -1 : 1) * push[k] * part / (x * x + y * y));
    });
    const own = amounts.every(([x, y]) => isFinite(x + y)) && Math.abs(push[slow] * g) > 1e-6;
    const shares = own ? amounts : w.map((_, k) => [k === slow ? 1 : 0, 0]);
    const shape = shapes[0].map(
      (_, i) => [0, 1].map(j => shares.reduce((sum, part, k) => sum + part[j] * shapes[k][i], 0)));
    // at first the place that moves most is at its end
    const [x, y] = shape.reduce((most, z) => Math.hypot(...z) > Math.hypot(...most) ? z : most);
    const back = x * x + y * y || 1;
    return {
      few,
      all,
      slow,
      shape: shape.map(([re, im]) => [(re * x + im * y) / back, (im * x - re * y) / back])
    };
  }

  show({few, all, slow}, _ghost, {a, s}) {
    const {kept, free} = this.data, [part, whole] = [few, all].map(rightmost), [, im] = all[slow];
    const does = x => `${x < 0 ? "decays" : "grows"} with ${number(Math.abs(x), " s⁻¹")}`;
    this.tell(whole < 0 ? "feasible" : "infeasible",
      whole < 0    ? "The arm settles."
        : part < 0 ? `Mode ${slow + 1} grows, which was left out.`
                   : `Mode ${slow + 1} grows.`,
      `<p>Of the ${kept} modes that were kept the slowest ${does(part)}, of all ${all.length} it ${
        does(whole)}, at ${number(im, " rad/s")}.</p>`);
    const plot = new Plot({x: WINDOW, y: [0.5, all.length + 0.5], labels: ["Re s (s⁻¹)", "mode"]});
    plot.rule("sos-axis", [0, 0], plot.y);
    all.forEach(([re], k) => {
      const colour = k < kept ? "--sos-first" : "--sos-second", shape = Number(k >= kept);
      const [now, before] = [re, free[k]].map(x => clamp(x, ...WINDOW));
      plot.line([[before, k + 1], [now, k + 1]], colour, "", " sos-ghost");
      mark(plot, [before, k + 1], colour, shape, "opacity:.3");
      mark(plot, [now, k + 1], colour, shape);
      plot.said.push(`mode ${k + 1} ${clean(re)}`);
    });
    this.draw("poles", plot, "Real parts of the poles by mode");
    const held = (end, x) => `<circle class="sos-handle" data-end="${end}" cx="${x}" r="8"/>`;
    this.find("map").innerHTML = picture(136, `An arm, pushed at ${clean(a)} m and measured at ${clean(s)} m`,
      `<rect class="sos-part" x="8" y="${MIDDLE - 22}" width="${
        LEFT - 8}" height="44" rx="4"/><path class="sos-line sos-beam" style="stroke:var(` +
        `--sos-ink);stroke-width:5"/><path class="sos-line sos-arrow" style="stroke:var(--sos-bad)"/>${
          held("a", round(LEFT + LONG * a))}${held("s", round(LEFT + LONG * s))}`);
  }

  pose({shape}, time) {
    const turn = 2 * Math.PI * time, last = shape.length - 1, {a, s} = this.stands;
    const y = shape.map(([re, im]) => round(MIDDLE - HIGH * (re * Math.cos(turn) - im * Math.sin(turn))));
    const at = x => y[Math.round(x * last)], map = this.find("map");
    map.querySelector(".sos-beam")
      .setAttribute("d", y.map((v, i) => `${i ? "L" : "M"}${round(LEFT + LONG * i / last)} ${v}`).join(""));
    const x = round(LEFT + LONG * a), below = at(a) + 34;
    map.querySelector(".sos-arrow").setAttribute("d", `M${x} ${below}V${at(a) + 5}l-4 7m4 -7l4 7`);
    const [push, ring] = map.querySelectorAll(".sos-handle");
    push.setAttribute("cy", below);
    ring.setAttribute("cy", at(s));
  }
}

define("sos-arm", Arm);
