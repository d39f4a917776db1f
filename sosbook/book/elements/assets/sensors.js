// A motor that turns a load by a shaft which gives: the reader ticks what is measured.
// What was found and proven comes from the package; poles and motion are computed here.
import {capital, clean, define, escape, round} from "./kit.js";
import {add, eigenvalues, motion, mul, rightmost, solve, spectralRadius, trace, zeros} from "./linalg.js";
import {Mover, number, samples, series, verdict} from "./mover.js";
import {mark, picture} from "./plot.js";

const SECONDS = 3, STEPS = 600;
const GAINS = ["K_P", "K_D", "K_I"], PAIRS = [[0, 0], [1, 0], [0, 1], [1, 1]];
const LOADS = ["lightest", "heaviest"];
const DISCS = [[74, 44, 30], [266, 44, 36]];  // x, y and radius of motor and load
/** @type {any[][]} */
const SENSORS = [["p1", "φ₁", 44], ["v1", "φ₁′", 104], ["p2", "φ₂", 236], ["v2", "φ₂′", 296]];

/** @type {(place: any, kind: string) => number[]} */
const ticked = (place, kind) => [0, 1].filter(i => place[`${kind}${i + 1}`]);

// Under what a choice of ticks is found; each part counts where it means something.
/** @type {(place: any) => string} */
function name({p1, p2, v1, v2, integral, filter}) {
  const angles = p1 || p2, rates = v1 || v2;
  return `${p1}${p2}${v1}${v2}${angles ? integral : 0}${angles && !rates ? filter : 0}`;
}

class Sensors extends Mover {
  get horizon() { return SECONDS; }
  get still() { return 0.12; }

  figures() {
    return [
      ["scene", "Tick a sensor here or above. Blue hand: the heaviest load, pale: the lightest. True speed."],
      [
        "choices",
        "Best decay σ (s⁻¹) that the package found and proved for each choice, with this filter and integral. Choose a cell."
      ],
      [
        "poles",
        "Poles of your loop: crosses with the heaviest load, circles with the lightest. Shaded: left of the σ that was proven. Dotted: the mean of the poles, where no gain moves it."
      ],
      ["angle", "The load's angle φ₂ from 1 rad at rest. Blue: heaviest load, orange: lightest."]
    ];
  }

  good({right}) { return right.every(x => x < -1e-6 * this.size); }
  get means() { return "the loop is stable with both loads"; }

  // The loop x' = A x of a plant, x = [z; z'; integral; lagging angles], and u = k x.
  loop({M, D, S, B}, place, K) {
    const angles = ticked(place, "p"), rates = ticked(place, "v");
    const lagging = rates.length ? [] : angles, tau = this.data.filters[place.filter];
    const sum = angles.length ? place.integral : 0, N = 4 + sum + lagging.length;
    const A = zeros(N, N), u = Array(N).fill(0);
    angles.forEach((i, k) => { u[i] += K.K_P[k]; });
    rates.forEach((i, k) => { u[2 + i] += K.K_D[k]; });
    lagging.forEach((i, k) => {
      const row = 4 + sum + k;
      u[i] += K.K_D[k] / tau;
      u[row] -= K.K_D[k] / tau;
      A[row][i] += 1 / tau;
      A[row][row] -= 1 / tau;
    });
    if (sum) {
      u[4] += K.K_I[0];
      A[4][angles[0]] = 1;
    }
    const push = [...zeros(2, N), ...mul(solve(M, B), [u]), ...zeros(N - 4, N)];
    motion(M, D, S).forEach((row, i) => row.forEach((a, j) => { A[i][j] += a; }));
    return add(A, push);
  }

  // The gains: the sliders' factors times what was found; where nothing was, times a tenth of the limits.
  gains(place) {
    const count = {
      K_P: ticked(place, "p").length,
      K_D: ticked(place, "v").length || ticked(place, "p").length
    };
    count.K_I = count.K_P && place.integral;
    const found = this.data.found[name(place)];
    return Object.fromEntries(GAINS.map(k => {
      const start = found?.gains?.[k] ?? Array(count[k]).fill(-this.data.limits[k] / 10);
      return [k, start.slice(0, count[k]).map(x => place[k] * x)];
    }));
  }

