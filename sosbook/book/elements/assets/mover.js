// What the elements have in common that compute what they show: a sentence whose numbers and choices
// are its controls, a hint, buttons, a motion that plays, and the last setting as a ghost.
import {buttons, clamp, clean, complex, drag, escape, gaussian, number as decimal, PageElement, panel, panels, printed, READOUT, tallest, uniform} from "./kit.js";
import {mark, markAll, Plot, S_PLANE} from "./plot.js";
import {cut, shownOf} from "./sentence.js";
import {listen, longest, markup, speak, typed} from "./spoken.js";

const FEW = 3;                                                        // poles that a plot's name tells
const LOOKS = 25;                                                     // at a ruler, before those by halves
const DRAWN = ["draw", "poleMap", "curves", "strips", "map", "cut"];  // methods that say nothing
const WAY = 300;  // pixels that lead from one end of a number's range to the other

// A number goes from one position of its ruler to the next: its values, or evenly, or by logarithm.
const steps = ({values, min, max, step}) => values ? values.length - 1 : Math.round((max - min) / step);
const value = (control, position) => {
  if (control.values) return control.values[position];
  const at = control.min + position * control.step;
  return control.scale === "log" ? Number((10 ** at).toPrecision(3)) : Number(at.toPrecision(12)) + 0;
};
const position = ({values, scale, min, step}, x) => values
  ? values.reduce((near, v, k) => Math.abs(v - x) < Math.abs(values[near] - x) ? k : near, 0)
  : Math.round(((scale === "log" ? Math.log10(x) : x) - min) / step);
const some = control => Array.from({length: LOOKS}, (_, k) => Math.round(k * steps(control) / (LOOKS - 1)));

