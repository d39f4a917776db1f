"""HTML as a tree, with the parser of the standard library."""

from html.parser import HTMLParser

__all__ = ["Node", "parse"]

VOID = {"br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}


class Node:
    """An element: its tag, attributes and children (nodes and strings)."""

    __slots__ = ("tag", "attributes", "children")

    def __init__(self, tag, attributes=()):
        self.tag, self.attributes = tag, dict(attributes)
        self.children = []

    @property
    def text(self):
        """All text in it, spaces collapsed."""
        return " ".join("".join(self._texts()).split())

    def _texts(self):
        for child in self.children:
            if isinstance(child, str):
                yield child
            else:
                yield from child._texts()

    def elements(self):
        """The element and all those in it, in their order."""
        yield self
        for child in self.children:
            if not isinstance(child, str):
                yield from child.elements()

    def __str__(self):
        attributes = "".join(f' {k}="{v}"' for k, v in self.attributes.items())
        inside = "".join(map(str, self.children))
        return f"<{self.tag}{attributes}>{inside}</{self.tag}>"


class Parser(HTMLParser):
    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open = [Node("")]

    def handle_starttag(self, tag, attrs):
        node = Node(tag, attrs)
        self.open[-1].children.append(node)
        if tag not in VOID:
            self.open.append(node)

    def handle_startendtag(self, tag, attrs):
        self.open[-1].children.append(Node(tag, attrs))

    def handle_endtag(self, tag):
        for depth in range(len(self.open) - 1, 0, -1):
            if self.open[depth].tag == tag:
                del self.open[depth:]
                return

    def handle_data(self, data):
        self.open[-1].children.append(data)


def parse(text):
    """The root of an HTML fragment, a Node without a tag.

    Examples
    --------
    >>> parse("<p id='a'>0<br>1</p>").children[0].text
    '01'
    """
    parser = Parser()
    parser.feed(text)
    parser.close()
    return parser.open[0]
