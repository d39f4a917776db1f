import {announce, buttons, clean, controls, define, escape, gainRows, gains, nearest, number, options, PageElement, panel, panels, places, printed, READOUT, select, slider, steady} from "./kit.js";
import {Plot} from "./plot.js";
import * as python from "./program.js";

class FeasibilityMap extends PageElement {
  markup() {
    const named = (key, more) => ({id: `${this.name}-${key}`, key, ...more});
    const slide = key => slider(named(key, {label: "", max: 0}));
    return controls("Plant and requirements",
             select(named("group", {label: "Plant", names: this.data.groups.map(group => group.name)})) +
               select(named("pair", {label: "Requirements", names: []})) + slide("x") + slide("y")) +
      panels(panel("plot", "") + READOUT) +
      buttons([["reset", "Reset"], ["link", "Link to this"], ["python", "As Python"]]);
  }

  wire() {
    this.control("group").addEventListener("change", () => this.choose());
    this.control("pair").addEventListener("change", () => this.open());
    for (const key of ["x", "y"]) {
      this.control(key).addEventListener("input", () => this.update());
      steady(this.control(key));
    }
    this.reset(this.linked());
  }

  // A slider at the value next to this one.
  put(key, value) { this.control(key).value = nearest(this.map[key].values, value); }

  get values() { return ["x", "y"].map((key, k) => this.map[key].values[this.place[k]]); }

  reset(to = {}) {
    const {group = "", pair = this.control("pair").value, x, y} = to;
    if (number(group) in this.data.groups) this.control("group").value = group;
    this.choose(pair);
    for (const [key, value] of Object.entries({x: number(x), y: number(y)}))
      if (value > 0 && isFinite(value)) this.put(key, value);
    this.update();
  }

  get address() {
    const [x, y] = this.values;
    return {group: this.control("group").value, pair: this.control("pair").value, x, y};
  }

  get program() {
    const {x, y, bounds, program} = this.map, [u, v] = this.values;
    return python.design(program, {...bounds, [x.key]: u, [y.key]: v});
  }

  control(key) { return this.view.querySelector(`[data-key=${key}]`); }
  get group() { return this.data.groups[Number(this.control("group").value)]; }
  // Between a list's "input" and its "change" a plant may lack the pair of the one before.
  get map() { return this.group.maps[Number(this.control("pair").value)] ?? this.group.maps[0]; }
  get place() { return [Number(this.control("x").value), Number(this.control("y").value)]; }

  choose(pair = "0") {
    this.control("pair").innerHTML =
      options(this.group.maps.map(({x, y}) => printed(`${x.symbol} and ${y.symbol}`)));
    this.control("pair").value = number(pair) in this.group.maps ? pair : 0;
    this.open();
    if (this.longest) this.reserve();  // those of another plant
  }

  // The sliders start at what was asked, or next to it.
  open() {
    ["x", "y"].forEach((key, k) => {
      const axis = this.map[key], input = this.control(key);
      input.max = axis.values.length - 1;
      this.put(key, this.map.asked[k]);
      input.parentElement.querySelector("span").textContent = printed(axis.label);
    });
    this.update();
  }

  unit(axis) { return printed(axis.unit.trim() ? `${axis.symbol} (${axis.unit.trim()})` : axis.symbol); }
  say(axis, value) { return printed(`${axis.symbol} = ${clean(value, 4)}${axis.unit}`); }

  // By the proofs kept: one that asks for as much, or one that asks for no more.
  /** @returns {any} */
  verdict([i, j]) {
    const {y, rows, designs, refusals} = this.map, v = y.values[j];
    const least = (a, b) => (a - b) * y.harder >= -1e-9 * Math.abs(b);
    for (let k = i; k < rows.length; k++) {
      if (rows[k][0] !== null && least(rows[k][0], v)) return {status: "feasible", kept: designs[rows[k][2]]};
    }
    for (let k = i; k >= 0; k--) {
      if (rows[k][3] !== null && least(v, rows[k][1]))
        return {status: "infeasible", kept: refusals[rows[k][3]]};
    }
    return {status: "undecided"};
  }

