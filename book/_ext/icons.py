"""Less to load: no script of 1.5 MB for icons.

The theme draws its icons with a script that holds all two thousand of them.
When the pages are written, the few that they show are taken from it.
"""

import re
from pathlib import Path
from urllib.parse import quote

from sphinx.util import logging

SCRIPT = "scripts/fontawesome.js"
TAG = re.compile(r'<script src="([^"]*)scripts/fontawesome\.js[^"]*"></script>')
USED = re.compile(r'class="(?:[^"]* )?fa[srb]?(?:-solid|-regular|-brands)? [^"]*"')
SIZES = {"fa-lg", "fa-fw", "fa-sm", "fa-xs", "fa-xl", "fa-solid", "fa-brands"}
HEAD = """\
/* Icons: Font Awesome Free (https://fontawesome.com), CC BY 4.0. */
:is(.fa-solid, .fa-brands, .fa-regular, .fas, .fab, .far) {
  background: currentColor;
  display: inline-block;
  flex: none;
  height: 1em;
  line-height: 1;
  mask: var(--icon) center / contain no-repeat;
  vertical-align: -0.125em;
  width: var(--width, 1em);
}
:is(.fa-solid, .fa-brands, .fa-regular, .fas, .fab, .far)::before { content: none; }
:is(.fa-solid, .fa-brands, .fa-regular, .fas, .fab, .far).fa-lg { line-height: 1; }
@media (forced-colors: active) {
  :is(.fa-solid, .fa-brands, .fa-regular, .fas, .fab, .far) {
    background: ButtonText;
    forced-color-adjust: none;
  }
}
"""
log = logging.getLogger(__name__)


def icons_of(text):
    """The names of the icons that a page shows."""
    words = " ".join(USED.findall(text)).replace('"', " ").split()
    return {w for w in words if w.startswith("fa-")} - SIZES


def drawing(name, script):
    """Width, height and path of an icon of the script, or None."""
    body = r'\[(\d+),(\d+),\[([^\]]*)\],"\w+",("[^"]*"|\["[^\]]*\])\]'
    match = re.search(rf'[{{,]"?{re.escape(name)}"?:{body}', script)
    if match is None:  # a former name stands in the list of its present one
        match = next(
            (m for m in re.finditer(body, script) if f'"{name}"' in m[3]), None
        )
    if match is None:
        return None
    return int(match[1]), int(match[2]), "".join(re.findall(r'"([^"]*)"', match[4]))


def sheet(names, script):
    """The style sheet of some icons."""
    lines = [HEAD]
    for name in sorted(names):
        found = drawing(name.removeprefix("fa-"), script)
        if found is None:
            log.warning("the icon %s isn't known", name)
            continue
        width, height, path = found
        svg = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">'
            f'<path d="{path}"/></svg>'
        )
        data = quote(svg, safe=" =:/'()-,.")
        lines.append(
            f'.{name} {{ --icon: url("data:image/svg+xml,{data}"); '
            f"--width: {width / height:.4g}em; }}\n"
        )
    return "".join(lines)


def finish(app, exception):
    """Replace the script by the sheet, in all pages."""
    static = Path(app.outdir) / "_static"
    script = static / SCRIPT
    if exception or app.builder.name != "html" or not script.exists():
        return
    names = set()
    for page in Path(app.outdir).rglob("*.html"):
        text = page.read_text("utf-8")
        names |= icons_of(text)
        new = TAG.sub(r'<link rel="stylesheet" href="\1icons.css" />', text)
        if new != text:
            page.write_text(new, "utf-8")
    (static / "icons.css").write_text(sheet(names, script.read_text("utf-8")), "utf-8")
    for path in (*static.rglob("*.map"), *static.glob("scripts/fontawesome*")):
        path.unlink(missing_ok=True)


def setup(app):
    """Tell Sphinx."""
    app.connect("build-finished", finish)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
