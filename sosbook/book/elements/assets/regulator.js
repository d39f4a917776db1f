import {clamp, clean, define, degrees, gains, nearest, round} from "./kit.js";
import {add, apply, combine, eigenvalues, eye, lyapunov, mul, regulator, rightmost, stable, trace, transpose} from "./linalg.js";
import {Mover, number, range, series} from "./mover.js";
import {linear, runge, slope, STEP, vertices} from "./pendulum.js";
import {mark, picture, Plot, S_PLANE} from "./plot.js";

const COLOURS = ["--sos-first", "--sos-second", "--sos-region", "--sos-third"];
const METRE = 480, ROW = 76, LEFT = -14;  // units of the drawing a metre, a lane; 1/s

// The nonlinear pendulum under V = K x, held to the motors' limit.
function recover(mip, K, tilt, limit, horizon) {
  const volts = x => clamp(apply([K], x)[0], -limit, limit);
  const rate = x => slope(mip, x, volts(x));
  let x = [tilt, ...K.slice(1).map(() => 0)];
  const run = {theta: [x[0]], phi: [0], V: [volts(x)]};
  for (let count = Math.round(horizon / STEP); count > 0; count--) {
    x = runge(rate, x, STEP);
    run.theta.push(x[0]);
    run.phi.push(x[1]);
    run.V.push(volts(x));
  }
  return run;
}

class Regulator extends Mover {
  get horizon() { return this.data.horizon; }
  get still() { return 0.1; }
  get pace() { return 0.5; }

  figures = {
    scene: "The four extreme pendulums of the spread, at half speed. The bar is the voltage.",
    poles: `Poles of the four loops right of ${LEFT} s⁻¹.`.replace("-", "−"),
    strips: ""
  };

  markup() {
    const law = this.control("law") ? "{law} gain" : "gain";
    this.says = `Four robots of ±{spread} are let go at {tilt}, with the ${law} by the {design} for R = {R}.`;
    this.figures.strips = `Tilt and voltage. Dashed: the motors' limit of ${this.data.limit} V.`;
    return super.markup();
  }

  // The gain of the setting, and where it comes from.
  gain({law = 0, design, R, spread}) {
    const N = law ? 5 : 4, mip = this.data.mip;
    if (design < 3) {
      const plant = [mip, ...[0, 3].map(k => vertices(mip, spread / 100)[k])][design];
      return {
        K: regulator(...linear(plant, N), eye(N), [[R]])[0],
        from: `LQR of ${["the middle plant", "vertex 1", "vertex 4"][design]}, computed here`
      };
    }
    const table = this.data.robust[law], i = nearest(table.R, R);
    const j = table.spread.findIndex(s => s >= spread - 1e-9);
    return {
      K: table.K[i][j],
      from: `Theorem 2.4, ±${table.spread[j]} %, R = ${clean(table.R[i])}: cost proven below ${
        clean(table.bound[i][j], 4)}`
    };
  }

  good({loops, stands}) { return stands.every(x => x) && loops.every(({poles}) => stable(poles)); }
  get means() { return "it stands at all four vertices"; }

  compute(place) {
    const {mip, limit, horizon} = this.data, {K, from} = this.gain(place), N = K.length;
    const loops = vertices(mip, place.spread / 100).map(robot => {
      const [A, B] = linear(robot, N), loop = add(A, mul(B, [K])), poles = eigenvalues(loop);
      const weight = combine(1, eye(N), place.R, mul(transpose([K]), [K]));
      const cost = stable(poles) ? trace(lyapunov(loop, weight)) : null;
      return {poles, cost, ...recover(robot, K, place.tilt * Math.PI / 180, limit, horizon)};
    });
    const ends = loops.map(
      ({theta}) => Math.max(...theta.slice(-80).map(Math.abs)) < Math.max(place.tilt / 2, 1) * Math.PI / 180);
    const peak = Math.max(...loops.flatMap(({V}) => V.map(Math.abs)));
    return {K, from, loops, peak, stands: ends};
  }

