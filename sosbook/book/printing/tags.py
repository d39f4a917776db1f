"""Tags of a bound book: what is a heading, what a figure, for screen readers."""


class Tags:
    """The trees of the chapters' tags as one tree: a page or a link names its tags by a
    number, and here all chapters count on. ``pypdf``: the library; ``writer``: the
    book.
    """

    def __init__(self, pypdf, writer):
        self.generic, self.writer = pypdf.generic, writer
        kind = self.generic.NameObject("/StructTreeRoot")
        self.tree = writer._add_object(self._record(Type=kind))
        self.kids, self.owners = self.generic.ArrayObject(), self.generic.ArrayObject()
        self.following = 0

    def add(self, reader, start):
        """Take the tags of a chapter by its `reader`; it begins on the page `start`."""
        tree = reader.root_object.get("/StructTreeRoot")
        if tree is None:
            return
        tree, name = tree.get_object(), self.generic.NameObject
        chapter = tree["/K"].clone(self.writer)
        chapter[name("/P")] = self.tree
        self.kids.append(chapter.indirect_reference or self.writer._add_object(chapter))
        owners = tree["/ParentTree"]["/Nums"]
        for key, owner in zip(owners[::2], owners[1::2]):
            owner = owner.get_object().clone(self.writer)
            self.owners.append(self._number(key))
            self.owners.append(owner.indirect_reference or owner)
        for old, new in zip(reader.pages, self.writer.pages[start:]):
            self._renumber(old, new, "/StructParents")
            pairs = zip(old.get("/Annots", ()), new.get("/Annots", ()))
            for link, copy in pairs:
                self._renumber(link.get_object(), copy.get_object(), "/StructParent")
        self.following += tree["/ParentTreeNextKey"]

    def finish(self):
        """Write the tree into the book."""
        name, tree = self.generic.NameObject, self.tree.get_object()
        owners = self.writer._add_object(self._record(Nums=self.owners))
        tree[name("/K")] = self.kids
        tree[name("/ParentTree")] = owners
        tree[name("/ParentTreeNextKey")] = self.generic.NumberObject(self.following)
        root = self.writer.root_object
        root[name("/StructTreeRoot")] = self.tree
        root[name("/MarkInfo")] = self._record(Marked=self.generic.BooleanObject(True))

    def _number(self, key):
        """A chapter's number of tags as one of the book's."""
        return self.generic.NumberObject(key + self.following)

    def _renumber(self, old, new, kind):
        """Let the copy of a page or a link name its tags by the book's number."""
        if kind in old:
            new[self.generic.NameObject(kind)] = self._number(old[kind])

    def _record(self, **entries):
        """A dictionary of PDF."""
        name = self.generic.NameObject
        return self.generic.DictionaryObject(
            {name(f"/{key}"): value for key, value in entries.items()}
        )
