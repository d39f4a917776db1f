// Proof files: the text that the package's checker writes for what a page can ask, to the
// letter, and its data.
import {coupledPairs} from "./descriptor.js";
import {decimals, ratio, sha256, weightFactors} from "./exact.js";
import {impliesStability, sizeName} from "./request.js";

const SIZED = ["gamma", "cost", "input"];  // whose blocks aren't homogeneous in P
const GIVEN = {
  "half-plane": ["alpha", "beta", "sigma"],
  sector: ["alpha", "beta", "theta", "apex", "degrees"],
  disk: ["alpha", "beta", "rho", "centre"],
  gamma: ["gamma", "mu"],
  cost: ["bound"],
  input: ["u_max"]
};  // the data of a region's form and of other kinds, beside matrices and states

// The file of a kind of proof: what a request asks, as the requirements of a file, and K with
// the `unknowns`, or the coordinates with the multipliers.
export function fileOf(
  kind, request, requirements, {K, unknowns = null, coordinates = null, multipliers = null}) {
  const {vertices, U = [], K_A = null, coupling = "pairs"} = request, framed = coordinates !== null;
  const n = vertices[0].M.length, N = 2 * n + U.length, m = vertices[0].B[0].length;
  const text = [], data = {}, once = [], each = [], free = {}, point = {};
  const put = (name, x, width = 0) => {
    const empty = Array.isArray(x) && !(x.length && x[0].length);
    data[name] = empty ? {zeros: [x.length, x.length ? 0 : width]} : x;
    return "=" + name;
  };
  const plant = {
    kind: "second order",
    vertices: vertices.map(v => Object.fromEntries(["M", "D", "S", "B", "F"].map(
                             name => [name, v[name] ? decimals(v[name]) : v.M.map(() => [])])))
  };
  const asks = {
    plant: {
      kind: plant.kind,
      vertices: plant.vertices.map((v, k) => Object.fromEntries(Object.entries(v).map(
                                     ([name, x]) => [name, put(`${name}.${k + 1}`, x)])))
    },
    U: U.length ? put("U", decimals(U)) : [],
    K_A: K_A && put("K_A", decimals(K_A)),
    coupling,
    epsilon: null,
    E0: null
  };
  text.push(...plantLines(U.length > 0, K_A !== null));
  const frame = framed &&
    Object.fromEntries(
      Object.entries(coordinates).map(([name, x]) => [name, name === "sizes" ? x : put(name, x)]));
  if (framed) {
    text.push(...["left", "T", "back"].map(x => `${x}.regular: inv(${x}) ${x} == I(${N})`));
    text.push("sign.scale: scale > 0", "X = T P T'");
  }
  const sizes = {}, named = multipliers?.map(([[, , block]]) => block) ?? Object.keys(unknowns);
  for (const size of SIZED) {
    const r = requirements.find(({kind}) => kind === size);
    if (!r || !named.includes(sizeOf(r))) continue;
    sizes[size] = `s_${size} `;
    free[`s_${size}`] = "number";
    if (unknowns) point[`s_${size}`] = unknowns[sizeOf(r)][0][0];
    text.push(`s_${size}: s_${size} > 0`);
  }
  free.P = `symmetric ${N}`;
  text.push("P: P > 0");
  if (unknowns) point.P = unknowns.P;
  const gain = K && put("K", K);
  if (K) text.push("Y = K P");
  else free.Y = `${m} x ${N}`;
  if (framed) text.push("Yx = scale Y T'");
  asks.requirements = requirements.map((r, k) => {
    const asked = {...r};
    for (const name of GIVEN[r.form ?? r.kind]) {
      const full = r.form ? `${name}.${k + 1}` : name;
      if (r[name] === null) text.push("mu = 1");
      else asked[name] = put(full, r[name]);
      if (r[name] !== null && !r.form) text.push(`sign.${full}: ${full} > 0`);
    }
    return asked;
  });
  const [back, to, X] = framed ? ["back ", " back'", "X"] : ["", "", "P"];
  for (const r of demands(request.asked, requirements)) {
    const k = requirements.indexOf(r), asked = asks.requirements[k], s = sizes[r.kind] ?? "";
    const add = (list, name, block) => list.push(`${name}: ${block} > 0`);
    const poles = (name, a, b) => add(each, `${name}.i.j`, `-(kron(${a}, EPE) + he(kron(${b}, Theta)))`);
    if (r.kind === "stability") poles("stability", "[0]", "[1]");
    if (r.kind === "region") poles(`region.${k + 1}`, `alpha.${k + 1}`, `beta.${k + 1}`);
    if (r.kind === "gamma")
      add(each, "hinf.i.j", `-[he(Theta), EP C', ${s}W; ., -${s}gamma^2/mu, 0; ., 0, -${s}mu]`);
    if (r.kind === "input") {
      put("x0", r.x0.map(x => [x]));
      asked.x0 = "|x0";
      add(once, "x0", `[${s.trim() || 1}, ${s}x0'${to}; ., ${back}${X}${to}]`);
      add(once, "u_max", `[P, Y'; ., ${s}u_max^2${framed ? "/(scale)^2" : ""}]`);
    }
    if (r.kind !== "cost") continue;
    const states = r.noise === "states", J = framed || !s ? "J" : `${s}J`;
    Object.assign(asked, {R: put("R", r.R), Q: put("Q", r.Q)});
    const {L, W} = factors(r.Q.map(row => row.map(Number)));
    put("L", L);
    put("Wq", W);
    text.push("R: R > 0", "Wq: Wq > 0", "Q: L inv(Wq) L' == Q");
    free.J = `symmetric ${states ? N : vertices[0].F[0].length}`;
    if (unknowns) point.J = unknowns.J;
    add(once, "trace", `${s}bound - tr(${J})`);
    if (states) add(once, "cost", `[${J}, ${framed ? `${s}back'` : s.trim() || 1}; ., ${back}${X}${to}]`);
    else add(each, "cost.i.j", `[${J}, ${s}W'; ., EPE]`);
    const [y, r2] = framed ? ["EY/scale", "/(scale)^2"] : ["EY", ""];
    add(each, "lqr.i.j", `-[he(Theta), EP L, ${y}; ., -${s}Wq, 0; ., 0, -${s}inv(R)${r2}]`);
  }
  text.push(...once, "for i, j in pairs:", ...[...pairLines(framed), ...each].map(x => "  " + x));
  const label = ([kind, name, block, i, j = i]) => {
    const k = requirements.findIndex(r => r.kind === kind && r.name === name) + 1;
    const head = block.startsWith("size for ") ? `s_${kind}` : block || `region.${k}`;
    return i === undefined ? head : `${head}.${i + 1}.${j + 1}`;
  };
  const more = unknowns
    ? {
        unknowns: Object.fromEntries(
          Object.keys(unknowns).map(name => [name, name in free ? "=" + name : "#s_" + name.split(" ")[2]]))
      }
    : {coordinates: frame, multipliers: multipliers.map(([key]) => [key, "*" + label(key)])};
  const pairs = coupledPairs(request).map(pair => pair.map(i => String(i + 1)));
  const about = {plant, U: decimals(U), K_A: K_A && decimals(K_A), K};
  for (const {x0} of requirements)
    if (x0) about.x0 = x0;
  return spread({
    format: "sosbook proof",
    version: 2,
    kind,
    about: Object.fromEntries(
      Object.entries(about).filter(([, x]) => x && (x === plant || x.length)).map(([name,
        x]) => [name, sha256(JSON.stringify(sortedKeys(x))).slice(0, 12)])),
    asks: {...asks, K: gain, ...more},
    text,
    data,
    sets: {vertices: vertices.map((_, i) => [String(i + 1)]), pairs},
    unknowns: free,
    ...unknowns ? {point} : {multipliers: Object.fromEntries(multipliers.map(([key, Z]) => [label(key), Z]))}
  });
}

const sizeOf = ({kind, name}) => sizeName([...new Set([kind, name])].join(" "));

// The requirements in the order of their blocks: what implies stability comes first.
function demands(asked, requirements) {
  const [kind, name] = impliesStability(asked) ?? ["stability", "stability"];
  const stable = requirements.find(r => r.kind === kind && r.name === name) ?? {kind};
  return [stable, ...requirements.filter(r => r !== stable)];
}

function plantLines(U, K_A) {
  const M = K_A ? "M.i - B.i K_A" : "M.i", of = U ? "rows(U)" : "";
  return [
    "n = rows(M.1)", `C = [I(n), O(n, n${U ? " + rows(U)" : ""})]`, "for i in vertices:",
    U ? `  E.i = [I(n), 0, 0; 0, ${M}, 0; 0, 0, I(${of})]` : `  E.i = [I(n), 0; 0, ${M}]`,
    U ? `  A.i = [0, I(n), O(n, ${of}); -S.i, -D.i, 0; U, O(${of}, n), 0]` : "  A.i = [0, I(n); -S.i, -D.i]",
    `  Bu.i = [O(n, cols(B.i)); B.i${U ? "; O(rows(U), cols(B.i))" : ""}]`,
    `  Bw.i = [O(n, cols(F.i)); F.i${U ? "; O(rows(U), cols(F.i))" : ""}]`
  ];
}

function pairLines(framed) {
  const [left, right, X, Y] = framed ? ["left ", " left'", "X", "Yx"] : ["", "", "P", "Y"];
  return [
    `Theta = ${left}((A.i ${X} + Bu.i ${Y}) E.j' + (A.j ${X} + Bu.j ${Y}) E.i')${right}/2`,
    `EPE = ${left}he(E.i ${X} E.j')${right}/2`, `EP = ${left}(E.i + E.j) ${X}/2`,
    `EY = ${left}(E.i + E.j) ${Y}'/2`, `W = ${left}(Bw.i + Bw.j)/2`
  ];
}

// L and W with Q = L inv(W) L' and W diagonal, in fractions.
function factors(Q) {
  const {L, W, d} = weightFactors(Q), N = L.rows, n = L.cols, unit = k => d.at[k * n + k];
  const table = (rows, value) =>
    Array.from({length: rows}, (_, i) => Array.from({length: n}, (_, k) => value(i, k)));
  return {
    L: table(N, (i, k) => ratio(L.at[i * n + k], unit(k))),
    W: table(n, (i, k) => i === k ? ratio(W.at[i * n + k], unit(k) ** 2n) : "0")
  };
}

// JSON with what is named on a line of its own.
function spread(whole) {
  const named = ([key, x]) => `${JSON.stringify(key)}:${JSON.stringify(x)}`;
  const lines = Object.entries(whole).map(([key, x]) => {
    const inner = Array.isArray(x) ? `[\n${x.map(y => JSON.stringify(y)).join(",\n")}]`
      : typeof x === "object" && Object.keys(x).length ? `{\n${Object.entries(x).map(named).join(",\n")}}`
                                                       : JSON.stringify(x);
    return `${JSON.stringify(key)}:${inner}`;
  });
  return `{${lines.join(",\n")}}\n`;
}

function sortedKeys(x) {
  if (Array.isArray(x)) return x.map(sortedKeys);
  if (x === null || typeof x !== "object") return x;
  return Object.fromEntries(Object.keys(x).sort().map(key => [key, sortedKeys(x[key])]));
}
