import {verdictOf} from "./drawn.js";
import {delayedRun} from "./history.js";
import {announce, buttons, clean, controls, define, escape, gainRows, gains, inPairs, number, PageElement, panel, panels, places, READOUT, select, slider, steady, withConjugates} from "./kit.js";
import {apply} from "./linalg.js";
import {mark, Plot, S_PLANE} from "./plot.js";
import {asks, list, program} from "./program.js";

const COLOURS = ["--sos-first", "--sos-third", "--sos-second"];
const SIGNS = ["○", "+", "✕"], SHAPES = [1, 3, 0], DELAYS = ["shortest", "nominal", "longest"];

// The delay as a function of time, as `signal_of` has it.
function delayOf(kind, tau, mu, [period, dwell, random]) {
  const low = tau - mu, hold = t => Math.floor(t / (dwell * tau) + 1e-9);
  return [
    () => tau,
    t => tau + mu * Math.sin(2 * Math.PI * t / (period * tau)),
    t => t - 2 * mu * Math.floor((t - low) / (2 * mu) + 1e-9),
    t => tau + (hold(t) % 2 ? mu : -mu),
    t => low + 2 * mu * random[hold(t)],
  ][mu ? kind : 0];
}

// x' = A x + s + B u(t - d(t)) from rest, with u = K x - K_P r from t = 0 on.
function simulate({A, B, s}, K, r, delay, horizon, steps) {
  const level = apply(K.map(row => row.slice(0, r.length)), r);
  const input = (x, on = true) => apply(K, x).map((u, i) => on ? u - level[i] : 0);
  const rate = (x, old, on) => {
    const push = apply(B, input(old, on));
    return apply(A, x).map((a, i) => a + push[i] + s[i]);
  };
  const {t, d, x, old} = delayedRun(rate, A.map(() => 0), delay, horizon, steps);
  const applied = old.map((y, k) => input(y, t[k] - d[k] >= -1e-9));
  return {t, states: x, asked: x.map(y => input(y)), applied};
}

const sign = (colour, text) => `<span class="sos-mark" style="color:var(${colour})">${text}</span>`;

// Sliders over designs that were solved beforehand.
class DelayAtlas extends PageElement {
  sliders() {
    return this.data.sliders
      .map(({key, label, values}, k) =>
             slider({id: `${this.name}-${k}`, key, label, max: values.length - 1, value: this.data.start[k]}))
      .join("");
  }

  markup() {
    const roots = DELAYS.map((name, k) => sign(COLOURS[k], `${SIGNS[k]} ${name}`)).join(", ");
    const words = {label: "How the delay varies", names: this.data.kinds};
    return controls(
             "Requirements", this.sliders() + select({id: `${this.name}-kind`, key: "kind", ...words})) +
      panels(panel("map", `Rightmost roots for the constant delays: ${roots}. Dashed: Re s = −δ.`) +
        panel("step", escape(this.data.caption)) +
        panel("input",
          `The control signal: ${sign("--sos-first", "┄ as asked")}, ${
            sign("--sos-second", "— as it arrives")}.`) +
        READOUT) +
      this.note + buttons([["reset", "Reset"], ["link", "Link to this"], ["python", "As Python"]]);
  }

  // Why there is a grid.
  get note() {
    return `<p class="sos-soft">Solved beforehand at ${this.data.designs.length} positions, to which the ` +
      `sliders snap: the page's own solver doesn't know the LMIs of a delay.</p>`;
  }

  wire() {
    const kind = this.view.querySelector("select");
    kind.addEventListener("change", () => {
      this.kind = Number(kind.value);
      this.update();
    });
    this.inputs = [...this.view.querySelectorAll("input[type=range]")];
    this.inputs.forEach((input, k) => {
      input.addEventListener("input", () => this.move(this.place.with(k, Number(input.value))));
      steady(input);
    });
    this.reset(this.linked());
  }

  move(place) {
    this.place = [...place];
    this.inputs.forEach((input, k) => { input.value = place[k]; });
    this.update();
  }

