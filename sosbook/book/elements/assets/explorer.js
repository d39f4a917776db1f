// Requirements that move freely: every position is a set of LMIs that the reader's own
// browser solves.
import {DesignElement, relax} from "./drawn.js";
import {rest} from "./judge.js";
import {announce, band, clean, define, drag, escape, number, printed, slider, withConjugates} from "./kit.js";
import * as python from "./program.js";
import {solverOf} from "./solver.js";

const STEPS = 200;                  // of a slider
const FURTHEST = 1e3, FINE = 5e-4;  // of a bound without a slider: how far it is relaxed, in which steps
const UNMOVED = ", which has no slider here";
const LAST = 1e3;  // further than any bound goes, by its logarithm
const PART = "The solutions have hardly a bound, or none: this is the centre of a bounded part.";

const bound = (label, symbol, unit, looser = 1, degrees = false) =>
  ({label, symbol, unit, looser, degrees, log: !degrees});
// The bounds that a page knows, as the package's vocabulary has them.
export const BOUNDS = {
  sigma: bound("Decay rate σ", "σ", " 1/s", -1),
  theta: bound("Half-angle θ", "θ", "°", 1, true),
  rho: bound("Disk radius ρ", "ρ", " 1/s"),
  gamma: bound("H∞ bound γ", "γ", ""),
  cost: bound("Bound of the cost", "J", ""),
  u_max: bound("Input bound u_max", "u_max", "")
};

// ------------------------------------------------------------------ values
const valueAt = ({min, max, log}, at) => {
  const value = log ? min * (max / min) ** (at / STEPS) : min + (max - min) * at / STEPS;
  return Number(value.toPrecision(3));
};
const placeOf = ({min, max, log}, value) => Math.max(0,
  Math.min(STEPS, STEPS * (log ? Math.log(value / min) / Math.log(max / min) : (value - min) / (max - min))));
const inRadians = ({degrees}, shown) => degrees ? shown * Math.PI / 180 : shown;
const textOf = ({symbol, unit}, shown) => `${symbol} = ${Number(shown.toPrecision(4))}${unit}`;

// Where a bound still holds, between a good end and a bad one, by halving; null if not even there.
async function edge(holds, good, bad, fine) {
  if (!await holds(good)) return null;
  if (await holds(bad)) return bad;
  while (Math.abs(good - bad) > fine) {
    const middle = (good + bad) / 2;
    if (await holds(middle)) good = middle;
    else bad = middle;
  }
  return good;
}

export class Explorer extends DesignElement {
  get buttons() {
    return [
      ["reset", "Reset"], ["link", "Link to this"], ["prove", "Prove it exactly"], ["python", "As Python"]
    ];
  }

  // ---------------------------------------------------------------- controls
  sliders() {
    const made = (s, k) =>
      ({id: `${this.name}-${k}`, key: s.key, label: s.label, value: placeOf(s, s.value)});
    return this.data.sliders.map((s, k) => this.control(k, slider({...made(s, k), max: STEPS, step: "any"})))
      .join("");
  }

  // A slider and what a subclass puts beside it.
  control(_k, slider) { return slider; }

  get solver() { return solverOf(this); }

  wire() {
    this.listen();
    this.inputs = [...this.view.querySelectorAll("input[type=range]")];
    this.values = this.data.sliders.map(s => s.value);
    this.answer = this.found = this.ghost = null;
    this.own ??= {};  // what a reader chose, by name
    this.read(this.linked());
    this.inputs.forEach(input => band(input, []));
    this.inputs.forEach((input, k) => {  // sliders of a plant before say nothing any more
      const on = (kind, act) => input.addEventListener(kind, event => {
        if (input === this.inputs[k]) act(event);
      });
      on("input", () => this.set(k, valueAt(this.data.sliders[k], Number(input.value))));
      on("keydown", event => this.key(event, k));
      on("pointerdown", () => {
        this.held = {value: this.values[k], own: {...this.own}};
        this.remember();
      });
      on("pointercancel", () => {  // a swipe that scrolls
        this.own = this.held.own;
        this.put(k, this.held.value);
        this.solve();
      });
    });
    drag(this.find("map"), ({handle}) => {
      this.remember();
      return Number(handle);
    }, (k, place) => this.pull(k, place));
    new IntersectionObserver(list => {
      if (this.seen || !list.at(-1).isIntersecting) return;
      this.seen = true;
      this.look();
    }).observe(this.view);
    this.solve();
  }

