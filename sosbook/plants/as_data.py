"""Plants as plain data, and back again: as proof files have them, or people write."""

from ..exact.checker.families import vertex_words
from ..exact.rational import decimal, decimals, read_array, read_number
from ..runtime.sparse import issparse
from .checks import as_written
from .descriptor import OF_ARGUMENTS
from .descriptor_system import DescriptorSystem, of_next
from .gain import states_data
from .reduction import Reduction
from .second_order import Polytope, SecondOrderSystem
from .uncertain import Uncertain

NAMES, OPTIONAL = "MDSBF", "F"
ALIASES = {"S": "K", "D": "C"}  # what programs for finite elements call them


def plant_data(plant):
    """The matrices of a plant, vertex by vertex; a family's are polynomials in words,
    beside the ranges of its parameters. A reduced plant adds how many coordinates are
    kept, of how many; sparse ones, which no proof is about, have their entries.
    """
    if isinstance(plant, Uncertain):
        plant = plant.polytope()
    part = plant.reduction
    part = {} if part is None else {"reduced": [part.kept, part.of]}
    return _whole_data(plant) | states_data(plant) | part


def vertex_place(plant, k):
    """The vertex ``k`` of a ``plant`` in words: by the values of its parameters, if it
    has some and is a corner of their ranges; nothing where there is one vertex.

    >>> family = Uncertain(lambda s: SecondOrderSystem(1, 1, 1, s), s=(0, 10))
    >>> vertex_place(family.polytope(), 1)
    'the plant with s = 10'
    """
    many, family = len(plant.vertices), plant.family
    if many == 1:
        return ""
    data = {} if family is None else plant_data(plant)
    return vertex_words(data, k + 1, many).replace("the vertex", "vertex")


def _whole_data(plant):
    """The data of a plant that isn't reduced."""
    if plant.family is not None:
        kind = "descriptor" if isinstance(plant, DescriptorSystem) else "second order"
        followed = [*plant.family.schedule]
        followed = {"schedule": followed} if followed else {}
        return {"kind": kind, **plant.family.data()} | followed
    if isinstance(plant, DescriptorSystem):
        names = {x: x for x in "EA"} | {k: OF_ARGUMENTS[k] for k in ("B", "B_w")}
        common = plant.outputs
        one = common.keys() <= {"C", "D_u"} and common
        if not one:  # they are written beside each vertex
            names |= {"C": "C"} | OF_ARGUMENTS
        loops = plant.vertices
        if plant.dt is not None:  # a file has x(k+1)
            loops = [of_next(d, plant.dt).map(lambda x: x.astype(float)) for d in loops]
        several = [{k: getattr(d, name) for k, name in names.items()} for d in loops]
        written = [
            {k: None if x is None else decimals(x) for k, x in v.items()}
            for v in several
        ]
        shared = {k: common.get(k) for k in ("C", "D_u") if one}
        shared = {k: None if x is None else decimals(x) for k, x in shared.items()}
        return {"kind": "descriptor", "vertices": written, **shared}
    return {
        "kind": "second order",
        "vertices": [
            {k: _written(getattr(v, k)) for k in "MDSBF"} for v in plant.vertices
        ],
    }


def _written(x):
    """A matrix; of a sparse one row, column and number of its entries, by columns."""
    if not issparse(x):
        return decimals(x)
    x = x.tocoo()
    places = zip(x.row.tolist(), x.col.tolist(), map(decimal, x.data.tolist()))
    return {"sparse": list(map(list, places))}


