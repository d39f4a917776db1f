"""Proofs that are files: what they prove is computed from their texts alone.

A file is JSON, a text with data, see `sosbook.exact.checker`. What no text says, as
matrices in balls, has its data alone.
"""

import json
import re
from dataclasses import dataclass, replace
from functools import lru_cache

from ..runtime.names import OfKind
from ..runtime.reading import parse_json, read_text
from . import quick
from .balls import certain
from .checker import kernel, verdict
from .checker.arithmetic import Beyond, Refused
from .definite import definite
from .integers import as_rational
from .proof import Examined, Verdict, nearest, swiftest
from .rational import decimals, read_array

KINDS = {  # whose class each kind is, by its module: it is found when a file names it
    "lmi": "lmi.proofs.LMIProof",
    "infeasible lmi": "lmi.proofs.LMIRefusal",
    "regularization": "synthesis.regularity.RegularityProof",
    "infeasible regularization": "synthesis.regularity.MassRefusal",
    "design": "synthesis.proofs.DesignProof",
    "infeasible design": "synthesis.proofs.DesignRefusal",
    "delay": "delay.proofs.DelayProof",
    "infeasible delay": "delay.proofs.DelayRefusal",
    "infeasible delay modes": "delay.modes.ModesRefusal",
    "fixed mode": "synthesis.fixed_mode.FixedModeRefusal",
    "growing": "synthesis.growing.GrowingRefusal",
    "singular mass": "synthesis.fixed_mode.SingularMassRefusal",
    "small input": "synthesis.small_input.SmallInputRefusal",
    "unreached response": "synthesis.unreached.UnreachedResponseRefusal",
    "sampled": "sampled.proof_file.SampledProof",
    "known gain": "synthesis.known_proof.KnownGainProof",
    "observer": "synthesis.observer_problem.ObserverProof",
    "infeasible observer": "synthesis.observer_problem.ObserverRefusal",
    "infeasible any order": "synthesis.structured.any_order.AnyOrder",
    "sum of poles": "synthesis.structured.doors.SumOfPoles",
}
FORMAT = verdict.FORMAT
LONG = 30_000  # letters of a text that floats decide sooner than rationals


def written(kind, data):
    """The text of a proof of a ``kind`` and ``data``; `verdict.written`'s or None."""
    asked = {"kind": kind} | {k: v for k, v in data.items() if k != "claims"}
    try:
        whole, *said = verdict.written(asked)
        if not same(verdict.asked_of(whole), asked):
            raise Refused("its data don't say again what is asked")
    except (Beyond, Refused):  # no text says it
        asks = {k: v for k, v in asked.items() if k != "kind"}
        return spread(verdict.head(asked) | {"asks": asks}), None
    return spread(verdict.stored(whole)), (whole, *said)


def spread(whole):
    """The ``whole`` file as JSON, with what is named on a line of its own."""

    def line(value):
        return json.dumps(value, separators=(",", ":"))

    lines = []
    for key, value in whole.items():
        text = line(value)
        if isinstance(value, dict) and value:
            parts = (f"{line(k)}:{line(v)}" for k, v in value.items())
            text = "{\n" + ",\n".join(parts) + "}"
        elif isinstance(value, list):
            text = "[\n" + ",\n".join(map(line, value)) + "]"
        lines.append(f"{line(key)}:{text}")
    return "{" + ",\n".join(lines) + "}\n"


def parse(text):
    """A proof's kind and data, from its ``text``; a ValueError if it is none."""
    whole = parse_json(text)
    if not isinstance(whole, dict) or whole.get("format") != FORMAT:
        raise ValueError(f'there is no "format": "{FORMAT}"')
    version, kind = whole.get("version"), whole.get("kind")
    if type(version) is not int or version != verdict.VERSION:
        raise ValueError(f"version must be {verdict.VERSION}, got {version!r:.40}")
    if not isinstance(kind, str):
        raise ValueError("kind is missing")
    try:
        asked = verdict.asked_of(whole)
    except (*verdict.MALFORMED, Refused) as fault:
        raise ValueError(f"its data aren't what it asks for: {fault}") from None
    return kind, {key: value for key, value in asked.items() if key != "kind"}


def is_proof(content):
    """True if a file's bytes, ``content``, say that it is a proof, whole or not."""
    return re.search(rb'"format"\s*:\s*"sosbook proof"', content) is not None


def same(a, b):
    """True if two contents, a and b, are written alike: True isn't 1 here."""
    return json.dumps(a, sort_keys=True) == json.dumps(b, sort_keys=True)