  // Arrows move by a hundredth of the way, which "step=any" wouldn't do.
  key(event, k) {
    const far =
      {ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10}[event.key];
    if (!far) return;
    event.preventDefault();
    const slider = this.data.sliders[k];
    const at = Math.max(0, Math.min(STEPS, placeOf(slider, this.values[k]) + 2 * far));
    this.remember();
    this.set(k, valueAt(slider, at));
  }

  put(k, value) {
    const {min, max} = this.data.sliders[k];
    this.values[k] = Math.max(min, Math.min(max, value));
    this.inputs[k].value = placeOf(this.data.sliders[k], this.values[k]);
  }

  set(k, value) {
    this.put(k, value);
    const {key} = this.data.sliders[k];
    this.own[key] = this.values[k];
    this.last = [key];
    this.solve();
  }

  // The design before a move stays as a ghost.
  remember() {
    if (this.found) this.ghost = {...this.found, response: this.shown};
  }

  press(what) {
    super.press(what);
    if (what === "prove") this.prove();
  }

  reset(to = {}) {
    this.remember();
    this.own = {...to};
    this.last = Object.keys(to);
    this.data.sliders.forEach((s, k) => this.put(k, to[s.key] ?? s.value));
    this.solve();
  }

  get address() { return this.named; }

  // The sliders' values by name, in the units shown.
  get named() { return Object.fromEntries(this.data.sliders.map(({key}, k) => [key, this.values[k]])); }
  get program() { return python.design(this.data, {...this.data.shownFixed, ...this.named}, rest); }

  read(linked) {
    this.data.sliders.forEach(({key}, k) => {
      if (isFinite(number(linked[key]))) this.put(k, number(linked[key]));
    });
  }

  // ------------------------------------------------------------ the requests
  get asked() { return this.askedAt(this.values); }

  askedAt(values, others = {}) {
    return {
      ...this.data.fixed,
      ...others,
      ...Object.fromEntries(this.data.sliders.map((s, k) => [s.key, inRadians(s, values[k])]))
    };
  }

  request(values = this.values, others = {}) {
    const asked = this.askedAt(values, others), {x0, mu, cost} = this.data;
    if (cost && asked.cost !== undefined) Object.assign(asked, cost);
    if (x0 && asked.u_max !== undefined) asked.x0 = x0;
    if (mu !== null) asked.mu = mu;
    return {...this.data.request, asked};
  }

  get reason() { return this.answer.reason ? escape(this.answer.reason) : undefined; }
  get texts() { return this.data.sliders.map((s, k) => textOf(s, this.values[k])); }

  async solve() {
    this.inputs.forEach((input, k) => announce(input, this.texts[k]));
    this.view.querySelectorAll(".sos-band").forEach(band => band.classList.add("sos-old"));
    this.settle();
    const {texts, digest} = this, {request} = this.data, values = [...this.values];
    const answer = await this.solver.ask(this.name, "move", this.request(values));
    if (!answer || request !== this.data.request) return;  // another plant by now
    this.answer = {...this.meant(answer), asked: this.askedAt(values), values, texts, digest};
    if (this.answer.status === "feasible") this.found = this.answer;
    this.edges = null;
    this.update();
    clearTimeout(this.idle);
    this.idle = setTimeout(() => this.look(), answer.status === "feasible" ? 250 : 60);
  }

  // What an answer of the solver means here.
  meant(answer) { return answer; }

