// A theorem that the reader types: designed for, proven in fractions, saved as a file.
import {descriptors, rounded, stateSpace} from "../../kernel/descriptor.js";
import {design} from "../../kernel/design.js";
import {decimals, sha256} from "../../kernel/exact.js";
import {parsedLine} from "../../kernel/grammar.js";
import {combined, rowsOf, scaled, symmetricEigenvalues, times, transposed, zeros} from "../../kernel/matrices.js";
import {exponential} from "../../kernel/spectrum.js";
import {unproven, unsymmetric} from "../../kernel/written.js";

import {clean, define, escape, QUIET} from "./kit.js";
import {Mover, number} from "./mover.js";

const POINTS = 160, SECONDS = 12;  // of the curve
const DIGITS = [6, 10, 17];        // of K and P, in the order of trial
const LABEL = /^[a-z][a-z0-9_]*$/;

// The file of a theorem: that of the page's own one with other lines, numbers and words.
function fileOf({file, mark}, lines, words, numbers, K, P) {
  const made = structuredClone(file), first = made.text.findIndex(line => line.includes(mark));
  made.text = made.text.filter(line => !line.includes(mark));
  made.text.splice(first, 0, ...lines.map(({name, text}) => `  ${mark}${name}.i.j: ${text} > 0`));
  Object.assign(made.data, numbers, {K: decimals(K)});
  made.point.P = decimals(P);
  const own = made.asks.requirements.find(({theorem}) => theorem);
  Object.assign(own, {claim: words});
  own.theorem.blocks = lines.map(({name, text}) => ["pair", name, text]);
  made.about.K = sha256(JSON.stringify(made.data.K)).slice(0, 12);
  return made;
}

class Theorem extends Mover {
  says = "A gust moves z by at most peak = {peak}, with |u| at most {u_max}.";
  figures = {
    reach:
      "The farthest that a gust of energy one can move z until t: with the design, and pale without. Dashed: the number peak.",
    text: "The proof as a text: yours are the lines in bold. The numbers stand beside it in the file."
  };

  markup() {
    const {lines, words, known} = this.data, id = `${this.name}-lines`;
    const names = known.map(([name, means]) => `<span><code>${escape(name)}</code> ${escape(means)}</span>`);
    return `${super.markup()}<div class="sos-form"><label for="${
             id}">Blocks that must be positive definite, one a line</label>` +
      `<textarea id="${id}" class="sos-lines" rows="${lines.length}" spellcheck="false" ${QUIET}>${
        escape(lines.join("\n"))}</textarea><p class="sos-fault" role="alert"></p>` +
      `<p class="sos-soft sos-known">${names.join(" ")}</p>` +
      `<label for="${id}-words">What they prove, in your words</label>` +
      `<input id="${id}-words" type="text" class="sos-words" value="${escape(words)}" ${QUIET}></div>`;
  }

  get buttons() { return [["reset", "Reset"], ["link", "Link to this"], ["save", "Save the proof"]]; }
  get address() { return {...this.place, lines: this.areas.lines.value, words: this.areas.words.value}; }

  wire() {
    const linked = this.linked();
    this.areas = {lines: this.find("lines"), words: this.find("words")};
    for (const [name, area] of Object.entries(this.areas)) {
      if (linked[name] !== undefined) area.value = linked[name];
      area.addEventListener("input", () => {
        clearTimeout(this.pause);
        this.pause = setTimeout(() => this.update(), 250);
      });
    }
    super.wire();
  }

  reset(to = {}) {
    if (this.stands && to.lines === undefined) {
      this.areas.lines.value = this.data.lines.join("\n");
      this.areas.words.value = this.data.words;
    }
    super.reset(to);
  }

  // The typed lines as {name, text}, in the names of the file; an Error says what is wrong.
  get typed() {
    const lines = [];
    for (const line of this.areas.lines.value.split("\n")) {
      const bare = line.split("#")[0].trim(), step = bare && parsedLine(bare);
      if (!bare) continue;
      if (step.mark !== ">" || String(step.right) !== "number,0" || !LABEL.test(step.name))
        throw new Error(`${bare.slice(0, 30)}: a line is a name, a colon, a matrix and > 0`);
      if (lines.some(({name}) => name === step.name)) throw new Error(`${step.name} comes twice`);
      const text = bare.slice(bare.indexOf(":") + 1).replace(/>\s*0$/, "").trim();
      lines.push({name: step.name, text: text.replace(/(?<![\w.])peak(?![\w.])/g, `${this.data.mark}peak`)});
    }
    if (!lines.length) throw new Error("no block is left: type one");
    return lines;
  }

