(() => {
  "use strict";
  const COLOURS = ["--sos-first", "--sos-second", "--sos-third", "--sos-region"];
  const DASHES = ["", "7 4", "2 3", "8 3 2 3"];
  let count = 0;

  // ------------------------------------------------------------- numbers
  const clean = (x, digits = 3) => {
    const text = String(Number(Number(x).toPrecision(digits)));
    return (text === "-0" ? "0" : text).replace("-", "−");
  };
  const round = x => Math.round(x * 10) / 10 + 0;
  const escape = text => String(text).replace(/[&<>"]/g, c =>
    ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
  const complex = (re, im) => im === 0 ? clean(re)
    : `${clean(re)} ± ${clean(im)}j`;

  function ticks(low, high, wanted) {
    const raw = (high - low) / wanted, size = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find(k => k * size >= raw * 0.999) * size;
    const list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
      list.push(k * step);
    }
    return list;
  }

  // -------------------------------------------------- the linear response
  const times = (X, Y) => X.map(row => Y[0].map((_, j) =>
    row.reduce((sum, x, k) => sum + x * Y[k][j], 0)));

  // exp(X h) by scaling, a Taylor polynomial, and squaring.
  function exponential(X, h) {
    const size = Math.max(...X.map(row =>
      row.reduce((sum, x) => sum + Math.abs(x), 0))) * h;
    const halvings = Math.max(0, Math.ceil(Math.log2(size || 1)) + 2);
    const small = X.map(row => row.map(x => x * h / 2 ** halvings));
    let term = X.map((row, i) => row.map((_, j) => +(i === j)));
    let sum = term;
    for (let k = 1; k <= 14; k++) {
      term = times(term, small).map(row => row.map(x => x / k));
      sum = sum.map((row, i) => row.map((x, j) => x + term[i][j]));
    }
    for (let k = 0; k < halvings; k++) sum = times(sum, sum);
    return sum;
  }

  // z(t) of x' = (A + B K) x + (s - B K_P r) from rest; one row an instant.
  function stepResponse(vertex, K, r, horizon, steps) {
    const {A, B, s} = vertex, n = r.length;
    const rate = A.map((row, i) => [
      ...row.map((a, j) => a + B[i].reduce((sum, b, k) => sum + b * K[k][j], 0)),
      s[i] - B[i].reduce((sum, b, k) =>
        sum + b * r.reduce((inner, x, j) => inner + K[k][j] * x, 0), 0),
    ]);
    rate.push(new Array(A.length + 1).fill(0));
    const forward = exponential(rate, horizon / steps);
    let x = rate.map((_, i) => [+(i === A.length)]);
    const rows = [];
    for (let k = 0; k <= steps; k++) {
      rows.push(x.slice(0, n).map(value => value[0]));
      x = times(forward, x);
    }
    return rows;
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

  // ------------------------------------------------------------- drawing
  // Axes in a 340 x 340 viewBox; returns the mapping and the grid.
  function frame(x, y, xlabel, ylabel) {
    const [l, r, t, b] = [46, 332, 10, 298];
    const X = v => l + (v - x[0]) / (x[1] - x[0]) * (r - l);
    const Y = v => b - (v - y[0]) / (y[1] - y[0]) * (b - t);
    let grid = "";
    for (const v of ticks(x[0], x[1], 5)) {
      grid += `<line class="sos-grid" x1="${round(X(v))}" x2="${round(X(v))}" y1="${t}" y2="${b}"/>` +
        `<text x="${round(X(v))}" y="${b + 16}" text-anchor="middle">${clean(v, 6)}</text>`;
    }
    for (const v of ticks(y[0], y[1], 5)) {
      grid += `<line class="sos-grid" x1="${l}" x2="${r}" y1="${round(Y(v))}" y2="${round(Y(v))}"/>` +
        `<text x="${l - 6}" y="${round(Y(v)) + 4}" text-anchor="end">${clean(v, 6)}</text>`;
    }
    grid += `<text x="${(l + r) / 2}" y="332" text-anchor="middle">${xlabel}</text>` +
      `<text transform="translate(11 ${(t + b) / 2}) rotate(-90)" text-anchor="middle">${ylabel}</text>`;
    const path = points => points.map(([u, v], k) =>
      `${k ? "L" : "M"}${round(X(u))} ${round(Y(v))}`).join("");
    return {X, Y, grid, path, l, r, t, b};
  }

  class Atlas extends HTMLElement {
    connectedCallback() { this.start(); }

    // The parser may create the element before its data: see the last lines.
    start() {
      const source = this.querySelector("script[type='application/json']");
      if (this.started || !source) return;
      this.started = true;
      this.data = JSON.parse(source.textContent);
      this.name = `sos-atlas-${++count}`;
      while (document.getElementById(`${this.name}-0`)) this.name = `sos-atlas-${++count}`;
      this.place = [...this.data.start];
      this.view = document.createElement("div");
      this.view.innerHTML =
        `<p class="sos-title">${escape(this.data.title)}</p>` +
        `<div class="sos-sliders" role="group" aria-label="Requirements">` +
        this.data.sliders.map((slider, k) => this.sliderMarkup(slider, k)).join("") +
        `</div><div class="sos-panels"><figure class="sos-panel"><div class="sos-map"></div>` +
        `<figcaption class="sos-caption">Closed-loop poles over the region that was asked for.</figcaption></figure>` +
        `<figure class="sos-panel"><div class="sos-step"></div><figcaption class="sos-caption">${escape(this.data.caption)}` +
        `</figcaption></figure></div>` +
        `<div class="sos-readout" role="status" aria-live="polite" aria-atomic="true"></div>`;
      this.append(this.view);
      this.view.querySelectorAll("input").forEach((input, k) =>
        input.addEventListener("input", () => {
          this.place[k] = Number(input.value);
          this.update();
        }));
      this.update();
    }

    sliderMarkup(slider, k) {
      const id = `${this.name}-${k}`;
      return `<div class="sos-slider"><label for="${id}"><span>${escape(slider.label)}</span>` +
        `<output for="${id}"></output></label>` +
        `<input id="${id}" type="range" min="0" max="${slider.values.length - 1}" step="1"` +
        ` value="${this.place[k]}" data-key="${escape(slider.key)}" autocomplete="off"` +
        ` data-lm-suppress-shortcuts="true"></div>`;
    }

    index(place) {
      return place.reduce((sum, at, k) => sum * this.data.sliders[k].values.length + at, 0);
    }

    // 0 is infeasible, 1 undecided, everything else a design.
    stored(place = this.place) { return this.data.designs[this.index(place)]; }

    get design() {
      const found = this.stored(), [n, m, a] = this.data.shape, N = 2 * n + a;
      const asked = {...this.data.fixed};
      this.data.sliders.forEach((slider, k) => { asked[slider.key] = slider.values[this.place[k]]; });
      if (typeof found === "number") {
        return {status: ["infeasible", "undecided"][found], asked};
      }
      const [gain, poles, [block, margin], norm, peak] = found;
      const K = Array.from({length: m}, (_, i) => gain.slice(i * N, (i + 1) * N));
      const pairs = [];
      for (let k = 0; k < poles.length; k += 2) pairs.push([poles[k], poles[k + 1]]);
      return {status: "feasible", asked, K, poles: pairs,
        margin: [this.data.blocks[block], margin], norm, peak};
    }

    // Designs that a move of one slider reaches, the nearest first.
    relaxations() {
      const found = [];
      this.data.sliders.forEach((slider, k) => {
        for (let far = 1; far < slider.values.length; far++) {
          const at = this.place[k] + far * slider.looser;
          if (at < 0 || at >= slider.values.length) break;
          const place = this.place.map((old, j) => j === k ? at : old);
          if (typeof this.stored(place) !== "number") {
            found.push({far, text: slider.texts[at], share: far / slider.values.length});
            break;
          }
        }
      });
      return found.sort((p, q) => p.far - q.far || p.share - q.share);
    }

    advice() {
      const [first, ...others] = this.relaxations();
      if (first) {
        return `Relax first: ${first.text}.` + (others.length
          ? ` Moving one other slider would do as well: ${others.map(o => o.text).join("; or ")}.` : "");
      }
      let best = null;
      const walk = (place, k, far) => {
        if (best && far >= best.far) return;
        if (k === place.length) {
          if (typeof this.stored(place) !== "number") best = {far, place: [...place]};
          return;
        }
        const {values, looser} = this.data.sliders[k];
        for (let d = 0; d < values.length; d++) {
          const at = this.place[k] + d * looser;
          if (at < 0 || at >= values.length) break;
          walk([...place.slice(0, k), at, ...place.slice(k + 1)], k + 1, far + d);
        }
      };
      walk([...this.place], 0, 0);
      if (!best) return "No design on these sliders is looser and feasible.";
      const moves = this.data.sliders.filter((_, k) => best.place[k] !== this.place[k])
        .map(slider => slider.texts[best.place[this.data.sliders.indexOf(slider)]]);
      return `No single slider is enough. Relax together: ${moves.join(" and ")}.`;
    }

    update() {
      const design = this.design;
      this.view.querySelectorAll("input").forEach((input, k) => {
        const text = this.data.sliders[k].texts[this.place[k]];
        input.setAttribute("aria-valuetext", text);
        input.parentElement.querySelector("output").textContent = text;
      });
      this.view.querySelector(".sos-map").innerHTML = this.map(design);
      this.view.querySelector(".sos-step").innerHTML = this.step(design);
      const readout = this.view.querySelector(".sos-readout");
      readout.className = `sos-readout sos-${design.status}`;
      readout.innerHTML = this.readout(design);
    }

    map(design) {
      const [left, right, height] = this.data.window;
      const middle = (left + right) / 2, half = Math.max(right - left, 2 * height * 286 / 288) / 2;
      const tall = half * 288 / 286;
      const x = [middle - half, middle + half], y = [-tall, tall];
      const f = frame(x, y, "Re s (1/s)", "Im s (rad/s)");
      const polygon = regionPolygon(design.asked, [x[0], x[1], tall]);
      const inside = design.status === "feasible";
      const area = polygon.length ? f.path(polygon) + "Z" : "";
      const marks = (design.poles || []).flatMap(([re, im]) => im ? [[re, im], [re, -im]] : [[re, im]])
        .filter(([re, im]) => re >= x[0] && re <= x[1] && Math.abs(im) <= tall)
        .map(([re, im]) => {
          const [u, v] = [round(f.X(re)), round(f.Y(im))];
          return `<path class="sos-pole" d="M${u - 4} ${v - 4}l8 8m0 -8l-8 8"/>`;
        }).join("");
      const label = inside
        ? `Pole map: poles at ${design.poles.map(p => complex(...p)).join(", ")}, all in the shaded region.`
        : `Pole map: the region is hatched, because no design is known (${design.status}).`;
      return `<svg role="img" viewBox="0 0 340 340" aria-label="${escape(label)}"><defs>` +
        `<pattern id="${this.name}-hatch" width="9" height="9" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">` +
        `<line class="sos-hatch" x1="0" y1="0" x2="0" y2="9"/></pattern></defs>${f.grid}` +
        (area ? `<path class="sos-region${inside ? "" : " sos-empty"}" d="${area}"` +
          (inside ? "" : ` style="fill:url(#${this.name}-hatch)"`) + "/>" : "") +
        `<line class="sos-axis" x1="${f.l}" x2="${f.r}" y1="${round(f.Y(0))}" y2="${round(f.Y(0))}"/>` +
        (x[0] < 0 && x[1] > 0 ? `<line class="sos-axis" x1="${round(f.X(0))}" x2="${round(f.X(0))}" y1="${f.t}" y2="${f.b}"/>` : "") +
        marks + (inside ? "" : `<text class="sos-no" x="${(f.l + f.r) / 2}" y="40" text-anchor="middle">${design.status}</text>`) +
        "</svg>";
    }

    step(design) {
      const {horizon, r, vertices} = this.data;
      this.response = [];
      if (design.status !== "feasible") {
        const f = frame([0, horizon], [-0.2, 1.4], "time t (s)", "position z");
        return `<svg role="img" viewBox="0 0 340 340" aria-label="Step response: none, ${design.status}.">` +
          `${f.grid}<text class="sos-no" x="${(f.l + f.r) / 2}" y="40" text-anchor="middle">no design</text></svg>`;
      }
      const steps = 150, all = vertices.map(v => stepResponse(v, design.K, r, horizon, steps));
      this.response = all;
      const values = all.flat(2), low = Math.min(-0.2, ...values), high = Math.max(1.4, ...values);
      const snap = (v, up) => (up ? Math.ceil : Math.floor)(v * 5 - (up ? 1e-9 : -1e-9)) / 5;
      const f = frame([0, horizon], [snap(low, false), snap(high, true)], "time t (s)", "position z");
      const lines = all.flatMap(rows => r.map((_, i) =>
        `<path class="sos-line" style="stroke:var(${COLOURS[i % 4]})" stroke-dasharray="${DASHES[i % 4]}"` +
        ` d="${f.path(rows.map((row, k) => [k * horizon / steps, row[i]]))}"/>`)).join("");
      const targets = [...new Set(r)].map(v => `<line class="sos-target" x1="${f.l}" x2="${f.r}"` +
        ` y1="${round(f.Y(v))}" y2="${round(f.Y(v))}"/>`).join("");
      const key = r.map((_, i) => {
        const u = f.r - 52 * (r.length - i);
        return `<line class="sos-line" style="stroke:var(${COLOURS[i % 4]})" stroke-dasharray="${DASHES[i % 4]}"` +
          ` x1="${u}" x2="${u + 24}" y1="${f.b - 12}" y2="${f.b - 12}"/><text x="${u + 28}" y="${f.b - 8}">z${"₁₂₃₄₅₆₇₈₉"[i]}</text>`;
      }).join("");
      const peaks = r.map((_, i) => `z${i + 1} peaks at ${clean(Math.max(...all.flat().map(row => row[i])))}`);
      return `<svg role="img" viewBox="0 0 340 340" aria-label="Step response over ${clean(horizon)} seconds: ` +
        `${peaks.join(", ")}.">${f.grid}${targets}${lines}${key}</svg>`;
    }

    readout(design) {
      const texts = this.data.sliders.map((slider, k) => slider.texts[this.place[k]]);
      const asked = [...texts, ...this.data.also].join(", ");
      const head = `<p><span class="sos-status">${design.status[0].toUpperCase()}${design.status.slice(1)}</span>` +
        ` for ${escape(asked)}.</p>`;
      if (design.status === "undecided") {
        return head + `<p>Neither a design nor a proof that there is none was found.</p>`;
      }
      if (design.status === "infeasible") {
        const empty = design.asked.rho <= design.asked.sigma;
        return head + `<p>${empty ? "The region is empty." : "These LMIs have no solution."} ${escape(this.advice())}</p>`;
      }
      const [n, , a] = this.data.shape;
      const parts = [["P", 0, n], ["D", n, 2 * n], ["I", 2 * n, 2 * n + a]].filter(p => p[2] > p[1]);
      const gains = parts.map(([name, from, to]) =>
        `<span class="sos-gain"><span>K<sub>${name}</sub> =</span> <span class="sos-matrix" style="grid-template-columns:repeat(${to - from},auto)">` +
        design.K.flatMap(row => row.slice(from, to)).map(x => `<span>${clean(x, 5)}</span>`).join(" ") + `</span></span>`).join(" ");
      const poles = design.poles.map(p => `<span class="sos-number">${complex(...p)}</span>`).join(", ");
      const [block, margin] = design.margin;
      const truth = [];
      if (design.norm !== null) truth.push(`True H∞ norm ${clean(design.norm)}` +
        (design.asked.gamma ? ` (bound γ = ${clean(design.asked.gamma, 4)}).` : "."));
      if (design.peak !== null) truth.push(`Largest ‖u‖ from x(0): ${clean(design.peak)}` +
        (design.asked.u_max ? ` (bound ${clean(design.asked.u_max, 4)}).` : "."));
      return head + `<div class="sos-gains">${gains}</div><p>Poles: ${poles}.</p>` +
        `<p>Smallest margin: ${clean(margin, 2)} (${escape(block)}). ${truth.join(" ")}</p>`;
    }
  }

  if (!customElements.get("sos-atlas")) customElements.define("sos-atlas", Atlas);
  document.querySelectorAll("sos-atlas").forEach(atlas => atlas.start && atlas.start());
})();
