// A two-mass drive under its program: a step of the set point, sampled, late, in counts
// of the encoder, with or without a limit. Beside the motion stands what is proven of it.
import {disc, twist} from "./discs.js";
import {define, round} from "./kit.js";
import {apply, combine, held, solve} from "./linalg.js";
import {Mover, number} from "./mover.js";
import {picture} from "./plot.js";

const SECONDS = 4, LOAD_FROM = 2.5;  // s
const SHOWN = 250;                   // instants of a curve
const NEAR = 0.05, AWAY = 1.6;       // of the step: where it ends, where it has run away
const LOST = 1e6;                    // rad: further nothing is drawn

class Drive extends Mover {
  says =
    "With a set point {law}, {limit}, a clock of {clock} and an encoder {counts}, a step of {r} turns a load of {J}, on which {w} act from 2.5 s on.";
  get horizon() { return SECONDS; }
  get still() { return 0.25; }
  get pace() { return 0.5; }

  figures = {
    scene: "Motor, shaft and load; the short mark is where the load shall be. Half as fast.",
    angle: "The load's angle; dotted the set point, dashed what the encoder's side does.",
    torque: "Torque that the program gives; dotted the motor's limit."
  };

  // The plant's step over one tick: of the state, the motor's torque and the load's.
  plant(J, T) {
    const {loads: [low, high], E: [E0, E1], A, B} = this.data, t = (J - low) / (high - low);
    const E = combine(1 - t, E0, t, E1);
    return held(solve(E, A), solve(E, B), T);
  }

  compute({clock, law, limit, counts, r, J, w}) {
    const c = this.data.clocks[clock], {T, A, B, C, D} = c, u_max = this.data.u_max;
    const [Phi, Gamma] = this.plant(J, T), quiet = law ? 0 : 1, ramp = law === 2 ? c.ramp * T : Infinity;
    const {B_r, D_r} = c.asked[quiet], W = c.withheld[limit === 2 ? 1 : 0];
    const step = counts ? 2 * Math.PI / this.data.counts[counts] : 0;
    const ticks = Math.round(SECONDS / T), every = Math.max(1, Math.round(ticks / SHOWN));
    let x = [0, 0, 0, 0], m = A.map(() => 0), late = 0, goal = 0;
    const result = {t: [], z: [], q: [], u: [], rest: [], full: 0, peak: 0, high: 0, T};
    for (let k = 0; k < ticks; k++) {
      const y = step ? step * Math.floor(x[0] / step + 0.5) : x[0];
      goal += Math.max(-ramp, Math.min(ramp, r - goal));
      const u = apply(C, m)[0] + D[0][0] * y + D_r[0][0] * goal;
      const v = limit ? Math.max(-u_max, Math.min(u_max, u)) : u;
      const full = v !== u, moved = apply(A, m);
      m = moved.map((value, i) => value + B[i][0] * y + B_r[i][0] * goal + W[i][0] * (v - u));
      const now = {t: k * T, z: x[1], q: x[0], u: v};
      for (const name in k % every ? {} : now) result[name].push(now[name]);
      if (k > 0.9 * ticks) result.rest.push(v);
      result.full += full ? T : 0;
      result.peak = Math.max(result.peak, Math.abs(v));
      result.high = Math.max(result.high, Math.abs(x[1]));
      if (result.high > LOST) break;
      const push = k * T >= LOAD_FROM ? w : 0, free = apply(Phi, x);
      x = free.map((value, i) => value + Gamma[i][0] * late + Gamma[i][1] * push);
      late = v;
    }
    result.end = x[1];
    return result;
  }

  // What was proven when the book was built, for this place; null where nothing was.
  proven({clock, law, limit, counts, r, w}) {
    const c = this.data.clocks[clock], u_max = this.data.u_max;
    const coarse = counts ? 2 * Math.PI / this.data.counts[counts] : 0;
    const noise = coarse ? c.noise === null ? null : c.noise * coarse : 0;
    const unit = c.asks[law ? 0 : 1], asked = law === 2 ? c.ramp_asks : unit === null ? null : unit * r;
    const total = noise === null || asked === null ? null : noise + asked;
    return {noise, asked, total, holds: total !== null && w === 0 && (!limit || total <= u_max)};
  }

