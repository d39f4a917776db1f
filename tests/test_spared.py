"""What the build of the book doesn't do again at each page changes no page."""

import random
import sys
from pathlib import Path

import pytest

from tests.processes import process

EXTENSIONS = Path(__file__).resolve().parent.parent / "book" / "_ext"
sys.path.append(str(EXTENSIONS))
spared = pytest.importorskip("spared")
nodes = spared.nodes

MODULE = '''
def half(x=2):
    """The half of x: |x| / 2.

    Parameters
    ----------
    x : float

    Returns
    -------
    float
    """
'''
PAGES = {
    "index.md": "# A\n```{toctree}\n:caption: Part\none\ntwo\n```\n## Within\nText.\n",
    "one.md": "# B\n## First\n### Deep\nText.\n```{toctree}\nthree\n```\n## Last\n",
    "two.md": "# C\n## X\n```{eval-rst}\n.. automodule:: halves\n   :members:\n```\n",
    "three.md": "# D\n\n## Its *section*\n[](one.md)\n",
    "page.html": '{% extends "!page.html" %}{% block body %}{{ super() }}'
    "{{ toctree(titles_only=True, collapse=False, includehidden=True) }}"
    "{{ toctree(titles_only=False, collapse=True) }}{% endblock %}",
    "halves.py": MODULE,
}
BUILD = """
import sys
from sphinx.application import Sphinx
source, *folders = sys.argv[1:]
sys.path.append(source)
for folder, more in zip(folders, ([], ["spared"])):
    given = {"extensions": ["myst_parser", "sphinx.ext.autodoc", "numpydoc", *more],
             "templates_path": [source], "html_theme": "basic",
             "exclude_patterns": ["[ab]"], "html_last_updated_fmt": None}
    app = Sphinx(source, None, folder, folder + "/trees", "html", given, None)
    app.build()
    assert not app.statuscode
"""


def test_a_book_has_the_same_pages_and_stores_less(tmp_path):
    for name, text in PAGES.items():
        (tmp_path / name).write_text(text, "utf-8")
    plain, less = tmp_path / "a", tmp_path / "b"
    words = "-c", BUILD, tmp_path, plain, less
    process(sys.executable, *words, check=True, cwd=EXTENSIONS)
    pages = [x.name for x in plain.glob("*.html")]
    assert {"index.html", "one.html", "two.html", "three.html"} <= {*pages}
    for page in pages:
        assert (less / page).read_text("utf-8") == (plain / page).read_text("utf-8")
    assert "Parameters" in (less / "two.html").read_text("utf-8")
    sizes = [(x / "trees" / "two.doctree").stat().st_size for x in (plain, less)]
    assert sizes[1] < 20_000 < sizes[0]


KINDS = {
    None: None,
    "class": nodes.emphasis,
    "text": nodes.Text,
    "function": lambda node: "b" in node.astext(),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("within", [{}, {"include_self": False}, {"siblings": True}])
@pytest.mark.parametrize("seed", range(3))
def test_the_nodes_of_a_tree_are_those_of_docutils_in_their_order(kind, within, seed):
    draw = random.Random(seed)

    def tree(depth):
        below = (tree(depth - 1) for _ in range(draw.randrange(depth) if depth else 0))
        word = nodes.Text(draw.choice("abc"))
        return draw.choice((nodes.emphasis, nodes.strong))("", "", word, *below)

    whole = nodes.paragraph("", "", *(tree(5) for _ in range(4)))
    for top in (whole, whole[1], nodes.paragraph()):
        asked = {"condition": KINDS[kind], **within}
        found = [*spared.walk(top, **asked)]
        assert [*map(id, found)] == [*map(id, spared.findall(top, **asked))]


def test_a_node_that_is_replaced_while_it_is_found_is_passed_as_before():
    texts = []
    for walk in (spared.walk, spared.findall):
        whole = nodes.paragraph("", "", *(nodes.strong("", x) for x in "abc"))
        for node in walk(whole, nodes.strong):
            node.replace_self([nodes.emphasis("", "x"), nodes.strong("", "y")][:1])
        texts.append(str(whole))
    assert texts[0] == texts[1] and texts[0].count("emphasis") == 6
