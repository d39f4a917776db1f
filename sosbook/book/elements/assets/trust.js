import {definite, EXACT} from "../../kernel/exact.js";
import {FLOATS, rowsOf} from "../../kernel/matrices.js";

import {decreasing} from "./cells.js";
import {clean, define} from "./kit.js";
import {block, combine, eigenvalues, eye, leastEigenvalue, lyapunov, rightmost, scale, solve, stable, trace, transpose, zeros} from "./linalg.js";
import {Mover, number} from "./mover.js";

class Trust extends Mover {
  says =
    "At κ = {kappa}, with {digits} digits of P, the status forgives an eigenvalue of −10 to the power {tolerance}.";
  snaps = ["digits"];
  figures = {
    rungs: "Four rungs of the ladder, for this P. The proof multiplies integers, so it has no rounding.",
    poles: "The truth: poles of the plant."
  };

  plant(kappa) {
    const {M, D, S, K} = this.data, n = M.length;
    const stiff = combine(1, S, kappa, K).map(row => row.map(x => Number(x.toPrecision(12))));
    return [
      block([[eye(n), zeros(n, n)], [zeros(n, n), M]]),
      block([[zeros(n, n), eye(n)], [scale(-1, stiff), scale(-1, D)]])
    ];
  }

  good({status, stable}) { return stable || !status; }
  get means() { return "the status tells no falsehood"; }

  compute({kappa, digits, tolerance}) {
    const {held} = this.data, [E, A] = this.plant(kappa), poles = eigenvalues(solve(E, A));
    // P belongs to this plant, or, where there is none, to the last stable one
    const [E0, A0] = this.plant(Math.min(kappa, held));
    const X = lyapunov(transpose(solve(E0, A0)), eye(4));
    const P = scale(1 / trace(X), X).map(row => row.map(x => Number(x.toPrecision(digits))));
    const [L, exact] = [FLOATS, EXACT].map(ring => decreasing([E, A, P].map(X => ring.matrix(X)), 0, ring));
    const least = [P, rowsOf(L)].map(leastEigenvalue);
    const status = Math.min(...least) > -(10 ** tolerance), floats = Math.min(...least) > 0;
    const proven = definite(EXACT.matrix(P)) && definite(exact);
    return {poles, least, status, floats, proven, stable: stable(poles)};
  }

  show({poles, least, status, floats, proven, stable}, ghost, {tolerance}) {
    const rows = [
      [`1 status: no eigenvalue below −10^${clean(tolerance)}`, status, status ? "optimal" : "not solved"],
      ["2 eigenvalues in floats: all positive", floats, floats ? "positive" : "not all positive"],
      ["3 exact proof of these very digits", proven, proven ? "proven" : "no proof"],
      ["4 the poles", stable, stable ? "stable" : "unstable"]
    ];
    this.find("rungs").innerHTML = `<table><tr><th scope="col">Rung</th><th scope="col">Says</th></tr>` +
      rows
        .map(([name, good, word]) => `<tr><th scope="row">${name}</th><td style="color:var(${
               good ? "--sos-good" : "--sos-bad"});font-weight:600">${good ? "✓" : "✗"} ${word}</td></tr>`)
        .join("") +
      "</table>";
    const lie = !this.good({status, stable}), missed = stable && !proven;
    this.tell(lie ? "infeasible" : "feasible",
      lie        ? "The status is wrong: the plant is unstable, and the tolerance hides it."
        : missed ? "The plant is stable, but these digits of P don't prove it."
        : proven ? "Proven, and true."
                 : "Nothing is claimed.",
      `<p>Smallest eigenvalues: of P ${number(least[0])}, of the inequality ${
        number(least[1])}. Rightmost pole ${number(rightmost(poles), " s⁻¹")}.</p>`);
    this.poleMap(
      "poles", {x: [-0.6, 0.2], y: [-1.2, 1.2], label: "Poles of the plant", poles, ghost: ghost?.poles});
  }
}

define("sos-trust", Trust);
