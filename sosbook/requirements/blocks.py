"""The blocks of all requirements of a request, and their names."""


class BlockName(str):
    """The label of a block, with the key of its ``requirement`` (None for P itself),
    that one's own name of the ``block``, and ``vertices``: numbers of the vertex or of
    the pair, none for what is demanded once.
    """

    def __new__(cls, label, requirement, block, vertices):
        self = super().__new__(cls, label)
        self.requirement, self.block = requirement, block
        self.vertices = vertices
        return self

    def __getnewargs__(self):
        return str(self), self.requirement, self.block, self.vertices


class BlockTable:
    """The one place where the blocks of a request come together. Their keys are
    (requirement, block, vertices), so that no name that a user chose can take the place
    of another block; ``many`` is whether labels show the vertices' numbers.
    """

    def __init__(self, many):
        self.many, self.matrices, self.owners = many, {}, {}

    def add(self, requirement, block, vertices, matrix):
        """Join the ``matrix`` of a ``requirement``'s ``block`` at ``vertices``; refuse
        a second one.
        """
        key = (requirement and requirement.key, block, tuple(dict.fromkeys(vertices)))
        if key in self.matrices:
            raise ValueError(f"two blocks are called {key}")
        self.matrices[key], self.owners[key] = matrix, requirement

    def named(self):
        """dict from `BlockName` to matrix, in the order of joining."""
        taken = {block for _, block, _ in self.matrices}
        labelled = {}
        for key, matrix in self.matrices.items():
            owner, block = self.owners[key], key[1]
            label = block or owner.name
            if not block and label in taken:  # a name that a user chose
                label = f"{owner.kind} {label}"
            label += self._numbers(key[2])
            if label in labelled:
                label = f"{owner.name} {label}"
            if label in labelled:
                raise ValueError(f"two blocks are labelled {label!r}")
            labelled[BlockName(label, *key)] = matrix
        return labelled

    def _numbers(self, vertices):
        if not self.many or not vertices:
            return ""
        return " " + ",".join(str(i + 1) for i in vertices)
