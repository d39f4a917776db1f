// The search page: ranks the sections of search-index.js and shows excerpts.
"use strict";
(() => {
  const {pages, rows} = window["SOS_SEARCH"];
  const MOST = 40, PER_PAGE = 4, WIDE = 220;
  const fold = (text) => text.normalize("NFKD").replace(/[\u0300-\u036f]/g, "").toLowerCase();
  const kinds = ["", "statement", "in the package", "glossary"];
  const entries = rows.map(([page, id, title, kind, text, code]) => ({
    page,
    id,
    title,
    kind,
    text,
    code,
    folded: [
      fold(kind === 2 ? title.split(".").pop() : title),
      fold(`${pages[page][1]} ${pages[page][0].replace(/[_/.]/g, " ")}`), fold(text), fold(code)
    ],
  }));

  const wanted = (query) => [...new Set(
    fold(query).replace(/\b(?:sosbook|sos)\.(?=\w)/g, "").match(/[\p{L}\p{N}_]+/gu) || [])];
  // A term matches the start of a word; a plural or an ending doesn't hide one.
  const stem = (term) => term.length > 5 ? term.replace(/(?:ies|es|s|ing|ed)$/, "") : term;
  const pattern = (term) => {
    const plain = stem(term).replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
    return new RegExp(`(?<![\\p{L}\\p{N}])${plain}`, "gu");
  };
  const count = (text, test) => (text.match(test) || []).length;
  const WEIGHTS = [9, 3, 1, 0.3];

  const rank = (query) => {
    const terms = wanted(query);
    if (!terms.length) return [];
    const tests = terms.map(pattern);
    const hits = entries.map((entry) => tests.map((test) => entry.folded.map((text) => count(text, test))));
    // What the whole page says counts for its first line.
    const whole = pages.map(() => tests.map(() => 0));
    hits.forEach(
      (hit, i) => hit.forEach(
        ([title, , text, code], k) => { whole[entries[i].page][k] += 2 * title + text + 0.3 * code; }));
    const rarity = tests.map((_, k) => {
      const having = hits.filter((hit) => hit[k].some(Boolean)).length;
      return Math.log(1 + entries.length / (1 + having));
    });
    const score = (entry, hit) => {
      let sum = 0, found = 0;
      hit.forEach((counts, k) => {
        const part = counts.reduce((total, n, field) => total + WEIGHTS[field] * (n / (n + 1.2)), 0);
        if (part) found += 1;
        sum += rarity[k] * part;
      });
      if (!found) return 0;
      if (!entry.id) whole[entry.page].forEach((n, k) => { sum += rarity[k] * 22 * (n / (n + 12)); });
      const [title, page] = entry.folded, asked = fold(query).trim();
      const name = asked.replace(/^(sosbook|sos)\./, "").replace(/\(\)$/, "");
      if (entry.kind === 2) sum *= fold(entry.title).endsWith("." + name) ? 4 : 0.4;
      if (title === asked) sum *= 2;
      if (!entry.id && (title.includes(asked) || page.includes(asked))) sum *= 4;
      return sum * (found / tests.length) ** 3;
    };
    const ranked = entries.map((entry, k) => ({entry, score: score(entry, hits[k])}))
                     .filter((one) => one.score > 0)
                     .sort((a, b) => b.score - a.score);
    const shown = new Map();
    return ranked
      .filter(({entry}) => {
        const n = (shown.get(entry.page) || 0) + 1;
        shown.set(entry.page, n);
        return n <= PER_PAGE;
      })
      .slice(0, MOST)
      .map(({entry}) => ({entry, tests}));
  };

  // The stretch of the text with most of the terms, those marked.
  const excerpt = (entry, tests) => {
    const text =
      count(entry.folded[2], tests[0]) || !entry.code || tests.some((test) => count(entry.folded[2], test))
      ? entry.text
      : tests.some((test) => count(entry.folded[3], test)) ? entry.code
                                                           : entry.text;
    const low = text.toLowerCase();
    const places = tests.flatMap((test) => [...low.matchAll(test)].map((m) => m.index));
    let start = 0, most = -1;
    for (const place of places) {
      const from = Math.max(0, place - 60);
      const inside = tests.filter((test) => count(low.slice(from, from + WIDE), test)).length;
      if (inside > most) [most, start] = [inside, from];
    }
    if (start) start = text.indexOf(" ", start) + 1;
    const piece = text.slice(start, start + WIDE);
    const line = document.createElement("p");
    const any = new RegExp(tests.map((test) => `${test.source}[\\p{L}\\p{N}]*`).join("|"), "giu");
    let end = 0;
    line.append(start ? "… " : "");
    for (const match of piece.matchAll(any)) {
      const mark = document.createElement("mark");
      mark.textContent = match[0];
      line.append(piece.slice(end, match.index), mark);
      end = match.index + match[0].length;
    }
    line.append(piece.slice(end), start + WIDE < text.length ? " …" : "");
    return line;
  };

  const box = document.getElementById("search-results");
  box.setAttribute("aria-live", "polite");
  const show = (query) => {
    const found = rank(query);
    const list = document.createElement("ol");
    for (const {entry, tests} of found) {
      const [address, page] = pages[entry.page];
      const item = document.createElement("li");
      const link = document.createElement("a");
      link.href = address + (entry.id ? "#" + entry.id : "");
      link.textContent = entry.title;
      const where = document.createElement("span");
      where.className = "sos-where";
      where.textContent = [entry.id ? page : "", kinds[entry.kind]].filter(Boolean).join(" · ");
      item.append(link, " ", where, excerpt(entry, tests));
      list.append(item);
    }
    const head = document.createElement("p");
    head.textContent = !query.trim() ? ""
      : found.length ? `${found.length}${found.length === MOST ? " best" : ""} places for “${query}”`
                     : `Nothing for “${query}”. Try fewer or shorter words.`;
    box.replaceChildren(head, list);
  };

  /** @type {NodeListOf<HTMLInputElement>} */
  const fields = document.querySelectorAll("form.bd-search input[type=search]");
  /** @type {HTMLInputElement} */
  const field = document.querySelector(".bd-search-container input") || fields[0];
  const query = new URLSearchParams(location.search).get("q") || "";
  fields.forEach((one) => { one.value = query; });
  field.addEventListener("input", () => {
    show(field.value);
    try {
      history.replaceState(null, "", "?q=" + encodeURIComponent(field.value));
    } catch { /* from the disk some browsers forbid it */
    }
  });
  show(query);
})();
