"""The reproduction as files for other programs, which the book's page offers.

``python -m sosbook.book.reproduction.files`` writes them into ``book/``.
"""

import csv
import json
from dataclasses import asdict
from io import StringIO
from pathlib import Path

from ...runtime.writing import write_file
from . import assumptions, checked, errata, readings, rows


def files():
    """The text of each file by its name: ``reproduction.csv`` has the rows,
    ``reproduction.json`` errata, assumptions and readings too, ``readings.csv`` is a
    form for readers.
    """
    lines = [asdict(row) for row in rows()]
    form = [entry | {"decides": " ".join(entry["decides"])} for entry in readings()]
    everything = {
        "rows": lines,
        "errata": [asdict(entry) for entry in errata()],
        "right": [asdict(entry) for entry in checked()],
        "assumptions": assumptions(),
        "readings": readings(),
    }
    return {
        "reproduction.csv": _csv(lines),
        "reproduction.json": json.dumps(everything, indent=1, ensure_ascii=False)
        + "\n",
        "readings.csv": _csv([entry | {"you read": ""} for entry in form]),
    }


def _csv(lines):
    text = StringIO()
    table = csv.DictWriter(text, list(lines[0]), lineterminator="\n")
    table.writeheader()
    table.writerows(lines)
    return text.getvalue()


if __name__ == "__main__":
    for name, text in files().items():
        write_file(Path("book", name), text)
