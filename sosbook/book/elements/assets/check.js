// A proof file that a reader opens: what is proven, of what, by whom, and what isn't.
import {judgedFile} from "../../kernel/judged.js";

import {define, escape, PageElement, READOUT} from "./kit.js";

const MOST = 2e6;  // letters
const STATUS = {
  proven: "feasible",
  refused: "infeasible",
  beyond: "undecided",
  odd: "undecided"
};
const LEFT = "Not proven: that this plant is yours (compare its digest, or --plant), that a program runs " +
  "this law (--code), and what limits, noise and other plants do.";
const ELSEWHERE =
  "python checker FILE decides it with Python alone; python -m sosbook verify FILE decides all kinds.";

class Check extends PageElement {
  /** @type {any} */
  chosen;  // the last file

  markup() {
    const id = `${this.name}-file`;
    return `<div class="sos-form"><label for="${id}">A proof file (.json), or drop it here</label>` +
      `<input id="${id}" type="file" accept=".json"></div>${READOUT}`;
  }

  wire() {
    const form = this.find("form");
    form.addEventListener("change", ({target}) => this.take(target.files));
    for (const kind of ["dragover", "drop"])
      form.addEventListener(kind, event => {
        event.preventDefault();
        if (kind === "drop") this.take(event.dataTransfer.files);
      });
  }

  async take([file]) {
    if (!file) return;
    this.chosen = file;  // what was chosen before and is read late isn't said any more
    if (file.size > MOST) return this.say(file.name, {status: "odd", words: "It is too large for a page."});
    const text = await file.text();
    if (this.chosen === file) this.say(file.name, judgedFile(text));
  }

  say(name, {status, words, about = [], claims = []}) {
    const list = items => items.length ? `<ul>${items.map(x => `<li>${escape(x)}</li>`).join("")}</ul>` : "";
    const last = status === "proven" ? LEFT : status === "odd" ? "" : ELSEWHERE;
    this.tell(STATUS[status],
      `<p><strong>${escape(name)}: ${status}.</strong> ${escape(words)}</p>${list(claims)}${
        about.length ? `<p>About:</p>${list(about)}` : ""}<p>${escape(last)}</p>`);
  }
}

define("sos-check", Check);
