// A plant of the reader's own, from an engineer's words to a proven gain: a wish, and matrices to type,
// with ranges or several plants; what is true at all corners; and outputs to take home.
import {Fault, parsed, refusals} from "./checks.js";
import {plants} from "./corners.js";
import {read} from "./files.js";
import {BOXES, compact, dataOf, FIELDS, goals, requestOf, STRANGE} from "./form.js";
import {rest} from "./judge.js";
import {button, capital, define, escape, number, options, panel, panels, printed, QUIET} from "./kit.js";
import {lawOf, memory, seen, seenBy, withChoice} from "./law.js";
import {apply} from "./linalg.js";
import {machine} from "./machine.js";
import * as outputs from "./outputs.js";
import {Searched} from "./searched.js";
import {markup} from "./spoken.js";
import {boundOf, BOUNDS} from "./wishes.js";

const CHANGED =
  "The fields were changed. What stands below belongs to the matrices before, and is locked until you design for these.";
const DRAWN =
  "Springs and dampers as S and D join the coordinates, dashed where they push apart. u pushes, w disturbs; marks below: measured.";
const RUN = "<p>Saved as plant.json: <code>python -m sosbook design plant.json --out folder</code></p>";
const FILES = "or drop them here: a plant.json, a .mat, or M, D, S and B at once as .mtx or .csv";
// What went wrong, for readers; what they needn't know goes to the console.
function words(error, before = "") {
  if (error instanceof Fault) return error.message;
  console.error(error);
  return before + STRANGE;
}
const PAUSE = 300;  // ms without a move, before the address and the way back know it
const PAST = 200;   // settings that "Undo" goes back

const matricesOf = texts => [..."MDSBF"].map(name => compact(texts[name] ?? "")).join("|");

class Bench extends Searched {
  /** @type {any} */
  chosen;  // the last files

  get buttons() {
    const [, ...others] = super.buttons;
    return [
      ["undo", "Undo"], ["reset", "Reset the numbers"], ...others, ["c", "As C"], ["json", "As JSON"],
      ["report", "Report"]
    ];
  }

  markup() {
    const field = ([name, words, shape, box]) =>
      `<div class="sos-field"${box ? ` data-box="${box}" hidden` : ""}>` +
      `<label for="${this.name}-${name}">${words} <span class="sos-soft">${shape}</span></label>` +
      `<textarea id="${this.name}-${name}" data-field="${name}" rows="3" spellcheck="false" ${
        QUIET}></textarea></div>`;
    const box = ([key, words]) =>
      `<label class="sos-check"><input type="checkbox" data-wanted="${key}" ${QUIET}> ${words}</label>`;
    const names = this.data.examples.map(({name}) => name);
    const id = `${this.name}-example`,
          start = `<label for="${id}">Start from</label>` +
      `<select id="${id}" data-key="example" ${QUIET}>${options(names)}</select>`;
    return `${markup(this.name)}<div class="sos-form">${
             panels(panel("machine", DRAWN) + `<div>${start}` +
               `<div class="sos-row">${button(["open", "Open files"])}<input type="file" multiple hidden>` +
               `<span class="sos-soft sos-source" role="status"></span></div>` +
               `<p class="sos-soft">Or type your own. A row of numbers a line, or 1 0; 0 1. An empty line between two matrices: two plants, and one gain for both.</p></div>`)}` +
      `<div class="sos-fields">${FIELDS.map(field).join("")}</div>` +
      `<div class="sos-row"><button type="button" class="sos-button sos-design" ${
        QUIET}>Design for these matrices</button>${BOXES.map(box).join("")}</div>` +
      `<p class="sos-fault" role="alert"></p><p class="sos-note" role="status"></p></div><div class="sos-inner"></div>`;
  }

