(() => {
  "use strict";
  let count = 0;
  const escape = text => String(text).replace(/[&<>"]/g, c =>
    ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
  const clean = (x, digits = 4) => String(Number(Number(x).toPrecision(digits))).replace("-", "−");
  const round = x => Math.round(x * 10) / 10 + 0;
  const [L, R, T, B] = [54, 332, 12, 292];

  // 1, 2, 5 times powers of ten; every step where these are too few.
  function ticks(low, high) {
    for (const steps of [[1], [1, 2, 5], [1, 1.5, 2, 3, 4, 5, 7], [1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6, 7, 8, 9]]) {
      const list = [];
      for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++) {
        for (const s of steps) {
          const v = s * 10 ** e;
          if (v >= low * 0.9999 && v <= high * 1.0001) list.push(v);
        }
      }
      if (list.length >= 3) return list.length > 8 ? list.filter((_, k) => k % 2 === 0) : list;
    }
    return [low, high];
  }

  class FeasibilityMap extends HTMLElement {
    connectedCallback() { this.start(); }

    start() {
      const source = this.querySelector("script[type='application/json']");
      if (this.started || !source) return;
      this.started = true;
      this.data = JSON.parse(source.textContent);
      do { this.name = `sos-map-${++count}`; } while (document.getElementById(`${this.name}-group`));
      this.view = document.createElement("div");
      const pick = (key, label, options) =>
        `<div class="sos-slider"><label for="${this.name}-${key}">${label}</label>` +
        `<select id="${this.name}-${key}" autocomplete="off" data-lm-suppress-shortcuts="true">${options}</select></div>`;
      const slide = key => `<div class="sos-slider"><label for="${this.name}-${key}"><span></span>` +
        `<output for="${this.name}-${key}"></output></label><input id="${this.name}-${key}" type="range" min="0" step="1"` +
        ` autocomplete="off" data-lm-suppress-shortcuts="true"></div>`;
      this.view.innerHTML = `<p class="sos-title">${escape(this.data.title)}</p><div class="sos-sliders">` +
        pick("group", "Plant", this.data.groups.map((g, k) => `<option value="${k}">${escape(g.name)}</option>`).join("")) +
        pick("pair", "Requirements", "") + slide("x") + slide("y") +
        `</div><div class="sos-panels"><figure class="sos-panel"><div class="sos-plot"></div>` +
        `<figcaption class="sos-caption"></figcaption></figure>` +
        `<div class="sos-readout" role="status" aria-live="polite" aria-atomic="true"></div></div>`;
      this.append(this.view);
      this.part("group").addEventListener("change", () => this.choose());
      this.part("pair").addEventListener("change", () => this.open());
      for (const key of ["x", "y"]) this.part(key).addEventListener("input", () => this.update());
      this.choose();
    }

    part(key) { return this.view.querySelector(`#${this.name}-${key}`); }
    get group() { return this.data.groups[Number(this.part("group").value)]; }
    get map() { return this.group.maps[Number(this.part("pair").value)]; }
    get place() { return [Number(this.part("x").value), Number(this.part("y").value)]; }

    choose() {
      this.part("pair").innerHTML = this.group.maps.map((m, k) =>
        `<option value="${k}">${escape(m.x.symbol)} and ${escape(m.y.symbol)}</option>`).join("");
      this.part("pair").value = "0";
      this.open();
    }

    // The sliders start at what was asked, or next to it.
    open() {
      ["x", "y"].forEach((key, k) => {
        const axis = this.map[key], input = this.part(key);
        input.max = axis.values.length - 1;
        const far = axis.values.map(v => Math.abs(Math.log(v / this.map.asked[k])));
        input.value = far.indexOf(Math.min(...far));
        input.parentElement.querySelector("span").textContent = axis.label;
      });
      this.update();
    }

    unit(axis) { return axis.unit.trim() ? `${axis.symbol} (${axis.unit.trim()})` : axis.symbol; }
    say(axis, value) { return `${axis.symbol} = ${clean(value)}${axis.unit}`; }

    // By the proofs kept: one that asks for as much, or one that asks for no more.
    get verdict() {
      const {x, y, rows, designs, refusals} = this.map, [i, j] = this.place, v = y.values[j];
      const least = (a, b) => (a - b) * y.harder >= -1e-9 * Math.abs(b);
      for (let k = i; k < rows.length; k++) {
        if (rows[k][0] !== null && least(rows[k][0], v)) return {status: "feasible", found: designs[rows[k][2]]};
      }
      for (let k = i; k >= 0; k--) {
        if (rows[k][3] !== null && least(v, rows[k][1])) return {status: "infeasible", found: refusals[rows[k][3]]};
      }
      return {status: "undecided"};
    }

    update() {
      const {x, y} = this.map, [i, j] = this.place, verdict = this.verdict;
      for (const [key, axis, at] of [["x", x, i], ["y", y, j]]) {
        const text = this.say(axis, axis.values[at]), input = this.part(key);
        input.setAttribute("aria-valuetext", text);
        input.parentElement.querySelector("output").textContent = text;
      }
      this.view.querySelector(".sos-plot").innerHTML = this.plot(verdict);
      this.view.querySelector(".sos-caption").textContent =
        `Shaded: a certified design. Hatched: proven infeasible. Blank: between the proofs. Diamond: what was asked. Held: ${this.map.held.join(", ") || "nothing else"}.`;
      const readout = this.view.querySelector(".sos-readout");
      readout.className = `sos-readout sos-${verdict.status}`;
      readout.innerHTML = this.readout(verdict);
    }

    plot(verdict) {
      const {x, y, rows, asked} = this.map, [i, j] = this.place;
      const near = [...x.values, asked[0]], all = [...y.values, asked[1]];
      const xs = [Math.min(...near) / 1.03, Math.max(...near) * 1.03], ys = [Math.min(...all), Math.max(...all)];
      const along = (v, [a, b], p, q) => p + Math.log(v / a) / Math.log(b / a) * (q - p);
      const X = v => round(along(v, xs, L, R)), Y = v => round(Math.max(T, Math.min(B, along(v, ys, B, T))));
      let out = "";
      for (const v of ticks(...xs)) out += `<line class="sos-grid" x1="${X(v)}" x2="${X(v)}" y1="${T}" y2="${B}"/>` +
        `<text x="${X(v)}" y="${B + 16}" text-anchor="middle">${clean(v, 3)}</text>`;
      for (const v of ticks(...ys)) out += `<line class="sos-grid" x1="${L}" x2="${R}" y1="${Y(v)}" y2="${Y(v)}"/>` +
        `<text x="${L - 6}" y="${Y(v) + 4}" text-anchor="end">${clean(v, 3)}</text>`;
      out += `<text x="${(L + R) / 2}" y="326" text-anchor="middle">${escape(this.unit(x))}</text>` +
        `<text transform="translate(11 ${(T + B) / 2}) rotate(-90)" text-anchor="middle">${escape(this.unit(y))}</text>`;
      // a design covers all that asks for less, a refusal all that asks for more
      const loose = x.harder > 0 ? L : R, hard = x.harder > 0 ? R : L;
      const easy = y.harder > 0 ? B : T, tough = y.harder > 0 ? T : B;
      const stair = (side, from, close) => {
        const steps = x.values.map((v, k) => [X(v), rows[k][side]]).filter(p => p[1] !== null).map(([u, v]) => [u, Y(v)]);
        if (!steps.length) return "";
        if (!close) steps.reverse();
        let path = `M${from} ${close ? easy : tough}`, last = null;
        for (const [u, v] of steps) { path += last === null ? `L${from} ${v}` : `L${last} ${v}`; path += `L${u} ${v}`; last = u; }
        return `${path}L${last} ${close ? easy : tough}Z`;
      };
      out += `<defs><pattern id="${this.name}-hatch" width="9" height="9" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">` +
        `<line class="sos-hatch" x1="0" y1="0" x2="0" y2="9"/></pattern></defs>` +
        `<path class="sos-region" d="${stair(0, loose, true)}"/>` +
        `<path class="sos-region sos-empty" style="fill:url(#${this.name}-hatch)" d="${stair(1, hard, false)}"/>`;
      const [u, v] = [X(asked[0]), Y(asked[1])], [a, b] = [X(x.values[i]), Y(y.values[j])];
      out += `<path class="sos-asked" d="M${u} ${v - 6}l6 6l-6 6l-6 -6Z"/>` +
        `<path class="sos-cross" d="M${a - 9} ${b}h18M${a} ${b - 9}v18"/>`;
      const label = `Map of ${x.label} and ${y.label}, logarithmic: the point at ${this.say(x, x.values[i])}, ` +
        `${this.say(y, y.values[j])} is ${verdict.status}.`;
      return `<svg role="img" viewBox="0 0 340 334" aria-label="${escape(label)}">${out}</svg>`;
    }

    readout({status, found}) {
      const {x, y, shape: [n, m, a]} = this.map, [i, j] = this.place;
      const point = `${this.say(x, x.values[i])}, ${this.say(y, y.values[j])}`;
      const word = {feasible: "Certified", infeasible: "Excluded", undecided: "Undecided"}[status];
      const head = `<p><span class="sos-status">${word}</span>: ${escape(point)}.</p>`;
      if (status === "undecided") return head + "<p>Neither a certified design nor a proof that there is none is stored for this point.</p>";
      if (status === "infeasible") {
        const bars = found.shares.map(([name, share]) => `<li><span class="sos-bar" style="width:${share / 20}em"></span>` +
          `${escape(name)}: ${share} %</li>`).join("");
        return head + `<p>Exact multipliers exclude every design for ${escape(found.asked)}: these LMIs have no solution there, nor where more is asked.</p>` +
          (bars ? `<p>What a relaxation of each requirement by the same small factor would contribute:</p><ul class="sos-shares">${bars}</ul>` : "");
      }
      const N = 2 * n + a, K = Array.from({length: m}, (_, r) => found.K.slice(r * N, (r + 1) * N));
      const parts = [["P", 0, n], ["D", n, 2 * n], ["I", 2 * n, N]].filter(p => p[2] > p[1]);
      const gains = parts.map(([name, from, to]) => `<span class="sos-gain"><span>K<sub>${name}</sub> =</span> ` +
        `<span class="sos-matrix" style="grid-template-columns:repeat(${to - from},auto)">` +
        K.flatMap(row => row.slice(from, to)).map(g => `<span>${clean(g)}</span>`).join(" ") + `</span></span>`).join(" ");
      return head + `<p>This design, certified for ${escape(found.asked)}, keeps it; its tightest block is ` +
        `${escape(this.data.blocks[found.block])}.</p><div class="sos-gains">${gains}</div>`;
    }
  }

  if (!customElements.get("sos-map")) customElements.define("sos-map", FeasibilityMap);
  document.querySelectorAll("sos-map").forEach(map => map.start && map.start());
})();
