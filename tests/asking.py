"""Proof files that ask for something else: what a test changes is written again."""

import json

from sosbook.exact.checker import verdict


def asked_by(proof):
    """What a proof asks, with its kind, as numbers and words in one dict."""
    return {"kind": proof.kind, **json.loads(json.dumps(proof.data))}


def asking(asked):
    """The contents of the file that asks this, with the text that is written for it."""
    try:
        whole, *_ = verdict.written(asked)
        return json.loads(json.dumps(verdict.stored(whole)))
    except (verdict.Refused, verdict.Beyond, *verdict.MALFORMED) as fault:
        return in_place(asked, not isinstance(fault, verdict.Beyond))


def in_place(asked, text=True):
    """A file with its data in what it asks: with an empty text, or without one."""
    asks = {k: v for k, v in asked.items() if k != "kind"}
    head = {"format": verdict.FORMAT, "version": verdict.VERSION, "about": {}}
    none = {"text": [], "data": {}, "sets": {}, "unknowns": {}} if text else {}
    return mended(head | {"kind": asked["kind"], "asks": asks} | none)


def mended(whole):
    """A file that was changed, with the digests of its contents."""
    try:
        return dict(whole, about=verdict.about(verdict.asked_of(whole)))
    except (verdict.Refused, *verdict.MALFORMED):
        return whole
