// What a worker finds and proves for a law, one descent or cell after another: gains, bounds that would do
// where there are none, and the cells of a proof.
import {wholeOf} from "../../kernel/law.js";

import {clean, printed} from "./kit.js";
import {own} from "./solver.js";
import {BOUNDS, sayable} from "./wishes.js";

const STARTS = 16, FEW = 7;       // descents of a search, and of one that relaxes a bound
const KEPT = 3;                   // that keep all: the best of these is taken
const SECONDS = 20;               // of either
const ENOUGH = -0.0199;           // of the rate: with so much room a search ends
const AGAIN = 6;                  // searches, each with one more plant between the corners
const CELLS = 64;                 // that are tried for a bound
const LOOSER = [1.02, 1.1, 1.3];  // times what was reached is offered
const TRUE = {
  gamma: "norm",
  cost: "cost",
  u_max: "peak"
};
export const EXACT = ["sigma", "theta", "rho"];
const CLAIMS = {
  sigma: "every pole decays with",
  gamma: "the norm from w to z is below",
  cost: "the cost is below",
  u_max: "from x(0) the input stays within"
};

const degrees = x => x * 180 / Math.PI;

// The best of some descents, {K, value, off, reached, starts}; null where `stale`.
async function best(name, request, {most = STARTS, near = null, stale, told = _ => {}}) {
  const end = performance.now() + 1000 * SECONDS;
  let found = null, kept = 0;
  for (let start = 0; start < most && (!start || performance.now() < end); start++) {
    told(start);
    const job = {...request, start, near: start ? null : near};
    const next = await own.search(name, "descent", job);
    if (!next || stale()) return null;
    if (!(next.value >= found?.value)) found = next;
    Object.assign(found, {starts: start + 1});
    if (!request.goal && (found.value <= ENOUGH || (kept += Number(next.value < 0)) === KEPT)) break;
  }
  return found;
}

// {status, gains, own, K, poles, norm, peak, cost}, or {status, near, reason}: what the search ended with.
export const sought = async (name, request, how) => {
  const begun = performance.now(), points = [],
        said = () => `${found.starts} starts in ${((performance.now() - begun) / 1000).toPrecision(2)} s`;
  let found = null;
  for (let count = 0; count < AGAIN; count++) {
    found = await best(name, {...request, points}, {...how, near: found?.K});
    if (!found) return null;
    const none = `No gains were found by ${said()}; that proves nothing.`;
    if (!(found.value < 0))
      return {status: "undecided", near: found.K, reached: found.reached, gains: null, reason: none};
    const {point = null} = await own.search(name, "between", {...request, K: found.K}) ?? {};
    if (how.stale()) return null;
    if (point) points.push(point);
    else {
      const judged = await own.search(name, "judged", {...request, K: found.K});
      if (!judged || how.stale()) return null;
      return {status: "feasible", own: found.K, by: "", ms: performance.now() - begun, ...judged};
    }
  }
  const reason =
    `Gains for the corners were found, none for the plants between, by ${said()}; that proves nothing.`;
  return {status: "undecided", near: found.K, reached: found.reached, gains: null, reason};
};

// Bounds that would do, each alone: [{key, from, to}], found and tried as they stand.
export const relaxed = async (name, bounds, requestAt, {near, reached, stale}) => {
  const offers = [], how = {most: FEW, stale};
  for (const key of Object.keys(bounds)) {
    const request = requestAt(bounds), {[key]: _, ...asked} = request.asked, plain = EXACT.includes(key);
    const found = await best(name, plain ? {...request, goal: key} : {...request, asked}, {...how, near});
    if (stale()) return null;
    if (!found || !((plain ? found.off : found.value) < 0)) continue;
    const judged = plain ? null : await own.search(name, "judged", {...request, K: found.K});
    const size = !plain ? judged?.[TRUE[key]]
      : key === "theta" ? degrees(found.reached.theta)
                        : found.reached[key];
    if (await offer(key, {[key]: size})) return null;
  }
  const broken = EXACT.filter(key => key in bounds &&
      !(key === "sigma" ? reached[key] > bounds[key] : sizeOf(key, reached) < bounds[key]));
  if (broken.length > 1 &&
    await offer("several", Object.fromEntries(broken.map(key => [key, sizeOf(key, reached)]))))
    return null;
  return offers;

  // Offers bounds that are a little looser than these, if the search finds gains for them as they stand; true
  // where the question is another by now.
  async function offer(key, sizes) {
    for (const more of LOOSER) {
      const to = Object.fromEntries(Object.entries(sizes).map(
        ([key, size]) => [key, sayable(key, key === "sigma" ? size / more : size * more, 2)]));
      if (!Object.entries(to).every(([key, x]) => x > 0 && x <= BOUNDS[key].most)) return stale();
      const known = await sought(name, requestAt({...bounds, ...to}), {stale});
      if (!known) return true;
      if (known.status !== "feasible") continue;
      offers.push({key, from: bounds[key], to});
      break;
    }
    return false;
  }
};
const sizeOf = (key, reached) => key === "theta" ? degrees(reached.theta) : reached[key];

// {key: how many cells prove it, or 0} of what is asked; null where `stale`.
export const proven = async (name, request, K, stale) => {
  const cells = {};
  for (const key of Object.keys(BOUNDS)) {
    if (request.asked[key] === undefined) continue;
    const needs = {cost: ["Q", "R", "noise"], u_max: ["x0"]}[key] ?? [], open = [wholeOf(request)];
    const asked = Object.fromEntries([key, ...needs].map(name => [name, request.asked[name]]));
    cells[key] = 0;
    for (let tried = 1; open.length; tried++) {
      const found = await own.prove(name, "cell", {...request, asked, K, cell: open.shift()});
      if (!found || stale()) return null;
      open.push(...found.halves);
      if (found.proven) cells[key]++;
      else if (tried === CELLS || !found.halves.length) {
        cells[key] = 0;
        break;
      }
    }
  }
  return cells;
};

// What cells and floats are worth for each clause.
export const weighed = (clauses, cells) => clauses.map(clause => {
  const {key} = clause;
  if (key === "T") return clause;
  const why =
    cells[key] ? "" : `${BOUNDS[key].symbol} isn't proven by this page, which tries ${CELLS} cells.`;
  return {...clause, exact: !why, why};
});

// What is proven, a line for each bound.
export const claims = (asked, cells) =>
  Object.entries(cells)
    .filter(([, count]) => count)
    .map(([key, count]) => `${CLAIMS[key] ?? "every pole lies within"} ${BOUNDS[key].symbol} = ${
           clean(key === "theta"
               ? degrees(asked.theta)
               : asked[key])}${printed(BOUNDS[key].unit)}, in ${count} ${count > 1 ? "cells" : "cell"}`);
