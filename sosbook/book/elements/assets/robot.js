import {announce, button, capital, clean, controls, define, degrees, escape, gains, gaussian, nearest, PageElement, panel, panels, QUIET, READOUT, round, select, slider, steady, uniform} from "./kit.js";
import {runge, slope} from "./pendulum.js";
import {row, upright} from "./plot.js";

const HORIZON = 8, LENGTH = 30, WINDOW = 4;     // s
const PUSH = 0.06, HEIGHT = 0.1, HALF = 0.017;  // N s; m, of the body above the axle
const SCALE = 1250, GROUND = 258, MIDDLE = 170, SLACK = 0.03;
const fixed = (x, digits) => (x.toFixed(digits).replace(/^-(?=[0.]*$)/, "")).replace("-", "−");
const whole = (low, high) =>
  Array.from({length: Math.floor(high) - Math.ceil(low) + 1}, (_, k) => Math.ceil(low) + k);

// The pendulum, its sensors and its firmware; of this one's faults only the fall.
// `advance` goes a fraction of a tick; where one begins, the firmware acts before.
class Robot {
  data;
  mip;
  K;
  ideal;
  pushes;
  estimate;
  count = 0;
  fell = null;
  down = false;
  gyro = 0;
  x3 = 0;

  constructor(data, {mip, K, tilt, delay = 0, noise = 0, ideal = false, pushes = []}) {
    this.h = data.T / data.fine;
    this.random = uniform(data.seed);
    this.phase = this.random();
    this.late = Math.round(delay / this.h);
    this.noise = ideal ? 0 : noise * data.sigma;
    Object.assign(this, {data, mip, K, ideal, pushes, estimate: tilt});
    this.state = [tilt, 0, 0, 0];  // theta, phi and their rates
    this.log = {t: [], theta: [], phi: [], dtheta: [], dphi: [], V: []};
    this.zero = this.phi = this.encoder() + tilt;
  }

  get t() { return this.count * this.h; }
  // The voltage that acts now: late by so many steps.
  get voltage() { return this.log.V[Math.floor((this.count - this.late) / this.data.fine)] || 0; }

  read(value, step, phase) { return this.ideal ? value : step * Math.floor(value / step + phase); }
  encoder() { return this.read(this.state[1] - this.state[0], this.data.count, this.phase); }

  rate() {
    return this.read(this.state[2] + this.noise * gaussian(this.random), this.data.gyro, 0.5);
  }

  // One tick of the firmware, operation by operation.
  control() {
    const {T, limit, tip, unwind} = this.data, K = this.K, gyro = this.rate();
    const wheels = this.encoder();
    const theta = this.estimate + T / 2 * (gyro + this.gyro), phi = wheels + theta;
    if (this.fell === null && !(Math.abs(theta) <= tip)) this.fell = this.t;
    if (this.fell !== null) return 0;
    const y = [theta, phi - this.zero, gyro, (phi - this.phi) * (1 / T)];
    const u = y.reduce((sum, value, i) => sum + K[i] * value, K.length > 4 ? K[4] * this.x3 : 0);
    const V = Math.max(-limit, Math.min(limit, u));
    if (K.length > 4) this.x3 = this.x3 + T * y[1] + T / (unwind * K[4]) * (V - u);
    Object.assign(this, {estimate: theta, gyro, phi});
    return V;
  }

  // A blow on the body's top, from the left: momentum for both coordinates.
  kick() {
    const {a, b, c, J, radius} = this.mip, cos = Math.cos(this.state[0]), both = b * cos - J;
    const body = PUSH * HEIGHT * cos, wheels = PUSH * radius, det = a * c - both ** 2;
    this.state[2] += (a * body - both * wheels) / det;
    this.state[3] += (c * wheels - both * body) / det;
  }

  advance() {
    if (this.pushes.includes(this.count) && !this.down) this.kick();
    if (this.count % this.data.fine === 0) {
      const V = this.control();
      const [theta, phi, dtheta, dphi] = this.state, now = {t: this.t, theta, phi, dtheta, dphi, V};
      for (const name in now) this.log[name].push(now[name]);
    }
    if (!this.down) this.integrate();
    this.count++;
  }

