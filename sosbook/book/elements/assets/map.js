import {clean, define, escape, gainRows, gains, nearest, printed} from "./kit.js";
import {Mover} from "./mover.js";
import {Plot} from "./plot.js";
import * as python from "./program.js";

class FeasibilityMap extends Mover {
  figures = {plot: ""};

  // Plants, their maps, and the axes of one.
  get controls() {
    const {groups} = this.data, {x, y, asked} = this.map;
    const axis = (key, {label, unit, values}, k) =>
      ({key, label: printed(label), unit: printed(unit), values, start: values[nearest(values, asked[k])]});
    const pairs = this.group.maps.map(({x, y}) => printed(`${x.symbol} and ${y.symbol}`));
    return [
      {key: "group", label: "Plant", names: groups.map(({name}) => name), start: 0},
      {key: "pair", label: "Requirements", names: pairs, start: 0}, axis("x", x, 0), axis("y", y, 1)
    ];
  }
  get group() { return this.data.groups[this.stands?.group ?? 0]; }
  get map() { return this.group.maps[this.stands?.pair ?? 0]; }
  get means() { return "a design is certified"; }
  probe(place) { return this.verdict(this.index(place)).status === "feasible"; }

  // Another map begins where its designs were asked for.
  /** @param {any} to */
  reset({group, pair, ...to} = {}) {
    this.stands = {};
    for (const [key, value, list] of [["group", group, this.data.groups], ["pair", pair, null]])
      this.stands[key] = (list ?? this.group.maps)[value] ? Number(value) : 0;
    const {x, y} = this.map;
    this.says = printed(`For {group}, the map of {pair} asks for ${x.symbol} = {x} and ${y.symbol} = {y}.`);
    super.reset({...this.stands, ...to});
    if (this.longest) this.reserve();
  }
  choose(at, key) {
    this.reset({...this.stands, ...(key === "group" && {pair: 0}), x: "", y: "", [key]: at});
  }

  get buttons() { return [...super.buttons, ["python", "As Python"]]; }
  get program() {
    const {x, y, bounds, program} = this.map, at = this.stands;
    return python.design(program, {...bounds, [x.key]: at.x, [y.key]: at.y});
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

  // Where a place lies on the grid.
  /** @returns {[number, number]} */
  index({x, y}) { return [this.map.x.values.indexOf(x), this.map.y.values.indexOf(y)]; }
  compute(place) { return this.verdict(this.index(place)); }

  show(verdict, _ghost, place) {
    this.find("plot").innerHTML = this.plotted(verdict, this.index(place));
    this.find("caption").textContent =
      `Shaded: a certified design. Hatched: proven infeasible. Blank: between the proofs. Diamond: what was asked. Held: ${
        printed(this.map.held.join(", ")) || "nothing else"}.`;
    this.tell(verdict.status, ...this.told(verdict));
  }

  plotted(verdict, [i, j]) {
    const {x, y, rows, asked} = this.map;
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

  said() {
    const {x, y} = this.map, all = x.values.flatMap((_, i) => y.values.map((_, j) => [i, j]));
    return all.map(at => this.told(this.verdict(at)));
  }

  told({status, kept}) {
    const {shape} = this.map;
    const word = {feasible: "Certified", infeasible: "Excluded", undecided: "Undecided"}[status];
    if (status === "undecided")
      return [
        `${word}.`,
        "<p>Neither a certified design nor a proof that there is none is stored for this point.</p>"
      ];
    if (status === "feasible")
      return [
        `${word}.`,
        `<p>This design, certified for ${escape(kept.asked)}, keeps it; its tightest block is ${
          escape(this.data.blocks[kept.block])}.</p>${gains(gainRows(kept.K, shape), shape, 4)}`
      ];
    const bars = kept.shares
                   .map(([name, share]) => `<li><span class="sos-bar" style="width:${5 * share}em"></span>` +
                       `${escape(name)}: ${Math.round(100 * share)} %</li>`)
                   .join("");
    return [
      `${word}.`,
      `<p>Exact multipliers: no design for ${escape(kept.asked)}, nor for more.</p>` +
        (bars &&
          `<p>What relaxing each by the same small factor would bring:</p><ul class="sos-shares">${
            bars}</ul>`)
    ];
  }
}

define("sos-map", FeasibilityMap);
