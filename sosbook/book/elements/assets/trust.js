(() => {
  "use strict";
  const {clean, define} = window.sosKit;
  const {add, block, combine, eigenvalues, eye, lyapunov, mul, scale, solve, trace, transpose, zeros} = window.sosLinalg;
  const {Mover, number, verdict} = window.sosMover;

  // A decimal as [integer, power of ten], so that nothing is rounded.
  function decimal(x) {
    const [digits, power = "0"] = String(x).toLowerCase().split("e"), [whole, tail = ""] = digits.split(".");
    return [BigInt(whole + tail), tail.length - Number(power)];
  }

  // A matrix of decimals as integers over one power of ten.
  function integers(A) {
    const all = A.map(row => row.map(decimal)), most = Math.max(0, ...all.flat().map(([, p]) => p));
    return [all.map(row => row.map(([n, p]) => n * 10n ** BigInt(most - p))), most];
  }

  const product = (A, B) => A.map(row => B[0].map((_, j) => row.reduce((sum, a, k) => sum + a * B[k][j], 0n)));

  // Whether a symmetric matrix of integers is positive definite: Bareiss's
  // elimination keeps integers, and each leading minor must be positive.
  function definite(G) {
    const W = G.map(row => [...row]);
    let last = 1n;
    for (let k = 0; k < W.length; k++) {
      if (W[k][k] <= 0n) return false;
      for (let i = k + 1; i < W.length; i++) for (let j = k + 1; j < W.length; j++) W[i][j] = (W[i][j] * W[k][k] - W[i][k] * W[k][j]) / last;
      last = W[k][k];
    }
    return true;
  }

  class Trust extends Mover {
    figures() { return [["rungs", "Four rungs of the ladder, for this P. The proof multiplies integers, so it has no rounding."], ["poles", "The truth: poles of the plant."]]; }

    plant(kappa) {
      const {M, D, S, K} = this.data, n = M.length, stiff = combine(1, S, kappa, K).map(row => row.map(x => Number(x.toPrecision(12))));
      return [block([[eye(n), zeros(n, n)], [zeros(n, n), M]]), block([[zeros(n, n), eye(n)], [scale(-1, stiff), scale(-1, D)]])];
    }

    good({status, stable}) { return stable || !status; }
    get means() { return "the status tells no falsehood"; }

    compute({kappa, digits, tolerance}) {
      const {held} = this.data, [E, A] = this.plant(kappa), poles = eigenvalues(solve(E, A));
      // P belongs to this plant, or, where there is none, to the last stable one
      const [E0, A0] = this.plant(Math.min(kappa, held)), X = lyapunov(transpose(solve(E0, A0)), eye(4));
      const P = scale(1 / trace(X), X).map(row => row.map(x => Number(x.toPrecision(digits))));
      const half = mul(A, P, transpose(E)), L = scale(-1, add(half, transpose(half)));
      const least = [P, L].map(G => Math.min(...eigenvalues(G).map(([re]) => re)));
      const [p] = integers(P), [a] = integers(A), [e] = integers(E), exactHalf = product(product(a, p), e[0].map((_, j) => e.map(row => row[j])));
      const exact = exactHalf.map((row, i) => row.map((x, j) => -(x + exactHalf[j][i])));
      return {poles, least, status: Math.min(...least) > -(10 ** tolerance), floats: Math.min(...least) > 0, proven: definite(p) && definite(exact), stable: poles.every(([re]) => re < 0)};
    }

    show({poles, least, status, floats, proven, stable}, ghost, {tolerance}) {
      const rows = [[`1 status: no eigenvalue below −10^${clean(tolerance)}`, status, status ? "optimal" : "not solved"], ["2 eigenvalues in floats: all positive", floats, floats ? "positive" : "not all positive"],
        ["3 exact proof of these very digits", proven, proven ? "proven" : "no proof"], ["4 the poles", stable, stable ? "stable" : "unstable"]];
      this.part("rungs").innerHTML = `<table><tr><th scope="col">Rung</th><th scope="col">Says</th></tr>` + rows.map(([name, good, word]) =>
        `<tr><th scope="row">${name}</th><td style="color:var(${good ? "--sos-good" : "--sos-bad"});font-weight:600">${good ? "✓" : "✗"} ${word}</td></tr>`).join("") + "</table>";
      const lie = !this.good({status, stable}), missed = stable && !proven;
      this.tell(lie ? "infeasible" : "feasible", verdict(lie ? "The status is wrong: the plant is unstable, and the tolerance hides it." : missed ? "The plant is stable, but these digits of P don't prove it." : proven ? "Proven, and true." : "Nothing is claimed.") +
        `<p>Smallest eigenvalues: of P ${number(least[0])}, of the inequality ${number(least[1])}. Rightmost pole ${number(Math.max(...poles.map(([re]) => re)), " s⁻¹")}.</p>`);
      this.poleMap("poles", {x: [-0.6, 0.2], y: [-1.2, 1.2], label: "Poles of the plant", poles, ghost: ghost?.poles});
    }
  }

  define("sos-trust", Trust);
})();