  integrate() {
    const V = this.voltage;
    this.state = runge(x => slope(this.mip, x, V), this.state, this.h);
    const lying = Math.acos(-this.mip.radius / Math.hypot(HEIGHT, HALF)) - Math.atan2(HALF, HEIGHT);
    this.down = Math.abs(this.state[0]) >= lying;
    if (this.down) this.state = [Math.sign(this.state[0]) * lying, this.state[1], 0, 0];
  }

  run(seconds) {
    while (this.t < seconds - this.h / 2) this.advance();
    return {...this.log, fell: this.fell};
  }
}

// What became of a run, by its last second, or by the one before the fall.
function judge({theta, phi, V, fell}, {limit, T}, radius) {
  const end = fell === null ? V.length : Math.round(fell / T);
  const out = theta.findLastIndex(x => Math.abs(degrees(x)) > 1);
  const last = V.slice(Math.max(0, end - Math.round(1 / T)), end), size = Math.max(1, last.length);
  const most = list => list.slice(0, end).reduce((top, x) => Math.max(top, Math.abs(x)), 0);
  const full = last.filter(v => Math.abs(v) >= limit).length / size;
  const turns = last.filter((v, k) => k && v * last[k - 1] < 0).length / (size * T);
  const rms = Math.sqrt(last.reduce((sum, v) => sum + v * v, 0) / size);
  const word = fell !== null       ? "falls"
    : rms > 1 && turns > 10        ? "chatters"
    : rms > 1 || out >= end - size ? "sways"
                                   : "stands";
  return {
    word,
    full,
    turns,
    rms,
    fell,
    settled: (out + 1) * T,
    peak: most(V),
    far: 100 * radius * most(phi)
  };
}

// The picture: side view and strips, in the element's `scene` and `strips`.
class Picture {
  constructor(view, {limit}) {
    this.limit = limit;
    this.find = name => view.querySelector(`.sos-${name}`);
    const spokes = [0, 60, 120].map(a => `<path d="M-25 0H25" transform="rotate(${a})"/>`).join("");
    this.find("scene").innerHTML =
      `<svg role="img" aria-label="The robot from the side" viewBox="0 0 340 300">
      <g class="sos-ground"></g><path class="sos-track" d="M90 30H250"/><path class="sos-bar"/>
      <path class="sos-ends" d="M90 22v16M170 24v12M250 22v16"/>
      <text x="84" y="34" text-anchor="end">−${limit} V</text><text x="256" y="34">${limit} V</text>
      <text class="sos-volts" x="170" y="16" text-anchor="middle"></text>
      <g class="sos-robot"><path class="sos-plumb" d="M0 0V-118"/>
        <g class="sos-body"><rect class="sos-frame" x="-17" y="-100" width="34" height="110" rx="8"/>
          <rect class="sos-board" x="-12" y="-92" width="24" height="32" rx="2"/>
          <path class="sos-chips" d="M-7 -86h8v8h-8zM3 -86h4v8h-4zM-7 -73h14v5h-14z"/>
          <rect class="sos-battery" x="-12" y="-54" width="24" height="24" rx="3"/><path class="sos-led" d="M-5 -42h10M0 -47v10"/>
          <path class="sos-arrow" d="M-58 -92H-26m-9 -8l9 8l-9 8"/></g>
        <g class="sos-wheel"><circle class="sos-tyre" r="29"/><g class="sos-spokes">${
        spokes}</g><circle class="sos-hub" r="6"/></g>
      </g></svg>`;
    this.find("strips").innerHTML =
      `<svg role="img" aria-label="Tilt and voltage" viewBox="0 0 340 300"></svg>`;
  }

