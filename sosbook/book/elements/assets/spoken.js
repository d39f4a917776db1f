// The sentence of an element, whose numbers are its controls: typed, dragged, or stepped by arrows,
// or moved by the ruler below.
import {attributes, escape, number as decimal, options, QUIET} from "./kit.js";
import {shownOf} from "./sentence.js";

const DRAG = 0.006, FAR = 4;   // of a number, for a pixel; pixels that are a drag
const RULER = 100, WIDE = 30;  // steps of the ruler to either side, and how many times a number it reaches
const PLACES = Array.from({length: 2 * RULER + 1}, (_, k) => k - RULER);
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

// A number that a reader types, perhaps with a decimal comma.
export const typed = text => decimal(text.trim().replace(/^([^.,]*),([^.,]*)$/, "$1.$2"));
const tidy = x => Number(x.toPrecision(x.toPrecision(3)[0] === "1" ? 3 : 2));
// A number some steps on, in its second digit.
function stepped(x, steps) {
  const size = 10 ** (Math.floor(Math.log10(Math.abs(x) * (steps < 0 ? 0.9999 : 1))) - 1);
  const next = Number((x + steps * size).toPrecision(12));
  return next > 0 === x > 0 && next ? next : x / 10;
}
// Where a positive number lies on a ruler: by its logarithm, in steps to either side of where it stood
// first, or of itself beyond the ends. Its longest text, `widest`, is the room that the number has, so
// that no line of the sentence breaks elsewhere as it moves. An element's own ruler has the same seven.
function free(form, slot, now) {
  const known = form.middles[slot], far = Math.abs(Math.log(now / known?.start));
  const start = far < Math.log(WIDE) * 1.0001 ? known.start : now;
  const value = at => tidy(start * WIDE ** (at / RULER));
  if (start !== known?.start) form.middles[slot] = {start, widest: longest(PLACES.map(value))};
  return {
    low: -RULER,
    high: RULER,
    at: x => RULER * Math.log(x / start) / Math.log(WIDE),
    value,
    widest: form.middles[slot].widest,
    stepped,
    pulled: (x, far) => tidy(x * Math.exp(DRAG * far))
  };
}
export const longest = values => Math.max(1, ...values.filter(isFinite).map(x => shownOf({}, x).length));
const scaleOf = (form, slot, now) => form.scaleOf?.(slot) ?? free(form, slot, now);

// A number of the sentence as its element knows it.
export const keyOf = slot => BOUND[slot] ?? slot;

// A line for the sentence, and one for the ruler of the number that was last taken.
export const markup = name =>
  `<p class="sos-say"><em role="status">&nbsp;</em></p><div class="sos-ruler" role="group" ` +
  `aria-label="Ruler"><label for="${name}-ruler"></label><button type="button" class="sos-button" ` +
  `data-step="-1" aria-label="less" ${QUIET}>−</button><span><input id="${name}-ruler" type="range" ` +
  `${
    QUIET}><b class="sos-band" aria-hidden="true"></b></span><button type="button" class="sos-button" data-step="1" ` +
  `aria-label="more" ${QUIET}>+</button></div>`;

// ------------------------------------------------------------------ shown
const unitsOf = names => Object.values(names).map(([, unit]) => unit).filter(unit => unit);
const numbers = form => [...form.find("say").querySelectorAll(".sos-num")];
const field = (form, key) => numbers(form).find(({dataset}) => dataset.bound === key);

export function speak(form, force = false) {
  const {ending: [join, word], pieces, sentences: {names}} = form, line = form.find("say");
  const active = document.activeElement, units = unitsOf(names), end = line.querySelector("em");
  const known = ({text, slot, shown, choices}) => text ??
    (choices                      ? [slot, choices]
        : form.moves(keyOf(slot)) ? [slot]
                                  : [shown]);
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
    line.innerHTML = pieces.map(html).join("") + join;
    line.append(end);
    line.dataset.shape = shape;
    const next = slot && line.querySelector(`[data-bound="${slot}"], [data-choice="${slot}"]`);
    next?.focus();
    if (next?.matches(".sos-num")) Object.assign(next, {value: text, clause});
  }
  for (const input of numbers(form)) {
    const k = pieces.findIndex(({slot}) => slot === input.dataset.slot), {shown, clause} = pieces[k];
    const after = pieces[k + 1]?.text ?? "",
          typing = (input.held || (input === document.activeElement && input.clause)) && !force;
    const unit = units.find(unit => after.startsWith(` ${unit}`));
    if (!typing) {
      if (input.value !== shown) input.value = shown;
      const taken = input === document.activeElement;
      Object.assign(input, {clause: taken ? clause : undefined, held: false});
    }
    input.now = clause;
    const {widest} = scaleOf(form, input.dataset.slot, typed(input.value));
    attributes(input, {
      style: `min-width:${widest}ch;--n:${Math.max(1, input.value.length)}`,
      "aria-valuenow": typed(shown),
      "aria-valuetext": shown + (unit ? ` ${unit}` : AFTER.exec(after)?.[0] ?? "")
    });
  }
  for (const part of line.querySelectorAll("[data-choice]")) {
    const {choices, shown, off = false} = pieces.find(({slot}) => slot === part.dataset.choice);
    part.disabled = off;
    if (choices === true) part.checked = shown === part.closest("label").textContent.trim();
    else part.selectedIndex = choices.indexOf(shown);
  }
  attributes(end, {class: `sos-${form.kind}`});
  if (end.textContent !== word) end.textContent = word;
  attributes(form, {"aria-label": `${form.data.title}. ${form.sentence}`});
  measure(form);
}
const held = (line, active) => line.contains(active)
  ? {slot: active.dataset.bound ?? active.dataset.choice, text: active.value, clause: active.clause}
  : {};