  compute(place) {
    const {plants} = this.data, K = this.gains(place),
          loops = plants.map(plant => this.loop(plant, place, K));
    const poles = loops.map(eigenvalues), means = loops.map(A => trace(A) / A.length);
    const none = Object.fromEntries(GAINS.map(k => [k, K[k].map(() => 0)]));
    const moved = GAINS.some(k => K[k].some((_, i) => {
      const one = {...none, [k]: none[k].map((_, j) => i === j ? 1 : 0)};
      const change = trace(this.loop(plants[0], place, one)) - trace(this.loop(plants[0], place, none));
      return Math.abs(change) > 1e-9 * this.size;
    }));
    const start = [1, 1, 0, 0, ...(ticked(place, "p").length && place.integral ? [0] : [])];
    const runs = loops.map(A => {
      const x = [...start, ...Array(A.length - start.length).fill(1)];
      return samples(A, A.map(() => [0]), x, Array(STEPS).fill([0]), SECONDS / STEPS);
    });
    return {
      K,
      poles,
      right: poles.map(rightmost),
      limit: moved ? null : Math.min(...means.map(x => -x)),
      means,
      angles: runs.map(run => run.map(x => x.slice(0, 2)))
    };
  }

  wire() {
    const none = {p1: 0, p2: 0, v1: 0, v2: 0, integral: 0, filter: 0};
    const free =
      this.data.plants.map(plant => eigenvalues(this.loop(plant, none, {K_P: [], K_D: [], K_I: []})));
    this.size = Math.max(...free.map(spectralRadius));
    super.wire();
    this.view.addEventListener("click", ({target}) => {
      const {tick, cell} = target.closest("[data-tick], [data-cell]")?.dataset ?? {};
      if (tick) this.choose({[tick]: 1 - this.place[tick]});
      if (cell)
        this.choose(Object.fromEntries(["p1", "p2", "v1", "v2"].map((key, k) => [key, Number(cell[k])])));
    });
  }

  update() {
    super.update();
    const place = this.place, {K} = this.result;
    for (const key of GAINS) this.inputs[key].disabled = !K[key].length;
    this.inputs.integral.disabled = !ticked(place, "p").length;
    this.inputs.filter.disabled = ticked(place, "v").length > 0;
  }

  show(result, ghost, place) {
    const found = this.data.found[name(place)];
    this.tell(...this.said(result, place, found));
    this.scene(place);
    this.choices(place);
    this.map(result, ghost, found);
    this.curves("angle", {
      y: [-1.3, 1.3],
      labels: "φ₂ (rad)",
      label: "The load's angle over time, with the lightest and the heaviest load",
      lines: [...result.angles].reverse().map((run, k) => ({
        points: series(run.map(x => x[1]), SECONDS / STEPS, 3),
        colour: k ? "--sos-second" : "--sos-first"
      }))
    });
  }

  said({K, right, limit}, place, found) {
    const proven = found?.status === "feasible", kept = this.good({right});
    const used = GAINS.filter(k => K[k].length), same = used.every(k => place[k] === 1);
    const worst = right.indexOf(Math.max(...right));
    const state = kept ? "feasible" : found?.status === "undecided" ? "undecided" : "infeasible";
    const words = !found ? "Nothing is measured, so no gain moves a pole."
      : !proven          ? `${capital(found.status)}. ${escape(found.reason)}`
      : !kept ? `Unstable with the ${LOADS[worst]} load.`
      : same
      ? `Proven by the package for every load of the range: σ = ${clean(found.sigma)} s⁻¹.`
      : "Stable with both loads, as this page's eigenvalues tell. Nothing is proven of the loads between.";
    const list = k => K[k].map(x => clean(x)).join(", ");
    const gains = used.map(k => `K<sub>${k[2]}</sub> = ${number(0, "").replace(/>.*</, `>${list(k)}<`)}`);
    const sum = limit === null ? "A gain moves the sum of the poles."
                               : `No gain of these sensors moves the sum of the poles: none decays with ${
                                   number(limit, " s⁻¹")} or faster.`;
    return [
      state,
      verdict(words) +
        `<p>${gains.join("; ") || "No gain"}. Your slowest pole: ${
          right.map((x, k) => `${number(x, " s⁻¹")} with the ${LOADS[k]} load`).join(", ")}.</p><p>${sum}</p>`
    ];
  }

  scene(place) {
    const [[x, y, r], [u, v, s]] = DISCS;
    /** @type {(place: any, words: string) => string} */
    const disc = ([cx, cy, size], words) => `<circle class="sos-part" cx="${cx}" cy="${cy}" r="${size}"/>` +
      `<text x="${cx}" y="${cy + size + 14}" text-anchor="middle">${words}</text>`;
    const hands =
      DISCS.flatMap(([cx, cy, size], i) => LOADS.map(
                      (_, k) => `<path class="sos-line sos-turn" data-disc="${i}" data-load="${
                        k}" style="stroke-width:3;stroke:var(--sos-${k ? "first" : "second"});opacity:${
                        k ? 1 : 0.45}" d="M${cx} ${cy}V${cy - size + 4}"/>`));
    const sensors =
      SENSORS.map(([key, words, at]) =>
                    `<g data-tick="${key}"><rect class="sos-sensor${place[key] ? " sos-on" : ""}" x="${
                      at - 24}" y="106" width="48" height="26" rx="5"/>` +
          `<text x="${at}" y="123" text-anchor="middle">${words}</text></g>`);
    this.find("scene").innerHTML = picture(140,
      `A motor and a load on a shaft; measured: ${
        SENSORS.filter(([key]) => place[key]).map(([, words]) => words).join(", ") || "nothing"}`,
      `<path class="sos-thin sos-shaft"/><path class="sos-thin" d="M${x} ${y + r + 18}V106M${u} ${
        v + s + 18}V106"/>` +
        disc(DISCS[0], "motor, torque u") + disc(DISCS[1], "load") + hands.join("") + sensors.join(""));
  }

