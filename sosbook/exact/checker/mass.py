"""Mass matrices: regular by a margin at all plants, or singular at one of them."""

from .arithmetic import need
from .families import decimal, every_plant
from .plants import determinant, distinct, plant, vertex_of
from .text import Text, positive


class Mass:
    """The symmetric part of M - B K_A exceeds beta^2 at each vertex."""

    def __init__(self, d):
        """Write the text: a block for each vertex that differs."""
        t = self.t = Text(d)
        need(d["plant"]["kind"] == "second order", "this plant has no mass")
        vertices, N, m, _ = plant(t, dict(d, U=[], K_A=None))
        t.put_number("beta", d, "beta")
        t.write("sign.beta: beta > 0")
        if d["K"] is None:
            t.point("K_A", "K_A", f"{m} x {N // 2}")
        else:
            t.put("K_A", d, "K", (m, N // 2))
        few, many = distinct(vertices, "MB"), len(vertices)
        t.sets["vertices"] = [[str(i + 1)] for i in few]
        for i in few:
            t.labels[f"mass {i + 1}" if many > 1 else "mass"] = f"mass.{i + 1}"
        t.write("mass.i: he(M.i - B.i K_A)/2 - beta^2 > 0", loop="i in vertices")
        where = every_plant(d["plant"], many)
        least = "the eigenvalues of its symmetric part exceed beta^2 = "
        least += decimal(positive(d["beta"]) ** 2)
        self.claims = [f"for {where}, M - B K_A is regular", least]


class SingularMass:
    """det E changes its sign between two vertices, or is zero halfway."""

    def __init__(self, d):
        self.t = Text(d)
        plant(self.t, d, ticks=True)
        i, j = (vertex_of(self.t, k) for k in d["between"])
        env = self.t.values()
        E, F = env[f"E.{i}"], env[f"E.{j}"]
        signs = determinant(E) * determinant(F) <= 0 or determinant(E + F) == 0
        need(signs, "no mass is singular there")
        self.claims = ["no gain makes every plant of the polytope stable: a plant "
                       f"between the vertices {i} and {j} has a singular "
                       "matrix E"]  # fmt: skip
