// The sentence of an element, whose numbers are its controls: typed, dragged, or stepped by arrows,
// or moved by the ruler below.
import {escape, QUIET, steady} from "./kit.js";
import {shownOf, valueOf as numberOf} from "./sentence.js";
import {typed, valueOf} from "./wishes.js";

const DRAG = 0.006, FAR = 4;   // of a number, for a pixel; pixels that are a drag
const RULER = 100, WIDE = 30;  // steps of the ruler to either side, and how many times a number it reaches
const STEPS = {
  ArrowUp: 1,
  ArrowDown: -1,
  PageUp: 10,
  PageDown: -10
};
// The bounds that a file has by other names.
const BOUND = {
  theta_deg: "theta",
  overshoot: "theta",
  hinf: "gamma"
};
const LABELS = {
  step: "step of the set point"
};
const AFTER = /^(?:°| (?:%|s⁻¹|s|kHz|ms)(?![\p{L}\d]))/u;

const tidy = x => Number(x.toPrecision(x.toPrecision(3)[0] === "1" ? 3 : 2));
// A number some steps on, in its second digit.
function stepped(x, steps) {
  const size = 10 ** (Math.floor(Math.log10(Math.abs(x) * (steps < 0 ? 0.9999 : 1))) - 1);
  const next = Number((x + steps * size).toPrecision(12));
  return next > 0 === x > 0 && next ? next : x / 10;
}
// A number of the sentence as its element knows it.
export const keyOf = slot => BOUND[slot] ?? slot;

// A line for the sentence, and one for the ruler of the number that was last taken.
export const markup = name => `<p class="sos-say">&nbsp;</p><div class="sos-ruler" role="group" ` +
  `aria-label="Ruler"><label for="${name}-ruler"></label><button type="button" class="sos-button" ` +
  `data-step="-1" aria-label="less" ${QUIET}>−</button><input id="${name}-ruler" type="range" min="${
    - RULER}" max="${RULER}" ${QUIET}><button type="button" class="sos-button" data-step="1" ` +
  `aria-label="more" ${QUIET}>+</button></div>`;

// ------------------------------------------------------------------ shown
const unitsOf = names => Object.values(names).map(([, unit]) => unit).filter(unit => unit);
const numbers = form => [...form.find("say").querySelectorAll("input")];
const field = (form, key) => numbers(form).find(({dataset}) => dataset.bound === key);

export function speak(form, force = false) {
  const {sentences, word, pieces} = form, {names} = sentences, line = form.find("say");
  const active = document.activeElement, units = unitsOf(names);
  const known = ({text, slot, shown, choices}) =>
    text ?? (choices || !form.moves(keyOf(slot)) ? [shown, choices] : [slot]);
  const shape = JSON.stringify(pieces.map(known));
  if (shape !== line.dataset.shape) {
    const {slot, text, clause} = held(line, active);
    const unitOf = k => {  // of the number before a text, as the text begins
      const text = pieces[k - 1]?.slot && pieces[k]?.text;
      const unit = text && units.find(unit => text.startsWith(` ${unit}`));
      return unit ? ` ${unit}` : text ? AFTER.exec(text)?.[0] : undefined;
    };
    const html = (piece, k) => {  // no line ends before a unit, or in it
      if (piece.text === undefined)
        return (unitOf(k + 1) ? `<span class="sos-with">` : "") + control(form, piece);
      const unit = unitOf(k) ?? "";
      return (unit && `${escape(unit.replaceAll(" ", "\u00a0"))}</span>`) +
        escape(piece.text.slice(unit.length));
    };
    line.innerHTML = `${pieces.map(html).join("")}: <em role="status"></em>`;
    line.dataset.shape = shape;
    const next = slot && field(form, slot);
    if (next) {
      next.focus();
      Object.assign(next, {value: text, clause});
    }
  }
  for (const input of numbers(form)) {
    const k = pieces.findIndex(({slot}) => slot === input.dataset.slot), {shown, clause} = pieces[k];
    const after = pieces[k + 1]?.text ?? "",
          typing = input === document.activeElement && input.clause && !force;
    const unit = units.find(unit => after.startsWith(` ${unit}`));
    if (!typing)
      Object.assign(input, {value: shown, clause: input === document.activeElement ? clause : undefined});
    input.now = clause;
    input.style.setProperty("--n", String(Math.max(1, input.value.length)));
    input.setAttribute("aria-valuenow", String(typed(shown)));
    input.setAttribute("aria-valuetext", shown + (unit ? ` ${unit}` : AFTER.exec(after)?.[0] ?? ""));
  }
  const end = line.querySelector("em");
  end.className = `sos-${form.kind}`;
  if (end.textContent !== `${word}.`) end.textContent = `${word}.`;
  form.setAttribute("aria-label", `${form.data.title}. ${form.sentence}`);
  measure(form);
}
const held = (line, active) =>
  line.contains(active) ? {slot: active.dataset.bound, text: active.value, clause: active.clause} : {};
function control(form, {slot, clause, shown, choices}) {
  if (choices)
    return `<select class="sos-choice" aria-label="${escape(clause.label)}" ${QUIET}>${
      choices.map(x => `<option value="${escape(x)}"${x === shown ? " selected" : ""}>${escape(x)}</option>`)
        .join("")}</select>`;
  if (!form.moves(keyOf(slot))) return `<strong>${escape(shown)}</strong>`;
  return `<input type="text" inputmode="decimal" role="spinbutton" class="sos-num" data-slot="${
    slot}" data-bound="${keyOf(slot)}" aria-label="${escape(LABELS[slot] ?? clause.label)}" value="${
    escape(shown)}" ${QUIET}>`;
}

