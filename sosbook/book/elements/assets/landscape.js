// The largest real part of a loop's poles over two gains: a gain that is dragged, and
// the descents from there and from many starts. All of it in floats.
import {descend} from "../../kernel/descent.js";

import {clean, define, uniform} from "./kit.js";
import {combine, eigenvalues, rightmost} from "./linalg.js";
import {Mover, number, range} from "./mover.js";
import {mark, Plot} from "./plot.js";

const GRID = 48;                                          // squares a side of the map
const LINES = [-0.2, -0.15, -0.1, -0.05, 0.1, 0.2, 0.4];  // 1/s, of the contours besides zero
const STARTS = 16, STEPS = 80;                            // of the descents
const NEAR = 1e-5;                                        // of differences, in parts of the map
const WALL = 30;    // of a gain's way beyond the map, which is its limit
const SAME = 0.01;  // 1/s and parts of the map: two ends are one minimum
const SURE = 1e-9;  // 1/s: less than that to the left says nothing

class Landscape extends Mover {
  figures = {
    map:
      "Contours of the largest real part; drag the round handle. Filled: stable. Line: the descent from there; crosses: where descents end.",
    cut: "The same function on two lines through the handle: to the right (first) and upwards (second)."
  };

  // From the map's parts of one to gains.
  gain(part) { return part.map((t, k) => this.ends[k][0] + t * (this.ends[k][1] - this.ends[k][0])); }

  poles(part) {
    const [x, y] = this.gain(part);
    return eigenvalues(combine(1, combine(1, this.base, x, this.data.ways[0]), y, this.data.ways[1]));
  }

  // With a wall at the map's edges.
  height(part) {
    const over = part.reduce((sum, t) => sum + Math.max(0, -t, t - 1), 0);
    return rightmost(this.poles(part)) + WALL * over;
  }

  slope(part) {
    return [0, 1].map(k => {
      const [up, down] = [1, -1].map(way => this.height(part.map((t, j) => j === k ? t + way * NEAR : t)));
      return (up - down) / (2 * NEAR);
    });
  }

  descent(start) { return descend(part => [this.height(part), () => this.slope(part)], start, STEPS); }

  compute(place) {
    const {x, y, many} = place;
    this.ends = this.data.ends;
    this.base = this.data.others.reduce((A, {key, part}) => combine(1, A, place[key], part), this.data.A);
    const here = [x, y].map((v, k) => (v - this.ends[k][0]) / (this.ends[k][1] - this.ends[k][0]));
    const random = uniform(7);
    // Of all sizes down to a thirtieth of the map's, as the package has them.
    const part = ([low, high]) => {
      const gain = (random() < 0.5 ? low : high) * 10 ** (-1.5 * random());
      return (gain - low) / (high - low);
    };
    const starts = Array.from({length: many ? STARTS : 0}, () => this.ends.map(part));
    const own = this.descent(here), runs = starts.map(start => this.descent(start)), minima = [];
    for (const {end, value} of runs) {
      const same = minima.find(m => Math.abs(m.value - value) < SAME &&
          Math.hypot(m.end[0] - end[0], m.end[1] - end[1]) < 10 * SAME);
      if (same) same.count++;
      else minima.push({end, value, count: 1});
    }
    minima.sort((a, b) => a.value - b.value);
    const gains = part => this.gain(part), right = this.height(here), {value} = own;
    const [path, ...others] = [own, ...runs].map(run => run.path.map(gains));
    const best = minima.map(m => ({...m, end: gains(m.end)}));
    return {here, right, end: gains(own.end), value, path, runs: others, minima: best};
  }

  show(result, _ghost, {x, y, many}) {
    const {right, end, value, path, minima} = result, rate = v => number(v, " s⁻¹");
    const ends = minima.slice(0, 3).map(m => `${m.count} at ${number(m.value)}`).join(", ");
    const said = many
      ? `<p>${STARTS} starts end: ${ends}${minima.length > 3 ? ", others above" : ""} s⁻¹.</p>`
      : "<p>Another start may end elsewhere: look at 16.</p>";
    this.tell(right < -SURE ? "feasible" : "undecided", right < -SURE ? "Stable here." : "Not stable here.",
      `<p>Largest real part at (${number(x)}, ${number(y)}): ${rate(right)}. Descent: ${
        number(path.length - 1)} steps to (${number(end[0])}, ${number(end[1])}) with ${rate(value)}${
        value < -SURE ? ", stable" : "; none stable, which proves nothing"}.</p>` +
        said);
    this.map(result, [x, y]);
    this.cut(result);
  }

