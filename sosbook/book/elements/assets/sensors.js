// A motor that turns a load by a shaft which gives: the reader ticks what is measured, and drags
// the shaft, and the ranges of load and shaft. Gains are searched here, then proven for all of
// these plants.
import {corners} from "../../kernel/law.js";

import {covering, drawn, ends, middle, quotient} from "./cells.js";
import {clamp, clean, complex, define, drag, round} from "./kit.js";
import {eigenvalues, mul, rightmost, samples, spectralRadius, trace} from "./linalg.js";
import {Mover, number, series, wide} from "./mover.js";
import {mark, picture, Plot} from "./plot.js";
import {driven, hidden, law, loop, sought, ticked, unit} from "./sought.js";

const SECONDS = 3, STEPS = 600;
const PAIRS = [[0, 0], [1, 0], [0, 1], [1, 1]], TICKS = ["p1", "p2", "v1", "v2"];
const GRID = 9;                                     // plants a side of the box that are looked at
const CLAIMS = [0.5, 0.75, 0.9, 0.95, 0.98, 0.99];  // of the true decay, one after another
const MOST = 500;                                   // cells that are tried for each of these
const STILL = 1e-6;                                 // of the rate: no decay
const DISCS = [[74, 44, 30], [266, 44, 36]];        // x, y and radius of motor and load
const MIDDLE = 166, WAY = [86, 8];                  // y of the shaft's handle, soft and stiff
/** @type {any[][]} */
const SENSORS = [["p1", "φ₁", 44], ["v1", "φ₁′", 104], ["p2", "φ₂", 236], ["v2", "φ₂′", 296]];

// To three digits, towards zero.
const below = x => {
  const last = 10 ** (2 - Math.floor(Math.log10(x)));
  return Number((Math.floor(x * last) / last).toPrecision(3));
};

class Sensors extends Mover {
  says =
    "A motor turns {J0} to {J1} by a shaft of {k0} to {k1}. Its law sees {p1}, {p2}, {v1}, {v2} {integral}; a filter of {filter} makes other rates.";
  get horizon() { return SECONDS; }
  get still() { return 0.12; }
  get idles() { return true; }

  figures = {
    scene: "Tick a sensor, drag the shaft. Blue hand: the slowest plant; pale: the middle one. True speed.",
    map: "Loads and shafts that may be. Drag the ends of the range. Filled: proven cells.",
    choices: "Decay (s⁻¹) that the page finds for each choice of sensors. Choose a cell.",
    poles: "Crosses: slowest plant, circles: the middle one. Shaded: proven. Dotted: a fixed mean.",
    angle: "The load's angle φ₂ from 1 rad at rest. Blue: slowest plant, orange: the middle one."
  };

  // From the lightest load and the softest shaft to the others.
  box({J0, J1, k0, k1}) {
    return [[Math.min(J0, J1), Math.min(k0, k1)], [Math.max(J0, J1), Math.max(k0, k1)]];
  }

  key(place) {
    const {p1, p2, v1, v2, integral, filter} = place;
    return String([p1, p2, v1, v2, integral, filter, this.box(place)]);
  }

  // What is found for a choice, once: gains, their loop, and the slowest plant that is seen.
  best(place) {
    const box = this.box(place), key = this.key(place);
    if (this.known.has(key)) return this.known.get(key);
    const own = law(this.data, place), {names, rows} = own, free = loop(this.data, own, []);
    const plants = corners(box).map(point => driven(free, own.push, point));
    const gains = rows.length
      ? sought(plants, rows, names.map(k => this.data.limits[k]), names.map(k => k === "K_D"))
      : [];
    const found = loop(this.data, own, gains),
          right = point => rightmost(eigenvalues(quotient(found, point)));
    const part = k =>
      Array.from({length: GRID}, (_, i) => box[0][k] + (box[1][k] - box[0][k]) * i / (GRID - 1));
    const [loads, shafts] = [0, 1].map(k => [...new Set(part(k))]);
    const seen = loads.flatMap(J => shafts.map(k => [right([J, k]), [J, k]]));
    const [most, worst] = seen.reduce((a, b) => b[0] > a[0] ? b : a);
    this.known.set(key, {law: own, plants, gains, loop: found, worst, decay: -most});
    return this.known.get(key);
  }

