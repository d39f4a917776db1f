// The exact proof of a design and its file, which `python -m sosbook verify` accepts.
// Everything is read again from its text: the plant, the bounds, K and P.
import {coupledPairs, rounded, sized} from "./descriptor.js";
import {decimal, decimals, sector} from "./exact.js";
import {rowsOf} from "./matrices.js";
import {requirements, sizeName} from "./request.js";
import {fileOf, spread} from "./text.js";
import {unproven} from "./written.js";

const GAIN_DIGITS = [6, 8, 10, 12, 17], PLACES = [12, 17];  // in the order of trial

// {proven, text, claims, blocks, digits}: the first rounding that is proven, or the last.
export function prove(request, result) {
  let last = null;
  for (const digits of GAIN_DIGITS) {
    for (const places of PLACES) {
      const to = (rows, d) => rows.map(row => row.map(x => rounded(x, d)));
      const own = ownSizes(request, result).map(([key, s]) => [key, rounded(s, places)]);
      last = examined(request, to(result.K, digits), to(rowsOf(result.naturalP), places), own,
        result.J && to(rowsOf(result.J), places));
      if (last.proven) return {...last, digits};
    }
  }
  return last;
}

// With requirements that fix the size of P, the file's P is that of the last one.
function ownSizes({asked}, {sizes}) {
  const names = sized(asked), last = sizes[names.pop()];
  return last ? names.map(name => [sizeName(name), (sizes[name] || 1) / last]) : [];
}

function examined(request, K, P, own, J) {
  const sizes = Object.fromEntries(own.map(([key, s]) => [key, [[decimal(s)]]]));
  const unknowns = {P: decimals(P), ...(J && {J: decimals(J)}), ...sizes};
  const {file, keys} = fileOf("design", request, requirements(request.asked), {K: decimals(K), unknowns});
  const failed = unproven(file.text.join("\n"), file.sets, {...file.data, ...file.point});
  const proven = !failed.length;
  return {
    proven,
    failed,
    claims: proven ? claimsOf(request) : [],
    blocks: [...keys.values()],
    text: spread(file)
  };
}

// What a design claims, in words.
export function claimsOf(request) {
  const {vertices, asked} = request, count = vertices.length;
  const whole = coupledPairs(request).length === coupledPairs(request, "pairs").length;
  const where = count === 1 ? "the plant"
    : whole                 ? "every constant or changing plant of the polytope"  // one P for all
                            : `each of the ${count} vertices (not the plants between)`;
  const {sigma, theta, rho, gamma, cost, u_max} = asked, said = [];
  const say = (bound, words) => bound === undefined || said.push(words(bound));
  say(sigma, x => `its poles lie in the half-plane Re s < ${decimal(-x)}`);
  say(theta, x => `its poles lie in the sector of half-angle ${sector(x).degrees} degrees`);
  say(rho, x => `its poles lie in the disk of radius ${decimal(x)} around 0`);
  say(gamma, x => `its H-infinity norm is below ${decimal(x)}`);
  say(cost, x => `its quadratic cost is below ${decimal(x)} times the largest noise intensity`);
  say(u_max, x => `|K x(t)| <= ${decimal(x)} from x0 (with r = 0, w = 0)`);
  return [`${where}, under u = K x, is stable`, ...said];
}
