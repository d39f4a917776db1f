"""Lists of changes that survive, each with a word why it may."""

WHY = {"", "equal", "stricter", "words", "limit", "tested"}


def listed(path):
    """Why each change of a list may survive, in one of the words `WHY`."""
    lines = path.read_text("utf-8").splitlines() if path.is_file() else ()
    return {line: why for line, _, why in (x.partition("  # ") for x in lines)}


def keep(path, survivors):
    """Write a list: of each change why it may survive, or an empty word."""
    lines = sorted(x + f"  # {why}" * bool(why) for x, why in survivors.items())
    path.write_text("\n".join(lines) + "\n", "utf-8")
