"""A results document as readable tables."""

__all__ = ["table"]


def table(document):
    """Text: the machine, then a table for each case."""
    machine = document["machine"]
    lines = [
        f"{machine['cpu']}, {machine['cores']} cores, one thread used; "
        f"Python {machine['python']}, {machine['date']}"
    ]
    case = None
    for r in document["records"]:
        if r["case"] != case:
            case = r["case"]
            lines += [
                "",
                f"{case} (N = {r['states']}, {r['unknowns']} "
                f"unknowns, {r['vertices']} vertices)",
            ]
        lines.append(_line(r))
    if document["growth"]:
        lines += ["", "time grows like n to the power"]
    for g in document["growth"]:
        lines.append(
            f"  {g['competitor']:34} {g['clock']:12} "
            f"{g['exponent']:5.2f}  n = {g['from_n']} to "
            f"{g['to_n']}"
        )
    return "\n".join(lines)


def _line(r):
    name = f"  {r['competitor']:34} {r['coordinates'] or '':6}"
    if r["median_s"] is None:
        return f"{name} {r['status']}: {r['note']}"
    words = [name, f"{r['clock']:12}", f"{_seconds(r['median_s']):>9}"]
    words.append("" if r["ratio"] is None else f"x {r['ratio']:<7.3g}")
    if r["peak_mb"]:
        words.append(f"{r['peak_mb']:6.0f} MB")
    if r["margin"] is not None:
        words.append(f"margin {r['margin']:.1e}")
    if r["excess"] is not None:
        words.append(f"excess {r['excess']:.1e}")
    if r["share_solver"] is not None:
        words.append(
            f"solver {r['share_solver']:.0%}, simulation "
            f"{r['share_simulation']:.0%}, drawing {r['share_drawing']:.0%}"
        )
    if r["solves"] is not None:
        words.append(f"{r['solves']} solves, agrees {r['agreement']:.1%}")
    return " ".join(words).rstrip()


def _seconds(s):
    return f"{1e3 * s:.1f} ms" if s < 1 else f"{s:.2f} s"
