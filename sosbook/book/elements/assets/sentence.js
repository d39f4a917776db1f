// What a plant file asks, as a sentence of English: the page's counterpart of the package's
// requirements/sentence.py, by the same table of words. The package reads it again.
import TABLE from "../../../requirements/sentence.json" with {type : "json"};

/** @type {any[]} */
const CLAUSES = TABLE.clauses;
const DIGITS = 6, WIDEST = 21;
const KEPT = ["$schema", "plant", "words", "U", "search"];

// ------------------------------------------------------------------ numbers
// The sign, the digits and the place of the point of a decimal.
/** @returns {[string, string, number]} */
function digitsOf(text) {
  const [, sign, whole, part, power] = /^([-+]?)(\d*)\.?(\d*)(?:e([-+]?\d+))?$/.exec(text);
  return [sign, whole + part, whole.length + Number(power ?? 0)];
}
function show(text, power = 0) {
  const [sign, all, point] = digitsOf(text), late = all.replace(/^0+/, "");
  const digits = late.replace(/0+$/, ""), k = digits.length, n = point + power - all.length + late.length;
  if (!k) return "0";
  const shown = k <= n && n <= WIDEST ? digits + "0".repeat(n - k)
    : 0 < n && n <= WIDEST            ? `${digits.slice(0, n)}.${digits.slice(n)}`
    : -6 < n && n <= 0 ? `0.${"0".repeat(-n)}${digits}`
                       : `${digits[0]}${k > 1 ? "." : ""}${digits.slice(1)}e${n > 0 ? "+" : ""}${n - 1}`;
  return (sign === "-" ? "−" : "") + shown.replace("-", "−");
}
const plain = text => {
  const word = text.trim().toLowerCase().replaceAll("−", "-");
  return word.includes(".") ? word : word.replace(",", ".");
};
// The number of a file that a text in a clause means, and the shortest text that means a number.
export function valueOf({over = undefined, shift = 0}, text) {
  const [sign, digits, point] = digitsOf(plain(text)), x = Number(`${sign}0.${digits}e${point + shift}`);
  return over === undefined ? x : x ? over / x : Infinity;
}
export function shownOf(clause, x) {
  const {over = undefined, shift = 0} = clause;
  if (over === undefined) return show(String(x), -shift);
  for (let digits = 0; digits < (x > 0 ? DIGITS : 0); digits++) {
    const text = show((over / x).toExponential(digits), -shift);
    if (valueOf(clause, text) === x) return text;
  }
  return null;
}

// ------------------------------------------------------------------- places
const get = (data, at) => at.reduce((inner, name) => inner?.[name], data);
const limit = data => data.saturation?.u_max ?? undefined;
const eye = n => Array.from({length: n}, (_, i) => Array.from({length: n}, (_, j) => Number(i === j)));

// A plant file in the one form that a sentence leads to.
function canonical(given) {
  const data = structuredClone(given), {region, law, controller} = data;
  if (region?.settling_time !== undefined) {
    region.sigma = 4 / region.settling_time;
    delete region.settling_time;
  }
  if (law && "integrate" in law) {
    if (law.integrate === true) law.integrate = eye(law.position?.length ?? 0);
    if (!law.integrate || !law.integrate.length) delete law.integrate;
  }
  if (controller?.T !== undefined && limit(data) !== undefined) controller.u_max ??= limit(data);
  return data;
}
// The rows of z that a law integrates.
export function integrated({law, U = undefined}) {
  const {position = [], integrate = []} = law ?? {}, [first = []] = position;
  return law
    ? integrate.map(row => first.map((_, j) => row.reduce((sum, x, k) => sum + x * position[k][j], 0)))
    : U ?? [];
}
// The same mixtures where they are measured, else as many of what is.
export function mixed(rows, position) {
  const seen = position.map(row => row.indexOf(1));
  if (rows.every(row => row.every((x, j) => !x || seen.includes(j))))
    return rows.map(row => seen.map(j => row[j]));
  return eye(seen.length).slice(0, rows.length);
}
const equal = (a, b) => JSON.stringify(a) === JSON.stringify(b);

// A form's texts and the places of its numbers.
export const cut = form => form.split(/(\{\w+\})/).filter(bit => bit).map(bit => {
  const [, slot] = /^\{(\w+)\}$/.exec(bit) ?? [];
  return slot ? {slot} : {text: bit};
});

// ------------------------------------------------------------------ sentences
// Sentences about the plant of a file: with n coordinates, and `rest`, from the rows that are
// integrated to the coordinates where the plant rests when each of these errors is one, or null;
// with `symbols` they say σ, not a time.
export class Sentences {
  /** @param {any} given */
  constructor(given, n, rest = _ => null, symbols = false) {
    const {plant, words = {}} = given, {parameters = {}, coordinates} = Object(plant);
    this.n = n;
    this.rest = rest;
    this.symbols = symbols;
    this.data = canonical(given);
    this.ranges = Object.entries(parameters);
    const named = coordinates ?? eye(n).map((_, i) => `z${i + 1}`), {filter: _, ...own} = words;
    /** @type {any} */
    this.names = {
      ...TABLE.names,
      ...Object.fromEntries(this.ranges.map(([name]) => [name, [name]])),
      ...Object.fromEntries(named.map((name, i) => [`z${i + 1}`, [name]])),
      it: [TABLE.it],
      ...Object.fromEntries(Object.entries(own).map(([name, x]) => [name, [x].flat()]))
    };
  }