  wire() {
    Object.assign(refusals, this.data.refusals);
    const linked = this.linked();
    const on = (name, kind, act) =>
      this.view.querySelectorAll(name).forEach(part => part.addEventListener(kind, act));
    this.past = [];
    on("[data-key=example]", "change", () => {
      const {wanted} = this, fields = FIELDS.filter(([name, , , box]) => wanted[box] && !this.follows(name));
      const went = Object.keys(this.own)
                     .filter(key => key in this.bounds)
                     .map(key => this.textOf(key))
                     .concat(fields.map(([name]) => name));
      this.fill(this.data.examples[this.example.value]);
      this.own = {};
      this.jump = undefined;
      this.rebuild(
        went.length && `${printed(went.join(", "))} went with the plant before. Undo brings it back.`);
    });
    on(".sos-design", "click", () => this.rebuild());
    on("[data-wanted]", "change", () => this.rebuild());
    on("[type=file]", "change", ({target}) => this.take(target.files));
    for (const kind of ["dragover", "drop"])
      on(".sos-form", kind, event => {
        event.preventDefault();
        if (kind === "drop") this.take(event.dataTransfer.files);
      });
    this.attend();
    this.view.addEventListener("keydown", event => {
      if (event.key !== "z" || event.shiftKey || !(event.ctrlKey || event.metaKey)) return;
      if (event.target.matches("textarea, [type=text]")) return;
      event.preventDefault();
      this.press("undo");
    });
    this.fill(this.data.examples[0]);
    if ("M" in linked) this.rebuild();  // what there is below where the address has a fault
    this.open(linked);
    this.kept = this.digest;
    if (Object.keys(linked).length) return;
    this.recall();
    this.settle();
  }

  get example() { return this.view.querySelector("[data-key=example]"); }
  area(name) { return this.view.querySelector(`[data-field=${name}]`); }

  // The wishes that are ticked, and the fields that count.
  get boxes() { return [...this.view.querySelectorAll("[data-wanted]")]; }
  get wanted() { return Object.fromEntries(this.boxes.map(box => [box.dataset.wanted, box.checked])); }
  get matrices() {
    return Object.fromEntries(FIELDS.filter(([, , , box]) => !box || this.wanted[box])
        .map(([name]) => [name, compact(this.area(name).value)]));
  }
  get typed() { return JSON.stringify([this.wanted, this.matrices]); }
  // Whether nobody has typed in a field: then it follows the plant.
  follows(name) { return this.area(name).value === this.area(name).dataset.given; }
  // Under "own" stand the names of all that a reader chose, also where no box asks for it now.
  get address() {
    const bounds = Object.entries(this.wanted).filter(([, on]) => on).map(([key]) => key).join(" ");
    const typed = FIELDS.map(([name]) => name).filter(name => !this.follows(name));
    return {
      ...this.own,
      ...super.address,
      ...(this.jump && {step: this.jump}),
      example: this.example.value,
      ...Object.fromEntries(typed.map(name => [name, compact(this.area(name).value)])),
      ...this.matrices,
      ...(bounds && {bounds}),
      own: [...Object.keys(this.own), ...typed].sort().join(" ")
    };
  }

  // What an address asks for; where it doesn't say what is a reader's own, all of it is.
  open(linked) {
    const bounds = (linked.bounds ?? "").split(" "), example = number(linked.example);
    this.jump = number(linked.step) || undefined;
    const own = linked.own?.split(" ") ?? Object.keys(linked).filter(key => linked[key]);
    this.own = Object.fromEntries(Object.keys(BOUNDS)
        .filter(key => own.includes(key) && boundOf(key, linked[key]))
        .map(key => [key, boundOf(key, linked[key])]));
    if ("M" in linked) {
      this.example.value = example in this.data.examples ? example : 0;
      const texts = Object.entries(linked).map(([key, text]) => [key, text.replaceAll(";", "\n")]);
      this.fill({texts: Object.fromEntries(texts), x0: this.data.examples[this.example.value].x0});
      for (const [name] of FIELDS)
        if (own.includes(name)) delete this.area(name).dataset.given;
      for (const box of this.boxes) box.checked = bounds.includes(box.dataset.wanted);
    }
    this.rebuild();
  }

  // Files in the place of an address: what they don't say is empty then.
  async take(files) {
    const names = [...files].map(({name}) => name).join(", "), source = this.find("source");
    const mine = this.chosen = [...files];
    try {
      const {fields, left, words} = await read(mine);
      if (mine !== this.chosen) return;  // others were chosen meanwhile
      this.file = {texts: fields, words};
      this.open(fields);
      source.textContent = `Read from ${names}.${left && ` Without a field, and left out: ${left}.`}`;
    } catch (error) {
      if (mine !== this.chosen) return;
      source.textContent = words(error, `${names}: `);
      source.classList.add("sos-wrong");
    }
    this.view.querySelector("[type=file]").value = "";  // for the same once more
  }

