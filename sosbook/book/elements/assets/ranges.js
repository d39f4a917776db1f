// A crane whose load and rope are known by ranges, and a gain that is known: the box of
// plants is proven cell by cell, or a plant of it breaks the claim. All of it in floats.
import {Blocks} from "../../kernel/blocks.js";
import {cholesky, identity, inverseLower, matrix, rowsOf} from "../../kernel/matrices.js";
import {phaseOne} from "../../kernel/solver.js";

import {corners, halves, middle} from "./cells.js";
import {clean, complex, define, round} from "./kit.js";
import {block, combine, eigenvalues, eye, lyapunov, mul, rightmost, scale, solve, spectralRadius, transpose, zeros} from "./linalg.js";
import {Mover, number, samples, verdict} from "./mover.js";
import {mark, picture, Plot} from "./plot.js";

const MOST = 24;   // cells that are tried: a drag stays a drag
const BOUND = 10;  // of P and the multipliers, where one is their natural size
const GRID = 17;   // plants a side of the map whose poles are looked at
const SECONDS = 20, STEPS = 400;
const TURN = 0.15;  // rad, of the rope at first

class Ranges extends Mover {
  get horizon() { return SECONDS; }
  get still() { return 0; }
  get pace() { return 2; }

  figures() {
    return [
      [
        "map",
        "Loads and ropes; drag a round handle of the box. Filled: proven cells. Dots: there a pole lies right of −σ."
      ],
      ["scene", "The worst plant of the box that was found, and pale the one in its middle. Twice as fast."]
    ];
  }

  // E and A + B K of a plant: between those at the corners of the map.
  /** @type {(plant: any) => any} */
  loop([m, l]) {
    const [loads, ropes] = this.data.ranges, [a, b, c, d] = this.data.gains[this.chosen];
    const t = (m - loads[0]) / (loads[1] - loads[0]), s = (l - ropes[0]) / (ropes[1] - ropes[0]);
    return ["E", "A"].map(
      name => combine(1 - t, combine(1 - s, a[name], s, b[name]), t, combine(1 - s, c[name], s, d[name])));
  }

  poles(plant) { return eigenvalues(solve(...this.loop(plant))); }

  // Whether a P for each corner of a cell and common multipliers prove the decay in it.
  // In coordinates and a unit of time in which the cell's middle has E = I and P near I.
  proven(cell, sigma) {
    const [E, A] = this.loop(middle(cell)), N = E.length, free = solve(E, A);
    const poles = eigenvalues(free), rate = spectralRadius(poles);
    const slower = combine(1, free, -0.9 * rightmost(poles), eye(N));
    const L = cholesky(matrix(lyapunov(transpose(slower), eye(N))));
    if (!L) return false;
    const T = transpose(rowsOf(inverseLower(L)));
    const ends = corners(cell), unknowns = {FG: {rows: 2 * N, cols: N}};
    ends.forEach((_, i) => { unknowns[`P${i}`] = {rows: N, cols: N, symmetric: true}; });
    const blocks = new Blocks(unknowns), nothing = n => matrix(zeros(n, n));
    const decay = matrix([...scale(-sigma / rate, eye(N)), ...scale(-1, eye(N))]);
    ends.forEach((plant, i) => {
      const [Ei, Ai] = this.loop(plant).map(X => solve(T, solve(E, mul(X, T))));
      const motion = matrix(block([[scale(1 / rate, Ai), scale(-1, Ei)]]));
      blocks.add("P", nothing(N), [[`P${i}`, identity(N, 0.5), identity(N)]]);
      blocks.add("size", identity(N, BOUND), [[`P${i}`, identity(N, -0.5), identity(N)]]);
      blocks.add("decay", nothing(2 * N),
        [[`P${i}`, decay, matrix(block([[eye(N), zeros(N, N)]]))], ["FG", identity(2 * N, -1), motion]]);
    });
    const [above, right] = [[...eye(2 * N), ...zeros(N, 2 * N)], block([[zeros(N, 2 * N), eye(N)]])];
    blocks.add("size", identity(3 * N, BOUND), [["FG", matrix(above), matrix(right)]]);
    return phaseOne(blocks).verdict === "feasible";
  }

