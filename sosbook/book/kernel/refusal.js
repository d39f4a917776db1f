// Why there is no design, in exact arithmetic: multipliers Z_k > 0 of the blocks G_k with
// sum <G_ka, Z_k> = 0 for every variable a and sum <G_k0, Z_k> <= 0. With all G_k > 0
// that sum would be positive. Floats come near; a few entries make it exact.
import {FRACTIONS} from "./arithmetic.js";
import {rounded} from "./descriptor.js";
import {atPlaces, decimal, decimals, definite, divisor, EXACT, exactInner, exactMatrix, exactScalar, exactScaled, exactSum, exactTimes, exactTransposed, exactZeros, nearly, ratio} from "./exact.js";
import {dot, inverse, mapped, rowsOf} from "./matrices.js";
import {claimsOf} from "./proof.js";
import {Reader} from "./reader.js";
import {conditionOf, followersOf, ownerOf, requirements} from "./request.js";
import {fileOf, sizeOf, spread} from "./text.js";
import {products, unknownsOf} from "./written.js";

const MULTIPLIER_DIGITS = 15;

// {file, keys, list, Z, scales}: the text's blocks, and their exact multipliers Z / scale by
// the float ones; null where no exact ones were found.
export function refusalOf(request, frame, blocks, floats) {
  const {asked} = request, [left, T, back] = ["left", "T", "back"].map(name => decimals(rowsOf(frame[name])));
  const all = requirements(asked), followers = followersOf(asked);
  const sizes = all.filter(r => followers.includes(ownerOf(r))).map(sizeOf);
  const coordinates = {left, T, back, scale: decimal(frame.scale), sizes: {}};
  const {file, keys, said} = fileOf("infeasible design", request, all, {coordinates, sizes});
  const {list, unknowns, D} = wholes(file, said);
  const unscaled =
    floats.map((z, k) => mapped(z, (x, i, j) => x * blocks.list[k].d[i] * blocks.list[k].d[j]));
  const Z = unscaled.map(z => exactMatrix(rowsOf(mapped(z, x => rounded(x, MULTIPLIER_DIGITS)))));
  const mended = withoutP(list, unknowns, Z, unscaled, String(D).length);
  if (!mended) return null;
  const {repaired, scale} = mended, place = list.findIndex(({name}) => name === "P");
  if (unknowns.J) withoutJ(list, keys, repaired, unknowns.J.rows);
  const others = list.filter((_, k) => k !== place);
  const P = symmetricSlope(others, repaired.filter((_, k) => k !== place), unknowns.P.rows);
  repaired[place] = EXACT.scaled(-1, P);
  const scales = list.map((_, k) => k === place ? scale * D : scale);
  if (!excludes(list, repaired, Z, scales)) return null;
  return {file, keys, list, Z: repaired, scales};
}

// Whether multipliers that cancel all variables exclude the blocks: each is positive definite, as
// the decimals near it say, and the constants' sum isn't positive.
export function excludes(list, Z, near, scales) {
  const sum = list.reduce((sum, {constant}, k) => exactSum(sum, exactInner(constant, Z[k])), exactScalar(0));
  return sum.at[0] <= 0n && Z.every((far, k) => staysDefinite(near[k], far, scales[k]));
}

// The blocks of a file's text and its unknowns; all are multiplied by D, so that they are whole.
function wholes({text, data, sets}, said) {
  const reader = new Reader(FRACTIONS);
  for (const [name, x] of Object.entries(data)) reader.env[name] = reader.known(x);
  const unknowns = unknownsOf(reader, said), lines = text.filter(line => !line.includes(".regular:"));
  const multiple = dens => [...new Set(dens)].reduce((a, d) => a / divisor(a, d) * d, 1n);
  const common = X => multiple(X.at.map(([, d]) => d));
  const read = [...products(reader, lines.join("\n"), sets)].map(
    ({terms, ...more}) => ({...more, terms: terms.map(([of, L, R]) => [of, L, R, common(L), common(R)])}));
  const D =
    multiple(read.flatMap(({constant, terms, slopes}) => [common(constant),
                            ...slopes.map(([, G]) => common(G)), ...terms.map(([, , , l, r]) => l * r)]));
  const whole = ({rows, cols, at}, by = D) => ({rows, cols, places: 0, at: at.map(([n, d]) => n * by / d)});
  const list = read.map(({name, constant, terms, slopes}) => ({
    name,
    constant: whole(constant),
    slopes: slopes.map(([of, G]) => [of, whole(G)]),
    terms: terms.map(([of, L, R, , r]) => [of, whole(L, D / r), whole(R, r)])
  }));
  return {list, unknowns, D};
}