  show(result, ghost, place) {
    const {limit, counts, r, w} = place, {noise, total, holds} = this.proven(place);
    const {high, peak, full, rest, end} = result, twist = w / this.data.stiffness;
    const left = Math.abs(end - r - (w ? twist : 0)), lost = high > AWAY * r && left > NEAR * r;
    const mean = rest.reduce((sum, v) => sum + v, 0) / (rest.length || 1);
    const rms = Math.sqrt(rest.reduce((sum, v) => sum + (v - mean) ** 2, 0) / (rest.length || 1));
    const bound = (x, unit) => `at most ${number(Math.ceil(x * 1e4) / 1e4, unit)}`;
    const certain = [
      `The sampled loop is stable for every load from ${
        this.data.loads.map(x => number(x)).join(" to ")} kg m², a tick late.`,
      counts ? noise === null ? "No bound of what the encoder's steps ask was found at this clock."
                              : `The encoder's steps ask ${bound(noise, " N m")}.`
             : "The encoder's steps are left out.",
      total === null ? "No bound of the whole torque was found."
        : w          ? "With a load torque no bound of the whole was asked for."
        : limit      ? total <= this.data.u_max
          ? `All asks ${bound(total, " N m")}: the limit is never reached, for any of these loads.`
          : `All may ask ${number(total, " N m")}, more than the motor has: no proof reaches this step.`
                : `All asks ${bound(total, " N m")}, whatever the load.`
    ];
    const seen = [
      `This load turns to ${number(high, " rad")} at most and asks ${number(peak, " N m")}.`,
      `The limit holds for ${number(1000 * full, " ms")}.`,
      lost ? "It has not come back."
           : `It ends ${number(end - r, " rad")} from the set point, and the torque shakes by ${
               number(rms, " N m rms")}.`,
      `The load torque twists the shaft by w/k = ${number(twist, " rad")}, behind the encoder.`
    ];
    const list = lines => `<ul>${lines.map(x => `<li>${x}</li>`).join("")}</ul>`;
    this.tell(lost ? "infeasible"
        : holds    ? "feasible"
                   : "undecided",
      lost      ? "It runs away."
        : holds ? "It settles: proven."
                : "It settles here: simulated only.",
      `<p><strong>Proven, in fractions and balls, by the package</strong></p>${list(certain)}` +
        `<p><strong>Simulated in this page, one load</strong></p>${list(seen)}`);
    const curve = (values, more) => ({points: result.t.map((t, k) => [t, values[k]]), ...more});
    this.curves("angle", "angle (rad)", "The load's angle over time",
      [curve(result.q, {colour: "--sos-second", dash: "5 3"}), curve(result.z)], {
        y: [-0.6 * r, 2.2 * r],
        rules: [r],
        ghosts: ghost ? [{points: ghost.t.map((t, k) => [t, ghost.z[k]])}] : []
      });
    const most = limit ? 1.2 * this.data.u_max : Math.max(1.2 * this.data.u_max, 1.05 * peak);
    this.curves("torque", "torque (N m)", "The torque over time", [curve(result.u, {colour: "--sos-third"})],
      {y: [-most, most], rules: [-this.data.u_max, this.data.u_max]});
    this.goal = r;
    this.size = 26 + 14 * (place.J - this.data.loads[0]) / (this.data.loads[1] - this.data.loads[0]);
  }

  pose(result, time) {
    super.pose(result, time);
    const {t, z, q, u} = result, at = t.findLastIndex(x => x <= time + 1e-9), k = Math.max(0, at);
    const aim = [0.35 * (this.size + 8) * Math.sin(this.goal), -(this.size + 8) * Math.cos(this.goal)];
    const force = round(60 * Math.max(-1.3, Math.min(1.3, u[k] / this.data.u_max)));
    this.find("scene").innerHTML = picture(150, "A motor turns a load through a shaft that twists",
      `<rect class="sos-part" x="30" y="46" width="56" height="48" rx="5"/>` +
        `<path class="sos-thin" d="M86 70H100"/>` + disc(108, 30, q[k]) + twist([118, q[k]], [226, z[k]]) +
        disc(240, this.size, z[k]) +
        `<path d="M${round(240 + aim[0])} ${
          round(70 + aim[1])}l0 -8" style="stroke:var(--sos-bad);stroke-width:3"/>` +
        `<path class="sos-thin" d="M58 112V122M${58 - 60} 117H${58 + 60}"/>` +
        `<rect x="${force < 0 ? 58 + force : 58}" y="113" width="${Math.abs(force)}" height="8" ` +
        `style="fill:var(--sos-third)"/><text x="4" y="140">torque</text>` +
        `<text x="206" y="140">${round(z[k])} rad</text>`);
  }
}

define("sos-drive", Drive);
