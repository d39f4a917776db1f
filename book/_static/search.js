// The search page: ranks the sections of search-index.js and shows excerpts.
"use strict";
(() => {
  const {pages, rows, synonyms, subjects} = window["SOS_SEARCH"];
  const MOST = 40, PER_PAGE = 3, WIDE = 220;
  const fold = (text) => text.normalize("NFKD")
                           .replace(/[\u0300-\u036f]/g, "")
                           .toLowerCase()
                           .replace(/(?<=\p{L}{3})iz(?=e|ing|ation)/gu, "is");
  const kinds = ["", "statement", "in the package", "glossary", "of the thesis"];
  const address = (page) => `${pages[page][0].replace(/[_\/.]/g, " ")} ${subjects[page]}`;
  const entries = rows.map(([page, id, title, kind, text, code]) => ({
    page,
    id,
    title,
    kind,
    text,
    code,
    folded: [
      fold(kind === 2 ? title.split(".").pop()
          : id        ? title
                      : `${title} ${address(page)}`),
      fold(`${pages[page][1]} ${address(page)}`), fold(text), fold(code)
    ],
  }));
  // A long section has more of every word: what counts is how dense a word is.
  const mean = entries.reduce((sum, {text}) => sum + text.length, 0) / entries.length;
  for (const entry of entries) entry.long = 0.4 + (0.6 * entry.text.length) / mean;
  // Pages that record, and the manual, come behind those that teach.
  const BEHIND =
    /intro|notation|appendix|api\/|glossary|where_this|reproduction|errata|performance|references|bibliography/;
  const fair = pages.map(([address]) => BEHIND.test(address) ? 0.5 : 1);

  const wanted = (query) => [...new Set(
    fold(query).replace(/\b(?:sosbook|sos)\.(?=\w)/g, "").match(/[\p{L}\p{N}_]+/gu) || [])];
  // A term matches the start of a word; a plural or an ending doesn't hide one.
  const stem = (term) => term.length > 5 ? term.replace(/(?:ies|es|s|ing|ed|e|(?<=.{5})ation)$/, "") : term;
  const pattern = (term) => {
    const bare = stem(term), plain = bare.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
    const start = `(?<![\\p{L}\\p{N}])${plain}`, ends = "(?:y|ies|e?s|ing|e?d|e|(?:at)?ion)?";
    return Object.assign(
      new RegExp(start, "gu"), {bare, whole: new RegExp(`${start}${ends}(?![\\p{L}\\p{N}])`, "gu")});
  };
  // A driver is a tenth of a drive. Most texts lack the letters, which is soon seen.
  const count = (text, test) => {
    if (!text.includes(test.bare)) return 0;
    const all = (text.match(test) || []).length;
    return all && 0.1 * all + 0.9 * (text.match(test.whole) || []).length;
  };
  // A title says what a section is about; code is found last.
  const WEIGHTS = [5, 1.5, 1, 0.1], CODE = 3;

  let vocabulary;
  // The word of the book that is nearest to one that isn't in it, or the word itself.
  const mended = (term) => {
    const test = pattern(term);
    if (entries.some(({folded}) => folded.some((text) => count(text, test)))) return term;
    vocabulary ||=
      [...new Set(entries.flatMap(({folded}) => folded.slice(0, 3).join(" ").match(/\p{L}{4,}/gu) || []))];
    const near = vocabulary.filter((word) => Math.abs(word.length - term.length) < 3)
                   .map((word) => [distance(term, word), word])
                   .sort(([a], [b]) => a - b)[0];
    return near && near[0] <= (term.length > 5 ? 2 : 1) ? near[1] : term;
  };
  // How many letters are to be changed, left out, put in or swapped.
  const distance = (a, b) => {
    let before = [], above = Array.from({length: b.length + 1}, (_, k) => k);
    for (let i = 1; i <= a.length; i += 1) {
      const row = [i];
      for (let k = 1; k <= b.length; k += 1) {
        const other = Number(a[i - 1] !== b[k - 1]);
        row[k] = Math.min(above[k] + 1, row[k - 1] + 1, above[k - 1] + other);
        if (i > 1 && k > 1 && a[i - 1] === b[k - 2] && a[i - 2] === b[k - 1])
          row[k] = Math.min(row[k], before[k - 2] + 1);
      }
      [before, above] = [above, row];
    }
    return above[b.length];
  };

  // A number of the thesis: "T 2.18", "Theorem 2.4", "eq. (2.18)", "(A.3)".
  const THESIS =
    /^(?:t|eq|equation|theorem|lemma|corollary|table|fig|figure|section|chapter|procedure)?[ .]*\(?([a-d]?\.?\d[\d.]*)\)?$/;
  const ofThesis = (asked) => {
    const number = asked.replace(/^t +/, "").match(THESIS)?.[1];
    const kind = asked.match(/theorem|lemma|corollary|table|fig|section|chapter|procedure/)?.[0] || "";
    if (!number) return [];
    const test = new RegExp(`(?<![\\w.])${number.replace(/\./g, "\\.")}(?![\\w])`);
    return entries.filter(({kind: k, folded: [title]}) => k === 4 && test.test(title))
      .sort((a, b) => b.title.toLowerCase().includes(kind) - a.title.toLowerCase().includes(kind));
  };

  // How well each entry answers some words, all of which should be there.
  const scored = (asked) => {
    const terms = wanted(asked), tests = terms.map(pattern);
    const hits = entries.map((entry) => tests.map((test) => entry.folded.map((text) => count(text, test))));
    const rarity = tests.map((_, k) => {
      const having = hits.filter((hit) => hit[k].some((n, field) => n && field !== CODE)).length;
      return Math.log(1 + entries.length / (1 + having));
    });
    const phrase = new RegExp(tests.map((test) => test.source).join("[\\p{L}\\p{N}]*[^\\p{L}\\p{N}]+"), "u");
    const holds = (text) =>
      tests.length > 1 && tests.every(({bare}) => text.includes(bare)) && phrase.test(text);
    // The first line of a page stands for all of it.
    const whole = pages.map(() => tests.map(() => 0)), size = pages.map(() => 0), phrased = new Set();
    entries.forEach(({page, kind, text}, i) => {
      if (kind) return;
      size[page] += text.length;
      if (holds(entries[i].folded[2])) phrased.add(page);
      hits[i].forEach(([title, , said], k) => { whole[page][k] += 3 * title + said; });
    });
    const usual = size.reduce((sum, n) => sum + n, 0) / size.length;
    return entries.map((entry, i) => {
      const [title, , text] = entry.folded;
      let sum = 0, said = 0, coded = 0;
      hits[i].forEach((counts, k) => {
        const prose = counts.some((n, field) => n && field !== CODE);
        said += Number(prose);
        coded += Number(!prose && counts[CODE] > 0);
        counts.forEach((n, field) => { sum += rarity[k] * WEIGHTS[field] * (n / (n + entry.long)); });
        const all = entry.id ? 0 : whole[entry.page][k], long = 4 * (0.4 + (0.6 * size[entry.page]) / usual);
        sum += rarity[k] * 3 * (all / (all + long));
        said += Number(!prose && all > 0);
      });
      if (!said && !coded) return 0;
      const found = (said + 0.3 * coded) / tests.length;
      if (found < 1) sum *= 0.1 * found * found;
      if (holds(title)) sum *= 4;
      else if (holds(text) || (!entry.id && phrased.has(entry.page))) sum *= tests.length;
      if (!entry.id && fair[entry.page] === 1 && hits[i].every(([, n]) => n >= 1)) sum *= 3;
      sum *= fair[entry.page];
      if (entry.kind === 2) {
        const named = fold(entry.title).endsWith("." + asked.replace(/ /g, "."));
        sum *= named && asked.includes("_") ? 20 : named && entry.title.split(".").length === 2 ? 2 : 0.3;
      } else if (entry.kind === 4) sum *= 0.3;
      else if (title.replace(/-/g, " ") === asked) sum *= entry.kind === 3 ? 4 : 2 * fair[entry.page];
      return sum;
    });
  };

  const rank = (query) => {
    const terms = wanted(query), typed = terms.join(" ");
    if (!typed) return [];
    const meanings = (text) => synonyms.flatMap(
      ([said, meant]) => ` ${text} `.includes(` ${said} `) ? [text.replace(said, meant)] : []);
    const asked = meanings(typed).length ? typed : terms.map(mended).join(" ");
    const ways = [asked, ...meanings(asked)];
    const scores = ways.map((way, k) => scored(way).map((score) => (k ? 1.2 : 1) * score));
    const tests = ways.flatMap(wanted).map(pattern);
    const first = new Set(ofThesis(fold(query).trim()));
    const ranked = entries.map((entry, k) => ({entry, score: Math.max(...scores.map((one) => one[k]))}))
                     .filter((one) => one.score > 0 && !first.has(one.entry))
                     .sort((a, b) => b.score - a.score)
                     .map(({entry}) => entry);
    const shown = new Map();
    return [...first, ...ranked]
      .filter((entry) => {
        const n = (shown.get(entry.page) || 0) + 1;
        shown.set(entry.page, n);
        return n <= PER_PAGE;
      })
      .slice(0, MOST)
      .map((entry) => ({entry, tests}));
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
