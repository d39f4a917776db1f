"""Names and texts that are safe in messages, pages, files and verdicts."""

import re

NAME = re.compile(r"(?=[\w(])([\w (),#-]|[.](?! ))+(?<! )")


def sane_name(name):
    """A name that is safe in messages, pages, files and verdicts, or a ValueError.

    It begins with a letter, a digit or a bracket and ends with no space. A point
    stands inside a word only: a name is no sentence.

    Examples
    --------
    >>> sane_name("decay 1,2"), sane_name("half-plane#2"), sane_name("Größe (A.6)")
    ('decay 1,2', 'half-plane#2', 'Größe (A.6)')
    """
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise ValueError(
            f"name = {name!r} must be one line of letters, digits, spaces and hyphens, "
            "and of _ ( ) , # and points inside words"
        )
    return name
