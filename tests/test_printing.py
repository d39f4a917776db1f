"""The book as a PDF: text, outline, links and fonts of a few printed chapters."""

import re
from pathlib import Path

import pytest

from sosbook.book.printing import chosen, contents, print_book
from sosbook.book.printing.__main__ import mention
from tests import browser as chromium

pypdf = pytest.importorskip("pypdf")
LISTING = Path(__file__).resolve().parent.parent / "_toc.yml"
CHAPTERS = 4


@pytest.fixture(scope="module")
def printed(site, tmp_path_factory):
    path = chromium.find()
    if path is None:
        pytest.skip(chromium.MISSING)
    output = tmp_path_factory.mktemp("pdf") / "book.pdf"
    return print_book(site, output, contents(site, LISTING)[:CHAPTERS], path)


#: Lines and curves of figures, in the text of a page: most of what is to be read.
DRAWN = re.compile(rb"^[-.\d ]+ (?:[mlcvyh]|re)\n", re.MULTILINE)


def pages(printed):
    return pypdf.PdfReader(printed.path).pages


def words(page):
    """The text of a page, read without its figures' lines."""
    content = page["/Contents"].get_object()
    content.set_data(DRAWN.sub(b"", content.get_data()))
    return page.extract_text()


def titles(outline):
    for entry in outline:
        if isinstance(entry, list):
            yield from titles(entry)
        else:
            yield entry.title


def test_the_outline_has_the_parts_the_chapters_and_their_sections(site, printed):
    found = list(titles(pypdf.PdfReader(printed.path).outline))
    for chapter in contents(site, LISTING)[:CHAPTERS]:
        assert chapter.title in found
        assert chapter.part in ["", *found]
    assert len(found) > 3 * CHAPTERS


def test_pages_are_numbered_and_listed_in_the_contents(printed):
    texts = [words(page) for page in pages(printed)]
    assert len(texts) == printed.pages > 10
    assert printed.size == printed.path.stat().st_size
    front = next(k for k, text in enumerate(texts) if re.search(r"(?m)^1$", text))
    for k, text in enumerate(texts[front:], 1):
        assert re.search(rf"(?m)^{k}$", text), k
    assert "Contents" in texts[1]
    labels = pypdf.PdfReader(printed.path).page_labels
    assert labels[: front + 1] == ["i", "ii", "iii", "iv"][:front] + ["1"]


def test_links_stay_in_the_book_or_lead_to_the_web(printed):
    inside = 0
    for page in pages(printed):
        for note in page.get("/Annots", ()):
            note = note.get_object()
            uri = str(note.get("/A", {}).get("/URI", ""))
            assert not uri.startswith("file:")
            inside += "/Dest" in note
    assert inside > 20
    assert b"file:///" not in printed.path.read_bytes()


def test_a_chapter_alone_counts_from_one_and_shows_a_still_with_its_setting(
    site, tmp_path
):
    """Without controls, with the address where it moves; no contents before it."""
    chapters, path = contents(site, LISTING), chromium.find()
    (one,) = chosen(chapters, "4")
    site_address = "https://book.example"
    output = tmp_path / "four.pdf"
    bound = print_book(site, output, [one], path, site_address, textbook=True)
    texts = [words(page) for page in pages(bound)]
    assert pypdf.PdfReader(output).page_labels[:2] == ["1", "2"]
    assert one.title.split()[-1] in texts[0] and "Contents" not in texts[0]
    text = " ".join("".join(texts).split())
    assert "A still of what moves on the page: " in text
    assert "decays with σ = 0.7 s⁻¹, rings within" in text  # its setting
    assert "within ρ = 5 s⁻¹: proven." in text
    assert f"{site_address}/book/{one.name}.html" in text
    for control in ("Link to this", "Prove it exactly", "For readers of the thesis"):
        assert control not in text
    assert chosen(chapters, "own_plant")[0].name == "own_plant"
    with pytest.raises(ValueError, match="no chapter is called 99"):
        chosen(chapters, "99")
    teaching = {chapter.part for chapter in chosen(chapters, textbook=True)}
    parts = {chapter.part for chapter in chapters}
    assert parts - teaching == {"The package", "The record"}


def test_every_font_is_part_of_the_file(printed):
    names = set()
    for page in pages(printed):
        for font in page["/Resources"].get("/Font", {}).values():
            font = font.get_object()
            if font["/Subtype"] == "/Type3":  # drawn by the file itself
                continue
            inner = font["/DescendantFonts"][0] if "/DescendantFonts" in font else font
            parts = inner.get_object()["/FontDescriptor"].get_object()
            assert {"/FontFile", "/FontFile2", "/FontFile3"} & parts.keys()
            names.add(font["/BaseFont"])
    assert len(names) > 3


def test_a_page_that_was_not_built_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"tasks\.py book"):
        contents(tmp_path, LISTING)


def test_the_first_page_links_the_file_once_it_is_there(tmp_path):
    first = tmp_path / "book" / "intro.html"
    first.parent.mkdir()
    first.write_text('on paper: <span class="sos-pdf">none</span>.', "utf-8")
    for size in ("7 pages", "8 pages"):
        mention(tmp_path, tmp_path / "sosbook.pdf", size)
        text = first.read_text("utf-8")
        assert f'<a href="../sosbook.pdf">PDF</a> ({size})' in text
        assert text.count("sos-pdf") == 1


def test_the_book_is_tagged_and_each_page_and_link_finds_its_tags(printed):
    """Chromium tags each chapter; bound, the numbers still lead to the right tags."""
    reader = pypdf.PdfReader(printed.path)
    root = reader.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and root["/Lang"] == "en"
    tree = root["/StructTreeRoot"]
    assert len(tree["/K"]) == CHAPTERS + 1  # the contents, too
    numbers = tree["/ParentTree"]["/Nums"]
    owners = dict(zip(numbers[::2], numbers[1::2]))
    assert len(owners) == len(numbers) / 2 == tree["/ParentTreeNextKey"]
    links = 0
    for page in reader.pages:
        tags = [tag.get_object() for tag in owners[page["/StructParents"]].get_object()]
        homes = [tag.raw_get("/Pg") for tag in tags if "/Pg" in tag]
        assert page.indirect_reference in homes
        for note in page.get("/Annots", ()):
            if "/StructParent" in (note := note.get_object()):
                assert owners[note["/StructParent"]].get_object()["/S"] == "/Link"
                links += 1
    assert links > 20
    kinds = {tag["/S"] for tag in every(tree["/K"])}
    assert {"/Document", "/H1", "/H2", "/P", "/Figure", "/Link", "/Table"} <= kinds


def every(tags):
    """All tags below, without what isn't one."""
    tags = tags.get_object()
    if isinstance(tags, pypdf.generic.ArrayObject):
        for tag in tags:
            yield from every(tag)
    elif isinstance(tags, pypdf.generic.DictionaryObject):
        if "/S" in tags:
            yield tags
        if "/K" in tags:
            yield from every(tags["/K"])
