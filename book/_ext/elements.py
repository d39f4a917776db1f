"""Page elements: the style and scripts that they share, as files of the site.

A stored notebook has an element's data alone. Its page loads what it needs from
``_static/elements``; from a file, too, for these are classic scripts. They stand behind
the first element that needs them, and the browser waits there: what is below an element
isn't seen before the element has its size, so no text moves while a page loads.
"""

import json
import re
import subprocess
from functools import cache
from pathlib import Path
from zlib import crc32

from mathematics import deno
from sphinx.errors import ExtensionError

from sosbook.book.elements.page import ELEMENT, named
from sosbook.book.elements.scripts import modules, script, sheet

LAST = 900  # behind the theme's and the book's own sheets
WHOLE = re.compile(rf"{ELEMENT.pattern}.*?</sos-[a-z]+>", re.DOTALL)
#: One whose script is there was made before its data.
START = "<script>document.currentScript.previousElementSibling.start?.()</script>"
DATA = re.compile(r'<script type="application/json">(.*?)</script>', re.DOTALL)
ABSENT = re.compile(r'<p class="sos-absent">.*?</p>', re.DOTALL)
WISHES = "<sos-wish", "<sos-bench"
HERE = Path(__file__).resolve().parent


@cache
def stills(*elements):
    """The same wishes, each with what it shows without a script: sentence, verdict and
    pictures.
    """
    data = [json.loads(DATA.search(element)[1]) for element in elements]
    reads = f"--allow-read={HERE.parent.parent}"
    done = subprocess.run(
        [*deno(), reads, HERE / "stills.js"],
        input=json.dumps(data),
        capture_output=True,
        encoding="utf-8",
    )
    if done.returncode:
        raise ExtensionError(f"stills.js: {done.stderr[-2000:]}")
    pictures = [f'<div class="sos-absent">{x}</div>' for x in json.loads(done.stdout)]
    both = zip(elements, pictures, strict=True)
    return [ABSENT.sub(lambda _, x=x: x, text, count=1) for text, x in both]


def load(app, page, template, context, doctree):
    """Write the files that a page's elements need, and name them behind those."""
    body = context.get("body", "")
    sheets, scripts = named(body)
    folder = Path(app.outdir) / "_static" / "elements"
    folder.mkdir(parents=True, exist_ok=True)
    for k, name in enumerate(sheets):
        (folder / f"{name}.css").write_text(sheet(name), "utf-8")
        app.add_css_file(f"elements/{name}.css", priority=LAST + k)
    wishes = [m[0] for m in WHOLE.finditer(body) if m[0].startswith(WISHES)]
    whole = dict(zip(wishes, stills(*wishes), strict=True)) if wishes else {}
    tags = {}
    for name in scripts:
        (folder / f"{name}.js").write_text(script(name), "utf-8")
        place = context["pathto"](f"_static/elements/{name}.js", resource=True)
        mark = crc32(script(name).encode())
        tags[name] = f'<script src="{place}?v={mark:08x}"></script>'

    def behind(element):
        """An element, and what wasn't there before it."""
        more = (tags.pop(name, "") for name in modules(element[2]))
        text = whole.get(element[0], element[0])
        return f"{text}{START}{''.join(more)}"

    context["body"] = WHOLE.sub(behind, body)


def setup(app):
    """Tell Sphinx."""
    app.connect("html-page-context", load)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
