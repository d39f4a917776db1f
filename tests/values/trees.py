"""HTML as a tree, with the parsers of the standard library."""

from html.parser import HTMLParser
from xml.parsers import expat

VOID = {"br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}


class Node:
    """An element: its tag, attributes and children (nodes and strings)."""

    __slots__ = ("attributes", "children", "tag")

    def __init__(self, tag, attributes=None):
        self.tag, self.attributes = tag, attributes or {}
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
        rest = [self]
        while rest:
            node = rest.pop()
            yield node
            rest += [x for x in reversed(node.children) if not isinstance(x, str)]

    def __str__(self):
        attributes = "".join(f' {k}="{v}"' for k, v in self.attributes.items())
        inside = "".join(map(str, self.children))
        return f"<{self.tag}{attributes}>{inside}</{self.tag}>"


class Builder:
    """Makes the tree from what a parser meets."""

    def __init__(self):
        self.open = [Node("")]

    def start(self, tag, attributes):
        node = Node(tag.lower(), {k.lower(): v for k, v in attributes.items()})
        self.open[-1].children.append(node)
        if node.tag not in VOID:
            self.open.append(node)

    def end(self, tag):
        for depth in range(len(self.open) - 1, 0, -1):
            if self.open[depth].tag == tag.lower():
                del self.open[depth:]
                return

    def text(self, data):
        self.open[-1].children.append(data)


class Tolerant(HTMLParser):
    def __init__(self, builder):
        super().__init__(convert_charrefs=True)
        self.handle_data, self.handle_endtag = builder.text, builder.end
        self.builder = builder

    def handle_starttag(self, tag, attrs):
        self.builder.start(tag, dict(attrs))

    def handle_startendtag(self, tag, attrs):
        self.builder.start(tag, dict(attrs))
        self.builder.end(tag)


def parse(text):
    """The root of an HTML fragment, a Node without a tag: by XML's parser if it can."""
    try:
        builder = Builder()
        fast = expat.ParserCreate("utf-8")
        fast.buffer_text = True
        fast.StartElementHandler = builder.start
        fast.EndElementHandler = builder.end
        fast.CharacterDataHandler = builder.text
        fast.Parse(f"<page>{text}</page>", True)
        return builder.open[0].children[0]
    except expat.ExpatError:
        builder = Builder()
        tolerant = Tolerant(builder)
        tolerant.feed(text)
        tolerant.close()
        return builder.open[0]