  /** @param {any} example */
  fill({texts = {}, x0}) {
    for (const [name] of FIELDS) this.area(name).value = this.area(name).dataset.given = texts[name] ?? "";
    this.initial = x0;
    this.find("source").textContent = FILES;
    this.find("source").classList.remove("sos-wrong");
  }

  // What a wish needs and nobody has typed: weights of one, and the example's x(0), or a step
  // of the set point from where the plant rests.
  complete() {
    let found = {};
    try {
      const {vertices: [v]} = plants(this.matrices), U = parsed("U", this.matrices.U);
      const law = this.wanted.law && lawOf(this.matrices, v.M.length, U), r = parsed("r", this.matrices.r);
      const goal = r.length ? r.flat() : goals(v.M.length, U), {jump = 1} = this;
      const z = rest(v, U, goal).map(x => 0 - jump * x);
      const start = [...z, ...z.map(() => 0), ...(law ? memory(law, z) : U.map(() => 0))], N = start.length;
      const x0 = !this.jump && this.initial?.length === N ? this.initial : start;
      found = {x0, Q: Array(N).fill(1), R: v.B[0].map(() => 1), T: [0.001]};
    } catch { /* the form says it */
    }
    const asked = FIELDS.filter(([name, , , box]) => name in found && this.wanted[box]);
    for (const [name] of asked) {
      const list = found[name], area = this.area(name);
      if (this.follows(name) && list.every(isFinite)) area.value = area.dataset.given = list.join(" ");
    }
  }

  rebuild(note = "", middles = undefined) {
    const {wanted} = this, fault = this.find("fault");
    this.view.querySelectorAll("[data-box]").forEach(field => { field.hidden = !wanted[field.dataset.box]; });
    this.complete();
    fault.textContent = "";
    try {
      const found = requestOf(this.matrices, wanted);
      Object.assign(this.data, dataOf(found, wanted), {words: this.words});
      const rounded = found.rounded && "A corner has more digits than a number keeps, and is rounded.";
      this.warning = [note, found.warning, rounded].filter(x => x).join(" ");
    } catch (error) {
      fault.textContent = words(error);
      return this.settle();
    }
    this.solver.cancel(this.name);
    clearTimeout(this.idle);
    this.built = this.typed;
    this.find("inner").innerHTML = this.body();
    this.wrong = {};
    this.begin(middles);
    for (const key in this.bounds)
      if (key in this.own) this.bounds[key] = this.own[key];
    this.draw(null);
    this.solve();
    this.reserve();
  }

  // The first plant: at rest before there is an answer, and as its loop moves then.
  draw(motion) {
    const {request, clock, law} = this.data, seen = law ? seenBy(law) : clock?.measured;
    this.find("machine").innerHTML = machine(request.vertices[0], seen, motion);
  }

  // Until fields and answer belong together nothing below the fields can be used.
  settle() {
    super.settle();
    const inner = this.find("inner"), old = this.built !== this.typed;
    inner.classList.toggle("sos-locked", old);
    inner.inert = old;
    const note = this.find("note"), words = old ? CHANGED : this.warning ?? "";
    if (note.textContent !== words) note.textContent = words;  // screen readers say it once
    clearTimeout(this.pause);
    this.pause = setTimeout(() => this.keep(), PAUSE);
  }

  // The setting goes into the page's address, for a reload, and into the past, for "Undo".
  keep() {
    const now = this.digest;
    if (now === this.kept || Object.keys(this.wrong).length) return;
    if (this.kept !== undefined) this.past = [...this.past, this.kept].slice(-PAST);
    if (this.kept !== undefined && !this.closest(".sos-live"))
      history.replaceState(null, "", `#${this.name}:${now}`);
    this.kept = now;
  }

  // What the parts of this plant are called, where an example or a file says it.
  get words() {
    const known = [...this.data.examples, this.file ?? {texts: {}}], now = matricesOf(this.matrices);
    return known.find(({texts}) => matricesOf(texts) === now)?.words;
  }

