"""Proofs that are files: what they prove is computed from their texts alone."""

import warnings
from dataclasses import dataclass, replace
from functools import lru_cache
from weakref import WeakKeyDictionary

from ..runtime.kinds import OfKind
from ..runtime.reading import read_text
from ..runtime.writing import write_file
from .checker import verdict
from .proof import Examined, Verdict
from .proof_text import MADE, is_proof, parse, said, same, written

__all__ = ["ProofFile", "kinds", "load"]


@dataclass(frozen=True, repr=False)
class ProofFile(Verdict, OfKind):
    """A proof that is a file: its text holds all data, as exact decimals.

    What it proves is computed from the text alone. A changed text is
    another proof, or none: no field stores a verdict.

    Parameters
    ----------
    text : str
        The file, in JSON.
    """

    text: str

    @classmethod
    def of(cls, data):
        """Write the file of some data: a dict of lists, decimals and words."""
        text, words, fault = written(cls.kind, _of_part(data))
        proof = cls(text)
        _WORDS[proof] = words
        if fault is not None and proof.proven and proof.claims:  # a text should say it
            fault = f"written as version 1, which has no text: {cls.kind}: {fault}"
            warnings.warn(fault, stacklevel=2)
        return proof

    @classmethod
    def examine(cls, data):
        """Rebuild everything from the data, where more than a text is to be decided.

        Returns
        -------
        data : dict
            As it is written, from what was rebuilt.
        examined : Examined
            None of both where the kernel alone decides, see `Examined.by_kernel`.
        """
        return None

    @property
    def examined(self):
        """The verdict on the text."""
        return _remembered(type(self), self.text, _WORDS.get(self))

    @property
    def data(self):
        """The file's contents, as a dict."""
        return parse(self.text)[1]

    def verify(self):
        """Whether it is proven, with everything computed again from the text."""
        return _examined(type(self), self.text).proven

    def save(self, path):
        """Write the file, proven or not; `load` reads it.

        Parameters
        ----------
        path : str or Path
            Where the file goes. A proof that is there is replaced.

        Raises
        ------
        FileExistsError
            If a file is there that is no proof.
        """
        write_file(path, self.text, over=is_proof)

    @classmethod
    def load(cls, path):
        """Read a proof file. Nothing is believed: ask ``proven``.

        Parameters
        ----------
        path : str or Path
            Where the file is.

        Raises
        ------
        ValueError
            If it is no proof file, or one of another kind.
        """
        proof = load(path)
        if not isinstance(proof, cls):
            raise ValueError(
                f"{path} is a proof of the kind {proof.kind!r}: use sosbook.proofs.load"
            )
        return proof

    def __repr__(self):
        return f"<{type(self).__name__}: {'' if self.proven else 'not '}proven>"


def kinds():
    """The classes of proof files that are known."""
    return ProofFile.owners()


def load(path):
    """Read a proof file of any kind.

    Parameters
    ----------
    path : str or Path
        Where the file is.

    Returns
    -------
    ProofFile
        Nothing of it is believed: ``proven`` is computed from the data.

    Raises
    ------
    ValueError
        If it is no proof file.
    """
    text = read_text(path)
    try:
        kind, _ = parse(text)
    except ValueError as error:
        raise ValueError(f"{path} is no proof file: {error}") from None
    cls = ProofFile.owner(kind)
    if cls is not None:
        return cls(text)
    known = ", ".join(sorted(repr(cls.kind) for cls in kinds()))
    raise ValueError(f"{path}: kind must be one of {known}, got {kind!r:.80}")


def _examined(cls, text, words=None):
    """The verdict on a text, beside which these words were just written; or again."""
    try:
        kind, data = parse(text)
        if kind != cls.kind:
            return Examined.nothing(f"kind is {kind!r}, not {cls.kind!r}")
        rebuilt = cls.examine(data)
        if rebuilt is None:
            return Examined.by_kernel(text)
        words = said(text) if words is None else list(words)
        again, examined = rebuilt
        again = _of_part(again)
    except (*verdict.MALFORMED, ArithmeticError) as e:
        return Examined.nothing(f"not a well-formed proof: {e}")
    claims = tuple(verdict.of_part(examined.claims, data))
    examined = replace(examined, claims=claims)
    if words is not None:
        data["claims"] = words
    made = {key for key in MADE if key not in data}
    for key in {*data, *again} - made:
        if key not in data or key not in again or not same(data[key], again[key]):
            return Examined.nothing(f"{key!r:.80} isn't what the data say")
    return examined


def _of_part(data):
    """The data, their claims being about a reduced model if that is the plant."""
    if "claims" not in data:
        return data
    return {**data, "claims": verdict.of_part(data["claims"], data)}


_remembered = lru_cache(maxsize=64)(_examined)
# Of files that were written here, beside their texts.
_WORDS: WeakKeyDictionary = WeakKeyDictionary()
