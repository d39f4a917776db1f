"""Bind printed chapters: one file, one outline, links from page to page."""

import io
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit
from urllib.request import url2pathname

from ...runtime.libraries import library
from .tags import Tags


@dataclass(frozen=True)
class Bound:
    """A bound book.

    ``path``: the file; ``pages``: how many pages it has; ``size``: its bytes.
    """

    path: Path
    pages: int
    size: int


class _Places:
    """Where each chapter begins, and its named places."""

    def __init__(self):
        self.starts, self.named = {}, {}

    def add(self, path, start, reader):
        self.starts[path] = start
        for name, place in reader.named_destinations.items():
            number = reader.get_destination_page_number(place)
            if number is not None and number >= 0:
                key = unquote(name.lstrip("/"))
                self.named[path, key] = (start + number, place.left, place.top)

    def find(self, path, name):
        """Page, left and top of a place; the chapter's first page if it is lost."""
        if found := self.named.get((path, name)):
            return found
        return (self.starts[path], 0, None) if path in self.starts else None


def bind(printed, output):
    """Write the printed chapters as one file.

    ``printed``, list of (Chapter, bytes): the chapters as single PDFs; ``output``: the
    file to write. Returns the numbers of pages and bytes.
    """
    pypdf = library("pypdf")
    writer, places, owners = pypdf.PdfWriter(), _Places(), []
    tags = Tags(pypdf, writer)
    part, parent, front = None, None, 0
    for chapter, data in printed:
        reader = pypdf.PdfReader(io.BytesIO(data))
        start = len(writer.pages)
        places.add(chapter.path, start, reader)
        for page in reader.pages:
            writer.add_page(page)
            owners.append(chapter.path)
        tags.add(reader, start)
        if chapter.opens and chapter.part != part:
            part = chapter.part
            parent = writer.add_outline_item(title=part, page_number=start, bold=True)
        item = writer.add_outline_item(
            title=chapter.title,
            page_number=start,
            parent=parent if chapter.part else None,
        )
        if chapter.path.suffix:
            _outline(writer, reader, reader.outline, start, item)
        else:  # title and contents, which are no page of the site
            front = len(writer.pages)
            writer.set_page_label(0, front - 1, style="/r")
    writer.set_page_label(front, len(owners) - 1, style="/D", start=1)
    for page, owner in zip(writer.pages, owners):
        _relink(pypdf, writer, page, owner, places)
    tags.finish()
    writer.add_metadata(
        {
            "/Title": "Uncertain Second Order Systems",
            "/Author": "The sosbook authors",
            "/Subject": "An executable book on control by linear matrix inequalities",
        }
    )
    writer.root_object[pypdf.generic.NameObject("/Lang")] = (
        pypdf.generic.TextStringObject("en")
    )
    writer.page_mode = "/UseOutlines"
    writer.compress_identical_objects(remove_duplicates=True, remove_unreferenced=True)
    writer.write(output)
    return Bound(Path(output), len(owners), Path(output).stat().st_size)


def _outline(writer, reader, entries, start, parent, depth=0):
    """Copy the headings below a chapter's title, two levels deep."""
    item = parent
    for entry in entries:
        if isinstance(entry, list):
            if depth < 2:
                _outline(writer, reader, entry, start, item, depth + 1)
        elif depth == 0:  # the title itself
            item = parent
        else:
            number = reader.get_destination_page_number(entry)
            item = writer.add_outline_item(
                title=_once(entry.title), page_number=start + number, parent=parent
            )


def _once(title):
    """A heading; Chromium says it twice where a label stands in it."""
    half = len(title) // 2
    return title[:half] if half and title[:half] == title[half:] else title


def _relink(pypdf, writer, page, owner, places):
    """Let a page's links lead into the bound book; drop those to files."""
    generic = pypdf.generic
    kept = generic.ArrayObject()
    for reference in page.get("/Annots", ()):
        note = reference.get_object()
        action = note.get("/A")
        action = action.get_object() if action is not None else {}
        name, path = note.get("/Dest"), owner
        uri = str(action.get("/URI", ""))
        if action.get("/S") == "/GoTo":
            name = action.get("/D")
        if uri and not uri.startswith("file:"):
            kept.append(reference)
            continue
        if uri:
            split = urlsplit(uri)
            path = Path(url2pathname(split.path))
            name = split.fragment
        place = places.find(path, unquote(str(name or "").lstrip("/")))
        if place is None:
            continue
        number, left, top = place
        target = [writer.pages[number].indirect_reference, generic.NameObject("/XYZ")]
        target += [_number(generic, left), _number(generic, top), generic.NullObject()]
        note.pop("/A", None)
        note[generic.NameObject("/Dest")] = generic.ArrayObject(target)
        kept.append(reference)
    page[generic.NameObject("/Annots")] = kept


def _number(generic, value):
    return generic.NullObject() if value is None else generic.FloatObject(value)
