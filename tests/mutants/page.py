"""Change the page's exact reader by rule, and say which changes no file notices.

    python3 tasks.py mutants page             all changes, some ten minutes
    python3 tasks.py mutants page --write     keep what survives in page_survivors.txt

The modules `DECIDE` write a proof's text, read it, decide its matrices and say what is
proven. They are changed token by token as `changes.py` changes Python: comparisons,
signs, "&&" and "||", "every" and "some", integers, refusals left out. Deno asks each
change what tests ask: proof files, true and spoiled, which pairs of vertices need a
block, designs with their files. Exit code: 0; 1 where a change survives that isn't
listed. A line of the list ends with a word, as in `survivors.txt`.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from queue import Empty, Queue
from threading import Thread

from sosbook.book.elements import scripts
from tests.mutants.lists import keep, listed

LIST = Path(__file__).with_name("page_survivors.txt")
DECIDE = ("arithmetic", "descriptor", "exact", "grammar", "judged", "proof", "reader",
          "refusal", "request", "text", "written")  # fmt: skip
FLOATS = {  # of a search: what they find is decided again
    *("meanDescriptor", "stateSpace", "changed", "frameOf", "leastCost", "ofEnergy"),
    *("withInverses", "typicalRate", "energy", "reach", "joined", "NUMBERS"),
    *("assembled", "namesOf", "statedAt", "blocksOf", "writtenBlocks", "pointOf"),
    *("halves", "independent", "prove", "ownSizes", "unprovenOf"),
}
SECONDS = 20.0  # of one change, on a busy machine; for huge integers
OTHER = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "===": "!==", "!==": "===",
    "&&": "||", "||": "&&", "+=": "-=", "-=": "+=", "true": "false", "false": "true",
    "every": "some", "some": "every", "throw": "void", "odd": "(() => null)",
}  # fmt: skip
BINARY = {"+": "-", "-": "+", "*": "+"}
TOKEN = re.compile(
    r"""(?P<skip>\s+|//[^\n]*|/\*.*?\*/)|(?P<text>"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')
    |(?P<number>\d[\d.]*(?:e[-+]?\d+)?n?)|(?P<word>[A-Za-z_$][\w$]*)|(?P<tick>`)
    |(?P<sign>[=!]==|\.\.\.|>>>|\*\*|=>|[-+*/%<>&|^]=|\|\|=|\?\?=|&&|\|\||\?\?|\?\.|\+\+
    |--|>>|<<|[-+*/%<>=!&|^~?:;,.(){}\[\]])""",
    re.VERBOSE | re.DOTALL,
)
REGEX = re.compile(r"/(?:\\.|\[(?:\\.|[^\]\\])*\]|[^/\\\[\n])+/\w*")
TEMPLATE = re.compile(r"(?:\\.|[^`\\$]|\$(?!\{))*")
BEFORE_A_VALUE = {"return", "of", "in", "case", "typeof", "void", "throw", "yield",
                  "new", "function", "else", "const", "let", "import"}  # fmt: skip
OWNER = re.compile(
    r"^(?:  (?:\* ?)?(?!if|for|while)(\w+)\(.*\{"
    r"|(?:function\*?|const|let|class) (\w+))",
    re.M,
)
TURN = " sosTurn(),"
COUNTER = """const counter = {turns: 0, end: 0, late: false};
const sosTurn = () => {
  if (counter.turns++ % 1024 || performance.now() < counter.end) return;
  counter.late = true;
  throw new Error("it has no end");
};"""
JUDGE = """
import {Session} from "node:inspector";
const session = new Session(), out = new TextEncoder(), MOST = 2;
let seen = [];
session.connect();
const post = (what, more = {}) => new Promise((done, fail) =>
  session.post(what, more, (e, r) => e ? fail(e) : done(r)));
const say = x => Deno.stdout.writeSync(out.encode(JSON.stringify(x) + "\\n"));
const ASK = {
  file: (k, x) => { const {status, words, about, claims} = k.judgedFile(x);
    return [status, status === "refused" || words, about, claims]; },
  call: (k, [name, ...given]) => k[name](...given),
  text: (k, x) => [k.unsymmetric(...x), k.unproven(...x)],
  pairs: (k, x) => k.coupledPairs(x),
  design: (k, x) => { const r = k.design(x);
    return [r.status, r.status === "feasible" ? k.prove(x, r)
      : r.refusal && k.refusalFile(x, r.refusal)]; }};
const answer = (kernel, [kind, given]) => {
  let said = "an error";
  Object.assign(kernel.counter, {turns: 1, end: performance.now() + 5000});
  try { said = JSON.stringify(ASK[kind](kernel, given), (_, x) =>
      typeof x === "bigint" ? String(x) : x) ?? "";
  } catch (fault) { /* is an answer */ }
  return kernel.counter.late ? "no end" : said; };
const made = body => new Function(`${body}\\n//# sourceURL=made.js`)();
let source, inputs, places, last = {};
async function begin(given) {
  ({source, places} = given);
  inputs = JSON.parse(JSON.stringify(given.inputs), (_, x) =>
    typeof x === "string" && /^-?\\d+n$/.test(x) ? BigInt(x.slice(0, -1)) : x);
  const honest = inputs.map(x => answer(made(source), x)), alike = {};
  const head = "function anonymous(\\n) {\\n".length;
  const after = x => {  // how many places are before it
    let [low, high] = [0, places.length];
    while (low < high) {
      const middle = low + high >> 1;
      if (places[middle] + head < x) low = middle + 1;
      else high = middle;
    }
    return low;
  };
  await post("Profiler.enable");
  await post("Profiler.startPreciseCoverage", {callCount: true, detailed: true});
  const watched = new Function(`${source}\\n//# sourceURL=watched.js`)();
  const entered = async enters => {
    if (!places.length) return enters;
    const {result} = await post("Profiler.takePreciseCoverage");
    for (const {functions} of result.filter(x => x.url.includes("watched.js")))
      for (const {ranges} of functions)
        for (const r of ranges)
          enters.fill(r.count ? 1 : 0, after(r.startOffset), after(r.endOffset));
    return enters;
  };
  const always = await entered(new Uint8Array(places.length));  // as it is made
  for (const [k, x] of inputs.entries()) {
    const start = performance.now();
    answer(watched, x);
    const ms = performance.now() - start, enters = await entered(always.slice());
    const like = x[0] === "file" ? `${enters}${honest[k].slice(0, 20)}` : k;
    (alike[like] ??= []).push({k, ms, enters, said: honest[k]});
  }
  await post("Profiler.stopPreciseCoverage");
  await post("Profiler.disable");
  const sorted = list => list.sort((a, b) => a.ms - b.ms);
  seen = sorted(Object.values(alike).flatMap(list => sorted(list).slice(0, MOST)));
  say([seen.length, honest]);
}
function notices({from, to, by, owner}) {
  let kernel;
  try { kernel = made(source.slice(0, from) + by + source.slice(to));
  } catch (fault) { return -1; }
  const place = places.indexOf(from), name = owner.split(" ")[1];
  const calls = ([kind, given]) => kind === "call" && given[0] === name;  // not counted
  const near = seen.filter(x => x.enters[place] || calls(inputs[x.k]));  // at times
  const first = (last[owner] ??= []).filter(x => near.includes(x));
  for (const x of [...first, ...near])
    if (answer(kernel, inputs[x.k]) !== x.said) {
      last[owner] = [x, ...last[owner].filter(y => y !== x)].slice(0, 20);
      return -1;
    }
  return near.length;
}
let rest = "";
for await (const part of Deno.stdin.readable.pipeThrough(new TextDecoderStream())) {
  const lines = (rest + part).split("\\n");
  rest = lines.pop();
  for (const line of lines) {
    const asked = JSON.parse(line);
    if (asked.source) await begin(asked);
    else say(notices(asked));
  }
}
"""


def body():
    """The kernel as pages have it, and where each module begins and ends in it."""
    text, names, places, data = "", [], {}, ""
    for path in sorted(scripts.KERNEL.iterdir(), key=lambda p: p.name):
        if path.name.endswith(".js"):
            source = path.read_text("utf-8")
            for name, _, file in scripts.DATA.findall(source):
                given = (scripts.KERNEL / Path(file).name).read_text("utf-8")
                data += f"const {name} = {given};"
            source = scripts.DATA.sub("", scripts.IMPORT.sub("", source))
            names += scripts.EXPORT.findall(source)
            begin = len(text)
            text += counted(scripts.EXPORT.sub("", source) + "\n")
            places[path.name.removesuffix(".js")] = begin, len(text)
    head = f'"use strict";\n{data}\n{COUNTER}\n'
    names += ["counter"]
    places = {x: (a + len(head), b + len(head)) for x, (a, b) in places.items()}
    return head + text + f"return {{{', '.join(names)}}};", places


def tokens(text, at=0, end=None):
    """(place, kind, token) of each token, in templates, too; returns where they end."""
    before = depth = 0
    while at < len(text):
        if text[at] == "/" and not before and (m := REGEX.match(text, at)):
            if not re.match(r"//|/\*", text[at:]):
                yield at, "text", m[0]
                before, at = 1, m.end()
                continue
        m = TOKEN.match(text, at)
        kind, token, at = m.lastgroup, m[0], m.end()
        if kind == "skip":
            continue
        if kind == "tick":
            at = TEMPLATE.match(text, at).end()
            while text[at] == "$":
                at = yield from tokens(text, at + 2, "}")
                at = TEMPLATE.match(text, at).end()
            at, token, kind = at + 1, "`", "text"
        depth += (token == "{") - (token == "}")
        if token == end and depth < 0:
            return at
        yield m.start(), kind, token
        before = kind in ("text", "number") or token in (")", "]", "}")
        before = before or (kind == "word" and token not in BEFORE_A_VALUE)
    return at


def counted(text):
    """A text whose loops count their turns, so that none is without an end."""
    every, found = [*tokens(text)], []
    for k, (_, _, token) in enumerate(every):
        if token in ("for", "while") and every[k + 1][2] == "(":
            depth, ends = 0, []
            for at, _, sign in every[k + 1 :]:
                depth += (sign == "(") - (sign == ")")
                ends += [at + 1] * (sign == ";" and depth == 1)
                if not depth:
                    break
            if token == "while":
                found.append((every[k + 1][0] + 1, TURN))
            elif ends:
                none = not text[ends[0] : ends[1] - 1].strip()
                found.append((ends[0], TURN + " true" * none))
    for at, more in reversed(found):
        text = text[:at] + more + text[at:]
    return text


def plain(text):
    """The same without what counts."""
    return text.replace(TURN + " true", "").replace(TURN, "")


def changes(text):
    """(from, to, other token) of each change of a text in JavaScript."""
    every = [(0, "sign", ";"), *tokens(text)]
    for (_, was, last), (at, kind, token) in zip(every, every[1:]):
        value = was in ("number", "text") or last in (")", "]")
        value = value or (was == "word" and last not in BEFORE_A_VALUE)
        other = None
        if kind == "number" and re.fullmatch(r"\d+n?", token):
            other = f"{int(token.strip('n')) + 1}{'n' * token.endswith('n')}"
        elif token in BINARY and value:
            other = BINARY[token]
        elif kind == "sign" and token in ("-", "!"):
            other = " "
        elif kind != "text" and token in OTHER and last != "function":
            other = OTHER[token]
        if other and (token not in ("every", "some") or last == "."):
            yield at, at + len(token), other


def mutants():
    """{words: (owner, from, to, other)} of each change of what decides."""
    text, places = body()
    found = {}
    for name in DECIDE:
        begin, end = places[name]
        source = text[begin:end]
        owners = [(m.start(), m[1] or m[2]) for m in OWNER.finditer(source)]
        for a, b, other in changes(source):
            owner = next((x for at, x in reversed(owners) if at <= a), "module")
            if owner in FLOATS:
                continue
            line = source[source.rfind("\n", 0, a) + 1 : source.find("\n", a)]
            line = plain(line).strip()
            words = f"{name} {owner}: {source[a:b]} -> {other} in {line[:100]}"
            several = sum(x.partition(", the ")[0] == words for x in found)
            words += f", the {several + 1}th" * bool(several)
            found[words] = f"{name} {owner}", begin + a, begin + b, other
    return text, found


class Judge:
    """Deno, which asks changes of a ``text`` what ``inputs`` ask."""

    def __init__(self, text, every, inputs):
        places = sorted({begin for _, begin, *_ in every.values()})
        whole = {"source": text, "places": places, "inputs": inputs}
        self.given = json.dumps(whole)
        self.kept, self.answers = self._begun()

    def _begun(self):
        with tempfile.NamedTemporaryFile(
            "w", suffix=".mjs", delete=False, encoding="utf-8"
        ) as file:
            file.write(JUDGE)
        deno = Path(sys.executable).with_name("deno")
        self.process = subprocess.Popen(
            [deno, "run", "--no-lock", "-A", file.name],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8",
        )  # fmt: skip
        self.said = Queue()
        Thread(target=self._listen, args=(self.process,), daemon=True).start()
        return self._ask(self.given, 600.0)

    def _listen(self, process):
        for line in process.stdout:
            self.said.put(json.loads(line))
        self.said.put(None)

    def _ask(self, line, seconds):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return self.said.get(timeout=seconds)

    def survives(self, owner, begin, end, other):
        """How many inputs enter it and none notices it; -1 where one does."""
        asked = {"from": begin, "to": end, "by": other, "owner": owner}
        try:
            found = self._ask(json.dumps(asked), SECONDS)
        except Empty:
            found = None
        if found is None:  # it has no end, or takes all memory
            self.close()
            self._begun()
        return -1 if found is None else found

    def close(self):
        """End the process."""
        self.process.kill()
        self.process.wait()


def main(words=None):
    """What survives, and whether that is what is listed."""
    form = dict(formatter_class=argparse.RawDescriptionHelpFormatter)
    parser = argparse.ArgumentParser("tasks.py mutants page", None, __doc__, **form)
    parser.add_argument("--write", action="store_true", help="keep what survives")
    asked = parser.parse_args(words)
    from tests.mutants.page_inputs import inputs

    text, every = mutants()
    judge = Judge(text, every, [*inputs()])
    print(
        f"{judge.kept} of {len(judge.answers)} inputs, {len(every)} changes", flush=True
    )
    known, survive = listed(LIST), {}
    for line, change in every.items():
        if (entering := judge.survives(*change)) >= 0:
            survive[line] = known.get(line, "")
            if line not in known:
                print(f"SURVIVES, {entering} inputs enter it: {line}", flush=True)
    judge.close()
    for line in known.keys() - survive.keys():
        print("NOTICED NOW, or no change any more:", line)
    print(f"{len(survive):6d} of {len(every)} changes survive")
    if asked.write:
        keep(LIST, survive)
    return int(not asked.write and bool(survive.keys() - known.keys()))


if __name__ == "__main__":
    sys.exit(main())
