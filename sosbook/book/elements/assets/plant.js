// A plant of the reader's own: matrices to type or paste, then the explorer's sliders.
(() => {
  "use strict";
  const {QUIET, define, escape, select} = window.sosKit;
  const Explorer = customElements.get("sos-explorer");
  const LARGEST = 4;   // degrees of freedom
  const FIELDS = [["M", "Mass M"], ["D", "Damping D"], ["S", "Stiffness S"], ["B", "Inputs B"], ["F", "Disturbances F"],
    ["U", "Integrated errors U"], ["x0", "Initial state x(0)"], ["Q", "Weight Q of the state"], ["R", "Weight R of the input"]];

  // "1 2; 3 4", lines of numbers, or [[1, 2], [3, 4]] as Python writes it.
  function parse(name, text) {
    const rows = text.replace(/\]\s*,?\s*\[/g, ";").replace(/[[\]]/g, " ").split(/[;\n]/).map(row => row.trim()).filter(row => row)
      .map(row => row.split(/[\s,]+/).filter(word => word).map(Number));
    if (rows.flat().some(x => !isFinite(x))) throw new Error(`${name} holds something that is no number.`);
    rows.forEach((row, k) => {
      if (row.length !== rows[0].length) throw new Error(`${name}: row ${k + 1} has ${row.length} numbers, the first has ${rows[0].length}.`);
    });
    return rows;
  }

  const written = rows => rows.map(row => row.join(" ")).join("\n");

  // A weight of so many rows, symmetric; one row is a diagonal.
  function weight(name, text, size, who) {
    const rows = parse(name, text), X = rows.length === 1 ? rows[0].map((x, i) => rows[0].map((_, j) => i === j ? x : 0)) : rows;
    if (X.length !== size || X[0].length !== size) throw new Error(`${name} needs ${size} numbers (a diagonal) or ${size} rows, ${who}.`);
    if (X.some((row, i) => row.some((x, j) => x !== X[j][i]))) throw new Error(`${name} must be symmetric.`);
    const kernel = window.sosPlain, least = Math.min(...kernel.eigenvalues(kernel.matrix(X)).map(([re]) => re)), most = Math.max(...X.flat().map(Math.abs));
    if (name === "R" ? least <= 0 : least < -1e-12 * most) throw new Error(`${name} must ${name === "R" ? "be positive definite" : "have no negative eigenvalue"}.`);
    return X;
  }

  // The cost that the fields weigh; noise enters by F, or every state without one.
  function costOf({Q, R}, {vertices: [{M, B, F}], U}) {
    const N = 2 * M.length + U.length;
    return {Q: weight("Q", Q, N, "for z, z', and the integrals of U z"), R: weight("R", R, B[0].length, "one for each input"), noise: F ? "F" : "states"};
  }

  // The request of the typed matrices; an Error that names what doesn't fit.
  function requestOf(texts) {
    const typed = FIELDS.map(([name]) => name).filter(name => name !== "Q" && name !== "R");
    const given = Object.fromEntries(typed.map(name => [name, parse(name, texts[name])]));
    const {M, D, S, B, F, U} = given, n = M.length;
    if (!n || n > LARGEST) throw new Error(`M must have 1 to ${LARGEST} rows. For larger plants take the package.`);
    for (const [name, X] of [["M", M], ["D", D], ["S", S], ["B", B], ["F", F]]) {
      if (name === "F" && !X.length) continue;
      if (X.length !== n) throw new Error(`${name} must have ${n} rows, like M; it has ${X.length}.`);
      if ("MDS".includes(name) && X[0].length !== n) throw new Error(`${name} must be ${n} by ${n}.`);
    }
    if (U.length && U[0].length !== n) throw new Error(`U must have ${n} columns.`);
    if (U.length > B[0].length) throw new Error("U has more rows than there are inputs: integrate fewer errors.");
    const N = 2 * n + U.length, x0 = given.x0.flat();
    if (x0.length && x0.length !== N) throw new Error(`x(0) needs ${N} numbers: z, z', and the integrals of U z.`);
    return {request: {vertices: [{M, D, S, B, ...(F.length ? {F} : {})}], U, K_A: null, coupling: "pairs"}, x0: x0.length ? x0 : null};
  }

  // Two digits are enough for the end of a slider.
  const plain = x => Number(x.toPrecision(2));
  const slider = (key, label, symbol, unit, looser, min, max, value, more = {}) =>
    ({key, label, symbol, unit, looser, min: plain(min), max: plain(max), value: plain(value), degrees: false, log: true, ...more});

  // What the explorer needs to know of a plant; `before` is what is known of its last design.
  function dataOf({request, x0}, wanted, before, texts) {
    const kernel = window.sosPlain ??= window.sosKernel(), cost = wanted.cost ? costOf(texts, request) : null, {B, F, M} = request.vertices[0];
    const [d] = kernel.descriptors(request), [A, Bu] = kernel.stateSpace(d);
    if (!A || !Bu || A.at.some(x => !isFinite(x))) throw new Error("M is singular: such plants need acceleration feedback, see the package.");
    const rates = kernel.eigenvalues(A).map(s => Math.hypot(...s)).filter(x => x > 1e-6);
    const omega = rates.length ? Math.exp(rates.reduce((sum, x) => sum + Math.log(x), 0) / rates.length) : 1;
    const n = M.length, a = request.U.length, r = M.map(() => 1);
    const sliders = [
      slider("sigma", "Decay rate σ", "σ", " 1/s", -1, 0.02 * omega, 2 * omega, 0.2 * omega),
      slider("theta", "Half-angle θ", "θ", "°", 1, 10, 90, 60, {degrees: true, log: false}),
      slider("rho", "Disk radius ρ", "ρ", " 1/s", 1, omega, 40 * omega, 8 * omega)];
    if (wanted.gamma && F) {
      const norm = before?.norm || 1;
      sliders.push(slider("gamma", "H∞ bound γ", "γ", "", 1, norm / 20, norm * 50, norm * 3));
    }
    if (cost) {
      const fits = before && before.K[0].length === cost.Q.length && before.K.length === cost.R.length;
      const now = fits ? kernel.truth({...request, asked: cost}, before).cost : 0, typical = now > 0 ? now : 100;
      sliders.push(slider("cost", "Bound of the cost", "J", "", 1, typical / 20, typical * 50, typical * 3));
    }
    if (wanted.u_max && x0) {
      const peak = before?.peak || 10;
      sliders.push(slider("u_max", "Input bound u_max", "u_max", "", 1, peak / 20, peak * 50, peak * 3));
    }
    const far = 10 * omega, s = [...Array(2 * n).fill(0), ...request.U.map(row => -row.reduce((sum, u) => sum + u, 0))];
    return {request, x0, mu: null, cost, sliders, fixed: {}, shownFixed: {}, also: [], shape: [n, B[0].length, a], r,
      horizon: plain(40 / omega), window: [-1.06 * far, 0.2 * far, far],
      vertices: [{A: kernel.rowsOf(A), B: kernel.rowsOf(Bu), s}],
      caption: `Step response from rest to the set point (${r.join(", ")}).`};
  }

  // The control law as a C function of its own.
  function program(K, [n, m, a], U) {
    const table = rows => rows.map(row => `    {${row.map(x => x.toPrecision(9)).join(", ")}}`).join(",\n");
    return `/* u = K [e; z'; x3] with e = z - r, and x3 the integral of U e. Call it every dt seconds.
   The integral is a sum of rectangles: a design in discrete time needs a small dt. */
#define STATES ${n}
#define INPUTS ${m}
#define INTEGRATORS ${a}

static const double K[INPUTS][2 * STATES + INTEGRATORS] = {
${table(K)}
};
${a ? `static const double U[INTEGRATORS][STATES] = {\n${table(U)}\n};\nstatic double x3[INTEGRATORS];\n` : ""}
void control(const double z[STATES], const double velocity[STATES],
             const double r[STATES], double dt, double u[INPUTS])
{
    for (int i = 0; i < INPUTS; i++) {
        u[i] = 0;
        for (int j = 0; j < STATES; j++)
            u[i] += K[i][j] * (z[j] - r[j]) + K[i][STATES + j] * velocity[j];
${a ? `        for (int j = 0; j < INTEGRATORS; j++)
            u[i] += K[i][2 * STATES + j] * x3[j];
    }
    for (int i = 0; i < INTEGRATORS; i++)
        for (int j = 0; j < STATES; j++)
            x3[i] += dt * U[i][j] * (z[j] - r[j]);
` : `    }
    (void)dt;
`}}
`;
  }

  class OwnPlant extends Explorer {
    markup() {
      const field = ([name, words]) => `<div class="sos-field"><label for="${this.name}-${name}">${words}</label>` +
        `<textarea id="${this.name}-${name}" data-field="${name}" rows="4" spellcheck="false" ${QUIET}></textarea></div>`;
      const box = (key, words) => `<label class="sos-check"><input type="checkbox" data-wanted="${key}" ${QUIET}> ${words}</label>`;
      const names = this.data.examples.map(({name}) => name);
      return `<div class="sos-form">${select({id: `${this.name}-example`, key: "example", label: "Start from", names})}` +
        `<div class="sos-fields">${FIELDS.map(field).join("")}</div><div class="sos-row">` +
        `<button type="button" class="sos-button sos-design" ${QUIET}>Design for these matrices</button>` +
        box("gamma", "bound what w does (γ)") + box("cost", "bound the cost (Q, R)") + box("u_max", "bound the input from x(0)") + `</div>` +
        `<p class="sos-fault" role="alert"></p></div><div class="sos-inner">${this.inner()}</div>`;
    }

    inner() {
      return super.markup().replace(/<\/button><\/div>/, `</button><button type="button" class="sos-button" data-do="c" ${QUIET}>As C</button></div>`);
    }

    wire() {
      super.wire();
      this.fill(this.data.examples[0]);
      const example = this.view.querySelector("select");
      example.addEventListener("change", () => { this.fill(this.data.examples[example.value]); this.rebuild(); });
      this.part("design").addEventListener("click", () => this.rebuild());
      this.view.querySelectorAll("[data-wanted]").forEach(box => box.addEventListener("change", () => this.rebuild()));
    }

    fill({request, x0}) {
      const [{M, D, S, B, F = []}] = request.vertices, ones = X => [Array(X).fill(1)];
      const values = {M, D, S, B, F, U: request.U, x0: x0 ? [x0] : [], Q: ones(2 * M.length + request.U.length), R: ones(B[0].length)};
      this.view.querySelectorAll("textarea").forEach(area => { area.value = written(values[area.dataset.field]); });
    }

    rebuild() {
      const texts = Object.fromEntries([...this.view.querySelectorAll("textarea")].map(area => [area.dataset.field, area.value]));
      const wanted = Object.fromEntries([...this.view.querySelectorAll("[data-wanted]")].map(box => [box.dataset.wanted, box.checked]));
      const fault = this.part("fault");
      fault.textContent = "";
      try {
        if (wanted.u_max && !parse("x0", texts.x0).length) throw new Error("The bound of the input needs x(0).");
        if (wanted.gamma && !parse("F", texts.F).length) throw new Error("The bound γ needs F: say where the disturbance enters.");
        Object.assign(this.data, dataOf(requestOf(texts), wanted, this.found, texts));
      } catch (error) {
        fault.textContent = error.message;
        return;
      }
      this.solver.cancel(this.name);
      clearTimeout(this.idle);
      this.rebuilt = true;
      this.part("inner").innerHTML = this.inner();
      super.wire();
      this.reserve();
    }

    // The largest input from x(0) is told, whether it has a bound or not.
    request(values) {
      const request = super.request(values);
      if (this.data.x0) request.asked.x0 = this.data.x0;
      return request;
    }

    // A link leads to the first plant's sliders only.
    read() { if (!this.rebuilt) super.read(); }

    press(what) {
      super.press(what);
      if (what !== "c") return;
      if (this.answer?.status !== "feasible") {
        this.part("more").innerHTML = "<p>There is no design here.</p>";
        return;
      }
      this.code = program(this.answer.K, this.data.shape, this.data.request.U);
      this.part("more").innerHTML = `<pre class="sos-code" tabindex="0">${escape(this.code)}</pre>`;
    }
  }

  define("sos-plant", OwnPlant);
})();
