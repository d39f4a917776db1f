// The robot, simulated and drawn: its pendulum, its sensors and its firmware.
import {clamp, clean, define, degrees, gains, gaussian, nearest, QUIET, round, uniform} from "./kit.js";
import {Mover, stairs} from "./mover.js";
import {runge, slope} from "./pendulum.js";
import {picture} from "./plot.js";

const HORIZON = 8, LENGTH = 30, WINDOW = 4;     // s: of the verdict, a run, the strips
const PUSH = 0.06, HEIGHT = 0.1, HALF = 0.017;  // N s; m, of the body above the axle
const SCALE = 1250, GROUND = 258, MIDDLE = 170, SLACK = 0.03;
const SPANS = [1, 2, 5, 10, 20, 50, 100];  // degrees
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
    this.log = {theta: [], phi: [], dtheta: [], dphi: [], V: []};
    this.zero = this.phi = this.encoder() + tilt;
  }

  get t() { return this.count * this.h; }
  // The voltage that acts at a step: late by some.
  voltage(count) { return this.log.V[Math.floor((count - this.late) / this.data.fine)] || 0; }

  read(value, step, phase) { return this.ideal ? value : step * Math.floor(value / step + phase); }
  encoder() { return this.read(this.state[1] - this.state[0], this.data.count, this.phase); }

  rate() { return this.read(this.state[2] + this.noise * gaussian(this.random), this.data.gyro, 0.5); }

  // One tick of the firmware, operation by operation.
  control() {
    const {T, limit, tip, unwind} = this.data, K = this.K, gyro = this.rate();
    const wheels = this.encoder();
    const theta = this.estimate + T / 2 * (gyro + this.gyro), phi = wheels + theta;
    if (this.fell === null && !(Math.abs(theta) <= tip)) this.fell = this.t;
    if (this.fell !== null) return 0;
    const y = [theta, phi - this.zero, gyro, (phi - this.phi) * (1 / T)];
    const u = y.reduce((sum, value, i) => sum + K[i] * value, K.length > 4 ? K[4] * this.x3 : 0);
    const V = clamp(u, -limit, limit);
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
      const [theta, phi, dtheta, dphi] = this.state, now = {theta, phi, dtheta, dphi, V};
      for (const name in now) this.log[name].push(now[name]);
    }
    if (!this.down) this.integrate();
    this.count++;
  }

  integrate() {
    const V = this.voltage(this.count);
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
  return {word, full, turns, rms, fell, settled: (out + 1) * T, peak: most(V), far: 100 * radius * most(phi)};
}

// What is said of each ending.
const ENDINGS = {
  stands: ({settled, rms}) =>
    `the tilt stays below 1° from ${fixed(settled, 2)} s on; at rest ${clean(rms, 2)} V rms.`,
  chatters: (_, limit) => `it stays up, but the motors rattle: ${limit}`,
  sways: (_, limit) => `it stays up, but doesn't rest: ${limit}`,
  falls: ({fell}, _, tip) =>
    `after ${fixed(fell ?? 0, 2)} s the tilt passes ${clean(degrees(tip), 2)}° and the motors go off.`
};

class Animation extends Mover {
  says =
    "The robot {robot} under the {law} for R = {R} starts at {tilt}; its voltage comes {delay} late, and " +
    "its gyro's noise is {noise}.";
  snaps = ["delay"];
  // A run ends with the fall, or long after the last push.
  get horizon() {
    const robot = this.result?.robot;
    if (!robot) return LENGTH;
    return robot.down ? robot.fell + 2 : LENGTH + (robot.pushes.at(-1) ?? 0) * robot.h;
  }
  get still() { return 0; }
  get pace() { return this.find("slow").firstChild.checked ? 0.25 : 1; }

  get option() { return `<label class="sos-slow"><input type="checkbox" ${QUIET}> Slow motion</label>`; }
  get buttons() {
    const [play, ...others] = super.buttons;
    return [play, ["push", "Push"], ...others];
  }