  // How far each slider may go while the others stay, by halving: what the bands show,
  // once somebody can see them. Where there is no design, so for the bounds without a slider.
  async look() {
    clearTimeout(this.idle);
    if (!this.seen || !this.answer) return;
    const values = [...this.values], edges = [], {digest, answer} = this, offers = [];
    const failed = answer.status !== "feasible";
    const stale = () => digest !== this.digest || answer !== this.answer;
    const asks = async (there, others) => !stale() &&
      (await this.solver.ask(this.name, "probe", this.request(there, others)))?.status === "feasible";
    for (const [k, slider] of this.data.sliders.entries()) {
      const ends = slider.looser > 0 ? [STEPS, 0] : [0, STEPS];
      edges[k] = await edge(at => asks(values.with(k, valueAt(slider, at))), ...ends, 1.5);
      if (stale()) return;
      this.band(k, edges[k]);
    }
    for (const [key, from] of failed ? Object.entries(this.data.shownFixed) : []) {
      const {looser, degrees} = BOUNDS[key], far = degrees ? 90 / from : FURTHEST;
      const at = share => Number((from * far ** (looser * share)).toPrecision(3));
      const share = await edge(x => asks(values, {[key]: inRadians(BOUNDS[key], at(x))}), 1, 0, FINE);
      if (stale()) return;
      if (share !== null) offers.push({key, from, to: at(share), more: UNMOVED});
    }
    this.edges = edges;
    this.offers = offers;
    if (failed && answer.digest === digest) this.tell(answer.status, this.readout(this.design));
  }

  band(k, edge) {
    const share = edge / STEPS, {looser} = this.data.sliders[k];
    band(this.inputs[k], edge === null ? [[0, 1, false]] : [[0, share, looser < 0], [share, 1, looser > 0]]);
  }

  // All bounds that alone lead to a design, the nearest first; what the reader has just asked for last.
  advice() {
    const {edges, last = []} = this, {sliders} = this.data;
    if (!edges) return "Looking for what to relax …";
    const known = (edge, k) =>
      ({...sliders[k], from: this.values[k], to: valueAt(sliders[k], edge), more: ""});
    const moves = edges.flatMap((edge, k) => edge === null ? [] : [known(edge, k)]).concat(this.offers ?? []);
    const far = ({key, from, to}) => Math.abs(Math.log(to / from)) + (last.includes(key) ? LAST : 0);
    moves.sort((a, b) => far(a) - far(b));
    return moves.length ? relax(moves.map(({key, to, more}) => ({text: textOf(BOUNDS[key], to) + more})))
                        : "No single bound is enough: relax several.";
  }

  // --------------------------------------------------------------- the design
  /** @returns {any} */
  get design() {
    const {status, asked, texts, K, poles, margins, norm, peak, cost} = this.answer;
    if (status !== "feasible") return {status, asked, texts};
    const upper = poles.flat().filter(([, im]) => im >= 0).sort((p, q) => q[0] - p[0]);
    const least = Math.min(...Object.values(margins));
    const block = Object.keys(margins).find(name => margins[name] === least);
    return {status, asked, texts, K, poles: upper, margin: [block, least], norm, peak, cost};
  }

  update() {
    this.lit = undefined;
    const design = this.design, held = design.K ? design : null;
    this.find("map").innerHTML = this.map(design);
    this.find("step").innerHTML = this.step(held || {status: design.status, K: this.found?.K});
    this.find("step").classList.toggle("sos-stale", !held);
    if (held) this.shown = this.response;
    this.tell(design.status, this.readout(design), this.answer.digest);
  }

  // Ghosts of poles, and handles on the edges of the region.
  overPoles(plot) {
    const {status, asked} = this.answer, ghost = status === "feasible" ? this.ghost : this.found;
    for (const [re, im] of withConjugates((ghost?.poles || []).flat().filter(([, im]) => im >= 0))
           .filter(pole => plot.has(pole))) {
      plot.body += `<path class="sos-ghost" d="M${plot.X(re) - 4} ${plot.Y(im) - 4}l8 8m0 -8l-8 8"/>`;
    }
    for (const [k, [re, im]] of this.handles(asked).entries()) {
      if (plot.has([re, im]))
        plot.body +=
          `<circle class="sos-handle" data-handle="${k}" cx="${plot.X(re)}" cy="${plot.Y(im)}" r="7"/>`;
    }
  }

