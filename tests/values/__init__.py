"""Outputs of notebooks compared by their values and not by their bytes.

Another processor rounds otherwise: a contour gets a point more, a zero turns
into -0, a last digit changes. None of it changes what a reader learns, and all
of it changes bytes. `differences` says what a reader would notice; how texts
are compared stands in `words`, pages and their data in `pages`, drawings in
`figures`. `cells` has nbval use it.

When a cell is red, the test's message lists what differs and names two files
in _build/outputs, the stored output and the new one, to open side by side. To
accept a new output, run the notebook again: python3 tasks.py run book/XX.ipynb
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
    """What two lists of outputs of a cell don't agree in.

    Parameters
    ----------
    stored, now : sequence of dict
        Outputs as in a notebook file.

    Returns
    -------
    list of str
        Empty if they agree.

    Examples
    --------
    >>> def printed(text):
    ...     return [{"output_type": "stream", "name": "stdout", "text": text}]
    >>> differences(printed("phase -0 degrees"), printed("phase 0 degrees"))
    []
    >>> differences(printed("gamma 0.75"), printed("gamma 0.77"))
    ['stdout: line 1, number 1: stored 0.75, now 0.77 (tolerance 0.01)']
    """
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
    """The contents of outputs by stream or media type, each in its order.

    What a cell prints into one stream is one text, however it came.
    """
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
