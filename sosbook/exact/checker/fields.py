"""The form of each field that a proof file asks with.

What hasn't its form is refused by the name of its place, such as plant.vertices.0.M,
before anything is made of it. A form is the name of a plain one; a list, of things of
one form; a tuple, of one thing of each; a dict of keys, of which those that end with ?
may be missing, and * is any; or a function that finds the form of what is there.
"""

from .arithmetic import Refused, need
from .outputs import SIGNALS
from .regions import FORMS
from .text import is_decimal, ratio


def is_matrix(x):
    rows = isinstance(x, list) and all(isinstance(u, list) for u in x)
    return (
        rows
        and len({*map(len, x)}) < 2
        and all(isinstance(e, str) for u in x for e in u)
    )


def is_ratio(x):
    try:
        return ratio(x) is not None
    except Refused:
        return False


PLAIN = {
    "a text": lambda x: isinstance(x, str),
    "a decimal number in a string": is_decimal,
    "a fraction in a string": is_ratio,
    "a whole number": lambda x: type(x) is int,
    "true or false": lambda x: isinstance(x, bool),
    "a matrix of numbers in strings": is_matrix,
    "a matrix of numbers in strings, with a row": lambda x: is_matrix(x) and x != [],
    "null": lambda x: x is None,
    "something": lambda x: True,
}
TEXT, NUMBER, RATIO, WHOLE, FLAG, MATRIX, ROWS, NULL, ANY = PLAIN
COMPLEX = MATRIX, MATRIX


def fits(x, form, at):
    """Refuse an x that hasn't this form, by the name of its place."""
    while callable(form):
        form = form(x)
    if isinstance(form, str):
        need(PLAIN[form](x), f"{at}: {form} is needed")
    elif isinstance(form, dict):
        need(isinstance(x, dict), f"{at}: keys with values are needed")
        known = {key.removesuffix("?"): inner for key, inner in form.items()}
        lost = [k for k in form if k[-1] != "?" and k != "*" and k not in x]
        need(not lost, f"{at}: the key {' '.join(lost)} is missing")
        for key, inner in x.items():
            need(key in known or "*" in known, f"{at}.{key:.40} isn't known")
            fits(inner, known[key] if key in known else known["*"], f"{at}.{key:.40}")
    else:
        several = isinstance(form, list)
        good = isinstance(x, list) and (several or len(x) == len(form))
        need(good, f"{at}: a list{'' if several else f' of {len(form)}'} is needed")
        for k, inner in enumerate(x):
            fits(inner, form[0] if several else form[k], f"{at}.{k}")


def maybe(form):
    """The form, or null."""
    return lambda x: NULL if x is None else form


def of(form, *keys):
    """The same form for some keys, each word of a text."""
    return dict.fromkeys(" ".join(keys).split(), form)


VERTEX = {
    "second order": of(ROWS, "M D S B F"),
    "descriptor": of(ROWS, "E A B B_w") | of(maybe(MATRIX), "C? D_u? D_w? C_a?"),
}
BESIDE = {"reduced?": (WHOLE, WHOLE), "states?": [TEXT], "dt?": NUMBER}
PARAMETER = TEXT, TEXT, TEXT, WHOLE  # its name and its ends, and its pieces if any


def plant(x):
    """The form of a plant, by its kind, with vertices or with parameters."""
    kind = x.get("kind") if isinstance(x, dict) else None
    whole = {"kind": TEXT}
    if kind == "loop":
        return whole | of(ROWS, "A A_d")
    if not isinstance(kind, str) or kind not in VERTEX:
        return whole | {"*": ANY}
    if "parameters" in x:
        return whole | BESIDE | family(kind) | {"schedule?": [TEXT]}
    shared = {k: form for k, form in VERTEX[kind].items() if k in ("C?", "D_u?")}
    return whole | BESIDE | {"vertices": [VERTEX[kind]]} | shared


def family(kind):
    """The form of what has parameters: matrices of polynomials."""
    ends = [lambda p: PARAMETER[: 4 if isinstance(p, list) and len(p) > 3 else 3]]
    return VERTEX[kind] | {"parameters": ends}


def box(x):
    """The form of the box that vertices are near to, and each one's corner."""
    first = isinstance(x, dict) and "E" in x
    own = family("descriptor" if first else "second order")
    return own | {"corners": [WHOLE]}


def requirement(x):
    """The form of a requirement, by its kind; an author's may have more."""
    kind = x.get("kind") if isinstance(x, dict) else None
    named = {"kind": TEXT, "name": TEXT}
    ends = {"outputs?": [OUTPUT], "inputs?": [WHOLE]}
    if isinstance(x, dict) and "theorem" in x:
        return named | {"claim": TEXT, "theorem": THEOREM, "*": ANY}
    if kind == "region":
        form = x.get("form")
        known = of(ROWS, "alpha beta") | {"form": TEXT}
        if not isinstance(form, str) or form not in FORMS:
            return named | known | {"*": ANY}
        return named | known | of(NUMBER, FORMS[form])
    return named | {
        "gamma": {"gamma": NUMBER, "mu": maybe(NUMBER)} | ends,
        "h2": {"h2": NUMBER} | ends,
        "input": of(NUMBER, "u_max")
        | {"acceleration": FLAG, "x0": start, "u?": [WHOLE]},
        "cost": {"bound": NUMBER, "noise": TEXT} | of(MATRIX, "R Q? C? N?"),
    }.get(kind if isinstance(kind, str) else "", {"*": ANY})