  compute({peak, u_max}) {
    const {request, x0, mark} = this.data, [plain] = descriptors(request);
    const numbers = {[`${mark}peak`]: String(peak), u_max: String(u_max)};
    const words = `${this.areas.words.value} (peak = ${peak})`;
    const free = reach(plain, null);
    try {
      const lines = this.typed, {K, P} = this.data.sample;
      const mine = fileOf(this.data, lines, "", numbers, K, P);
      const text = mine.text.join("\n"),
            asked =
              {u_max, x0, text, sets: mine.sets, numbers: {...mine.data, x0: decimals(x0.map(x => [x]))}};
      const [skew] = unsymmetric(text, mine.sets, {...mine.data, ...mine.point});
      if (skew) throw new Error(`${this.label(skew)} isn't symmetric`);
      /** @type {any} */
      const found = design({...request, asked}), {status, reason} = found;
      if (status !== "feasible") return {status, reason, free, lines, file: mine};
      const rows = rowsOf(found.naturalP), proof = digits => {
        const to = (list, d) => list.map(row => row.map(x => rounded(x, Math.min(17, d))));
        const K = to(found.K, digits), P = to(rows, digits + 6);
        const file = fileOf(this.data, lines, words, numbers, K, P);
        const failed = unproven(file.text.join("\n"), file.sets, {...file.data, ...file.point});
        return {K, file, failed};
      };
      let last;
      for (const digits of DIGITS) {
        last = proof(digits);
        if (!last.failed.length) break;
      }
      const held = last.failed.length ? "undecided" : "feasible";
      return {...last, status: held, lines, free, reach: reach(plain, last.K)};
    } catch (fault) {
      if (fault.constructor !== Error) throw fault;
      return {status: "fault", fault: fault.message, free};
    }
  }

  show(result, _ghost, {peak}) {
    const {status, fault, reason, failed = [], K, lines, free} = result, held = result.reach;
    const box = this.find("fault");
    if (box.textContent !== (fault ?? "")) box.textContent = fault ?? "";
    this.areas.lines.ariaInvalid = String(Boolean(fault));
    const truth = held?.at(-1)[1], over = truth > peak;
    const most = 1.15 * Math.max(peak, free.at(-1)[1]);
    this.curves("reach", ["t (s)", "farthest |z|"], "The farthest that a gust can move z until t",
      held ? [{points: held, colour: over ? "--sos-second" : "--sos-first"}] : [],
      {x: [0, SECONDS], y: [0, most], ghosts: [{points: free, colour: "--sos-soft"}], rules: [peak]});
    this.find("text").innerHTML = this.proof(result.file);
    if (status === "fault")
      this.tell("undecided", "These lines can't be read yet.", "<p>The design waits for them.</p>");
    else if (!held) this.tell("undecided", "No design was found.", `<p>${escape(reason)}</p>`);
    else if (failed.length)
      this.tell("undecided", "Not proven.",
        `<p>In fractions ${
          failed.map(x => `<code>${escape(this.label(x))}</code>`)
            .join(", ")} is no symmetric positive definite matrix.</p>`);
    else
      this.tell(over ? "infeasible" : "feasible",

        over ? "The blocks are proven, and they don't mean that." : "Designed and proven in fractions.",
        `<p>K = [${K[0].map(x => clean(x, 4)).join(", ")}]: ${
          lines.length + 4} blocks are positive definite. The truth: |z| gets to ${
          number(truth)} at the most, ${over ? "more" : "less"} than peak = ${number(peak)}.${
          over ? " A theorem that proves a falsehood has a slip." : ""}</p>`);
  }

  // What the reader calls a block of a file.
  label(name) { return name.replace(this.data.mark, "").replace(/\.1\.1$/, ""); }

  // The lines of a proof, those of the reader marked.
  proof(file) {
    const lines = (file ?? this.data.file).text.map(line => {
      const mine = line.includes(this.data.mark), text = escape(line.replaceAll(this.data.mark, ""));
      return mine ? file ? `<b>${text}</b>` : "  …" : text;
    });
    return `<pre class="sos-code" tabindex="0">${lines.join("\n")}</pre>`;
  }

  press(what) {
    super.press(what);
    if (what !== "save") return;
    const {file, status} = this.result;
    if (status !== "feasible") {
      this.reply("<p>There is no proof to save here.</p>");
      return;
    }
    const lines =
      Object.entries(file).map(([key, value]) => `${JSON.stringify(key)}:${JSON.stringify(value)}`);
    const text = `{${lines.join(",\n")}}\n`;
    const address = URL.createObjectURL(new Blob([text], {type: "application/json"}));
    this.reply(`<p><a href="${
      address}" download="my_theorem.json">Download the proof</a>: a text and numbers. Your colleague needs nothing of yours to check it: <code>python -m sosbook verify my_theorem.json</code></p>`);
  }
}

// [t, r]: how far a gust w of energy one can move z until t, the root of the largest
// eigenvalue of C W C' with W' = A W + W A' + B B'.
function reach(plain, K) {
  const [A0, Bu, B] = stateSpace(plain), h = SECONDS / POINTS;
  const A = K
    ? combined(1, A0, 1, times(Bu, {rows: K.length, cols: K[0].length, at: Float64Array.from(K.flat())}))
    : A0;
  const Phi = exponential(A, h), BB = times(B, transposed(B)), list = [[0, 0]];
  let step = scaled(1 / 6, BB);  // Simpson's rule
  for (const [s, weight] of [[0.5, 4], [1, 1]]) {
    const E = exponential(A, s * h);
    step = combined(1, step, weight / 6, times(times(E, BB), transposed(E)));
  }
  step = scaled(h, step);
  let W = zeros(A.rows, A.rows);
  for (let k = 1; k <= POINTS; k++) {
    W = combined(1, times(times(Phi, W), transposed(Phi)), 1, step);
    const Z = times(times(plain.C, W), transposed(plain.C));
    list.push([k * h, Math.sqrt(Math.max(0, symmetricEigenvalues(Z).at(-1)))]);
  }
  return list;
}

define("sos-theorem", Theorem);