function control(form, {slot, clause, shown, choices}) {
  const {label} = clause, data = `data-choice="${slot}" ${QUIET}`;
  if (choices === true)
    return `<label class="sos-tick"><input type="checkbox" ${data}> ${escape(label)}</label>`;
  if (choices)
    return `<select class="sos-choice" aria-label="${escape(label)}" ${data}>${options(choices)}</select>`;
  if (!form.moves(keyOf(slot))) return `<strong>${escape(shown)}</strong>`;
  return `<input type="text" inputmode="decimal" role="spinbutton" class="sos-num" data-slot="${
    slot}" data-bound="${keyOf(slot)}" aria-label="${escape(LABELS[slot] ?? label)}" value="${
    escape(shown)}" ${QUIET}>`;
}

// The ruler lies at the number that was taken last: around where this stood first, or beyond its ends.
function measure(form) {
  const ruler = form.find("ruler"), [less, input, more] = ruler.querySelectorAll("input, button");
  const number = field(form, form.taken) ?? numbers(form)[0], now = number ? typed(number.value) : NaN;
  form.taken = number?.dataset.bound;
  ruler.hidden = !number;
  const {slot} = number?.dataset ?? {}, scale = number && scaleOf(form, slot, now), at = scale?.at(now);
  [input, less, more].forEach(part => { part.disabled = !isFinite(at ?? NaN); });
  if (less.disabled) return;
  const [name, words] = ["aria-label", "aria-valuetext"].map(name => number.getAttribute(name));
  const label = ruler.querySelector("label");
  if (label.textContent !== name) label.textContent = name;
  attributes(input, {min: scale.low, max: scale.high, "aria-valuetext": words});
  input.value = at;
  for (const one of numbers(form)) one.classList.toggle("sos-taken", one === number);
}

// ------------------------------------------------------------------ asked
// What stands in a field is asked from now on; false if it is no such number. What waits for the hand
// to leave is held: no answer that comes meanwhile puts the number back.
function take(form, input, left) {
  const {dataset: {slot}, value: text} = input, x = form.meaning(slot, text, input.clause ?? input.now);
  if (isFinite(x)) {
    delete form.wrong[slot];
    input.held = form.ask(slot, x, left) === false;
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
  const bounds = input => input.dataset.bound in (form.bounds ?? {});
  let drag = null, begun = null;
  const move = (number, steps) => {
    const now = typed(number.value);
    if (isFinite(now)) write(form, number, scaleOf(form, number.dataset.slot, now).stepped(now, steps), true);
  };
  ruler.addEventListener("input", () => {  // before the view hears of it
    const number = field(form, form.taken), {slot} = number?.dataset ?? {};
    if (number)
      write(
        form, number, scaleOf(form, slot, typed(number.value)).value(Number(ruler.value)), bounds(number));
  });
  // before the element settles, which shows what is asked
  view.addEventListener("input", ({target}) => {
    const {choice} = target.dataset;
    if (choice)
      form.choose(target.type === "checkbox" ? Number(target.checked) : target.selectedIndex, choice);
    if (!num(target)) return;
    target.clause ??= target.now;
    changed(form, target, false);
  }, true);
  view.addEventListener("click", ({target}) => {
    const {step} = target.dataset, number = field(form, form.taken);
    if (step && number) move(number, Number(step));
  });
  // a swipe that scrolls the page gives the number back, to its last digit and in its own words
  const state = number => ({value: number.value, clause: number.clause ?? number.now});
  const leave = (number, before, kind) => {
    if (kind === "pointercancel") Object.assign(number, before);
    changed(form, number, true);
  };
  ruler.addEventListener("pointerdown", () => {
    const number = field(form, form.taken);
    begun = number && state(number);
  });
  for (const kind of ["pointerup", "pointercancel"])
    ruler.addEventListener(kind, () => {
      const number = field(form, form.taken);
      if (number && begun && (number.held || number.value !== begun.value)) leave(number, begun, kind);
      begun = null;
    });
  view.addEventListener("change", ({target}) => {
    const number = target === ruler ? field(form, form.taken) : num(target);
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
    if (!num(target) || (begun && target.held)) return;  // the ruler has it now
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
    if (!(key in STEPS)) return;
    event.preventDefault();
    move(target, STEPS[key]);
  });
  view.addEventListener("pointerdown", event => {
    const {target, clientX, button, pointerType} = event,
                                    from = num(target) && !button ? typed(target.value) : NaN;
    drag = isFinite(from) && isFinite(scaleOf(form, target.dataset.slot, from).at(from))
      ? {slot: target.dataset.bound, clientX, from, on: false, before: state(target)}
      : null;
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
      write(form, input, scaleOf(form, input.dataset.slot, drag.from).pulled(drag.from, far), bounds(input));
  });
  for (const kind of ["pointerup", "pointercancel"])
    view.addEventListener(kind, () => {
      const input = drag?.on && field(form, drag.slot);
      if (input) leave(input, drag.before, kind);
      drag = null;
    });
}
