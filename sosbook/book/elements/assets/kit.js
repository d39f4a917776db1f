// What the page elements share: numbers and texts, controls, and how an
// element starts. It is defined once for all the elements of a page.
// ------------------------------------------------------- numbers and texts
export const clean = (x, digits = 3) => {
  const value = Number(Number(x).toPrecision(digits)) + 0, size = Math.abs(value);
  if (size === 0 || !isFinite(size) || (size >= 1e-4 && size < 1e6)) return String(value).replace("-", "−");
  const [mantissa, power] = value.toExponential().split("e");
  return `${mantissa}·10${
      [...power.replace("+", "")].map(c => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]).join("")}`
    .replace("-", "−");
};
// Names and units as the book prints them; programs have u_max and 1/s.
export const printed = text => text.replaceAll("1/s", "s⁻¹").replaceAll("u_max", "uₘₐₓ");
export const round = x => Math.round(x * 10) / 10 + 0;
// A decimal number that a reader wrote or that stands in an address; NaN for anything else.
export const number = text =>
  /^[-+−]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(text) ? Number(String(text).replace("−", "-")) : NaN;
export const escape = text => String(text).replace(/[&<>"']/g, c => `&#${c.charCodeAt(0)};`);
export const capital = word => word[0].toUpperCase() + word.slice(1);
export const complex = (re, im) => im === 0 ? clean(re) : `${clean(re)} ± ${clean(im)}j`;
// Numbers re, im, re, im, ... two by two.
export const inPairs = list => list.flatMap((re, k) => k % 2 ? [] : [[re, list[k + 1]]]);
export const withConjugates = pairs => pairs.flatMap(([re, im]) => im ? [[re, im], [re, -im]] : [[re, im]]);

export const degrees = x => x * 180 / Math.PI;
export const clamp = (x, low, high) => Math.max(low, Math.min(high, x));
// The place in a list of the value that is nearest by its logarithm.
export function nearest(list, value) {
  const far = list.map(x => Math.abs(Math.log(x / value)));
  return far.indexOf(Math.min(...far));
}

// Uniform numbers, the same for the same seed (mulberry32), and one of normal numbers by
// two of them (Box and Muller).
export function uniform(seed) {
  return () => {
    seed = (seed + 0x6D2B79F5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
export const gaussian = random => Math.sqrt(-2 * Math.log(1 - random())) * Math.cos(2 * Math.PI * random());

// A list of numbers as the rows of a gain for n coordinates, m inputs, a integrators.
export const gainRows = (list, [n, m, a]) =>
  Array.from({length: m}, (_, i) => list.slice(i * (2 * n + a), (i + 1) * (2 * n + a)));

// The parts of a gain, of n coordinates, d rates and a integrators.
export function gains(K, [n, , a, d = n], digits) {
  const parts = [["P", 0, n], ["D", n, n + d], ["I", n + d, n + d + a]].filter(([, from, to]) => to > from);
  return `<div class="sos-gains">` +
    parts
      .map(
        ([name, from, to]) => `<span class="sos-gain${to - from > 3 ? " sos-wide" : ""}"><span>K<sub>${
                                name}</sub> =</span> <span class="sos-matrix" style="grid-template-columns:` +
          `repeat(${to - from},auto)">` +
          K.flatMap(row => row.slice(from, to)).map(x => `<span>${clean(x, digits)}</span>`).join(" ") +
          `</span></span>`)
      .join(" ") +
    `</div>`;
}

// ---------------------------------------------------------------- controls
export const QUIET = `autocomplete="off" data-lm-suppress-shortcuts="true"`;

export const options = names =>
  names.map((name, k) => `<option value="${k}">${escape(name)}</option>`).join("");
export const panels = inner => `<div class="sos-panels">${inner}</div>`;
export const panel = (name, caption, kind = "") =>
  `<figure class="sos-panel"><div class="sos-${name}"></div>` +
  `<figcaption class="sos-caption${kind}">${caption}</figcaption></figure>`;
export const READOUT = `<div class="sos-readout" role="status" aria-live="polite" aria-atomic="true"></div>`;

// A button that `press` hears of.
export const button = ([key, words]) =>
  `<button type="button" class="sos-button sos-${key}" data-do="${key}" ${QUIET}>${words}</button>`;

// Buttons, what stands beside them, and the place for what they answer.
export const buttons = (list, more = "") =>
  `<div class="sos-buttons">${list.map(button).join("")}${more}</div>` +
  `<div class="sos-more" aria-live="polite"></div>`;

const REACH = 20;  // pixels from a handle's middle: fingers are broad, and some handles swing

// Handles of a picture are dragged: `begin` says what of its data a handle holds, and
// `move` hears of that and of the pointer's place in the picture.
export function drag(field, begin, move) {
  let held = null;
  const near =
    ({clientX, clientY}) => [...field.querySelectorAll(".sos-handle")]
                              .map(handle => {
                                const {left, top, width, height} = handle.getBoundingClientRect();
                                return {
                                  handle,
                                  away: Math.hypot(clientX - left - width / 2, clientY - top - height / 2)
                                };
                              })
                              .filter(({away}) => away < REACH)
                              .sort((a, b) => a.away - b.away)[0]
                              ?.handle;
  field.addEventListener("pointerdown", event => {
    const handle = near(event);
    if (!handle) return;
    event.preventDefault();
    if (event.isTrusted) field.setPointerCapture(event.pointerId);  // a script has no pointer
    held = begin(handle.dataset);
  });
  // a finger on a handle doesn't scroll: touch-action isn't heeded inside of an SVG
  field.addEventListener("touchstart", event => {
    if (near(event.changedTouches[0])) event.preventDefault();
  }, {passive: false});
  field.addEventListener("pointermove", ({clientX, clientY}) => {
    if (held === null) return;
    const frame = field.querySelector("svg").getScreenCTM().inverse();
    move(held, new DOMPoint(clientX, clientY).matrixTransform(frame));
  });
  for (const over of ["pointerup", "pointercancel"]) field.addEventListener(over, () => { held = null; });
}

// Attributes of a node, of which only those are written that differ.
export function attributes(node, wanted) {
  for (const [name, value] of Object.entries(wanted))
    if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
}

// The height of the tallest of some texts in a box: all are written, then laid out once.
export function tallest(box, texts) {
  const style = `position:absolute;visibility:hidden;width:${box.offsetWidth}px`;
  const probes = texts.map(html => {
    const probe = box.cloneNode();
    probe.style.cssText = style;
    probe.innerHTML = html;
    return probe;
  });
  box.after(...probes);
  const heights = probes.map(probe => Math.ceil(probe.getBoundingClientRect().height));
  probes.forEach(probe => probe.remove());
  return Math.max(0, ...heights);
}

// ----------------------------------------------------------------- element
const LONGEST = 5;  // texts of a readout, of each kind, that are measured

// An element holds its data as JSON. It has `markup()`, and `wire()` to listen.
//
// What its controls ask is its `address`: names and values that say all of it. The
// `digest` is its text. Whatever is shown has the digest of what it answers; where that
// isn't what the controls ask, it is marked as old, and its downloads are out of reach.
export class PageElement extends HTMLElement {
  // What a subclass has of its own.
  markup() { return ""; }
  wire() {}
  reset(_to = {}) {}
  get program() { return ""; }

  // The parser may create an element before its data.
  connectedCallback() {
    this.start();
    if (!this.started) document.addEventListener("DOMContentLoaded", () => this.start());
  }

  start() {
    const source = this.querySelector("script[type='application/json']");
    if (this.started || !source) return;
    this.started = true;
    this.data = JSON.parse(source.textContent);
    let count = 1;
    while (document.querySelector(`[id^="${this.localName}-${count}-"]`)) count++;
    this.name = `${this.localName}-${count}`;
    /** @type {any} */
    this.view = document.createElement("div");
    this.view.innerHTML = `<p class="sos-title">${escape(this.data.title)}</p>${this.task}${this.markup()}`;
    this.absent = this.querySelector(":scope > .sos-absent");
    this.absent?.remove();
    this.append(this.view);
    this.view.addEventListener("input", () => this.settle());
    this.view.addEventListener("click", ({target}) => {
      if (target.dataset.do) this.press(target.dataset.do);
    });
    this.wire();
    this.reserve();
    const strange = this.strange(this.linked());
    this.opened = true;
    addEventListener("hashchange", () => {
      if (location.hash.startsWith(`#${this.name}:`)) location.reload();
    });
    if (strange && this.find("more"))
      this.reply(`<p>The address asks for what isn't here: ${escape(strange)}.</p>`);
  }

  // What to try first, and a button that leads there.
  get task() {
    const {hint, answer} = this.data, shown = answer ? button(["answer", "Show me"]) : "";
    return hint ? `<p class="sos-hint"><strong>Try this.</strong> ${escape(printed(hint))} ${shown}</p>` : "";
  }

  get address() { return {}; }
  get digest() { return String(new URLSearchParams(this.address)); }

  // Marks what answers another question than the present one.
  settle() {
    const now = this.digest;
    for (const part of this.view.querySelectorAll("[data-digest]")) {
      const old = part.dataset.digest !== now;
      part.classList.toggle("sos-old", old);
      part.ariaBusy = String(old);
      part.inert = old && part.matches(".sos-more");
    }
  }

  // What the buttons answer: a link, code, a proof.
  reply(html, digest = this.digest) {
    const box = this.find("more");
    box.innerHTML = html;
    box.dataset.digest = digest;
    this.settle();
  }

  press(what) {
    this.reply("");
    if (what === "reset") this.reset();
    else if (what === "answer") this.reset(this.data.answer);
    else if (what === "link") this.link();
    else if (what === "python") this.print(this.program);
  }

  // The page's address leads back to what the controls ask; `linked` reads it, once.
  link() {
    history.replaceState(null, "", `#${this.name}:${this.digest}`);
    this.reply("<p>The address of this page now leads to this setting.</p>");
    this.copy(location.href);
  }

  linked() {
    const [, name, words] = /^#([^:]*):(.*)$/.exec(location.hash) || [];
    if (this.opened || name !== this.name) return {};
    this.scrollIntoView();
    return Object.fromEntries(new URLSearchParams(words));
  }

  // What the page's address asks for and the controls don't.
  strange(linked) {
    const {address} = this;
    const held = (text, value) => text === String(value) || number(text) === Number(value);
    return Object.entries(linked)
      .filter(([key, text]) => !(Object.hasOwn(address, key) && held(text, address[key])))
      .map(([key, text]) => `${key} = ${text}`)
      .join(", ");
  }

  // Code to read, and to paste where that is allowed.
  print(code, below = "") {
    this.reply(`<pre class="sos-code" tabindex="0">${escape(code)}</pre>${below}`);
    this.copy(code);
  }
  copy(text) {
    const shown = this.find("more").firstChild;
    navigator.clipboard?.writeText(text).then(
      () => shown.isConnected && this.find("more").insertAdjacentHTML("beforeend", "<p>Copied.</p>"),
      () => {});
  }

  find(name) { return this.view.querySelector(`.sos-${name}`); }

  // The verdict, once all figures are drawn: they answer the same question.
  tell(status, html, digest = this.digest) {
    const box = this.find("readout");
    box.className = `sos-readout sos-${status}`;
    box.innerHTML = html;
    for (const part of this.view.querySelectorAll(".sos-readout, .sos-panel")) part.dataset.digest = digest;
    this.settle();
  }

  // What the readout may say as well, a list of HTML.
  states() { return []; }

  // This element where its controls may stand as well: it says what it would say, and
  // draws nothing.
  elsewhere(values) {
    const there = Object.create(this);
    for (const key in values) Object.defineProperty(there, key, {value: values[key], writable: true});
    return there;
  }

  // Room for the longest text of the readout: what stands below it doesn't move.
  reserve() {
    const length = html => html.replace(/<[^>]*>/g, "").length;
    const said = [...new Set([...this.states(), this.find("readout").innerHTML])], count = {};
    this.longest = said.sort((p, q) => length(q) - length(p)).filter(html => {
      const kind = String(html.match(/<\w+/g));
      count[kind] = (count[kind] ?? 0) + 1;
      return count[kind] <= LONGEST;
    });
    this.sizes?.disconnect();
    this.sizes = new ResizeObserver(() => this.resized());
    this.sizes.observe(this.find("readout"));
    this.room();
  }

  // After all is laid out, so that nothing is laid out twice.
  resized() {
    const box = this.find("readout"), longer = box.getBoundingClientRect().height > this.tall + 0.01;
    if (longer) this.longest.push(box.innerHTML);
    if (longer || box.offsetWidth !== this.wide) this.room();
  }

  room() {
    const box = this.find("readout");
    this.wide = box.offsetWidth;
    this.tall = tallest(box, this.longest);
    box.style.minHeight = `${this.tall}px`;
  }
}

export function define(tag, kind) {
  if (!customElements.get(tag)) customElements.define(tag, kind);
}