  reset(to = {}) {
    const kind = number(to.kind);
    this.kind = this.view.querySelector("select").value = kind in this.data.kinds ? kind : 0;
    this.move(this.data.sliders.map(({key, values}, k) => {
      const at = values.indexOf(number(to[key]));
      return at < 0 ? this.data.start[k] : at;
    }));
  }

  index(place) { return place.reduce((sum, at, k) => sum * this.data.sliders[k].values.length + at, 0); }

  // 0 is infeasible, 1 undecided, everything else a design.
  stored(place = this.place) { return this.data.designs[this.index(place)]; }

  get asked() {
    return Object.fromEntries(this.data.sliders.map(({key, values}, k) => [key, values[this.place[k]]]));
  }

  get texts() { return this.data.sliders.map(({texts}, k) => texts[this.place[k]]); }

  states() {
    const at = this.elsewhere({place: null}), {sliders} = this.data,
          all = sliders.reduce(
            (places, {values}) => places.flatMap(place => values.map((_, k) => [...place, k])), [[]]);
    return all.map(place => {
      at.place = place;
      return at.readout(at.design);
    });
  }

  get address() { return {...this.asked, kind: this.kind}; }

  get program() {
    const {tau, ratio, delta, alpha = this.data.alpha} = this.asked, {request} = this.data;
    return program(asks({request}, {}).plant, "design_delay_pid", [
      ["U", list(request.U)], ["tau", tau], ["mu", Number((ratio * tau).toPrecision(12))], ["delta", delta],
      ["alpha", alpha]
    ]);
  }

  /** @returns {any} */
  get design() {
    const stored = this.stored(), asked = {...this.asked, mu: this.asked.tau * this.asked.ratio};
    if (typeof stored === "number") return {status: ["infeasible", "undecided"][stored], asked};
    const [gain, [block, margin], [rate, at], roots] = stored;
    const K = gainRows(gain, this.data.shape), least = [this.data.blocks[block], margin];
    return {status: "feasible", asked, rate, at, K, margin: least, roots: roots.map(inPairs)};
  }

  update() {
    const design = this.design, good = place => typeof this.stored(place) !== "number";
    this.response = this.answer(design);
    this.inputs.forEach((input, k) => {
      announce(input, this.texts[k]);
      places(input, this.data.sliders[k].values.map((_, at) => good(this.place.with(k, at))));
    });
    this.find("map").innerHTML = this.map(design);
    this.find("step").innerHTML = this.step();
    this.find("input").innerHTML = this.input();
    this.tell(design.status, this.readout(design));
  }

  answer({K, asked}) {
    if (!K) return null;
    const {vertices: [plant], r, horizon, U, varying, steps} = this.data;
    const delay = delayOf(this.kind, asked.tau, asked.mu, varying);
    const run = simulate(plant, K, r, delay, horizon, steps);
    const z = run.states.map(x => apply(U, x.slice(0, r.length)));
    return {...run, z};
  }

  /** @param {any} design */
  map({status, asked, roots}) {
    const [left, right, height] = this.data.window;
    /** @type {[number, number]} */
    const tall = [-height, height];
    const plot = new Plot({x: [left, right], y: tall, labels: S_PLANE});
    plot.rule("sos-axis", [0, 0], tall);
    plot.rule(`sos-bound${roots ? "" : " sos-empty"}`, [-asked.delta, -asked.delta], tall);
    (roots ?? []).forEach((row, k) => {
      for (const root of withConjugates(row).filter(root => plot.has(root)))
        mark(plot, root, COLOURS[k], SHAPES[k]);
    });
    if (!roots) plot.absent(status, 150);
    return plot.svg(roots
        ? `Root map: ${
            DELAYS
              .map((name, k) =>
                     `for the ${name} delay the rightmost root has real part ${clean(roots[k][0][0])}`)
              .join(", ")}.`
        : `Root map: empty, because no design is known (${status}).`);
  }