  // The function on the grid, of the present loop.
  heights() {
    const key = JSON.stringify(this.base);
    if (this.known?.key !== key) {
      const at = Array.from({length: GRID + 1},
        (_, j) => Array.from({length: GRID + 1}, (_, i) => rightmost(this.poles([i / GRID, j / GRID]))));
      this.known = {key, at};
    }
    return this.known.at;
  }

  map({path, runs, minima, end}, here) {
    const plot = new Plot({x: this.ends[0], y: this.ends[1], labels: this.data.labels}), at = this.heights();
    /** @type {(part: any) => string} */
    const place = ([u, v]) => `${plot.X(this.gain([u, v])[0])} ${plot.Y(this.gain([u, v])[1])}`;
    let filled = "";
    const lines = [0, ...LINES].map(() => "");
    for (let j = 0; j < GRID; j++)
      for (let i = 0; i < GRID; i++) {
        const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
        const sides = corners.map((c, k) => [c, corners[(k + 1) % 4]]);
        /** @type {(side: any, level: number) => any} */
        const cross = ([a, b], level) => {
          const [p, q] = [at[a[1]][a[0]] - level, at[b[1]][b[0]] - level];
          const t = p / (p - q);
          return p < 0 === q < 0 ? null : [0, 1].map(k => (a[k] + t * (b[k] - a[k])) / GRID);
        };
        const inside = sides.flatMap(side => {
          const first = at[side[0][1]][side[0][0]] < 0 ? [side[0].map(c => c / GRID)] : [];
          const point = cross(side, 0);
          return point ? [...first, point] : first;
        });
        if (inside.length) filled += `M${inside.map(place).join("L")}Z`;
        [0, ...LINES].forEach((level, k) => {
          const points = sides.map(side => cross(side, level)).filter(Boolean);
          for (let n = 0; n + 1 < points.length; n += 2)
            lines[k] += `M${place(points[n])}L${place(points[n + 1])}`;
        });
      }
    plot.body += `<path d="${filled}" style="fill:var(--sos-region);fill-opacity:.22"/>`;
    lines.forEach((d, k) => {
      plot.body += `<path d="${d}" style="fill:none;stroke:var(${
        k ? "--sos-soft" : "--sos-region"});stroke-width:${k ? 0.7 : 1.8}"/>`;
    });
    for (const run of runs) plot.line(run, "--sos-third", "", " sos-ghost");
    plot.line(path, "--sos-second");
    for (const m of minima) mark(plot, m.end, "--sos-third");
    mark(plot, end, "--sos-second", 0, "stroke-width:3");
    plot.body += `<circle class="sos-handle" cx="${plot.X(here[0])}" cy="${plot.Y(here[1])}" r="8"/>`;
    this.plot = plot;
    this.find("map").innerHTML = plot.svg(`Gains ${clean(here[0])} and ${
      clean(here[1])}; the descent ends at ${clean(end[0])} and ${clean(end[1])}`);
  }

  cut({here}) {
    const steps = Array.from({length: 121}, (_, k) => (k - 60) / 120);
    const lines = [0, 1].map(k => steps.map(t => [t, here.map((u, j) => j === k ? u + t : u)])
                               .filter(([, part]) => part[k] >= 0 && part[k] <= 1)
                               .map(([t, part]) => [t, rightmost(this.poles(part))]));
    const y = range(lines.flatMap(points => points.map(p => p[1])));
    const plot = new Plot(
      {x: [-0.5, 0.5], y, labels: ["way from the handle, in parts of the map", "largest Re s (s⁻¹)"]});
    plot.rule("sos-axis", [-0.5, 0.5], [0, 0]);
    plot.line(lines[0], "--sos-first");
    plot.line(lines[1], "--sos-second", "5 3");
    this.draw("cut", plot, "The largest real part along two lines through the handle");
  }

  wire() {
    super.wire();
    this.handles(() => ["x", "y"]);
  }
}

define("sos-landscape", Landscape);
