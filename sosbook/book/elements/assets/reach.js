// A chain of masses that one force shakes and one motor holds: at each frequency, what is
// left with the best of all inputs. What is refused or proven comes from the package.
import {clean, define, round} from "./kit.js";
import {solve} from "./linalg.js";
import {Mover, number} from "./mover.js";
import {picture, spring} from "./plot.js";

const POINTS = 300, MILLI = 1000, [LEFT, RIGHT, HEIGHT] = [10, 330, 74], ROOM = 24, HALF = 20;
const size = z => Math.hypot(...z.flat());

class Reach extends Mover {
  says = "The motor pushes {motor}, w shakes {gust} with ω = {omega}, and you ask for at most γ = {gamma}.";
  get horizon() { return 5; }
  get pace() { return 0.4; }
  get still() { return 0.1; }

  figures = {
    scene:
      "Choose a mass: the motor u pushes there. Pale: without it. Solid: with the best of all inputs at this frequency. Slowed down, and grown so that the pale motion has one size.",
    curve:
      "Motion for each newton of w. Orange, dashed: without the motor. Blue: with the best input at each frequency. Dotted: what you ask. Pale: before your last move."
  };

  // The motion for a unit of w that swings with ω: without a motor, and with the best of all inputs.
  at({motor, gust}, omega) {
    const {M, D, S} = this.data.plant, n = M.length;
    const still = S.map((row, i) => row.map((s, j) => s - omega * omega * M[i][j]));
    const real = [
      ...still.map((row, i) => [...row, ...D[i].map(d => -omega * d)]),
      ...still.map((row, i) => [...D[i].map(d => omega * d), ...row])
    ];
    const both = solve(real, real.map((_, k) => [k === motor ? 1 : 0, k === gust ? 1 : 0]));
    const [reach, free] = [0, 1].map(j => both.slice(0, n).map((row, i) => [row[j], both[n + i][j]]));
    const sum = f => reach.reduce((all, z, i) => all + f(z, free[i]), 0), power = size(reach) ** 2;
    const re = -sum(([a, b], [c, d]) => a * c + b * d) / power,
          im = -sum(([a, b], [c, d]) => a * d - b * c) / power;
    const left = free.map(([c, d], i) => {
      const [a, b] = reach[i];
      return [c + re * a - im * b, d + re * b + im * a];
    });
    return {free, left};
  }

  compute(place) {
    const grid = Array.from({length: POINTS + 1}, (_, k) => k * this.data.top / POINTS);
    const all = grid.map(omega => this.at(place, omega));
    const curve = kind => all.map((one, k) => [grid[k], MILLI * size(one[kind])]);
    return {...this.at(place, place.omega), curves: {free: curve("free"), left: curve("left")}};
  }

  wire() {
    super.wire();
    this.view.addEventListener("click", ({target}) => {
      const {cell} = target.closest("[data-cell]")?.dataset ?? {};
      if (cell === undefined) return;
      this.move({motor: Number(cell)});
    });
  }

  show(result, ghost, place) {
    const {excluded, at, reached, fixed} = this.data.found[place.motor][place.gust];
    const state = place.gamma < MILLI * excluded           ? "infeasible"
      : reached !== null && place.gamma >= MILLI * reached ? "feasible"
                                                           : "undecided";
    const words = {
      infeasible: `No gain keeps ${clean(place.gamma)} mm/N with the motor there. Near ${
        clean(at)} rad/s at least ${clean(MILLI * excluded)} mm/N is left: proven by the package.`,
      feasible: `Can be kept: the package found a gain and proved ${clean(MILLI * reached)} mm/N.`,
      undecided: "Undecided: the theorem doesn't refuse it, and no gain was sought so near its bound."
    }[state];
    const [free, left] = [result.free, result.left].map(z => number(MILLI * size(z), " mm/N"));
    const modes = fixed.map(([re, im]) => `${clean(re)} ± ${clean(im)}j`).join(", ");
    this.tell(state, words,
      `<p>At ${clean(place.omega)} rad/s: ${free} without the motor, ${left} with the best input.</p><p>${
        modes ? `The motor doesn't move the mode at ${modes} rad/s.` : "The motor moves every mode."}</p>`);
    const {curves} = result, top = Math.max(...curves.free.map(p => p[1]));
    this.curves("curve", ["frequency ω (rad/s)", "motion (mm/N)"],
      "Motion over frequency without the motor, and with the best input",
      [{points: curves.free, colour: "--sos-second", dash: "5 3"}, {points: curves.left}], {
        x: [0, this.data.top],
        y: [0, 1.05 * top],
        ghosts: ghost ? [{points: ghost.curves.left}] : [],
        rules: [place.gamma],
        marks: [[[place.omega, Math.min(1.05 * top, MILLI * size(result.left))], "--sos-first", 1]]
      });
    this.scene(place);
  }

  get rest() {
    const n = this.data.plant.M.length;
    return Array.from({length: n}, (_, i) => LEFT + (RIGHT - LEFT) * (i + 1) / (n + 1));
  }

  scene({motor, gust}) {
    const box = (x, kind) => `<rect class="${kind}" x="${round(x - HALF)}" y="${HEIGHT - HALF}" width="${
      2 * HALF}" height="${2 * HALF}" rx="4"/>`;
    const masses =
      this.rest.map((x, i) => `<g class="sos-pale" style="opacity:.5">${box(x, "sos-thin")}</g>` +
          `<g class="sos-mass" data-cell="${i}">${box(x, "sos-part")}` +
          `<text x="${round(x)}" y="${HEIGHT + 4}" text-anchor="middle">${i + 1}</text></g>`);
    /** @type {(i: number, y: number, colour: string, words: string) => string} */
    const arrow = (i, y, colour, words) => {
      const x = round(this.rest[i]);
      return `<path class="sos-line" style="stroke:var(${colour});stroke-width:3" d="M${x - 16} ${y}H${
        x + 14}M${x + 8} ${y - 5}L${x + 15} ${y}L${x + 8} ${y + 5}"/><text x="${x + 22}" y="${y + 4}">${
        words}</text>`;
    };
    this.find("scene").innerHTML =
      picture(140, `Masses between walls; w shakes mass ${gust + 1}, the motor pushes mass ${motor + 1}`,
        `<path class="sos-thin" d="M${LEFT} 44V104M${RIGHT} 44V104"/><path class="sos-thin sos-springs"/>` +
          arrow(gust, 30, "--sos-second", "w") + arrow(motor, 122, "--sos-first", "u") + masses.join(""));
  }

  pose({free, left}, time) {
    const angle = this.place.omega * time, grow = ROOM / Math.max(...free.map(z => Math.hypot(...z)));
    const at = ([re, im]) => grow * (re * Math.cos(angle) - im * Math.sin(angle)), scene = this.find("scene");
    const put = (kind, z) => scene.querySelectorAll(kind).forEach(
      (part, i) => part.setAttribute("transform", `translate(${round(at(z[i]))} 0)`));
    put(".sos-pale", free);
    put(".sos-mass", left);
    const ends =
      [LEFT, ...this.rest.flatMap((x, i) => [x + at(left[i]) - HALF, x + at(left[i]) + HALF]), RIGHT];
    this.find("springs").setAttribute(
      "d", ends.map((x, k) => k % 2 ? "" : spring([x, HEIGHT], [ends[k + 1], HEIGHT])).join(""));
    super.pose({free, left}, time);
  }
}

define("sos-reach", Reach);