def laid_out(value, indent=""):
    """A ``value`` as JSON behind an ``indent``, a matrix's rows on their own lines."""
    deeper = indent + " "
    if isinstance(value, dict) and value:
        lines = (
            f"{deeper}{json.dumps(key)}: {laid_out(inner, deeper)}"
            for key, inner in value.items()
        )
        return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
    if isinstance(value, list) and any(isinstance(x, (dict, list)) for x in value):
        lines = (deeper + laid_out(inner, deeper) for inner in value)
        return "[\n" + ",\n".join(lines) + f"\n{indent}]"
    return json.dumps(value)


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

    homes = KINDS

    text: str

    @classmethod
    def of(cls, data):
        """Write the file of some data: a dict of lists, decimals and words."""
        text, said = written(cls.kind, data)
        proof = cls(text)
        proof.__dict__["said"] = said and Written(*said)
        return proof

    def __reduce__(self):
        return type(self), (self.text,)

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
        """The verdict on the text, kept with it as long as the proof lives."""
        text, found = self.__dict__.get("judged", (None, None))
        if text is not self.text:
            found = _remembered(type(self), self.text, self.__dict__.get("said"))
            self.__dict__["judged"] = self.text, found
        return found

    @property
    def data(self):
        """The file's contents, as a dict."""
        return parse(self.text)[1]

    @property
    def blocks(self):
        """From a block's name to its smallest pivot, computed when it is asked for."""
        examined = self.examined
        if examined.blocks is None and examined.value is None:
            return self.measured(lambda x: nearest(definite(x)[1]))
        return examined.blocks or {}

    def measured(self, measure):
        """``measure`` of each block, a `Rational` matrix, by its name."""
        said, found = Written(*verdict.opened(self.text)), {}

        def decide(label, x, semi):
            if label in names or not names:
                found[names.get(label, label)] = measure(as_rational(x))
            return True

        names = said.names(self.data, type(self))
        kernel.check(said.whole, decide, swiftest(said.whole))
        return found

    def verify(self):
        """True if the text is proven; everything is computed again."""
        return _examined(type(self), self.text).proven

    @property
    def settled(self):
        return self.verify() if self.examined.by_floats else self.proven

    def save(self, path):
        """Write the file, proven or not; `load` reads it.

        What floats have proven so far is decided in rationals first.

        Parameters
        ----------
        path : str or Path
            Where the file goes. A proof that is there is replaced.

        Raises
        ------
        FileExistsError
            If a file is there that is no proof.
        """
        from ..runtime.writing import write_file

        write_file(path, self.settled_text(), over=is_proof)

    def settled_text(self):
        """The text for a file; what floats alone prove is an ArithmeticError."""
        if self.proven and not self.settled:
            raise ArithmeticError(
                "floats prove what rationals don't: this machine rounds in its own way"
            )
        return self.text

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
    """The kinds of proof files that are known, as words; `ProofFile.owner` reads them.

    >>> "design" in kinds(), ProofFile.owner("design")
    (True, <class 'sosbook.synthesis.proofs.DesignProof'>)
    """
    return ProofFile.kinds()


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
    if cls is None and verdict.by_author({"kind": kind}):  # that module isn't here
        cls = ProofFile.owner(kind.partition(verdict.ITS_NAME)[0])
    if cls is not None:
        return cls(text)
    known = ", ".join(sorted(map(repr, kinds())))
    raise ValueError(f"{path}: kind must be one of {known}, got {kind!r:.80}")


@dataclass(frozen=True, eq=False)
class Written:
    """The result of `sosbook.exact.checker.verdict.written` for a text."""

    whole: dict
    claims: list
    keys: dict

    def names(self, data, cls):
        """The names of blocks by their labels."""
        return dict(zip(self.keys, cls.named(data, self.keys.values()), strict=True))


def _by_floats(whole, text):
    """True if floats are sure of a ``whole`` file that is long."""
    if whole["kind"] != verdict.FOLDED:
        return len(text) > LONG and certain(whole)
    from .rounded import surely

    return sum(map(len, whole["text"])) > LONG and surely(whole)


def _examined(cls, text, said=None):
    """The verdict on a text that was just written, or on one from elsewhere.

    Floats with bounds of their errors may decide what was just written, where that is
    faster; what comes from elsewhere, and what is saved, is decided in rationals.
    """
    if said and _by_floats(said.whole, text):
        return Examined(tuple(said.claims), None, (), by_floats=True)
    try:
        kind, data = parse(text)
        if kind != cls.kind and not kind.startswith(f"{cls.kind}{verdict.ITS_NAME}"):
            return Examined.nothing(f"kind is {kind!r}, not {cls.kind!r}")
        try:
            said = said or Written(*verdict.opened(text))
        except Beyond as limit:
            return _rebuilt(cls, data, str(limit))
        return Examined.by_kernel(said.whole, said.claims, said.names(data, cls))
    except (Beyond, Refused) as e:
        return Examined.nothing(*map(str, e.args))
    except (*verdict.MALFORMED, ArithmeticError) as e:
        return Examined.nothing(f"not a well-formed proof: {e}")


def _rebuilt(cls, data, alone):
    """The verdict on a file without a text, which its class decides ``alone``."""
    again, examined = cls.examine(data)
    claims = tuple(verdict.of_part(examined.claims, data))
    again.pop("claims", None)  # no file has any
    for key in {*data, *again}:
        if key not in data or key not in again or not same(data[key], again[key]):
            return Examined.nothing(f"{key!r:.80} isn't what the data say")
    return replace(examined, claims=claims, alone=alone)


_remembered = lru_cache(maxsize=64)(_examined)


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
        return quick.proven_words(self.digits)


def given_gain(gain):
    """The option for a given gain: try it with all its digits."""
    return {} if gain is None else {"tries": (17,)}


def significant(K):
    """Significant digits of the longest entry of an array K of floats."""
    return quick.significant(decimals(K))
