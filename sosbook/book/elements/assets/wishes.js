// What an engineer asks for, and the numbers of the theorems: the sliders of a plant.
import {stateSpace} from "../../kernel/descriptor.js";
import {design} from "../../kernel/design.js";
import {eigenvalues} from "../../kernel/spectrum.js";
import {truth} from "../../kernel/truth.js";

import {BOUNDS} from "./explorer.js";
import {number} from "./kit.js";
import {degreesOf, shareOf} from "./program.js";
import {valueOf as meant} from "./sentence.js";

const LARGEST = 6, CORNERS = 8;  // degrees of freedom and plants that a browser solves while one waits
const SETTLED = 4;               // e^-4 is 2 %: as `PoleRegion` has it
const FURTHEST = 1e3;            // times the end of a slider that a number may be typed

// A number that a reader types, perhaps with a decimal comma.
export const typed = text => number(text.trim().replace(/^([^.,]*),([^.,]*)$/, "$1.$2"));

// The nearest value of a slider that a sentence says in few digits: a time, or an overshoot.
export function sayable(key, value, digits) {
  const near = x => Number(x.toPrecision(digits)), share = key === "theta" ? shareOf(value) : 0;
  if (key === "sigma") return SETTLED / near(SETTLED / value);
  if (key === "rho") return 1 / near(1 / value);
  return key === "theta" && near(share) > 0.001 && near(share) < 0.99 ? degreesOf(near(share)) : value;
}

// The value of a slider that a text means: in the unit of the clause where it stands, or in one that
// it says itself, an engineer's (s, %) or a theorem's (1/s, degrees); NaN where it is none.
export function valueOf(text, clause, {key, ends, min, max}) {
  const [, plain, unit] = /^\s*(.*?)\s*(%|s|1?\/s|s⁻¹|°|deg)?\s*$/.exec(text),
                  [low, high] = ends ?? [min, max];
  if (Number.isNaN(typed(plain))) return NaN;
  const own = {s: {over: {sigma: SETTLED, rho: 1}[key]}, "%": {key: "overshoot", shift: -2}}[unit];
  const how = own ?? (unit ? {} : clause), given = meant(how, plain);
  const value = how.key === "overshoot" ? degreesOf(given) : given,
        most = key === "theta" ? 90 : FURTHEST * high;
  return value >= (key === "theta" ? 1 : low / FURTHEST) && value <= most ? value : NaN;
}
// A slider reaches what is typed, and no further than it did where that is within its own ends.
export function widen(slider, value) {
  slider.ends ??= [slider.min, slider.max];
  slider.min = Math.min(slider.ends[0], value);
  slider.max = Math.max(slider.ends[1], value);
}

// Two digits are enough for the end of a slider.
const plain = x => Number(x.toPrecision(2));
const slider = (key, min, max, value) => ({
  key,
  ...BOUNDS[key],
  min: plain(min),
  max: plain(max),
  value: key === "sigma" ? sayable(key, plain(value), 2) : plain(value)
});

// Plants that are too large or too many for a browser aren't solved here: what to do is said.
export function beyond({request: {vertices}, x0, cost, law, outputs}) {
  const take = "As Python and As JSON write what the package takes.";
  if (outputs) return `This page bounds what w does to z alone. ${take}`;
  if (law && (x0 || cost)) return `This page bounds neither input nor cost of a law. ${take}`;
  if (vertices[0].M?.length > LARGEST)
    return `This page computes with up to ${LARGEST} degrees of freedom. ${take}`;
  return vertices.length > CORNERS ? `This page computes with up to ${CORNERS} corners. ${take}` : "";
}

// The sliders of a plant whose poles have such a size. Bounds start at three times what a
// design without bounds does.
export function sliders(found, omega, wanted) {
  const {request, x0, cost} = found;
  /** @type {any} */
  const now = {};
  const bound = (size, usual) => {
    const typical = size > 0 ? size : usual;
    return [typical / 20, typical * 50, typical * 3];
  };
  const list = [
    slider("sigma", 0.02 * omega, 2 * omega, 0.2 * omega), slider("theta", 10, 90, 60),
    slider("rho", omega, 40 * omega, 8 * omega)
  ];
  if ((wanted.gamma || cost || x0) && !beyond(found)) {
    const [sigma, theta, rho] = list.map(({value, degrees}) => degrees ? value * Math.PI / 180 : value);
    /** @type {any} */
    const known = design({...request, asked: {sigma, theta, rho}}, null, true);
    if (known.K) Object.assign(now, truth({...request, asked: {...cost, ...(x0 && {x0})}}, known));
  }
  if (wanted.gamma) list.push(slider("gamma", ...bound(now.norm, 1)));
  if (cost) list.push(slider("cost", ...bound(now.cost, 100)));
  if (x0) list.push(slider("u_max", ...bound(now.peak, 10)));
  return list;
}

// The geometric mean of the plant's poles that aren't at rest.
export function typicalRate(d) {
  const [A, B] = stateSpace(d), rates = eigenvalues(A).map(s => Math.hypot(...s)).filter(x => x > 1e-6);
  const omega = rates.length ? Math.exp(rates.reduce((sum, x) => sum + Math.log(x), 0) / rates.length) : 1;
  return {omega, A, B};
}
