// How long a move takes on the reader's own computer: an explorer that moves by itself.
import {Explorer} from "./explorer.js";
import {clean, define, escape, number, QUIET, select} from "./kit.js";
import {Plot} from "./plot.js";

const MOVES = 60, SHARE = 0.2, GOAL = 16;  // of a slider, up and down by this share; milliseconds

const quantile =
  (list, part) => [...list].sort((a, b) => a - b)[Math.min(list.length - 1, Math.floor(part * list.length))];

class Stopwatch extends Explorer {
  markup() {
    const names = this.data.examples.map(({name}) => name);
    return select({id: `${this.name}-example`, key: "example", label: "Plant", names}) +
      `<div class="sos-row"><button type="button" class="sos-button sos-measure" ${
        QUIET}>Move every slider, up and down</button></div>` +
      `<figure class="sos-panel"><div class="sos-times"></div><figcaption class="sos-caption">Time from a move to its new picture, one dot for each move. ` +
      `Dashed: ${
        GOAL} ms, 60 pictures a second.</figcaption></figure><p class="sos-told" role="status"></p><div class="sos-inner">${
        super.markup()}</div>`;
  }

  wire() {
    const linked = number(this.linked().example), example = this.view.querySelector("select");
    super.wire();
    example.addEventListener("change", () => this.choose(Number(example.value)));
    this.find("measure").addEventListener("click", () => this.measure());
    if (linked > 0 && linked in this.data.examples) this.choose(linked);
    else this.draw([]);
  }

  choose(k) {
    this.view.querySelector("select").value = k;
    this.solver.cancel(this.name);
    clearTimeout(this.idle);
    Object.assign(this.data, this.data.examples[k].data);
    this.find("inner").innerHTML = super.markup();
    super.wire();
    this.reserve();
    this.draw([]);
  }

  get address() { return {...this.named, example: this.view.querySelector("select").value}; }

  // The address has the sliders of its own plant.
  read(linked) {
    if (!("example" in linked) || linked.example === this.address.example) super.read(linked);
  }

  // Milliseconds of each move, and those of them that the solver took.
  async measure() {
    const button = this.find("measure"), begin = [...this.values], times = [], solver = [];
    const {request} = this.data;
    button.disabled = true;
    for (const [k, value] of begin.entries()) {
      for (let move = 0; move < MOVES; move++) {
        const from = performance.now();
        this.put(k, value * (1 + SHARE * Math.sin(2 * Math.PI * move / MOVES)));
        await this.solve();
        times.push(performance.now() - from);
        solver.push(this.answer?.ms);
        await new Promise(requestAnimationFrame);
        if (request !== this.data.request) {
          button.disabled = false;
          return null;
        }  // another plant by now
      }
      this.set(k, value);
    }
    button.disabled = false;
    this.draw(times, solver);
    return {times, solver};
  }

  draw(times, solver) {
    const most = Math.max(1.25 * GOAL, ...times), plot = new Plot({
      x: [0, this.values.length * MOVES],
      y: [0, most],
      labels: ["move", "time (ms)"],
      height: 200,
      box: [46, 322, 10, 158]
    });
    plot.rule("sos-target", plot.x, [GOAL, GOAL]);
    times.forEach(
      (time,
        k) => { plot.body += `<circle class="sos-dot" cx="${plot.X(k)}" cy="${plot.Y(time)}" r="1.6"/>`; });
    const words = times.length ? `Median ${clean(quantile(times, 0.5), 2)} ms, of which the solver takes ${
                                   clean(quantile(solver, 0.5), 2)} ms; ` +
        `nine of ten moves take less than ${clean(quantile(times, 0.9), 2)} ms.`
                               : "Not measured yet on this computer.";
    this.find("times").innerHTML = plot.svg(words);
    this.find("told").innerHTML = escape(words);
  }
}

define("sos-stopwatch", Stopwatch);
