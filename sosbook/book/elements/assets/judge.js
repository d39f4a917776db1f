// What the loop of a gain does at every corner, in floats: beside what is proven of it.
import {descriptors, stateSpace} from "../../kernel/descriptor.js";
import {combined, matrix, rowsOf, times} from "../../kernel/matrices.js";
import {gainAt} from "../../kernel/truth.js";

import {clean, escape, printed} from "./kit.js";
import {add, apply, block, eigenvalues, eye, mul, pushed, scale, solve, transpose} from "./linalg.js";

const STEPS = 800, LONG = 8;  // of a motion, and how many time constants it lasts
const NEAR = 0.02;            // of the set point: settled
const FREQUENCIES = 80, HALVINGS = 12;
const RIDGE = 1e-9;  // of the free entries: the smallest of those that are as quiet

// The set point with U z = r whose K_P z is least; all of z where nothing is integrated.
export function quiet(U, K, r) {
  if (!U.length) return r;
  const n = U[0].length, K_P = K.map(row => row.slice(0, n)), H = mul(transpose(K_P), K_P);
  const size = RIDGE * (Math.max(...H.map((row, i) => row[i])) || 1);
  const X = block([[add(H, scale(size, eye(n))), transpose(U)], [U, U.map(() => U.map(() => 0))]]);
  const z = solve(X, [...H.map(() => [0]), ...r.map(x => [x])]);
  return z.slice(0, n).map(([x]) => x);
}

// A motion x' = A x + b from rest, [t, x] at equal times.
const motion = (A, b, horizon) => pushed(A, b, horizon, STEPS).map((x, k) => [k * horizon / STEPS, x]);

// The largest sensitivity at the plant's input.
function sensitivity(A, B, K, poles) {
  const sizes = poles.map(s => Math.hypot(...s)), low = Math.min(...sizes) / 10,
        high = Math.max(...sizes) * 10;
  const at = p => gainAt(A, B, K, low * (high / low) ** p, 1);
  const places = Array.from({length: FREQUENCIES + 1}, (_, k) => k / FREQUENCIES), gains = places.map(at);
  let most = Math.max(...gains), p = places[gains.indexOf(most)], step = 1 / FREQUENCIES;
  for (let k = 0; k < 2 * HALVINGS; k++) {
    const side = [p - step, p + step].map(q => [at(q), q]).reduce((a, b) => b[0] > a[0] ? b : a);
    if (side[0] > most) [most, p] = side;
    else step /= 2;
  }
  return Math.max(1, most);
}

// The worst of all corners for a step of the set point and loads of one: what its numbers
// are called stands in `table`. `ends` is where the first corner comes to rest.
export function judged(request, K, r) {
  const {U, vertices: [{M}]} = request, n = M.length, at = quiet(U, K, r);
  const goals = U.length ? U : eye(n),
        worst = {settled: 0, overshoot: 0, input: 0, load: 0, rest: 0, peak: 1};
  const more = (name, x) => { worst[name] = Math.max(worst[name], x); };
  /** @type {any} */
  let ends = null;
  for (const d of descriptors(request)) {
    const [A0, B0, W0] = stateSpace(d), gain = matrix(K), loop = combined(1, A0, 1, times(B0, gain));
    const A = rowsOf(loop), B = rowsOf(B0), poles = eigenvalues(A);
    const slow = LONG / Math.min(...poles.map(([re]) => -re)),
          fast = LONG / Math.max(...poles.map(s => Math.hypot(...s)));
    if (!(slow > 0)) return null;  // a loop that isn't stable
    const push = K.map(row => -row.slice(0, n).reduce((sum, k, i) => sum + k * at[i], 0));
    const b = apply(B, push).map((x, i) => x - (i < 2 * n ? 0 : r[i - 2 * n]));
    for (const horizon of [fast, slow]) {
      const run = motion(A, b, horizon), y = x => apply(goals, x.slice(0, n));
      for (const [, x] of run) {
        more("input", Math.hypot(...apply(K, x).map((u, i) => u + push[i])));
        y(x).forEach((z, i) => {
          if (r[i]) more("overshoot", z / r[i] - 1);
        });
      }
      if (horizon !== slow) continue;
      const late = run.findLast(([, x]) => y(x).some((z, i) => Math.abs(z - r[i]) > NEAR * Math.abs(r[i])));
      more("settled", late ? late[0] : 0);
      ends ??= run.at(-1)[1].slice(0, n);
    }
    for (const w of transpose(rowsOf(W0)).filter(column => column.length)) {
      for (const horizon of [fast, slow]) {
        const run = motion(A, w, horizon), size = x => Math.max(...x.slice(0, n).map(Math.abs));
        for (const [, x] of run) more("load", size(x));
        if (horizon === slow) more("rest", size(run.at(-1)[1]));
      }
    }
    more("peak", sensitivity(loop, B0, gain, poles));
  }
  return {...worst, r: at, ends};
}

const percent = share => `${clean(100 * share, 2)} %`;

// The numbers in words, beside what was asked: rows of HTML.
export function table({settled, overshoot, input, load, rest, peak, r, ends}, asked, corners, F, unit) {
  const margin = 2 * Math.asin(Math.min(1, 1 / (2 * peak))) * 180 / Math.PI;
  const wish = (bound, words) => bound === undefined ? "" : words(bound);
  const rows = [
    [
      "Settles within 2 %", `${clean(settled)} s`,
      wish(asked.sigma, x => `poles decay within 4/σ = ${clean(4 / x)} s`)
    ],
    [
      "Overshoot", percent(overshoot),
      wish(asked.theta, x => `${percent(Math.exp(-Math.PI / Math.tan(x)))} of one mode alone`)
    ],
    ["Largest input on the way", clean(input), wish(asked.u_max, x => `${clean(x)} from x(0), with r = 0`)],
    ...(F ? [[
      "A load of 1 moves z by", `${clean(load)}, at rest ${clean(rest < 1e-6 * load ? 0 : rest)}`,
      wish(asked.gamma, x => `γ = ${clean(x)} of a load that swings`)
    ]]
          : []),
    ["Largest sensitivity", clean(peak), `a phase margin of ${clean(margin)}° or more`]
  ];
  const line = (tag, cells) =>
    `<tr>${cells.map(x => `<${tag}>${escape(printed(x))}</${tag}>`).join("")}</tr>`;
  const point = r.some((x, i) => Math.abs(x - ends[i]) > 1e-3 * Math.max(...ends.map(Math.abs), 1e-9))
    ? ` What isn't integrated may have any entry in r: r = (${
        r.map(x => clean(x)).join(", ")}) asks least of K_P.`
    : "";
  return `<table class="sos-truth"><caption>A step of ${unit}, ${
           corners > 1 ? `the worst of ${corners} corners`
                       : "computed"}: true in floats, not proven.${point}</caption>` +
    line("th", ["of the loop", "true", "asked"]) + rows.map(row => line("td", row)).join("") + "</table>";
}
