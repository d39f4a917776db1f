// A plant as its matrices have it: a box for each coordinate, what joins the boxes, what
// pushes them and what is measured. It moves once as the loop does, unless motion is unwanted.
import {round} from "./kit.js";
import {picture, spring} from "./plot.js";

const MOST = 6, FRAMES = 40, SECONDS = 3;
const FLOOR = 90, HALF = 20;  // of a box: the height of its feet and half of its width, at most
const CALM = matchMedia("(prefers-reduced-motion: reduce)");

// A pot and a piston between two places on a line.
const damper = ([a, y], [b]) => {
  const c = round((a + b) / 2);
  return `M${round(a)} ${y}H${c - 5}M${c + 5} ${y - 5}H${c - 5}V${y + 5}H${c + 5}M${round(b)} ${y}H${c}M${
    c} ${y - 3}V${y + 3}`;
};

// `rows` are displacements at equal times, `seen` the names of what is measured, or null: all.
/** @type {(plant: any, seen: any, rows: any) => string} */
export function machine({M = [], D, S, B, F = []}, seen, rows) {
  const n = M.length, wide = 292 / n, half = Math.min(HALF, 0.2 * wide);
  if (!n || n > MOST) return "";
  const run = rows ?? [M.map(() => 0)], most = Math.max(...run.flat().map(Math.abs)) || 1;
  const x = (z, i) => 24 + (i + 0.5) * wide + 0.22 * wide * z[i] / most, end = run.at(-1);
  const every = Math.ceil(run.length / FRAMES), frames = run.filter((_, k) => k % every === 0);
  const moves = (name, at, kind = "") => frames.length < 2 || CALM.matches
    ? ""
    : `<animate${kind && "Transform"} attributeName="${name}" ${kind} dur="${
        SECONDS}s" fill="freeze" values="${[...frames, end].map(at).join(";")}"/>`;
  // the middle of what couples i and j, and its size: below zero it pushes apart
  const both = (X, i, j) => (X[i][j] + X[j][i]) / 2, size = X => Math.max(...X.flat().map(Math.abs));
  const real = (X, value) => Math.abs(value) > 1e-9 * size(X);
  let body = `<path class="sos-thin" d="M2 ${FLOOR}H338"/>`;
  const line = (at, value) => {
    const odd = value < 0 ? ";stroke:var(--sos-bad)" : "";
    body += `<path class="sos-thin" style="stroke-dasharray:${value < 0 ? "3 2" : "none"}${odd}" d="${
      at(end)}">${moves("d", at)}</path>`;
  };
  for (let i = 0; i < n; i++) {
    const right = i && i === n - 1, edge = !i || right, wall = right ? 336 : 4;
    for (const [X, y, draw] of [[S, 52, spring], [D, 72, damper]]) {
      const ground = X.reduce((sum, _, j) => sum + both(X, i, j), 0);
      if (real(X, ground)) {
        if (edge) body += `<path class="sos-axis" d="M${wall} ${y - 12}V${y + 12}"/>`;
        line(z => edge ? draw([x(z, i) + (right ? half : -half), y], [wall, y])
                       : spring([x(z, i), 80], [24 + (i + 0.5) * wide, FLOOR], 4),
          ground);
      }
      for (let j = i + 1; j < n; j++) {
        const value = -both(X, i, j);
        if (!real(X, value)) continue;
        line(j === i + 1 ? z => draw([x(z, i) + half, y], [x(z, j) - half, y])
                         : z => `M${round(x(z, i))} 42Q${round((x(z, i) + x(z, j)) / 2)} ${
                             X === S ? 16 : 10} ${round(x(z, j))} 42`,
          value);
      }
    }
  }
  for (let i = 0; i < n; i++) {
    const arrow = (b, y) => {
      const way = Math.sign(b);
      return `M${- 14 * way} ${y}h${28 * way}m${- 5 * way} -4l${5 * way} 4l${- 5 * way} 4`;
    };
    const force = (X, y, name, colour) =>
      (X[i] ?? [])
        .map((b, k) => b &&
            `<path class="sos-line" style="stroke:var(${colour})" d="${arrow(b, y)}"/>` +
              `<text x="18" y="${y + 4}">${name}${X[i].length > 1 ? "₁₂₃₄₅₆₇₈₉"[k] : ""}</text>`)
        .filter(text => text)
        .join("");
    const ticks = ["", "'"].map((mark, k) => !seen || seen.includes(`z${i + 1}${mark}`)
        ? `<path d="M${8 * k - 4} ${FLOOR + 3}l-3 7h6z" style="fill:var(--sos-${k ? "second" : "first"})"/>`
        : "");
    body += `<g transform="translate(${round(x(end, i))})">${
      moves("transform", z => round(x(z, i)),
        `type="translate"`)}<rect class="sos-part" x="${- half}" y="42" width="${
      2 * half}" height="40" rx="4"/><text y="66" text-anchor="middle">z${"₁₂₃₄₅₆"[i]}</text>${
      force(B, 30, "u", "--sos-first")}${force(F, 14, "w", "--sos-second")}${ticks.join("")}</g>`;
  }
  return picture(104, `${n} ${n > 1 ? "boxes, joined" : "box, held"} as S and D say`, body);
}