  // Its words in order: {text}, and {slot, clause, shown} for each number that they hold.
  get pieces() {
    if (this.all) return this.all;
    const said = this.clauses, others = this.others();
    const more = others.length ? [[{text: TABLE.end.replace("{}", others.join(", "))}]] : [];
    const clauses = [...said.values(), ...more].flatMap((parts, k) => [{text: k ? ", " : " "}, ...parts]);
    this.all = [...this.subject(), ...clauses];
    return this.all;
  }
  // The parts of each clause that is said, by its key.
  get clauses() {
    const said = new Map();
    for (const clause of CLAUSES) {
      const parts = said.has(clause.key) || (this.symbols && clause.plain) ? null : this.parts(clause);
      if (parts) said.set(clause.key, parts);
    }
    return said;
  }
  toString() { return `${this.pieces.map(({text, shown}) => text ?? shown).join("")}.`; }

  // The parts of the file that no clause says.
  others() {
    const found = [];
    for (const [key, value] of Object.entries(this.data).sort(([a], [b]) => a < b ? -1 : 1)) {
      const places = CLAUSES.filter(({at}) => at[0] === key).map(({at}) => at);
      const known = places.flatMap(at => at.slice(1));
      if (KEPT.includes(key)) continue;
      if (!places.length || !this.readable(key, value)) found.push(key);
      else if (known.length) {
        if (key === "law") known.push("position", "integrate");
        if (key === "saturation") known.push("x0");
        if (key === "controller" && value.u_max === limit(this.data)) known.push("u_max");
        found.push(
          ...Object.keys(value).filter(name => !known.includes(name)).sort().map(name => `${key}.${name}`));
      }
    }
    return found;
  }
  readable(key, value) {
    if (key === "law") return this.lawWords(value) !== null;
    if (key === "gamma") return typeof value === "number";
    const needed = {saturation: ["u_max", "x0"], controller: ["T"], hinf: ["gamma"], cost: ["bound"]}[key] ??
      [];
    return Object.keys(Object(value)).length > 0 && needed.every(name => (value[name] ?? null) !== null);
  }
  subject() {
    return [
      {text: this.named(TABLE.subject)}, ...this.ranges.flatMap(([name, ends], k) => {
        const clause = {shift: this.power(name), label: `${this.names[name][0]}, least and most`};
        return cut(this.range(k, name)).map(({text, slot}) => {
          const end = Number(slot === "high");
          return slot ? {slot: `${name}/${end}`, clause, shown: shownOf(clause, ends[end])} : {text};
        });
      })
    ];
  }
  range(k, name) {
    const own = this.names[name][0] === this.names.it[0], form = TABLE.range[k ? 2 : own ? 0 : 1];
    return this.named(form.replace("<p>", `<${name}>`).replace("[p]", `[${name}]`));
  }
  power(name) { return this.names[name][2] ?? 0; }
  named(text) {
    return text.replace(/<(\w+)>|\[(\w+)\]/g, (_, name, unit) => {
      const [word, one = ""] = this.names[name ?? unit];
      return name ? word : one && ` ${one}`;
    });
  }
  /** @returns {any} */
  parts(clause) {
    const {key, at, says} = clause, {data} = this, value = get(data, at) ?? null;
    if (value === null || !this.readable(at[0], data[at[0]])) return null;
    const shown = {
      law: () => this.lawWords(value),
      step: () => {
        const step = this.step();
        return step === null ? null : show(String(step));
      },
      x0: () => data.saturation.x0.map(x => show(String(x))).join("; ")
    };
    const parts = cut(this.named(says))
                    .map(({text, slot}) => slot ? {
                      slot,
                      clause: slot === key ? clause : {},
                      shown: shown[slot] ? shown[slot]() : shownOf(clause, value)
                    }
                                                : {text});
    return parts.some(({slot, shown}) => slot && shown === null) ? null : parts;
  }

  // [words, rows of the measured positions] of all laws that have words.
  laws() {
    const unit = eye(this.n), clause = CLAUSES.find(({key}) => key === "law");
    const one = unit.map((row, i) => {
      const z = `z${i + 1}`, called = this.names[z][0] === z ? `position <${z}>` : `<${z}>`;
      return [this.named(clause.one.replace("<z>", called)), [row]];
    });
    return [...(this.n > 1 ? one : []), [clause.all, unit]];
  }
  lawWords(law) {
    if (Object.keys(law).some(name => !["position", "integrate", "filter", "structure"].includes(name)))
      return null;
    const same = rows =>
      equal(law.position, rows) && equal(law.integrate ?? [], mixed(integrated({law}), rows));
    return this.laws().find(([, rows]) => same(rows))?.[0] ?? null;
  }

  // x(0) at rest, a step of all that is integrated away; null if that isn't known.
  startOf(step, data) {
    const rows = integrated(data), rest = this.rest(rows), {position, filter} = data.law ?? {};
    if (!rest) return null;
    const held = filter ? position.map(row => row.reduce((sum, x, j) => sum + x * rest[j], 0)) : [];
    return [...rest, ...Array(this.n + rows.length).fill(0), ...held].map(x => 0 - step * x);
  }
  step() {
    const {x0} = this.data.saturation, one = this.startOf(1, this.data), k = one?.findIndex(x => x) ?? -1;
    if (k < 0 || x0.length !== one.length) return null;
    const step = x0[k] / one[k];
    return step > 0 && equal(this.startOf(step, this.data), x0.map(x => x + 0)) ? step : null;
  }
}
