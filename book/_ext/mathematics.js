/// <reference lib="deno.ns" />
// Sets formulas by MathJax, without a browser. A line of standard input is one,
// {tex, display}; its line of standard output {html} or {fault}. An empty line
// asks for the {css} of all letters.
const [folder, fonts] = Deno.args;
const config = {
  tex: {
    // What isn't TeX is a fault of the book, not red letters in it.
    packages: ["base", "ams", "newcommand"],
    formatError(_, fault) { throw fault; },
  },
  // By themselves formulas grow with the x-height of the reader's font.
  chtml: {matchFontHeight: false, scale: 1.2, adaptiveCSS: false, fontURL: fonts},
  startup: {typeset: false, ready() {}},
};
globalThis["MathJax"] = config;
const parts = ["startup", "core", "liteDOM", "tex", "chtml", "fonts", "assistive-mml"];
for (const part of parts) (0, eval)(Deno.readTextFileSync(`${folder}/${part}.js`));
const mathjax = globalThis["MathJax"];
mathjax.config.startup.adaptor = "liteAdaptor";
mathjax.startup.getComponents();
mathjax.startup.makeMethods();
const {adaptor} = mathjax.startup;

function answer(line) {
  if (!line) return {css: adaptor.textContent(mathjax.chtmlStylesheet())};
  const {tex, display} = JSON.parse(line);
  try {
    return {html: adaptor.outerHTML(mathjax.tex2chtml(tex, {display}))};
  } catch (fault) { return {fault: fault.message}; }
}

let rest = "";
for await (const more of Deno.stdin.readable.pipeThrough(new TextDecoderStream())) {
  const lines = (rest + more).split("\n");
  rest = lines.pop();
  for (const line of lines) console.log(JSON.stringify(answer(line)));
}
