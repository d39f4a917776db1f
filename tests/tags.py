"""What a page's tags say, without a browser."""

import re
from collections import Counter
from html.parser import HTMLParser

VOID = {"area", "br", "col", "hr", "img", "input", "link", "meta", "source", "wbr"}
#: What takes most of a page's bytes and tells nothing here: the inside of a formula,
#: strokes of a drawing and colours of code without a name.
FORMULA = re.compile(r"(<mjx-container[^>]*>).*?(</mjx-container>)", re.DOTALL)
STROKES = re.compile(r"<(?:use|path)\b(?![^>]*\bid=)[^>]*/>")
CODE = re.compile(r"<pre>.*?</pre>", re.DOTALL)
COLOURS = re.compile(r'<span class="\w+">|</span>|<span></span>')
#: Nothing in these is of a page's kinds: what has tests of its own, and the title that
#: printers get.
CLOSED = {"head", "script", "style", "svg", "mjx-container", "pre", "sos-", "print"}
#: No rule of axe asks where these stand.
WORDS = {"span", "code", "em", "strong", "sup", "br", "i"}
HEADINGS = {f"h{k}" for k in range(1, 7)}
NAMED = HEADINGS | {"a", "button", "summary", "caption", "label", "th"}
NAMES = "aria-label", "alt", "title"
REFER = "aria-labelledby", "aria-describedby", "for"


def bare(text):
    """A page's text without what takes most of its bytes."""
    text = STROKES.sub("", FORMULA.sub(r"\1formula\2", text))
    return CODE.sub(lambda code: COLOURS.sub("", code[0]), text)


class Tags(HTMLParser):
    """The tags of a page: where it leads to, what it loads, and its elements."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loads, self.ids, self.anchors = [], [], [], {""}
        self.levels, self.unnamed, self.referred = [], [], []
        #: Parent, tag, attributes and role of each element, of words no parent; of a
        #: link its style, too.
        self.kinds = set()
        self.open, self.closed = [], 0
        self.feed(bare(text))

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if "id" in given:
            self.ids.append(given["id"])
        self.anchors.update(given[x] for x in ("id", "name") if x in given)
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif tag in ("script", "img", "iframe", "source") and "src" in given:
            self.loads.append(given["src"])
        elif tag == "link" and "href" in given:
            self.loads.append(given["href"])
        kind = "sos-" if tag.startswith("sos-") else tag
        kind = "print" if given.get("class") == "onlyprint" else kind
        if not self.closed:
            self.describe(kind, given)
        if tag not in VOID:
            self.open.append([tag, kind, False])
            self.closed += kind in CLOSED
        if any(given.get(x) for x in NAMES):
            self.handle_data("named")

    def describe(self, tag, given):
        """The kind of an element, its level, and what it refers to."""
        parent = self.open[-1][1] if self.open and tag not in WORDS else ""
        names = frozenset(given) - {"id", "class", "href", "name", "title"}
        style = given.get("class") if tag == "a" else None
        self.kinds.add((parent, tag, names, given.get("role"), style))
        if tag in HEADINGS:
            self.levels.append(int(tag[1]))
        for name in REFER:
            self.referred += (given.get(name) or "").split()

    def handle_data(self, data):
        if data.strip():
            for element in reversed(self.open):
                if element[2]:
                    break  # so has all that it stands in
                element[2] = True

    def handle_endtag(self, tag):
        if tag not in (name for name, _, _ in self.open):
            return
        while True:
            name, kind, named = self.open.pop()
            self.closed -= kind in CLOSED
            if name in NAMED and not named and not self.closed:
                self.unnamed.append(name)
            if name == tag:
                return

    def faults(self):
        """What listeners would miss: names, levels of headings, what is referred to."""
        steps = zip(self.levels, self.levels[1:])
        twice = [name for name, count in Counter(self.ids).items() if count > 1]
        return [
            *(f"{tag} without a name" for tag in self.unnamed),
            *(f"h{b} after h{a}" for a, b in steps if b > a + 1),
            *([f"{n} h1"] if (n := self.levels.count(1)) != 1 else []),
            *(f"id {name} twice" for name in twice),
            *(f"nothing has the id {x}" for x in {*self.referred} - {*self.ids}),
        ]
