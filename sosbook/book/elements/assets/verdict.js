// The word at a sentence's end is that of its weakest clause: what the true numbers of a gain say of
// each, and what an exact proof does.
import {descriptors, stateSpace} from "../../kernel/descriptor.js";
import {rowsOf} from "../../kernel/matrices.js";

import {clean} from "./kit.js";
import {eigenvalues, eye, held, mul, part, spectralRadius, zeros} from "./linalg.js";

const NEAR = 1e-6;  // of a bound, to which a gain's true number is computed

// A program's loop from sample to sample: x(k + 1) = A x(k) for x = [z; z'; sums of T U z; late inputs].
function sampled(d, K, {T, delay = 0}) {
  const [A0, B0] = stateSpace(d).map(rowsOf), m = K.length, n = 2 * d.C.rows, N = A0.length;
  const late = Math.floor(delay / T * (1 + 1e-12)), rest = Math.max(0, delay - late * T);
  const A = part(A0, [0, n], [0, n]), B = B0.slice(0, n), [Phi] = held(A, B, T);
  const [after, fresh] = held(A, B, T - rest), before = mul(after, held(A, B, rest)[1]);
  const inputs = late + 1, size = N + m * inputs, next = zeros(size, size);
  const put = (X, i, j) => X.forEach((row, k) => row.forEach((x, l) => { next[i + k][j + l] += x; }));
  // u(k) and the inputs before it, as rows of the state
  const now = K.map(row => [...row, ...Array(m * inputs).fill(0)]);
  const ago = k => k ? eye(size).slice(N + m * (k - 1), N + m * k) : now;
  put(Phi, 0, 0);
  put(mul(before, ago(late + 1)), 0, 0);
  put(mul(fresh, ago(late)), 0, 0);
  put(A0.slice(n).map(row => row.map(x => T * x)), n, 0);
  put(eye(N - n), n, n);
  for (let k = 0; k < inputs; k++) put(ago(k), N + m * k, 0);
  return next;
}

// The largest modulus of a pole of the loops with a clock.
export const radius = (request, K, clock) =>
  Math.max(...descriptors(request).map(d => spectralRadius(eigenvalues(sampled(d, K, clock)))));

// {key, holds, why} of each clause: whether its bound holds for the poles, the norm, the peak and the
// cost of a gain; `holds` is null for what the page doesn't judge, with the reason.
export function clauses(request, clock, {K, poles, norm, peak, cost}) {
  const {sigma, theta, rho, gamma, cost: J, u_max} = request.asked, all = poles.flat();
  const below = (x, bound) => x <= bound * (1 + NEAR);
  const found = {
    sigma: sigma !== undefined && all.every(([re]) => below(sigma, -re)),
    theta:
      theta !== undefined && all.every(([re, im]) => re < 0 && below(Math.atan2(Math.abs(im), -re), theta)),
    rho: rho !== undefined && all.every(s => below(Math.hypot(...s), rho)),
    gamma: gamma !== undefined && below(norm, gamma),
    cost: J !== undefined && below(cost, J),
    u_max: u_max !== undefined && below(peak, u_max)
  };
  const list = Object.entries(found).filter(([key]) => request.asked[key] !== undefined).map(([key,
    holds]) => ({key, holds, exact: true, why: ""}));
  if (clock) {
    const r = radius(request, K, clock), many = clock.measured;
    const why = many ? `An observer from ${many.join(", ")} isn't judged here.`
      : r < 1 ? `The largest pole of the sampled loop is ${clean(r)}: inside of the unit circle, in floats.`
              : `Too slow a clock: the sampled loop isn't stable, its largest pole is ${clean(r)}.`;
    list.push({key: "T", holds: many ? null : r < 1, exact: false, why});
  }
  return list;
}

// The weakest of all: {word, why}; `proven` where an exact proof of the design is known.
export function verdict(status, list, proven) {
  if (status !== "feasible") return {word: status === "infeasible" ? "no design" : "undecided", why: []};
  const broken = list.filter(({holds}) => holds === false);
  if (broken.length)
    return {
      word: "undecided",
      why: broken.map(({key, why}) => why || `The gain that was found breaks the bound of ${key}.`)
    };
  const open = list.filter(({exact}) => !exact), why = open.map(x => x.why);
  if (!proven) return {word: "feasible", why};
  return {word: open.length ? "part proven" : "proven", why};
}