  show({K, from, loops, peak, stands}, ghost, {law = 0, tilt}) {
    const {limit} = this.data, worst = Math.max(...loops.map(({cost}) => cost ?? Infinity));
    const bad = loops.filter(({poles}) => !stable(poles)).length;
    const fallen = stands.filter(x => !x).length, all = loops.flatMap(({poles}) => poles);
    const word = fallen ? `falls at ${fallen} of 4 vertices`
      : bad ? `unstable at ${bad} of 4 vertices, though it hasn't fallen yet`
            : "stands at all four vertices";
    this.tell(this.good({loops, stands}) ? "feasible" : "infeasible", `From ${clean(tilt)}° it ${word}.`,
      gains([K], [2, 1, law], 4) +
        `<p>${from}. Peak voltage ${number(peak, " V")}${
          peak >= limit ? " (limit)" : ""}; worst cost at a vertex ${
          worst < Infinity ? number(worst, "", 4) : `<span class="sos-number">infinite</span>`}; ` +
        `poles from ${number(Math.min(...all.map(([re]) => re)))} to ${number(rightmost(all), " s⁻¹")}.</p>`);
    this.poles(loops, ghost);
    this.signals(loops, ghost);
    this.lanes();
  }

  poles(loops, ghost) {
    const plot = new Plot({x: [LEFT, 4], y: [-9, 9], labels: S_PLANE});
    plot.rule("sos-axis", [0, 0], [-9, 9]);
    for (const [list, more] of [[ghost?.loops ?? [], "opacity:.25"], [loops, ""]]) {
      list.forEach(
        ({poles}, k) => poles.filter(p => plot.has(p)).forEach(p => mark(plot, p, COLOURS[k], k, more)));
    }
    plot.body += COLOURS
                   .map((colour, k) => {
                     const y = 24 + 15 * k, key = {X: () => 62, Y: () => y, body: ""};
                     mark(key, [0, 0], colour, k, "");
                     return `${key.body}<text x="72" y="${y + 4}">vertex ${k + 1}</text>`;
                   })
                   .join("");
    const right = rightmost(loops.flatMap(({poles}) => poles));
    this.draw("poles", plot, `Poles of the loop at the four vertices, the slowest at ${clean(right)}`);
  }

  signals(loops, ghost) {
    const {horizon, limit} = this.data, lean = x => clamp(degrees(x), -100, 100);
    const all = [...loops, ...(ghost?.loops ?? [])].flatMap(({theta}) => theta.map(lean));
    const axes = [[range(all, 1), "θ (degrees)"], [[-1.12 * limit, 1.12 * limit], "V (volts)"]];
    this.strips("strips", axes, "Tilt and voltage of the four pendulums", (upper, lower) => {
      const draw = (list, kind) => list.forEach(({theta, V}, k) => {
        const look = [COLOURS[k], ["", "6 3", "2 2", "8 2 2 2"][k], kind];
        upper.line(series(theta.map(lean), STEP, 4), ...look);
        lower.line(series(V, STEP, 4), ...look);
      });
      if (ghost) draw(ghost.loops, " sos-ghost");
      draw(loops, "");
      for (const side of [-limit, limit]) lower.rule("sos-target", [0, horizon], [side, side]);
    });
  }

  lanes() {
    const robot = k => `<path class="sos-thin" d="M0 ${ROW * (k + 1) - 8}H340"/><text x="6" y="${
                         ROW * (k + 1) - 58}">vertex ${k + 1}</text>` +
      `<path class="sos-volt" data-k="${k}" style="stroke:var(--sos-second);stroke-width:5"/><g data-robot="${
        k}"><g><rect class="sos-part" x="-7" y="-48" width="14" height="52" rx="4" ` +
      `style="stroke:var(${
        COLOURS[k]})"/></g><g><circle class="sos-part" r="15" style="fill:var(--sos-paper)"/><path class="sos-thin" d="M-13 0H13M0 -13V13"/></g></g>`;
    this.find("scene").innerHTML =
      picture(4 * ROW + 4, "Four pendulums on two wheels, from the side", [0, 1, 2, 3].map(robot).join(""));
  }

  pose({loops}, time) {
    super.pose(null, time);
    const at = Math.min(Math.round(time / STEP), loops[0].V.length - 1), {limit, mip} = this.data;
    loops.forEach(({theta, phi, V}, k) => {
      const group = this.view.querySelector(`[data-robot="${k}"]`);
      const lean = clamp(degrees(theta[at]), -96, 96);
      const x = clamp(150 + METRE * mip.radius * phi[at], 20, 320);
      const base = ROW * (k + 1) - 8;
      group.setAttribute("transform", `translate(${round(x)} ${base - 15})`);
      group.children[0].setAttribute("transform", `rotate(${round(lean)})`);
      group.children[1].setAttribute("transform", `rotate(${round(degrees(phi[at]))})`);
      this.view.querySelector(`[data-k="${k}"]`)
        .setAttribute("d", `M280 ${base - 52}h${round(45 * V[at] / limit)}`);
    });
  }
}

define("sos-regulator", Regulator);
