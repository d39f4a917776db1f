"""A plant and what is asked of it, in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from ..plants.bernstein import Box
from ..plants.files import plant_and_asked
from ..plants.second_order import Polytope, SecondOrderSystem
from ..plants.uncertain import Uncertain
from ..runtime.reading import named
from .in_files import asked_in_file
from .pole_region import PoleRegion
from .sentence import Sentences

OTHER = "words", "controller", "search", "$schema"  # not of the design's keywords
_FORM = "alpha", "beta"  # of a region
DIGITS = 9  # of the coordinates at rest


@dataclass(frozen=True, eq=False)
class Wish:
    """A plant, and what is asked of it as a plant file has it; made by `read_wish`.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        The plant, with the ranges that the sentence says.
    data : dict
        What a plant file has beside its "plant"; its U, which errors are integrated,
        belongs to the plant: no sentence says it.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(2, 1, 0, 1, 1)
    >>> wish = sos.read_wish("The loop settles every mode in 4 s", cart)
    >>> wish.data, wish.sentence
    ({'region': {'sigma': 1.0}}, 'The loop settles every mode in 4 s.')
    >>> sos.design_pid(wish.plant, **wish.asked).status
    'feasible'
    """

    plant: Any
    data: dict

    @property
    def sentence(self) -> str:
        """All that is asked, in one sentence, which `read_wish` reads again."""
        return str(self._sentences)

    @property
    def asked(self) -> dict:
        """Keywords of `design_pid`, without those of a controller and a search."""
        return asked_in_file({k: x for k, x in self.data.items() if k not in OTHER})

    @property
    def _sentences(self):
        plant, words = self.plant, {}
        if family := plant if isinstance(plant, Uncertain) else plant.family:
            box = family.box
            ends = zip(box.names, box.low, box.high)
            words["parameters"] = {k: [float(x), float(y)] for k, x, y in ends}
        if given := getattr(plant, "coordinates", None):
            words["coordinates"] = list(given)
        first = plant.vertices[0]
        if not isinstance(first, SecondOrderSystem):
            return Sentences({**self.data, "plant": words}, 0)
        return Sentences({**self.data, "plant": words}, first.n, _rest(first))

    def read(self, text: str) -> "Wish":
        """The wish of a ``text`` about this plant; see `read_wish`."""
        data = self._sentences.read(text)
        ranges = data.pop("plant").get("parameters")
        if not ranges:
            return Wish(self.plant, data)
        family = self.plant if isinstance(self.plant, Uncertain) else self.plant.family
        return Wish(family.within(Box.of(**ranges)), data)


def read_wish(
    text: str,
    plant: str | PathLike | SecondOrderSystem | Polytope | Uncertain,
    words: Mapping | None = None,
) -> Wish:
    """The wish that a sentence has for a plant.

    Parameters
    ----------
    text : str
        "The loop settles every mode in 1.2 s, at 1 kHz": clauses in any order, between
        commas. What isn't said isn't asked. The words are those that `Wish.sentence`
        prints; blanks, "sigma", "m^2", "1/s" and a decimal comma are read, too.
    plant : path, SecondOrderSystem, Polytope or Uncertain
        A plant, or a file that `load_plant` takes. In JSON and TOML its key "words"
        has the vocabulary, and what no clause can say stays where the sentence ends
        with "and cost as given".
    words : mapping, optional
        What things are called, in the place of the file's: "it", the subject; of the
        signals "z", "u", "w" and of each parameter [name, unit], with a third entry -3
        where a unit is a thousandth of the file's; "z1", ... the sensors' names.

    Returns
    -------
    Wish
        Its ``plant`` has the ranges of the sentence, its ``asked`` are the keywords of
        `design_pid`, its ``data`` is the rest of a plant file.

    Raises
    ------
    ValueError
        If something isn't understood, is said twice, or is no such number; the text
        has the place, and how the sentence may go on.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(2, 1, 0, 1)
    >>> text = "The cart settles every mode in 4 s, lets no mode overshoot 5 %"
    >>> read_wish(text, cart, {"it": "cart"}).data["region"]
    {'sigma': 1.0, 'overshoot': 0.05}
    >>> read_wish("The loop flies", cart)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ...
    ValueError: character 10: “flies” isn't understood. It may go on: settles every ...
    """
    if not isinstance(text, str):
        raise ValueError(f"text must be a sentence, got {type(text).__name__}")
    data: dict = {}
    if isinstance(plant, (str, PathLike)):
        with named(plant):
            return wish_in(plant, words).read(text)
    if words is not None:
        data["words"] = dict(words)
    return Wish(plant, data).read(text)


def sentence_of(request):
    """All that a ``request`` asks, in one sentence; what has no clause "as given"."""
    return Wish(request.plant, _as_data(request)).sentence


def wish_in(path, words=None):
    """The `Wish` of a plant file at ``path``, with its own ``words`` or these."""
    plant, data = plant_and_asked(path)
    data = dict(data or {})
    if words is not None:
        data["words"] = dict(words)
    given = data.get("words", {})
    if not isinstance(given, dict) or not all(map(_is_name, given.values())):
        raise ValueError('words must be like {"it": "load", "u": ["torque", "N m"]}')
    return Wish(plant, data)


def _is_name(x):
    """True for a name, or a list of a name, a unit and a power of ten."""
    if isinstance(x, str):
        return True
    if not isinstance(x, list) or not 0 < len(x) < 4:
        return False
    kinds = zip(x, (str, str, int))
    return all(isinstance(one, kind) for one, kind in kinds)


def _rest(plant):
    """The function from rows that are integrated to where a plant rests when each of
    these errors is one: the smallest such z and u, this measured in a unit in which B
    is as large as S. No gain has a say in it; where there is none it says None.
    """

    def rest(rows):
        """The coordinates at which every row is one, with nine digits."""
        if not rows:
            return [1.0] * plant.n
        S, B, U = plant.S, plant.B, np.array(rows, float)
        unit = -abs(S).max() / abs(B).max() if plant.m and S.any() else -1.0
        X = np.block([[S, unit * B], [U, np.zeros((len(U), plant.m))]])
        size = np.linalg.norm(X, axis=1)
        size[size == 0] = 1.0
        X, y = X / size[:, None], np.r_[np.zeros(plant.n), 1 / size[plant.n :]]
        found, *_ = np.linalg.lstsq(X, y, rcond=None)
        if not np.allclose(X @ found, y, atol=1e-9):
            return None
        z = found[: plant.n]
        z[abs(z) < 1e-9 * abs(z).max()] = 0.0
        return [float(f"{x:.{DIGITS}g}") for x in z]

    return rest


def _as_data(request):
    """Of a request what sentences say; a name for what they leave to a plant file."""
    data: dict = {}
    law = request.law
    if law.whole:
        data |= {"U": law.U.tolist()} if law.U is not None else {}
    else:
        data["law"] = _law_as_data(law)
    for r in request.requirements:
        key = r.parameter.key if r.parameter else ""
        bound = r.bound if key else None
        if key in ("sigma", "theta", "rho") and not _of_pole_region(r, key):
            data[r.name] = None
        elif key in ("sigma", "rho") and bound is not None:
            data.setdefault("region", {})[key] = bound
        elif key == "theta":
            degrees = float(f"{np.degrees(bound):.6g}")
            exact = np.radians(degrees) == bound
            which = ("theta_deg", degrees) if exact else ("theta", bound)
            data.setdefault("region", {})[which[0]] = which[1]
        elif key == "gamma" and bound and r.outputs is None and r.inputs is None:
            data["gamma"] = bound
        elif key == "u_max" and bound and r.bounds_input_from() is not None:
            data["saturation"] = {"u_max": bound, "x0": r.x0.tolist()}
        else:
            data[r.name] = None
    if request.K_A is not None:
        data["K_A"] = request.K_A.tolist()
    return data


def _of_pole_region(r, key):
    """True if a region ``r`` of the parameter ``key`` is that part of a `PoleRegion`:
    others have a centre, an apex or a tick, of which no clause speaks.
    """
    if r.step is not None:
        return False
    try:
        (part,) = PoleRegion(**{key: r.bound}).parts
    except ValueError:  # a half-plane that reaches to the right
        return False
    return all(np.array_equal(getattr(r, x), getattr(part, x)) for x in _FORM)


def _law_as_data(law):
    """The part of a file that is a law of positions; a mark of any other law."""
    seen, more = law.sensors, ("form", "limits", "rates", "noise", "lag")
    plain = hasattr(law, "integrate") and not any(getattr(law, x) for x in more)
    if not plain or seen is None or {*seen.given} != {"position"}:
        return {"sensors": None}
    data = {"position": seen.position.tolist()}
    if np.any(law.integrate):
        data["integrate"] = law.integrate is True or law.integrate.tolist()
    return data if law.filter is None else {**data, "filter": law.filter}