// The same text with numbers of six characters or more.
export const wide = html =>
  html.replace(/(?<=sos-number">)−?[\d.]+(·10[⁻⁰¹²³⁴-⁹]+)?/g, x => x.padEnd(6, "8"));

export class Mover extends PageElement {
  /** @type {any} */
  plot;  // whose handles are dragged
  /** @type {any} */
  stands;  // the controls, by name
  /** @type {any} */
  words;  // the verdict
  /** @type {any} */
  taken;  // the number on the ruler

  // What a subclass has of its own. What it says of its controls: {key} is a number and its unit, a
  // choice or a tick; which numbers go in steps alone, and which choices mean nothing now;
  /** @type {any} */
  says;
  /** @type {string[]} */
  snaps = [];
  off(_key) { return false; }
  // the caption of each panel, empty where `pose` writes it;
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
  // where a result is good, the ruler is green, which means something.
  good(_result, _place) { return false; }
  get means() { return ""; }
  // It has work to do when nothing moves: `looks`.
  get idles() { return this.means !== ""; }

  markup() {
    const figures =
      Object.entries(this.figures).map(([name, caption]) => panel(name, caption, caption ? "" : " sos-live"));
    return markup(this.name) +
      (this.means ? `<p class="sos-soft">Green below the ruler: there ${
                      this.means}, while the other numbers stay.</p>`
                  : "") +
      buttons(this.buttons, this.option) +
      (figures.length > 1 ? panels(figures.join("")) + READOUT : panels(figures.join("") + READOUT));
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
    Object.assign(this, {wrong: {}, middles: {}});
    listen(this);
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
    this.stands = Object.fromEntries(this.controls.map(control => {
      const {key, start, names} = control, given = decimal(to[key]);
      const x = names ? given in names ? given : NaN : this.meaning(key, String(given));
      return [key, isFinite(x) ? x : start];
    }));
    this.wrong = {};
    this.reply("");
    this.ghost = undefined;
    this.update();
  }

  // ------------------------------------------------------------- the sentence
  get controls() { return this.data.controls; }
  /** @returns {any} */
  control(key) { return this.controls.find(control => control.key === key); }
  get place() { return {...this.stands}; }
  get address() { return this.place; }
  get sentences() {
    return {
      names: Object.fromEntries(
        this.controls.map(({key, label, unit = ""}) => [key, [label, printed(unit).trim()]]))
    };
  }
  get pieces() {
    return cut(this.says ?? this.data.says).flatMap(({text, slot}) => {
      if (!slot) return {text};
      const control = this.control(slot), {names, tick, unit} = control, x = this.stands[slot];
      const piece = {slot, clause: control, off: this.off(slot)};
      if (tick) return {...piece, choices: true, shown: x ? control.label : `(not ${control.label})`};
      if (names) return {...piece, choices: names, shown: names[x]};
      return [{...piece, shown: shownOf({}, x)}, ...(unit ? [{text: printed(unit)}] : [])];
    });
  }
  get sentence() { return this.pieces.map(({text, shown}) => text ?? shown).join(""); }
  get ending() { return [" ", this.words]; }
  moves(_key) { return true; }
  scaleOf(slot) {
    const control = this.control(slot), high = steps(control);
    const at = x => position(control, x), go = k => value(control, clamp(Math.round(k), 0, high));
    return {
      low: 0,
      high,
      at,
      value: go,
      get widest() { return longest(some(control).map(go)); },
      stepped: (x, count) => go(at(x) + count),
      pulled: (x, far) => go(at(x) + far * high / WAY)
    };
  }

  // What a text means as the number of a control; NaN where it is none, or out of its range.
  meaning(slot, text) {
    const control = this.control(slot), unit = (control.unit ?? "").trim(),
          x = typed(printed(text).replace(printed(unit), ""));
    const ends = [value(control, 0), value(control, steps(control))];
    if (!(x >= Math.min(...ends) && x <= Math.max(...ends))) return NaN;
    return control.values || this.snaps.includes(slot) ? value(control, position(control, x)) : x;
  }
  ask(slot, x, left) { this.move({[slot]: x}, left); }
  choose(x, slot) { this.move({[slot]: x}); }
  remember() {
    this.surveyed = false;
    this.survey();
  }
  // Controls that are moved, by hand or in a picture; what was before is a ghost until the hand leaves.
  move(places, left = true) {
    if (Object.keys(places).some(key => places[key] !== this.stands[key])) {
      Object.assign(this.stands, places);
      this.update();
    }
    if (left) this.ghost = this.result;
  }

  // The handles on the plot of the map are dragged; `keys` names what a handle moves, across and up.
  handles(keys) {
    drag(this.find("map"), keys, (held, place) => {
      const at = this.plot.at(place), to = (key, x) => {
        const {value, at} = this.scaleOf(key);
        return [key, value(at(x))];
      };
      this.move(Object.fromEntries(held.map((key, k) => to(key, at[k]))), false);
    });
  }

  settle() {
    super.settle();
    if (this.words !== undefined) speak(this);
  }
  // A verdict ends the sentence; what more there is stands below.
  tell(status, words, html) {
    Object.assign(this, {words: printed(words), kind: status});
    super.tell(status, printed(html));
  }

  update() {
    this.result = this.compute(this.place);
    this.show(this.result, this.ghost, this.place);
    if (this.horizon) this.seek(this.playing ? 0 : this.still ?? this.time);
    this.find("band").classList.add("sos-old");
    this.surveyed = false;
    this.survey();
  }

  // What is said here and at both ends of each control, in longer numbers; nothing is drawn for it.
  said() {
    const said = [], nothing = () => {};
    const at = this.elsewhere({
      tell: (_, words, html) => said.push([words, wide(html)]),
      find: () => document.createElement("div"),
      ...Object.fromEntries(DRAWN.map(name => [name, nothing]))
    });
    const ends = this.controls.flatMap(control => {
      const {key, names} = control, last = names ? names.length - 1 : steps(control);
      return [0, last].map(k => ({...this.place, [key]: names ? k : value(control, k)}));
    });
    at.show(this.result, undefined, this.place);
    for (const place of ends) at.show(at.compute(place), undefined, place);
    return said;
  }
  states() {
    const said = this.said();
    this.verdicts = said.map(([words]) => words);
    return said.map(([, html]) => html);
  }
  reserve() {
    super.reserve();
    this.sizes.observe(this.find("say em"));
  }
  resized() {
    if (this.find("say em").getBoundingClientRect().height > this.high + 0.01) {
      this.verdicts.push(this.words);
      this.room();
    }
    super.resized();
  }
  room() {
    super.room();
    const end = this.find("say em");
    this.high = tallest(end, this.verdicts.map(escape));
    end.style.minHeight = `${this.high}px`;
  }

  // ------------------------------------------------------------------ band
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

  // The number on the ruler at some places, then by halves where the verdict changes: below the ruler
  // stretches of its way are green.
  * looks(place) {
    const control = this.control(this.taken), last = steps(control), known = new Map();
    const at = k => {
      const there = {...place, [control.key]: value(control, k)};
      if (!known.has(k)) known.set(k, this.probe(there));
      return known.get(k);
    };
    for (const k of some(control)) {
      at(k);
      yield;
    }
    const seen = [...known.keys()], stretches = [[0, at(0)]];
    for (let i = 1; i < seen.length; i++) {
      let [from, to] = [seen[i - 1], seen[i]];
      if (at(from) === at(to)) continue;
      while (to - from > 1) {
        const middle = (from + to) >> 1;
        if (at(middle) === at(from)) from = middle;
        else to = middle;
        yield;
      }
      stretches.push([(from + to) / 2 / last, at(to)]);
    }
    const band = this.find("band"), percent = x => `${Math.round(1000 * x) / 10}%`;
    const colours = stretches.map(
      ([from, good], k) =>
        `var(--sos-${good ? "region" : "line"}) ${percent(from)} ${percent(stretches[k + 1]?.[0] ?? 1)}`);
    band.className = "sos-band";
    band.style.background = `linear-gradient(to right, ${colours.join(", ")})`;
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
  curves(
    name, labels, label, lines, {x = null, y = null, ghosts = [], rules = [], marks = [], absent = ""} = {}) {
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
    if (absent) plot.absent(absent, 110);
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
