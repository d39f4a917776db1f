/* Boxes that are wider than the screen scroll inside themselves. A box that does
   so fades at the edge where it goes on, and the keyboard reaches it. */
(() => {
  "use strict";
  const BOXES = ".bd-article :is(mjx-container, .sos-sheet, .sos-table, .sos-panel, pre," +
    " .cell_output > .output, .pst-scrollable-table-container)";

  // The theme's script would name the reader's colours only after the page is laid
  // out, in light ones: then everything is styled twice, and in the dark it flashes.
  const given = document.documentElement.dataset;
  if (given.theme === "auto")
    given.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";

  // What is copied has the TeX of its formulas: their letters are style sheets'.
  addEventListener("copy", event => {
    const selection = getSelection(), range = selection?.rangeCount && selection.getRangeAt(0);
    if (!range || document.activeElement?.matches("input, textarea")) return;
    const inside = range.commonAncestorContainer.parentElement?.closest("mjx-container");
    const copy = document.createElement("div");
    copy.append(inside ? inside.cloneNode(true) : range.cloneContents());
    const formulas = [...copy.querySelectorAll("mjx-container")];
    if (!formulas.length) return;
    for (const formula of formulas) {
      const bars = formula.hasAttribute("display") ? "$$" : "$";
      formula.replaceWith(bars + formula.getAttribute("data-tex").trim() + bars);
    }
    copy.style.cssText = "position: fixed; left: -99999px";
    document.body.append(copy);
    event.clipboardData.setData("text/plain", copy.innerText);
    copy.remove();
    event.preventDefault();
  });

  function measured(box) {
    const hidden = box.scrollWidth - box.clientWidth;
    const scrolls = hidden > 1 && getComputedStyle(box).overflowX !== "visible";
    const more = [];
    if (scrolls && box.scrollLeft > 1) more.push("left");
    if (scrolls && box.scrollLeft < hidden - 1) more.push("right");
    return {box, hidden, scrolls, more};
  }

  function mark({box, hidden, scrolls, more}) {
    if (more.length) {
      box.style.setProperty("--sos-hidden", `${hidden}px`);
      box.dataset.more = more.join(" ");
    } else delete box.dataset.more;
    if (scrolls && box.tabIndex < 0) {
      box.tabIndex = 0;
      box.dataset.reached = "";
    } else if (!scrolls && "reached" in box.dataset) {
      box.removeAttribute("tabindex");
      delete box.dataset.reached;
    }
  }

  // All boxes are measured before any is marked, so that they are laid out once.
  function watch() {
    const watcher = new ResizeObserver(changes => changes.map(({target}) => measured(target)).forEach(mark));
    document.querySelectorAll(BOXES).forEach(box => {
      watcher.observe(box);
      box.addEventListener("scroll", () => mark(measured(box)), {passive: true});
    });
  }

  // Sections for readers of the thesis are open for those who asked for them, on
  // paper, and where a link leads into one.
  /** @type {(kinds?: string) => any[]} */
  const sections = (kinds = ".sos-thesis") => [...document.querySelectorAll(kinds)];
  const FOLDED = ".sos-thesis, .sos-second";

  function unfold(all) {
    for (const section of sections()) {
      section.open = all;
      section.querySelector(".sos-thesis-all input").checked = all;
    }
  }

  function keepUnfolded() {
    const KEY = "sosbook-thesis";
    /** @type {(work: (kept: Storage) => any) => any} */
    const store = work => {
      try {
        return work(localStorage);
      } catch { return null; }
    };
    if (store(kept => kept.getItem(KEY)) === "open") unfold(true);
    document.addEventListener("change", event => {
      const /** @type {any} */ box = event.target;
      if (!box.matches(".sos-thesis-all input")) return;
      store(kept => box.checked ? kept.setItem(KEY, "open") : kept.removeItem(KEY));
      const before = box.getBoundingClientRect().top;
      unfold(box.checked);
      box.closest("details").open = true;
      scrollBy(0, box.getBoundingClientRect().top - before);
    });
    const open = () => {
      const place = document.getElementById(decodeURIComponent(location.hash.slice(1)));
      const /** @type {any} */ section =
        place?.closest(FOLDED) || place?.querySelector(`:scope > :is(${FOLDED})`);
      if (section) section.open = true;
    };
    addEventListener("hashchange", open);
    open();
    addEventListener("beforeprint", () => sections(FOLDED).forEach(section => { section.open = true; }));
  }

  // The contents beside the page follow the reader. The theme names another place for
  // them: then every link of the text is followed, and what it leads to takes the mark
  // from its section. Nobody can be in a folded section, which would be laid out to see
  // that; links that are disabled aren't followed.
  function follow() {
    const body = document.body.dataset, place = "#pst-page-toc-nav";
    if (document.querySelector(place)) body.bsTarget = place;
    else delete body.bsSpy;
    for (const link of sections(`${place} a`)) {
      const section = document.getElementById(decodeURIComponent(link.hash.slice(1)));
      link.disabled = Boolean(section?.closest("details:not([open])"));
    }
  }

  addEventListener("load", () => {
    // The theme's sidebar holds the book's name, which belongs to a landmark.
    const sidebar = document.querySelector(".bd-sidebar-primary");
    sidebar?.setAttribute("role", "complementary");
    sidebar?.setAttribute("aria-label", "Contents of the book");
    keepUnfolded();
    follow();
    watch();
  });
})();

// A drawing that sways is let go whenever it comes into sight.
addEventListener("DOMContentLoaded", () => {
  const seen = new IntersectionObserver(
    all => all.forEach(({target, isIntersecting}) => target.classList.toggle("sos-seen", isIntersecting)),
    {threshold: 0.6});
  document.querySelectorAll("svg:has([class^='sos-sway'])").forEach(svg => seen.observe(svg));
});