  compute(place) {
    const {law: {N, names, rows}, plants, gains, loop, worst, decay} = this.best(place);
    const box = this.box(place);
    const means = plants.map(([F]) => trace(F) / N);
    const moved = rows.some(row => plants.some(([, b]) => mul([row], b)[0][0]));
    const [F, b] = plants[0], seen = TICKS.map((_, i) => unit(4, i)).filter((_, i) => place[TICKS[i]]);
    const loops = [worst, middle(box)].map(point => quotient(loop, point));
    const start = [1, 1, 0, 0, ...unit(N - 4, -1)];
    if (!ticked(place, "v").length) ticked(place, "p").forEach((_, k) => { start[N - 1 - k] = 1; });
    const runs = loops.map(A => samples(A, A.map(() => [0]), start, Array(STEPS).fill([0]), SECONDS / STEPS));
    const unseen = hidden(F.slice(0, 4).map(row => row.slice(0, 4)), b.slice(0, 4),
      seen).map(pole => pole.map(x => Math.abs(x) > STILL * this.size ? x : 0));
    const all = Object.fromEntries(TICKS.map(key => [key, 1])), full = this.best({...place, ...all}).decay;
    const limit = moved ? null : Math.min(...means.map(x => -x)), poles = loops.map(eigenvalues);
    const angles = runs.map(run => run.map(x => x.slice(0, 2))), proof = {sigma: 0, cells: [], tried: false};
    return {box, names, gains, worst, decay, poles, limit, means, unseen, full, angles, ...proof};
  }

  // When nothing moves: the proof, from smaller claims to larger ones; then the other choices.
  * looks(place) {
    const {loop, decay} = this.best(place), {result} = this;
    for (const share of this.decays(decay) ? CLAIMS : []) {
      const sigma = below(share * decay);
      const {done, open} = yield* covering(loop, result.box, sigma, MOST);
      if (open.length) break;
      Object.assign(result, {sigma, cells: done});
      this.map(result, place);
    }
    result.tried = true;
    this.show(result, this.ghost, place);
    this.seek(this.time);
    for (const choice of this.table(place)) {
      this.best(choice);
      yield;
      this.choices(place);
    }
  }

  decays(x) { return x > STILL * this.size; }

  // The other choices of ticks, in the order of the table.
  table(place) { return PAIRS.flatMap(([p1, p2]) => PAIRS.map(([v1, v2]) => ({...place, p1, p2, v1, v2}))); }

  wire() {
    this.known = new Map();
    const none = law(this.data, {filter: 0}), {ranges} = this.data;
    this.size = Math.max(
      ...corners(ranges).map(p => spectralRadius(eigenvalues(quotient(loop(this.data, none, []), p)))));
    super.wire();
    this.view.addEventListener("click", ({target}) => {
      const {tick, cell} = target.closest("[data-tick], [data-cell]")?.dataset ?? {};
      if (tick) this.move({[tick]: 1 - this.place[tick]});
      if (cell) this.move(Object.fromEntries(TICKS.map((key, k) => [key, Number(cell[k])])));
    });
    this.handles(({end}) => ["J" + end, "k" + end]);
    const {step} = this.data.controls.find(({key}) => key === "k0"), [[, soft], [, stiff]] = ranges;
    drag(this.find("scene"), () => [this.place.k0, this.place.k1], ([k0, k1], {y}) => {
      const wanted = soft + (stiff - soft) * (y - WAY[0]) / (WAY[1] - WAY[0]) - (k0 + k1) / 2;
      const shift = clamp(wanted, soft - Math.min(k0, k1), stiff - Math.max(k0, k1));
      const at = k => Number((soft + step * Math.round((k + shift - soft) / step)).toPrecision(12));
      this.move({k0: at(k0), k1: at(k1)}, false);
    });
  }

  off(key) {
    return (key === "integral" && !ticked(this.stands, "p").length) ||
      (key === "filter" && ticked(this.stands, "v").length > 0);
  }
  remember() {}

  said() {
    const {result} = this, others = [{}, {tried: true}, {sigma: 1}, {decay: 0}, {unseen: [[0, 0]]}];
    return others.map(more => {
      const [, words, html] = this.told({...result, decay: this.size, limit: 1, ...more});
      return [words, wide(html)];
    });
  }

  show(result, ghost, place) {
    this.tell(...this.told(result));
    this.scene(place);
    this.map(result, place);
    this.choices(place);
    this.plane(result, ghost);
    this.curves("angle", "φ₂ (rad)",
      "The load's angle over time, of the slowest plant and the one in the middle",
      [...result.angles].reverse().map((run, k) => ({
        points: series(run.map(x => x[1]), SECONDS / STEPS, 3),
        colour: k ? "--sos-first" : "--sos-second"
      })),
      {y: [-1.3, 1.3]});
  }

