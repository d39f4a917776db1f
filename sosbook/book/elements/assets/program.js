// The Python of a design, as readers copy it.
export const list = x => Array.isArray(x) ? `[${x.map(list).join(", ")}]`
  : typeof x === "string" ? JSON.stringify(x)
                          : String(x);

// A plant, then a call of the package; arguments are [name, text], and those without a text are
// left out.
export function program({vertices, family}, call, words, notes = [], more = "") {
  const plants = family
    ? [`sos.Uncertain.read(sos.SecondOrderSystem, {\n${
        Object.entries(family).map(([name, X]) => `    "${name}": ${list(X)},\n`).join("")}}, rows=True)`]
    : vertices.map(v => "sos.SecondOrderSystem(\n" +
          Object.entries(v).filter(([, X]) => X).map(([name, X]) => `    ${name}=${list(X)},\n`).join("") +
          ")");
  const plant = plants.length === 1 ? plants[0] : `sos.Polytope([\n${plants.join(",\n")}])`;
  const given = words.filter(([, text]) => text).map(([name, text]) => `    ${name}=${text},\n`).join("");
  return `import sosbook as sos\n${notes.map(note => note + "\n").join("")}\nplant = ${plant}\ndesign = sos.${
           call}(\n    plant,\n${given})\n` +
    `print(design.status)\nprint(design.K)\n${more}`;
}

// The design of what is asked: `program_data`, and bounds by name in the units shown.
export function design({request, x0, mu, cost, own = [], clock = null, law = null, outputs = null}, bounds) {
  const {U, K_A, coupling} = request;
  const rest = own.map(({key, text}) => text.replace("{}", bounds[key]));
  const words = given => Object.entries(given).map(([name, X]) => `${name}=${JSON.stringify(X)}`).join(", ");
  if (outputs)
    rest.push(
      `sos.HInfinity(${bounds.gamma}, outputs=${outputs.map(x => `sos.Output(${words(x)})`).join(" & ")})`);
  const region = [["sigma", "sigma"], ["theta", "theta_deg"], ["rho", "rho"]]
                   .filter(([key]) => bounds[key] !== undefined)
                   .map(([key, name]) => `${name}=${bounds[key]}`)
                   .join(", ");
  return program(request, "design_pid",
    [
      ["U", !law && U.length && list(U)], ["law", law && `sos.PIDLaw(${words(law)})`],
      ["K_A", K_A && list(K_A)], ["region", region && `sos.PoleRegion(${region})`],
      ["gamma", !outputs && bounds.gamma], ["mu", mu],
      [
        "cost",
        bounds.cost && `sos.QuadraticCost(${list(cost.Q)}, ${list(cost.R)}, "${cost.noise}", ${bounds.cost})`
      ],
      ["saturation", bounds.u_max && `sos.Saturation(${bounds.u_max}, ${list(x0)})`],
      ["requirements", rest.length && `[${rest.join(", ")}]`],
      ["coupling", coupling !== "pairs" && `"${coupling}"`]
    ],
    [...new Set(own.map(({note}) => note).filter(note => note))], clock ? sampled(clock, bounds) : "");
}

// The same gain with a clock, and an observer for what isn't measured.
function sampled({measured, T, delay}, {u_max}) {
  const names = measured ? `${list(measured)}, ` : "";
  return `controller = design.controller(${names}T=${T}${delay ? `, delay=${delay}` : ""})\n` +
    (u_max === undefined ? "" : `controller = controller.limit(u_max=${u_max})\n`) +
    `print(controller.certify(time_limit=60))\nprint(design.report("report", controller=controller))\n`;
}
