// A wish for a law that sees some of what a plant does: its gains are searched in a worker, then proven.
import {claims, proven, relaxed, sought, weighed} from "./gains.js";
import {rest} from "./judge.js";
import {escape} from "./kit.js";
import {summed} from "./law.js";
import {joined} from "./outputs.js";
import {design} from "./program.js";
import {own} from "./solver.js";
import {Wish} from "./wish.js";
import {beyond} from "./wishes.js";

export class Searched extends Wish {
  // Why there is no design, without the solver: {status, reason, help}.
  get known() {
    const {law, request: {vertices}} = this.data, reason = beyond(this.data, this.live);
    return (law && summed(law, vertices, this.asked.sigma)) ??
      (reason ? {status: "undecided", reason} : null);
  }

  async solve() {
    const {known, digest, asked} = this;
    if (known) this.accept({...known, asked, digest, ms: 0});
    else if (this.data.law) await this.seek();
    else await super.solve();
  }

  // ------------------------------------------------------------- a law
  get live() { return Boolean(this.closest(".sos-live")); }
  request(bounds = this.bounds) {
    const {law} = this.data;
    return {...super.request(bounds), ...(law && {law})};
  }
  // Whether another question is asked by now.
  get staleness() {
    const {digest, data: {request}} = this;
    return () => digest !== this.digest || request !== this.data.request;
  }

  // Gains of the package where it has a line, else by a search here, one descent after another.
  async discovered(how) {
    const {name} = this, request = this.request();
    const found = this.live ? await this.solver.ask(name, "move", request) : {};
    if (!found || how.stale()) return null;
    if (!found.by) return sought(name, request, how);
    const {own: K, gains} = found, judged = K && await own.search(name, "judged", {...request, K});
    return how.stale() ? null : {...found, ...judged, gains: gains ?? null};
  }

  // Where no gains are found, whether any controller keeps what is asked.
  async seek() {
    clearTimeout(this.idle);
    this.offers = null;
    this.settle();
    const {digest, asked, staleness: stale, data: {request, cost, x0}} = this;
    const told = start => {
      if (start % 4 === 3) this.find("readout").innerHTML = `<p>Searching gains: start ${start + 1} …</p>`;
    };
    const answer = await this.discovered({stale, told});
    if (!answer) return;
    const alone = request.vertices.length === 1 && asked.gamma === undefined && !cost && !x0;
    if (answer.status === "undecided" && alone) {
      const whole = await this.solver.ask(this.name, "move", {...this.request(), law: null});
      if (!whole || stale()) return;
      if (whole.status === "infeasible")
        Object.assign(answer, whole, {near: null, reason: "No controller keeps this, whatever it measures."});
    }
    this.accept({...answer, asked, digest});
  }

  async settled() {
    const {answer, staleness: stale} = this;
    if (!this.data.law || answer.by) return super.settled();
    if (answer.proof || answer.digest !== this.digest) return;
    const cells =
      await proven(this.name, this.request(), answer.own, () => stale() || answer !== this.answer);
    if (!cells) return;
    answer.clauses = weighed(answer.clauses, cells);
    answer.proof = {proven: answer.clauses.some(({exact}) => exact), digits: 6, cells};
    this.say();
  }

  async look() {
    const {answer, data: {law}, staleness: stale} = this;
    if (this.known) return;
    if (!law) return super.look();
    if (!answer.near || answer.digest !== this.digest) return;
    const how = {...answer, stale: () => stale() || answer !== this.answer};
    const offers = await relaxed(this.name, {...this.bounds}, bounds => this.request(bounds), how);
    if (!offers) return;
    this.offers = offers;
    this.say();
  }
  advice() {
    const {answer, offers} = this;
    if (this.data.law && !answer.near) return escape(answer.help ?? "Ask for less.");
    return this.data.law && offers?.length === 0
      ? "The search found no single bound that would do: relax several."
      : super.advice();
  }

  async prove() {
    const {answer, digest, data: {law}} = this;
    if (!law || answer?.by || (answer?.status === "infeasible" && !answer.help)) return super.prove();
    if (answer?.status !== "feasible" || answer.digest !== digest)
      return this.reply(`<p>Not proven here. ${escape(answer?.reason ?? "")}${
        answer?.help ? " These are floats: press As JSON, and the package proves it exactly." : ""}</p>`);
    const proof = await this.proofOf();
    if (this.find("more").dataset.digest !== digest || !proof) return;
    const list = proof.claims.map(x => `<li>${escape(x)}</li>`).join("");
    this.reply(`<p>${escape(this.sentence)}</p>${
                 list &&
                 `<p><span class="sos-status">Proven</span> in exact arithmetic, ` +
                   `for every constant plant that is asked and these gains:</p><ul>${list}</ul>`}<p>${
                 escape(answer.clauses.map(({why}) => why).filter(why => why).join(" "))}</p>` +
        `<p>As Python, the package proves the same of these gains, and writes the file for others: ` +
        `<code>python -m sosbook verify proof.json</code> checks it.</p>`,
      digest);
  }

  // {proven, claims} of what stands there, and the text of a file where this page writes one.
  async proofOf() {
    if (!this.data.law || this.answer.by)
      return (await this.solver.ask(this.name, "prove", this.request()))?.proof;
    await this.settled();
    const {asked, proof} = this.answer;
    return proof && {...proof, claims: claims(asked, proof.cells)};
  }

  get design() {
    const {answer: {gains, K}, data: {law}} = this, found = super.design;
    if (!gains || !K) return found;
    const {position = [], integrate = []} = law, rows = joined(gains);
    const d = rows[0].length - position.length - integrate.length;
    return {...found, own: {K: rows, shape: [position.length, K.length, integrate.length, d]}};
  }
  get program() {
    const {answer} = this, found = answer?.digest === this.digest ? answer.gains : null;
    return design({...this.data, found}, this.named, rest);
  }
}
