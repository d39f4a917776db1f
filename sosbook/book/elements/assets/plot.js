// A plot: axes with their ticks, and what is drawn in them.
import {clean, escape, round} from "./kit.js";

export const S_PLANE = ["Re s (s⁻¹)", "Im s (rad/s)"];  // names of axes

function linearTicks(low, high) {
  const raw = (high - low) / 5, size = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find(k => k * size >= raw * 0.999) * size, list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(k * step);
  return list;
}

// 1, 2, 5 times powers of ten; every step where these are too few.
function logarithmicTicks(low, high) {
  for (const steps of [[1], [1, 2, 5], [1, 1.5, 2, 3, 4, 5, 7],
         [1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8, 9]]) {
    const list = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++) {
      list.push(...steps.map(s => s * 10 ** e).filter(v => v >= low * 0.9999 && v <= high * 1.0001));
    }
    if (list.length >= 3) return list.length > 8 ? list.filter((_, k) => k % 2 === 0) : list;
  }
  return [low, high];
}

// Grid lines with their numbers, and an axis title that reads upwards.
const column = ([t, b], u, text) => `<line class="sos-grid" x1="${u}" x2="${u}" y1="${t}" y2="${b}"/>` +
  `<text x="${Math.min(u, round(338 - 3.6 * text.length))}" y="${b + 16}" text-anchor="middle">${
    text}</text>`;
export const row = ([l, r], v, text) => `<line class="sos-grid" x1="${l}" x2="${r}" y1="${v}" y2="${v}"/>` +
  `<text x="${l - 6}" y="${v + 4}" text-anchor="end">${text}</text>`;
export const upright = ([t, b], label) =>
  `<text transform="translate(11 ${(t + b) / 2}) rotate(-90)" text-anchor="middle">${escape(label)}</text>`;

// A picture for eyes and, by its label, for screen readers.
export const picture = (height, label, body) =>
  `<svg role="img" viewBox="0 0 340 ${height}" aria-label="${escape(label)}">${body}</svg>`;

// A spring from one point to another.
export function spring([x0, y0], [x1, y1], wide = 6) {
  const far = Math.hypot(x1 - x0, y1 - y0) || 1;
  const at = (part, side) => `${round(x0 + part * (x1 - x0) + side * wide * (y0 - y1) / far)} ${
    round(y0 + part * (y1 - y0) + side * wide * (x1 - x0) / far)}`;
  const turns = Array.from({length: 7}, (_, i) => `L${at((i + 1) / 8, i % 2 ? 1 : -1)}`);
  return `M${at(0, 0)}${turns.join("")}L${at(1, 0)}`;
}

// A bar that stands on a line, or hangs from it, as high as its value.
export const bar = (x, width, line, value, colour) =>
  `<rect x="${x}" y="${round(line - Math.max(0, value))}" width="${width}" height="${
    round(Math.abs(value))}" style="fill:var(${colour})"/>`;

// Axes in a viewBox that is 340 wide; what is drawn joins `body`. Where the
// axes are logarithmic, what lies above or below is drawn on the edge.
export class Plot {
  constructor({x, y, labels, box = [46, 332, 10, 298], height = 340, logarithmic = false}) {
    const [l, r, t, b] = box, ticks = logarithmic ? logarithmicTicks : linearTicks;
    const digits = logarithmic ? 3 : 6;
    const part = logarithmic ? (v, [low, high]) => Math.log(v / low) / Math.log(high / low)
                             : (v, [low, high]) => (v - low) / (high - low);
    /** @type {string[]} */
    this.said = [];  // what the lines do, for those who don't see them
    this.x = x;
    this.y = y;
    this.l = l;
    this.r = r;
    this.t = t;
    this.b = b;
    this.height = height;
    this.X = v => round(l + part(v, x) * (r - l));
    this.Y = v => {
      const at = b - part(v, y) * (b - t);
      return round(logarithmic ? Math.max(t, Math.min(b, at)) : at);
    };
    this.body = ticks(...x).map(v => column([t, b], this.X(v), clean(v, digits))).join("") +
      ticks(...y).map(v => row([l, r], this.Y(v), clean(v, digits))).join("") +
      `<text x="${(l + r) / 2}" y="${height - 8}" text-anchor="middle">${escape(labels[0])}</text>` +
      upright([t, b], labels[1]);
  }

  // What a place of the picture means on linear axes.
  at({x, y}) {
    const along = (part, [low, high]) => low + part * (high - low);
    return [along((x - this.l) / (this.r - this.l), this.x), along((this.b - y) / (this.b - this.t), this.y)];
  }

  /** @param {any} point */
  has([u, v]) { return u >= this.x[0] && u <= this.x[1] && v >= this.y[0] && v <= this.y[1]; }
  path(points) { return points.map(([u, v], k) => `${k ? "L" : "M"}${this.X(u)} ${this.Y(v)}`).join(""); }

  line(points, colour, dash = "", kind = "") {
    const all = points.map(p => p[1]), ends = [all[0], all.at(-1)];
    const [low, high] = [Math.min(...all), Math.max(...all)];
    if (!kind.includes("ghost") && all.length)
      this.said.push(
        `from ${ends.map(v => clean(v)).join(" to ")}, between ${clean(low)} and ${clean(high)}`);
    this.body += `<path class="sos-line${kind}" style="stroke:var(${colour})" stroke-dasharray="${dash}" d="${
      this.path(points)}"/>`;
  }

  rule(kind, [u0, u1], [v0, v1]) {
    this.body +=
      `<line class="${kind}" x1="${this.X(u0)}" x2="${this.X(u1)}" y1="${this.Y(v0)}" y2="${this.Y(v1)}"/>`;
  }

  // The style of an area hatched with the pattern of this name.
  hatch(name) {
    this.body += `<defs><pattern id="${name}" width="9" height="9" patternUnits="userSpaceOnUse" ` +
      `patternTransform="rotate(45)"><line class="sos-hatch" x1="0" y1="0" x2="0" y2="9"/></pattern></defs>`;
    return `style="fill:url(#${name})"`;
  }

  absent(text, y) {
    this.body +=
      `<text class="sos-no" x="${(this.l + this.r) / 2}" y="${y}" text-anchor="middle">${text}</text>`;
  }

  svg(label) { return picture(this.height, label, this.body); }
}

// A mark of one of four shapes: cross, circle, square, plus.
const SHAPES =
  ["M-4-4L4 4M-4 4L4-4", "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0", "M-3.5-3.5h7v7h-7z", "M-5 0H5M0-5V5"];
export const mark = (plot, [x, y], colour, shape = 0, more = "") => {
  plot.body += `<path class="sos-pole" style="stroke:var(${colour});${more}" transform="translate(${
    plot.X(x)} ${plot.Y(y)})" d="${SHAPES[shape]}"/>`;
};
// Crosses at the points that a plot holds; those of the ghost are pale.
export const markAll = (plot, ghost, points) => {
  for (const [list, more] of [[ghost ?? [], "opacity:.3"], [points, ""]])
    list.filter(p => plot.has(p)).forEach(p => mark(plot, p, "--sos-first", 0, more));
};
