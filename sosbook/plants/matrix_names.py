"""The names of a plant's matrices in files of other programs."""

from .as_data import ALIASES, NAMES, OPTIONAL
from .state_space import BLOCK, LETTERS, is_step

HARWELL = ".hb", ".rb", ".rsa", ".rua", ".rza"
ENDS = ".csv", ".txt", ".mtx", ".npy", ".npz", ".sti", ".mas", *HARWELL
PACKED = ".gz", ".bz2", ".xz", ".zip", ".tar", ".tgz"
STRUCTURE = "M", "S"  # what a program of finite elements always has
INITIALS = {"M": "M", "S": "KS", "D": "DC", "B": "B"}  # of names of one's own
DAMPING = "E"  # in benchmarks of reduction, beside M and K


def chosen_names(place, there, names, made):
    """From each matrix to what it is called ``there``, in a file or folder at a
    ``place``, by ``names`` that are given; those that are ``made`` of
    arguments, by name, needn't be there.
    """
    for name, own in names.items():
        if name not in (*NAMES, *LETTERS):
            raise ValueError(f"names: {name!r:.40} is none of M, D, S, B, F, {LETTERS}")
        if own not in there:
            raise ValueError(f"{place}: {own} isn't there, but {listed_names(there)}")
    letters, within = _letters(place, there)
    own = {n: x for n, x in letters.items() if n in (*NAMES, *LETTERS)}
    chosen = {n: x for n, x in own.items() if x not in names.values()} | dict(names)
    state_space = (*BLOCK, *LETTERS)
    if "M" not in chosen and {"A", "ABCD"} & letters.keys() | {"A"} & chosen.keys():
        rest = {n: within + n for n in BLOCK if within + n in there}
        own = {x.removeprefix(within): x for x in there if x.startswith(within)}
        rest |= {n: x for n, x in own.items() if is_step(n)}
        return {n: x for n, x in chosen.items() if n in state_space} | rest
    chosen = {n: own for n, own in chosen.items() if n in NAMES}
    if "S" not in chosen and {"C", "D", "K"} <= letters.keys() and "D" not in names:
        raise ValueError(
            f"{place}: beside K, is C or D the damping? Pass names={{'D': 'C'}} or "
            "names={'D': 'D'}"
        )
    sure = [*chosen]  # C may be no damping: its size tells
    for name, alias in ALIASES.items():
        if name not in chosen and alias in letters:
            chosen[name] = letters[alias]
    _refuse_small_letters(place, there, chosen)
    if twice := [n for n in made if n in sure]:
        raise ValueError(f"{place}: {twice[0]} is there: leave {made[twice[0]]} out")
    if all(name in chosen for name in STRUCTURE):
        return chosen  # what else is missing the structure says, which knows its rows
    missing = [n for n in NAMES if n not in OPTIONAL and n not in (*chosen, *made)]
    cure = _cure_of(missing, there, chosen)
    if place.is_dir():
        first = next(n for n in STRUCTURE if n not in chosen)
        *some, last = (f"{first}{end}" for end in ENDS[:5])
        raise FileNotFoundError(
            f"{place}: {', '.join(some)} or {last} is missing; {cure}{_unread(place)}"
        )
    raise ValueError(f"{place}: {', '.join(missing)} is missing; {cure}")


def _letters(place, there):
    """The names of the matrices, capital letters or all of them small ones, and what
    stands before each: "sys." of a struct that alone has a plant.
    """
    known = *NAMES, *LETTERS, *ALIASES.values(), *BLOCK
    found = {}
    for within in dict.fromkeys(
        ("", *(x.rpartition(".")[0] + "." for x in there if "." in x))
    ):
        large = {n: within + n for n in known if within + n in there}
        small = {n: within + n.lower() for n in known if within + n.lower() in there}
        found[within] = large or small
    some = [x for x, letters in found.items() if {"M", "A", "ABCD"} & letters.keys()]
    if len(some) > 1 and some[0]:
        raise ValueError(
            f"{place}: which is the plant, {' or '.join(x[:-1] for x in some)}? Pass "
            f"names={{'M': '{some[0]}M', ...}} with all of its matrices"
        )
    within = some[0] if some else ""
    return found[within], within


def _unread(place):
    """The files in a folder at a ``place`` that aren't read, in words."""
    other = [x.name for x in sorted(place.iterdir()) if x.suffix.lower() not in ENDS]
    if not other:
        return ""
    packed = any(x.endswith(PACKED) for x in other)
    return f"; not read: {listed_names(other)}" + ", which are packed" * packed


def _cure_of(missing, there, chosen):
    """The cure for missing matrices, where others are there."""
    strange = [(n, what) for n, what in there.items() if what and isinstance(what, str)]
    spare = [n for n in there if n not in (*chosen.values(), *dict(strange))]
    if strange and not spare:
        name, what = strange[0]
        return f"{name} is {what}, which only MATLAB opens: save its matrices by names"
    return f"{listed_names(there)} is there{cure_by_name(missing, spare)}"


def cure_by_name(missing, spare):
    """The argument of `load_plant` that names ``missing`` matrices among ``spare``
    ones, in words, as the initials tell.
    """
    own = {}
    for name in missing:
        ends = [(x, x.rpartition(".")[2]) for x in spare]
        like = [x for x, end in ends if name == "D" and end == DAMPING]
        like = like or [x for x, end in ends if end[:1].upper() in INITIALS[name]]
        if len(like) == 1 or (spare and name in STRUCTURE):
            own[name] = like[0] if len(like) == 1 else "..."
    if not own:
        return ""
    passed = ", ".join(f"{n!r}: {x!r}" for n, x in own.items())
    return f": pass names={{{passed}}} for other names"


def listed_names(there):
    """The names that are ``there``, in words."""
    return f"{', '.join(there) or 'nothing':.200}"


def _refuse_small_letters(where, names, chosen):
    """An f isn't dropped as if no F were meant."""
    for name in OPTIONAL:
        if name not in chosen and name.lower() in names:
            raise ValueError(f"{where}: {name.lower()} isn't read: call it {name}")
