// The grammar of proof files; sosbook/language/traced.py lists its words.

/** @returns {any} */
export function odd(words) { throw new Error(words); }

const WORDS = ["he", "kron", "inv", "tr", "I", "O", "rows", "cols", "pick", "at"];
const TOKEN = /\s*(\d+(?:\.\d+)?|[A-Za-z]\w*(?:\.\w+)*|>=|==|[-+/'^()[\],;:=>.])/y;

// The lines of a page are few, and read again for each number that moves.
const READ = new Map();
export const parsedLine = line => READ.get(line) ?? READ.set(line, readLine(line)).get(line);

// {name, mark, x}: a definition (mark "="), or a statement of a label (">", ">=" or "==").
function readLine(line) {
  const t = [], text = line.split("#")[0].trimEnd();
  let k = 0;
  for (TOKEN.lastIndex = 0; TOKEN.lastIndex < text.length;) {
    const from = TOKEN.lastIndex, m = TOKEN.exec(text);
    t.push(m ? m[1] : odd(`not understood: ${text.slice(from, from + 20)}`));
  }
  const next = (...wanted) => !wanted.length || wanted.includes(t[k]) ? t[k++] ?? "" : "";
  const must = token => next(token) || odd(`${token} is missing before ${t[k] ?? "the end"}`);
  /** @returns {any[]} */
  const expression = () => {
    let x = next("-") ? ["neg", product()] : product(), sign;
    while ((sign = next("+", "-"))) x = ["add", x, sign === "+" ? product() : ["neg", product()]];
    return x;
  };
  const product = () => {
    let x = factor();
    for (;;) {
      if (next("/")) x = ["div", x, factor()];
      else if (/^[\w([]/.test(t[k] ?? "")) x = ["mul", x, factor()];
      else return x;
    }
  };
  const listed = () => {
    const all = [expression()];
    while (next(",")) all.push(expression());
    return all;
  };
  const factor = () => {
    const token = next();
    let x, mark;
    if (token === "[") x = ["block", blocks()];
    else if (/^\d/.test(token)) x = ["number", token];
    else if (token !== "(" && !/^[A-Za-z]/.test(token))
      odd(`a matrix is missing before ${token || "the end"}`);
    else if (token === "(" || (WORDS.includes(token) && must("("))) {
      x = token === "(" ? expression() : [token, ...listed()];
      must(")");
    } else x = ["name", token];
    while ((mark = next("'", "^"))) x = mark === "'" ? ["T", x] : ["pow", x, ["number", next()]];
    return x;
  };
  const blocks = () => {
    /** @type {any[][]} */
    const rows = [[]];
    for (;;) {
      rows[rows.length - 1].push(next(".") ? ["mirror"] : expression());
      const end = next(",", ";", "]") || odd("a block matrix doesn't end");
      if (end === "]") return rows;
      if (end === ";") rows.push([]);
    }
  };
  if (!t.length) return null;
  const name = next(), x = next(":") || must("=") ? expression() : null, colon = t[1] === ":";
  const mark = colon ? next(">", ">=", "==") || odd(`${name} states nothing: > 0 is missing`) : "=";
  const right = colon ? expression() : null;
  if (k < t.length) odd(`too much: ${t.slice(k).join(" ")}`);
  return {name, mark, x, right};
}