  draw(robot, ahead) {
    const [theta, phi] = robot.state, radius = robot.mip.radius, x = radius * phi;
    const V = robot.voltage;
    this.camera = robot.count ? Math.max(x - SLACK, Math.min(x + SLACK, this.camera)) : 0;
    const X = metres => round(MIDDLE + SCALE * (metres - this.camera)), grow = SCALE / 1000;
    const axle = GROUND - SCALE * radius;
    this.find("robot").setAttribute("transform", `translate(${X(x)} ${axle}) scale(${grow})`);
    this.find("body").setAttribute("transform", `rotate(${degrees(theta).toFixed(2)})`);
    this.find("wheel").setAttribute(
      "transform", `scale(${1000 * radius / 32}) rotate(${(degrees(phi) % 360).toFixed(2)})`);
    this.find("bar").setAttribute("d", `M170 30H${round(170 + 80 * V / this.limit)}`);
    this.find("bar").classList.toggle("sos-full", Math.abs(V) >= this.limit);
    this.find("volts").textContent = robot.fell !== null ? "motors off" : `${fixed(V, 1)} V`;
    this.find("led").classList.toggle("sos-off", robot.fell !== null);
    this.find("arrow").classList.toggle(
      "sos-on", robot.pushes.some(k => robot.count > k && (robot.count - k) * robot.h < 0.3));
    this.find("ground").innerHTML = `<path d="M0 ${GROUND}H340"/>` +
      whole(20 * (this.camera - 0.14), 20 * (this.camera + 0.14))
        .map(k => `<path d="M${X(k / 20)} ${GROUND}v${k % 2 ? 5 : 9}"/>` +
            (k % 2 || Math.abs(X(k / 20) - MIDDLE) > 145
                ? ""
                : `<text x="${X(k / 20)}" y="${GROUND + 23}" text-anchor="middle">${
                    clean(5 * k)} cm</text>`))
        .join("");
    this.strips(robot.count ? robot.log : ahead, robot.t, robot.count ? "" : " sos-ahead");
    this.find("live").textContent =
      `t = ${fixed(robot.t, 2)} s, θ = ${fixed(degrees(theta), 1)}°, ` +
      `V = ${fixed(V, 1)} V, x = ${fixed(100 * x, 1)} cm`;
  }

  // The last seconds of tilt and voltage.
  strips({t, theta, V}, now, kind) {
    const [l, r] = [46, 332], from = Math.max(0, now - WINDOW);
    const X = s => round(l + (s - from) / WINDOW * (r - l));
    const near = t.map((_, k) => k).filter(k => t[k] >= from && t[k] <= from + WINDOW);
    const most = Math.max(...near.map(k => Math.abs(degrees(theta[k]))));
    const span = [1, 2, 5, 10, 20, 50, 100].find(s => s >= most);
    /** @type {(...a: any) => any[]} */
    const axes = (top, bottom, high, marks, label) => {
      const Y = value => round((top + bottom) / 2 - value / high * (bottom - top) / 2);
      return [
        Y, marks.map(v => row([l, r], Y(v), clean(v))).join("") + upright([top, bottom], label)
      ];
    };
    const [tilt, grid] = axes(10, 132, 1.1 * span, [-span, 0, span], "θ (degrees)");
    const [volt, rows] = axes(146, 262, 8.5, [-5, 0, 5], "V (volts)");
    const seconds = whole(from, from + WINDOW)
                      .map(s => `<path class="sos-grid" d="M${X(s)} 10V132M${X(s)} 146V262"/>` +
                          `<text x="${X(s)}" y="278" text-anchor="middle">${s}</text>`)
                      .join("");
    const limits = [-1, 1]
                     .map(s => `<path class="sos-target" d="M${l} ${volt(s * this.limit)}H${r}"/>`)
                     .join("");
    const line = `M${near.map(k => `${X(t[k])} ${tilt(degrees(theta[k]))}`).join("L")}`;
    const stairs =
      near.map((k, i) => `${i ? "H" : "M"}${X(t[k])}${i ? "V" : " "}${volt(V[k])}`).join("");
    this.find("strips").firstChild.innerHTML = grid + rows + seconds + limits +
      `<path class="sos-line${kind}" style="stroke:var(--sos-first)" d="${line}"/>` +
      `<path class="sos-line sos-stairs${kind}" style="stroke:var(--sos-second)" d="${stairs}"/>` +
      `<text x="${(l + r) / 2}" y="295" text-anchor="middle">time t (s)</text>`;
  }
}

