// A turntable whose payload and its place are known by ranges, and a gain that is known:
// the box of plants is proven cell by cell, or a plant of it breaks the claim.
import {corners} from "../../kernel/law.js";

import {affine, covering, drawn, ends, middle, quotient} from "./cells.js";
import {clean, complex, define, round} from "./kit.js";
import {eigenvalues, rightmost, samples} from "./linalg.js";
import {Mover, number} from "./mover.js";
import {mark, picture, Plot} from "./plot.js";

const MOST = 600;  // cells that are tried: a drag stays a drag
const GRID = 17;   // plants a side of the map whose poles are looked at
const SECONDS = 1.5, STEPS = 400;
const TURN = 1;  // rad, of motor and table at first

class Ranges extends Mover {
  says =
    "The gain {gain} turns payloads from {m0} to {m1} at r² from {q0} to {q1}, and claims a decay of σ = {sigma}.";
  get horizon() { return SECONDS; }
  get still() { return 0; }
  get pace() { return 0.5; }

  figures = {
    map:
      "Payloads and the squares of their radii; drag a round handle of the box. Filled: proven cells. Dots: there a pole lies right of −σ.",
    scene:
      "From above, let go one radian from where it shall stand: the worst table of the box that was found, and the one in its middle. Blue: the motor. Half as fast."
  };

  // E and A + B K of a plant, in floats or in decimals.
  loop(plant, ring) { return [this.data.E, this.data.gains[this.chosen]].map(X => affine(X, plant, ring)); }

  /** @type {(plant: any) => any} */
  A(plant) { return quotient((...given) => this.loop(...given), plant); }
  poles(plant) { return eigenvalues(this.A(plant)); }

  box({m0, m1, q0, q1}) {
    return [[Math.min(m0, m1), Math.min(q0, q1)], [Math.max(m0, m1), Math.max(q0, q1)]];
  }

  compute(place) {
    this.chosen = place.gain;
    const {sigma} = place, box = this.box(place);
    const right = plant => rightmost(this.poles(plant));
    const tried = [middle(box), ...corners(box)];
    for (let k = 0; k < 9; k++)
      for (let j = 0; j < 9; j++)
        tried.push([0, 1].map(i => box[0][i] + (box[1][i] - box[0][i]) * [k, j][i] / 8));
    const worst = tried.map(p => [right(p), p]).reduce((a, b) => b[0] > a[0] ? b : a)[1];
    const broken = right(worst) >= -sigma;
    const work = covering((...given) => this.loop(...given), box, sigma, broken ? 0 : MOST);
    let step = work.next();
    while (!step.done) step = work.next();
    const {done, open} = step.value;
    const runs = [worst, middle(box)].map(plant => this.swing(plant));
    return {box, worst, right: right(worst), broken, done, open, at: this.poles(worst), runs};
  }

  // The angles of motor and table over time.
  /** @type {(plant: any) => any} */
  swing(plant) {
    const A = this.A(plant),
          x = samples(A, A.map(() => [0]), [TURN, TURN, 0, 0], Array(STEPS).fill([0]), SECONDS / STEPS);
    return {plant, x: x.map(v => v.slice(0, 2))};
  }

  show({box, worst, right, broken, done, open, at}, _ghost, {sigma}) {
    const [m, q] = worst, where = `payload ${number(m, " kg")}, radius ${number(Math.sqrt(q), " cm")}`;
    const pole = at.reduce((a, b) => b[0] > a[0] || (b[0] === a[0] && b[1] > a[1]) ? b : a);
    const found = `The worst plant that was found (${where}) has its slowest poles at ${
      complex(pole[0], Math.abs(pole[1]))}.`;
    const state = broken ? "infeasible" : open.length ? "undecided" : "feasible";
    const claim = `σ = ${clean(sigma)} s⁻¹`;
    this.tell(state,
      broken ? `Broken: a plant of the box is slower than ${claim}.`
        : open.length
        ? `Undecided for ${claim} within this page's number of cells.`
        : `Kept by every constant plant of the box: ${claim} is proven, in exact arithmetic, with ${
            done.length} ${done.length === 1 ? "cell" : "cells"}.`,
      `<p>${found}</p><p>Proven cells ${number(done.length)}, open ${
        number(open.length)}. True decay of the box, as far as was looked: ${number(-right, " s⁻¹")}.</p>`);
    this.map(box, worst, broken, done, open, sigma);
  }

  map(box, worst, broken, done, open, sigma) {
    const [loads, squares] = this.data.ranges;
    const plot = new Plot({x: loads, y: squares, labels: ["payload m (kg)", "r² (cm²)"]});
    plot.body += drawn(plot, box, done, open, broken ? "--sos-bad" : "--sos-ink");
    for (const [x, y] of this.slow(sigma))
      plot.body +=
        `<circle cx="${plot.X(x)}" cy="${plot.Y(y)}" r="2" style="fill:var(--sos-bad);fill-opacity:.55"/>`;
    if (broken) mark(plot, worst, "--sos-bad", 0, "stroke-width:4");
    plot.body += ends(plot, box);
    this.plot = plot;
    this.find("map").innerHTML = plot.svg(`Box of payloads from ${clean(box[0][0])} to ${
      clean(box[1][0])} kg and squared radii from ${clean(box[0][1])} to ${clean(box[1][1])} cm²; ${
      broken ? "a plant in it breaks the claim" : `${done.length} proven cells, ${open.length} open`}`);
  }

  // Plants of the whole map that are slower than sigma.
  slow(sigma) {
    if (this.looked !== `${this.chosen} ${sigma}`) {
      const [loads, squares] = this.data.ranges, at = ([a, b], k) => a + (b - a) * k / (GRID - 1);
      const all =
        Array.from({length: GRID * GRID}, (_, k) => [at(loads, k % GRID), at(squares, Math.floor(k / GRID))]);
      const known = this.grids[this.chosen] ??= all.map(plant => [plant, rightmost(this.poles(plant))]);
      this.dots = known.filter(([, right]) => right >= -sigma).map(([plant]) => plant);
      this.looked = `${this.chosen} ${sigma}`;
    }
    return this.dots;
  }

  wire() {
    this.grids = {};
    super.wire();
    this.handles(({end}) => ["m" + end, "q" + end]);
  }

  pose({runs}, time) {
    const k = Math.min(STEPS, Math.round(time / SECONDS * STEPS));
    const turned = ({plant: [m, q], x}, at, words) => {
      const [motor, load] = x[k], size = 9 * Math.cbrt(m), far = 6 * Math.sqrt(q);
      const end =
        (angle, length) => [at + length * Math.sin(angle), 84 - length * Math.cos(angle)].map(round);
      const [u, v] = end(load, far);
      return `<circle class="sos-part" cx="${at}" cy="84" r="72"/>` +
        `<path class="sos-thin" d="M${at} 84L${end(load, 72).join(" ")}M${at} 6V16"/>` +
        `<circle cx="${u}" cy="${v}" r="${round(size)}" style="fill:var(--sos-second)"/>` +
        `<circle class="sos-part" cx="${at}" cy="84" r="14"/>` +
        `<path d="M${at} 84L${end(motor, 24).join(" ")}" style="stroke:var(--sos-first);stroke-width:4"/>` +
        `<text x="${at}" y="172" text-anchor="middle">${words}</text>`;
    };
    const [worst, mean] = runs;
    this.find("scene").innerHTML = picture(180, "Two turntables with payloads, seen from above",
      turned(worst, 84, "the worst") + turned(mean, 256, "the middle"));
  }
}

define("sos-ranges", Ranges);