  markup() {
    const tick = clean(1000 * this.data.T);
    this.figures = {
      scene: "",
      strips: `Tilt, and the voltage asked for at every tick of ${tick} ms. Dashed: the limit.`
    };
    return super.markup();
  }

  wire() {
    const {limit} = this.data;
    const spokes = [0, 60, 120].map(a => `<path d="M-25 0H25" transform="rotate(${a})"/>`).join("");
    this.find("scene").innerHTML = picture(300, "The robot from the side",
      `
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
      </g>`);
    super.wire();
  }

  // Each law has its own weights R; another one begins with the nearest.
  get controls() {
    const {R} = this.data.laws[this.stands?.law ?? 0];
    return this.data.controls.map(one => one.key === "R" ? {...one, names: R.map(x => clean(x))} : one);
  }
  reset(to = {}) {
    const {start} = this.data.controls.find(({key}) => key === "law");
    this.stands = {law: this.data.laws[to.law] ? Number(to.law) : start};
    this.weights = null;
    super.reset(to);
  }

  update() {
    const {R} = this.data.laws[this.stands.law], {weights = R} = this;
    if (weights && weights !== R) this.stands.R = nearest(R, weights[this.stands.R]);
    this.weights = R;
    this.pushes = [];
    super.update();
  }

  press(what) {
    super.press(what);
    if (what === "push") this.push();
  }

  push() {
    const {robot} = this.result, at = Math.round(this.time / robot.h);
    if (robot.down && this.time > robot.fell) return;
    if (!this.pushes.includes(at)) this.pushes.push(at);
    this.result = this.compute(this.place);
    this.show(this.result);
    this.seek(this.time);
  }

  // A robot in a setting, pushed at steps.
  robot({law, R, robot, tilt, delay, noise, ideal = false}, pushes = []) {
    const {laws, robots} = this.data, mip = robots[robot], K = laws[law].K[R];
    const lean = tilt * Math.PI / 180;
    return new Robot(this.data, {mip, K, tilt: lean, delay: delay / 1000, noise, ideal, pushes});
  }

  // Any run as arrays over the ticks, and the verdict. Law, R and robot are named; angles are
  // in rad, but the tilt in degrees; the delay is in ms, pushes are times in s.
  /** @param {any} asked */
  run({seconds = HORIZON, pushes = [], law, R, robot, ...more} = {}) {
    const {laws, robots, T, fine} = this.data, place = {...this.place, ...more};
    if (law !== undefined) place.law = laws.findIndex(({name}) => name === law);
    if (R !== undefined) place.R = laws[place.law].R.indexOf(R);
    if (robot !== undefined) place.robot = robots.findIndex(({name}) => name === robot);
    const it = this.robot(place, pushes.map(t => Math.round(t * fine / T))), run = it.run(seconds);
    return {...run, verdict: judge(run, this.data, it.mip.radius)};
  }

  compute(place) {
    const robot = this.robot(place, this.pushes);
    const run = robot.run(HORIZON + (robot.pushes.at(-1) ?? 0) * robot.h);
    return {robot, verdict: judge(run, this.data, robot.mip.radius)};
  }

  show({robot, verdict}) {
    this.find("scene").firstChild.setAttribute("aria-label", `Side view: it ${verdict.word}.`);
    this.tell(verdict.word === "stands" ? "feasible" : "infeasible",
      ...this.told(verdict, robot.K, robot.pushes.length));
  }

