"""Print the chapters, one after the other, and bind them."""

import html
import io
import os
import re
from importlib.resources import files
from pathlib import Path
from urllib.parse import unquote, urlsplit

from ...display.escape import page_text
from ...runtime.libraries import library
from .binding import Bound, bind
from .contents import Chapter

LINK = re.compile(r'href="([^"#]*)#([^"]+)"')
#: The width of the printed column: A4 less two margins of 20 mm, at 96 dpi.
COLUMN = {"width": 642, "height": 900}


def print_book(
    site: Path,
    output: Path,
    chapters: list[Chapter],
    chromium: str | None = None,
    address: str = "",
    textbook: bool = False,
) -> Bound:
    """Print ``chapters`` of the built ``site`` into one PDF, ``output``, with an
    outline and working links, by ``chromium``, or playwright's own; several have a
    title and contents with Roman numbers. ``address`` serves what moves, a ``textbook``
    leaves out what is for readers of the thesis. Returns the numbers of pages and
    bytes.
    """
    wanted = anchors(chapters)
    playwright = library("playwright.sync_api")
    parts, first, printed = [], 1, []
    with playwright.sync_playwright() as engine:
        window = engine.chromium.launch(executable_path=chromium, args=_switches())
        for chapter in chapters:
            page = _opened(window, chapter)
            name = chapter.path.relative_to(site).as_posix()
            elsewhere = f"{address.rstrip('/')}/{name}" if address else ""
            page.evaluate(
                _asset("prepare.js"),
                {
                    "css": _asset("print.css"),
                    "part": chapter.part if chapter.opens else "",
                    "head": chapter.title,
                    "first": first,
                    "anchors": sorted(wanted.get(chapter.path, ())),
                    "elsewhere": elsewhere,
                    "textbook": textbook,
                },
            )
            data = _pdf(page)
            page.close()
            parts.append((chapter, first, data))
            first += _length(data)
        if len(parts) > 1:
            printed = [(Chapter(site / "contents", "Contents"), _front(window, parts))]
        window.close()
    printed += [(chapter, data) for chapter, _, data in parts]
    return bind(printed, output)


def anchors(chapters):
    """The places of each page that other pages link to."""
    wanted, known = {}, {chapter.path for chapter in chapters}
    for chapter in chapters:
        text = chapter.path.read_text("utf-8")
        for target, place in LINK.findall(text):
            if target and not urlsplit(target).scheme:
                path = Path(os.path.normpath(chapter.path.parent / unquote(target)))
                if path in known:
                    wanted.setdefault(path, set()).add(unquote(html.unescape(place)))
    return wanted


def _opened(window, chapter):
    """A page in print, without a network."""
    page = window.new_page(viewport=COLUMN, color_scheme="light")
    page.route(re.compile("^(https?|wss?):"), lambda route: route.abort())
    page.emulate_media(media="print", reduced_motion="reduce")
    page.goto(chapter.path.resolve().as_uri(), wait_until="load")
    return page


def _pdf(page):
    return page.pdf(
        prefer_css_page_size=True, print_background=True, outline=True, tagged=True
    )


def _length(data):
    pypdf = library("pypdf")
    return len(pypdf.PdfReader(io.BytesIO(data)).pages)


def _front(window, parts):
    """The title page and the contents with the numbers of the pages."""
    rows = []
    for chapter, number, _ in parts:
        if chapter.opens:
            rows.append(f"<h2>{page_text(chapter.part)}</h2>")
        rows.append(
            f'<p><a href="{chapter.path.resolve().as_uri()}">'
            f"<span>{page_text(chapter.title)}</span>"
            f"<i></i><span>{number}</span></a></p>"
        )
    page = window.new_page(viewport=COLUMN)
    page.set_content(_asset("front.html").replace("<!-- rows -->", "\n".join(rows)))
    data = _pdf(page)
    page.close()
    return data


def _switches():
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return ["--disable-dev-shm-usage", *(["--no-sandbox"] if root else [])]


def _asset(name):
    return (files(__package__) / name).read_text("utf-8")
