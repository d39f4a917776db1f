"""Plants as plain data, and back again: what proof files say of them."""

from ..exact.rational import decimals, read_array
from .checks import as_written
from .descriptor_system import DescriptorSystem
from .second_order import Polytope, SecondOrderSystem
from .uncertain import Uncertain

__all__ = ["plant_data", "read_plant"]


def plant_data(plant):
    """The matrices of a plant, vertex by vertex.

    Of a family they are polynomials in words, beside the ranges of its parameters:
    the vertices are the coefficients of Bernstein's form, and follow from them.
    """
    if isinstance(plant, Uncertain):
        plant = plant.polytope()
    if plant.family is not None:
        kind = "descriptor" if isinstance(plant, DescriptorSystem) else "second order"
        return {"kind": kind, **plant.family.data()}
    if isinstance(plant, DescriptorSystem):
        names = {"E": "E", "A": "A", "B": "Bu", "B_w": "Bw"}
        return {
            "kind": "descriptor",
            "vertices": [
                {k: decimals(getattr(d, name)) for k, name in names.items()}
                for d in plant.vertices
            ],
            "C": decimals(plant.vertices[0].C),
            "D_u": None if plant.D_u is None else decimals(plant.D_u),
        }
    return {
        "kind": "second order",
        "vertices": [
            {k: decimals(getattr(v, k)) for k in "MDSBF"} for v in plant.vertices
        ],
    }


@as_written()
def read_plant(data):
    """The plant of the ``data`` that `plant_data` writes."""
    if "parameters" in data:
        matrices = {name: rows for name, rows in data.items() if name != "kind"}
        kinds = {"descriptor": DescriptorSystem, "second order": SecondOrderSystem}
        return Uncertain.read(kinds[data["kind"]], matrices).polytope()
    vertices = data["vertices"]
    if data["kind"] == "descriptor":
        several = {
            k: [read_array(v[k], len(v["E"]), None) for v in vertices]
            for k in ("E", "A", "B", "B_w")
        }
        C, D_u = data["C"], data["D_u"]
        return DescriptorSystem(
            **several,
            C=read_array(C, None, None) if C else None,
            D_u=None if D_u is None else read_array(D_u, len(C), None),
        )
    if data["kind"] != "second order":
        raise ValueError(f"a plant of the kind {data['kind']!r} isn't known")
    plants = [
        SecondOrderSystem(*(read_array(v[k], len(v["M"]), None) for k in "MDSBF"))
        for v in vertices
    ]
    return plants[0] if len(plants) == 1 else Polytope(plants)
