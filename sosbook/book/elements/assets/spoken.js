// The sentence of a form, whose numbers are its controls: typed, dragged, or stepped by arrows.
import {escape, QUIET} from "./kit.js";
import {shownOf, valueOf as numberOf} from "./sentence.js";
import {typed, valueOf} from "./wishes.js";

const DRAG = 0.006, FAR = 4;  // of a number, for a pixel; pixels that are a drag
const STEPS = {
  ArrowUp: 1,
  ArrowDown: -1,
  PageUp: 10,
  PageDown: -10
};
const SLIDERS = {
  theta_deg: "theta",
  overshoot: "theta",
  hinf: "gamma"
};  // by the names of the file, where others
const LABELS = {
  step: "step of the set point"
};
const AFTER = /^(?:°| (?:%|s⁻¹|s|kHz|ms)(?![\p{L}\d]))/u;
const WORDS = {
  feasible: "feasible",
  infeasible: "no design",
  undecided: "undecided"
};

const tidy = x => Number(x.toPrecision(x.toPrecision(3)[0] === "1" ? 3 : 2));
// A number some steps on, in its second digit.
function stepped(x, steps) {
  const size = 10 ** (Math.floor(Math.log10(Math.abs(x) * (steps < 0 ? 0.9999 : 1))) - 1);
  const next = Number((x + steps * size).toPrecision(12));
  return next > 0 === x > 0 && next ? next : x / 10;
}

const index = (form, slot) => form.data.sliders.findIndex(({key}) => key === (SLIDERS[slot] ?? slot));
// The field of the form where a number stands that has no slider.
const place = slot => slot.includes("/") ? "ranges" : slot === "step" ? "x0" : slot;
const moves = (form, slot) =>
  index(form, slot) >= 0 || slot.includes("/") || ["step", "T", "delay", "filter"].includes(slot);

// ------------------------------------------------------------------ shown
export function speak(form, force = false) {
  const {answer, sentences} = form, {pieces, names} = sentences, line = form.find("say");
  const active = document.activeElement,
        units = Object.values(names).map(([, unit]) => unit).filter(unit => unit);
  const status = answer?.digest === form.digest ? answer.status : "";
  const shape =
    JSON.stringify(pieces.map(({text, slot, shown}) => text ?? (moves(form, slot) ? [slot] : shown)));
  if (shape !== line.dataset.shape) {
    const {slot, text, clause} = held(line, active);
    const html = ({text}, k) => {  // no line ends before a unit, or in it
      const unit = pieces[k - 1]?.slot &&
        (units.find(unit => text.startsWith(` ${unit}`)) ?? AFTER.exec(text)?.[0].trim());
      return escape(unit ? text.replace(` ${unit}`, `\u00a0${unit.replaceAll(" ", "\u00a0")}`) : text);
    };
    line.innerHTML =
      pieces.map((piece, k) => piece.text === undefined ? field(form, piece) : html(piece, k)).join("") +
      `: <em role="status"></em>.`;
    line.dataset.shape = shape;
    const next = slot && line.querySelector(`[data-bound="${slot}"]`);
    if (next) {
      next.focus();
      Object.assign(next, {value: text, clause});
    }
  }
  for (const input of line.querySelectorAll("input")) {
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
  const end = line.querySelector("em"), word = WORDS[status] ?? "…";
  end.className = `sos-${status}`;
  if (end.textContent !== word) end.textContent = word;
  form.setAttribute("aria-label", `${form.data.title}. ${form.sentence}`);
}
const held = (line, active) =>
  line.contains(active) ? {slot: active.dataset.bound, text: active.value, clause: active.clause} : {};
function field(form, {slot, clause, shown}) {
  if (!moves(form, slot)) return `<strong>${escape(shown)}</strong>`;
  return `<input type="text" inputmode="decimal" role="spinbutton" class="sos-num" data-slot="${
    slot}" data-bound="${SLIDERS[slot] ?? slot}" aria-label="${
    escape(LABELS[slot] ?? clause.label)}" value="${escape(shown)}" ${QUIET}>`;
}

// ------------------------------------------------------------------ asked
// What stands in a field is asked from now on; false if it is no such number.
function take(form, input, left) {
  const {dataset: {slot}, value: text} = input, clause = input.clause ?? input.now, k = index(form, slot);
  if (k >= 0) {
    const value = valueOf(text, clause, form.data.sliders[k]);
    if (isFinite(value)) {
      delete form.wrong[slot];
      form.type(k, value);
      return true;
    }
  } else {
    const x = Number.isNaN(typed(text)) ? NaN : numberOf(clause, text);
    if (isFinite(x) && (x > 0 || slot.includes("/"))) {
      delete form.wrong[slot];
      if (left) put(form, slot, x);
      return true;
    }
  }
  if (left) delete form.wrong[slot];
  else form.wrong[slot] = text;
  return false;
}
function put(form, slot, x) {
  const name = place(slot), {value} = form.area(name), words = String(x);
  if (name === "ranges") {
    const [parameter, end] = slot.split("/"), {ranges} = form.sentences;
    const text = ranges
                   .map(([name, ends]) =>
                          `${name} = ${(name === parameter ? ends.with(Number(end), x) : ends).join(" .. ")}`)
                   .join("\n");
    return form.fit(name, text);
  }
  if (name === "x0") {
    form.jump = x;
    return form.rebuild();
  }
  if (value !== words) form.fit(name, words);
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
  let drag = null;
  view.addEventListener("input", ({target}) => {
    if (!num(target)) return;
    target.clause ??= target.now;
    changed(form, target, false);
  });
  view.addEventListener("change", ({target}) => {
    if (num(target)) changed(form, target, true);
  });
  view.addEventListener("focusin", ({target}) => {
    if (num(target)) Object.assign(target, {before: target.value, clause: target.now});
  });
  view.addEventListener("focusout", ({target}) => {
    if (!num(target)) return;
    target.clause = undefined;
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
    if (!drag || pointerType !== "mouse" || target === document.activeElement) return;
    event.preventDefault();  // it would select the text
    target.focus();
    target.select();
  });
  view.addEventListener("pointermove", ({clientX, buttons, pointerId, isTrusted}) => {
    if (!drag || !buttons) return;
    const far = clientX - drag.clientX, input = view.querySelector(`.sos-num[data-bound="${drag.slot}"]`);
    if (!drag.on && Math.abs(far) >= FAR && isTrusted) view.setPointerCapture(pointerId);
    drag.on ||= Math.abs(far) >= FAR;
    if (drag.on && input)
      write(form, input, tidy(drag.from * Math.exp(DRAG * far)), index(form, input.dataset.slot) >= 0);
  });
  for (const kind of ["pointerup", "pointercancel"])
    view.addEventListener(kind, () => {
      const input = drag?.on && view.querySelector(`.sos-num[data-bound="${drag.slot}"]`);
      drag = null;
      if (input) changed(form, input, true);
    });
}
