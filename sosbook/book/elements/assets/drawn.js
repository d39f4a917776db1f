import {buttons, clean, complex, escape, gains, PageElement, panel, panels, printed, READOUT, withConjugates} from "./kit.js";
import {add, apply, mul, pushed} from "./linalg.js";
import {Plot, S_PLANE} from "./plot.js";

const COLOURS = ["--sos-first", "--sos-second", "--sos-third", "--sos-region"];
const DASHES = ["", "7 4", "2 3", "8 3 2 3"];

// -------------------------------------------------- the linear response
// z(t) of x' = (A + B K) x + (s - B K x_r) from rest; one row an instant. What a law remembers of x_r is
// `held`.
function stepResponse({A, B, s, held = []}, K, r, horizon, steps) {
  const N = s.length, at = [...r, ...Array(N - r.length - held.length).fill(0), ...held];
  const level = apply(B, apply(K, at)), push = s.map((x, i) => x - level[i]);
  return pushed(add(A, mul(B, K)), push, horizon, steps).map(x => x.slice(0, r.length));
}

// ----------------------------------------------------------- the region
// The part of a convex polygon where a x + b y < c.
function clip(polygon, a, b, c) {
  const out = [];
  polygon.forEach((p, k) => {
    const q = polygon[(k + 1) % polygon.length];
    const f = a * p[0] + b * p[1] - c, g = a * q[0] + b * q[1] - c;
    if (f <= 0) out.push(p);
    if ((f < 0 && g > 0) || (f > 0 && g < 0)) {
      const t = f / (f - g);
      out.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
    }
  });
  return out;
}

/** @type {(asked: any, window: any) => any[]} */
function regionPolygon(asked, [left, right, height]) {
  let polygon = [[left, -height], [right, -height], [right, height], [left, height]];
  if (asked.sigma !== undefined) polygon = clip(polygon, 1, 0, -asked.sigma);
  if (asked.theta !== undefined) {
    const sin = Math.sin(asked.theta), cos = Math.cos(asked.theta);
    polygon = clip(clip(polygon, sin, cos, 0), sin, -cos, 0);
  }
  if (asked.rho !== undefined) {
    for (let k = 0; k < 120; k++) {
      const angle = k * Math.PI / 60;
      polygon = clip(polygon, Math.cos(angle), Math.sin(angle), asked.rho);
    }
  }
  return polygon;
}

// ---------------------------------------------------------- the element
// A design drawn: its poles over what is asked, its response, its numbers.
export class DesignElement extends PageElement {
  get captions() { return ["Closed-loop poles over the region that was asked for.", this.data.caption]; }
  markup() {
    const [map, step] = this.captions;
    return panels(panel("map", map) + panel("step", escape(step))) + READOUT + buttons(this.buttons);
  }

  // What is asked and found is a subclass's.
  /** @returns {any} */
  get design() { return null; }
  get buttons() { return []; }

  // A pole's mark, its number and the curve by which it decays belong together.
  listen() {
    this.view.addEventListener(
      "pointerover", event => this.light(event.target.closest("[data-pole]")?.dataset.pole));
  }

  light(k) {
    if (k === this.lit) return;
    this.lit = k;
    this.view.querySelectorAll("[data-pole]")
      .forEach(part => part.classList.toggle("sos-lit", part.dataset.pole === k));
    this.find("step").querySelector(".sos-mode")?.remove();
    const pole = this.design.poles?.[k];
    if (pole) this.find("step").querySelector("svg").insertAdjacentHTML("beforeend", this.mode(pole));
  }

  // The envelope of a pole's part of the response, and what the pole means.
  /** @param {any} pole */
  mode([re, im]) {
    const {horizon, r} = this.data, plot = this.stepPlot;
    const times = Array.from({length: 61}, (_, k) => k * horizon / 60);
    const ends = [...new Set(r.filter(x => x))].flatMap(
      x => [x, -x].map(side => times.map(t => [t, x - side * Math.exp(re * t)])));
    const swings = im ? `, ω = ${clean(im)} rad/s, ζ = ${clean(-re / Math.hypot(re, im), 2)}` : "";
    return `<g class="sos-mode">` +
      ends.map(points => `<path d="${plot.path(points.filter(p => plot.has(p)))}"/>`).join("") +
      `<text x="${plot.r - 4}" y="${plot.t + 12}" text-anchor="end">decays by e in ${clean(-1 / re)} s${
        swings}</text></g>`;
  }

  // Axes of the same scale that hold the window.
  poleAxes() {
    const [left, right, height] = this.data.window, middle = (left + right) / 2, shape = 288 / 286;
    const half = Math.max(right - left, 2 * height / shape) / 2, tall = half * shape;
    return new Plot({x: [middle - half, middle + half], y: [-tall, tall], labels: S_PLANE});
  }