  told({names, gains, worst, decay, limit, unseen, full, sigma, cells, tried}) {
    const rate = x => number(x, " s⁻¹"), stable = this.decays(decay), [pole] = unseen;
    const left = pole && `the pole at ${complex(pole[0], Math.abs(pole[1]))}`;
    const state = stable ? "feasible" : pole ? "infeasible" : "undecided";
    const words = !stable && pole ? `No controller of any order moves ${left}: ${
                                      names.length ? "these sensors don't see it" : "nothing is measured"}.`
      : !stable ? "Undecided: the search found no gains that are stable in the whole range."
      : sigma   ? `Proven for every constant plant: σ = ${clean(sigma)} s⁻¹, exactly, in ${cells.length} ${
                    cells.length === 1 ? "cell" : "cells"}.`
      : tried ? `Stable as far as was looked; ${MOST} cells prove nothing.`
              : "Stable as far as was looked. The proof comes when nothing moves.";
    const kinds = [...new Set(names)].map(
      kind => `K<sub>${kind[2]}</sub> = ${
        number(0).replace(
          />.*</, `>${gains.filter((_, i) => names[i] === kind).map(x => clean(x)).join(", ")}<`)}`);
    const sum = limit === null
      ? "A gain moves the sum of the poles."
      : `No gain of these sensors moves the sum of the poles: none decays with ${rate(limit)} or faster.`;
    const any = pole
      ? stable ? `No controller of any order moves ${left}.` : ""
      : "With enough memory a controller gives any single plant any decay; of one controller for all of them that isn't said.";
    return [
      state, words,
      `<p>${kinds.join("; ") || "No gain"}. True decay, as far as was looked: ${
        rate(Math.abs(decay) > STILL * this.size ? decay : 0)}, with a load of ${
        number(worst[0], " kg m²")} and a shaft of ${number(worst[1], " N m/rad")}.</p>` +
        `<p>${sum}</p><p>With all four measured, no memory and the same limits of the gains the page finds ${
          rate(full)}. ${any}</p>`
    ];
  }

  map({box, cells, worst}, {J0, J1, k0, k1}) {
    const [low, high] = this.data.ranges;
    const [x, y] = [0, 1].map(k => [low[k], high[k]]), labels = ["load J (kg m²)", "shaft k (N m/rad)"];
    const plot = new Plot({x, y, labels, height: 260, box: [46, 332, 10, 218]});
    plot.body += drawn(plot, box, cells, [], "--sos-ink");
    mark(plot, worst, "--sos-first");
    plot.body += ends(plot, [[J0, k0], [J1, k1]]);
    this.plot = plot;
    this.find("map").innerHTML =
      plot.svg(`Loads from ${clean(box[0][0])} to ${clean(box[1][0])} kg m², shafts from ${
        clean(box[0][1])} to ${clean(box[1][1])} N m/rad; ${cells.length} proven cells`);
  }

  scene(place) {
    const [[x, y, r], [u, v, s]] = DISCS, [[, soft], [, stiff]] = this.data.ranges;
    const share = ((place.k0 + place.k1) / 2 - soft) / (stiff - soft);
    /** @type {(place: any, words: string) => string} */
    const disc = ([cx, cy, size], words) => `<circle class="sos-part" cx="${cx}" cy="${cy}" r="${size}"/>` +
      `<text x="${cx}" y="${cy + size + 14}" text-anchor="middle">${words}</text>`;
    const hands =
      DISCS.flatMap(([cx, cy, size], i) => [1, 0].map(
                      k => `<path class="sos-line sos-turn" data-disc="${i}" data-plant="${
                        k}" style="stroke-width:3;stroke:var(--sos-${k ? "second" : "first"});opacity:${
                        k ? 0.45 : 1}" d="M${cx} ${cy}V${cy - size + 4}"/>`));
    const sensors =
      SENSORS.map(([key, words, at]) =>
                    `<g data-tick="${key}"><rect class="sos-sensor${place[key] ? " sos-on" : ""}" x="${
                      at - 24}" y="106" width="48" height="26" rx="5"/>` +
          `<text x="${at}" y="123" text-anchor="middle">${words}</text></g>`);
    this.find("scene").innerHTML = picture(140,
      `A motor and a load on a shaft; measured: ${
        SENSORS.filter(([key]) => place[key]).map(([, words]) => words).join(", ") || "nothing"}`,
      `<path class="sos-thin sos-shaft" style="stroke-width:${
        round(1 + 4 * share)}"/><path class="sos-thin" d="M${x} ${y + r + 18}V106M${u} ${v + s + 18}V106M${
        MIDDLE} ${WAY.join("V")}"/>` +
        disc(DISCS[0], "motor, torque u") + disc(DISCS[1], "load") + hands.join("") + sensors.join("") +
        `<circle class="sos-handle" cx="${MIDDLE}" cy="${
          round(WAY[0] + share * (WAY[1] - WAY[0]))}" r="8"/>`);
  }

