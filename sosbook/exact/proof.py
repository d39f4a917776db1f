"""Verdicts of exact arithmetic on blocks: computed from matrices, never stored."""

from dataclasses import dataclass
from time import monotonic

import numpy as np
from flint import ctx

from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, check_time, checked_seconds, time_limit
from .checker import kernel
from .checker.arithmetic import Refused, scalar
from .definite import definite, positive, semidefinite
from .integers import Integers, Swift, as_rational
from .rational import digit_count

DIGITS = (6, 8, 10, 12, 17)  # to which gains are rounded, in the order of trial
PLACES = (12, 17)  # of the matrices that only the proof needs
NOTHING = "nothing was asked"  # the reason of a `Loop`'s design, which asks nothing


def nearest(x):
    """The float nearest to a rational x, or its infinity: the verdict isn't its own."""
    try:
        return float(x)
    except OverflowError:
        return np.inf if x > 0 else -np.inf


def first_proven(attempt, digits=None, tries=DIGITS, places=PLACES):
    """The first proof of ``attempt(gain digits, matrix digits)``, or its last try.

    With ``digits`` the gain has these only; ``tries`` and ``places`` are what is tried.
    """
    if digits is not None:
        tries = (digit_count(digits),)
    for gain_digits in tries:
        for matrix_digits in places:
            check_time()
            proof = attempt(gain_digits, matrix_digits)
            if proof.proven:
                return proof
    return proof


@dataclass(frozen=True, eq=False)
class Examined:
    """The examination of some blocks.

    ``claims``: what is proven, in words; ``blocks``: each one's smallest pivot by name,
    in large blocks to six digits, None where a kernel that asks for none decided;
    ``failed``: names of those that aren't positive definite, or what else is wrong;
    ``value``: see `MultiplierRefusal`; ``alone``: why no second program can decide it,
    so that it is an enclosure, or ""; ``by_floats``: whether floats with bounds of
    their errors decided, see `sosbook.exact.balls`, and not rationals.
    """

    claims: tuple
    blocks: dict | None
    failed: tuple
    value: float | None = None
    alone: str = ""
    by_floats: bool = False

    @property
    def proven(self) -> bool:
        """True if nothing failed."""
        return not self.failed

    @classmethod
    def of(cls, matrices, claims):
        """Decide for each of the ``matrices`` of rationals, by name.

        ``claims`` are words, which rest on all blocks, or pairs of words and names of
        blocks. One for which a block is missing, or that rests on none, fails.
        """
        verdicts = {}
        for name, g in matrices.items():
            check_time()
            try:
                verdicts[name] = definite(g)
            except ValueError:  # it isn't symmetric
                verdicts[name] = False, np.nan
        failed = [name for name, (proven, _) in verdicts.items() if not proven]
        if not verdicts:
            failed.append("there is no block")
        pairs = [(c, tuple(verdicts)) if isinstance(c, str) else c for c in claims]
        for words, names in pairs:
            if verdicts and not (names and set(names) <= set(verdicts)):
                failed.append(f"no block proves: {words}")
        blocks = {name: nearest(size) for name, (_, size) in verdicts.items()}
        said = () if failed else tuple(words for words, _ in pairs)
        return cls(said, blocks, tuple(failed))

    @classmethod
    def by_kernel(cls, whole, claims, names):
        """The kernel's verdict on the file ``whole``, with its ``claims``.

        Blocks have ``names`` by their labels; without any the labels are names. Where
        few bits of what is enclosed prove too little, the most decide.
        """
        failed, reader = [], swiftest(whole)

        def decide(label, x, semi):
            check_time()
            if scalar(x):
                proven = x >= 0 if semi else x > 0
            elif not x.r or x != x.T:
                proven = x == x.T
            else:
                x = Integers.of(x)
                proven = positive(x) or (semi and semidefinite(as_rational(x)))
            if semi or proven or (names and label not in names):  # a condition
                return proven
            failed.append(names.get(label, label))
            return True  # what fails is listed, and the others are looked at

        for bits in reader.bits:
            failed.clear()
            try:
                with ctx.workprec(bits):
                    value = kernel.check(whole, decide, reader).value
            except Refused:
                if bits == reader.bits[-1]:
                    raise
            else:
                if not failed:
                    break
        value = None if value is None else nearest(value)
        return cls(() if failed else tuple(claims), None, tuple(failed), value)

    @classmethod
    def nothing(cls, *why):
        """Nothing is proven, and ``why``."""
        return cls((), {}, why or ("nothing",))


def swiftest(whole):
    """The `Reader` of a ``whole`` file: of enclosed matrices, or of rational ones."""
    from .checker.verdict import FOLDED  # a first design needs no verdict

    if whole.get("kind") != FOLDED:
        return Swift
    from .enclosing import Enclosing

    return Enclosing


class Verdict:
    """The verdict that files and results without a proof share, from ``examined``."""

    examined: Examined

    @property
    def proven(self) -> bool:
        """True if every block is positive definite, in rational arithmetic."""
        return self.examined.proven

    @property
    def settled(self):
        """True if it is proven in rationals: asked of a text that goes into a file."""
        return self.proven

    @property
    def claims(self):
        """The proven statements, in words; empty without a proof."""
        return self.examined.claims

    @property
    def blocks(self):
        """From a block's name to its smallest pivot: see `Examined`."""
        return self.examined.blocks

    @property
    def failed(self):
        """Names of the blocks that aren't positive definite."""
        return self.examined.failed

    def __bool__(self):
        return self.proven

    def __str__(self):
        from ..runtime.saying import one_line

        if self.proven:
            first = self._proven_words()
            if self.examined.alone:
                first = f"{first.removesuffix(':')}, by an enclosure of one program:"
            return "\n- ".join([first, *map(one_line, self.claims)])
        return "not proven: " + ", ".join(map(one_line, self.failed))

    def _proven_words(self):
        return "proven:"


@dataclass(frozen=True)
class Unproven(Verdict):
    """The answer of a result without a proof, and ``why``; it excludes nothing.

    >>> print(Unproven("the design is undecided"))
    not proven: the design is undecided
    """

    why: str

    @property
    def examined(self):
        """The verdict: nothing is proven."""
        return Examined.nothing(self.why)

    def verify(self):
        """Never proven: there is nothing to compute again."""
        return False

    @property
    def K(self) -> np.ndarray:
        """A ValueError: no gain is proven."""
        raise ValueError(f"no gain is proven: {self.why}")

    def save(self, path: object) -> None:
        """Raise a ValueError: there is no proof for the file at ``path``."""
        raise ValueError(f"there is no proof to save: {self.why}")


class Stopped(Unproven):
    """The result of `proven_within` where the ``seconds`` are over; ``share``: which
    part of the work is done, in words.
    """

    def __init__(self, seconds, share=""):
        share = f". So far: {share}" if share else ""
        super().__init__(f"stopped after {seconds:g} s; raise time_limit{share}")


@one_thread
def proven_within(seconds, work, progress=False):
    """The proof that ``work()`` returns, examined, or `Stopped` after some ``seconds``.

    None sets no limit. With ``progress`` a bar shows the seconds that have passed.

    >>> print(proven_within(1e-9, lambda: first_proven(None)))
    not proven: stopped after 1e-09 s; raise time_limit
    """
    seconds, begun = checked_seconds(seconds), monotonic()
    try:
        with time_limit(seconds, progress):
            return work()
    except OutOfTime as over:
        if seconds is None or over.end < begun + seconds:  # somebody else's limit
            raise
        return Stopped(seconds, over.share)
