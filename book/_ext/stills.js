/// <reference lib="deno.ns" />
// What wishes of the pages show at first, without a browser: a list of their data on standard input, a
// list of HTML on standard output.
import "data:text/javascript,Object.assign(globalThis,{HTMLElement:class{},customElements:{get:()=>true}})";

import {dataOf, FIELDS, requestOf} from "../../sosbook/book/elements/assets/form.js";
import {escape} from "../../sosbook/book/elements/assets/kit.js";
import {Wish} from "../../sosbook/book/elements/assets/wish.js";
import {design} from "../../sosbook/book/kernel/design.js";
import {prove} from "../../sosbook/book/kernel/proof.js";
import {truth} from "../../sosbook/book/kernel/truth.js";

// A wish without a page, with its answer.
function answered(data) {
  const wish = Object.assign(Object.create(Wish.prototype), {data, name: "still", own: {}, wrong: {}});
  wish.bounds = wish.starts();
  /** @type {any} */
  const found = design(wish.request());
  const request = wish.request(), {digest, asked} = wish;
  wish.answer = {...found, ...truth(request, found), digest, asked, proof: prove(request, found)};
  wish.judge();
  return wish;
}

// The plant that a reader's form begins with.
function first({title, examples: [{texts, words}]}) {
  const all = Object.fromEntries(FIELDS.map(([name]) => [name, ""])),
        found = requestOf({...all, ...texts}, {});
  return {...dataOf(found, {}), title, words};
}

const page = JSON.parse(await new Response(Deno.stdin.readable).text());
console.log(JSON.stringify(page.map(data => {
  const wish = answered(data.examples ? first(data) : data), {design} = wish;
  const figure = (picture, words) => `<figure class="sos-panel">${picture}<figcaption class="sos-caption">${
    escape(words)}</figcaption></figure>`;
  return `<p class="sos-title">${escape(wish.data.title)}</p><p class="sos-say">${
           escape(wish.sentence.slice(0, -1))}: <em class="sos-${wish.kind}">${wish.word}.</em></p>` +
    `<div class="sos-panels">${figure(wish.map(design), wish.captions[0])}${
      figure(wish.step(design), wish.captions[1])}</div>`;
})));