// J is a corner of each block of (2.35), and minus its trace is that of (2.34): the
// multiplier's corner cancels it.
function withoutJ(list, keys, Z, channels) {
  const blocks = list.map(({name}) => keys.get(name)[2]);
  const at = [...blocks.keys()].filter(k => blocks[k] === "cost"), trace = Z[blocks.indexOf("trace")];
  let sum = exactScaled(trace, EXACT.identity(channels, -1));
  for (const k of at) {
    const {rows: q, places} = Z[k], corner = {...exactZeros(channels, channels), places};
    for (let i = 0; i < channels; i++)
      for (let j = 0; j < channels; j++) corner.at[i * channels + j] = Z[k].at[i * q + j];
    sum = exactSum(sum, corner);
  }
  EXACT.place(Z[at[0]], 0, 0, sum, -1);
}

// sum over the blocks of <G_a, Z> by the entries of a symmetric unknown P.
function symmetricSlope(list, Z, N) {
  let sum = exactZeros(N, N);
  list.forEach(({terms}, k) => terms.forEach(([name, L, R]) => {
    if (name !== "P") return;
    const half = exactTimes(exactTimes(exactTransposed(L), Z[k]), exactTransposed(R));
    sum = exactSum(exactSum(sum, half), exactTransposed(half));
  }));
  return sum;
}

// Multipliers {repaired, scale}, multiplied by scale > 0, that cancel all variables but P and J:
// as few entries are changed as there are variables, those with the most room. The blocks'
// numbers are about 10^digits times as large as they were, which no float holds.
function withoutP(list, unknowns, Z, floats, digits) {
  const {rows: m, cols: N} = unknowns.Y;
  const sizes = Object.keys(unknowns).filter(name => !["P", "Y", "J"].includes(name));
  let residual = exactZeros(m, N);
  const values = sizes.map(() => exactScalar(0));
  list.forEach(({terms, slopes}, k) => {
    for (const [name, L, R] of terms) {
      if (name === "Y")
        residual = exactSum(
          residual, EXACT.scaled(2, exactTimes(exactTimes(exactTransposed(L), Z[k]), exactTransposed(R))));
    }
    for (const [name, G] of slopes) {
      const s = sizes.indexOf(name);
      values[s] = exactSum(values[s], exactInner(G, Z[k]));
    }
  });
  const right = [...residual.at.map(x => ({...residual, rows: 1, cols: 1, at: [x]})), ...values];
  // the derivatives by all variables of <G, e_i e_j' + e_j e_i'>, and how much room there is
  const entries = [];
  list.forEach((block, k) => {
    if (!block.slopes.length && !block.terms.some(([name]) => name === "Y")) return;
    const q = Z[k].rows, root = inverse(floats[k]);
    for (let i = 0; root && i < q; i++)
      for (let j = 0; j <= i; j++) {
        const slope = slopeAt(block, i, j, m, N, sizes);
        const room = 1 / Math.sqrt(root.at[i * q + i] * root.at[j * q + j]);
        if (slope.some(x => x.at[0] !== 0n))
          entries.push(
            {k, i, j, slope, floats: slope.map(x => room * nearly({...x, places: x.places + digits}))});
      }
  });
  const few = independent(entries, right.length);
  const solution = few && solvedExactly(few.map(e => e.slope), right);
  if (!solution) return null;
  const {scale, changes} = solution, unit = {rows: 1, cols: 1, places: 0, at: [scale]};
  const repaired = Z.map(z => exactScaled(unit, z));
  few.forEach(({k, i, j}, c) => {
    const q = Z[k].rows, change = exactZeros(q, q);
    change.at[i * q + j] = change.at[j * q + i] = -changes[c];
    repaired[k] = exactSum(repaired[k], change);
  });
  return {repaired, scale};
}

function slopeAt({terms, slopes}, i, j, m, N, sizes) {
  /** @type {any} */
  const twice = i === j ? 1n : 2n;
  const slope = Array.from({length: m * N + sizes.length}, () => exactScalar(0));
  for (const [name, L, R] of terms) {
    if (name !== "Y") continue;
    for (let p = 0; p < m; p++)
      for (let q = 0; q < N; q++) {
        const value = L.at[i * m + p] * R.at[q * R.cols + j] + L.at[j * m + p] * R.at[q * R.cols + i];
        if (value)
          slope[p * N + q] =
            exactSum(slope[p * N + q], {rows: 1, cols: 1, places: L.places + R.places, at: [twice * value]});
      }
  }
  for (const [name, G] of slopes) {
    slope[m * N + sizes.indexOf(name)] =
      {rows: 1, cols: 1, places: G.places, at: [twice * G.at[i * G.cols + j]]};
  }
  return slope;
}