@as_written()
def read_plant(data, names=None):
    """The plant of the ``data`` that `plant_data` writes, with ``names`` of z."""
    part = Reduction(*data["reduced"]) if "reduced" in data else None
    more = {"reduction": part} | ({"coordinates": names} if names else {})
    if "states" in data:
        more["states"] = tuple(data["states"])
    if "dt" in data:
        more["dt"] = read_number(data["dt"])
    if "parameters" in data:
        own = "kind", "reduced", "states", "dt", "schedule"
        given = {k: rows for k, rows in data.items() if rows is not None}
        matrices = {k: rows for k, rows in given.items() if k not in own}
        kinds = {"descriptor": DescriptorSystem, "second order": SecondOrderSystem}
        family = Uncertain.read(kinds[data["kind"]], matrices, **more)
        family.schedule = tuple(data.get("schedule", ()))
        return family.polytope()
    vertices = data["vertices"]
    if data["kind"] == "descriptor":
        several: dict = {
            k: [read_array(v[k], len(v["E"]), None) for v in vertices]
            for k in ("E", "A", "B", "B_w")
        }
        beside = vertices if "C" in vertices[0] else [data]
        for k in ("C", "D_u", "D_w", "C_a"):
            given = [v.get(k) for v in beside]
            if given[0]:
                rows = len(beside[0]["C"])
                several[k] = [read_array(x, rows, None) for x in given]
        return DescriptorSystem(**several, **more)
    if data["kind"] != "second order":
        raise ValueError(f"a plant of the kind {data['kind']!r} isn't known")
    plants = [
        SecondOrderSystem(
            *(read_array(v[k], len(v["B"]), None) for k in "MDSBF"), **more
        )
        for v in vertices
    ]
    return plants[0] if len(plants) == 1 else Polytope(plants)


def plant_of(data, where="plant"):
    """The plant of plain ``data``, which errors call ``where``: M, D, S, B, perhaps F
    and ``"coordinates"`` (names of z); a list of such under ``"vertices"`` (a
    Polytope); or ranges under ``"parameters"``, ``{"m": [1, 2]}``, and entries that may
    be polynomials in words, ``"0.5*m + 1"`` (an Uncertain). Raises ValueError.
    """
    if isinstance(data, dict) and "parameters" in data:
        return _family(where, data)
    if not isinstance(data, dict) or "vertices" not in data:
        return _vertex(where, data)
    several = data["vertices"]
    if not isinstance(several, list) or len(data) > 1:
        raise ValueError(f"{where}: vertices must be a list, and the only key")
    if not several:
        raise ValueError(f"{where}: vertices is empty")
    plants = [_vertex(f"{where}.vertices[{k}]", v) for k, v in enumerate(several)]
    return Polytope(plants)


def _family(where, data):
    """Matrices whose entries are numbers or polynomials in words, and ranges."""
    matrices = dict(data)
    ranges = matrices.pop("parameters")
    names = _named(where, matrices)
    if not isinstance(ranges, dict) or not all(
        isinstance(x, list) and len(x) == 2 for x in ranges.values()
    ):
        raise ValueError(f'{where}: parameters must be like {{"m": [1, 2]}}')
    several = [[name, *ends] for name, ends in ranges.items()]
    try:
        return Uncertain.read(
            SecondOrderSystem, {"parameters": several, **matrices}, True, **names
        )
    except (TypeError, AttributeError):
        raise ValueError(f"{where}: a matrix must be a list of rows") from None
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _vertex(where, data):
    matrices = dict(data) if isinstance(data, dict) else {}
    names = _named(where, matrices)
    try:
        return SecondOrderSystem(**matrices, **names)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _named(where, matrices):
    """Take the names of z out of the ``matrices``; raises where a key is wrong."""
    names = {k: matrices.pop(k) for k in ("coordinates",) if k in matrices}
    lacking = [name for name in "MDSB" if name not in matrices]
    strange = [name for name in matrices if name not in NAMES]
    if lacking or strange:
        known = {ALIASES[n]: f", call it {n}" for n in lacking if n in ALIASES}
        faults = [f"{name} is missing" for name in lacking]
        faults += [f"{name!r} isn't known{known.get(name, '')}" for name in strange]
        raise ValueError(
            f"{where} has M, D, S, B, and perhaps F and coordinates (names of z), and "
            f'what is asked stands beside a key "plant" for them: {"; ".join(faults)}'
        )
    return names
