// A wish whose numbers move freely: every sentence is a set of LMIs that the reader's own browser
// solves and proves.
import {DesignElement} from "./drawn.js";
import {judged, rest, worst} from "./judge.js";
import {capital, clean, define, drag, escape, QUIET, withConjugates} from "./kit.js";
import {apply} from "./linalg.js";
import * as python from "./program.js";
import {valueOf as numberOf} from "./sentence.js";
import {solverOf} from "./solver.js";
import {keyOf, listen, markup, speak, typed} from "./spoken.js";
import {clauses, verdict} from "./verdict.js";
import {boundOf, BOUNDS, sayable, valueOf} from "./wishes.js";

const PAUSE = 400;                  // ms without a move, before what was found is proven
const FURTHEST = 1e3, FINE = 0.01;  // how far a bound is relaxed, by a factor, and in which steps
const OFFERS = 3, TRIES = 4;        // bounds that are offered; numbers of few digits that are tried
const LAST = 1e3;                   // further than any bound goes, by its logarithm
const PART = "The solutions have hardly a bound, or none: this is the centre of a bounded part.";

// Where a bound still holds, between a good end and a bad one, by halving; null if not even there.
async function edge(holds, good, bad, fine) {
  if (!await holds(good)) return null;
  while (Math.abs(good - bad) > fine) {
    const middle = (good + bad) / 2;
    if (await holds(middle)) good = middle;
    else bad = middle;
  }
  return good;
}

// The bounds that an offer sets.
const several = ({key, to}) => to === Object(to) ? to : {[key]: to};

// A bound of few digits in the sentence's unit, but for its last bit, is that.
const said = (key, value) => {
  const near = sayable(key, value, 3);
  return Math.abs(near / value - 1) < 1e-11 ? near : value;
};

export class Wish extends DesignElement {
  /** @type {any} */
  middles;  // of the rulers of its numbers

  get buttons() {
    return [
      ["reset", "Reset"], ["link", "Link to this"], ["prove", "Prove it exactly"], ["python", "As Python"]
    ];
  }
  markup() { return markup(this.name) + super.markup(); }
  // What stands below sentence and ruler.
  body() { return super.markup(); }

  get solver() { return solverOf(this); }
  get prover() { return solverOf(this, true); }

  wire() {
    this.attend();
    this.begin();
    this.recall();
    this.read(this.linked());
    this.solve();
  }

  // What is heard once, whatever the plant.
  attend() {
    Object.assign(this, {own: {}, wrong: {}, bounds: {}, middles: {}, last: []});
    this.listen();
    listen(this);
    new IntersectionObserver(list => {
      if (!this.seen && list.at(-1).isIntersecting) this.see();
    }).observe(this.view);
  }
  see() {
    this.seen = true;
    this.wait();
  }
  // Whether all is said that this page finds for what is asked.
  get ended() {
    const {answer, offers} = this;
    return answer?.digest === this.digest && Boolean(answer.proof ?? offers ?? answer.status === "undecided");
  }
  // The still of the first wish knows its proof before this page does.
  recall() {
    const word = this.absent?.querySelector(".sos-say em")?.textContent.slice(0, -1);
    this.baked = word && {word, digest: this.digest};
  }

  // A plant, and its bounds as they are at first.
  begin(middles = {}) {
    this.bounds = this.starts();
    Object.assign(this, {answer: null, found: null, ghost: null, offers: null, middles});
    drag(this.find("map"), ({handle}) => {
      this.remember();
      return handle;
    }, (key, place) => this.pull(key, place));
  }

  starts() {
    for (const one of this.data.bounds) one.value = said(one.key, one.value);
    return Object.fromEntries(this.data.bounds.map(({key, value}) => [key, value]));
  }

  moves(key) { return this.data.bounds.some(one => one.key === key && one.moves); }

  // Bounds by name: they are a reader's own from now on.
  set(bounds) {
    Object.assign(this.bounds, bounds);
    Object.assign(this.own, bounds);
    this.last = Object.keys(bounds);
    this.wrong = {};
    this.solve();
  }
  // A reader types a bound.
  type(key, value) {
    if (value === this.bounds[key] && key in this.own) return;
    this.set({[key]: value});
  }

