// A plant of the reader's own: matrices to type or paste, then the explorer's sliders.
import {descriptors, stateSpace} from "../../kernel/descriptor.js";
import {rowsOf} from "../../kernel/matrices.js";
import {eigenvalues} from "../../kernel/spectrum.js";
import {truth} from "../../kernel/truth.js";

import * as checks from "./checks.js";
import {Fault, parsed, refuse} from "./checks.js";
import {Explorer} from "./explorer.js";
import {define, number, QUIET, select} from "./kit.js";

const LARGEST = 4;  // degrees of freedom
const CHANGED =
  "The fields were changed. What stands below belongs to the matrices before, and is locked until you design for these.";
const STRANGE = "These matrices can't be computed with: choose other units, or take the package.";
// name, words, shape, and the box that asks for it
const FIELDS = [
  ["M", "Mass M", "n rows of n"], ["D", "Damping D", "n rows of n"], ["S", "Stiffness S", "n rows of n"],
  ["B", "Inputs B", "n rows, a column for each input"], ["F", "Disturbances F", "n rows; may be empty"],
  ["U", "Integrated errors U", "a rows of n; may be empty"],
  ["x0", "Initial state x(0)", "2n + a numbers: z, z′, integrals of U z", "u_max"],
  ["Q", "Weight Q of the state", "2n + a numbers, a diagonal, or rows", "cost"],
  ["R", "Weight R of the input", "a number for each input, or rows", "cost"]
];

const written = rows => rows.map(row => row.join(" ")).join("\n");
// One line, as an address has it.
const compact = text => text.split(/[;\n]/).map(row => row.trim()).filter(row => row).join(";");

// {request, x0, cost, warning} of what is typed and asked; a Fault says what doesn't fit.
function requestOf(texts, wanted) {
  /** @type {any} */
  const given = Object.fromEntries(Object.entries(texts).map(([name, text]) => [name, parsed(name, text)]));
  const {M, D, S, B, F, U} = given;
  if (!M.length || M.length > LARGEST)
    refuse(`M must have 1 to ${LARGEST} rows. For larger plants take the package.`);
  const warning = checks.plant(given), N = 2 * M.length + U.length;
  if (wanted.gamma && !F.length) refuse(checks.said("disturbance"));
  return {
    request: {vertices: [{M, D, S, B, ...(F.length ? {F} : {})}], U, K_A: null, coupling: "pairs"},
    warning,
    x0: wanted.u_max ? checks.start(given.x0, N) : null,
    cost: wanted.cost ? {
      Q: checks.weight("Q", given.Q, N),
      R: checks.weight("R", given.R, B[0].length),
      noise: F.length ? "F" : "states"
    }
                      : null
  };
}

// Two digits are enough for the end of a slider.
const plain = x => Number(x.toPrecision(2));
const slider = (key, label, symbol, unit, looser, min, max, value, more = {}) => ({
  key,
  label,
  symbol,
  unit,
  looser,
  min: plain(min),
  max: plain(max),
  value: plain(value),
  degrees: false,
  log: true,
  ...more
});

