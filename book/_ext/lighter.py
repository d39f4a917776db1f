"""Less to load and to do: no rules of classes that no page has, no box asked twice.

The theme's sheets are made for every page that anybody may write, MathJax's for every
letter. A browser reads their 7000 rules for each page, and asks hundreds of them of
each of its elements. When the pages are written, the sheets keep the rules that an
element may have: those whose classes are in a page, or among the words of a script.

The theme's script asks all boxes of code and output whether they scroll, when a page
is there and whenever anything in it has changed. It lays out all of the page for each
answer, what is folded, too. sosbook.js knows that from each box whose size changes.
"""

import re
from pathlib import Path

SCRIPT = "scripts/pydata-sphinx-theme.js"
ASKS = re.compile(
    r',"complete"===document\.readyState\?(\w+)\(\):'
    r'window\.addEventListener\("load",\1\)'
)
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
#: What comes before the next brace or semicolon; a string may have both.
PIECE = re.compile(
    r"""((?:"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|url\([^"')]*\)|[^{};"'u]+|u)*)([{};])"""
)
NESTED = re.compile(r"\([^()]*\)|\[[^\[\]]*\]")
CLASS = re.compile(r"\.(-?[A-Za-z_][\w-]*)")
WORN = re.compile(r"""class=\\?["']([^"'\\]*)""")
WORD = re.compile(r"[A-Za-z_][\w-]*")


def words_of(pages, scripts):
    """The classes of some pages, and all words of some scripts."""
    worn = (word for text in pages for word in " ".join(WORN.findall(text)).split())
    return {*worn, *(word for text in scripts for word in WORD.findall(text))}


def used(sheet, words):
    """The sheet with the rules alone that ask for no class but of these words.

    A script may add to a word that ends with a hyphen. What stands in the brackets of
    a selector, as in `:not(.wide)`, decides nothing.
    """
    stems = tuple(word for word in words if word.endswith("-"))

    def known(name):
        return name in words or name.startswith(stems)

    blocks = [("", [])]
    for text, mark in PIECE.findall(COMMENT.sub("", sheet)):
        if mark == "{":
            blocks.append((text, []))
            continue
        blocks[-1][1].append(text + mark.strip("}"))
        if mark == "}":
            head, body = blocks.pop()
            bare = head
            while (less := NESTED.sub("", bare)) != bare:
                bare = less
            parts = [CLASS.findall(part) for part in bare.split(",")]
            if "".join(body).strip() and any(all(map(known, part)) for part in parts):
                blocks[-1][1].append(f"{head}{{{''.join(body)}}}")
    ((_, rules),) = blocks
    return "".join(rules)


def finish(app, exception):
    """Write the sheets and the script again, after all pages and sheets are there."""
    if exception or app.builder.name != "html":
        return
    static = Path(app.outdir) / "_static"
    script = static / SCRIPT
    script.write_text(ASKS.sub("", script.read_text("utf-8")), "utf-8")
    pages = (path.read_text("utf-8") for path in static.parent.rglob("*.html"))
    scripts = (path.read_text("utf-8") for path in static.rglob("*.js"))
    words = words_of(pages, scripts)
    for path in static.rglob("*.css"):
        path.write_text(used(path.read_text("utf-8"), words), "utf-8")


def setup(app):
    """Tell Sphinx."""
    app.connect("build-finished", finish, priority=900)  # icons has its sheet then
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
