"""Old addresses of the book's pages lead to the new ones.

The table ``book/moved.toml`` says where each page went. The build writes a small page
at each old address. It opens the new one, from a server and from the disk, at the same
place: of a label such as ``eq-12-gamma`` the number is that of the new chapter.
"""

import html
import json
import re
import tomllib
from pathlib import Path

from sphinx.util import logging

TABLE = Path(__file__).resolve().parent.parent / "moved.toml"
IDS = re.compile(r'\bid="([^"]+)"')
PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="robots" content="noindex">
<title>This page has moved - {project}</title>
<link rel="canonical" href="{to}.html">
<noscript><meta http-equiv="refresh" content="0; url={to}.html"></noscript>
<script>
  const name = (place) => place.replace(/((?:^|-)[a-z]+)-{old}-/, "$1-{new}-");
  const place = decodeURIComponent(location.hash.slice(1));
  const away = {away};
  const [page, id] = away[place] || ["{to}", name(place)];
  location.replace(page + ".html" + location.search + (id && "#" + id));
</script>
</head>
<body>
<p>This page is now <a href="{to}.html">{to}</a>.</p>
</body>
</html>
"""
log = logging.getLogger(__name__)


def table(path=TABLE):
    """The old pages by their names, and where each went: one page, or several."""
    pages = tomllib.loads(path.read_text("utf-8"))["pages"]
    return {old: [new] if isinstance(new, str) else new for old, new in pages.items()}


def mark(name):
    """What stands in a page's labels for its number: 07, or a letter."""
    return name[:2] if name[:2].isdigit() else name[0]


def places(path):
    """The ids of a built page."""
    return IDS.findall(path.read_text("utf-8"))


def page(old, news, folder, project):
    """The small page at an old address, as HTML."""
    first, *others = news
    away, here = {}, set(places(folder / f"{first}.html")) if others else ()
    for other in others:
        for place in places(folder / f"{other}.html"):
            if place not in here:
                marks = f"-(?:{mark(other)}|{mark(first)})-"  # a label may keep its own
                was = re.sub(marks, f"-{mark(old)}-", place, count=1)
                away[was] = [other, place]
    return PAGE.format(
        project=html.escape(project),
        to=first,
        old=mark(old),
        new=mark(first),
        away=json.dumps(away),
    )


def write(app, exception):
    """Write a page at each old address; a warning if it leads nowhere."""
    if exception or app.builder.name != "html":
        return
    folder = Path(app.outdir) / "book"
    for old, news in table().items():
        known = [f"book/{new}" in app.env.found_docs for new in news]
        if f"book/{old}" in app.env.found_docs or not all(known):
            log.warning("moved.toml: %s leads to no page, or is one", old)
            continue
        text = page(old, news, folder, app.config.project)
        (folder / f"{old}.html").write_text(text, "utf-8")


def setup(app):
    """Tell Sphinx."""
    app.connect("build-finished", write)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
