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

  // Formulas are set when the fonts that most pages need are there: one that comes
  // later makes the browser lay out the whole page again, and lines jump.
  if (window["MathJax"])
    window["MathJax"].startup = {
      async pageReady() {
        const {startup} = window["MathJax"];
        document.head.append(startup.output.styleSheet(startup.document));
        const kinds = ["I", "A", "C", "S1", "S2", "S3", "S4"];
        const names = ["ZERO", "TEX", ...kinds.map(kind => `TEX-${kind}`)];
        await Promise.allSettled(names.map(name => document.fonts.load(`1em MJX${name}`)));
        return startup.defaultPageReady();
      },
    };

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

  addEventListener("load", () => {
    // The theme's sidebar holds the book's name, which belongs to a landmark.
    const sidebar = document.querySelector(".bd-sidebar-primary");
    sidebar?.setAttribute("role", "complementary");
    sidebar?.setAttribute("aria-label", "Contents of the book");
    Promise.resolve(window["MathJax"]?.startup?.promise).then(watch);
  });
})();