  // What a text means as a number of the sentence, and what is asked by it then.
  meaning(slot, text, clause) {
    const key = keyOf(slot), x = Number.isNaN(typed(text)) ? NaN : numberOf(clause, text);
    if (key in this.bounds) return valueOf(text, clause, key);
    return x > 0 || slot.includes("/") ? x : NaN;
  }
  ask(slot, x, left) {
    const key = keyOf(slot);
    if (key in this.bounds) this.type(key, x);
    else if (left) this.fit(slot, x);
    else return false;
  }
  fit(_slot, _x) {}

  // The design before a move stays as a ghost.
  remember() {
    if (this.found) this.ghost = {...this.found, response: this.shown};
  }

  press(what) {
    const [, key] = /^offer:(.*)/.exec(what) ?? [];
    if (key) this.set(several(this.offers.find(offer => offer.key === key)));
    super.press(what);
    if (what === "prove") this.prove();
  }

  reset(to = {}) {
    this.remember();
    this.own = {};
    this.data.bounds.forEach(({key, value}) => { this.bounds[key] = value; });
    this.set(to);
  }

  get named() { return {...this.bounds}; }
  get address() { return {...this.named, ...this.wrong}; }
  get asks() { return python.asks(this.data, this.named); }
  // The words of what is asked, made once.
  get sentences() {
    const {asks} = this, key = JSON.stringify(asks);
    if (key !== this.said?.key) this.said = {key, words: python.sentences(asks, this.data, rest)};
    return this.said.words;
  }
  get pieces() { return this.sentences.pieces; }
  get sentence() { return String(this.sentences); }
  get program() { return python.design(this.data, this.named, rest); }

  read(linked) {
    for (const key in this.bounds) {
      const value = boundOf(key, linked[key]);
      if (value) this.bounds[key] = value;
    }
  }

  // ------------------------------------------------------------ the requests
  get asked() { return this.askedAt(this.bounds); }
  /** @param {any} bounds */
  askedAt({theta, ...others}) {
    return theta === undefined ? others : {...others, theta: theta * Math.PI / 180};
  }

  request(bounds = this.bounds) {
    const asked = this.askedAt(bounds), {x0, mu, cost} = this.data;
    if (cost && asked.cost !== undefined) Object.assign(asked, cost);
    if (x0 && asked.u_max !== undefined) asked.x0 = x0;
    if (mu !== null) asked.mu = mu;
    return {...this.data.request, asked};
  }

  async solve() {
    clearTimeout(this.idle);
    this.offers = null;
    this.settle();
    const {digest, asked} = this, {request} = this.data;
    const answer = await this.solver.ask(this.name, "move", this.request());
    if (!answer || request !== this.data.request) return;  // another plant by now
    this.accept({...answer, asked, digest});
  }
  accept(answer) {
    this.answer = answer;
    if (answer.status === "feasible") this.found = answer;
    this.judge();
    this.update();
    this.wait();
  }

  // ------------------------------------------------------------ the verdict
  // The true numbers of the loop, and what the clauses are worth: the weakest is the verdict.
  judge() {
    const {answer, data: {r, goal, clock, law}} = this, request = {...this.data.request, law}, {U} = request;
    this.truth = null;
    if (answer.status !== "feasible") return;
    this.truth = judged(request, answer.K, goal ?? (U.length ? apply(U, r) : r), r);
    answer.clauses = clauses({...request, asked: answer.asked}, clock, answer);
  }
  worth({status, digest, clauses = [], proof}) {
    const found = verdict(status, clauses, proof?.proven), {baked} = this;
    return status === "feasible" && !proof && baked?.digest === digest ? {...found, word: baked.word} : found;
  }
  get verdict() {
    const {answer, baked, digest} = this;
    if (answer?.digest === digest) return this.worth(answer);
    return {word: baked?.digest === digest ? baked.word : "…", why: []};
  }
  get word() { return this.verdict.word; }
  get ending() { return [": ", `${this.word}.`]; }
  get kind() {
    return this.word.includes("proven") ? "feasible" : {"no design": "infeasible"}[this.word] ?? this.word;
  }

  settle() {
    super.settle();
    if (this.data.request && this.bounds) speak(this);
  }

