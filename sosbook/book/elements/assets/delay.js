(() => {
  "use strict";
  const COLOURS = ["--sos-first", "--sos-third", "--sos-second"];
  const SHAPES = ["○", "+", "✕"], DELAYS = ["shortest", "nominal", "longest"];
  const escape = text => String(text).replace(/[&<>"]/g, c =>
    ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
  const clean = (x, digits = 3) =>
    String(Number(Number(x).toPrecision(digits)) + 0).replace("-", "−");
  const round = x => Math.round(x * 10) / 10 + 0;
  const product = (X, x) => X.map(row => row.reduce((sum, a, k) => sum + a * x[k], 0));

  // The delay as a function of time, as `signal_of` has it.
  function delayOf(kind, tau, mu, [period, dwell, random]) {
    const low = tau - mu, hold = t => Math.floor(t / (dwell * tau) + 1e-9);
    return [
      () => tau,
      t => tau + mu * Math.sin(2 * Math.PI * t / (period * tau)),
      t => t - 2 * mu * Math.floor((t - low) / (2 * mu) + 1e-9),
      t => tau + (hold(t) % 2 ? mu : -mu),
      t => low + 2 * mu * random[hold(t)],
    ][mu ? kind : 0];
  }

  // x' = A x + s + B u(t - d(t)) from rest, with u = K x - K_P r from t = 0 on:
  // Runge and Kutta's method, and u on straight lines between its values.
  function simulate({A, B, s}, K, r, delay, horizon, steps) {
    const h = horizon / steps, level = product(K.map(row => row.slice(0, r.length)), r);
    const states = [A.map(() => 0)], asked = [], applied = [];
    const late = time => {
      const at = (time - delay(time)) / h, k = Math.min(Math.floor(at), asked.length - 1);
      if (at < -1e-9) return level.map(() => 0);
      if (k < 1 && asked.length < 2) return asked[0];
      const low = Math.max(Math.min(k, asked.length - 2), 0);
      return asked[low].map((u, i) => u + (at - low) * (asked[low + 1][i] - u));
    };
    for (let k = 0; k <= steps; k++) {
      const x = states[k], t = k * h;
      asked.push(product(K, x).map((u, i) => u - level[i]));
      applied.push(late(t));
      const drive = [1e-7, 0.5, 1 - 1e-7].map(part => product(B, late(t + part * h)).map((b, i) => b + s[i]));
      const rate = (point, push) => product(A, point).map((a, i) => a + push[i]);
      const ahead = (slope, part) => x.map((value, i) => value + part * h * slope[i]);
      const a = rate(x, drive[0]), b = rate(ahead(a, 0.5), drive[1]);
      const c = rate(ahead(b, 0.5), drive[1]), d = rate(ahead(c, 1), drive[2]);
      states.push(x.map((value, i) => value + h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i])));
    }
    states.pop();
    return {states, asked, applied};
  }

  function ticks(low, high) {
    const raw = (high - low) / 5, size = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find(k => k * size >= raw * 0.999) * size, list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(k * step);
    return list;
  }

  // Axes in a 340 x 340 viewBox, which draws lines and clips them.
  class Plot {
    constructor(x, y, xlabel, ylabel) {
      const [l, r, t, b] = [46, 332, 10, 298];
      this.X = v => round(l + (v - x[0]) / (x[1] - x[0]) * (r - l));
      this.Y = v => round(b - (v - y[0]) / (y[1] - y[0]) * (b - t));
      this.x = x; this.y = y;
      const grid = (u, v, across) => across
        ? `<line class="sos-grid" x1="${l}" x2="${r}" y1="${v}" y2="${v}"/><text x="${l - 6}" y="${v + 4}" text-anchor="end">`
        : `<line class="sos-grid" x1="${u}" x2="${u}" y1="${t}" y2="${b}"/><text x="${u}" y="${b + 16}" text-anchor="middle">`;
      this.body = ticks(...x).map(v => `${grid(this.X(v), 0, false)}${clean(v, 6)}</text>`).join("") +
        ticks(...y).map(v => `${grid(0, this.Y(v), true)}${clean(v, 6)}</text>`).join("") +
        `<text x="${(l + r) / 2}" y="332" text-anchor="middle">${xlabel}</text>` +
        `<text transform="translate(11 ${(t + b) / 2}) rotate(-90)" text-anchor="middle">${ylabel}</text>`;
    }

    has(u, v) { return u >= this.x[0] && u <= this.x[1] && v >= this.y[0] && v <= this.y[1]; }

    line(points, colour, dash = "") {
      const path = points.map(([u, v], k) => `${k ? "L" : "M"}${this.X(u)} ${this.Y(v)}`).join("");
      this.body += `<path class="sos-line" style="stroke:var(${colour})" stroke-dasharray="${dash}" d="${path}"/>`;
    }

    rule(u, v, name) {
      this.body += `<line class="${name}" x1="${this.X(u[0])}" x2="${this.X(u[1])}" y1="${this.Y(v[0])}" y2="${this.Y(v[1])}"/>`;
    }

    svg(label) {
      return `<svg role="img" viewBox="0 0 340 340" aria-label="${escape(label)}">${this.body}</svg>`;
    }
  }

  class DelayAtlas extends customElements.get("sos-atlas") {
    start() {
      if (this.started) return;
      this.kind = 0;
      super.start();
      if (!this.started) return;
      const id = `${this.name}-kind`, captions = this.view.querySelectorAll(".sos-caption");
      this.view.querySelector(".sos-sliders").insertAdjacentHTML("beforeend",
        `<div class="sos-slider"><label for="${id}">How the delay varies</label><select id="${id}" autocomplete="off"` +
        ` data-lm-suppress-shortcuts="true">` + this.data.kinds.map((name, k) =>
          `<option value="${k}">${escape(name)}</option>`).join("") + `</select></div>`);
      captions[0].innerHTML = "Rightmost roots for the constant delays: " + DELAYS.map((name, k) =>
        `<span class="sos-mark" style="color:var(${COLOURS[k]})">${SHAPES[k]} ${name}</span>`).join(", ") + ". Dashed: Re s = −δ.";
      this.view.querySelector(".sos-panels").insertAdjacentHTML("beforeend",
        `<figure class="sos-panel"><div class="sos-input"></div><figcaption class="sos-caption">The control signal: ` +
        `<span class="sos-mark" style="color:var(--sos-first)">┄ as asked</span>, ` +
        `<span class="sos-mark" style="color:var(--sos-second)">— as it arrives</span>.</figcaption></figure>`);
      this.view.querySelector(".sos-panels").append(this.view.querySelector(".sos-readout"));
      const select = this.view.querySelector("select");
      select.value = "0";
      select.addEventListener("change", () => {
        this.kind = Number(select.value);
        this.update();
      });
      this.update();
    }

    get design() {
      const found = this.stored(), [n, m, a] = this.data.shape, N = 2 * n + a;
      const asked = {};
      this.data.sliders.forEach((slider, k) => { asked[slider.key] = slider.values[this.place[k]]; });
      asked.mu = asked.tau * asked.ratio;
      if (typeof found === "number") return {status: ["infeasible", "undecided"][found], asked};
      const [gain, [block, margin], [rate, at], roots] = found;
      return {status: "feasible", asked, rate, at,
        K: Array.from({length: m}, (_, i) => gain.slice(i * N, (i + 1) * N)),
        margin: [this.data.blocks[block], margin],
        roots: roots.map(row => row.flatMap((re, k) => k % 2 ? [] : [[re, row[k + 1]]]))};
    }

    update() {
      this.response = this.answer(this.design);
      super.update();
      const input = this.view.querySelector(".sos-input");
      if (input) input.innerHTML = this.input();
    }

    answer({K, asked}) {
      if (!K) return null;
      const {vertices: [plant], r, horizon, U, varying, steps} = this.data;
      const delay = delayOf(this.kind, asked.tau, asked.mu, varying);
      const found = simulate(plant, K, r, delay, horizon, steps);
      const z = found.states.map(x => product(U, x.slice(0, r.length)));
      return {...found, z, t: z.map((_, k) => k * horizon / steps)};
    }

    map({status, asked, roots}) {
      const [left, right, height] = this.data.window;
      const plot = new Plot([left, right], [-height, height], "Re s (1/s)", "Im s (rad/s)");
      plot.rule([0, 0], [-height, height], "sos-axis");
      plot.rule([-asked.delta, -asked.delta], [-height, height], `sos-bound${roots ? "" : " sos-empty"}`);
      const shape = [(u, v) => `M${u - 4} ${v}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0`,
        (u, v) => `M${u - 5} ${v}h10M${u} ${v - 5}v10`, (u, v) => `M${u - 4} ${v - 4}l8 8m0 -8l-8 8`];
      (roots || []).forEach((row, k) => row.flatMap(([re, im]) => im ? [[re, im], [re, -im]] : [[re, im]])
        .filter(point => plot.has(...point)).forEach(([re, im]) => {
          plot.body += `<path class="sos-root" style="stroke:var(${COLOURS[k]})" d="${shape[k](plot.X(re), plot.Y(im))}"/>`;
        }));
      if (!roots) plot.body += this.absent(status);
      return plot.svg(roots ? `Root map: ${DELAYS.map((name, k) =>
        `for the ${name} delay the rightmost root has real part ${clean(roots[k][0][0])}`).join(", ")}.`
        : `Root map: empty, because no design is known (${status}).`);
    }

    absent(status) { return `<text class="sos-no" x="189" y="150" text-anchor="middle">${status}</text>`; }

    // Lines over time, thinned.
    chart(lines, ylabel, label, limits, target) {
      const {horizon, steps, points} = this.data, all = lines.flatMap(line => line.values).concat(limits);
      const low = Math.min(...all), high = Math.max(...all), room = 0.05 * (high - low);
      const plot = new Plot([0, horizon], [low - room, high + room], "time t (s)", ylabel);
      if (target !== undefined) plot.rule([0, horizon], [target, target], "sos-target");
      for (const {values, colour, dash} of this.response ? lines : []) {
        plot.line(values.map((v, k) => [this.response.t[k], v]).filter((_, k) => k % (steps / points) === 0), colour, dash);
      }
      if (!this.response) plot.body += this.absent(this.design.status);
      return plot.svg(label);
    }

    step() {
      const z = this.response ? this.response.z : [], dashes = ["", "7 4", "2 3"];
      const lines = this.data.U.map((_, i) => ({
        values: z.map(row => row[i]), colour: COLOURS[i % 3], dash: dashes[i % 3]}));
      const words = lines.map(line => `peaks at ${clean(Math.max(...line.values))}, ends at ${clean(line.values.at(-1))}`);
      return this.chart(lines, this.data.output, this.response
        ? `Response over ${clean(this.data.horizon)} seconds: ${words.join("; ")}.` : "Response: none, for there is no design.",
      [-0.1, 1.2], 1);
    }

    input() {
      const {asked, applied} = this.response || {asked: [], applied: []};
      const lines = Array.from({length: this.data.shape[1]}, (_, i) => [
        {values: asked.map(u => u[i]), colour: "--sos-first", dash: "3 3"},
        {values: applied.map(u => u[i]), colour: "--sos-second"}]).flat();
      const peak = Math.max(...applied.flat().map(Math.abs));
      return this.chart(lines, "control signal u", this.response
        ? `Control signal, as asked and as it arrives: at most ${clean(peak)} in size.` : "Control signal: none, for there is no design.",
      asked.length ? [] : [-1, 1]);
    }

    // The nearest move of each single slider to a design, the shortest first.
    moves() {
      return this.data.sliders.flatMap((slider, k) => {
        const near = slider.values.map((_, at) => at).sort((p, q) => Math.abs(p - this.place[k]) - Math.abs(q - this.place[k]));
        const at = near.find(i => typeof this.stored(this.place.map((old, j) => j === k ? i : old)) !== "number");
        return at === undefined ? [] : [{far: Math.abs(at - this.place[k]), text: slider.texts[at]}];
      }).sort((p, q) => p.far - q.far);
    }

    advice() {
      const moves = this.moves().map(move => move.text);
      return moves.length ? `${moves.length > 1 ? "Each of these moves" : "This move"} leads to a design: ${moves.join("; or ")}.`
        : "No move of a single slider leads to a design.";
    }

    readout(design) {
      const texts = this.data.sliders.map((slider, k) => slider.texts[this.place[k]]);
      const {tau, mu, delta} = design.asked, span = `[${clean(tau - mu)}, ${clean(tau + mu)}] s`;
      const head = `<p><span class="sos-status">${design.status[0].toUpperCase()}${design.status.slice(1)}</span>` +
        ` for ${escape([...texts, ...this.data.also].join(", "))}: the delay stays in ${span}.</p>`;
      if (design.status !== "feasible") {
        return head + `<p>${design.status === "infeasible" ? "No certificate: the corrected LMI has no solution, by the solver's multipliers."
          : "No certificate was found, nor a proof that there is none."} ${escape(this.advice())}</p>`;
      }
      const [n, , a] = this.data.shape, [block, margin] = design.margin;
      const gains = [["P", 0, n], ["D", n, 2 * n], ["I", 2 * n, 2 * n + a]].filter(p => p[2] > p[1]).map(([name, from, to]) =>
        `<span class="sos-gain"><span>K<sub>${name}</sub> =</span> <span class="sos-matrix" style="grid-template-columns:repeat(${to - from},auto)">` +
        design.K.flatMap(row => row.slice(from, to)).map(x => `<span>${clean(x, 4)}</span>`).join(" ") + `</span></span>`).join(" ");
      return head + `<div class="sos-gains">${gains}</div>` +
        `<p>Promised rate, however the delay varies: ${clean(delta)} 1/s. ` +
        `True slowest rate over the constant delays: ${clean(design.rate)} 1/s, at ${clean(design.at)} s.</p>` +
        `<p>Smallest margin: ${clean(margin, 2)} (block: ${escape(block)}).</p>`;
    }
  }

  if (!customElements.get("sos-delay")) customElements.define("sos-delay", DelayAtlas);
  document.querySelectorAll("sos-delay").forEach(atlas => atlas.start && atlas.start());
})();
