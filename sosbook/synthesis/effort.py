"""The effort of a gain: which modes it moves, and with how much force."""

from dataclasses import dataclass

import numpy as np

from ..plants.descriptor_system import DescriptorSystem
from ..runtime.read_only import ReadOnly
from ..runtime.time_limit import check_time_of_eigenvalues
from .starting_points import balanced

SAME_POLE = 1e-6  # of its size; what is nearer to an open-loop pole hasn't moved
ROUNDING = 1e-11  # of the largest pole's size
FAR_TOO_STIFF = 1e6  # times the plant's own stiffness: no actuator's, or a unit's slip
MOST_FORCE = 0.9  # of the squares of K's rows: then one mode is the reason
STRONG = 100.0  # times the plant's own stiffness; the reason of less isn't sought


@dataclass(frozen=True, eq=False)
class Effort(ReadOnly):
    """The effort of a gain; see `Design.effort`.

    ``needless``: whether K = 0 keeps all that is asked, in floats and at the vertices;
    ``moved``, ``modes``: how many poles of the mean vertex move, and how many there
    are; ``stiffness``: the largest entry of B K_P over the largest one of S; None where
    the plant has no S; ``costly``: the frequency in rad/s of a mode that takes nearly
    all of a strong gain, because the inputs hardly reach it; None where no mode does;
    ``vertices``: how many plants were looked at: those between them weren't.
    """

    needless: bool
    moved: int
    modes: int
    stiffness: float | None
    costly: float | None
    vertices: int = 1

    @property
    def where(self) -> str:
        """Of which plants it is said, in words: of vertices, and not between them."""
        return " at each vertex" if self.vertices > 1 else ""

    def __str__(self):
        words = [f"{self.moved} of {self.modes} poles are moved"]
        if self.needless:
            words.append(f"K = 0 keeps all that is asked already{self.where}")
        if self.stiffness is not None:
            words.append(
                f"the force at one unit is {self.stiffness:.2g} of the stiffness's"
            )
        if self.costly is not None:
            words.append(f"the mode at {self.costly:.4g} rad/s takes nearly all of it")
        text = "; ".join(words)
        if self.stiffness is not None and self.stiffness > FAR_TOO_STIFF:
            text += ": no actuator gives that. Ask for less, or bound the input"
        return text


def effort_of(solution):
    """The `Effort` of a ``solution`` with a gain."""
    request, K = solution.request, solution.K
    A, B, _ = request.mean.state_space()
    check_time_of_eigenvalues(len(A), 3)
    before, V = np.linalg.eig(A)
    after = np.linalg.eigvals(A + B @ K)
    same = np.maximum(SAME_POLE * np.abs(after), ROUNDING * np.abs(before).max())
    apart = np.abs(after[:, None] - before).min(axis=1)
    T = balanced(request.plant.vertices[0], request.mean)
    V = V if T is None else np.linalg.solve(T, V)  # in which each mode counts alike
    V = V / np.linalg.norm(V, axis=0)
    stiffness, plant = None, request.plant
    if not isinstance(plant, DescriptorSystem):
        force = max(np.abs(v.B @ K[:, : v.n]).max(initial=0) for v in plant.vertices)
        own = max(np.abs(v.S).max() for v in plant.vertices)
        stiffness = float(force / own) if own else None
    shares = (np.abs(K @ V if T is None else K @ T @ V) ** 2).sum(axis=0)
    worst = int(shares.argmax())
    pair = np.isclose(np.abs(before.imag), abs(before[worst].imag)) & np.isclose(
        before.real, before[worst].real
    )
    alone = shares.sum() > 0 and shares[pair].sum() > MOST_FORCE * shares.sum()
    return Effort(
        request.kept_by(np.zeros_like(K), request.demands),
        int((apart > same).sum()),
        len(A),
        stiffness,
        float(abs(before[worst])) if alone and (stiffness or 0) > STRONG else None,
        len(request.distinct),
    )