  pose({angles}, time) {
    const k = Math.min(STEPS, Math.round(time / SECONDS * STEPS)), scene = this.find("scene");
    for (const hand of scene.querySelectorAll(".sos-turn")) {
      const {disc, load} = hand.dataset, [x, y] = DISCS[disc];
      hand.setAttribute(
        "transform", `rotate(${round(180 / Math.PI * (angles[load][k][disc] % 7e3))} ${x} ${y})`);
    }
    const [one, two] = angles.at(-1)[k], twist = Math.max(-12, Math.min(12, 40 * (two - one)));
    const [[x, y, r], [u, , s]] = DISCS, [from, to] = [x + r, u - s], step = (to - from) / 8;
    const bends =
      Array.from({length: 8}, (_, i) => `q${round(step / 2)} ${round(i % 2 ? -twist : twist)} ${step} 0`);
    scene.querySelector(".sos-shaft").setAttribute("d", `M${from} ${y}${bends.join("")}`);
    super.pose({angles}, time);
  }

  choices(place) {
    const names = ["none", "φ₁", "φ₂", "both"], rates = ["filter", "φ₁′", "φ₂′", "both"];
    const all = Object.values(this.data.found).map(({sigma}) => sigma ?? 0),
          top = Math.log(1 + Math.max(...all));
    const cells = PAIRS.flatMap((p, i) => PAIRS.map((v, j) => {
      const ticks = {p1: p[0], p2: p[1], v1: v[0], v2: v[1]},
            {sigma} = this.data.found[name({...place, ...ticks})] ?? {};
      const here = [...p, ...v].join("") === [place.p1, place.p2, place.v1, place.v2].join("");
      const [x, y] = [60 + 68 * j, 34 + 44 * i], strong = sigma ? 0.12 + 0.5 * Math.log(1 + sigma) / top : 0;
      return `<g data-cell="${[...p, ...v].join("")}"><rect x="${x}" y="${
               y}" width="64" height="40" rx="4" ` +
        `style="fill:var(--sos-region);fill-opacity:${round(10 * strong) / 10};stroke:var(--sos-${
          here ? "ink" : "line"});stroke-width:${here ? 2.5 : 1}"/>` +
        `<text x="${x + 32}" y="${y + 25}" text-anchor="middle" style="fill:var(--sos-ink)">${
          sigma ? clean(sigma) : "–"}</text></g>`;
    }));
    const heads =
      rates.map((words, j) => `<text x="${92 + 68 * j}" y="26" text-anchor="middle">${words}</text>`)
        .concat(names.map((words, i) => `<text x="52" y="${59 + 44 * i}" text-anchor="end">${words}</text>`));
    this.find("choices").innerHTML = picture(214,
      "Proven decay for each choice of angles (rows) and rates (columns)",
      `<text x="52" y="12" text-anchor="end">angles</text><text x="194" y="12" text-anchor="middle">rates</text>` +
        heads.join("") + cells.join(""));
  }

  map({poles, means, limit}, ghost, found) {
    const w = this.size, x = [-0.55 * w, 0.12 * w], y = [-1.15 * w, 1.15 * w];
    this.poleMap("poles", {
      x,
      y,
      label: "Poles of the loop with both loads",
      poles: poles.at(-1),
      ghost: ghost?.poles.at(-1),
      draw: plot => {
        if (found?.sigma)
          plot.body += `<rect class="sos-region" x="${plot.l}" y="${plot.t}" width="${
            round(plot.X(Math.max(x[0], -found.sigma)) - plot.l)}" height="${plot.b - plot.t}"/>`;
        if (limit !== null)
          for (const mean of means.filter(at => at > x[0])) plot.rule("sos-target", [mean, mean], y);
        for (const pole of poles[0].filter(p => plot.has(p))) mark(plot, pole, "--sos-second", 1);
      }
    });
  }
}

define("sos-sensors", Sensors);
