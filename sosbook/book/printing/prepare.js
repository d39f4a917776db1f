// Make a page of the site ready for print; the argument says what to add.
async ({css, part, head, first, anchors, elsewhere, textbook}) => {
  const style = document.createElement("style");
  const quote = (text) => JSON.stringify(text);
  style.textContent = css + `
    @page { @top-left { content: ${quote(head)}; font: 9pt "DejaVu Sans", sans-serif; } }
    html { counter-reset: page ${first - 1}; }`;
  document.head.append(style);
  document.documentElement.dataset.theme = "light";
  for (const one of document.querySelectorAll(".toggle-hidden")) one.classList.remove("toggle-hidden");
  for (const one of document.querySelectorAll("details"))
    if (!one.matches(".hide")) one.open = true;
  /** @type {any} */
  const article = document.querySelector("article.bd-article");
  if (textbook)
    for (const one of article.querySelectorAll(".sos-thesis, .sos-thesis-all, .admonition.thesis"))
      (one.matches(".sos-thesis") ? one.closest("section") : one).remove();
  if (part) {
    const line = document.createElement("p");
    line.className = "sos-part";
    line.textContent = part;
    article.prepend(line);
  }
  // Each wish says what it ends with, as if it were in sight.
  const wishes = [...article.querySelectorAll("sos-wish, sos-bench")];
  for (const one of wishes) one.see();
  while (!wishes.every(one => one.ended)) await new Promise(done => setTimeout(done, 50));
  for (const one of article.querySelectorAll("*")) {
    if (!one.localName.startsWith("sos-")) continue;
    const note = document.createElement("p");
    note.className = "sos-elsewhere";
    note.append("A still of what moves on the page");
    if (elsewhere) {
      const link = document.createElement("a");
      link.href = link.textContent = elsewhere;
      note.append(": ", link);
    }
    note.append(".");
    one.after(note);
  }
  // Links inside of the page give its places names; the book needs some more.
  const list = document.createElement("nav");
  list.className = "sos-anchors";
  for (const id of anchors)
    if (document.getElementById(id)) {
      const link = document.createElement("a");
      link.href = "#" + id;
      link.textContent = ".";
      list.append(link);
    }
  article.append(list);
  await document.fonts.ready;
  // What is wider than the paper shrinks.
  const fit = (box, inner) => {
    const room = box.clientWidth, needed = inner.scrollWidth;
    if (room && needed > room + 1) inner.style.zoom = (0.99 * room) / needed;
  };
  for (const box of article.querySelectorAll("div.math")) {
    const formula = box.querySelector("mjx-container");
    if (!formula) continue;
    const math = formula.querySelector("mjx-math");
    const needed = math ? math.getBoundingClientRect().width : 0;
    const number = box.querySelector(".eqno");
    const room = box.clientWidth - (number ? number.offsetWidth + 8 : 0);
    if (needed > room) formula.style.fontSize = `${Math.floor(99 * room / needed)}%`;
  }
  for (const table of article.querySelectorAll("table"))
    fit(table.closest(".admonition, td, .bd-article") || article, table);
  for (const box of article.querySelectorAll("div.highlight"))
    if (box.offsetHeight > 700) {
      box.classList.add("sos-long");
      box.closest(".cell_input")?.classList.add("sos-long");
    }
}