  // Once nothing has moved for a while: an exact proof, or what to relax.
  wait() {
    clearTimeout(this.idle);
    if (this.seen && this.answer)
      this.idle = setTimeout(() => this.answer.status === "feasible" ? this.settled() : this.look(), PAUSE);
  }
  async settled() {
    const {answer, digest} = this;
    if (answer.proof || answer.digest !== digest) return;
    const found = await this.prover.ask(this.name, "prove", this.request());
    if (answer !== this.answer || digest !== this.digest) return;
    answer.proof = found?.proof ?? {proven: false, reason: found?.reason};
    this.say();
  }

  // How far each bound must be relaxed alone, by halving, whether it moves here or not. What is
  // offered has few digits, and was solved as it stands.
  async look() {
    const {answer, digest} = this, bounds = {...this.bounds}, offers = [];
    if (answer.status !== "infeasible" || answer.digest !== digest) return;
    const stale = () => digest !== this.digest || answer !== this.answer;
    const holds = async there => !stale() &&
      (await this.solver.ask(this.name, "probe", this.request({...bounds, ...there})))?.status === "feasible";
    for (const [key, from] of Object.entries(bounds)) {
      const {looser, most} = BOUNDS[key],
                     far = Math.log(Math.min(FURTHEST, looser > 0 ? most / from : FURTHEST));
      const at = x => from * Math.exp(looser * x);
      const x = await edge(x => holds({[key]: at(x)}), far, 0, FINE);
      for (let k = 0; k < TRIES && x !== null; k++) {
        const to = Math.min(most, sayable(key, at(x + k * FINE / 2), 3));
        if (!await holds({[key]: to})) continue;
        offers.push({key, from, to});
        break;
      }
      if (stale()) return;
    }
    const {last} = this,
          way = ({key, from, to}) => Math.abs(Math.log(to / from)) + (last.includes(key) ? LAST : 0);
    this.offers = offers.sort((a, b) => way(a) - way(b));
    this.say();
  }

  // The bounds that alone lead to a design, the nearest first; what the reader has just asked for
  // comes last.
  advice() {
    const {offers} = this;
    if (!offers) return "Looking for what to relax …";
    if (!offers.length) return "No single bound is enough: relax several.";
    const words = offer => {
      const bounds = several(offer), asked = python.asks(this.data, {...this.bounds, ...bounds});
      const said = [...python.sentences(asked, this.data, rest).clauses.values()].filter(
        parts => parts.some(({slot}) => slot && keyOf(slot) in bounds));
      return said.map(parts => parts.map(({text, shown}) => text ?? shown).join("")).join(", ");
    };
    return `Would do: ${
      offers.slice(0, OFFERS)
        .map(offer => `<button type="button" class="sos-button" data-do="offer:${offer.key}" ${QUIET}>${
               escape(words(offer))}</button>`)
        .join(" or ")}`;
  }

  // --------------------------------------------------------------- the design
  /** @returns {any} */
  get design() {
    const {status, asked, K, poles, margins = {}, norm, peak, cost} = this.answer;
    if (status !== "feasible") return {status, asked};
    const upper = poles.flat().filter(([, im]) => im >= 0).sort((p, q) => q[0] - p[0]);
    const least = Math.min(...Object.values(margins));
    const block = Object.keys(margins).find(name => margins[name] === least);
    return {status, asked, K, poles: upper, margin: block && [block, least], norm, peak, cost};
  }

  update() {
    this.lit = undefined;
    const design = this.design, held = design.K ? design : null;
    this.find("map").innerHTML = this.map(design);
    this.find("step").innerHTML = this.step(held || {status: design.status, K: this.found?.K});
    this.find("step").classList.toggle("sos-stale", !held);
    if (held) this.shown = this.response;
    this.say();
  }
  say() { this.tell(this.answer.status, this.readout(this.design), this.answer.digest); }

  // Ghosts of poles, and handles on the edges of the region.
  overPoles(plot) {
    const {status, asked} = this.answer, ghost = status === "feasible" ? this.ghost : this.found;
    for (const [re, im] of withConjugates((ghost?.poles || []).flat().filter(([, im]) => im >= 0))
           .filter(pole => plot.has(pole))) {
      plot.body += `<path class="sos-ghost" d="M${plot.X(re) - 4} ${plot.Y(im) - 4}l8 8m0 -8l-8 8"/>`;
    }
    for (const [key, [re, im]] of Object.entries(this.handles(asked))) {
      if (this.moves(key) && plot.has([re, im]))
        plot.body +=
          `<circle class="sos-handle" data-handle="${key}" cx="${plot.X(re)}" cy="${plot.Y(im)}" r="7"/>`;
    }
  }

