"""Outputs of notebooks compared by their values and not by their bytes.

Another processor rounds otherwise. `differences` says what a reader would notice:
`words`, `pages`, `figures`; `cells` has nbval use it. A red cell names the stored
and the new output in _build/outputs; to accept it: python3 tasks.py run book/XX.ipynb
"""

from collections import defaultdict

from . import pages, words

SKIPPED = (
    "metadata",
    "traceback",
    "output_type",
    "name",
    "execution_count",
    "application/vnd.jupyter.widget-view+json",
)


def differences(stored, now):
    """What two lists of outputs of a cell don't agree in, as sentences."""
    before, after = folded(stored), folded(now)
    faults = [
        f"{kind}: stored {len(before.get(kind, ()))} outputs, "
        f"now {len(after.get(kind, ()))}"
        for kind in sorted(before.keys() | after.keys())
        if len(before.get(kind, ())) != len(after.get(kind, ()))
    ]
    for kind in before:
        compare = COMPARE.get(kind, _plain)
        for pair in zip(before[kind], after.get(kind, ())):
            faults += (f"{kind}: {fault}" for fault in compare(*pair))
    return faults


def folded(outputs):
    """The contents of outputs by stream (one text) or media type, in order."""
    found = defaultdict(list)
    for output in outputs:
        if output["output_type"] == "stream":
            texts = found[output["name"]]
            texts[:] = ["".join(texts) + _text(output["text"])]
            continue
        for key, value in output.items():
            if key == "data":
                for kind, content in value.items():
                    if kind not in SKIPPED:
                        found[kind].append(_text(content))
            elif key not in SKIPPED:
                found[key].append(_text(value))
    return dict(found)


def _plain(stored, now):
    if isinstance(stored, str) and isinstance(now, str):
        return words.differences(stored, now)
    return pages.data(stored, now)


def _bytes(stored, now):
    return [] if stored == now else ["its bytes changed"]


COMPARE = {"text/html": pages.differences, "image/png": _bytes, "image/jpeg": _bytes}


def _text(content):
    return "".join(content) if isinstance(content, list) else content