  // Where the coordinates shall go.
  get targets() { return this.data.r; }

  // What a subclass draws over the poles and over the response.
  overPoles(_plot) {}
  overResponse(_plot) {}

  /** @param {any} design */
  map({status, asked, poles}) {
    const plot = this.poleAxes(), {x, y} = plot, polygon = regionPolygon(asked, [...x, y[1]]);
    const style = plot.hatch(`${this.name}-hatch`);
    if (polygon.length) {
      plot.body += `<path class="sos-region${poles ? "" : " sos-empty"}" ${poles ? "" : style} d="${
        plot.path(polygon)}Z"/>`;
    }
    plot.rule("sos-axis", x, [0, 0]);
    if (x[0] < 0 && x[1] > 0) plot.rule("sos-axis", [0, 0], y);
    (poles || []).forEach((pole, k) => {
      for (const [re, im] of withConjugates([pole]).filter(pole => plot.has(pole))) {
        const [x, y] = [plot.X(re), plot.Y(im)];
        plot.body += `<path class="sos-pole" data-pole="${k}" d="M${x - 4} ${y - 4}l8 8m0 -8l-8 8"/>` +
          `<circle class="sos-hit" data-pole="${k}" cx="${x}" cy="${y}" r="9"/>`;
      }
    });
    if (!poles) plot.absent(status, 40);
    this.overPoles(plot);
    return plot.svg(poles
        ? `Pole map: poles at ${poles.map(p => complex(p[0], p[1])).join(", ")}, all in the shaded region.`
        : `Pole map: the region is hatched, because no design is known (${status}).`);
  }

  step({status, K}) {
    const {horizon, r, vertices} = this.data, steps = 150, labels = ["time t (s)", "position z"];
    const all = K ? vertices.map(v => stepResponse(v, K, r, horizon, steps)) : [];
    this.response = all;
    const values = all.flat(2), low = Math.min(-0.2, ...values), high = Math.max(1.4, ...values);
    const limits = K ? [Math.floor(low * 5 + 1e-9) / 5, Math.ceil(high * 5 - 1e-9) / 5] : [low, high];
    const plot = this.stepPlot = new Plot({x: [0, horizon], y: limits, labels});
    if (!K) {
      plot.absent("no design", 40);
      return plot.svg(`Step response: none, ${status}.`);
    }
    for (const target of new Set(this.targets)) plot.rule("sos-target", [0, horizon], [target, target]);
    for (const rows of all) {
      r.forEach((_, i) => plot.line(
                  rows.map((row, k) => [k * horizon / steps, row[i]]), COLOURS[i % 4], DASHES[i % 4]));
    }
    r.forEach((_, i) => {
      const u = plot.r - 52 * (r.length - i), v = plot.b - 12;
      plot.body +=
        `<line class="sos-line" style="stroke:var(${COLOURS[i % 4]})" stroke-dasharray="${DASHES[i % 4]}"` +
        ` x1="${u}" x2="${u + 24}" y1="${v}" y2="${v}"/><text x="${u + 28}" y="${v + 4}">z${
                                                                                      "₁₂₃₄₅₆₇₈₉"[i]}</text>`;
    });
    this.overResponse(plot);
    const peaks = r.map((_, i) => `z${i + 1} peaks at ${clean(Math.max(...all.flat().map(row => row[i])))}`);
    return plot.svg(`Step response over ${clean(horizon)} seconds: ${peaks.join(", ")}.`);
  }

  // A gain and what is true of it.
  gains({asked, K, poles, norm, peak, cost = null, margin = null, own = null}) {
    const bounds = [
      ["True H∞ norm", norm, "γ", asked.gamma], ["Largest ‖u‖ from x(0):", peak, "u_max", asked.u_max],
      ["True cost", cost, "J", asked.cost]
    ];
    const truth = bounds.filter(([, x]) => x !== null).map(([name, x, symbol,
      bound]) => `${name} ${clean(x, 4)}${bound ? ` (bound ${symbol} = ${clean(bound, 4)})` : ""}.`);
    const shown = own ?? {K, shape: this.data.shape};
    return gains(shown.K, shown.shape, 5) +
      `<p>Poles: ${
        poles.map((p, k) => `<span class="sos-number" data-pole="${k}">${complex(p[0], p[1])}</span>`)
          .join(", ")}.</p>` +
      `<p>${margin ? `Smallest margin: ${clean(margin[1], 2)} (${escape(printed(margin[0]))}). ` : ""}${
        printed(truth.join(" "))}</p>`;
  }
}