  handles({sigma, theta, rho}) {
    const far = (rho ?? this.data.window[2]) * 0.7;
    return {sigma: [-sigma, 0], theta: [-far * Math.cos(theta), far * Math.sin(theta)], rho: [-rho, 0]};
  }

  pull(key, place) {
    const [re, im] = this.poleAxes().at(place);
    const shown = key === "theta" ? Math.atan2(Math.abs(im), -re) * 180 / Math.PI : -re;
    if (shown > 0 && shown <= BOUNDS[key].most) this.set({[key]: sayable(key, shown, 3)});
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
    const {bounds, shape: [n, m, a], vertices, x0, cost} = this.data, N = 2 * n + a;
    const {asked} = this, number = 0.00088, offers = bounds.map(({key}) => ({key, from: 1, to: 88.8}));
    const at = this.elsewhere({
      offers,
      truth: {settled: 88.8, overshoot: 0.88, input: 88.8, load: 88.8, rest: 88.8, peak: 88.8},
      answer:
        {ms: 888, bounded: !(asked.gamma || asked.u_max || asked.cost), digest: this.digest, clauses: []}
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
    const {status, asked} = design, {reason, by, ms, bounded, proof, gains} = this.answer;
    const {word, why} = this.worth(this.answer);
    const head = words => `<p><span class="sos-status">${capital(word)}</span>: ${words}</p>`;
    if (status === "undecided")
      return head(escape(reason ?? "neither a design nor a proof that there is none was found.") +
        (gains === null ? ` ${this.advice()}` : ""));
    if (status === "infeasible") {
      const empty = asked.rho <= asked.sigma;
      return head(`${escape(reason ?? (empty ? "The region is empty." : "These LMIs have no solution."))} ${
        this.advice()}`);
    }
    const how = proof?.proven ? `in exact arithmetic, for the gain rounded to ${proof.digits} digits.`
      : word.includes("proven") ? "in exact arithmetic, when this page was made."
      : gains                   ? "the loop keeps this at all corners, in floats."
                                : "floats solve the LMIs with this gain.";
    const solved = `Solved ${by ? `by ${escape(by)}` : "in your browser"} in ${clean(ms, 2)} ms.`;
    return head([how, ...why].map(escape).join(" ")) +
      (this.truth ? `<p>${worst(this.truth, this.data.request)}</p>` : "") + this.gains(design) +
      `<p class="sos-soft">${solved}${bounded ? ` ${PART}` : ""}</p>`;
  }

  // ----------------------------------------------------------------- the proof
  async prove() {
    const {answer, digest, sentence} = this;
    this.reply("<p>Computing with whole numbers …</p>");
    const known = answer?.digest === digest && answer.proof?.proven;
    const asked = known ? answer : await this.solver.ask(this.name, "prove", this.request());
    if (this.find("more").dataset.digest !== digest) return;  // something else stands there by now
    if (!asked?.proof?.proven) {
      this.reply(`<p>Not proven. ${escape(asked?.reason || "There is no design here.")}</p>`, digest);
      return;
    }
    const {claims, text, blocks, digits} = asked.proof;
    const address = URL.createObjectURL(new Blob([text], {type: "application/json"}));
    const how = asked.status === "feasible"
      ? `for the gain ${digits ? `rounded to ${digits} digits` : "as it is"}: ${
          blocks.length} blocks are positive definite`
      : `that there is none: rational multipliers of ${blocks.length} blocks exclude every solution`;
    this.reply(`<p>${escape(sentence)} <span class="sos-status">Proven</span> in exact arithmetic, ${
                 how}. So</p><ul>${claims.map(c => `<li>${escape(c)}</li>`).join("")}</ul>` +
        `<p><a href="${
          address}" download="proof.json">Download the proof</a>; <code>python -m sosbook verify proof.json</code> checks it again.</p>`,
      digest);
  }
}

define("sos-wish", Wish);