// As many entries as there are variables, whose slopes are independent: the largest first,
// each less its part along those before (Golub and Van Loan, section 5.4.2).
function independent(entries, count) {
  const sizes = Array.from({length: count}, (_, v) => Math.hypot(...entries.map(e => e.floats[v])) || 1);
  const rest = entries.map(entry => ({entry, x: entry.floats.map((x, v) => x / sizes[v])}));
  const few = [];
  let first = 0;
  while (few.length < count && rest.length) {
    const lengths = rest.map(({x}) => Math.hypot(...x)), longest = Math.max(...lengths);
    first ||= longest;
    if (!(longest > 1e-9 * first)) break;
    const [{entry, x}] = rest.splice(lengths.indexOf(longest), 1), unit = x.map(v => v / longest);
    for (const other of rest) {
      const along = dot(unit, other.x);
      other.x = other.x.map((v, k) => v - along * unit[k]);
    }
    few.push(entry);
  }
  return few.length ? few : null;
}

// {scale, changes} with sum_c changes_c columns_c = scale right, by elimination without
// divisions that leave a remainder (Bareiss); null where there is none.
function solvedExactly(columns, right) {
  const places = Math.max(...columns.flat().map(x => x.places)), n = columns.length;
  const more = Math.max(...right.map(x => x.places));
  const rows =
    right.map((r, v) => [...columns.map(c => atPlaces(c[v], places).at[0]), atPlaces(r, more).at[0]]);
  /** @type {any} */
  let last = 1n;
  const done = [];
  for (let c = 0; c < n; c++) {
    const at = rows.findIndex(row => row[c] !== 0n);
    if (at < 0) return null;
    const [pivot] = rows.splice(at, 1), lead = pivot[c];
    for (const list of [done, rows]) {
      list.forEach((row, k) => {
        const f = row[c];
        list[k] = row.map((x, j) => (lead * x - f * pivot[j]) / last);
      });
    }
    done.push(pivot);
    last = lead;
  }
  if (rows.some(row => row[n] !== 0n)) return null;
  // now every row of `done` says last 10^-places x_c = row[n] 10^-more
  const sign = last < 0n ? -1n : 1n, longer = Math.max(0, more - places);
  const shift = Math.max(0, places - more);
  return {
    scale: sign * last * 10n ** BigInt(longer),
    changes: done.map(row => sign * row[n] * 10n ** BigInt(shift))
  };
}

// Whether far / scale is positive definite because the decimals near it are: with the sum
// c_i over j of |far / scale - near|_ij w_j / w_i, near - diag(c) > 0 implies it
// (Gershgorin, after a diagonal scaling by any w > 0).
export function staysDefinite(near, far, scale) {
  const n = near.rows, places = near.places + 3, lowered = atPlaces(near, places).at.slice();
  const w = Array.from({length: n},
    (_, i) => Math.round(Math.log10(Math.abs(nearly({...near, at: [near.at[i * n + i]]})) || 1) / -2));
  const common = Math.max(places, far.places), unit = 10n ** BigInt(common - places);
  const here = atPlaces(near, common).at, there = atPlaces(far, common).at;
  for (let i = 0; i < n; i++) {
    for (let j = 0; j < n; j++) {
      /** @type {any} */
      let off = there[i * n + j] - scale * here[i * n + j];
      if (off === 0n) continue;
      if (off < 0n) off = -off;
      const power = BigInt(w[j] - w[i]), up = power > 0n ? off * 10n ** power : off;
      const down = power < 0n ? 10n ** -power : 1n;
      lowered[i * n + i] -= up / (scale * unit * down) + 1n;
    }
  }
  return definite({rows: n, at: lowered});
}

// The file of a refusal, which `python -m sosbook verify` accepts.
export function refusalFile(request, {file, keys, list, Z, scales}) {
  const tied = conditionOf(request.asked, decimal), multipliers = {};
  const claims = [`no gain and no matrices prove by these LMIs${tied}: ${claimsOf(request).join("; ")}`];
  list.forEach(({name}, k) => {
    const {rows: q, at, places} = Z[k], below = scales[k] * 10n ** BigInt(places);
    multipliers[name] =
      Array.from({length: q}, (_, i) => at.slice(i * q, (i + 1) * q).map(x => ratio(x, below)));
  });
  const asks = {...file.asks, multipliers: list.map(({name}) => [keys.get(name), "*" + name])};
  return {proven: true, claims, blocks: [...keys.values()], text: spread({...file, asks, multipliers})};
}
