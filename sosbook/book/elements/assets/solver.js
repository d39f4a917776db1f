// One worker for a page, which solves what its elements ask for: the kernel's own text
// runs in it, so it needs no file. Where there are no workers, the page itself computes.
import {line} from "./line.js";

/** @type {any} */
const {sosKernel} = globalThis;  // the kernel's modules as one function

// The worker's program: {id, key, kind, request} in, {id, ...} out.
function program(kernel, send) {
  const STRANGE =
    "The page's solver can't compute with these numbers: choose other units, or take the package.";
  const last = new Map();  // the last design of each element, to start from
  return ({id, key, kind, request}) => {
    const begun = performance.now();
    try {
      if (kind in kernel.OF_LAW) return send({id, ...kernel.OF_LAW[kind](request)});
      if (request.law) return send({id});  // which the package left unanswered
      const found = kernel.design(request, last.get(key), kind === "probe");  // its refusals needn't be exact
      const {status, K, poles, margins, reason, bounded, steps} = found;
      const answer = {id, status, K, poles, margins, reason, bounded, steps};
      if (status === "feasible") {
        if (kind === "move") last.set(key, found);
        if (kind !== "probe") Object.assign(answer, kernel.truth(request, found));
        if (kind === "prove") {
          const {proven, text, claims, blocks, digits} = kernel.prove(request, found);
          answer.proof = {proven, text, claims, blocks, digits};
        }
      } else if (kind === "prove" && found.refusal) answer.proof = kernel.refusalFile(request, found.refusal);
      send({...answer, ms: performance.now() - begun});
    } catch (fault) {
      console.error(fault);
      send({id, status: "undecided", reason: STRANGE});
    }
  };
}

function start(receive) {
  try {
    const text = `"use strict"; const run = (${program})((${sosKernel})(), postMessage);` +
      `onmessage = event => run(event.data);`;
    const worker = new Worker(URL.createObjectURL(new Blob([text], {type: "text/javascript"})));
    worker.onmessage = event => receive(event.data);
    return job => worker.postMessage(job);
  } catch {
    const run = program(sosKernel(), receive);
    return job => setTimeout(() => run(job));
  }
}

// One job at a time; the newest move of an element takes the place of those that wait.
function queue(open) {
  let waiting = [], busy = null, count = 0, post = null;
  function next() {
    if (busy || !waiting.length) return;
    const first = Math.max(0, waiting.findIndex(({job}) => job.kind !== "probe"));
    [busy] = waiting.splice(first, 1);
    post ??= open(answer => {
      const {resolve} = busy;
      busy = null;
      resolve(answer);
      next();
    });
    post(busy.job);
  }

  // A promise of the answer; null where a newer job takes its place.
  function ask(key, kind, request) {
    if (kind === "move") cancel(key);
    return new Promise(resolve => {
      waiting.push({job: {id: ++count, key, kind, request}, resolve});
      next();
    });
  }

  function cancel(key) {
    waiting = waiting.filter(({job, resolve}) => job.key !== key || job.kind === "prove" || resolve(null));
  }
  return {ask, cancel};
}

const page = queue(start), proofs = queue(start);  // nobody waits for a proof that nobody asked for

// What is computed here even where the package has a line.
export const own = {
  search: page.ask,
  prove: proofs.ask
};
// Who answers an element, and who proves: the package where it has a line, else this page.
export function solverOf(element, prover = false) {
  const home = element.closest(".sos-live");
  return home ? home.sosQueue ??= queue(line(home, start)) : prover ? proofs : page;
}
