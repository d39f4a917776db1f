// Discs on a shaft, seen from the side.
import {round} from "./kit.js";

const MIDDLE = 70;

// A disc at x, turned by an angle; of a pale one the mark alone is drawn.
export const disc = (x, size, angle, pale = false) => {
  const rim = turn => [round(x + 0.35 * size * Math.sin(turn)), round(MIDDLE - size * Math.cos(turn))];
  const spokes = [0, 1, 2].map(i => `M${x} ${MIDDLE}L${rim(angle + 2 * Math.PI * i / 3).join(" ")}`);
  const [u, v] = rim(angle);
  const dot = `<circle cx="${u}" cy="${v}" r="4" style="fill:var(--sos-${pale ? "second" : "first"})"/>`;
  return pale ? `<path class="sos-thin" style="stroke:var(--sos-second)" d="${spokes[0]}"/>${dot}`
              : `<ellipse class="sos-part" cx="${x}" cy="${MIDDLE}" rx="${round(0.35 * size)}" ry="${
                  round(size)}"/><path class="sos-thin" d="${spokes.join("")}"/>${dot}`;
};

// The twist of a shaft from one angle to another, between two places.
export const twist = ([from, one], [to, other], lines = 13, thick = 9) => `<path class="sos-thin" d="M${from} ${MIDDLE - thick}H${to}M${from} ${MIDDLE + thick}H${to}"/>` +
  `<path class="sos-thin" style="stroke:var(--sos-second)" d="${Array.from({length: lines}, (_, i) => {
      const part = i / (lines - 1), turn = one + (other - one) * part, c = round(thick * Math.cos(turn));
      const x = round(from + (to - from) * part);
      return `M${x} ${MIDDLE - c}L${round(x + 4 * Math.sin(turn))} ${MIDDLE + c}`;}).join("")}"/>`;