  update() {
    const {x, y} = this.map, [i, j] = this.place, verdict = this.verdict([i, j]);
    const held = at => this.verdict(at).status === "feasible";
    places(this.control("x"), x.values.map((_, k) => held([k, j])));
    places(this.control("y"), y.values.map((_, k) => held([i, k])));
    announce(this.control("x"), this.say(x, x.values[i]));
    announce(this.control("y"), this.say(y, y.values[j]));
    this.find("plot").innerHTML = this.plot(verdict);
    this.find("caption").textContent =
      `Shaded: a certified design. Hatched: proven infeasible. Blank: between the proofs. Diamond: what was asked. Held: ${
        printed(this.map.held.join(", ")) || "nothing else"}.`;
    this.tell(verdict.status, this.readout(verdict));
  }

  plot(verdict) {
    const {x, y, rows, asked} = this.map, [i, j] = this.place;
    const near = [...x.values, asked[0]], all = [...y.values, asked[1]];
    const plot = new Plot({
      x: [Math.min(...near) / 1.03, Math.max(...near) * 1.03],
      y: [Math.min(...all), Math.max(...all)],
      labels: [this.unit(x), this.unit(y)],
      box: [54, 332, 12, 292],
      height: 334,
      logarithmic: true,
    });
    // a design covers all that asks for less, a refusal all that asks for more
    const loose = x.harder > 0 ? plot.l : plot.r, hard = x.harder > 0 ? plot.r : plot.l;
    const easy = y.harder > 0 ? plot.b : plot.t, tough = y.harder > 0 ? plot.t : plot.b;
    const stair = (side, from, close) => {
      const steps =
        x.values.flatMap((v, k) => rows[k][side] === null ? [] : [[plot.X(v), plot.Y(rows[k][side])]]);
      if (!steps.length) return "";
      if (!close) steps.reverse();
      let path = `M${from} ${close ? easy : tough}`, last = null;
      for (const [u, v] of steps) {
        path += last === null ? `L${from} ${v}` : `L${last} ${v}`;
        path += `L${u} ${v}`;
        last = u;
      }
      return `${path}L${last} ${close ? easy : tough}Z`;
    };
    const style = plot.hatch(`${this.name}-hatch`);
    const [u, v] = [plot.X(asked[0]), plot.Y(asked[1])];
    const [a, b] = [plot.X(x.values[i]), plot.Y(y.values[j])];
    plot.body += `<path class="sos-region" d="${stair(0, loose, true)}"/>` +
      `<path class="sos-region sos-empty" ${style} d="${stair(1, hard, false)}"/>` +
      `<path class="sos-asked" d="M${u} ${v - 6}l6 6l-6 6l-6 -6Z"/>` +
      `<path class="sos-cross" d="M${a - 9} ${b}h18M${a} ${b - 9}v18"/>`;
    return plot.svg(printed(`Map of ${x.label} and ${y.label}`) +
      `, logarithmic: the point at ${this.say(x, x.values[i])}, ` +
      `${this.say(y, y.values[j])} is ${verdict.status}.`);
  }

  states() {
    return this.group.maps.flatMap(map => map.x.values.flatMap((_, i) => map.y.values.map((_, j) => {
      const at = this.elsewhere({map, place: [i, j]});
      return at.readout(at.verdict([i, j]));
    })));
  }

  readout({status, kept}) {
    const {x, y, shape} = this.map, [i, j] = this.place;
    const point = `${this.say(x, x.values[i])}, ${this.say(y, y.values[j])}`;
    const word = {feasible: "Certified", infeasible: "Excluded", undecided: "Undecided"}[status];
    const head = `<p><span class="sos-status">${word}</span>: ${escape(point)}.</p>`;
    if (status === "undecided")
      return head +
        "<p>Neither a certified design nor a proof that there is none is stored for this point.</p>";
    if (status === "infeasible") {
      const bars =
        kept.shares
          .map(([name, share]) => `<li><span class="sos-bar" style="width:${5 * share}em"></span>` +
              `${escape(printed(name))}: ${Math.round(100 * share)} %</li>`)
          .join("");
      return head + `<p>Exact multipliers: no design for ${escape(printed(kept.asked))}, nor for more.</p>` +
        (bars ? `<p>What relaxing each by the same small factor would bring:</p><ul class="sos-shares">${
                  bars}</ul>`
              : "");
    }
    return head +
      `<p>This design, certified for ${escape(printed(kept.asked))}, keeps it; its tightest block is ` +
      `${escape(printed(this.data.blocks[kept.block]))}.</p>${gains(gainRows(kept.K, shape), shape, 4)}`;
  }
}

define("sos-map", FeasibilityMap);
