"""Draws figure.png: what is printed, proven and true of the thesis's gains."""

from pathlib import Path

from matplotlib.figure import Figure

from sosbook.book import ledger

entries = [entry for entry in ledger.entries() if entry.printed is not None]
figure = Figure(figsize=(7, 2.4), layout="constrained")
axes = figure.subplots()
for name, mark in (("printed", "s"), ("proven", "o"), ("false", "|")):
    shares = [getattr(entry, name) / entry.false for entry in entries]
    label = "limit of the truth" if name == "false" else name
    axes.plot(shares, range(len(entries)), mark, ms=8, label=label)
axes.set(xscale="log", xlabel="relative to the limit of the truth")
axes.set_yticks(range(len(entries)), [entry.what for entry in entries])
axes.invert_yaxis()
axes.legend()
figure.savefig(Path(__file__).with_name("figure.png"), dpi=150)