  // Lines over time, thinned.
  chart(lines, ylabel, label, limits, target) {
    const {horizon, steps, points} = this.data;
    const all = lines.flatMap(line => line.values).concat(limits);
    const low = Math.min(...all), high = Math.max(...all), room = 0.05 * (high - low);
    const plot = new Plot({x: [0, horizon], y: [low - room, high + room], labels: ["time t (s)", ylabel]});
    if (target !== undefined) plot.rule("sos-target", [0, horizon], [target, target]);
    for (const {values, colour, dash} of this.response ? lines : []) {
      plot.line(values.map((v, k) => [this.response.t[k], v]).filter((_, k) => k % (steps / points) === 0),
        colour, dash);
    }
    if (!this.response) plot.absent(this.design.status, 150);
    return plot.svg(label);
  }

  step() {
    const z = this.response ? this.response.z : [], dashes = ["", "7 4", "2 3"];
    const lines = this.data.U.map(
      (_, i) => ({values: z.map(row => row[i]), colour: COLOURS[i % 3], dash: dashes[i % 3]}));
    const words =
      lines.map(line => `peaks at ${clean(Math.max(...line.values))}, ends at ${clean(line.values.at(-1))}`);
    return this.chart(lines, this.data.output,
      this.response ? `Response over ${clean(this.data.horizon)} seconds: ${words.join("; ")}.`
                    : "Response: none, for there is no design.",
      [-0.1, 1.2], 1);
  }

  input() {
    const {asked, applied} = this.response || {asked: [], applied: []};
    const lines = Array
                    .from({length: this.data.shape[1]},
                      (_, i) => [{values: asked.map(u => u[i]), colour: "--sos-first", dash: "3 3"},
                        {values: applied.map(u => u[i]), colour: "--sos-second"}])
                    .flat();
    const peak = Math.max(...applied.flat().map(Math.abs));
    return this.chart(lines, "control signal u",
      this.response ? `Control signal, as asked and as it arrives: at most ${clean(peak)} in size.`
                    : "Control signal: none, for there is no design.",
      asked.length ? [] : [-1, 1]);
  }

  // The nearest move of each single slider to a design, the shortest first.
  moves() {
    return this.data.sliders
      .flatMap((slider, k) => {
        const near = slider.values.map((_, at) => at)
                       .sort((p, q) => Math.abs(p - this.place[k]) - Math.abs(q - this.place[k]));
        const at =
          near.find(i => typeof this.stored(this.place.map((old, j) => j === k ? i : old)) !== "number");
        return at === undefined ? [] : [{far: Math.abs(at - this.place[k]), text: slider.texts[at]}];
      })
      .sort((p, q) => p.far - q.far);
  }

  advice() {
    const moves = this.moves().map(move => move.text);
    return moves.length
      ? `${moves.length > 1 ? "Each of these moves" : "This move"} leads to a design: ${moves.join("; or ")}.`
      : "No move of a single slider leads to a design.";
  }

  readout(design) {
    const {tau, mu, delta} = design.asked, span = `[${clean(tau - mu)}, ${clean(tau + mu)}] s`;
    const {texts, data: {also}} = this;
    const verdict = verdictOf(design.status, [...texts, ...also], `: the delay stays in ${span}`);
    if (design.status !== "feasible") {
      return verdict +
        `<p>${
          design.status === "infeasible"
            ? "No certificate: the corrected LMI has no solution, by exact multipliers."
            : "No certificate was found, nor a proof that there is none."} ${escape(this.advice())}</p>`;
    }
    const [block, margin] = design.margin;
    return verdict + gains(design.K, this.data.shape, 4) +
      `<p>Promised rate, however the delay varies: ${clean(delta)} s⁻¹. ` +
      `True slowest rate over the constant delays: ${clean(design.rate)} s⁻¹, at ${clean(design.at)} s.</p>` +
      `<p>Smallest margin: ${clean(margin, 2)} (block: ${escape(block)}).</p>`;
  }
}

define("sos-delay", DelayAtlas);
