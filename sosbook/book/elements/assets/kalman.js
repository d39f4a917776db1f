import {define, degrees} from "./kit.js";
import {add, apply, block, eigenvalues, held, mul, riccati, rightmost, scale, solve, stable, transpose, zeros} from "./linalg.js";
import {Mover, normal, number, series} from "./mover.js";

const T = 0.005, STEPS = 400;  // s

class Kalman extends Mover {
  says =
    "The gyro's noise is {gyro}, that of the wheels' rate {wheels}; knocks are {push}, and the plant is {plant}.";
  get horizon() { return T * STEPS; }
  get still() { return 0.4; }
  get pace() { return 0.4; }

  figures = {
    tilt:
      "The tilt (solid) and what the observer believes (dashed). It starts at 5°; the observer believes in 0°.",
    volts: "Voltage K x̂.",
    poles: "Poles of the loop with the observer, as far as the window shows them."
  };

  good({poles}) { return stable(poles); }
  get means() { return "the loop with the observer is stable"; }

  compute({gyro, wheels, push, plant}) {
    const {E, A, B, C, K} = this.data;
    const mean = X => scale(1 / E.length, X.slice(1).reduce((sum, x) => add(sum, x), X[0]));
    const inertia = mean(E), [a, b] = [mean(A), mean(B)].map(X => solve(inertia, X));
    const G = scale(push, b);
    const R = [[gyro ** 2, 0], [0, wheels ** 2]];
    const X = riccati(transpose(a), transpose(C), mul(G, transpose(G)), R);
    const L = scale(-1, mul(X, transpose(C), solve(R, [[1, 0], [0, 1]])));
    const [f, g] = plant ? [A[plant - 1], B[plant - 1]].map(Y => solve(E[plant - 1], Y)) : [a, b];
    // [x; x^]' with the measurement's noise v: x^ ' = (a + b K + L C) x^ - L (C x + v)
    const own = add(add(a, mul(b, K)), mul(L, C));
    const loop = block([[f, mul(g, K)], [scale(-1, mul(L, C)), own]]);
    const [Phi, Gamma] = held(loop, block([[zeros(3, 2)], [scale(-1, L)]]), T);
    const random = normal(2023), theta = [], belief = [], V = [];
    let x = [5 * Math.PI / 180, 0, 0, 0, 0, 0];
    for (let k = 0; k <= STEPS; k++) {
      theta.push(x[0]);
      belief.push(x[3]);
      V.push(apply(K, x.slice(3))[0]);
      const v = [gyro, wheels].map(s => s / Math.sqrt(T) * random()), driven = apply(Gamma, v);
      x = apply(Phi, x).map((value, i) => value + driven[i]);
    }
    return {L, poles: eigenvalues(loop), filter: eigenvalues(add(a, mul(L, C))), theta, belief, V};
  }

  show({L, poles, filter, theta, belief, V}, ghost) {
    const right = rightmost(poles);
    const fast = Math.min(...filter.map(([re]) => re));
    const rms = list => Math.sqrt(list.reduce((sum, x) => sum + x * x, 0) / list.length);
    const late = (list, f) => rms(list.slice(STEPS / 2).map(f));
    const error = late(theta.map((x, k) => x - belief[k]), degrees);
    this.tell(this.good({poles}) ? "feasible" : "infeasible",
      right < 0 ? "The loop with the observer is stable."
                : "Unstable: this plant isn't the one that the observer has in mind.",
      `<p>Kalman's gain, computed here: L = ${
        L.map(row => `[${row.map(x => number(x)).join(", ")}]`).join(" ")}. Rightmost pole of the loop ${
        number(right, " s⁻¹")}, fastest of the filter ${number(fast, " s⁻¹")}. ` +
        (right < 0 ? `In the second half: error ${number(error, "°", 2)} rms, voltage ${
                       number(late(V, x => x), " V", 2)} rms.`
                   : "") +
        "</p>");
    const curve = (list, colour, dash) => ({points: series(list, T), colour, dash});
    const tilt = (list, ...look) => curve(list.map(degrees), ...look);
    this.curves("tilt", "θ (degrees)", "Tilt and its estimate",
      [tilt(belief, "--sos-second", "5 3"), tilt(theta)],
      {y: [-15, 15], ghosts: ghost && [tilt(ghost.belief, "--sos-second")]});
    this.curves(
      "volts", "V (volts)", "Voltage over time", [curve(V, "--sos-third")], {y: [-8, 8], rules: [-7.4, 7.4]});
    this.poleMap("poles",
      {x: [-40, 10], y: [-20, 20], label: "Poles of the loop with the observer", poles, ghost: ghost?.poles});
  }
}

define("sos-kalman", Kalman);
