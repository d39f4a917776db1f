"""Proof files about a gain, which is written with few digits."""

from .proof_file import ProofFile
from .rational import decimal, read_array


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
