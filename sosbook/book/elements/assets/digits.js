import {clean, define, escape} from "./kit.js";
import {Mover, number} from "./mover.js";
const NAMES = ["θ", "φ", "θ′", "φ′", "∫φ"];

// A double as C99 and Python write it: 0x1.8p+3.
function hex(x) {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, x);
  const bits = view.getBigUint64(0), exponent = Number(bits >> 52n & 0x7ffn),
        tail = (bits & (1n << 52n) - 1n).toString(16).padStart(13, "0").replace(/0+$/, "");
  if (x === 0) return "0x0.0p+0";
  const power = exponent ? exponent - 1023 : -1022;
  return `${x < 0 ? "-" : ""}0x${exponent ? 1 : 0}.${tail || "0"}p${power < 0 ? "-" : "+"}${Math.abs(power)}`;
}

class Digits extends Mover {
  says = "The gain of {entry}, in {precision} precision, meets a tilt of {tilt} and a rate of {rate}.";
  figures = {
    table: "One tick: gain times state, entry by entry, as the program has it.",
    bits: "The bits of the chosen gain: sign, exponent, fraction. Pale bits are dropped in single precision."
  };

  compute({precision, tilt, rate, entry}) {
    const round = precision ? Math.fround : x => x, {K} = this.data;
    const state = [tilt * Math.PI / 180, 0.5, rate, -0.3, 0.1], gains = K.map(round);
    const sum = (gain, keep) => gain.reduce((total, k, i) => keep(total + keep(k * keep(state[i]))), 0);
    const exact = sum(K, x => x), single = sum(K.map(Math.fround), Math.fround);
    const most = Math.max(...K.map(k => Math.abs(Math.fround(k) / k - 1)));
    return {gains, hex: gains.map(hex), literal: hex(gains[entry]), state, exact, single, most};
  }

  show({gains, hex: all, state, exact, single, most}, _, {precision, entry}) {
    this.tell("feasible",
      precision ? "Single precision: 24 bits of each are kept." : "Double precision: the proven gain itself.",
      `<p>V = ${number(exact, " V", 9)} in double, ${
        number(single, " V",
          9)} in single precision: a difference of ${number(Math.abs(single - exact), " V", 2)}. ` +
        `Single gains are off by ${number(most, "", 2)} of their size at most.</p>`);
    this.find("table").innerHTML =
      gains
        .map((k, i) => `<div class="sos-box"><strong>${NAMES[i]}</strong><span>${clean(k, 6)}</span>` +
            `<span>× ${clean(state[i])}</span><br><code>${escape(all[i])}${
              precision ? "f" : ""}</code></div>`)
        .join("");
    const view = new DataView(new ArrayBuffer(8));
    view.setFloat64(0, this.data.K[entry]);
    const bits = view.getBigUint64(0).toString(2).padStart(64, "0");
    this.find("bits").innerHTML = `<svg role="img" viewBox="0 0 340 110" aria-label="Bits of the gain of ${
                                    NAMES[entry]} in ${precision ? "single" : "double"} precision">` +
      [...bits]
        .map((bit, k) => {
          const [row, column] = [Math.floor(k / 32), k % 32];
          const colour = k === 0 ? "--sos-bad" : k < 12 ? "--sos-second" : "--sos-first";
          return `<rect x="${8 + 10 * column}" y="${15 + 45 * row}" width="8" height="24" style="fill:var(${
            bit === "1" ? colour
                        : "--sos-tint"});stroke:var(${colour});opacity:${precision && k > 34 ? 0.25 : 1}"/>`;
        })
        .join("") +
      "</svg>";
  }
}

define("sos-digits", Digits);
