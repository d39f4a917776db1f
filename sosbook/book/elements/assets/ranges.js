// A crane whose load and rope are known by ranges, and a gain that is known: the box of
// plants is proven cell by cell, or a plant of it breaks the claim.
import {affine, corners, covering, drawn, ends, middle, quotient} from "./cells.js";
import {clean, complex, define, round} from "./kit.js";
import {eigenvalues, rightmost, samples} from "./linalg.js";
import {Mover, number, verdict} from "./mover.js";
import {mark, picture, Plot} from "./plot.js";

const MOST = 600;  // cells that are tried: a drag stays a drag
const GRID = 17;   // plants a side of the map whose poles are looked at
const SECONDS = 20, STEPS = 400;
const TURN = 0.15;  // rad, of the rope at first

class Ranges extends Mover {
  get horizon() { return SECONDS; }
  get still() { return 0; }
  get pace() { return 2; }

  figures = {
    map:
      "Loads and ropes; drag a round handle of the box. Filled: proven cells. Dots: there a pole lies right of −σ.",
    scene: "The worst plant of the box that was found, and pale the one in its middle. Twice as fast."
  };

  // E and A + B K of a plant, in floats or in decimals.
  loop(plant, ring) { return [this.data.E, this.data.gains[this.chosen]].map(X => affine(X, plant, ring)); }

  /** @type {(plant: any) => any} */
  A(plant) { return quotient((...given) => this.loop(...given), plant); }
  poles(plant) { return eigenvalues(this.A(plant)); }

  box({m0, m1, l0, l1}) {
    return [[Math.min(m0, m1), Math.min(l0, l1)], [Math.max(m0, m1), Math.max(l0, l1)]];
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

  // The crane's place and the rope's angle over time, let go with the rope turned.
  /** @type {(plant: any) => any} */
  swing(plant) {
    const A = this.A(plant),
          x = samples(A, A.map(() => [0]), [0, TURN, 0, 0], Array(STEPS).fill([0]), SECONDS / STEPS);
    return {plant, x: x.map(v => v.slice(0, 2))};
  }

  show({box, worst, right, broken, done, open, at}, _ghost, {sigma}) {
    const [m, l] = worst, where = `load ${number(m, " t")}, rope ${number(l, " m")}`;
    const pole = at.reduce((a, b) => b[0] > a[0] || (b[0] === a[0] && b[1] > a[1]) ? b : a);
    const found = `The worst plant that was found (${where}) has its slowest poles at ${
      complex(pole[0], Math.abs(pole[1]))}.`;
    const state = broken ? "infeasible" : open.length ? "undecided" : "feasible";
    const claim = `σ = ${number(sigma, " s⁻¹")}`;
    this.tell(state,
      verdict(broken ? `Broken: a plant of the box is slower than ${claim}.`
          : open.length
          ? `Undecided for ${claim} within this page's number of cells.`
          : `Kept by every constant plant of the box: ${claim} is proven, in exact arithmetic, with ${
              done.length} ${done.length === 1 ? "cell" : "cells"}.`) +
        `<p>${found}</p><p>Proven cells ${number(done.length)}, open ${
          number(open.length)}. True decay of the box, as far as was looked: ${number(-right, " s⁻¹")}.</p>`);
    this.map(box, worst, broken, done, open, sigma);
  }

  map(box, worst, broken, done, open, sigma) {
    const [loads, ropes] = this.data.ranges;
    const plot = new Plot({x: loads, y: ropes, labels: ["load m (t)", "rope l (m)"]});
    plot.body += drawn(plot, box, done, open, broken ? "--sos-bad" : "--sos-ink");
    for (const [x, y] of this.slow(sigma))
      plot.body +=
        `<circle cx="${plot.X(x)}" cy="${plot.Y(y)}" r="2" style="fill:var(--sos-bad);fill-opacity:.55"/>`;
    if (broken) mark(plot, worst, "--sos-bad", 0, "stroke-width:4");
    plot.body += ends(plot, box);
    this.plot = plot;
    this.find("map").innerHTML = plot.svg(`Box of loads from ${clean(box[0][0])} to ${
      clean(box[1][0])} t and ropes from ${clean(box[0][1])} to ${clean(box[1][1])} m; ${
      broken ? "a plant in it breaks the claim" : `${done.length} proven cells, ${open.length} open`}`);
  }

  // Plants of the whole map that are slower than sigma.
  slow(sigma) {
    if (this.looked !== `${this.chosen} ${sigma}`) {
      const [loads, ropes] = this.data.ranges, at = ([a, b], k) => a + (b - a) * k / (GRID - 1);
      const all =
        Array.from({length: GRID * GRID}, (_, k) => [at(loads, k % GRID), at(ropes, Math.floor(k / GRID))]);
      const known = this.grids[this.chosen] ??= all.map(plant => [plant, rightmost(this.poles(plant))]);
      this.dots = known.filter(([, right]) => right >= -sigma).map(([plant]) => plant);
      this.looked = `${this.chosen} ${sigma}`;
    }
    return this.dots;
  }

  wire() {
    this.grids = {};
    super.wire();
    this.handles(({end}) => ["m" + end, "l" + end]);
  }

  pose({runs}, time) {
    const k = Math.min(STEPS, Math.round(time / SECONDS * STEPS));
    const crane = ({plant: [load, rope], x}, kind) => {
      const [s, turn] = x[k], at = 170 + 14 * s, down = 14 * rope, size = 10 * Math.cbrt(load);
      const [u, v] = [at + down * Math.sin(turn), 40 + down * Math.cos(turn)];
      return `<g style="${kind}"><rect class="sos-part" x="${
               round(at - 15)}" y="26" width="30" height="14" rx="3"/>` +
        `<path class="sos-thin" style="stroke:var(--sos-ink)" d="M${round(at)} 40L${round(u)} ${
          round(v)}"/>` +
        `<rect class="sos-part" x="${round(u - size)}" y="${round(v)}" width="${round(2 * size)}" height="${
          round(1.5 * size)}" rx="2"/></g>`;
    };
    const [worst, mean] = runs;
    this.find("scene").innerHTML = picture(340, "A crane's cart on its rail, with the load on its rope",
      `<path class="sos-thin" d="M8 44H332"/>` + crane(mean, "opacity:.35") + crane(worst, ""));
  }
}

define("sos-ranges", Ranges);