def start(x):
    """The form of one state, or of several."""
    return MATRIX if isinstance(x, list) and isinstance([*x, 0][0], list) else [NUMBER]


OUTPUT = {
    "name?": TEXT,
    **{f"{x}?": lambda x: TEXT if isinstance(x, str) else ROWS for x in SIGNALS},
}
THEOREM = {"numbers": {"*": NUMBER}, "unknowns": {"*": (TEXT, TEXT)},
           "blocks": [(TEXT, TEXT, TEXT)]}  # fmt: skip
LAW = of(MATRIX, "rows noise E A B of_sensors of_states") | of([TEXT], "states signals")
CLOCK = {"dt": lambda dt: FLAG if dt is True else maybe(NUMBER)}
PROGRAM = (
    CLOCK
    | of(MATRIX, "A B C B_w?")
    | of(ROWS, "D D_w?")
    | of([TEXT], "inputs? outputs?")
)


def half(x):
    """The form of how a cell is cut: along an axis or an edge, or not at all."""
    return (WHOLE, WHOLE) if isinstance(x, list) else maybe(WHOLE)


def cell(x):
    """The form of a sampled loop's cell of plants."""
    if isinstance(x, dict) and "halve" in x:
        return {"halve": half, "halves": (cell, cell)}
    return {"frame": WHOLE, "growth": NUMBER, "times": clocks, "P?": [MATRIX]}


def clocks(x):
    """The form of a cell of its clocks."""
    if isinstance(x, dict) and "halve" in x:
        return {"halve": TEXT, "halves": (clocks, clocks)}
    return {"share?": NUMBER, "G?": MATRIX}


def key(x):
    """The form of a block's key."""
    return [lambda e: WHOLE if isinstance(e, int) else TEXT] if x != str(x) else TEXT


FIELDS = {
    **of(MATRIX, "U C Q_F R_F L form start s v y spread blur push"),
    **of(maybe(MATRIX), "K_A E0"),
    **of(NUMBER, "tau mu delta beta bound level rate centre gap room"),
    **of(maybe(NUMBER), "epsilon alpha"),
    **of([MATRIX], "noises gains"),
    **of(WHOLE, "vertex digits"),
    **of(maybe(WHOLE), "order free"),
    **of((WHOLE, WHOLE), "place between"),
    **of([TEXT], "misprints statement"),
    **of([RATIO], "exponentials polynomial"),
    **of(TEXT, "coupling method"),
    **of((NUMBER, NUMBER), "T delay"),
    **of(COMPLEX, "columns share price"),
    **of(maybe(requirement), "requirement norm"),
    **{"plant": plant, "K": maybe(MATRIX), "box": box, "law": LAW, "analysis": FLAG},
    "requirements": [requirement],
    "unknowns": {"*": MATRIX},
    "multipliers": [(key, MATRIX)],
    "coordinates": of(MATRIX, "left T back")
    | {"scale": NUMBER, "sizes": {"*": NUMBER}},
    "corners": maybe([WHOLE]),
    "cells": [(TEXT, TEXT, [half])],
    "model": of(MATRIX, "E A Bu"),
    "units": of(NUMBER, "slow of_w of_z") | {"T": MATRIX},
    "sides": {"*": of(MATRIX, "V here rate push")},
    "shapes": [(TEXT, WHOLE, WHOLE, FLAG)],
    "expressions": [(TEXT, MATRIX, [(TEXT, FLAG, MATRIX, MATRIX)])],
    "frames": [of(MATRIX, "L R") | {"scale": NUMBER}],
    "rows": MATRIX,
    "point": (RATIO, RATIO),
    **of([(NUMBER, NUMBER)], "witness spectrum"),
}
OF_KIND = {
    "unreached response": {"requirement": requirement},
    "known gain": {"law": maybe(LAW)},
    "delay modes": {"columns": MATRIX},
    "sampled": {
        "K": lambda x: PROGRAM if isinstance(x, dict) else MATRIX,
        "cells": cell,
    },
    "observer": {"coordinates": {"T": COMPLEX, "left": MATRIX, "unit": NUMBER}},
    "small input": {"rows": COMPLEX, "multipliers": [(key, COMPLEX)]},
}


HEAD = of(ANY, "format version *") | {
    "kind": TEXT,
    "about": {"*": TEXT},
    "asks": {"*": ANY},
}
BESIDE_TEXT = of({"*": ANY}, "data sets unknowns point? multipliers?")


def in_form(file):
    """Refuse a file that hasn't what each file has."""
    more = BESIDE_TEXT if isinstance(file, dict) and "text" in file else {}
    fits(file, HEAD | more, "file")


def well_formed(asked):
    """Refuse a request of which some field hasn't its form."""
    kind = asked["kind"].removeprefix("infeasible ")
    forms = FIELDS | OF_KIND.get(kind, {})
    for name, x in asked.items():
        if name in forms:
            fits(x, forms[name], name)
