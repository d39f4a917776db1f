"""Formulas are set when the book is built, not in each reader's browser.

MathJax writes each formula once, by Deno, which requirements.txt brings. A page
then needs a style sheet and fonts, no script: links land where they should, and
what isn't TeX is a warning of the build.
"""

import json
import os
import shutil
import subprocess
import sys
from functools import cache
from html import escape
from pathlib import Path

from docutils import nodes
from sphinx.errors import ExtensionError
from sphinx.util import logging
from sphinx.util.math import get_node_equation_number

HERE = Path(__file__).resolve().parent
FONTS = "mathjax/fonts"
SHEET = "mathematics.css"
log = logging.getLogger(__name__)


def deno():
    """The words that run a script by Deno; what it may read is added."""
    beside = shutil.which("deno", path=Path(sys.executable).parent)
    program = beside or shutil.which("deno")
    if program is None:
        raise ExtensionError("Formulas and stills are set by Deno: pip install deno")
    return program, "run", "--no-config", "--no-remote", "--no-lock"


@cache
def setter():
    """The process that sets formulas; it ends with this one."""
    quiet = {"DENO_NO_UPDATE_CHECK": "1", "NO_COLOR": "1"}
    script = (HERE / "mathematics.js", HERE / "mathjax", FONTS)
    return subprocess.Popen(
        [*deno(), f"--allow-read={HERE}", *script],
        env=os.environ | quiet,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        encoding="utf-8",
    )


def asked(line):
    """What the process answers to a line."""
    process = setter()
    process.stdin.write(line + "\n")
    process.stdin.flush()
    answer = process.stdout.readline()
    if not answer:
        raise ExtensionError(f"Deno ended with {process.wait()} at {line[:200]!r}")
    return json.loads(answer)


@cache
def formula(tex, display):
    """A formula's HTML, or why it is none."""
    return asked(json.dumps({"tex": tex, "display": display}))


def written(node, display):
    """The HTML of a node's formula, with its TeX for those who copy it."""
    tex = node.astext()
    lines = display and not node["nowrap"] and r"\\" in tex
    answer = formula(rf"\begin{{split}}{tex}\end{{split}}" if lines else tex, display)
    if "fault" in answer:
        log.warning("%s: %s", answer["fault"], tex, location=node)
    source = f'<mjx-container data-tex="{escape(tex)}"'
    return answer.get("html", "").replace("<mjx-container", source, 1)


def inline(translator, node):
    """A formula in a line."""
    tag = translator.starttag(node, "span", "", CLASS="math notranslate nohighlight")
    translator.body.append(f"{tag}{written(node, False)}</span>")
    raise nodes.SkipNode


def display(translator, node):
    """A formula of its own, with its number."""
    body = translator.body
    body.append(translator.starttag(node, "div", CLASS="math notranslate nohighlight"))
    if not node["nowrap"] and node["number"]:
        number = get_node_equation_number(translator, node)
        body.append(f'<span class="eqno">({number})')
        translator.add_permalink_ref(node, "Link to this equation")
        body.append("</span>")
    body.append(written(node, True) + "</div>\n")
    raise nodes.SkipNode


def finish(app, exception):
    """Write the sheet of all letters; lighter.py leaves those that the pages have."""
    if not exception and app.builder.name == "html":
        sheet = Path(app.outdir) / "_static" / SHEET
        sheet.write_text(asked("")["css"], "utf-8")


def setup(app):
    """Tell Sphinx."""
    app.add_html_math_renderer("set", (inline, None), (display, None))
    app.add_css_file(SHEET)
    app.connect("build-finished", finish)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
