"""The names of a plant's matrices in files of other programs."""

from .as_data import ALIASES, NAMES, OPTIONAL
from .state_space import BLOCK, LETTERS, STEPS

ENDS = ".csv", ".mtx", ".npy", ".npz"
FROM_ELSEWHERE = {  # what a program of finite elements hasn't
    "B": "add B, a column for each actuator with ones in the rows that it pushes, or "
    "pass push= with these rows",
    "D": "add D, or pass rayleigh=(a, b) for a M + b S",
}


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
    letters = _letters(there)
    own = {n: x for n, x in letters.items() if n in (*NAMES, *LETTERS)}
    chosen = {n: x for n, x in own.items() if x not in names.values()} | dict(names)
    if "A" not in chosen and "M" not in chosen and {*BLOCK} <= {*there}:
        return {n: n for n in (*BLOCK, *STEPS) if n in there}
    if "A" in chosen and "M" not in chosen:
        steps = {n: n for n in STEPS if n in there}
        return {n: own for n, own in chosen.items() if n in LETTERS} | steps
    chosen = {n: own for n, own in chosen.items() if n in NAMES}
    if "S" not in chosen and {"C", "D", "K"} <= letters.keys() and "D" not in names:
        raise ValueError(
            f"{place}: beside K, is C or D the damping? Pass names={{'D': 'C'}} or "
            "names={'D': 'D'}"
        )
    for name, alias in ALIASES.items():
        if name not in chosen and alias in letters:
            chosen[name] = letters[alias]
    _refuse_small_letters(place, there, chosen)
    if twice := [n for n in made if n in chosen]:
        raise ValueError(f"{place}: {twice[0]} is there: leave {made[twice[0]]} out")
    needed = [n for n in NAMES if n not in OPTIONAL and n not in made]
    if missing := [n for n in needed if n not in chosen]:
        cure = _cure_of(missing, there)
        if place.is_dir():
            *some, last = (f"{missing[0]}{end}" for end in ENDS)
            raise FileNotFoundError(
                f"{place}: {', '.join(some)} or {last} is missing; {cure}"
            )
        raise ValueError(f"{place}: {', '.join(missing)} is missing; {cure}")
    return chosen


def _letters(there):
    """The names of the matrices: capital letters, or all of them small ones."""
    known = *NAMES, *LETTERS, *ALIASES.values()
    large = {n: n for n in known if n in there}
    return large or {n: n.lower() for n in known if n.lower() in there}


def _cure_of(missing, there):
    """The cure for missing matrices, where others are there."""
    pass_on = ", ".join(f"{n!r}: '...'" for n in missing)
    strange = [(n, what) for n, what in there.items() if what and isinstance(what, str)]
    for name, what in strange:
        if what == "a struct":
            return (
                f"{name} is a struct: save('plant.mat', '-struct', '{name}') writes it"
            )
        return f"{name} is {what}, which only MATLAB opens: save its matrices by names"
    spare = there.keys() - {*_letters(there).values()}
    cure = f"{listed_names(there)} is there"
    if len(spare) >= len(missing):
        cure += f": pass names={{{pass_on}}} for other names"
    if len(missing) < len(NAMES) - len(OPTIONAL):
        cure += "".join(
            f"; {words}" for n, words in FROM_ELSEWHERE.items() if n in missing
        )
    return cure


def listed_names(there):
    """The names that are ``there``, in words."""
    return f"{', '.join(there) or 'nothing':.200}"


def _refuse_small_letters(where, names, chosen):
    """An f isn't dropped as if no F were meant."""
    for name in OPTIONAL:
        if name not in chosen and name.lower() in names:
            raise ValueError(f"{where}: {name.lower()} isn't read: call it {name}")
