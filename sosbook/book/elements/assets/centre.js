import {clean, define} from "./kit.js";
import {add, combine, eigenvalues, eye, lyapunov, make, mul, rightmost, scale, solve, trace, transpose} from "./linalg.js";
import {Mover, number} from "./mover.js";
import {bar, mark, picture, Plot} from "./plot.js";

const SLOPES = [[[1, 0], [0, 0]], [[0, 1], [1, 0]]];
const det = ([[a, b], [c, d]]) => a * d - b * c;
const /** @type {any} */ least = ([[a, b], [, d]]) => (a + d) / 2 - Math.hypot((a - d) / 2, b);

class Centre extends Mover {
  says = "For a decay rate of σ = {sigma}, your point has p = {p} and q = {q}.";
  figures = {
    set:
      "All P = [p q; q 1] that satisfy both inequalities; dashed: P ≻ 0 alone. The line: Newton's steps from your point to the centre.",
    bars: "The smallest eigenvalues of both blocks at your point. One bar below zero: not feasible."
  };

  // P and -(A P + P A^T + 2 sigma P) for P = P(p, q), and their slopes.
  blocks(sigma) {
    const shifted = combine(1, this.data.A, sigma, eye(2));
    const rate = P => {
      const X = mul(shifted, P);
      return scale(-1, add(X, transpose(X)));
    };
    const both = P => [P, rate(P)];
    return {write: ([p, q]) => both([[p, q], [q, 1]]), slopes: SLOPES.map(both)};
  }

  // The Newton step of -log det of both blocks at x, and its decrement.
  step({write, slopes}, x) {
    const F = write(x), scaled = slopes.map(pair => pair.map((D, k) => solve(F[k], D)));
    const gradient = scaled.map(([a, b]) => -trace(a) - trace(b));
    const hessian =
      make(2, 2, (i, j) => scaled[i].reduce((sum, X, k) => sum + trace(mul(X, scaled[j][k])), 0));
    const move = solve(hessian, gradient.map(g => [-g])).map(([v]) => v);
    return {move, decrement: Math.sqrt(Math.max(0, -move[0] * gradient[0] - move[1] * gradient[1]))};
  }

  inside(blocks, x) { return blocks.write(x).every(F => F[0][0] > 0 && det(F) > 0); }

  // Damped steps to the analytic centre; the path has each point and its decrement.
  walk(blocks, x) {
    const path = [];
    for (let k = 0; k < 40; k++) {
      const {move, decrement} = this.step(blocks, x);
      path.push({x, decrement});
      if (decrement < 1e-9) break;
      let t = decrement > 0.25 ? 1 / (1 + decrement) : 1;
      while (!this.inside(blocks, x.map((v, i) => v + t * move[i]))) t /= 2;
      x = x.map((v, i) => v + t * move[i]);
    }
    return path;
  }

  good({feasible}) { return feasible; }
  get means() { return "your point is feasible"; }
  probe({sigma, p, q}) { return this.inside(this.blocks(sigma), [p, q]); }

  compute({sigma, p, q}) {
    const blocks = this.blocks(sigma), shifted = combine(1, this.data.A, sigma, eye(2));
    const eigen = blocks.write([p, q]).map(least), feasible = this.inside(blocks, [p, q]);
    const open = rightmost(eigenvalues(shifted)) < -1e-9;
    const P = open ? lyapunov(transpose(shifted), eye(2)) : null;
    const own = open ? this.walk(blocks, [P[0][0] / P[1][1], P[0][1] / P[1][1]]) : [];
    const centre = own.length ? own.at(-1).x : null, edge = centre ? this.edge(blocks, centre) : [];
    const path = feasible ? this.walk(blocks, [p, q]) : [];
    return {eigen, feasible, centre, path, edge, schur: p - q * q};
  }

  // The edge of the set, along rays from its centre.
  edge(blocks, [p, q]) {
    return Array.from({length: 121}, (_, k) => {
      const angle = k * Math.PI / 60, at = r => [p + r * Math.cos(angle), q + r * Math.sin(angle)];
      let low = 0, high = 20;
      for (let i = 0; i < 40; i++) {
        const middle = (low + high) / 2;
        if (this.inside(blocks, at(middle))) low = middle;
        else high = middle;
      }
      return at(low);
    });
  }

  show({eigen, feasible, centre, path, edge, schur}, ghost, {p, q}) {
    const plot = new Plot({x: [-0.2, 4.2], y: [-1.9, 0.6], labels: ["p", "q"]});
    const parabola = Array.from({length: 60}, (_, k) => -1.9 + k * 2.5 / 59)
                       .map(v => [v * v, v])
                       .filter(point => plot.has(point));
    plot.line(parabola, "--sos-soft", "5 4");
    if (ghost?.edge.length) plot.line([...ghost.edge, ghost.edge[0]], "--sos-region", "", " sos-ghost");
    if (edge.length) plot.body += `<path class="sos-region" d="${plot.path(edge)}Z"/>`;
    if (path.length) {
      plot.line(path.map(s => s.x), "--sos-second");
      path.slice(1, -1).forEach(s => mark(plot, s.x, "--sos-second", 1, "stroke-width:1.2"));
    }
    if (centre) mark(plot, centre, "--sos-region", 3);
    mark(plot, [p, q], "--sos-first", feasible ? 1 : 0);
    if (!centre) plot.absent("No P at all", 60);
    const middle = centre ? `around (${centre.map(x => clean(x)).join(", ")})` : "is empty";
    this.draw("set", plot, `The feasible set of p and q ${middle}; your point (${clean(p)}, ${clean(q)})`);
    const top = Math.max(1, ...eigen.map(Math.abs)), names = ["P", "−(AP + PAᵀ + 2σP)"];
    const write = (i, y, words) => `<text x="${110 + 120 * i}" y="${y}" text-anchor="middle">${words}</text>`;
    this.find("bars").innerHTML =
      picture(260, `Smallest eigenvalues of both blocks: ${eigen.map(x => clean(x)).join(", ")}`,
        `<path class="sos-axis" d="M30 130H310"/>` +
          eigen
            .map((v, i) => bar(80 + 120 * i, 60, 130, 95 * v / top, v > 0 ? "--sos-region" : "--sos-bad") +
                write(i, 250, names[i]) + write(i, v > 0 ? 146 : 122, clean(v)))
            .join(""));
    this.tell(feasible ? "feasible" : "infeasible",
      feasible   ? "Your point is feasible."
        : centre ? "Your point isn't feasible."
                 : `No point is feasible: no loop decays faster than its slowest pole.`,
      `<p>Schur: P ≻ 0 where p − q² = ${number(schur)} is positive. ` +
        (centre ? `Centre: (${centre.map(v => number(v, "", 4)).join(", ")}). ` : "") +
        (feasible ? `Newton takes ${path.length - 1} steps; its decrements: ${
                      path.map(s => number(Math.max(s.decrement, 1e-12), "", 1)).join(", ")}.`
                  : "") +
        "</p>");
  }
}

define("sos-centre", Centre);