class Animation extends PageElement {
  disconnectedCallback() { cancelAnimationFrame(this.frame); }

  wire() {
    this.place = {...this.data.start};
    this.picture = new Picture(this.view, this.data);
    for (const input of this.view.querySelectorAll("[data-key]")) {
      input.value = this.place[input.dataset.key];
      input.addEventListener("input", () => this.change(input.dataset.key, Number(input.value)));
      steady(input);
    }
    const on = (name, act) => this.find(name).addEventListener("click", act);
    on("play", () => this.ended ? this.restart(true) : this.play(!this.playing));
    on("reset", () => this.restart());
    on("push", () => this.push());
    this.slow = this.view.querySelector(".sos-slow input");
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.restart();
    new IntersectionObserver(([entry]) => {
      this.seen = entry.isIntersecting;
      this.play(this.playing);  // out of sight it rests
    }).observe(this.view);
  }

  markup() {
    const named = (key, more) => ({id: `${this.name}-${key}`, key, ...more});
    const choice = (key, label, all) =>
      select(named(key, {label, names: all.map(({name}) => name)}));
    const {laws, robots, sliders, T} = this.data;
    return controls("Setting",
             choice("law", "Law", laws) +
               slider(named("R", {label: "Weight R of the design", max: 0})) +
               choice("robot", "Robot", robots) +
               sliders.map(({key, ...more}) => slider(named(key, more))).join("")) +
      `<div class="sos-buttons">${button("play", "Play")}${button("reset", "Reset")}${
        button("push", "Push")}` +
      `<label class="sos-slow"><input type="checkbox" ${QUIET}> Slow motion</label></div>` +
      panels(panel("scene", "", " sos-live") +
        panel("strips",
          `Tilt, and the voltage asked for at every tick of ${
            clean(1000 * T)} ms. Dashed: the limit.`)) +
      READOUT;
  }

  get address() { return {...this.place, pushes: this.live?.pushes}; }
  get law() { return this.data.laws[this.place.law]; }
  change(key, value) {
    const {R} = this.law, wanted = R[this.place.R];
    this.place[key] = value;
    if (key === "law") this.place.R = nearest(this.law.R, wanted);  // that is solved
    this.restart();
  }

  // A robot in a setting: this one, or with changes as `run` takes them.
  /** @param {any} setting */
  robot({law, R, robot, tilt, delay, noise, ideal, pushes = []} = {}) {
    const {laws, robots, T, fine} = this.data, here = this.place;
    const held = laws[law === undefined ? here.law : laws.findIndex(x => x.name === law)];
    const mip = robots[robot === undefined ? here.robot : robots.findIndex(x => x.name === robot)];
    const K = held && held.K[R === undefined ? here.R : held.R.indexOf(R)];
    if (!K || !mip) throw new RangeError("no such law, R or robot");
    return new Robot(this.data, {
      mip,
      K,
      tilt: (tilt ?? here.tilt) * Math.PI / 180,
      delay: (delay ?? here.delay) / 1000,
      noise: noise ?? here.noise,
      ideal,
      pushes: pushes.map(t => Math.round(t * fine / T))
    });
  }

  // Arrays over the ticks, and the verdict. Angles in rad; tilt in degrees, delay in ms, pushes at
  // times in s.
  /** @param {any} asked */
  run({seconds = HORIZON, ...setting} = {}) {
    const robot = this.robot(setting), run = robot.run(seconds);
    return {...run, verdict: judge(run, this.data, robot.mip.radius)};
  }

  restart(playing = this.playing) {
    this.live = this.robot();
    this.report();
    this.play(playing);
  }

