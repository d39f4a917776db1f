// What an engineer asks for, and the numbers of the theorems: the bounds of a plant.
import {stateSpace} from "../../kernel/descriptor.js";
import {design} from "../../kernel/design.js";
import {eigenvalues} from "../../kernel/spectrum.js";
import {truth} from "../../kernel/truth.js";

import {number} from "./kit.js";
import {degreesOf, shareOf} from "./program.js";
import {valueOf as meant} from "./sentence.js";
import {typed} from "./spoken.js";

const LARGEST = 6, CORNERS = 8;  // degrees of freedom and plants that a browser solves while one waits
const SETTLED = 4;               // e^-4 is 2 %: as `PoleRegion` has it
const ODD = 1e99;                // no number is as large, nor as small

const bound = (symbol, unit, looser = 1, most = ODD) => ({symbol, unit, looser, most});
// The bounds that a page knows, as the package's vocabulary has them; which way they are relaxed.
export const BOUNDS = {
  sigma: bound("σ", " 1/s", -1),
  theta: bound("θ", "°", 1, 90),
  rho: bound("ρ", " 1/s"),
  gamma: bound("γ", ""),
  cost: bound("J", ""),
  u_max: bound("u_max", "")
};

// The value of a bound that an address or a file has; NaN where it is none.
export const boundOf = (key, text) => {
  const x = number(text);
  return x > 1 / ODD && x <= BOUNDS[key].most ? x : NaN;
};

// The nearest value of a bound that a sentence says in few digits: a time, or an overshoot.
export function sayable(key, value, digits) {
  const near = x => Number(x.toPrecision(digits)), share = key === "theta" ? shareOf(value) : 0;
  if (key === "sigma") return SETTLED / near(SETTLED / value);
  if (key === "rho") return 1 / near(1 / value);
  if (key !== "theta") return near(value);
  return near(share) > 0.001 && near(share) < 0.99 ? degreesOf(near(share)) : near(value);
}

// The value of a bound that a text means: in the unit of the clause where it stands, or in one that
// it says itself, an engineer's (s, %) or a theorem's (1/s, degrees); NaN where it is none.
export function valueOf(text, clause, key) {
  const [, plain, unit] = /^\s*(.*?)\s*(%|s|(?<=\s)1\/s|\/s|s⁻¹|°|deg)?\s*$/.exec(text);
  if (Number.isNaN(typed(plain))) return NaN;
  const own = {s: {over: {sigma: SETTLED, rho: 1}[key]}, "%": {key: "overshoot", shift: -2}}[unit];
  const how = own ?? (unit ? {} : clause), given = meant(how, plain);
  const value = how.key === "overshoot" ? degreesOf(given) : given;
  return boundOf(key, value);
}

// Plants that are too large or too many for a browser aren't solved here: what to do is said.
export function beyond({request: {vertices}, law, outputs}, live = false) {
  const take = "As Python and As JSON write what the package takes.";
  if (outputs) return `This page bounds what w does to z alone. ${take}`;
  if (law?.structure && !live) return `This page searches gains whose entries are all free. ${take}`;
  if (vertices[0].M?.length > LARGEST)
    return `This page computes with up to ${LARGEST} degrees of freedom. ${take}`;
  return vertices.length > CORNERS ? `This page computes with up to ${CORNERS} corners. ${take}` : "";
}

// The bounds of a plant whose poles have such a size: at first three times what a design does
// that has none of them.
export function starts(found, omega, wanted) {
  const {request, x0, cost} = found, plain = x => Number(x.toPrecision(2));
  const list = {sigma: sayable("sigma", plain(0.2 * omega), 2), theta: 60, rho: plain(8 * omega)};
  /** @type {any} */
  const now = {};
  if ((wanted.gamma || cost || x0) && !beyond(found)) {
    /** @type {any} */
    const known = design({...request, asked: {...list, theta: Math.PI / 3}}, null, true);
    const start = x0 && {x0: x0.slice(0, known.K?.[0].length)};  // without a law's filters
    if (known.K) Object.assign(now, truth({...request, asked: {...(!found.law && cost), ...start}}, known));
  }
  const asked = {gamma: [wanted.gamma, now.norm, 1], cost: [cost, now.cost, 100], u_max: [x0, now.peak, 10]};
  for (const [key, [on, size, usual]] of Object.entries(asked))
    if (on) list[key] = plain(3 * (size > 0 ? size : usual));
  return Object.entries(list).map(([key, value]) => ({key, value, moves: true}));
}

// The geometric mean of the plant's poles that aren't at rest.
export function typicalRate(d) {
  const [A, B] = stateSpace(d), rates = eigenvalues(A).map(s => Math.hypot(...s)).filter(x => x > 1e-6);
  const omega = rates.length ? Math.exp(rates.reduce((sum, x) => sum + Math.log(x), 0) / rates.length) : 1;
  return {omega, A, B};
}
