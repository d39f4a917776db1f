"""Page elements: the style and scripts that they share, as files of the site.

A stored notebook has an element's data alone. A page that shows elements loads what
these need from ``_static/elements``; from a file, too, for they are classic scripts.
"""

from pathlib import Path

from sosbook.book.elements.page import named
from sosbook.book.elements.scripts import script, sheet

LAST = 900  # behind the theme's and the book's own sheets


def load(app, page, template, context, doctree):
    """Name the files that this page's elements need, and write those not yet there."""
    sheets, scripts = named(context.get("body", ""))
    folder = Path(app.outdir) / "_static" / "elements"
    folder.mkdir(parents=True, exist_ok=True)
    for k, name in enumerate(sheets):
        (folder / f"{name}.css").write_text(sheet(name), "utf-8")
        app.add_css_file(f"elements/{name}.css", priority=LAST + k)
    for k, name in enumerate(scripts):
        (folder / f"{name}.js").write_text(script(name), "utf-8")
        app.add_js_file(
            f"elements/{name}.js", priority=LAST + k, loading_method="defer"
        )


def setup(app):
    """Tell Sphinx."""
    app.connect("html-page-context", load)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
