"""Plants as plain data, and back again: what proof files say of them."""

from scipy.sparse import csc_array, issparse

from ..exact.rational import decimal, decimals, read_array, read_number
from .checks import as_written
from .descriptor import OF_ARGUMENTS
from .descriptor_system import DescriptorSystem
from .reduction import Reduction
from .second_order import Polytope, SecondOrderSystem
from .uncertain import Uncertain

__all__ = ["plant_data", "read_plant"]


def plant_data(plant):
    """The matrices of a plant, vertex by vertex.

    Of a family they are polynomials in words, beside the ranges of its parameters:
    the vertices are the coefficients of Bernstein's form, and follow from them.
    Of a reduced plant they have how many coordinates are kept, of how many. Sparse
    ones have their entries.
    """
    if isinstance(plant, Uncertain):
        plant = plant.polytope()
    part = plant.reduction
    if part is not None:
        return {**_whole_data(plant), "reduced": [part.kept, part.of]}
    return _whole_data(plant)


def _whole_data(plant):
    if plant.family is not None:
        kind = "descriptor" if isinstance(plant, DescriptorSystem) else "second order"
        return {"kind": kind, **plant.family.data()}
    if isinstance(plant, DescriptorSystem):
        names = {x: x for x in "EA"} | {k: OF_ARGUMENTS[k] for k in ("B", "B_w")}
        common = plant.outputs
        one = common.keys() <= {"C", "D_u"} and common
        if not one:  # they are written beside each vertex
            names |= {"C": "C"} | OF_ARGUMENTS
        several = [
            {k: getattr(d, name) for k, name in names.items()} for d in plant.vertices
        ]
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


def _read(x, n):
    """The matrix of n rows that `_written` writes."""
    if not isinstance(x, dict):
        return read_array(x, n, None)
    rows, columns, values = zip(*x["sparse"])
    return csc_array(([*map(read_number, values)], (rows, columns)), shape=(n, n))


@as_written()
def read_plant(data):
    """The plant of the ``data`` that `plant_data` writes."""
    part = Reduction(*data["reduced"]) if "reduced" in data else None
    if "parameters" in data:
        matrices = {k: rows for k, rows in data.items() if k not in ("kind", "reduced")}
        kinds = {"descriptor": DescriptorSystem, "second order": SecondOrderSystem}
        plant = Uncertain.read(kinds[data["kind"]], matrices).polytope()
        for v in plant.vertices:
            object.__setattr__(v, "reduction", part)
        return plant
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
        return DescriptorSystem(**several, reduction=part)
    if data["kind"] != "second order":
        raise ValueError(f"a plant of the kind {data['kind']!r} isn't known")
    plants = [
        SecondOrderSystem(*(_read(v[k], len(v["B"])) for k in "MDSBF"), reduction=part)
        for v in vertices
    ]
    return plants[0] if len(plants) == 1 else Polytope(plants)
