// What an engineer asks for, and the numbers of the theorems: the sliders of a plant.
import {stateSpace} from "../../kernel/descriptor.js";
import {design} from "../../kernel/design.js";
import {eigenvalues} from "../../kernel/spectrum.js";
import {truth} from "../../kernel/truth.js";

import {BOUNDS} from "./explorer.js";
import {clean, number, printed, QUIET} from "./kit.js";

const LARGEST = 6, CORNERS = 8;  // degrees of freedom and plants that a browser solves while one waits
const SETTLED = 4;               // e^-4 is 2 %: as `PoleRegion` has it
const FURTHEST = 1e3;            // times the end of a slider that a number may be typed

// By the name of a bound: words before and behind its number, from the words' number to the one
// that is shown, and back.
const WORDS = {
  sigma: ["settles every mode in", "s", time => SETTLED / time, sigma => SETTLED / sigma],
  theta: [
    "lets no mode overshoot", "%", share => Math.atan2(Math.PI, -Math.log(share / 100)) * 180 / Math.PI,
    theta => 100 * Math.exp(-Math.PI / Math.tan(theta * Math.PI / 180))
  ],
  rho: ["reacts no faster than", "s", time => 1 / time, rho => 1 / rho]
};

// A number that a reader types, perhaps with a decimal comma.
export const typed = text => number(text.trim().replace(/^([^.,]*),([^.,]*)$/, "$1.$2"));

// The fields beside a slider: its number, and the same in words.
export function fields(name, k, {key, symbol, unit}) {
  const field = (kind, before, behind) =>
    `<label>${printed(before)} <input type="text" inputmode="decimal" size="7" id="${name}-${kind}-${
      k}" data-${kind}="${k}" ${QUIET}>${printed(behind)}</label>`;
  const [before, behind] = WORDS[key] ?? [];
  return `<div class="sos-typed">${field("number", `${symbol} =`, unit)}${
    before ? field("words", before, ` ${behind}`) : ""}</div>`;
}

// What stands in a field of a slider whose value is so much, and the value that a text means.
export const shownIn = ({words}, {key}, value) =>
  clean(words === undefined ? value : WORDS[key][3](value), 4);
export function valueOf({words = undefined}, {key, ends, min, max}, text) {
  const [low, high] = ends ?? [min, max];
  const given = typed(text), value = words === undefined ? given : WORDS[key][2](given);
  const most = key === "theta" ? 90 : FURTHEST * high;
  return value >= (key === "theta" ? 1 : low / FURTHEST) && value <= most ? Number(value.toPrecision(6))
                                                                          : NaN;
}
// A slider reaches what is typed, and no further than it did where that is within its own ends.
export function widen(slider, value) {
  slider.ends ??= [slider.min, slider.max];
  slider.min = Math.min(slider.ends[0], value);
  slider.max = Math.max(slider.ends[1], value);
}

// Two digits are enough for the end of a slider.
const plain = x => Number(x.toPrecision(2));
const slider = (key, min, max, value) =>
  ({key, ...BOUNDS[key], min: plain(min), max: plain(max), value: plain(value)});

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