  undo() {
    this.keep();
    const before = this.past.pop();
    if (before === undefined) return this.reply("<p>There is nothing to undo.</p>");
    this.kept = before;
    this.open(Object.fromEntries(new URLSearchParams(before)));
    if (!this.closest(".sos-live")) history.replaceState(null, "", `#${this.name}:${before}`);
  }

  // ------------------------------------------------------------- numbers
  textOf(key) { return `${BOUNDS[key].symbol} = ${this.bounds[key]}${BOUNDS[key].unit}`; }
  moves(key) {
    return key in this.bounds || key.includes("/") || ["step", "T", "delay", "filter"].includes(key);
  }
  get pieces() { return withChoice(this.sentences, this.data.law); }
  choose(at) {
    const law = this.sentences.laws()[at - 1];
    this.boxes.find(box => box.dataset.wanted === "law").checked = Boolean(law);
    if (law) {
      const {U} = this.data.request, [, position] = law,
            texts = {position, velocity: [], U: seen(U, position)};
      for (const [name, rows] of Object.entries(texts))
        this.area(name).value = rows.map(row => row.join(" ")).join("\n");
      this.area("filter").value ||= String(Number((1 / this.bounds.rho).toPrecision(1)));
    }
    this.rebuild();
  }
  // What a reader types in the sentence, and no bound has, stands in a field of the form.
  fit(slot, x) {
    const name = slot.includes("/") ? "ranges" : slot, [parameter, end] = slot.split("/");
    if (name === "step") {
      this.jump = x;
      return this.rebuild("", this.middles);
    }
    const text = name !== "ranges"
      ? String(x)
      : this.sentences.ranges
          .map(([one, ends]) =>
                 `${one} = ${(one === parameter ? ends.with(Number(end), x) : ends).join(" .. ")}`)
          .join("\n");
    if (this.area(name).value === text) return;
    this.area(name).value = text;
    this.rebuild("", this.middles);
  }

  // ------------------------------------------------------------- the truth
  update() {
    super.update();
    this.draw(this.truth && this.response[0]);
  }

  // ------------------------------------------------------------- outputs
  press(what) {
    super.press(what);
    if (what === "undo") this.undo();
    if (what === "open") this.view.querySelector("[type=file]").click();
    if (what === "json") this.print(outputs.file(this.asks), RUN);
    if (what !== "c" && what !== "report") return;
    const {answer, digest} = this;
    if (answer?.digest !== digest) this.reply("<p>The design is still being computed: press again.</p>");
    else if (answer.status !== "feasible") this.reply("<p>There is no design here.</p>");
    else if (what === "c") this.print(this.code);
    else this.report();
  }

  get code() {
    const {answer: {K, gains}, data: {request: {U, vertices: [plant]}, goal, law}} = this;
    const points = goal.map((_, k) => rest(plant, U, goal.map((_, j) => j === k ? 1 : 0)));
    const seen = law ? points.map(z => apply(law.position ?? [], z)) : points;
    return outputs.program(this.asks, {K, U, points: seen, gains}, this.sentence);
  }

  // A page of all that is known, and its proof.
  async report() {
    const {digest} = this, html = name => this.find(name).innerHTML;
    this.reply("<p>Computing with whole numbers …</p>");
    const proof = await this.proofOf();
    if (this.find("more").dataset.digest !== digest || this.digest !== digest) return;
    const claims = proof?.proven ? `<ul>${proof.claims.map(x => `<li>${escape(x)}</li>`).join("")}</ul>`
                                 : "<p>Not proven.</p>";
    const parts = [
      ["Asked", `<p>${escape(this.sentence)}</p>`], ["Found", html("readout")],
      ["Proven in exact arithmetic", claims], ["Poles and step", html("map") + html("step")]
    ];
    const own = [
      ["As Python", this.program], ["As JSON", outputs.file(this.asks)], ["As C", this.code],
      ...(proof?.text ? [["Proof, for python -m sosbook verify", proof.text]] : [])
    ];
    const page = outputs.report(capital(this.data.title), parts, own);
    const address = URL.createObjectURL(new Blob([page], {type: "text/html"}));
    this.reply(`<p><a href="${address}" download="report.html">Download the report</a>: request, gains, ${
                 proof?.text ? "proof, " : ""}truth, pictures and programs on one page.</p>`,
      digest);
  }
}

define("sos-bench", Bench);
