// What the loop of a gain does at every corner, in floats: beside what is proven of it.
import {descriptors, stateSpace} from "../../kernel/descriptor.js";
import {combined, matrix, rowsOf, times} from "../../kernel/matrices.js";
import {gainsOf} from "../../kernel/truth.js";

import {clean} from "./kit.js";
import {apply, block, dot, eigenvalues, eye, pushed, scale, solve, transpose, zeros} from "./linalg.js";

const STEPS = 800, LONG = 8;  // of a motion, and how many time constants it lasts
const NEAR = 0.02;            // of the set point: settled
const FREQUENCIES = 80, HALVINGS = 12;
const NOTHING = 1e-9;  // of the largest coordinate at rest

// Where the plant rests when U z is r: with the smallest such z and u, this measured in a unit in
// which B is as large as S; at z = r where nothing is integrated. No gain has a say in it.
export function rest({M, S, B}, U, r) {
  if (!U.length) return r;
  const n = M.length, [s, b] = [S, B].map(X => Math.max(...X.flat().map(Math.abs)));
  const rows = block([[S, scale(-s / b || -1, B)], [U, zeros(U.length, B[0].length)]]);
  const X = rows.map(row => row.map(x => x / (Math.hypot(...row) || 1))), N = X[0].length;
  const y = r.map((x, k) => [x / Math.hypot(...rows[n + k])]);
  const found =
    solve(block([[eye(N), transpose(X)], [X, zeros(X.length, X.length)]]), [...zeros(N + n, 1), ...y]);
  const z = found.slice(0, n).map(([x]) => x), most = Math.max(...z.map(Math.abs));
  return z.map(x => Math.abs(x) < NOTHING * most ? 0 : Number(x.toPrecision(9)));
}

// The largest sensitivity at the plant's input.
function sensitivity(A, B, K, poles) {
  const sizes = poles.map(s => Math.hypot(...s)), low = Math.min(...sizes) / 10,
        high = Math.max(...sizes) * 10;
  const gain = gainsOf(A, B, K, 1), at = p => gain(low * (high / low) ** p);
  const places = Array.from({length: FREQUENCIES + 1}, (_, k) => k / FREQUENCIES), gains = places.map(at);
  let most = Math.max(...gains), p = places[gains.indexOf(most)], step = 1 / FREQUENCIES;
  for (let k = 0; k < 2 * HALVINGS; k++) {
    const side = [p - step, p + step].map(q => [at(q), q]).reduce((a, b) => b[0] > a[0] ? b : a);
    if (side[0] > most) [most, p] = side;
    else step /= 2;
  }
  return Math.max(1, most);
}

// The whole state at rest, where z is `at`: a law's filters hold what is measured.
export const atRest = ({law, U}, at) => {
  const {filter, position, integrate = U} = law ?? {};
  return [...at, ...at.map(() => 0), ...integrate.map(() => 0), ...(filter ? apply(position, at) : [])];
};

// The worst of all corners for a step of the set point r, to `at`, and loads of one.
export function judged(request, K, r, at) {
  const {U} = request, n = at.length;
  const goals = U.length ? U : eye(n),
        worst = {settled: 0, overshoot: 0, input: 0, load: 0, rest: 0, peak: 1};
  const more = (name, x) => { worst[name] = Math.max(worst[name], x); };
  const most = (run, size) => run.reduce((most, x) => Math.max(most, size(x)), 0);
  for (const d of descriptors(request)) {
    const [A0, B0, W0] = stateSpace(d), gain = matrix(K), loop = combined(1, A0, 1, times(B0, gain));
    const A = rowsOf(loop), poles = eigenvalues(A);
    const slow = LONG / Math.min(...poles.map(([re]) => -re)),
          fast = LONG / Math.max(...poles.map(s => Math.hypot(...s)));
    if (!(slow > 0)) return null;  // a loop that isn't stable
    const push = apply(K, atRest(request, at)).map(x => -x);
    const b = apply(rowsOf(B0), push).map((x, i) => x - (i < 2 * n ? 0 : r[i - 2 * n] ?? 0));
    for (const horizon of [fast, slow]) {
      const run = pushed(A, b, horizon, STEPS), y = run.map(x => goals.map(row => dot(row, x)));
      more("input", most(run, x => Math.hypot(...K.map((row, i) => dot(row, x) + push[i]))));
      r.forEach((goal, i) => {
        if (goal) more("overshoot", most(y, z => z[i] / goal - 1));
      });
      if (horizon !== slow) continue;
      const late = y.findLastIndex(z => z.some((x, i) => Math.abs(x - r[i]) > NEAR * Math.abs(r[i])));
      more("settled", Math.max(0, late) * horizon / STEPS);
    }
    const size = x => {
      let most = 0;
      for (let i = 0; i < n; i++) most = Math.max(most, Math.abs(x[i]));
      return most;
    };
    for (const w of transpose(rowsOf(W0)).filter(column => column.length)) {
      more("rest", size(solve(A, w.map(x => [-x])).flat()));
      for (const horizon of [fast, slow]) more("load", most(pushed(A, w, horizon, STEPS), size));
    }
    more("peak", sensitivity(loop, B0, gain, poles));
  }
  return worst;
}

// What is true beside what was asked, at the worst of all corners.
export function worst({settled, overshoot, input, load, rest, peak}, {vertices: {length, 0: {F}}}) {
  const margin = 2 * Math.asin(Math.min(1, 1 / (2 * peak))) * 180 / Math.PI;
  const moved =
    F ? ` A load of 1 moves z by ${clean(load)}, at rest ${clean(rest < 1e-6 * load ? 0 : rest)}.` : "";
  return `In truth, ${
           length > 1 ? `at worst of ${length} corners` : "in floats"}: a step is within 2 % after ${
           clean(settled)} s, goes ${clean(100 * overshoot, 2)} % over, and takes ${clean(input)}.${moved}` +
    ` The largest sensitivity is ${clean(peak)}, a phase margin of ${clean(margin)}° or more.`;
}
