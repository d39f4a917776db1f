"""Controllers as arguments: a law with numbers, a design, a system with names."""

import re

import numpy as np

from ..plants.gain import Gain, input_names, signals
from ..plants.outputs import Output
from .base import Law
from .full_state import FullState

OF_NOBODY = re.compile(r"[uy]\[\d+\]")  # a name that python-control made
TERM = re.compile(r"(-?)(?:(\d[\d._]*(?:e[+-]?\d+)?) )?(.+)")


def is_controller(K):
    """True if K is a `SampledSystem` or python-control's StateSpace."""
    return hasattr(K, "nstates")


def law_of(U, law):
    """The law that is given, or that of the thesis, which integrates ``U``."""
    if law is None:
        return FullState(U)
    if U is not None:
        raise ValueError("law and U are given: say in the law what is integrated")
    if not isinstance(law, Law):
        raise ValueError(
            f"law must be a FullState, PIDLaw or DynamicLaw, got {type(law).__name__}"
        )
    return law


def taken(plant, K, law=None, U=None):
    """(``law``, ``K``): the law that K brings along, or the one given, else `FullState`
    with the integrals of ``U``, and its numbers. A design and an `ObserverDesign` have
    a law of their own; a StateSpace of continuous time is a `DynamicLaw` whose sensors
    are found by the names of its inputs, and without states a gain of the plant's
    state. Anything else is handed on. Raises ValueError if names are missing or are
    none of the ``plant``'s, or K has a clock.

    >>> import control
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=["place"])
    >>> K = control.ss(-9, 2, 3, 0, inputs=["place"], outputs=["u"])
    >>> law, gains = taken(cart, K)
    >>> law.words(cart), gains["A_c"].tolist()
    ('u depends on place alone: a controller of order 1', [[-9.0]])
    """
    own = getattr(K, "its_law", None)
    if own is not None and law is None:
        law, K = own()
        law = law if U is None or not law.whole else None  # K is found by its names
    if is_controller(K):
        law, K = _of_system(plant, K, law)
    return law_of(U, law), K


def _of_system(plant, K, law):
    """The law and the gains of a system K, its signals found by their names."""
    from .dynamic import DynamicLaw

    dt = getattr(plant, "dt", None) or 0
    if K.nstates and dt and K.dt != dt:
        raise ValueError(
            f"K has dt = {K.dt!r}, and the plant's ticks are of {dt:g} s: give a "
            f"controller with dt = {dt:g}"
        )
    if K.nstates and K.dt != dt:
        raise ValueError(
            f"K is sampled, with dt = {K.dt!r}: what runs at ticks is proven by "
            "certify_sampled; a controller of continuous time has dt = 0"
        )
    given = input_names(plant.m)
    rows = order_of(K, "output", given)
    rows = np.arange(len(given)) if rows is None else rows
    named = [x for x in K.input_labels if not OF_NOBODY.fullmatch(x)]
    if len(named) < len(K.input_labels) or K.noutputs != len(given):
        raise ValueError(
            f"K has the inputs {', '.join(K.input_labels)} and {K.noutputs} outputs: "
            f"name what each input measures, of {', '.join(signals(plant))}, and "
            f"give it the outputs {', '.join(given)}"
        )
    A, B, C, D = (np.asarray(x, float) for x in (K.A, K.B, K.C, K.D))
    C, D = C[rows], D[rows]
    if dt:  # the memory's change in a tick
        A, B = (A - np.eye(len(A))) / dt, B / dt
    if law is not None:
        columns = order_of(K, "input", law.parts(plant).sensors)
    else:
        seen = np.array([row_of(x, signals(plant)) for x in named])
        if not K.nstates:
            return None, Gain(D @ seen, signals(plant))
        n = plant.n if hasattr(plant, "coordinates") else seen.shape[1]
        columns = np.argsort(seen[:, n:].any(axis=1), kind="stable")  # rates are last
        sensors = Output(state=seen[columns])
        law = DynamicLaw(K.nstates, sensors=sensors, strictly_proper=not D.any())
    gains = dict(A_c=A, B_c=B[:, columns], C_c=C)
    return law, gains | (dict(D_c=D[:, columns]) if D.any() else {})


def row_of(word, names):
    """The row on signals of these ``names`` whose words are ``word``.

    >>> row_of("a' - 0.5 b", ("a", "b", "a'"))
    array([ 0. , -0.5,  1. ])
    """
    known = {x.replace(".", "_"): k for k, x in enumerate(names)}
    row = np.zeros(len(names))
    if (whole := word.replace(".", "_")) in known:  # "2 b" may be a name
        row[known[whole]] = 1.0
        return row
    for term in re.sub(r" ([+-]) ", r"\n\1", word).split("\n"):
        sign, size, name = TERM.fullmatch(term.removeprefix("+")).groups()
        name = name.replace(".", "_")
        if name not in known:
            raise ValueError(
                f"K measures {word!r}, and {name!r} is none of {', '.join(names)}: "
                "rename K's inputs, or give the law of its sensors, too"
            )
        row[known[name]] += float(f"{sign}{size or 1}".replace("_", "."))
    return row


def order_of(K, what, names):
    """Where each of these ``names`` is among K's ``what``, "input" or "output"; None
    where nobody named them. Raises ValueError where they are others.
    """
    found = getattr(K, f"{what}_labels", None) or getattr(K, f"{what}s", ()) or ()
    if isinstance(found, int) or all(OF_NOBODY.fullmatch(x) for x in found):
        return None
    words = [x.replace(".", "_") for x in names]  # python-control has no points
    at = [words.index(x) for x in (y.replace(".", "_") for y in found) if x in words]
    if len(found) != len(words) or sorted(at) != list(range(len(words))):
        raise ValueError(
            f"K has the {what}s {', '.join(found)}; the loop is closed by the names "
            f"{', '.join(names)}: rename K's {what}s, each once. A Controller proves "
            "its own loop: controller.certify(...)"
        )
    return np.argsort(at)