  handles({sigma, theta, rho}) {
    const far = (rho ?? this.data.window[2]) * 0.7;
    const ends = {sigma: [-sigma, 0], theta: [-far * Math.cos(theta), far * Math.sin(theta)], rho: [-rho, 0]};
    return this.data.sliders.map(({key}) => ends[key] ?? []);
  }

  pull(k, place) {
    const [re, im] = this.poleAxes().at(place);
    const shown = this.data.sliders[k].key === "theta" ? Math.atan2(Math.abs(im), -re) * 180 / Math.PI : -re;
    this.set(k, Number(shown.toPrecision(3)));
  }

  // The step response before the move, within the present axes.
  overResponse(plot) {
    if (this.answer.status !== "feasible") return;
    for (const rows of this.ghost?.response ?? []) {
      rows[0].forEach((_, i) => {
        const points =
          rows.map((row, k) => [k * this.data.horizon / (rows.length - 1), row[i]]).filter(p => plot.has(p));
        plot.body += `<path class="sos-ghost" d="${plot.path(points)}"/>`;
      });
    }
  }

  // Long numbers, for a design and for the lack of one.
  states() {
    const {sliders, shownFixed, shape: [n, m, a], vertices, x0, cost} = this.data, N = 2 * n + a;
    const {asked} = this, number = 0.00088, place = 74;
    const at = this.elsewhere({
      values: sliders.map(s => valueAt(s, place)),
      edges: sliders.map(() => place),
      offers: Object.entries(shownFixed).map(([key, from]) => ({key, from, to: 88.8, more: UNMOVED})),
      answer: {ms: 888, bounded: !(asked.gamma || asked.u_max || asked.cost)}
    });
    const poles =
      vertices.flatMap(() => [...Array(N >> 1).fill([-88.8, 88.8]), ...Array(N % 2).fill([-88.8, 0])]);
    const K = Array.from({length: m}, () => Array(N).fill(-0.08888));
    const margin = ["half-plane 8,8", number], norm = this.data.request.vertices[0].F ? number : null;
    const truth = {norm, peak: x0 && number, cost: cost && asked.cost ? number : null};
    const states = [{status: "feasible", K, poles, margin, ...truth}, {status: "infeasible"}];
    return states.map(state => at.readout({...state, asked}));
  }

  readout(design) {
    const extra = design.status === "feasible"
      ? `<p class="sos-soft">Solved ${
          this.answer.by ? `by ${escape(this.answer.by)}`
                         : "in your browser"} in ${clean(this.answer.ms, 2)} ms.` +
        `${this.answer.bounded ? ` ${PART}` : ""}</p>`
      : "";
    return super.readout(design) + extra;
  }

  // ----------------------------------------------------------------- the proof
  async prove() {
    const {digest, texts, data: {also}} = this;
    this.reply("<p>Computing with whole numbers …</p>");
    const answer = await this.solver.ask(this.name, "prove", this.request());
    if (this.find("more").dataset.digest !== digest) return;  // something else stands there by now
    if (!answer?.proof?.proven) {
      this.reply(`<p>Not proven. ${escape(answer?.reason || "There is no design here.")}</p>`, digest);
      return;
    }
    const {claims, text, blocks, digits} = answer.proof;
    const address = URL.createObjectURL(new Blob([text], {type: "application/json"}));
    const how = answer.status === "feasible"
      ? ` for the gain rounded to ${digits} digits: ${blocks.length} blocks are positive definite`
      : `: rational multipliers of ${blocks.length} blocks exclude every solution`;
    this.reply(`<p><span class="sos-status">Proven</span> for ${escape(printed([...texts,
      ...also].join(", ")))} in exact arithmetic${how}. So</p><ul>${
                 claims.map(c => `<li>${escape(c)}</li>`).join("")}</ul>` +
        `<p><a href="${
          address}" download="proof.json">Download the proof</a>; <code>python -m sosbook verify proof.json</code> checks it again.</p>`,
      digest);
  }
}

define("sos-explorer", Explorer);