// What the explorer needs to know of a plant. Bounds start at three times what the last
// design does, `before`, or where the page's address has them.
function dataOf({request, x0, cost}, wanted, before, linked) {
  const [d] = descriptors(request), [A, Bu] = stateSpace(d), {B, M} = request.vertices[0];
  const rates = eigenvalues(A).map(s => Math.hypot(...s)).filter(x => x > 1e-6);
  const omega = rates.length ? Math.exp(rates.reduce((sum, x) => sum + Math.log(x), 0) / rates.length) : 1;
  if (![...A.at, ...Bu.at].every(isFinite) || omega > 1e98 || omega < 1e-98)
    refuse(STRANGE);  // the package's bounds end at 1e100
  const n = M.length, a = request.U.length, r = M.map(() => 1);
  const now = before ? truth({...request, asked: {...cost, ...(x0 && {x0})}}, before) : {};
  const bound = (key, size, usual) => {
    const typical = number(linked[key]) > 0 ? number(linked[key]) / 3 : size > 0 ? size : usual;
    return [typical / 20, typical * 50, typical * 3];
  };
  const sliders = [
    slider("sigma", "Decay rate σ", "σ", " 1/s", -1, 0.02 * omega, 2 * omega, 0.2 * omega),
    slider("theta", "Half-angle θ", "θ", "°", 1, 10, 90, 60, {degrees: true, log: false}),
    slider("rho", "Disk radius ρ", "ρ", " 1/s", 1, omega, 40 * omega, 8 * omega)
  ];
  if (wanted.gamma) sliders.push(slider("gamma", "H∞ bound γ", "γ", "", 1, ...bound("gamma", now.norm, 1)));
  if (cost) sliders.push(slider("cost", "Bound of the cost", "J", "", 1, ...bound("cost", now.cost, 100)));
  if (x0) sliders.push(slider("u_max", "Input bound u_max", "u_max", "", 1, ...bound("u_max", now.peak, 10)));
  const far = 10 * omega;
  const s = [...Array(2 * n).fill(0), ...request.U.map(row => -row.reduce((sum, u) => sum + u, 0))];
  return {
    request,
    x0,
    mu: null,
    cost,
    sliders,
    fixed: {},
    shownFixed: {},
    also: [],
    shape: [n, B[0].length, a],
    r,
    horizon: plain(40 / omega),
    window: [-1.06 * far, 0.2 * far, far],
    vertices: [{A: rowsOf(A), B: rowsOf(Bu), s}],
    caption: `Step response from rest to the set point (${r.join(", ")}).`
  };
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
${
    a ? `static const double U[INTEGRATORS][STATES] = {\n${table(U)}\n};\nstatic double x3[INTEGRATORS];\n`
      : ""}
void control(const double z[STATES], const double velocity[STATES],
             const double r[STATES], double dt, double u[INPUTS])
{
    for (int i = 0; i < INPUTS; i++) {
        u[i] = 0;
        for (int j = 0; j < STATES; j++)
            u[i] += K[i][j] * (z[j] - r[j]) + K[i][STATES + j] * velocity[j];
${
    a ? `        for (int j = 0; j < INTEGRATORS; j++)
            u[i] += K[i][2 * STATES + j] * x3[j];
    }
    for (int i = 0; i < INTEGRATORS; i++)
        for (int j = 0; j < STATES; j++)
            x3[i] += dt * U[i][j] * (z[j] - r[j]);
`
      : `    }
    (void)dt;
`}}
`;
}

class OwnPlant extends Explorer {
  get buttons() {
    const [[reset], ...others] = super.buttons;
    return [[reset, "Reset the sliders"], ...others, ["c", "As C"]];
  }

  markup() {
    const field = ([name, words, shape, box]) =>
      `<div class="sos-field"${box ? ` data-box="${box}" hidden` : ""}>` +
      `<label for="${this.name}-${name}">${words} <span class="sos-soft">${shape}</span></label>` +
      `<textarea id="${this.name}-${name}" data-field="${name}" rows="4" spellcheck="false" ${
        QUIET}></textarea></div>`;
    const box = (key, words) =>
      `<label class="sos-check"><input type="checkbox" data-wanted="${key}" ${QUIET}> ${words}</label>`;
    const names = this.data.examples.map(({name}) => name);
    return `<div class="sos-form">${
             select({id: `${this.name}-example`, key: "example", label: "Start from", names})}` +
      `<p class="sos-soft">A row of numbers a line, or 1 0; 0 1. Decimals have a point.</p><div class="sos-fields">${
        FIELDS.map(field).join("")}</div>` +
      `<div class="sos-row"><button type="button" class="sos-button sos-design" ${
        QUIET}>Design for these matrices</button>` +
      box("gamma", "bound what w does (γ)") + box("cost", "bound the cost (Q, R)") +
      box("u_max", "bound the input from x(0)") + `</div>` +
      `<p class="sos-fault" role="alert"></p><p class="sos-note" role="status"></p></div><div class="sos-inner">${
        super.markup()}</div>`;
  }

  wire() {
    Object.assign(checks.refusals, this.data.refusals);
    const linked = this.linked(),
          on = (name, kind, act) =>
            this.view.querySelectorAll(name).forEach(part => part.addEventListener(kind, act));
    on("select", "change", () => {
      this.fill(this.data.examples[this.example.value]);
      this.rebuild();
    });
    on(".sos-design", "click", () => this.rebuild());
    on("[data-wanted]", "change", () => this.rebuild());
    this.fill(this.data.examples[0]);
    this.built = this.typed;
    super.wire();
    if ("M" in linked) this.open(linked);
  }

  get example() { return this.view.querySelector("select"); }
  area(name) { return this.view.querySelector(`[data-field=${name}]`); }

  // The wishes that are ticked, and the fields that count.
  get wanted() {
    return Object.fromEntries(
      [...this.view.querySelectorAll("[data-wanted]")].map(box => [box.dataset.wanted, box.checked]));
  }
  get matrices() {
    return Object.fromEntries(FIELDS.filter(([, , , box]) => !box || this.wanted[box])
        .map(([name]) => [name, compact(this.area(name).value)]));
  }
  get typed() { return JSON.stringify([this.wanted, this.matrices]); }
  get address() {
    const bounds = Object.entries(this.wanted).filter(([, on]) => on).map(([key]) => key).join(" ");
    return {...this.named, example: this.example.value, ...this.matrices, ...(bounds && {bounds})};
  }

  // The plant of the page's address.
  open(linked) {
    const bounds = (linked.bounds ?? "").split(" "), example = number(linked.example);
    this.example.value = example in this.data.examples ? example : 0;
    this.fill({});
    for (const [name] of FIELDS) this.area(name).value = (linked[name] ?? "").replaceAll(";", "\n");
    this.view.querySelectorAll("[data-wanted]")
      .forEach(box => { box.checked = bounds.includes(box.dataset.wanted); });
    this.rebuild(linked);
  }

  /** @param {any} example */
  fill({request, x0}) {
    const [{M, D, S, B, F = []}] = request?.vertices ?? [{M: [], D: [], S: [], B: []}];
    const values = {M, D, S, B, F, U: request?.U ?? []};
    for (const [name] of FIELDS)
      this.area(name).value = this.area(name).dataset.given = written(values[name] ?? []);
    this.initial = x0;
  }

  // What a wish needs and nobody has typed: weights of one, and the example's x(0).
  complete() {
    const rows = name => {
      try {
        return parsed(name, this.area(name).value);
      } catch { return []; }
    };
    const n = rows("M").length, N = n && 2 * n + rows("U").length;
    const ones = count => Array(count).fill(1), x0 = this.initial?.length === N ? this.initial : [];
    for (const [name, list] of [["x0", x0], ["Q", ones(N)], ["R", ones(rows("B")[0]?.length ?? 0)]]) {
      const area = this.area(name);
      if (area.value === area.dataset.given) area.value = area.dataset.given = list.join(" ");
    }
  }

  rebuild(linked = {}) {
    const {wanted} = this, fault = this.find("fault");
    this.view.querySelectorAll("[data-box]").forEach(field => { field.hidden = !wanted[field.dataset.box]; });
    this.complete();
    fault.textContent = "";
    try {
      const found = requestOf(this.matrices, wanted);
      const same = JSON.stringify(found.request) === JSON.stringify(this.data.request);
      Object.assign(this.data, dataOf(found, wanted, same ? this.found : null, linked));
      this.warning = found.warning;
    } catch (error) {
      if (!(error instanceof Fault)) console.error(error);
      fault.textContent = error instanceof Fault ? error.message : STRANGE;
      this.settle();
      return;
    }
    this.solver.cancel(this.name);
    clearTimeout(this.idle);
    this.built = this.typed;
    this.find("inner").innerHTML = super.markup();
    super.wire();
    this.reserve();
  }

  // Until fields and answer belong together nothing below the fields can be used.
  settle() {
    super.settle();
    const inner = this.find("inner"), old = this.built !== this.typed;
    inner.classList.toggle("sos-locked", old);
    inner.inert = old;
    const note = this.find("note"), words = old ? CHANGED : this.warning ?? "";
    if (note.textContent !== words) note.textContent = words;  // screen readers say it once
  }

  press(what) {
    super.press(what);
    if (what !== "c") return;
    const {answer, digest} = this;
    if (answer?.digest !== digest) this.reply("<p>The design is still being computed: press again.</p>");
    else if (answer.status !== "feasible") this.reply("<p>There is no design here.</p>");
    else this.print(program(answer.K, this.data.shape, this.data.request.U));
  }
}

define("sos-plant", OwnPlant);