  box({m0, m1, l0, l1}) {
    return [[Math.min(m0, m1), Math.min(l0, l1)], [Math.max(m0, m1), Math.max(l0, l1)]];
  }

  compute(place) {
    this.chosen = place.gain;
    const {sigma} = place, box = this.box(place), done = [], open = [];
    const right = plant => rightmost(this.poles(plant));
    const tried = [middle(box), ...corners(box)];
    for (let k = 0; k < 9; k++)
      for (let j = 0; j < 9; j++)
        tried.push([0, 1].map(i => box[0][i] + (box[1][i] - box[0][i]) * [k, j][i] / 8));
    const worst = tried.map(p => [right(p), p]).reduce((a, b) => b[0] > a[0] ? b : a)[1];
    const broken = right(worst) >= -sigma, todo = broken ? [] : [box];
    for (let count = 0; todo.length; count++) {
      const cell = todo.shift();
      if (count >= MOST) open.push(cell);
      else if (this.proven(cell, sigma)) done.push(cell);
      else todo.push(...halves(plant => solve(...this.loop(plant)), cell));
    }
    return {
      box,
      worst,
      right: right(worst),
      broken,
      done,
      open,
      at: this.poles(worst),
      runs: [worst, middle(box)].map(plant => this.swing(plant))
    };
  }

  // The crane's place and the rope's angle over time, let go with the rope turned.
  /** @type {(plant: any) => any} */
  swing(plant) {
    const A = solve(...this.loop(plant)), none = A.map(() => [0]);
    const x = samples(A, none, [0, TURN, 0, 0], Array(STEPS).fill([0]), SECONDS / STEPS);
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
          : open.length ? `Undecided for ${claim} within this page's number of cells.`
                        : `Kept by every plant of the box: ${claim} is proven, in floats, with ${
                            done.length} ${done.length === 1 ? "cell" : "cells"}.`) +
        `<p>${found}</p><p>Proven cells ${number(done.length)}, open ${
          number(open.length)}. True decay of the box, as far as was looked: ${number(-right, " s⁻¹")}.</p>`);
    this.map(box, worst, broken, done, open, sigma);
  }

  map(box, worst, broken, done, open, sigma) {
    const [loads, ropes] = this.data.ranges;
    const plot = new Plot({x: loads, y: ropes, labels: ["load m (t)", "rope l (m)"]});
    const rect = ([low, high], style) => `<rect x="${plot.X(low[0])}" y="${plot.Y(high[1])}" width="${
                                           round(plot.X(high[0]) - plot.X(low[0]))}" ` +
      `height="${round(plot.Y(low[1]) - plot.Y(high[1]))}" style="${style}"/>`;
    plot.body +=
      done.map(cell => rect(cell, "fill:var(--sos-region);fill-opacity:.3;stroke:var(--sos-region)"))
        .join("");
    plot.body +=
      open.map(cell => rect(cell, "fill:none;stroke:var(--sos-soft);stroke-dasharray:3 3")).join("");
    for (const [x, y] of this.slow(sigma))
      plot.body +=
        `<circle cx="${plot.X(x)}" cy="${plot.Y(y)}" r="2" style="fill:var(--sos-bad);fill-opacity:.55"/>`;
    plot.body += rect(box, `fill:none;stroke:var(--${broken ? "sos-bad" : "sos-ink"});stroke-width:1.6`);
    if (broken) mark(plot, worst, "--sos-bad", 0, "stroke-width:4");
    plot.body +=
      box
        .map(([x, y], k) =>
               `<circle class="sos-handle" data-end="${k}" cx="${plot.X(x)}" cy="${plot.Y(y)}" r="8"/>`)
        .join("");
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