  // ---------------------------------------------------------------- pictures
  pose({robot, verdict: {word}}, time) {
    const {T, limit} = this.data, {log, mip: {radius}} = robot, k = Math.round(time / T);
    while (log.V.length <= k) robot.advance();
    const theta = log.theta[k], phi = log.phi[k], x = radius * phi;
    const off = robot.fell !== null && time >= robot.fell;
    const V = off ? 0 : robot.voltage(k * this.data.fine), ago = step => time - step * robot.h;
    this.camera = k ? clamp(this.camera, x - SLACK, x + SLACK) : 0;
    const X = metres => round(MIDDLE + SCALE * (metres - this.camera)), grow = SCALE / 1000;
    const turn = (name, words) => this.find(name).setAttribute("transform", words);
    turn("robot", `translate(${X(x)} ${GROUND - SCALE * radius}) scale(${grow})`);
    turn("body", `rotate(${degrees(theta).toFixed(2)})`);
    turn("wheel", `scale(${1000 * radius / 32}) rotate(${(degrees(phi) % 360).toFixed(2)})`);
    this.find("bar").setAttribute("d", `M170 30H${round(170 + 80 * V / limit)}`);
    this.find("bar").classList.toggle("sos-full", Math.abs(V) >= limit);
    this.find("volts").textContent = off ? "motors off" : `${fixed(V, 1)} V`;
    this.find("led").classList.toggle("sos-off", off);
    const pushed = robot.pushes.some(step => ago(step) > 0 && ago(step) < 0.3);
    this.find("arrow").classList.toggle("sos-on", pushed);
    const marks = whole(20 * (this.camera - 0.14), 20 * (this.camera + 0.14)).map(m => {
      const at = X(m / 20), named = m % 2 === 0 && Math.abs(at - MIDDLE) <= 145;
      return `<path d="M${at} ${GROUND}v${m % 2 ? 5 : 9}"/>` +
        (named ? `<text x="${at}" y="${GROUND + 23}" text-anchor="middle">${clean(5 * m)} cm</text>` : "");
    });
    this.find("ground").innerHTML = `<path d="M0 ${GROUND}H340"/>${marks.join("")}`;
    this.signals(log, time, word);
    this.find("live").textContent = `t = ${fixed(time, 2)} s, θ = ${fixed(degrees(theta), 1)}°, ` +
      `V = ${fixed(V, 1)} V, x = ${fixed(100 * x, 1)} cm`;
  }

  // The last seconds of tilt and voltage; before the start, what will come.
  signals({theta, V}, now, word) {
    const {T, limit} = this.data, from = Math.max(0, now - WINDOW), kind = now ? "" : " sos-ahead";
    const part = list =>
      list.map((v, k) => [k * T, v]).slice(Math.ceil(from / T), 1 + Math.round((now || WINDOW) / T));
    const tilt = part(theta).map(([t, v]) => [t, degrees(v)]), x = [from, from + WINDOW];
    const most = Math.max(...tilt.map(([, v]) => Math.abs(v)));
    const span = 1.1 * SPANS.find(s => s >= most);
    const axes = [[[-span, span], "θ (degrees)"], [[-8.5, 8.5], "V (volts)"]];
    this.strips("strips", axes, `Tilt and voltage over time: it ${word}.`, (upper, lower) => {
      for (const side of [-limit, limit]) lower.rule("sos-target", x, [side, side]);
      upper.line(tilt, "--sos-first", "", kind);
      lower.line(stairs(part(V), now || WINDOW), "--sos-second", "", ` sos-stairs${kind}`);
    }, x);
  }

  // ---------------------------------------------------------------- verdicts
  // Each ending with each law, in long numbers.
  said() {
    const long = {full: 0.088, turns: 88.8, rms: 0.088, fell: 8.88, settled: 8.88, peak: 8.8, far: 88.8};
    return this.data.laws.flatMap(
      ({K}) => Object.keys(ENDINGS).map(word => this.told({word, ...long}, K[0].map(() => -88.88), 88)));
  }

  told(verdict, K, blows) {
    const {word, peak, far, full, turns} = verdict, {tip} = this.data;
    const pushed = blows ? ` Pushed ${blows === 1 ? "once" : `${blows} times`}.` : "";
    const limit =
      `of the last second ${clean(100 * full, 2)} % at the limit, ${clean(turns, 2)} changes of sign.`;
    return [
      `It ${word}: ${ENDINGS[word](verdict, limit, tip)}`,
      `<p>Peak ${clean(peak, 2)} V; it rolls up to ${clean(far, 2)} cm away.${pushed}</p>${
        gains([K], [2, 1, K.length - 4], 4)}`
    ];
  }
}

define("sos-robot", Animation);
