"""What a page's layout may not do: functions in JavaScript, lists of faults."""

#: Text as wide as in DejaVu Sans or Verdana, the widest of the usual fonts: a
#: reader has other fonts than the machine that runs the tests. A script for new
#: pages, which are laid out once then. In Arial as in DejaVu Sans the mean letter of a
#: text has 0.814 of the width of a nought; in the widest fonts it has 0.518 em.
WIDE_TYPE = """
(() => {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(`.bd-article {letter-spacing: max(0px, 0.518em - 0.814ch)}
    .bd-article :is(mjx-container, pre, code) {letter-spacing: 0}`);
  document.adoptedStyleSheets.push(sheet);
})();
"""

#: Formulas whose letters stand out of the box that cuts them.
CUT_FORMULAS = """
() => [...document.querySelectorAll("mjx-container")].filter((box) => {
  const {top, bottom, width} = box.getBoundingClientRect();
  // The pieces of a tall bracket are longer than it is; MathJax clips them.
  return width && [...box.querySelectorAll("mjx-c")]
    .filter((letter) => !letter.closest("mjx-stretchy-v, mjx-stretchy-h"))
    .map((letter) => letter.getBoundingClientRect())
    .some((letter) => letter.top < top - 1 || letter.bottom > bottom + 1);
}).map((box) => box.querySelector("mjx-assistive-mml").textContent.slice(0, 80))
"""

#: Nothing is painted: no pixels, which take a quarter of a browser's time and which
#: only few tests look at. All else is there: styles, places, clicks, frames.
UNPAINTED = """
(() => {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync("html, body {opacity: 0}");
  document.adoptedStyleSheets.push(sheet);
})();
"""

#: How far down the page the picture begins with which it opens; null without one.
OPENING = """
() => {
  const first = document.querySelector(".sos-opening :is(.sos-panel, figure, svg)");
  return first && first.getBoundingClientRect().top + scrollY;
}
"""

#: Boxes that are wider than their place on a desk: formulas, tables, code, figures.
#: Each of them fades at an edge and has a bar to scroll it. On a phone their inside is
#: as wide, and their place narrower by as much as the column of 676 pixels is there.
WIDE_BOXES = """
() => {
  const article = document.querySelector(".bd-article");
  if (!article) return [];
  const {paddingLeft: left, paddingRight: right} = getComputedStyle(article);
  const column = article.clientWidth - parseFloat(left) - parseFloat(right);
  const room = 676 - column;
  if (room && innerWidth > 1200) return [`a desk's column has ${column} pixels`];
  return [...article.querySelectorAll(":not(svg *)")]
    .filter((box) => ["auto", "scroll"].includes(getComputedStyle(box).overflowX))
    .filter((box) => box.clientWidth > 1)
    .filter((box) => box.scrollWidth > box.clientWidth + room + 1)
    .filter((box) => box.checkVisibility())
    .map((box) => [box.scrollWidth - box.clientWidth, box.outerHTML.slice(0, 120)]);
}
"""

#: Boxes that scroll sideways and either can't be reached by the keyboard or
#: don't show that they go on.
SILENT_BOXES = """
() => [...document.querySelectorAll(".bd-article :not(svg *)")]
  .filter((box) => ["auto", "scroll"].includes(getComputedStyle(box).overflowX))
  .filter((box) => box.scrollWidth > box.clientWidth + 1 && box.clientWidth > 1)
  .filter((box) => box.checkVisibility())
  .filter((box) => box.tabIndex < 0 || getComputedStyle(box).maskImage === "none")
  .map((box) => box.outerHTML.slice(0, 120))
"""

#: Figures of which a part is out of sight until the reader scrolls.
CUT_FIGURES = """
() => [...document.querySelectorAll(".sos-figure .sos-sheet")]
  .filter((sheet) => sheet.checkVisibility())
  .filter((sheet) => sheet.scrollWidth > sheet.clientWidth + 1)
  .map((sheet) => [sheet.scrollWidth, sheet.closest("figure").id])
"""

