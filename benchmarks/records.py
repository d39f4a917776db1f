"""Records and how they are stored; those of times that somebody waits for."""

import json
import re
import statistics

FIELDS = {
    "family": "start, slider, page, answers, map or designs",
    "case": "what was timed",
    "n": "degrees of freedom",
    "vertices": "of the polytope",
    "competitor": "who solved it, and how",
    "clock": "which time",
    "note": "what else to know",
    "status": "right or wrong",
    "margin": "smallest eigenvalue of all blocks, each diagonal scaled to one",
    "median_s": "median time of a call in seconds, None unless right",
    "min_s": "the shortest",
    "repeats": "how many calls",
    "count": "how many designs, moves or specifications the time is for",
    "measured": "how many of them were measured, if the rest is scaled",
    "solves": "how many LMI problems were solved",
    "agreement": "share of verdicts that equal the one-by-one verdicts",
    "share_solver": "of the time, slider moves",
    "share_drawing": "of the time: SVG and tables as text",
}


def record(**values):
    """A record with every field; unknown names are refused."""
    if wrong := set(values) - set(FIELDS):
        raise ValueError(f"{sorted(wrong)} aren't fields of a record")
    return dict.fromkeys(FIELDS) | values


def summary(times):
    """Median, shortest and number of some times."""
    return dict(median_s=statistics.median(times), min_s=min(times), repeats=len(times))


def store(path, document):
    """Write a document as JSON, a line for each record: a difference shows which."""
    options = dict(ensure_ascii=False, allow_nan=False)
    lines = ",\n".join(json.dumps(r, **options) for r in document["records"])
    head = json.dumps(document | {"records": []}, indent=1, **options)
    head = re.sub(r"\{[^{}]*\}", _in_a_line, head)
    text = head.replace('"records": []', f'"records": [\n{lines}\n ]')
    path.write_text(text + "\n", "utf-8")


def _in_a_line(found):
    """A short object of JSON, in the line that it begins."""
    short = re.sub(r"\s*\n\s*", " ", found[0])
    return short if len(short) <= 300 else found[0]
