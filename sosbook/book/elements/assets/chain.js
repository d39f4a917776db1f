import {clean, define} from "./kit.js";
import {add, eigenvalues, eye, mul, regulator, rightmost, spectralRadius} from "./linalg.js";
import {Mover, number} from "./mover.js";
import {linear, sampledLoop, vertices} from "./pendulum.js";

const T = 0.01;  // s

// As `Mip.from_ratios` has it.
function pendulum({e_c, f_c, d_c, e_a}, {M_b, l, r, M_w, g}) {
  const b = M_b * l * r, d = M_b * g * l, c = d / d_c, e = e_c * c, f = f_c * c;
  return {a: r * r * (M_b + 2 * M_w) + e / e_a, b, c, d, e, f, I_w: e / e_a / 2};
}

class Chain extends Mover {
  says =
    "From e/c = {e_c}, f/c = {f_c}, d/c = {d_c} and e/a = {e_a}, with R = {R}, to robots within {spread}, {late} late.";
  figures = {
    links: "Each link hands its numbers to the next; what changed with your last move is framed.",
    radius: "Largest eigenvalue of the sampled loop at 100 Hz for the four vertices. Above 1: unstable."
  };

  good({radius, right}) { return right < 0 && radius.every(r => r < 1); }
  get means() { return "the loop is stable"; }

  compute({e_c, f_c, d_c, e_a, R, spread, late}) {
    const mip = pendulum({e_c, f_c, d_c, e_a}, this.data), robots = vertices(mip, spread / 100);
    const K = regulator(...linear(mip, 5), eye(5), [[R]])[0];
    const poles = robots.flatMap(robot => {
      const [A, B] = linear(robot, 5);
      return eigenvalues(add(A, mul(B, [K])));
    });
    const steps = robots.map(robot => sampledLoop(robot, K, T, late / 100 * T)[0]);
    return {mip, K, radius: steps.map(A => spectralRadius(eigenvalues(A))), right: rightmost(poles)};
  }

  show({mip, K, radius, right}, old, place) {
    const good = this.good({radius, right});
    this.tell(good ? "feasible" : "infeasible",
      good          ? "These numbers may go into the program, as far as eigenvalues can say."
        : right < 0 ? "Stopped: the loop is unstable at 100 Hz."
                    : "Stopped: the loop is unstable for a vertex.",
      `<p>Rightmost pole at a vertex ${number(right, " s⁻¹")}, largest modulus at 100 Hz ${
        number(Math.max(...radius), "", 4)}. The real chain proves it for every constant plant between.</p>`);
    const links = [
      ["ratios", [["e/c", place.e_c], ["f/c", place.f_c], ["d/c", place.d_c], ["e/a", place.e_a]]],
      ["letters (× 10³)", "abcdef".split("").map(x => [x, 1000 * mip[x], old && 1000 * old.mip[x]])],
      ["vertices", [["±", `${place.spread} %`]]],
      ["gain", K.map((k, i) => [["θ", "φ", "θ′", "φ′", "∫φ"][i], k, old?.K[i]])],
      ["loop at 100 Hz", [["radius", Math.max(...radius), old && Math.max(...old.radius)]]]
    ];
    this.find("links").innerHTML =
      links
        .map(([name, rows]) => `<div class="sos-box"><strong>${name}</strong> ` +
            rows
              .map(([key, value, before]) => `<span class="${
                     before !== undefined && clean(before, 4) !== clean(value, 4)
                       ? "sos-changed"
                       : ""}">${key} ${typeof value === "number" ? clean(value, 4) : value}</span>`)
              .join(" ") +
            "</div>")
        .join(`<div class="sos-then" aria-hidden="true">↓</div>`);
    this.curves("radius", ["vertex", "largest modulus"], "Largest modulus at the four vertices", [], {
      x: [0.5, 4.5],
      y: [Math.min(0.95, ...radius) - 0.01, Math.max(1.02, ...radius) + 0.01],
      rules: [1],
      marks: radius.map((r, k) => [[k + 1, r], r < 1 ? "--sos-region" : "--sos-bad", r < 1 ? 1 : 0])
    });
  }
}

define("sos-chain", Chain);
