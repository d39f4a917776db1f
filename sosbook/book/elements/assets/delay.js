import {delayedRun} from "./history.js";
import {capital, clean, define, escape, gainRows, gains, inPairs, withConjugates} from "./kit.js";
import {apply, dot, mul} from "./linalg.js";
import {Mover, range} from "./mover.js";
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
  const level = apply(K.map(row => row.slice(0, r.length)), r), BK = mul(B, K), still = apply(B, level);
  const input = (x, on = true) => apply(K, x).map((u, i) => on ? u - level[i] : 0);
  const rate = (x, old, on) => A.map((row, i) => dot(row, x) + s[i] + (on ? dot(BK[i], old) - still[i] : 0));
  const {t, d, x, old} = delayedRun(rate, A.map(() => 0), delay, horizon, steps);
  const applied = old.map((y, k) => input(y, t[k] - d[k] >= -1e-9));
  return {t, states: x, asked: x.map(y => input(y)), applied};
}

const sign = (colour, text) => `<span class="sos-mark" style="color:var(${colour})">${text}</span>`;

// Designs that were solved beforehand, on a grid.
class DelayAtlas extends Mover {
  get controls() {
    const {sliders, start, kinds} = this.data;
    return [
      ...sliders.map((one, k) => ({...one, start: one.values[start[k]]})),
      {key: "kind", label: "How the delay varies", names: kinds, start: 0}
    ];
  }
  get means() { return "a design is known"; }
  probe(place) { return typeof this.stored(place) !== "number"; }

  markup() {
    this.says =
      `A delay of τ = {tau} s that varies by {ratio} of itself (drawn: {kind}) leaves a decay of δ = {delta} s⁻¹${
        this.control("alpha") ? ", with α = {alpha} s" : ""}.`;
    const roots = DELAYS.map((name, k) => sign(COLOURS[k], `${SIGNS[k]} ${name}`)).join(", ");
    this.figures = {
      map: `Rightmost roots for the constant delays: ${roots}. Dashed: Re s = −δ.`,
      step: escape(this.data.caption),
      input: `The control signal: ${sign("--sos-first", "┄ as asked")}, ${
        sign("--sos-second", "— as it arrives")}.`
    };
    return `${super.markup()}<p class="sos-soft">Solved beforehand at ${
      this.data.designs
        .length} positions, to which the numbers snap: the page's own solver doesn't know the LMIs of a delay.</p>`;
  }
  get buttons() { return [...super.buttons, ["python", "As Python"]]; }

  // 0 is infeasible, 1 undecided, everything else a design.
  stored(place) {
    return this.data.designs[this.data.sliders.reduce(
      (sum, {key, values}) => sum * values.length + values.indexOf(place[key]), 0)];
  }

  get program() {
    const {tau, ratio, delta, alpha = this.data.alpha} = this.stands, {request} = this.data;
    return program(asks({request}, {}).plant, "design_delay_pid", [
      ["U", list(request.U)], ["tau", tau], ["mu", Number((ratio * tau).toPrecision(12))], ["delta", delta],
      ["alpha", alpha]
    ]);
  }

  compute(place) {
    const stored = this.stored(place), asked = {...place, mu: place.tau * place.ratio};
    if (typeof stored === "number") return {status: ["infeasible", "undecided"][stored], asked};
    const [gain, [block, margin], [rate, at], roots] = stored;
    const K = gainRows(gain, this.data.shape), least = [this.data.blocks[block], margin];
    return {status: "feasible", asked, rate, at, K, margin: least, roots: roots.map(inPairs)};
  }

  show(design) {
    this.response = this.answer(design);
    this.find("map").innerHTML = this.map(design);
    this.charts(design);
    this.tell(design.status, ...this.told(design));
  }
  said() { return this.places([{}]).map(place => this.told(this.compute(place))); }

  // All places of the grid.
  places(list) {
    for (const {key, values} of this.data.sliders)
      list = list.flatMap(place => values.map(x => ({...place, [key]: x})));
    return list;
  }

  answer({K, asked}) {
    if (!K) return null;
    const {vertices: [plant], r, horizon, U, varying, steps} = this.data;
    const delay = delayOf(asked.kind, asked.tau, asked.mu, varying);
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

  // What is integrated, and the input, over time, thinned.
  charts({status}) {
    const {horizon, steps, points, output, shape: [, m], U} = this.data, {response} = this;
    const {t = [], z = [], asked = [], applied = []} = response ?? {};
    const line = (values, colour, dash) =>
      ({points: values.map((v, k) => [t[k], v]).filter((_, k) => k % (steps / points) === 0), colour, dash});
    const draw = (name, what, words, lines, y, rules = []) =>
      this.curves(name, ["time t (s)", what], response ? words() : `${what}: none, for there is no design.`,
        response ? lines : [], {x: [0, horizon], y: range(y), rules, absent: response ? "" : status});
    const rows = U.map((_, i) => z.map(row => row[i])), part = (all, i) => all.map(u => u[i]);
    draw("step", output,
      () => `Response over ${clean(horizon)} seconds: ${
        rows.map(v => `peaks at ${clean(Math.max(...v))}, ends at ${clean(v.at(-1))}`).join("; ")}.`,
      rows.map((v, i) => line(v, COLOURS[i % 3], ["", "7 4", "2 3"][i % 3])), [...rows.flat(), -0.1, 1.2],
      [1]);
    draw("input", "control signal u",
      () => `Control signal, as asked and as it arrives: at most ${
        clean(Math.max(...applied.flat().map(Math.abs)))} in size.`,
      Array
        .from({length: m},
          (_, i) => [line(part(asked, i), "--sos-first", "3 3"), line(part(applied, i), "--sos-second")])
        .flat(),
      response ? [...asked, ...applied].flat() : [-1, 1]);
  }

  // The nearest move of each single number to a design, the shortest first.
  advice(place) {
    const moves = this.data.sliders.flatMap(({key, values, texts}) => {
      const far = k => Math.abs(k - values.indexOf(place[key]));
      const good = values.map((_, k) => k).filter(k => this.probe({...place, [key]: values[k]}));
      const near = good.sort((p, q) => far(p) - far(q))[0];
      return near === undefined ? [] : [[far(near), texts[near]]];
    });
    const texts = moves.sort(([p], [q]) => p - q).map(([, text]) => text);
    return texts.length
      ? `${texts.length > 1 ? "Each of these moves" : "This move"} leads to a design: ${texts.join("; or ")}.`
      : "No move of a single number leads to a design.";
  }

  /** @param {any} design */
  told({status, asked, K, margin: [block, margin] = [], rate, at}) {
    const {tau, mu, delta} = asked, span = `[${clean(tau - mu)}, ${clean(tau + mu)}] s`;
    const word = `${capital(status)}: the delay stays in ${span}.`;
    if (!K)
      return [
        word,
        `<p>${
          status === "infeasible"
            ? "No certificate: the corrected LMI has no solution, by exact multipliers."
            : "No certificate was found, nor a proof that there is none."} ${escape(this.advice(asked))}</p>`
      ];
    return [
      word,
      gains(K, this.data.shape, 4) + `<p>Promised rate, however the delay varies: ${clean(delta)} s⁻¹. ` +
        `True slowest rate over the constant delays: ${clean(rate)} s⁻¹, at ${clean(at)} s.</p>` +
        `<p>Smallest margin: ${clean(margin, 2)} (block: ${escape(block)}).</p>`
    ];
  }
}

define("sos-delay", DelayAtlas);
