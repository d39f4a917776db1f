"""``verify`` of a small proof: the kernel decides, and no library is imported."""

import re
from time import process_time

from .checker import kernel, verdict
from .checker.arithmetic import Beyond, Refused, definite
from .checker.subject import subject

LONGEST, SECONDS = 45_000, 0.6  # letters of a file, and what the kernel may take:
# beyond them the libraries, which take as long to import, are faster
GAINS = ("design", "known gain", "delay", "regularization")  # kinds about a gain
NOT_DECIDED = "this says nothing about the proof; "


def verify(path):
    """Print what the proof file at ``path`` proves, and return the exit code.

    Returns None, and prints nothing, where the package must decide: where nothing is
    proven so, whatever the reason, and where the file is long or takes long.
    """
    end = process_time() + SECONDS

    def decide(label, x, semi):
        if process_time() > end and not sampled:
            raise Beyond("it takes long")
        return definite(x, semi)

    try:
        with verdict.at_most(verdict.SECONDS, NOT_DECIDED):
            text = verdict.read(path)
            sampled = '"kind":"sampled"' in text  # no library is faster
            if len(text) > LONGEST and not sampled:
                return None
            file, claims, _ = verdict.opened(text)
            kernel.check(file, decide)
            asked = verdict.asked_of(verdict.contents(text))
    except (Refused, Beyond, OSError, MemoryError, *kernel.MALFORMED):
        return None
    first, *lines = str(claims).splitlines()
    if asked["kind"] in GAINS:
        first = proven_words(significant(asked["K"]))
    about = subject(asked)
    verdict.say(f"{first[:-1]}, of {about}:" if about else first, *lines)
    return verdict.AUTHOR if verdict.by_author(asked) else 0


def proven_words(digits):
    """How a proof about a gain begins, which has so many significant digits."""
    return f"proven with {digits} digits:" if digits > 6 else "proven:"


def significant(K):
    """Significant digits of the longest of the decimals in the rows of K.

    >>> significant([["-1.250", "3e10"], ["0.001"]])
    3
    """
    words = (re.sub("e.*|[-.]", "", x).strip("0") for row in K for x in row)
    return max(map(len, words), default=0)