  pose({angles}, time) {
    const k = Math.min(STEPS, Math.round(time / SECONDS * STEPS)), scene = this.find("scene");
    for (const hand of scene.querySelectorAll(".sos-turn")) {
      const {disc, plant} = hand.dataset, [x, y] = DISCS[disc];
      hand.setAttribute(
        "transform", `rotate(${round(180 / Math.PI * (angles[plant][k][disc] % 7e3))} ${x} ${y})`);
    }
    const [one, two] = angles[0][k], twist = Math.max(-12, Math.min(12, 40 * (two - one)));
    const [[x, y, r], [u, , s]] = DISCS, [from, to] = [x + r, u - s], step = (to - from) / 8;
    const bends =
      Array.from({length: 8}, (_, i) => `q${round(step / 2)} ${round(i % 2 ? -twist : twist)} ${step} 0`);
    scene.querySelector(".sos-shaft").setAttribute("d", `M${from} ${y}${bends.join("")}`);
    super.pose({angles}, time);
  }

  choices(place) {
    const names = ["none", "φ₁", "φ₂", "both"], rates = ["filter", "φ₁′", "φ₂′", "both"];
    const key = one => TICKS.map(name => one[name]).join("");
    const found = this.table(place).map(one => [key(one), this.known.get(this.key(one))?.decay]);
    const top = Math.log(1 + Math.max(0, ...found.map(([, x]) => x ?? 0)));
    const cells = found.map(([name, decay], k) => {
      const [x, y] = [60 + 68 * (k % 4), 34 + 44 * Math.floor(k / 4)], sigma = this.decays(decay) ? decay : 0;
      const strong = sigma ? 0.12 + 0.5 * Math.log(1 + sigma) / top : 0, here = name === key(place);
      return `<g data-cell="${name}"><rect x="${x}" y="${y}" width="64" height="40" rx="4" ` +
        `style="fill:var(--sos-region);fill-opacity:${round(10 * strong) / 10};stroke:var(--sos-${
          here ? "ink" : "line"});stroke-width:${here ? 2.5 : 1}"/>` +
        `<text x="${x + 32}" y="${y + 25}" text-anchor="middle" style="fill:var(--sos-ink)">${
          sigma                   ? clean(sigma)
            : decay === undefined ? "…"
                                  : "–"}</text></g>`;
    });
    const heads =
      rates.map((words, j) => `<text x="${92 + 68 * j}" y="26" text-anchor="middle">${words}</text>`)
        .concat(names.map((words, i) => `<text x="52" y="${59 + 44 * i}" text-anchor="end">${words}</text>`));
    this.find("choices").innerHTML = picture(214,
      "Decay that is found for each choice of angles (rows) and rates (columns)",
      `<text x="52" y="12" text-anchor="end">angles</text><text x="194" y="12" text-anchor="middle">rates</text>` +
        heads.join("") + cells.join(""));
  }

  plane({poles, means, limit, sigma}, ghost) {
    const w = this.size, x = [-0.55 * w, 0.12 * w], y = [-1.15 * w, 1.15 * w];
    this.poleMap("poles", {
      x,
      y,
      label: "Poles of the slowest plant and of the one in the middle",
      poles: poles[0],
      ghost: ghost?.poles[0],
      draw: plot => {
        if (sigma)
          plot.body += `<rect class="sos-region" x="${plot.l}" y="${plot.t}" width="${
            round(plot.X(Math.max(x[0], -sigma)) - plot.l)}" height="${plot.b - plot.t}"/>`;
        if (limit !== null)
          for (const mean of means.filter(at => at > x[0])) plot.rule("sos-target", [mean, mean], y);
        for (const pole of poles[1].filter(p => plot.has(p))) mark(plot, pole, "--sos-second", 1);
      }
    });
  }
}

define("sos-sensors", Sensors);
