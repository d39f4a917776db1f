"""Proofs that are files: what they prove is computed from their texts alone."""

from dataclasses import dataclass, replace
from functools import lru_cache
from weakref import WeakKeyDictionary

from ..runtime.kinds import OfKind
from ..runtime.reading import read_text
from ..runtime.writing import write_file
from .checker import kernel, verdict
from .checker.arithmetic import Beyond, Refused
from .proof import Examined, Verdict
from .proof_text import MADE, is_proof, parse, same, written
from .rational import as_rational, decimal, read_array

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
        text, said = written(cls.kind, _of_part(data))
        proof = cls(text)
        _WRITTEN[proof] = said and Written(*said)
        return proof

    @classmethod
    def examine(cls, data):
        """(data, `Examined`), rebuilt from data of which no text says the proof."""
        raise Beyond("no text says it, and nothing else decides")

    @classmethod
    def named(cls, data, keys):
        """The names of blocks whose keys are those of the text that the data make."""
        return map(str, keys)

    @property
    def examined(self):
        """The verdict on the text."""
        return _remembered(type(self), self.text, _WRITTEN.get(self))

    @property
    def data(self):
        """The file's contents, as a dict."""
        return parse(self.text)[1]

    def measured(self, measure):
        """What ``measure`` makes of each block, a `Rational` matrix, by its name."""
        said, found = Written(*verdict.opened(self.text)), {}

        def decide(label, x, semi):
            if label in names or not names:
                found[names.get(label, label)] = measure(as_rational(x))
            return True

        names = said.names(self.data, type(self))
        kernel.check(said.whole, decide)
        return found

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


@dataclass(frozen=True, eq=False)
class Written:
    """What `sosbook.exact.checker.verdict.written` says of a text."""

    whole: dict
    claims: list
    keys: dict

    def names(self, data, cls):
        """The names of blocks by their labels."""
        return dict(zip(self.keys, cls.named(data, self.keys.values()), strict=True))


def _examined(cls, text, said=None):
    """The verdict on a text that was just written, or on one from elsewhere."""
    try:
        kind, data = parse(text)
        if kind != cls.kind:
            return Examined.nothing(f"kind is {kind!r}, not {cls.kind!r}")
        try:
            said = said or Written(*verdict.opened(text))
        except Beyond:
            return _rebuilt(cls, data)
        return Examined.by_kernel(said.whole, said.claims, said.names(data, cls))
    except (Beyond, Refused) as e:
        return Examined.nothing(*map(str, e.args))
    except (*verdict.MALFORMED, ArithmeticError) as e:
        return Examined.nothing(f"not a well-formed proof: {e}")


def _rebuilt(cls, data):
    """The verdict on a file without a text, which its class decides."""
    again, examined = cls.examine(data)
    again = _of_part(again)
    claims = tuple(verdict.of_part(examined.claims, data))
    for key in {*data, *again} - {x for x in MADE if x not in data}:
        if key not in data or key not in again or not same(data[key], again[key]):
            return Examined.nothing(f"{key!r:.80} isn't what the data say")
    return replace(examined, claims=claims)


def _of_part(data):
    """The data, their claims being about a reduced model if that is the plant."""
    if "claims" not in data:
        return data
    return {**data, "claims": verdict.of_part(data["claims"], data)}


_remembered = lru_cache(maxsize=64)(_examined)
# Of files that were written here, beside their texts.
_WRITTEN: WeakKeyDictionary = WeakKeyDictionary()


class GainProof(ProofFile):
    """A proof about a gain, which is written with few digits; ``text`` is its file."""

    @property
    def K(self):
        """The gain that the proof is about, rounded to the printed digits."""
        return read_array(self.data["K"], None, None)

    @property
    def digits(self):
        """Significant digits of the gain's longest entry."""
        return significant(self.K)

    def _proven_words(self):
        return f"proven with {self.digits} digits:" if self.digits > 6 else "proven:"


def given_gain(gain):
    """What to try instead where the gain is given: that very gain."""
    return {} if gain is None else {"tries": (17,)}


def significant(K):
    """Significant digits of the longest entry of an array K of floats."""
    digits = (decimal(k).lstrip("-").split("e")[0].replace(".", "") for k in K.flat)
    return max((len(d.strip("0")) for d in digits), default=0)