// The ruler lies at the number that was taken last: around where this stood first, or beyond its ends.
function measure(form) {
  const ruler = form.find("ruler"), [less, input, more] = ruler.querySelectorAll("input, button");
  const number = field(form, form.taken) ?? numbers(form)[0], now = number ? typed(number.value) : NaN;
  form.taken = number?.dataset.bound;
  ruler.hidden = !number;
  [input, less, more].forEach(part => { part.disabled = !(now > 0); });
  if (!(now > 0)) return;
  const {slot} = number.dataset, far = Math.abs(Math.log(now / form.middles[slot]));
  const start = form.middles[slot] = far < Math.log(WIDE) * 1.0001 ? form.middles[slot] : now;
  ruler.querySelector("label").textContent = number.getAttribute("aria-label");
  input.value = String(RULER * Math.log(now / start) / Math.log(WIDE));
  input.setAttribute("aria-valuetext", number.getAttribute("aria-valuetext"));
  for (const one of numbers(form)) one.classList.toggle("sos-taken", one === number);
}

// ------------------------------------------------------------------ asked
// What stands in a field is asked from now on; false if it is no such number.
function take(form, input, left) {
  const {dataset: {slot, bound}, value: text} = input, clause = input.clause ?? input.now;
  const own = bound in form.bounds;
  const x = own ? valueOf(text, clause, bound) : Number.isNaN(typed(text)) ? NaN : numberOf(clause, text);
  if (isFinite(x) && (own || x > 0 || slot.includes("/"))) {
    delete form.wrong[slot];
    if (own) form.type(bound, x);
    else if (left) form.fit(slot, x);
    return true;
  }
  if (left) delete form.wrong[slot];
  else form.wrong[slot] = text;
  return false;
}
function changed(form, input, left) {
  const good = take(form, input, left);
  input.setAttribute("aria-invalid", String(!good && !left));
  if (left) speak(form, true);
  form.settle();
}

// What a script or a key makes of a field's number.
function write(form, input, x, left) {
  input.clause ??= input.now;
  input.value = shownOf({}, x);
  changed(form, input, left);
}

export function listen(form) {
  const {view} = form, num = target => target.matches?.(".sos-num") ? target : null;
  const ruler = form.find("ruler").querySelector("input");
  let drag = null;
  ruler.addEventListener("input", () => {  // before the view hears of it
    const number = field(form, form.taken), {slot = "", bound = ""} = number?.dataset ?? {};
    if (form.middles[slot])
      write(
        form, number, tidy(form.middles[slot] * WIDE ** (Number(ruler.value) / RULER)), bound in form.bounds);
  });
  view.addEventListener("input", ({target}) => {
    if (!num(target)) return;
    target.clause ??= target.now;
    changed(form, target, false);
  });
  view.addEventListener("click", ({target}) => {
    const {step} = target.dataset, number = field(form, form.taken);
    if (step && number) write(form, number, stepped(typed(number.value), Number(step)), true);
  });
  steady(ruler);
  view.addEventListener("change", ({target}) => {
    const number = target === ruler ? field(form, form.taken) : num(target);
    if (target.matches(".sos-choice")) form.choose(target.value);
    if (number) changed(form, number, true);
  });
  view.addEventListener("focusin", ({target}) => {
    if (!num(target)) return;
    form.taken = target.dataset.bound;
    form.remember();
    measure(form);
    Object.assign(target, {before: target.value, clause: target.now});
  });
  view.addEventListener("focusout", ({target}) => {
    if (!num(target)) return;
    target.clause = undefined;
    target.inputMode = "decimal";
    speak(form, true);
  });
  view.addEventListener("keydown", event => {
    const {target, key} = event;
    if (!num(target)) return;
    if (key === "Escape") {
      target.value = target.before;
      changed(form, target, true);
    }
    const now = typed(target.value);
    if (!(key in STEPS) || Number.isNaN(now)) return;
    event.preventDefault();
    write(form, target, stepped(now, STEPS[key]), true);
  });
  view.addEventListener("pointerdown", event => {
    const {target, clientX, button, pointerType} = event,
                                    from = num(target) && !button ? typed(target.value) : NaN;
    drag = from > 0 ? {slot: target.dataset.bound, clientX, from, on: false} : null;
    // a finger's first touch opens the ruler, its second one the keyboard
    if (drag && pointerType === "touch")
      target.inputMode = target === document.activeElement ? "decimal" : "none";
    if (!drag || pointerType !== "mouse" || target === document.activeElement) return;
    event.preventDefault();  // it would select the text
    target.focus();
    target.select();
  });
  view.addEventListener("pointermove", ({clientX, buttons, pointerId, isTrusted}) => {
    if (!drag || !buttons) return;
    const far = clientX - drag.clientX, input = field(form, drag.slot);
    if (!drag.on && Math.abs(far) >= FAR && isTrusted) view.setPointerCapture(pointerId);
    drag.on ||= Math.abs(far) >= FAR;
    if (drag.on && input)
      write(form, input, tidy(drag.from * Math.exp(DRAG * far)), input.dataset.bound in form.bounds);
  });
  for (const kind of ["pointerup", "pointercancel"])
    view.addEventListener(kind, () => {
      const input = drag?.on && field(form, drag.slot);
      drag = null;
      if (input) changed(form, input, true);
    });
}
