"""Names that files may hold, and families of classes that they name by kind."""

import re
from typing import ClassVar

from .later import PACKAGE, later

NAME = re.compile(r"(?=[\w(])([\w (),#-]|[.](?! ))+(?<! )")


def sane_name(name):
    """A name that is safe in messages, pages, files and verdicts, or a ValueError: it
    begins with a letter, a digit or a bracket and ends with no space; a point stands
    inside a word.

    >>> sane_name("decay 1,2"), sane_name("half-plane#2"), sane_name("Größe (A.6)")
    ('decay 1,2', 'half-plane#2', 'Größe (A.6)')
    """
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise ValueError(
            f"name = {name!r} must be one line of letters, digits, spaces and hyphens, "
            "and of _ ( ) , # and points inside words"
        )
    return name


def claimed(names):
    """The ``names`` of signals as files and claims have them: "_" stands for what isn't
    of a word, and #2 tells the second from others that are then called the same.

    >>> claimed(["place'", "z1 - 0.5 z2", "a, b", "a; b"])
    ["place'", 'z1 - 0.5 z2', 'a_ b#3', 'a_ b#4']
    """
    strange = r"[^\w ()'+#/.-]|[.](?= )|^[^\w(-]|\s$"
    found = [re.sub(strange, "_", x[:95]) or "_" for x in names]
    twice = [f"{x}#{k}" for k, x in enumerate(found, 1)]
    told = [y if found.count(x) > 1 else x for x, y in zip(found, twice)]
    return told if len({*told}) == len(told) else twice


class OfKind:
    """A member of a family, whose direct heirs are a family each.

    A class that files can name declares its ``kind`` in its own body. A kind isn't
    inherited in files: what a file says is read by the class that declared it, whatever
    was derived from it since. Only a class of the same name and module takes its place:
    a cell of a notebook that is run again. Raises ValueError when a class is made whose
    kind has another owner, or is no sane name.

    >>> class Shape(OfKind):
    ...     "A family."
    >>> class Disk(Shape):
    ...     kind = "disk"
    >>> class Large(Disk):
    ...     "Files can't hold it: it declares no kind of its own."
    >>> Shape.owner("disk") is Disk, Disk().owns_its_kind, Large().owns_its_kind
    (True, True, False)
    """

    kind = ""
    homes: ClassVar[dict] = {}  # "module.Class" of kinds that are imported when asked
    _owners: ClassVar[dict]

    def __init_subclass__(cls, **more):
        """Register the class for its kind; raises ValueError if it is taken."""
        super().__init_subclass__(**more)
        if OfKind in cls.__bases__:
            cls._owners = {}
        kind = vars(cls).get("kind", "")
        if kind == "":
            return
        mine = _place(cls)
        owner = _place(cls._owners.get(sane_name(kind), cls))
        if kind in cls.homes:  # it has its owner before that is imported
            owner = f"{PACKAGE}.{cls.homes[kind]}"
        if owner != mine:
            raise ValueError(
                f"{cls.__qualname__}: kind = {kind!r} is that of {owner}, and what its "
                "files say must not change: give the class another kind"
            )
        cls._owners[kind] = cls

    @classmethod
    def owner(cls, kind: str) -> type | None:
        """The class of this family that declared a kind, or None; imported now, if it
        wasn't before. Raises ModuleNotFoundError if its room isn't there.
        """
        if kind in cls.homes and kind not in cls._owners:
            later(*cls.homes[kind].rsplit(".", 1))
        return cls._owners.get(kind)

    @classmethod
    def kinds(cls) -> tuple:
        """All kinds of this family, imported or not."""
        return tuple({**cls.homes, **cls._owners})

    @property
    def owns_its_kind(self) -> bool:
        """True if its very class declared the kind, so that files can hold it."""
        owner = self.owner(self.kind)
        return owner is not None and _place(owner) == _place(type(self))


def _place(cls):
    return f"{cls.__module__}.{cls.__qualname__}"