  // Runs ahead of the picture, and says what will become of it.
  report() {
    const pushes = this.live.pushes.map(k => k * this.live.h);
    this.ahead = this.run({pushes, seconds: HORIZON + (pushes.at(-1) || 0)});
    for (const input of this.view.querySelectorAll("input[data-key]")) {
      const {key} = input.dataset, text = this.text(key);
      if (key === "R")
        Object.assign(input,
          {max: this.law.R.length - 1, disabled: this.law.R.length < 2, value: this.place.R});
      announce(input, text);
    }
    const words = this.words(), [word] = words;
    this.tell(
      word === "Stands" ? "feasible" : "infeasible", this.said(words, this.law.K[this.place.R]));
    this.view.querySelectorAll("svg").forEach(
      (svg, k) => svg.setAttribute("aria-label",
        `${["Side view", "Tilt and voltage over time"][k]}: it ${word.toLowerCase()}.`));
  }

  text(key) {
    return key === "R"
      ? `R = ${clean(this.law.R[this.place.R])}`
      : `${clean(this.place[key])}${this.data.sliders.find(s => s.key === key).unit}`;
  }

  // Each ending with each law, in long numbers.
  states() {
    const long =
      {full: 0.088, turns: 88.8, rms: 0.088, fell: 8.88, settled: 8.88, peak: 8.8, far: 88.8};
    const place = law => ({...this.place, law, R: 0, tilt: 28, delay: 27.5, noise: 4.5});
    const push = {live: {pushes: []}};
    return this.data.laws.flatMap((_, law) => ["stands", "chatters", "sways", "falls"].map(word => {
      const at = this.elsewhere({place: place(law), ahead: {verdict: {word, ...long}}, ...push});
      return at.said(at.words(), at.law.K[0].map(() => -88.88));
    }));
  }

  /** @param {any} words */
  said([word, account], K) {
    return `<p><span class="sos-status">${word}</span> ${escape(account)}</p>${
      gains([K], [2, 1, K.length - 4], 4)}`;
  }

  words() {
    const {word, full, turns, rms, fell, settled, peak, far} = this.ahead.verdict;
    const blows = this.live.pushes.length;
    const from = `with ${this.law.name}, ${this.text("R")}, from ${this.text("tilt")}, ${
                   this.text("delay")} late, ` +
      `noise ${this.text("noise")}${
        blows ? `, pushed ${blows === 1 ? "once" : `${blows} times`}` : ""}:`;
    const limit = `In the ${fell === null ? "last second" : "second before"}, ${
                    clean(100 * full, 2)} % of the voltages are at the ` +
      `limit, and their sign changes ${clean(turns, 2)} times a second.`;
    const what = {
      stands: `the tilt stays below 1° from ${
        fixed(settled, 2)} s on; at rest the voltage's rms is ${clean(rms, 2)} V.`,
      chatters: `it stays up, but the motors rattle. ${limit}`,
      sways: `it stays up, but doesn't come to rest. ${limit}`,
      falls: `after ${fixed(fell ?? 0, 2)} s the tilt passes ${
        clean(degrees(this.data.tip), 2)}° and the motors go off. ${limit}`
    }[word];
    return [
      capital(word),
      `${from} ${what} Peak voltage ${clean(peak, 2)} V; ` +
        `it rolls up to ${clean(far, 2)} cm away.`
    ];
  }

  push() {
    if (this.live.down) return;
    if (!this.live.pushes.includes(this.live.count)) this.live.pushes.push(this.live.count);
    this.report();
    this.play(this.playing);
  }

  // A run ends with the fall, or long after the last push.
  get ended() {
    const {t, down, fell, pushes, h} = this.live;
    return down ? t > fell + 2 : t >= LENGTH + (pushes.at(-1) || 0) * h;
  }

  play(on) {
    this.playing = on;
    cancelAnimationFrame(this.frame);
    let before = null, clock = this.live.t;
    const step = now => {
      clock += Math.min(0.1, (now - (before ?? now)) / 1000) * (this.slow.checked ? 0.25 : 1);
      before = now;
      while (this.live.t < clock) this.live.advance();
      this.show();
      if (!this.ended) this.frame = requestAnimationFrame(step);
    };
    if (on && this.seen && !this.ended) this.frame = requestAnimationFrame(step);
    this.show();
  }

  show() {
    this.find("play").textContent = this.playing && !this.ended ? "Pause" : "Play";
    this.picture.draw(this.live, this.ahead);
  }
}

define("sos-robot", Animation);