#: Texts of figures that are too small: the widest legend has 6.44 px on a phone.
#: Matplotlib draws a text as a group of outlines, scaled from a font of 100 units.
#: In a figure that is shown in parts they are drawn again, in the smallest's scale.
SMALL_LETTERS = """
() => [...document.querySelectorAll(".sos-figure svg g[transform*='scale(']")]
  .filter((text) => text.querySelector(":scope > use") && text.checkVisibility())
  .map((text) => {
    const parts = [...text.closest(".sos-sheet").querySelectorAll(".sos-parts svg")]
      .filter((part) => part.checkVisibility());
    const place = text.getScreenCTM(), own = text.closest("svg").getScreenCTM();
    const shown = Math.min(...parts.map((part) => part.getScreenCTM().a)) / own.a;
    const size = 100 * Math.hypot(place.a, place.b) * (parts.length ? shown : 1);
    return [size, text.closest("figure").id];
  })
  .filter(([size]) => size < 6.4)
"""

#: What stands out of the box in which an element says what it found.
LOOSE_READOUTS = """
() => [...document.querySelectorAll(".sos-readout *")].filter((part) => {
  const {right, width} = part.getBoundingClientRect();
  const box = part.closest(".sos-readout").getBoundingClientRect();
  return width && right > box.right + 1;
}).map((part) => part.outerHTML.slice(0, 120))
"""

#: Elements that say a unit as programs write it, to readers or to listeners.
PROGRAM_UNITS = """
() => [...document.querySelectorAll(".bd-article *")].filter((element) =>
  element.localName.startsWith("sos-") && [element.innerText,
    ...[...element.querySelectorAll("[aria-label]")].map((part) => part.ariaLabel)
  ].some((text) => text.includes("1/s"))).map((element) => element.localName)
"""

#: Captions in a lighter type than the text.
THIN_CAPTIONS = """
() => [...document.querySelectorAll(".bd-article figcaption, .bd-article caption")]
  .filter((caption) => getComputedStyle(caption).fontWeight < 400)
  .map((caption) => caption.textContent.slice(0, 80))
"""

#: Icons that can be seen, and aren't drawn by the sheet in the size of a letter.
BAD_ICONS = """
() => {
  const seen = [...document.querySelectorAll("i[class*='fa-']")]
    .filter((icon) => icon.checkVisibility());
  if (!seen.length) return ["no icon at all"];
  return seen.filter((icon) => {
    const {width, height} = icon.getBoundingClientRect();
    return !getComputedStyle(icon).maskImage.startsWith("url(") ||
      Math.min(width, height) < 8 || Math.max(width, height) > 40;
  }).map((icon) => icon.outerHTML);
}
"""

#: Resolves in the next frame. A page's script hears of new colours or a new width
#: in a frame; what is asked before makes the browser style everything twice.
FRAME = "() => new Promise(requestAnimationFrame)"

#: Ids that more than one element has.
REPEATED_IDS = """
() => [...document.querySelectorAll("[id]")].map((element) => element.id)
  .filter((id, k, ids) => ids.indexOf(id) !== k)
"""

#: The page without what axe needn't walk through: outlines, formulas, the colours
#: of code and of names, the sidebars' links but the first of each list. No rule of its
#: own judges them, or they are all made alike; formulas have the tests above. Axe
#: keeps nodes in lists that it searches: twice the nodes take it four times as long.
BARE = """
() => {
  document.querySelectorAll("figure svg").forEach((svg) => svg.replaceChildren());
  document.querySelectorAll("mjx-container").forEach((box) => box.replaceChildren("x"));
  const boxes = [...document.querySelectorAll("pre")]; // all are read, then written
  const texts = boxes.map((box) => box.innerText);
  boxes.forEach((box, k) => box.replaceChildren(texts[k]));
  document.querySelectorAll(":is(.bd-sidebar-primary, .page-toc) li:nth-child(n + 3)")
    .forEach((item) => item.remove());
  for (const span of [...document.querySelectorAll(":is(code, .sig) span")].reverse())
    if (!span.childElementCount && span.getAttributeNames().join() === "class")
      span.replaceWith(...span.childNodes);
}
"""

#: What axe objects to. Contrast has a test of its own, which sees inside
#: custom elements and in both schemes.
AXE = """
async () => {
  const rules = {"color-contrast": {enabled: false}};
  const preload = {assets: ["media"]}; // no rule asks for the text of the sheets
  const wanted = {resultTypes: ["violations"], elementRef: true, preload, rules};
  const {violations} = await axe.run(wanted);
  return violations.flatMap(({id, nodes}) =>
    nodes.map(({element}) => `${id}: ${element.outerHTML.slice(0, 150)}`));
}
"""
