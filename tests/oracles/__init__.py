"""What tests hold the project against: programs that it no longer ships.

``check_version_1`` is the checker of files without a text. It writes no text and has
no kernel: its blocks are matrices of fractions, formed in Python.
"""

from sosbook.exact.checker import verdict
from sosbook.exact.proof_file import laid_out

__all__ = ["mended", "version_1", "without_text"]


def version_1(kind, data):
    """The text of a proof of some kind as data alone, as it was written before."""
    whole = {"format": verdict.FORMAT, "version": 1, "kind": kind, **data}
    return laid_out(whole | {"checksum": verdict.checksum(whole)}) + "\n"


def without_text(proof):
    """The text of a proof as a file of version 1: what is asked, as data alone."""
    data, more = proof.data, {}
    try:
        text, claims = verdict.law({"kind": proof.kind, **data})
        if "unknowns" in data and text.labels:
            more = {"blocks": list(text.labels)}
    except verdict.Beyond:
        claims = proof.claims
    return version_1(proof.kind, {"claims": verdict.earlier(claims), **data, **more})


def mended(whole):
    """A file that was changed, with the checksum or the digests of its contents."""
    if whole.get("version") != 2:
        return dict(whole, checksum=verdict.checksum(whole))
    try:
        return dict(whole, about=verdict.about(verdict.asked_of(whole)))
    except (verdict.Refused, *verdict.MALFORMED):
        return whole
