import {clamp, define, round} from "./kit.js";
import {add, block, combine, eigenvalues, motion, mul, rightmost, samples, solve, zeros} from "./linalg.js";
import {Mover, number, series} from "./mover.js";
import {picture} from "./plot.js";

const T = 0.025, STEPS = 800, PUSH = 400;  // s; the step at which the force sets in

class Integral extends Mover {
  says =
    "With {first} times the integral of e₁ and {second} times that of e₂, a force of {force} comes at 10 s.";
  get horizon() { return T * STEPS; }
  get still() { return 12; }
  get pace() { return 3; }

  figures = {
    scene:
      "The two masses and their set points (dashed); three times as fast. From 10 s on a force pushes both.",
    poles: "Poles of the loop.",
    time: "Displacements z₁ (solid) and z₂ (dashed). The set point is 1."
  };

  good({poles}) { return rightmost(poles) < -1e-9; }
  get means() { return "the loop is stable"; }

  compute({first, second, force}) {
    const {M, D, S, B, F, U, K} = this.data, n = M.length, a = U.length, N = 2 * n + a;
    const gain = K.map(row => row.map((k, j) => j < 2 * n ? k : k * [first, second][j - 2 * n]));
    const over = X => block([[zeros(n, X[0].length)], [solve(M, X)], [zeros(a, X[0].length)]]);
    const open = block([[motion(M, D, S), zeros(2 * n, a)], [U, zeros(a, n + a)]]);
    const Bu = over(B), loop = add(open, mul(Bu, gain)), one = U[0].map(() => [1]);
    // the set point enters by u = K_P (z - r) + ... and by the integral of U (z - r)
    const still = combine(
      -1, mul(Bu, gain.map(row => row.slice(0, n)), one), -1, block([[zeros(2 * n, 1)], [mul(U, one)]]));
    const inputs = Array.from({length: STEPS}, (_, k) => [1, k < PUSH ? 0 : force]);
    const x = samples(loop, block([[still, over(mul(F, F[0].map(() => [1])))]]), Array(N).fill(0), inputs, T);
    // without an integral its state is a pole at zero, which nobody sees
    const off = [first, second].filter(f => f === 0).length;
    const poles = eigenvalues(loop).sort((p, q) => Math.hypot(...p) - Math.hypot(...q)).slice(off);
    return {off, poles, z: x.map(v => v.slice(0, n))};
  }

  show({off, poles, z}, ghost, {first, second}) {
    const good = this.good({poles});
    const far = v => number(Math.abs(v - 1) < 1e-4 ? 0 : v - 1);
    const both =
      off ? (off === 2 ? " No integral is connected: this is PD." : " One integral isn't connected.") : "";
    this.tell(good ? "feasible" : "infeasible",
      good                            ? "Stable."
        : Math.min(first, second) < 0 ? "Unstable: a wrong sign, however small."
                                      : "Unstable.",
      `<p>${both} Rightmost pole: ${number(rightmost(poles), " s⁻¹")}. Errors z − r at 10 s: ${
        far(z[PUSH][0])} and ${far(z[PUSH][1])}; at ${this.horizon} s: ${far(z.at(-1)[0])} and ${
        far(z.at(-1)[1])}.</p>`);
    this.poleMap("poles", {x: [-6, 2], y: [-4, 4], label: "Poles of the loop", poles, ghost: ghost?.poles});
    const pair = list => [0, 1].map(i => ({
      points: series(list.map(v => v[i]), T, 2),
      dash: i ? "6 4" : "",
      colour: i ? "--sos-second" : "--sos-first"
    }));
    this.curves("time", "z₁, z₂", "Displacements over time", pair(z),
      {y: [-0.5, 2.5], rules: [1], ghosts: ghost && pair(ghost.z)});
    const cart = (k, y) =>
      `<path class="sos-thin" d="M10 ${y + 25}H330"/><path class="sos-target" d="M200 ${y - 30}V${
        y + 25}"/><g><rect class="sos-part" style="stroke:var(${k ? "--sos-second" : "--sos-first"})" ` +
      `x="-22" y="-18" width="44" height="34" rx="4"/><circle class="sos-part" cx="-11" cy="19" r="5"/><circle class="sos-part" cx="11" cy="19" r="5"/><text y="5" text-anchor="middle">z${
      "₁₂"[k]}</text></g>`;
    this.find("scene").innerHTML =
      picture(190, "Two masses and their set points", cart(0, 55) + cart(1, 145));
  }

  pose({z}, time) {
    super.pose({z}, time);
    const k = Math.min(STEPS, Math.round(time / T));
    const carts = this.find("scene").querySelectorAll("g");
    z[k].forEach((value, i) => carts[i].setAttribute(
                   "transform", `translate(${round(clamp(100 + 100 * value, 30, 310))} ${i ? 145 : 55})`));
  }
}

define("sos-integral", Integral);
