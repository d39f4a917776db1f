// What the elements have in common that compute what they show: sliders from data,
// a hint, buttons, a motion that plays, and the last setting as a ghost.
import {announce, band, buttons, clamp, clean, complex, controls, drag, escape, gaussian, number as decimal, PageElement, panel, panels, printed, READOUT, select, slider, steady, tick, uniform} from "./kit.js";
import {mark, markAll, Plot, S_PLANE} from "./plot.js";

// Room for the longest of the words that a slider may show: its label doesn't break anew.
const roomy = (input, texts) => {
  const longest = Math.max(...texts.map(text => printed(text).length));
  input.parentElement.querySelector("output").style.minWidth = `${longest}ch`;
};

const FEW = 3;     // poles that a plot's name tells
const LOOKS = 25;  // at a slider, before those by halves
const steps = control => Math.round((control.max - control.min) / control.step);
const value = (control, position) => {
  const at = control.min + position * control.step;
  return control.scale === "log" ? Number((10 ** at).toPrecision(3)) : Number(at.toPrecision(12)) + 0;
};
const position = (control, x) =>
  Math.round(((control.scale === "log" ? Math.log10(x) : x) - control.min) / control.step);

// The same text with numbers of six characters or more.
export const wide = html =>
  html.replace(/(?<=sos-number">)−?[\d.]+(·10[⁻⁰¹²³⁴-⁹]+)?/g, x => x.padEnd(6, "8"));

export class Mover extends PageElement {
  /** @type {any} */
  plot;  // whose handles are dragged

  // What a subclass has of its own. The caption of each panel, empty where `pose` writes it;
  /** @type {any} */
  figures = {};
  // numbers alone, and what draws and tells them;
  /** @returns {any} */
  compute(_place) { return {}; }
  show(_result, _ghost, _place) {}
  // with a horizon in seconds it moves, and draws an instant;
  get horizon() { return 0; }
  get still() { return undefined; }
  get pace() { return 1; }
  pose(_result, time) {
    for (const name in this.timed) this.now(name, this.timed[name], time);
  }
  // where a result is good, the bands under the sliders are green, which means something.
  good(_result, _place) { return false; }
  get means() { return ""; }
  // It has work to do when nothing moves: `looks`.
  get idles() { return this.means !== ""; }

  markup() {
    const named = (control, more) =>
      ({id: `${this.name}-${control.key}`, key: control.key, label: control.label, ...more});
    return this.ticks(named) +
      controls("Setting",
        this.data.controls.filter(control => !control.tick)
          .map(control => control.names ? select(named(control, {names: control.names}))
                                        : slider(named(control, {max: steps(control)})))
          .join("")) +
      (this.means ? `<p class="sos-soft">Green under a slider: there ${
                      escape(this.means)}, while the others stay.</p>`
                  : "") +
      buttons(this.buttons, this.option) +
      panels(Object.entries(this.figures)
          .map(([name, caption]) => panel(name, caption, caption ? "" : " sos-live"))
          .join("")) +
      READOUT;
  }

  ticks(named) {
    const all = this.data.controls.filter(control => control.tick);
    return all.length ? `<div class="sos-ticks" role="group" aria-label="${escape(all[0].tick)}">` +
        `<span>${escape(all[0].tick)}</span>${all.map(control => tick(named(control, {}))).join("")}</div>`
                      : "";
  }

  get buttons() {
    const play = this.horizon ? [["play", "Play"]] : [];
    return [...play, ["reset", "Reset"], ["link", "Link to this"]];
  }
  get option() { return ""; }  // what stands beside the buttons

  press(what) {
    super.press(what);
    if (what === "play") this.play(!this.playing);
  }

  wire() {
    this.inputs = {};
    for (const input of this.view.querySelectorAll("[data-key]")) {
      this.inputs[input.dataset.key] = input;
      input.addEventListener("input", () => this.update());
      input.addEventListener("change", () => { this.ghost = this.result; });
      steady(input);
    }
    for (const control of this.data.controls.filter(c => !c.names)) {
      const all = Array.from({length: LOOKS}, (_, k) => Math.round(k * steps(control) / (LOOKS - 1)));
      roomy(this.inputs[control.key], all.map(k => this.words(control, value(control, k))));
    }
    if (this.horizon) this.ready();
    if (this.idles) {
      new IntersectionObserver(([entry]) => {
        this.near = entry.isIntersecting;
        this.survey();
      }, {rootMargin: "25%"}).observe(this.view);
    }
    this.reset(this.linked());
  }

  reset(to = {}) {
    for (const control of this.data.controls) {
      const {key, names, start} = control, wanted = decimal(to[key]);
      const x = isFinite(wanted) && (!names || wanted in names) ? wanted : start;
      this.put(key, names ? x : position(control, x));
    }
    this.reply("");
    this.ghost = undefined;
    this.update();
  }

  // Where a control stands: of a tick 1 or 0.
  stands(key) {
    const input = this.inputs[key];
    return Number(input.type === "checkbox" ? input.checked : input.value);
  }

  put(key, place) {
    const input = this.inputs[key];
    if (input.type === "checkbox") input.checked = Number(place) === 1;
    else input.value = place;
  }

  // Controls that are moved in a picture, as if by hand.
  choose(places, kinds = ["input", "change"]) {
    const keys = Object.keys(places);
    for (const key of keys) this.put(key, places[key]);
    for (const kind of kinds) this.inputs[keys[0]].dispatchEvent(new Event(kind, {bubbles: true}));
  }

  // The handles on the plot of the map are dragged; `keys` names what a handle moves,
  // across and up.
  handles(keys) {
    const control = key => this.data.controls.find(c => c.key === key);
    drag(this.find("map"), keys, (held, place) => {
      const at = this.plot.at(place);
      const to = held.map((key, k) => [key, clamp(position(control(key), at[k]), 0, steps(control(key)))]);
      this.choose(Object.fromEntries(to), ["input"]);
    });
  }

  words({unit}, x) { return `${clean(x, 4)}${unit}`; }

  get address() { return this.place; }

  get place() {
    return Object.fromEntries(this.data.controls.map(control => {
      const at = this.stands(control.key);
      return [control.key, control.names ? at : value(control, at)];
    }));
  }

  update() {
    const place = this.place;
    for (const control of this.data.controls.filter(c => !c.names)) {
      announce(this.inputs[control.key], this.words(control, place[control.key]));
    }
    this.result = this.compute(place);
    this.show(this.result, this.ghost, place);
    if (this.horizon) this.seek(this.playing ? 0 : this.still ?? this.time);
    this.view.querySelectorAll(".sos-band").forEach(old => old.classList.add("sos-old"));
    this.surveyed = false;
    this.survey();
  }

  // What is said here and at both ends of each control, in longer numbers.
  states() {
    const said = [];
    const at =
      this.elsewhere({tell: (_, html) => said.push(wide(html)), find: () => document.createElement("div")});
    const ends = this.data.controls.flatMap(control => {
      const {key, names} = control, last = names ? names.length - 1 : steps(control);
      return [0, last].map(k => ({...this.place, [key]: names ? k : value(control, k)}));
    });
    for (const place of [this.place, ...ends]) at.show(at.compute(place), undefined, place);
    return said;
  }

  // ----------------------------------------------------------------- bands
  probe(place) { return this.good(this.compute(place), place); }

  // When nothing has moved for a while and readers may see it: a few milliseconds at a time.
  survey() {
    clearTimeout(this.idle);
    if (!this.idles || !this.near || this.surveyed) return;
    const work = this.looks(this.place), go = () => {
      const until = performance.now() + 8;
      do {
        if (work.next().done) {
          this.surveyed = true;
          return;
        }
      } while (performance.now() < until);
      this.idle = setTimeout(go, 20);
    };
    this.idle = setTimeout(go, 250);
  }

  // Each slider at some places, then by halves where the verdict changes.
  * looks(place) {
    for (const control of this.data.controls.filter(c => !c.names)) {
      const last = steps(control), known = new Map(), ends = [];
      const at = k => {
        const there = {...place, [control.key]: value(control, k)};
        if (!known.has(k)) known.set(k, this.probe(there));
        return known.get(k);
      };
      for (let k = 0; k < LOOKS; k++) {
        at(Math.round(k * last / (LOOKS - 1)));
        yield;
      }
      const seen = [...known.keys()];
      for (let i = 1; i < seen.length; i++) {
        let [from, to] = [seen[i - 1], seen[i]];
        if (at(from) === at(to)) continue;
        while (to - from > 1) {
          const middle = (from + to) >> 1;
          if (at(middle) === at(from)) from = middle;
          else to = middle;
          yield;
        }
        ends.push([(from + to) / 2 / last, at(to)]);
      }
      const stretches = [[0, at(0)], ...ends];
      band(this.inputs[control.key],
        stretches.map(([from, good], k) => [from, stretches[k + 1]?.[0] ?? 1, good]));
      yield;
    }
  }

  // ----------------------------------------------------------------- plots
  // A plot under a name that says its state.
  draw(name, plot, label) { this.find(name).innerHTML = plot.svg([label, ...plot.said].join("; ")); }

  // Poles in a window; those of the ghost are pale. `draw(plot)` adds what lies below.
  poleMap(name, {x, y, label, poles, ghost, labels = S_PLANE, draw = null}) {
    const plot = new Plot({x, y, labels});
    if (x[0] < 0 && x[1] > 0) plot.rule("sos-axis", [0, 0], y);
    draw?.(plot);
    markAll(plot, ghost, poles);
    const slow = poles.filter(([, im]) => im >= 0).sort((p, q) => q[0] - p[0]).slice(0, FEW);
    this.draw(name, plot, `${label}, the slowest at ${slow.map(p => complex(...p)).join(", ")}`);
  }

  // Curves {points, colour, dash} and their pale `ghosts` over x, or over time, whose axis
  // needs no label; y fits unless it is given.
  /** @type {(name: string, labels: any, label: string, lines: any, more?: any) => void} */
  curves(name, labels, label, lines, {x = null, y = null, ghosts = [], rules = [], marks = []} = {}) {
    const values = lines.flatMap(({points}) => points.map(p => p[1])).filter(Number.isFinite);
    const plot = new Plot({
      x: x ?? [0, this.horizon],
      y: y ?? range([...values, ...rules]),
      labels: x ? labels : ["time t (s)", labels],
      height: 260,
      box: [52, 332, 10, 218]
    });
    const draw = (list, kind) => list.forEach(({points, colour = "--sos-first", dash}) => {
      const seen = points.filter(p => Number.isFinite(p[1]) && p[0] <= plot.x[1]);
      plot.line(seen.map(([u, v]) => [u, clamp(v, ...plot.y)]), colour, dash, kind);
    });
    for (const at of rules) plot.rule("sos-target", plot.x, [at, at]);
    draw(ghosts, " sos-ghost");
    draw(lines, "");
    for (const [point, colour, shape] of marks.filter(([point]) => plot.has(point))) {
      mark(plot, point, colour, shape);
      plot.said.push(`a mark at (${point.map(x => clean(x)).join(", ")})`);
    }
    plot.body += `<path class="sos-now"/>`;
    this.draw(name, plot, label);
    if (!x) this.timed = {...this.timed, [name]: plot};
  }

  // Two plots over one axis of time, one above the other: [y, label] of each.
  /** @type {(name: string, axes: any[], label: string, draw: any, x?: any) => void} */
  strips(name, [upper, lower], label, draw, x = [0, this.horizon]) {
    const plot = ([y, words], box, height, time) => new Plot({x, y, labels: [time, words], box, height});
    const top = plot(upper, [46, 332, 10, 150], 180, "");
    const bottom = plot(lower, [46, 332, 172, 298], 340, "time t (s)");
    draw(top, bottom);
    bottom.body = top.body + bottom.body + `<path class="sos-now"/>`;
    bottom.said.unshift(...top.said);
    this.draw(name, bottom, label);
    this.timed = {...this.timed, [name]: {X: bottom.X, t: top.t, b: bottom.b}};
  }

  // The instant on a plot that `curves` drew.
  now(name, plot, t) {
    this.find(name).querySelector(".sos-now").setAttribute("d", `M${plot.X(t)} ${plot.t}V${plot.b}`);
  }

  // ---------------------------------------------------------------- motion
  ready() {
    this.time = this.still ?? 0;
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    new IntersectionObserver(([entry]) => {
      this.seen = entry.isIntersecting;
      if (!this.seen) cancelAnimationFrame(this.frame);
      else if (this.playing ?? !calm) this.play(true);
    }).observe(this.view);
  }

  disconnectedCallback() { cancelAnimationFrame(this.frame); }

  play(on) {
    this.playing = on;
    this.find("play").textContent = on ? "Pause" : "Play";
    cancelAnimationFrame(this.frame);
    if (!on) return;
    if (this.time >= this.horizon - 1e-9) this.time = 0;
    let last;
    const go = now => {
      this.seek(this.time + (last === undefined ? 0 : Math.min(0.1, (now - last) / 1000) * this.pace));
      last = now;
      if (this.time >= this.horizon + 0.6 * this.pace) this.time = 0;  // a rest, then once more
      this.frame = requestAnimationFrame(go);
    };
    this.frame = requestAnimationFrame(go);
  }

  seek(time) {
    this.time = time;
    this.pose(this.result, Math.min(time, this.horizon));
  }
}

// Ends of an axis that hold all values, and zero, with some room.
export function range(values, least = 0) {
  const low = Math.min(...values, -least), high = Math.max(...values, least);
  const room = 0.06 * (high - low || 1);
  return [low - room, high + room];
}

// Normal numbers, the same for the same seed.
export function normal(seed) {
  const random = uniform(seed);
  return () => gaussian(random);
}

export const series = (values, T, every = 1) =>
  values.map((v, k) => [k * T, v]).filter((_, k) => k % every === 0);
// The same held from one sample to the next.
export const stairs = (points, end) =>
  points.flatMap(([t, v], k) => [[t, v], [Math.min(end, points[k + 1]?.[0] ?? end), v]]);
export const number = (x, unit = "", digits = 3) =>
  `<span class="sos-number">${clean(x, digits)}${unit}</span>`;
export const verdict = words => `<p><span class="sos-status">${words}</span></p>`;
